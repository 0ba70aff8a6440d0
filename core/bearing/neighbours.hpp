// Which neighbours in the row of balls may meet. Balls never pass each other in the groove, so neighbours stay such.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>
#include "model.hpp"

namespace core::neighbours {

struct Row {
  const double *state;  // (balls, COLUMNS)
  int balls;

  const double *ball(int k) const { return state + k * COLUMNS; }
  // Orbit angle [rad] from ball k to the next ahead.
  double angle_ahead(int k) const {
    double angle = ball(k + 1 < balls ? k + 1 : 0)[ANGLE] - ball(k)[ANGLE];
    return k + 1 < balls ? angle : angle + 2.0 * M_PI;
  }
};

struct Meeting { double gap, closing; };

// Gap [m] from ball k to the next ahead, and twice the speed [m/s] at which their orbits close it. A gap that cannot
// close, because there is no other ball or the way round is the longer one, is infinite; one that the ball has passed
// through is below minus its diameter.
inline Meeting meeting(double ball_radius, const Row &row, int k) {
  double angle = row.angle_ahead(k);
  if (row.balls == 1 || (row.balls == 2 && angle > M_PI)) return {HUGE_VAL, 0.0};
  const double *own = row.ball(k), *next = row.ball(k + 1 < row.balls ? k + 1 : 0);
  double x = std::cos(angle) * next[RADIUS] - own[RADIUS], y = std::sin(angle) * next[RADIUS], z = next[HEIGHT] - own[HEIGHT];
  return {std::copysign(std::sqrt(x * x + y * y + z * z), angle) - 2.0 * ball_radius, 2.0 * std::fabs(next[VELOCITY + 1] - own[VELOCITY + 1])};
}

// Sets near[k] where ball k and the next ahead may come closer than `reach` [m] within `ahead` [s].
inline void mark_near(double ball_radius, const Row &row, double reach, double ahead, std::uint8_t *near) {
  for (int k = 0; k < row.balls; k++) {
    Meeting found = meeting(ball_radius, row, k);
    near[k] = found.gap < reach + ahead * found.closing;
  }
}

// Sets near[k] where ball k was closer than `reach` [m] to the next ahead, in `row` or in any of the states (instants,
// balls, COLUMNS); returns whether any was not set yet.
inline bool mark_met(double ball_radius, const Row &row, const double *states, int instants, double reach, std::uint8_t *near) {
  bool found = false;
  for (int k = 0; k < row.balls; k++) {
    Row closest = row;
    double least = row.angle_ahead(k);
    for (int i = 0; i < instants; i++) {
      Row there{states + long(i) * row.balls * COLUMNS, row.balls};
      if (double angle = there.angle_ahead(k); angle < least) closest = there, least = angle;
    }
    if (meeting(ball_radius, closest, k).gap < reach) found |= !near[k], near[k] = 1;
  }
  return found;
}

// Seconds for which no two balls can come closer than `reach` [m], by their present speeds.
inline double time_apart(double ball_radius, const Row &row, double reach) {
  double least = HUGE_VAL;
  for (int k = 0; k < row.balls; k++) {
    Meeting found = meeting(ball_radius, row, k);
    least = std::min(least, std::max(found.gap - reach, 0.0) / (found.closing + 1e-300));
  }
  return least;
}

}  // namespace core::neighbours
