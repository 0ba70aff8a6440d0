// Reads the numbers that the doors of the bearing are handed.
#pragma once
#include "../methods/rosenbrock.hpp"
#include "coupled_bodies.hpp"
#include "model.hpp"

namespace core {

// Reads numbers in the order in which kinds/bearing/compiled_balls.py writes them.
class Reader {
 public:
  explicit Reader(const double *numbers) : next(numbers) {}
  void operator()(double &number) { number = *next++; }
  template <std::size_t N> void operator()(double (&numbers)[N]) { for (double &one : numbers) one = *next++; }
  void operator()(GroovePolynomial &p) { (*this)(p.term), (*this)(p.least); }
  void operator()(Raceway &r) {
    (*this)(r.locus_radius), (*this)(r.groove_radius), (*this)(r.given);
    (*this)(r.coefficient), (*this)(r.semi_major), (*this)(r.semi_minor);
  }
  int integer() { return int(*next++); }

 private:
  const double *next;
};

inline Bearing bearing_of(const double *numbers, const double *points) {
  Bearing b{};
  Reader read(numbers);
  read(b.ball_radius), read(b.ball_mass), read(b.ball_inertia), read(b.offset), read(b.gravity);
  read(b.damping), read(b.relaxation_time), read(b.friction_coefficient), read(b.regularisation), read(b.power);
  read(b.pair_coefficient), read(b.pair_friction);
  read(b.inner), read(b.outer);
  b.patch.model = FrictionModel(read.integer());
  read(b.patch.coefficient), read(b.patch.easy), read(b.patch.hard);
  b.patch.points = read.integer();
  b.patch.point = points;
  return b;
}

inline RosenbrockMethod method_of(const double *numbers) {
  RosenbrockMethod m{};
  Reader read(numbers);
  m.stages = read.integer(), m.order = read.integer(), m.ends_steps_at_contacts = read.integer() != 0;
  read(m.gamma);
  for (auto &row : m.a) read(row);
  for (auto &row : m.c) read(row);
  read(m.alpha), read(m.d);
  for (auto &row : m.dense) read(row);
  return m;
}

// Reads numbers in the order in which kinds/bearing/compiled_coupled.py writes them.
inline CoupledBodies bodies_of(const double *numbers, const double *shaft) {
  CoupledBodies b{};
  Reader read(numbers);
  b.ring = RingMotion(read.integer()), b.cage = CageKind(read.integer()), b.guided = read.integer() != 0;
  for (bool &one : b.free) one = read.integer() != 0;
  for (auto *of_each : {&b.inertia, &b.stiffness, &b.damping, &b.rest, &b.weight, &b.place_scale, &b.speed_scale}) read(*of_each);
  read(b.polar_inertia), read(b.unbalance), read(b.phase), read(b.light);
  auto read_wall = [&](Wall &wall) { read(wall.stiffness), read(wall.relaxation_time), read(wall.friction); };
  read(b.pockets.radius), read(b.pockets.half_clearance), read_wall(b.pockets.wall);
  read(b.land.side), read(b.land.radius), read(b.land.clearance), read_wall(b.land.wall), read(b.land.smoothing);
  Reader read_motion(shaft);
  read_motion(b.load), read_motion(b.load_rate);
  read_motion(b.shaft_angle), read_motion(b.shaft_speed), read_motion(b.shaft_acceleration);
  return b;
}

}  // namespace core
