// Approaches of a ball to the raceways [m], and whether its state can be right.
#pragma once
#include "../methods/rosenbrock.hpp"
#include "ball_raceway.hpp"

namespace core {

constexpr double DEEPEST = 0.1;  // approach over ball radius beyond which bodies have run through each other

template <class T>
CORE_INLINE T approach_at(const Bearing &bearing, const Raceway &raceway, const T &axis_distance, const T &height) {
  T outwards = axis_distance - raceway.locus_radius;
  return root_and_inverse(outwards * outwards + height * height + 1e-300).first + bearing.ball_radius - raceway.groove_radius;
}
template <class State>
CORE_INLINE auto outer_approach(const Bearing &bearing, const State &y) {
  return approach_at(bearing, bearing.outer, y[RADIUS], y[HEIGHT]);
}
inline double inner_approach(const Bearing &bearing, double radius, double angle, double height) {
  double x = radius - (std::cos(angle) * bearing.offset[0] + std::sin(angle) * bearing.offset[1]);
  double y = std::sin(angle) * bearing.offset[0] - std::cos(angle) * bearing.offset[1];
  return approach_at(bearing, bearing.inner, std::sqrt(x * x + y * y), height - bearing.offset[2]);
}

// Whether a ball's state (COLUMNS,) can be right.
inline Status check_ball(const Bearing &bearing, const double *y) {
  double sum = 0.0, deepest = DEEPEST * bearing.ball_radius;
  for (int c = 0; c < COLUMNS; c++) sum += std::fabs(y[c]);
  if (!(sum < HUGE_VAL)) return NOT_FINITE;
  bool deep = inner_approach(bearing, y[RADIUS], y[ANGLE], y[HEIGHT]) > deepest || outer_approach(bearing, y) > deepest;
  return deep ? TOO_DEEP : OK;
}

}  // namespace core
