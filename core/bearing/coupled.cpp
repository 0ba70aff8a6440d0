// Exported functions of balls that share their steps with each other, or with ring, cage and shaft; arrays are C-contiguous doubles.
#include "coupled_balls.hpp"
#include "numbers.hpp"

using namespace core;

CORE_EXPORT int core_coupled_balls(
    const double *bearing_numbers, const double *points, const double *method_numbers, const double *body_numbers,
    const double *load, const double *load_rate, const double *drive, const double *scales, double duration, std::int64_t instants, const double *times,
    const volatile std::uint8_t *stop, std::int64_t count, const std::int64_t *numbers,
    const std::uint8_t *near, std::int64_t balls, double *state,
    double *orientation, double *steps, double *carried, double *border, double *states, double *orientations, double *borders,
    std::int64_t *counts, double *failure) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  RosenbrockMethod method = method_of(method_numbers);
  CoupledBodies bodies = bodies_of(body_numbers, load, load_rate, drive);
  Chunk chunk{bearing, method, {bodies.shaft_speed, bodies.shaft_acceleration, bodies.shaft_angle}, duration, {}, int(instants), times, stop};
  std::copy(scales, scales + SCALES, chunk.scale);
  Results results{int(balls), state, orientation, steps, carried, states, orientations, counts, failure};
  BodyState body_state = state_of(bearing, bodies, border);
  std::vector<double> body_states(instants * BODY_NUMBERS);
  BodyResults body_results{body_state.data(), body_states.data()};
  Status status = coupled_balls::Integration(chunk, bodies, results, body_results).run(numbers, int(count), near);
  if (status != OK) return status;
  auto write = [&](const double *from, double *to) {
    for_each_number(bodies, true, [&](int number, int place) { to[place] = from[number]; });
  };
  write(body_state.data(), border);
  for (int i = 0; i < instants; i++) write(body_states.data() + i * BODY_NUMBERS, borders + i * BORDER);
  return status;
}

// For tests, of all balls, their tangential velocities in `state`, and the bodies: see `linear_answers`.
CORE_EXPORT void core_linear_answers(
    const double *bearing_numbers, const double *points, const double *method_numbers, const double *body_numbers,
    const double *load, const double *load_rate, const double *drive, std::int64_t balls, const std::uint8_t *near,
    double *state, const double *border, double gain, std::int64_t sides, const double *right, double *rates, double *answers) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  RosenbrockMethod method = method_of(method_numbers);
  CoupledBodies bodies = bodies_of(body_numbers, load, load_rate, drive);
  std::uint8_t stop = 0;
  Chunk chunk{bearing, method, {}, 1.0, {}, 0, nullptr, &stop};
  std::vector<double> orientations(4 * balls), steps(balls, 1.0), carried(CARRIED * balls, 0.0);
  std::vector<std::int64_t> numbers(balls);
  for (int ball = 0; ball < balls; ball++) numbers[ball] = ball;
  Results results{int(balls), state, orientations.data(), steps.data(), carried.data(), nullptr, nullptr, nullptr, nullptr};
  BodyState body_state = state_of(bearing, bodies, border);
  BodyResults body_results{body_state.data(), nullptr};
  coupled_balls::Integration(chunk, bodies, results, body_results)
      .linear_answers(numbers.data(), int(balls), near, gain, int(sides), right, rates, answers);
}
