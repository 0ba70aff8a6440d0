// The door to balls that share their steps with each other, or with ring, cage and shaft; arrays are C-contiguous doubles.
#include "coupled_balls.hpp"
#include "numbers.hpp"

using namespace core;

namespace {

// Reads numbers in the order in which kinds/bearing/compiled_coupled.py writes them.
CoupledBodies bodies_of(const double *numbers, const double *shaft) {
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

template <bool PATCH>
Status advance(const Chunk &chunk, const CoupledBodies &bodies, const Results &results, const BodyResults &body_results,
               const std::int64_t *numbers, int count, const std::uint8_t *near) {
  return coupled_balls::Integration<PATCH>(chunk, bodies, results, body_results).run(numbers, count, near);
}

}  // namespace

extern "C" [[gnu::visibility("default")]] int core_coupled_balls(
    const double *bearing_numbers, const double *points, const double *method_numbers, const double *body_numbers,
    const double *acting, const double *scales, double duration, std::int64_t instants, const double *times,
    const volatile std::uint8_t *stop, std::int64_t count, const std::int64_t *numbers,
    const std::uint8_t *near, std::int64_t balls, double *state,
    double *orientation, double *steps, double *body_state, double *states, double *orientations, double *body_states,
    std::int64_t *counts, double *failure) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  RosenbrockMethod method = method_of(method_numbers);
  CoupledBodies bodies = bodies_of(body_numbers, acting);
  Chunk chunk{bearing, method, {bodies.shaft_speed, bodies.shaft_acceleration}, duration, {}, int(instants), times, stop};
  std::copy(scales, scales + MOTION, chunk.scale);
  Results results{int(balls), state, orientation, steps, states, orientations, counts, failure};
  BodyResults body_results{body_state, body_states};
  if (bearing.over_patch()) return advance<true>(chunk, bodies, results, body_results, numbers, int(count), near);
  return advance<false>(chunk, bodies, results, body_results, numbers, int(count), near);
}
