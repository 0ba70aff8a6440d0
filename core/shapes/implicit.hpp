// Surfaces as the zero set of a function f, negative inside the body, with gradient and Hesse matrix in closed form. Functions
// are scaled to be metres and to have gradients near 1 at the surface, so that Newton's method needs no further scaling.
#pragma once
#include <algorithm>
#include "../math/linear.hpp"

namespace core {

enum class SurfaceKind { plane, sphere, ellipsoid, torus, superquadric };  // as in shapes.py

// In its body's axes: kind, five sizes [m] or exponents, and side +1, or -1 where the body is outside.
struct Surface {
  SurfaceKind kind;
  double size[5], side;
};

// f [m], its gradient and Hesse matrix [1/m].
struct Level {
  double value;
  Real3 gradient;
  RealMatrix3 hesse;
};

namespace implicit {

// (s/2) (sum (r_i/a_i)^2 - 1), s the smallest semi-axis.
inline Level quadric(const Real3 &point, const Real3 &axes) {
  double scale = std::min({axes[0], axes[1], axes[2]});
  Level found{-0.5 * scale, {}, {}};
  for (int i = 0; i < 3; i++) {
    found.hesse[i][i] = scale / (axes[i] * axes[i]);
    found.gradient[i] = found.hesse[i][i] * point[i];
    found.value += 0.5 * found.gradient[i] * point[i];
  }
  return found;
}

// ((rho - R)^2 + z^2 - r^2)/(2 r), rho the distance from the axis: a factor of paper 1's polynomial f_A. Undefined on the axis.
inline Level torus(const Real3 &point, double locus, double tube) {
  double rho = std::sqrt(point[0] * point[0] + point[1] * point[1]), off = rho - locus;
  double unit[2] = {point[0] / rho, point[1] / rho};
  Level found{0.5 * (off * off + point[2] * point[2] - tube * tube) / tube, {}, {}};
  for (int i = 0; i < 2; i++) {
    found.gradient[i] = off * unit[i] / tube;
    for (int j = 0; j < 2; j++) {
      double across = (i == j) - unit[i] * unit[j];
      found.hesse[i][j] = (unit[i] * unit[j] + off / rho * across) / tube;
    }
  }
  found.gradient[2] = point[2] / tube, found.hesse[2][2] = 1.0 / tube;
  return found;
}

// |x/a|^n and its first two derivatives.
struct PowerTerm { double value, first, second; };
inline PowerTerm power_term(double x, double axis, double exponent) {
  double share = std::fabs(x) / axis, least = std::pow(share, exponent - 2.0), slope = least * share;
  return {slope * share, (x >= 0.0 ? 1.0 : -1.0) * exponent * slope / axis, exponent * (exponent - 1.0) * least / (axis * axis)};
}

// (s/m) (F - 1), F = (|x/a|^n + |y/b|^n)^(m/n) + |z/c|^m, with s the smallest semi-axis.
inline Level superquadric(const Real3 &point, const double (&size)[5]) {
  double n = size[3], m = size[4], scale = std::min({size[0], size[1], size[2]}) / m, power = m / n;
  PowerTerm flat[2] = {power_term(point[0], size[0], n), power_term(point[1], size[1], n)}, up = power_term(point[2], size[2], m);
  double inner = flat[0].value + flat[1].value, safe = std::max(inner, 1e-100);  // on the z axis all terms below vanish
  double least = std::pow(safe, power - 2.0), slope = power * least * safe, bend = power * (power - 1.0) * least;
  Level found{scale * ((inner >= safe ? least * safe * safe : std::pow(inner, power)) + up.value - 1.0), {}, {}};
  for (int i = 0; i < 2; i++) {
    found.gradient[i] = scale * slope * flat[i].first;
    for (int j = 0; j < 2; j++) found.hesse[i][j] = scale * bend * flat[i].first * flat[j].first;
    found.hesse[i][i] += scale * slope * flat[i].second;
  }
  found.gradient[2] = scale * up.first, found.hesse[2][2] = scale * up.second;
  return found;
}

}  // namespace implicit

inline Level level(const Surface &surface, const Real3 &point) {
  const double(&size)[5] = surface.size;
  Level found = [&]() -> Level {
    switch (surface.kind) {
      case SurfaceKind::plane: return {point[2], {0.0, 0.0, 1.0}, {}};
      case SurfaceKind::sphere: return implicit::quadric(point, {size[0], size[0], size[0]});
      case SurfaceKind::ellipsoid: return implicit::quadric(point, {size[0], size[1], size[2]});
      case SurfaceKind::torus: return implicit::torus(point, size[0], size[1]);
      default: return implicit::superquadric(point, size);
    }
  }();
  if (surface.side < 0.0) {
    found.value = -found.value, found.gradient = -1.0 * found.gradient;
    for (Real3 &row : found.hesse) row = -1.0 * row;
  }
  return found;
}

// A surface in motion: position [m] and the rotation from its own to fixed axes, velocity, angular velocity.
struct MovingSurface {
  Surface surface;
  Real3 position;
  RealMatrix3 rotation;
  Real3 velocity, spin;

  Real3 from_fixed(const Real3 &vector) const { return transposed(rotation) * vector; }
  Real3 velocity_at(const Real3 &point) const { return velocity + cross(spin, point - position); }
  // The same as `core::level` at a point, in fixed axes.
  Level level_at(const Real3 &point) const {
    Level found = level(surface, from_fixed(point - position));
    return {found.value, rotation * found.gradient, rotation * found.hesse * transposed(rotation)};
  }
};

}  // namespace core
