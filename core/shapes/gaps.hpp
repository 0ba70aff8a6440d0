// Curvatures of gaps in closed form: a ball in a groove, an ellipsoid on a plane.
#pragma once
#include "../math/dual.hpp"
#include "../math/linear.hpp"

namespace core {

// Two unit vectors that complete a unit vector to a right-handed frame (x, y, normal).
struct TangentAxes {
  Real3 x, y;
};
CORE_INLINE TangentAxes tangent_axes(const Real3 &normal) {
  int least = 0;
  for (int i = 1; i < 3; i++)
    if (std::fabs(normal[i]) < std::fabs(normal[least])) least = i;
  Real3 x = -normal[least] * normal;
  x[least] += 1.0;
  x = (1.0 / length_of(x)) * x;
  return {x, cross(normal, x)};
}

// The direction of the greatest eigenvalue of the tensor (diagonal, off_diagonal; off_diagonal, -diagonal) in tangent axes, the first
// of the axes where all are equal.
CORE_INLINE Real3 major_axis(const TangentAxes &axes, double diagonal, double off_diagonal) {
  double size = std::sqrt(diagonal * diagonal + off_diagonal * off_diagonal);
  if (size == 0.0) return axes.x;
  double greater = std::sqrt(0.5 + 0.5 * std::fabs(diagonal) / size), smaller = 0.5 * std::fabs(off_diagonal) / (size * greater);
  double cosine = diagonal >= 0.0 ? greater : smaller, sine = diagonal >= 0.0 ? smaller : greater;
  return cosine * axes.x + std::copysign(sine, off_diagonal) * axes.y;
}

// A ball in a toroidal groove (paper 1, section 5): the curvatures of the gap, halves of the relative principal ones.

// Of the gap across the groove [1/m], and along it where the contact's normal has this radial part. Radii [m] of the ball, of
// the groove's centre circle and of its meridian.
CORE_INLINE double curvature_across_groove(double ball, double groove) { return 0.5 * (1.0 / ball - 1.0 / groove); }
template <Number N>
CORE_INLINE auto curvature_along_groove(double ball, double locus, double groove, const N &normal_radial) {
  return 0.5 * (1.0 / ball - normal_radial / (locus + groove * normal_radial));
}

// Where an ellipsoid with semi-axes A = diag(a, b, c) reaches farthest in one direction, and the gap it has there to a plane, in
// closed form. Vectors are in the ellipsoid's axes.

// Extent [m] along a unit direction, |A d|, and the point there [m], A^2 d/|A d|: the support function and its gradient.
struct Reach {
  double extent;
  Real3 point;
};
CORE_INLINE Reach ellipsoid_reach(const Real3 &axes, const Real3 &direction) {
  Real3 scaled{axes[0] * direction[0], axes[1] * direction[1], axes[2] * direction[2]};
  double extent = length_of(scaled);
  return {extent, {axes[0] * scaled[0] / extent, axes[1] * scaled[1] / extent, axes[2] * scaled[2] / extent}};
}

// The gap z = P x^2 + Q y^2 (paper 1, eq. 6) of the farthest point to a plane: P and Q = 1/(2 r) [1/m] with the principal radii
// r, the eigenvalues of the support function's second derivative (A^2 - p p^T)/|A d| across the direction, whose product is
// (a b c)^2/|A d|^4. `excess` = sqrt(shape^2 - 1) with shape = (P + Q)/(2 sqrt(PQ)), 0 where the gap is round.
struct PlaneGap {
  double small, large, excess;
  TangentAxes axes;  // across the direction
  double diagonal, off_diagonal;  // (r_xx - r_yy)/2 and r_xy along them
};
CORE_INLINE PlaneGap ellipsoid_gap(const Real3 &axes, const Real3 &direction, const Reach &reach) {
  TangentAxes across_axes = tangent_axes(direction);
  const auto &[first, second] = across_axes;
  double xx = 0.0, xy = 0.0, yy = 0.0, along = dot(first, reach.point), across = dot(second, reach.point);
  for (int i = 0; i < 3; i++) {
    double square = axes[i] * axes[i];
    xx += square * first[i] * first[i], xy += square * first[i] * second[i], yy += square * second[i] * second[i];
  }
  double inverse = 1.0 / reach.extent;
  xx = (xx - along * along) * inverse, xy = (xy - along * across) * inverse, yy = (yy - across * across) * inverse;
  double diagonal = 0.5 * (xx - yy), half = std::sqrt(diagonal * diagonal + xy * xy), great = 0.5 * (xx + yy) + half;
  double root = axes[0] * axes[1] * axes[2] * inverse * inverse;
  return {0.5 / great, std::max(0.5 * great / (root * root), 0.5 / great), half / root, across_axes, diagonal, xy};
}

// Change of the gap with the direction, per radian: gradients of -ln(PQ)/4 and of the shape, across the direction. With p the
// point, r the extent and T = a^2 + b^2 + c^2, -ln(PQ)/4 + ln r is constant and the shape is (T - p^2) r/(2 a b c).
struct GapSlopes {
  Real3 size, shape;
};
CORE_INLINE GapSlopes ellipsoid_slopes(const Real3 &axes, const Real3 &direction, const Reach &reach) {
  const Real3 &point = reach.point;
  double square = dot(point, point), remainder = dot(axes, axes) - square, scale = 0.5 / (axes[0] * axes[1] * axes[2]);
  GapSlopes slopes;
  for (int i = 0; i < 3; i++) {
    slopes.size[i] = direction[i] - point[i] / reach.extent;
    slopes.shape[i] = scale * (remainder - 2.0 * (axes[i] * axes[i] - square)) * point[i];
  }
  slopes.shape = slopes.shape - dot(slopes.shape, direction) * direction;
  return slopes;
}

}  // namespace core
