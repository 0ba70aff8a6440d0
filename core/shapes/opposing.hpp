// The opposing points of two implicit surfaces (paper 1, section 2), by Newton's method or by their differential equations.
//
// The eight unknowns are the point P_A on A, P_B on B (fixed axes), and the multipliers lambda and mu of
//     grad g_A(P_A) = lambda grad g_B(P_B),   P_A - P_B = mu grad g_B(P_B),   g_A(P_A) = 0,   g_B(P_B) = 0        (1)
// with gradients outward, so lambda < 0 where the surfaces face each other; mu > 0 is a gap, mu < 0 contact. The system has
// many more roots (far sides, saddles of the distance); `kind_of_root` recognises them.
//
// A surface is the zero set of a function f, negative inside the body, with gradient and Hesse matrix in closed form. Functions
// are scaled to be metres and to have gradients near 1 at the surface, so that Newton's method needs no further scaling.
#pragma once
#include <algorithm>
#include "../math/linear.hpp"
#include "gaps.hpp"

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
  Level level{-0.5 * scale, {}, {}};
  for (int i = 0; i < 3; i++) {
    level.hesse[i][i] = scale / (axes[i] * axes[i]);
    level.gradient[i] = level.hesse[i][i] * point[i];
    level.value += 0.5 * level.gradient[i] * point[i];
  }
  return level;
}

// ((rho - R)^2 + z^2 - r^2)/(2 r), rho the distance from the axis: a factor of paper 1's polynomial f_A. Undefined on the axis.
inline Level torus(const Real3 &point, double locus, double tube) {
  double rho = std::sqrt(point[0] * point[0] + point[1] * point[1]), offset = rho - locus;
  double unit[2] = {point[0] / rho, point[1] / rho};
  Level level{0.5 * (offset * offset + point[2] * point[2] - tube * tube) / tube, {}, {}};
  for (int i = 0; i < 2; i++) {
    level.gradient[i] = offset * unit[i] / tube;
    for (int j = 0; j < 2; j++) {
      double across = (i == j) - unit[i] * unit[j];
      level.hesse[i][j] = (unit[i] * unit[j] + offset / rho * across) / tube;
    }
  }
  level.gradient[2] = point[2] / tube, level.hesse[2][2] = 1.0 / tube;
  return level;
}

// |x/a|^n and its first two derivatives.
struct PowerTerm {
  double value, first, second;
};
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
  Level result{scale * ((inner >= safe ? least * safe * safe : std::pow(inner, power)) + up.value - 1.0), {}, {}};
  for (int i = 0; i < 2; i++) {
    result.gradient[i] = scale * slope * flat[i].first;
    for (int j = 0; j < 2; j++) result.hesse[i][j] = scale * bend * flat[i].first * flat[j].first;
    result.hesse[i][i] += scale * slope * flat[i].second;
  }
  result.gradient[2] = scale * up.first, result.hesse[2][2] = scale * up.second;
  return result;
}

}  // namespace implicit

inline Level level(const Surface &surface, const Real3 &point) {
  const double(&size)[5] = surface.size;
  Level result = [&]() -> Level {
    switch (surface.kind) {
      case SurfaceKind::plane: return {point[2], {0.0, 0.0, 1.0}, {}};
      case SurfaceKind::sphere: return implicit::quadric(point, {size[0], size[0], size[0]});
      case SurfaceKind::ellipsoid: return implicit::quadric(point, {size[0], size[1], size[2]});
      case SurfaceKind::torus: return implicit::torus(point, size[0], size[1]);
      default: return implicit::superquadric(point, size);
    }
  }();
  if (surface.side < 0.0) {
    result.value = -result.value, result.gradient = -1.0 * result.gradient;
    for (Real3 &row : result.hesse) row = -1.0 * row;
  }
  return result;
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
    Level local = level(surface, from_fixed(point - position));
    return {local.value, rotation * local.gradient, rotation * local.hesse * transposed(rotation)};
  }
};

struct OpposingPoints {
  Real3 a, b;
  double lambda, mu;
};
using Unknowns = std::array<double, 8>;  // the same in a row
inline Unknowns unknowns_of(const OpposingPoints &p) { return {p.a[0], p.a[1], p.a[2], p.b[0], p.b[1], p.b[2], p.lambda, p.mu}; }
inline OpposingPoints opposing_points(const Unknowns &u) { return {{u[0], u[1], u[2]}, {u[3], u[4], u[5]}, u[6], u[7]}; }

// The equations (1): their residual, its derivative by the unknowns, and their terms.
struct OpposingEquations {
  Level a, b;
  Unknowns residual;
  SquareMatrix<8> jacobian;

  OpposingEquations(const MovingSurface &surface_a, const MovingSurface &surface_b, const OpposingPoints &p)
      : a(surface_a.level_at(p.a)), b(surface_b.level_at(p.b)), jacobian{} {
    for (int i = 0; i < 3; i++) {
      residual[i] = a.gradient[i] - p.lambda * b.gradient[i];
      residual[3 + i] = p.a[i] - p.b[i] - p.mu * b.gradient[i];
      for (int j = 0; j < 3; j++) {
        jacobian[i][j] = a.hesse[i][j], jacobian[i][3 + j] = -p.lambda * b.hesse[i][j];
        jacobian[3 + i][j] = i == j, jacobian[3 + i][3 + j] = -p.mu * b.hesse[i][j] - (i == j);
      }
      jacobian[i][6] = jacobian[3 + i][7] = -b.gradient[i];
      jacobian[6][i] = a.gradient[i], jacobian[7][3 + i] = b.gradient[i];
    }
    residual[6] = a.value, residual[7] = b.value;
  }
  // Error [m] of the unknowns in (1).
  double distance() const {
    double sum = 0.0;
    for (int i = 3; i < 8; i++) sum += residual[i] * residual[i];
    return std::sqrt(sum);
  }
};

// One Newton step on (1), the projection after a step of the differential form. False where the equations are singular.
inline bool project(const MovingSurface &a, const MovingSurface &b, OpposingPoints &points) {
  OpposingEquations equations(a, b, points);
  Unknowns step = equations.residual, unknowns = unknowns_of(points);
  if (!solve(equations.jacobian, step)) return false;
  for (int i = 0; i < 8; i++) unknowns[i] -= step[i];
  points = opposing_points(unknowns);
  return true;
}

// Solves (1) by damped Newton steps from a point `near` the expected contact; `kind_of_root` classifies the root. False where a
// surface has no normal at the start, or the steps do not converge.
inline bool find_opposing(const MovingSurface &a, const MovingSurface &b, const Real3 &near, int iterations,
                          OpposingPoints &points) {
  auto project_onto = [&](const MovingSurface &body, Real3 &point, Real3 &gradient) {
    point = near;
    for (int i = 0; i < 20; i++) {
      Level level = body.level_at(point);
      double square = dot(level.gradient, level.gradient);
      if (!(square > 0.0)) return false;
      point = point - (level.value / square) * level.gradient;
    }
    gradient = body.level_at(point).gradient;
    return true;
  };
  Real3 gradient_a, gradient_b;
  if (!project_onto(a, points.a, gradient_a) || !project_onto(b, points.b, gradient_b)) return false;
  double steep = length_of(gradient_b);
  points.lambda = -length_of(gradient_a) / steep, points.mu = dot(points.a - points.b, gradient_b) / (steep * steep);
  double length = std::max({length_of(points.a - a.position), length_of(points.a - points.b), length_of(points.b - b.position)});
  auto norm = [&](const Unknowns &u, int first, int end, double weight) {
    double sum = 0.0;
    for (int i = first; i < end; i++) sum += u[i] * u[i];
    return weight * weight * sum;
  };
  auto weighted_residual = [&](const Unknowns &residual) {
    return std::sqrt(norm(residual, 0, 3, length) + norm(residual, 3, 8, 1.0));
  };
  double last = HUGE_VAL;
  for (int i = 0; i < iterations; i++) {
    OpposingEquations equations(a, b, points);
    Unknowns step = equations.residual, start = unknowns_of(points), trial;
    double before = weighted_residual(equations.residual), fraction = 1.0;
    if (!solve(equations.jacobian, step)) return false;
    double size = std::sqrt(norm(step, 0, 6, 1.0));
    for (;; fraction *= 0.5) {
      for (int n = 0; n < 8; n++) trial[n] = start[n] - fraction * step[n];
      double after = weighted_residual(OpposingEquations(a, b, opposing_points(trial)).residual);
      if (after < before || fraction < 1e-3) break;
    }
    for (double number : trial)
      if (!std::isfinite(number)) return false;
    points = opposing_points(trial);
    if (size <= 1e-10 * length && (size >= last || size <= 1e-15 * length)) return true;  // down to rounding
    last = size;
  }
  return false;
}

// Newton's method on (1) from opposing points nearby; false where it does not converge.
inline bool solve_opposing(const MovingSurface &a, const MovingSurface &b, OpposingPoints &points) {
  constexpr int MAX_STEPS = 25;
  double size = 1e-3 + std::fabs(points.a[0]) + std::fabs(points.a[1]) + std::fabs(points.a[2]);
  for (int i = 0; i < MAX_STEPS; i++) {
    OpposingPoints previous = points;
    if (!project(a, b, points)) return false;
    Real3 moved_a = points.a - previous.a, moved_b = points.b - previous.b;
    double change = std::sqrt(dot(moved_a, moved_a) + dot(moved_b, moved_b));
    if (!std::isfinite(change + points.lambda + points.mu)) return false;
    if (change < 1e-13 * size) return true;
  }
  return false;
}

// Rates of the unknowns for the bodies' motion, from paper 1, eqs. (2)-(3), which are (1) differentiated: with v_P the
// velocity of the body's material at P, the surface carries its gradient along as d(grad g)/dt = omega x grad g +
// Hess g (u_P - v_P). False where the equations are singular.
inline bool opposing_rates(const MovingSurface &a, const MovingSurface &b, const OpposingPoints &points, Unknowns &rates) {
  OpposingEquations equations(a, b, points);
  Real3 material_a = a.velocity_at(points.a), material_b = b.velocity_at(points.b);
  Real3 carried_a = cross(a.spin, equations.a.gradient) - equations.a.hesse * material_a;
  Real3 carried_b = cross(b.spin, equations.b.gradient) - equations.b.hesse * material_b;
  for (int i = 0; i < 3; i++) rates[i] = points.lambda * carried_b[i] - carried_a[i], rates[3 + i] = points.mu * carried_b[i];
  rates[6] = dot(equations.a.gradient, material_a), rates[7] = dot(equations.b.gradient, material_b);
  return solve(equations.jacobian, rates);
}

// A symmetric 2 x 2 tensor in tangent axes.
struct Tensor2 {
  double xx, xy, yy;
};
inline Tensor2 operator+(const Tensor2 &a, const Tensor2 &b) { return {a.xx + b.xx, a.xy + b.xy, a.yy + b.yy}; }

// Curvature tensor [1/m] of a surface in tangent axes, positive where the body bulges: Hess g/|grad g|. The surface is
// z = -(k_xx x^2 + 2 k_xy x y + k_yy y^2)/2 along its outward normal (paper 1, eq. 4).
inline Tensor2 curvature_tensor(const Level &level, const TangentAxes &axes) {
  double inverse = 1.0 / length_of(level.gradient);
  Real3 by_x = level.hesse * axes.x, by_y = level.hesse * axes.y;
  return {inverse * dot(axes.x, by_x), inverse * dot(axes.x, by_y), inverse * dot(axes.y, by_y)};
}

// An elliptic contact, or an invalid root of (1): on a far side, a saddle of the distance, or without an ellipse (surfaces that
// conform, cross or are flat).
enum class RootKind { contact, far_side, saddle, no_ellipse };  // as in shapes/tracking.py

// From the curvature tensors, the distance -approach [m] and lambda. A contact's gap has the form (K_A + K_B)/2, eqs. (4)-(5),
// which must be positive definite. Followed out from touching to `distance`, the root stays the same kind of stationary point
// of the distance as long as det(K_A + K_B + s K_A K_B) keeps its sign: one change makes it a saddle, two a far side.
inline RootKind kind_of_root(const Tensor2 &a, const Tensor2 &b, double distance, double lambda) {
  if (!(lambda < 0.0)) return RootKind::far_side;
  Tensor2 total = a + b;
  double determinant = total.xx * total.yy - total.xy * total.xy, trace = total.xx + total.yy;
  if (!(determinant > 1e-12 * trace * trace && trace > 0.0)) return RootKind::no_ellipse;
  double product[2][2] = {{a.xx * b.xx + a.xy * b.xy, a.xx * b.xy + a.xy * b.yy},
                          {a.xy * b.xx + a.yy * b.xy, a.xy * b.xy + a.yy * b.yy}};
  double mixed = total.yy * product[0][0] + total.xx * product[1][1] - total.xy * (product[1][0] + product[0][1]);
  double square = product[0][0] * product[1][1] - product[0][1] * product[1][0];
  // determinant + mixed s + square s^2, as a function of t = s/distance in (0, 1]
  double linear = mixed * distance / determinant, quadratic = square * distance * distance / determinant;
  double root = std::sqrt(std::max(linear * linear - 4.0 * quadratic, 0.0));
  int crossings = (0.5 * (-linear - root) >= 1.0) + (0.5 * (-linear + root) >= 1.0);  // by 1/t of the zeros
  return crossings == 0 ? RootKind::contact : crossings == 1 ? RootKind::saddle : RootKind::far_side;
}

// The gap z = P x^2 + Q y^2 (eqs. 5 and 6), P <= Q [1/m], 0 at least; turns the first of the axes along P.
struct GapForm {
  double small, large;
};
inline GapForm gap_form(const Tensor2 &a, const Tensor2 &b, const Real3 &normal, TangentAxes &axes) {
  Tensor2 total = a + b;
  double xx = 0.5 * total.xx, xy = 0.5 * total.xy, yy = 0.5 * total.yy;
  double mean = 0.5 * (xx + yy), half = std::hypot(0.5 * (xx - yy), xy);
  axes.x = major_axis(axes, 0.5 * (yy - xx), -xy);
  axes.y = cross(normal, axes.x);
  return {std::max(mean - half, 0.0), mean + half};
}

// Geometry of two opposing surfaces: normal outward of A, approach [m] > 0 in contact, the gap, axes of which the first is
// along P, and the kind of the root.
struct Opposition {
  Real3 normal;
  double approach;
  GapForm gap;
  TangentAxes axes;
  RootKind kind;
};
inline Opposition opposition(const MovingSurface &a, const MovingSurface &b, const OpposingPoints &points) {
  Level level_a = a.level_at(points.a), level_b = b.level_at(points.b);
  Opposition result;
  result.normal = (1.0 / length_of(level_a.gradient)) * level_a.gradient;
  result.approach = -points.mu * length_of(level_b.gradient);
  result.axes = tangent_axes(result.normal);
  Tensor2 form_a = curvature_tensor(level_a, result.axes), form_b = curvature_tensor(level_b, result.axes);
  result.kind = kind_of_root(form_a, form_b, -result.approach, points.lambda);
  result.gap = gap_form(form_a, form_b, result.normal, result.axes);
  return result;
}

// The same of a sphere or an ellipsoid and a plane, one of which is A, in closed form; their opposing points, and in the axes of the
// ellipsoid how the gap changes as it turns.
struct PlaneOpposition : Opposition {
  Real3 a, b;
  double excess;
  GapSlopes slopes;
  const RealMatrix3 *rotation;  // of the ellipsoid
};
// With `any_axes` the first of the axes need not be along P.
CORE_INLINE PlaneOpposition plane_opposition(const MovingSurface &a, const MovingSurface &b, bool any_axes) {
  const bool exchanged = a.surface.kind == SurfaceKind::plane;
  const MovingSurface &body = exchanged ? b : a, &plane = exchanged ? a : b;
  const double(&size)[5] = body.surface.size;
  Real3 semi_axes = body.surface.kind == SurfaceKind::sphere ? Real3{size[0], size[0], size[0]} : Real3{size[0], size[1], size[2]};
  Real3 up{plane.rotation[0][2], plane.rotation[1][2], plane.rotation[2][2]}, down = body.from_fixed(-1.0 * up);
  Reach reach = ellipsoid_reach(semi_axes, down);
  PlaneGap gap = ellipsoid_gap(semi_axes, down, reach);
  Real3 low = body.position + body.rotation * reach.point;
  PlaneOpposition result;
  result.normal = exchanged ? up : -1.0 * up;
  result.approach = dot(plane.position - low, up);
  result.gap = {gap.small, gap.large};
  result.axes.x = body.rotation * (any_axes ? gap.axes.x : major_axis(gap.axes, gap.diagonal, gap.off_diagonal)),
  result.axes.y = cross(result.normal, result.axes.x);
  result.kind = RootKind::contact;
  Real3 foot = low + result.approach * up;
  result.a = exchanged ? foot : low, result.b = exchanged ? low : foot;
  result.excess = gap.excess, result.slopes = ellipsoid_slopes(semi_axes, down, reach), result.rotation = &body.rotation;
  return result;
}

// In closed form: of a plane and a convex body, of a sphere and a surface with a nearest point.

// The farthest point [m] of a sphere, ellipsoid or superquadric along a direction, in the body's axes: the gradient of the
// dual norm, whose exponents are n/(n - 1) and m/(m - 1).
inline Real3 support(const Surface &surface, const Real3 &direction) {
  bool round = surface.kind == SurfaceKind::sphere, quadric = surface.kind != SurfaceKind::superquadric;
  Real3 axes{surface.size[0], round ? surface.size[0] : surface.size[1], round ? surface.size[0] : surface.size[2]};
  Real3 scaled{axes[0] * direction[0], axes[1] * direction[1], axes[2] * direction[2]};
  if (quadric) {
    double inverse = 1.0 / length_of(scaled);
    return {axes[0] * scaled[0] * inverse, axes[1] * scaled[1] * inverse, axes[2] * scaled[2] * inverse};
  }
  double n = surface.size[3] / (surface.size[3] - 1.0), m = surface.size[4] / (surface.size[4] - 1.0);
  double flat = std::pow(std::pow(std::fabs(scaled[0]), n) + std::pow(std::fabs(scaled[1]), n), 1.0 / n);
  double length = std::pow(std::pow(flat, m) + std::pow(std::fabs(scaled[2]), m), 1.0 / m);
  Real3 point{};
  if (flat > 0.0) {
    double factor = std::pow(flat / length, m - 1.0);
    for (int i = 0; i < 2; i++)
      point[i] = axes[i] * std::copysign(std::pow(std::fabs(scaled[i]) / flat, n - 1.0), scaled[i]) * factor;
  }
  point[2] = axes[2] * std::copysign(std::pow(std::fabs(scaled[2]) / length, m - 1.0), scaled[2]);
  return point;
}

// The point of a plane, a sphere or a torus nearest to another.
inline Real3 nearest_point(const MovingSurface &body, const Real3 &centre) {
  Real3 local = body.from_fixed(centre - body.position);
  const double *size = body.surface.size;
  if (body.surface.kind == SurfaceKind::plane) local[2] = 0.0;
  else if (body.surface.kind == SurfaceKind::sphere) local = (size[0] / length_of(local)) * local;
  else {
    double rho = std::hypot(local[0], local[1]), offset = rho - size[0], fraction = size[1] / std::hypot(offset, local[2]);
    double stretch = (size[0] + fraction * offset) / rho;
    local = {stretch * local[0], stretch * local[1], fraction * local[2]};
  }
  return body.position + body.rotation * local;
}

// The opposing points of a pair that has a closed form.
inline OpposingPoints nearest_pair(const MovingSurface &a, const MovingSurface &b) {
  OpposingPoints points{};
  bool exchanged = a.surface.kind == SurfaceKind::plane || a.surface.kind == SurfaceKind::torus;
  const MovingSurface &convex = exchanged ? b : a, &target = exchanged ? a : b;
  Real3 &on_convex = exchanged ? points.b : points.a, &on_target = exchanged ? points.a : points.b;
  if (target.surface.kind == SurfaceKind::plane) {
    Real3 down = -1.0 * Real3{target.rotation[0][2], target.rotation[1][2], target.rotation[2][2]};
    on_convex = convex.position + convex.rotation * support(convex.surface, convex.from_fixed(down));
    on_target = nearest_point(target, on_convex);
  } else {
    on_target = nearest_point(target, convex.position);
    Real3 gradient = target.level_at(on_target).gradient;
    on_convex = convex.position - (convex.surface.size[0] / length_of(gradient)) * gradient;
  }
  Real3 gradient_a = a.level_at(points.a).gradient, gradient_b = b.level_at(points.b).gradient;
  double square = dot(gradient_b, gradient_b);
  points.lambda = -std::sqrt(dot(gradient_a, gradient_a) / square);
  points.mu = dot(points.a - points.b, gradient_b) / square;
  return points;
}

}  // namespace core
