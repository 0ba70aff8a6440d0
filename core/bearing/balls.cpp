// Exported functions of balls between rings whose motion is prescribed, alone or stepped together; arrays are C-contiguous doubles.
#include "common_balls.hpp"
#include "free_balls.hpp"
#include "numbers.hpp"
#include "start.hpp"

using namespace core;

CORE_EXPORT int core_free_balls(
    const double *bearing_numbers, const double *points, const double *method_numbers, const double *drive,
    const double *scales, double duration, std::int64_t instants, const double *times, const volatile std::uint8_t *stop,
    std::int64_t count, const std::int64_t *numbers, std::int64_t balls, double *state, double *orientation, double *steps, double *carried, double *states,
    double *orientations, std::int64_t *counts, double *failure) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  RosenbrockMethod method = method_of(method_numbers);
  Chunk chunk{bearing, method, {drive[0], drive[1], drive[2]}, duration, {}, int(instants), times, stop};
  std::copy(scales, scales + SCALES, chunk.scale);
  Results results{int(balls), state, orientation, steps, carried, states, orientations, counts, failure};
  return for_kind_of(bearing, [&]<bool PATCH, bool TILTED>() {
    return free_balls::Integration<PATCH, TILTED>(chunk, results).run(numbers, int(count));
  });
}

// Rates (12,) and Jacobian (9, 9) of one ball's motion, for tests: values and derivatives of the same functions. `carried`
// (CARRIED,) counts where the law carries states.
CORE_EXPORT void core_ball_rates(const double *bearing_numbers, const double *points, double ring_speed,
                                                    const double *state, const double *carried, double *rates, double *jacobian) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  BallState y, f;
  BallJacobian j;
  for (int c = 0; c < COLUMNS; c++) y[c] = broadcast<Pack>(state[c]);
  Pack speed = broadcast<Pack>(ring_speed);
  CarriedBalls states;
  for (int lane = 0; lane < LANES; lane++) load_carried(carried, lane, states);
  const CarriedBalls *given = bearing.carried == CarriedLaw::none ? nullptr : &states;
  for_kind_of(bearing, [&]<bool PATCH, bool TILTED>() { evaluate_rates_and_jacobian<PATCH, TILTED>(bearing, speed, given, Heights{}, y, f, j); });
  for (int c = 0; c < COLUMNS; c++) rates[c] = f[c][0];
  std::fill(jacobian, jacobian + MOTION * MOTION, 0.0);
  jacobian[0 * MOTION + VELOCITY] = jacobian[2 * MOTION + VELOCITY + 2] = 1.0;
  jacobian[1 * MOTION + RADIUS] = j.orbit_by_radius[0], jacobian[1 * MOTION + VELOCITY + 1] = j.orbit_by_velocity[0];
  for (int row = 0; row < 6; row++)
    for (int column = 0; column < MOTION; column++) jacobian[(VELOCITY + row) * MOTION + column] = j.row[row][column][0];
}
// States (balls, COLUMNS) of evenly spaced balls at rest between the raceways, rolling there if they are to; 0 where one
// has no rest.
CORE_EXPORT std::int64_t core_place_balls(const double *bearing_numbers, const double *points, double ring_speed,
                                          std::int64_t rolls, std::int64_t balls, double *state) {
  return start::place_balls(bearing_of(bearing_numbers, points), ring_speed, rolls != 0, int(balls), state);
}

namespace {

RungeKuttaMethod runge_kutta_of(const double *numbers) {
  RungeKuttaMethod m{};
  Reader read(numbers);
  m.stages = read.integer(), m.order = read.integer();
  read(m.a, m.node, m.weight, m.error);
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

// Which balls may meet.
CORE_EXPORT void core_mark_near(double ball_radius, const double *state, std::int64_t balls, double reach, double ahead, std::uint8_t *near) {
  neighbours::mark_near(ball_radius, {state, int(balls)}, reach, ahead, near);
}
CORE_EXPORT std::int64_t core_mark_met(double ball_radius, const double *state, std::int64_t balls, const double *states,
                                       std::int64_t instants, double reach, std::uint8_t *near) {
  return neighbours::mark_met(ball_radius, {state, int(balls)}, states, int(instants), reach, near);
}
CORE_EXPORT double core_time_apart(double ball_radius, const double *state, std::int64_t balls, double reach) {
  return neighbours::time_apart(ball_radius, {state, int(balls)}, reach);
}
