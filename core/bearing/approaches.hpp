// Approaches of a ball to the raceways [m], and whether its state can be right.
#pragma once
#include "../methods/rosenbrock.hpp"
#include "ball_raceway.hpp"
#include "tilted_ring.hpp"

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
// Distance of a ball's centre from the inner ring's axis and its height above that ring's plane [m].
struct RingPlace { double axis_distance, height; };
inline RingPlace inner_place(const Bearing &bearing, double radius, double angle, double height) {
  double c = std::cos(angle), s = std::sin(angle);
  Vector3 offset{radius - (c * bearing.offset[0] + s * bearing.offset[1]), s * bearing.offset[0] - c * bearing.offset[1],
                 height - bearing.offset[2]};
  if (bearing.tilted())
    offset = into_ring(ring_axes(c * bearing.tilt[0] + s * bearing.tilt[1], c * bearing.tilt[1] - s * bearing.tilt[0]), offset);
  return {std::sqrt(offset.x * offset.x + offset.y * offset.y), offset.z};
}
inline double inner_approach(const Bearing &bearing, double radius, double angle, double height) {
  auto [distance, above] = inner_place(bearing, radius, angle, height);
  return approach_at(bearing, bearing.inner, distance, above);
}

constexpr double TOUCHING = 1e-11;  // m: approaches below are neither contact nor gap
using Approaches = std::array<double, 2>;  // at the inner and at the outer raceway [m]

inline Approaches approaches_at(const Bearing &bearing, double radius, double angle, double height) {
  return {inner_approach(bearing, radius, angle, height), approach_at(bearing, bearing.outer, radius, height)};
}
// Whether a contact with a raceway begins or ends between two places, other than by a hair.
inline bool changes_contact(const Approaches &before, const Approaches &after) {
  for (int i = 0; i < 2; i++)
    if (before[i] * after[i] < 0.0 && std::min(std::fabs(before[i]), std::fabs(after[i])) > TOUCHING) return true;
  return false;
}
// The share of a step after which a contact has just begun or ended; `at(share)` are the approaches inside it.
template <class At>
inline double share_of_change(const Approaches &before, At at) {
  double low = 0.0, high = 1.0;
  while (high - low > 1e-6) {
    double middle = 0.5 * (low + high);
    (changes_contact(before, at(middle)) ? high : low) = middle;
  }
  return high;
}

// Ends a step of the ball in a lane, whose centre is there in the axes of either ring.
inline void carry_on(const Bearing &bearing, const RingPlace &inner, const RingPlace &outer, int lane, CarriedBalls &carried) {
  auto end = [&](const Raceway &raceway, const RingPlace &at, CarriedContact &contact) {
    double outwards = at.axis_distance - raceway.locus_radius;
    double radial = outwards / std::sqrt(outwards * outwards + at.height * at.height + 1e-300);
    contact.carry_on(bearing.carried, bearing.curvature_across(raceway) / bearing.curvature_along(raceway, radial));
  };
  end(bearing.inner, inner, carried.inner[lane]), end(bearing.outer, outer, carried.outer[lane]);
}
template <class State>
inline void carry_on(const Bearing &bearing, const State &y, int lane, CarriedBalls &carried) {
  double radius = y[RADIUS][lane], height = y[HEIGHT][lane];
  carry_on(bearing, inner_place(bearing, radius, y[ANGLE][lane], height), {radius, height}, lane, carried);
}

// What is carried of a ball between chunks (CARRIED,): of the inner and the outer contact P/Q, m, K and E.
constexpr int CARRIED = 8;
inline void load_carried(const double *numbers, int lane, CarriedBalls &carried) {
  carried.inner[lane] = {numbers[0], {numbers[1], numbers[2], numbers[3]}};
  carried.outer[lane] = {numbers[4], {numbers[5], numbers[6], numbers[7]}};
}
inline void store_carried(const CarriedBalls &carried, int lane, double *numbers) {
  for (const CarriedContact &one : {carried.inner[lane], carried.outer[lane]}) {
    *numbers++ = one.ratio;
    *numbers++ = one.shape.parameter, *numbers++ = one.shape.first_kind, *numbers++ = one.shape.second_kind;
  }
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
