// Opposing points in closed form: of a plane and a convex body, of a sphere and what has a nearest point.
#pragma once
#include "opposing.hpp"

namespace core {

// True if `nearest_pair` knows the opposing points of surfaces of these kinds.
inline bool is_convex(SurfaceKind kind) { return kind != SurfaceKind::plane && kind != SurfaceKind::torus; }
inline bool closed_form_known(SurfaceKind a, SurfaceKind b) {
  auto of = [](SurfaceKind one, SurfaceKind other) {
    return (one == SurfaceKind::plane && is_convex(other)) ||
           (one == SurfaceKind::sphere && (other == SurfaceKind::sphere || other == SurfaceKind::torus));
  };
  return of(a, b) || of(b, a);
}

// The farthest point [m] of a sphere, ellipsoid or superquadric along a direction, in the body's axes: the gradient of the
// dual norm, whose exponents are n/(n - 1) and m/(m - 1).
inline Real3 support(const Surface &surface, const Real3 &direction) {
  bool round = surface.kind == SurfaceKind::sphere, quadric = surface.kind != SurfaceKind::superquadric;
  Real3 axes{surface.size[0], round ? surface.size[0] : surface.size[1], round ? surface.size[0] : surface.size[2]};
  Real3 own{axes[0] * direction[0], axes[1] * direction[1], axes[2] * direction[2]};
  if (quadric) {
    double over = 1.0 / length_of(own);
    return {axes[0] * own[0] * over, axes[1] * own[1] * over, axes[2] * own[2] * over};
  }
  double n = surface.size[3] / (surface.size[3] - 1.0), m = surface.size[4] / (surface.size[4] - 1.0);
  double flat = std::pow(std::pow(std::fabs(own[0]), n) + std::pow(std::fabs(own[1]), n), 1.0 / n);
  double length = std::pow(std::pow(flat, m) + std::pow(std::fabs(own[2]), m), 1.0 / m);
  Real3 point{};
  if (flat > 0.0) {
    double around = std::pow(flat / length, m - 1.0);
    for (int i = 0; i < 2; i++) point[i] = axes[i] * std::copysign(std::pow(std::fabs(own[i]) / flat, n - 1.0), own[i]) * around;
  }
  point[2] = axes[2] * std::copysign(std::pow(std::fabs(own[2]) / length, m - 1.0), own[2]);
  return point;
}

// The point of a plane, a sphere or a torus nearest to another.
inline Real3 nearest_point(const MovingSurface &body, const Real3 &centre) {
  Real3 own = body.from_fixed(centre - body.position);
  const double *size = body.surface.size;
  if (body.surface.kind == SurfaceKind::plane) own[2] = 0.0;
  else if (body.surface.kind == SurfaceKind::sphere) own = (size[0] / length_of(own)) * own;
  else {
    double rho = std::hypot(own[0], own[1]), off = rho - size[0], share = size[1] / std::hypot(off, own[2]);
    double stretch = (size[0] + share * off) / rho;
    own = {stretch * own[0], stretch * own[1], share * own[2]};
  }
  return body.position + body.rotation * own;
}

// The opposing points of a pair that has a closed form.
inline OpposingPoints nearest_pair(const MovingSurface &a, const MovingSurface &b) {
  OpposingPoints points{};
  bool exchanged = a.surface.kind == SurfaceKind::plane || a.surface.kind == SurfaceKind::torus;
  const MovingSurface &one = exchanged ? b : a, &other = exchanged ? a : b;
  Real3 &on_one = exchanged ? points.b : points.a, &on_other = exchanged ? points.a : points.b;
  if (other.surface.kind == SurfaceKind::plane) {
    Real3 down = -1.0 * Real3{other.rotation[0][2], other.rotation[1][2], other.rotation[2][2]};
    on_one = one.position + one.rotation * support(one.surface, one.from_fixed(down));
    on_other = nearest_point(other, on_one);
  } else {
    on_other = nearest_point(other, one.position);
    Real3 gradient = other.level_at(on_other).gradient;
    on_one = one.position - (one.surface.size[0] / length_of(gradient)) * gradient;
  }
  Real3 gradient_a = a.level_at(points.a).gradient, gradient_b = b.level_at(points.b).gradient;
  double square = dot(gradient_b, gradient_b);
  points.lambda = -std::sqrt(dot(gradient_a, gradient_a) / square);
  points.mu = dot(points.a - points.b, gradient_b) / square;
  return points;
}

}  // namespace core
