// Reads the arrays of numbers that describe a bearing, its bodies and methods.
#pragma once
#include "../methods/rosenbrock.hpp"
#include "../methods/runge_kutta.hpp"
#include "elements.hpp"

namespace core {

// Reads numbers in the order in which kinds/bearing/system.py writes them.
class Reader {
 public:
  explicit Reader(const double *numbers) : next(numbers) {}
  template <class... X>
  void operator()(X &...x) {
    (take(x), ...);
  }
  int integer() { return int(*next++); }
  // The start of the next `count` numbers, which are skipped.
  const double *take(int count) { return std::exchange(next, next + count); }

 private:
  const double *next;
  void take(double &number) { number = *next++; }
  template <class X, std::size_t N>
  void take(X (&numbers)[N]) {
    for (X &x : numbers) take(x);
  }
  void take(GroovePolynomial &p) { take(p.term), take(p.least); }
  void take(Raceway &r) {
    (*this)(r.locus_radius, r.groove_radius, r.nominal_coefficient, r.modulus, r.coefficient, r.semi_major, r.semi_minor);
  }
  void take(Wall &w) { (*this)(w.stiffness, w.relaxation_time, w.friction); }
};

inline Bearing bearing_of(const double *numbers, const double *points) {
  Bearing b{};
  Reader read(numbers);
  read(b.ball_radius, b.ball_mass, b.ball_inertia, b.offset, b.tilt, b.gravity);
  read(b.damping, b.relaxation_time, b.friction_coefficient, b.regularisation, b.power);
  read(b.pair_coefficient, b.pair_friction);
  read(b.inner, b.outer);
  b.patch = patch_friction_of(read.take(FRICTION_NUMBERS), points);
  b.carried = CarriedLaw(read.integer());
  b.lubricant = lubricant_of(read.take(LUBRICANT_NUMBERS));
  if (b.lubricant.works())
    for (Raceway *raceway : {&b.inner, &b.outer}) read(raceway->film);
  b.defects = defects_of(read.take(0));
  return b;
}

inline RosenbrockMethod rosenbrock_of(const double *numbers) {
  RosenbrockMethod m{};
  Reader read(numbers);
  m.stages = read.integer(), m.order = read.integer(), m.ends_steps_at_contacts = read.integer() != 0;
  read(m.gamma, m.a, m.c, m.alpha, m.d, m.dense);
  return m;
}

inline RungeKuttaMethod runge_kutta_of(const double *numbers) {
  RungeKuttaMethod m{};
  Reader read(numbers);
  m.stages = read.integer(), m.order = read.integer();
  read(m.a, m.node, m.weight, m.error);
  return m;
}

// The state of ring, cage and shaft between Python and the core: positions x, y, z, tilt about x and y (or the centre x, y of a guided
// cage), angle of the cage; their velocities; the integrals; angle and speed of a torque-driven shaft, and its work;
// position and velocity of the housing.
constexpr int BORDER_POSITIONS = 6, BORDER_CAGE = 5, BORDER_SHAFT = 15, BORDER_TORQUE_WORK = 17, BORDER_HOUSING = 18, BORDER = 20;

inline int border_index(const CoupledBodies &b, int coordinate) {
  if (coordinate == SHAFT) return BORDER_SHAFT;
  if (coordinate == HOUSING) return BORDER_HOUSING;
  if (coordinate == CAGE_ANGLE) return BORDER_CAGE;
  if (coordinate == TILT_X || coordinate == TILT_Y) return b.guided ? -1 : coordinate;
  if (coordinate == CAGE_X || coordinate == CAGE_Y) return b.guided ? TILT_X + coordinate - CAGE_X : -1;
  return coordinate;
}

// Calls function(index in a body's state, index in the border) for all numbers of both; `moving`: those of free coordinates.
template <class Function>
void for_each_number(const CoupledBodies &b, bool moving, Function function) {
  for (int c = 0; c < COORDINATES; c++) {
    int position = border_index(b, c);
    if (position < 0 || ((moving || c == SHAFT) && !b.free[c])) continue;
    function(c, position), function(COORDINATES + c, position >= BORDER_SHAFT ? position + 1 : BORDER_POSITIONS + position);
  }
  for (int i = LOAD_WORK; i <= LAND_WORK; i++) function(2 * COORDINATES + i, 2 * BORDER_POSITIONS + i);
  if (b.free[SHAFT]) function(2 * COORDINATES + TORQUE_WORK, BORDER_TORQUE_WORK);
}

inline BodyState state_of(const Bearing &bearing, const CoupledBodies &bodies, const double *border) {
  BodyState state{};
  for_each_number(bodies, false, [&](int number, int border_number) { state[number] = border[border_number]; });
  if (bodies.ring == RingMotion::tilted) {
    std::copy(bearing.offset, bearing.offset + 3, state.begin());
    state[TILT_X] = bodies.rest_position[TILT_X], state[TILT_Y] = bodies.rest_position[TILT_Y];
  }
  return state;
}

inline Drive drive_of(const double *numbers) { return {numbers[0], numbers[1], numbers[2]}; }

// Reads numbers in the order in which kinds/bearing/system.py writes them.
inline CoupledBodies bodies_of(const double *numbers, const double *load, const double *load_rate) {
  CoupledBodies b{};
  Reader read(numbers);
  b.ring = RingMotion(read.integer()), b.cage = CageKind(read.integer()), b.guided = read.integer() != 0;
  for (bool &free : b.free) free = read.integer() != 0;
  read(b.inertia, b.stiffness, b.damping, b.rest_position, b.weight, b.position_scale, b.velocity_scale);
  read(b.polar_inertia, b.unbalance, b.phase, b.light);
  read(b.pockets.radius, b.pockets.half_clearance, b.pockets.wall);
  read(b.land.side, b.land.radius, b.land.clearance, b.land.wall, b.land.smoothing, b.direction);
  for (int c = 0; c < COORDINATES; c++) {
    int index = c == SHAFT ? BORDER_CAGE : border_index(b, c);  // loads have the torque on the shaft as that on the cage
    if (c == CAGE_ANGLE || c == HOUSING || index < 0) continue;
    b.load[c] = load[index], b.load_rate[c] = load_rate[index];
  }
  return b;
}

}  // namespace core
