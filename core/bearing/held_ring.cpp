// The door to balls alone between rings whose motion is prescribed; arrays are C-contiguous doubles.
#include "../door.hpp"
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
  std::copy(scales, scales + MOTION, chunk.scale);
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
  const Matrix3 *parts[2][3] = {{&j.velocity_by_position, &j.velocity_by_velocity, &j.velocity_by_spin},
                                {&j.spin_by_position, &j.spin_by_velocity, &j.spin_by_spin}};
  for (int row = 0; row < 6; row++)
    for (int column = 0; column < 9; column++)
      jacobian[(VELOCITY + row) * MOTION + column] = (*parts[row / 3][column / 3])[row % 3][column % 3][0];
}
// States (balls, COLUMNS) of evenly spaced balls at rest between the raceways, rolling there if they are to; 0 where one
// has no rest.
CORE_EXPORT std::int64_t core_place_balls(const double *bearing_numbers, const double *points, double ring_speed,
                                          std::int64_t rolls, std::int64_t balls, double *state) {
  return start::place_balls(bearing_of(bearing_numbers, points), ring_speed, rolls != 0, int(balls), state);
}
