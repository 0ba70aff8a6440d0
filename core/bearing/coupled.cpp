// The door to balls that share their steps with each other, or with ring, cage and shaft; arrays are C-contiguous doubles.
#include "../door.hpp"
#include "coupled_balls.hpp"
#include "numbers.hpp"

using namespace core;

namespace {

template <bool PATCH>
Status advance(const Chunk &chunk, const CoupledBodies &bodies, const Results &results, const BodyResults &body_results,
               const std::int64_t *numbers, int count, const std::uint8_t *near) {
  return coupled_balls::Integration<PATCH>(chunk, bodies, results, body_results).run(numbers, count, near);
}

}  // namespace

CORE_EXPORT int core_coupled_balls(
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
