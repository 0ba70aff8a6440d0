// How a stretch of an integration ended and what it cost (bearing_twin/numerics/statuses.py), and the control of steps.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace core {

constexpr double LEAST_STEP = 1e-15;  // s; a shorter step is lost in the time
constexpr double NEGLIGIBLE = 1e-12;  // share of a stretch that is too short for a step

enum Status { OK, NOT_FINITE, TOO_DEEP, STALLED, FULL, SEPARATED, TIME_UP, STOPPED, UNTRACKED };

struct Counts { std::int64_t steps, rejections, evaluations; };

// The step that should just meet an error of 1, given the error of this one; changes by 0.2 to 6 at most.
inline double next_step(double step, double error, int order) {
  if (!(error < HUGE_VAL)) return 0.2 * step;
  double least = std::max(error, 1e-10);
  double root = order == 4 ? std::sqrt(std::sqrt(least)) : std::pow(least, 1.0 / order);
  return step * std::min(6.0, std::max(0.2, 0.9 / root));
}

}  // namespace core
