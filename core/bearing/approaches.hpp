// Approaches of balls to raceways, where contacts begin and end, and what a law carries from step to step.
#pragma once
#include "../math/linear.hpp"
#include "../methods/rosenbrock.hpp"
#include "elements.hpp"

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
// Distance of a ball's centre from a ring's axis and its height above that ring's plane [m]; `y` begins with the ball's place.
struct RingPlace { double axis_distance, height; };
template <class Y>
inline RingPlace place_in_ring(const double *centre, const double *tilt, const Y &y) {
  double c = std::cos(y[ANGLE]), s = std::sin(y[ANGLE]);
  Vector3 offset{y[RADIUS] - (c * centre[0] + s * centre[1]), s * centre[0] - c * centre[1], y[HEIGHT] - centre[2]};
  if (tilt[0] != 0.0 || tilt[1] != 0.0) offset = into_ring(ring_axes(c * tilt[0] + s * tilt[1], c * tilt[1] - s * tilt[0]), offset);
  return {std::sqrt(offset.x * offset.x + offset.y * offset.y), offset.z};
}

constexpr double TOUCHING = 1e-11;  // m: approaches below are neither contact nor gap
using RingPlaces = std::array<RingPlace, 2>;  // in the inner and in the outer ring
using Approaches = std::array<double, 2>;  // at the inner and at the outer raceway [m]
inline Approaches approaches_of(const Bearing &bearing, const RingPlaces &places) {
  return {approach_at(bearing, bearing.inner, places[0].axis_distance, places[0].height),
          approach_at(bearing, bearing.outer, places[1].axis_distance, places[1].height)};
}
// Of a ball between rings whose motion is prescribed.
template <class Y>
inline RingPlaces prescribed_places(const Bearing &bearing, const Y &y) {
  return {place_in_ring(bearing.offset, bearing.tilt, y), RingPlace{y[RADIUS], y[HEIGHT]}};
}

// True if a contact with a raceway begins or ends between two places, other than by rounding.
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

// Ends a step of the ball in a lane, which is there.
inline void carry_on(const Bearing &bearing, const RingPlaces &places, int lane, CarriedBalls &carried) {
  auto end = [&](const Raceway &raceway, const RingPlace &at, CarriedContact &contact) {
    double outwards = at.axis_distance - raceway.locus_radius;
    double radial = outwards / std::sqrt(outwards * outwards + at.height * at.height + 1e-300);
    contact.carry_on(bearing.carried, bearing.curvature_across(raceway) / bearing.curvature_along(raceway, radial));
  };
  end(bearing.inner, places[0], carried.inner.contact[lane]), end(bearing.outer, places[1], carried.outer.contact[lane]);
}
// States of a ball's contacts that are carried between chunks (CARRIED,): of the inner and the outer contact P/Q, m, K and E.
constexpr int CARRIED = 8;
inline void load_carried(const double *numbers, int lane, CarriedBalls &carried) {
  carried.inner.contact[lane] = {numbers[0], {numbers[1], numbers[2], numbers[3]}};
  carried.outer.contact[lane] = {numbers[4], {numbers[5], numbers[6], numbers[7]}};
}
inline void store_carried(const CarriedBalls &carried, int lane, double *numbers) {
  for (const CarriedContact &one : {carried.inner.contact[lane], carried.outer.contact[lane]}) {
    *numbers++ = one.ratio;
    *numbers++ = one.shape.parameter, *numbers++ = one.shape.first_kind, *numbers++ = one.shape.second_kind;
  }
}

// OK if a ball's state `y` is possible, which is there.
template <class Y>
inline Status check_ball(const Bearing &bearing, const Y &y, const RingPlaces &places) {
  double sum = 0.0;
  for (int c = 0; c < COLUMNS; c++) sum += std::fabs(y[c]);
  if (!(sum < HUGE_VAL)) return NOT_FINITE;
  auto [inner, outer] = approaches_of(bearing, places);
  return std::max(inner, outer) > DEEPEST * bearing.ball_radius ? TOO_DEEP : OK;
}

}  // namespace core
