// Approaches of balls to raceways, start and end of contacts, and states of laws that are carried from step to step.
#pragma once
#include "../math/linear.hpp"
#include "../methods/step_control.hpp"
#include "elements.hpp"

namespace core {

constexpr double MAX_APPROACH = 0.1;  // over the ball radius; beyond it the motion is impossible

template <class T>
CORE_INLINE T raceway_approach(const Bearing &bearing, const Raceway &raceway, const T &axis_distance, const T &height) {
  T outwards = axis_distance - raceway.locus_radius;
  return root_and_inverse(outwards * outwards + height * height + 1e-300).first + bearing.ball_radius - raceway.groove_radius;
}
template <class State>
CORE_INLINE auto outer_approach(const Bearing &bearing, const State &y) {
  return raceway_approach(bearing, bearing.outer, y[RADIUS], y[HEIGHT]);
}
// Distance of a ball's centre from a ring's axis and its height above that ring's plane [m]; `y` begins with the ball's position.
struct RingPosition { double axis_distance, height; };
template <class Y>
inline RingPosition position_in_ring(const double *centre, const double *tilt, const Y &y) {
  double c = std::cos(y[ANGLE]), s = std::sin(y[ANGLE]);
  Vector3 offset{y[RADIUS] - (c * centre[0] + s * centre[1]), s * centre[0] - c * centre[1], y[HEIGHT] - centre[2]};
  if (tilt[0] != 0.0 || tilt[1] != 0.0) offset = into_ring(ring_axes(c * tilt[0] + s * tilt[1], c * tilt[1] - s * tilt[0]), offset);
  return {std::sqrt(offset.x * offset.x + offset.y * offset.y), offset.z};
}

constexpr double TOUCHING = 1e-11;  // m: smaller approaches are neither contact nor gap
using RingPositions = std::array<RingPosition, 2>;  // in the inner and in the outer ring
using Approaches = std::array<double, 2>;  // at the inner and at the outer raceway [m]
inline Approaches raceway_approaches(const Bearing &bearing, const RingPositions &positions) {
  return {raceway_approach(bearing, bearing.inner, positions[0].axis_distance, positions[0].height),
          raceway_approach(bearing, bearing.outer, positions[1].axis_distance, positions[1].height)};
}
// The same for rings whose motion is prescribed.
template <class Y>
inline RingPositions prescribed_positions(const Bearing &bearing, const Y &y) {
  return {position_in_ring(bearing.offset, bearing.tilt, y), RingPosition{y[RADIUS], y[HEIGHT]}};
}

// True if a contact with a raceway starts or ends between two positions, other than by rounding.
inline bool changes_contact(const Approaches &before, const Approaches &after) {
  for (int i = 0; i < 2; i++)
    if (before[i] * after[i] < 0.0 && std::min(std::fabs(before[i]), std::fabs(after[i])) > TOUCHING) return true;
  return false;
}
// The fraction of a step at which a contact has just started or ended; `approaches(fraction)` are the approaches inside it.
template <class ApproachesInside>
inline double event_fraction(const Approaches &before, ApproachesInside approaches) {
  double low = 0.0, high = 1.0;
  while (high - low > 1e-6) {
    double middle = 0.5 * (low + high);
    (changes_contact(before, approaches(middle)) ? high : low) = middle;
  }
  return high;
}

// Advances the states of the law to the position of the ball in a lane at the end of a step.
inline void advance_carried(const Bearing &bearing, const RingPositions &positions, int lane, CarriedBalls &carried) {
  auto advance = [&](const Raceway &raceway, const RingPosition &position, CarriedContact &contact) {
    double outwards = position.axis_distance - raceway.locus_radius;
    double radial = outwards / std::sqrt(outwards * outwards + position.height * position.height + 1e-300);
    contact.advance(bearing.carried, bearing.curvature_across(raceway) / bearing.curvature_along(raceway, radial));
  };
  advance(bearing.inner, positions[0], carried.inner.contact[lane]), advance(bearing.outer, positions[1], carried.outer.contact[lane]);
}
// States of laws between chunks (CARRIED,): of the inner and the outer contact P/Q, m, K and E.
constexpr int CARRIED = 8;
inline void load_carried(const double *numbers, int lane, CarriedBalls &carried) {
  carried.inner.contact[lane] = {numbers[0], {numbers[1], numbers[2], numbers[3]}};
  carried.outer.contact[lane] = {numbers[4], {numbers[5], numbers[6], numbers[7]}};
}
inline void store_carried(const CarriedBalls &carried, int lane, double *numbers) {
  for (const CarriedContact &contact : {carried.inner.contact[lane], carried.outer.contact[lane]}) {
    *numbers++ = contact.ratio;
    *numbers++ = contact.shape.parameter, *numbers++ = contact.shape.first_kind, *numbers++ = contact.shape.second_kind;
  }
}

// OK if the state `y` of a ball at these positions is possible.
template <class Y>
inline Status check_ball(const Bearing &bearing, const Y &y, const RingPositions &positions) {
  double sum = 0.0;
  for (int c = 0; c < COLUMNS; c++) sum += std::fabs(y[c]);
  if (!(sum < HUGE_VAL)) return NOT_FINITE;
  auto [inner, outer] = raceway_approaches(bearing, positions);
  return std::max(inner, outer) > MAX_APPROACH * bearing.ball_radius ? TOO_DEEP : OK;
}

}  // namespace core
