// A ball in a toroidal groove (paper 1, section 5): the curvatures of the gap, halves of the relative principal ones.
#pragma once
#include "../math/dual.hpp"

namespace core {

// Of the gap across the groove [1/m], and along it where the contact's normal has this radial part. Radii [m] of the ball, of
// the groove's centre circle and of its meridian.
CORE_INLINE double curvature_across_groove(double ball, double groove) { return 0.5 * (1.0 / ball - 1.0 / groove); }
template <Number N>
CORE_INLINE auto curvature_along_groove(double ball, double locus, double groove, const N &normal_radial) {
  return 0.5 * (1.0 / ball - normal_radial / (locus + groove * normal_radial));
}

}  // namespace core
