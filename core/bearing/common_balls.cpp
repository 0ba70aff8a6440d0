// The doors to balls that step together; arrays are C-contiguous.
#include "../door.hpp"
#include "common_balls.hpp"
#include "numbers.hpp"

using namespace core;

namespace {

RungeKuttaMethod runge_kutta_of(const double *numbers) {
  RungeKuttaMethod m{};
  Reader read(numbers);
  m.stages = read.integer(), m.order = read.integer();
  for (auto &row : m.a) read(row);
  read(m.node), read(m.weight), read(m.error);
  return m;
}

}  // namespace

// An explicit method, or for a method of no stages the implicit-explicit one. Without an error estimate steps between two
// instants are equal, none longer than `longest` [s]; with one they adapt from there, and `next` [s] is the step to go on with.
CORE_EXPORT int core_common_balls(const double *bearing_numbers, const double *points, const double *method_numbers, const double *drive,
                                  const double *scales, double longest, double duration, std::int64_t instants, const double *times,
                                  const volatile std::uint8_t *stop, std::int64_t number, const std::uint8_t *near, double *state,
                                  double *orientation, double *carried, double *states, double *orientations, std::int64_t *counts, double *failure,
                                  double *next) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  bool implicit = method_numbers[0] == 0.0;
  AllBalls all{bearing, {drive[0], drive[1], drive[2]}, int(number), near, implicit ? 0.0 : 1.0};
  all.load(carried);
  CommonResults results{state, orientation, states, orientations};
  auto stepped = [&](auto &balls, const Pace &pace) {
    Status status = step_together(balls, pace, duration, int(instants), times, stop, counts, failure, *next);
    all.store(carried);
    return status;
  };
  if (implicit) {
    ImexBalls balls(all, results, counts);
    return stepped(balls, {longest, 0, true});
  }
  RungeKuttaMethod method = runge_kutta_of(method_numbers);
  ExplicitBalls balls(all, results, method, scales, counts);
  return stepped(balls, {longest, method.adapts() ? method.order : 0, false});
}

// Rates (balls, COLUMNS) of all balls in a state (balls, COLUMNS) with the ring at this speed [rad/s] and angle [rad].
CORE_EXPORT void core_all_rates(const double *bearing_numbers, const double *points, double ring_speed, double ring_angle, std::int64_t number,
                                const std::uint8_t *near, const double *state, double *rates) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  Blocks y = blocks_of(state, int(number)), found(y.size());
  AllBalls{bearing, {ring_speed, 0.0, ring_angle}, int(number), near, 1.0}.rates(0.0, y, found);
  for (int k = 0; k < number; k++)
    for (int c = 0; c < COLUMNS; c++) rates[k * COLUMNS + c] = found[k / LANES][c][k % LANES];
}

// See `add_stored`; states (instants, balls, COLUMNS).
CORE_EXPORT void core_add_stored(const double *bearing_numbers, const double *points, std::int64_t number, const std::uint8_t *near,
                                 double share, std::int64_t instants, double *states) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  for (int i = 0; i < instants; i++) add_stored(bearing, int(number), near, share, states + i * number * COLUMNS);
}
