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

struct OpposingPoints {
  Real3 a, b;
  double lambda, mu;
};
using Unknowns = std::array<double, 8>;  // the same in a row
inline Unknowns in_a_row(const OpposingPoints &p) { return {p.a[0], p.a[1], p.a[2], p.b[0], p.b[1], p.b[2], p.lambda, p.mu}; }
inline OpposingPoints opposing_points(const Unknowns &u) { return {{u[0], u[1], u[2]}, {u[3], u[4], u[5]}, u[6], u[7]}; }

// The equations (1): their residual, its derivative by the unknowns, and what they are made of.
struct OpposingEquations {
  Level a, b;
  Unknowns residual;
  SquareMatrix<8> jacobian;

  OpposingEquations(const MovingSurface &one, const MovingSurface &other, const OpposingPoints &p)
      : a(one.level_at(p.a)), b(other.level_at(p.b)), jacobian{} {
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

// One Newton step on (1): what a step of the differential form is followed by. False where the equations are singular.
inline bool project(const MovingSurface &a, const MovingSurface &b, OpposingPoints &points) {
  OpposingEquations equations(a, b, points);
  Unknowns step = equations.residual, unknowns = in_a_row(points);
  if (!solve(equations.jacobian, step)) return false;
  for (int i = 0; i < 8; i++) unknowns[i] -= step[i];
  points = opposing_points(unknowns);
  return true;
}

// By damped Newton steps from a point `near` the expected contact; which root it is `kind_of_root` says. False where a surface has
// no normal at the start, or the steps come to no end.
inline bool find_opposing(const MovingSurface &a, const MovingSurface &b, const Real3 &near, int iterations, OpposingPoints &points) {
  auto next_to = [&](const MovingSurface &body, Real3 &point, Real3 &gradient) {
    point = near;
    for (int i = 0; i < 20; i++) {
      Level at = body.level_at(point);
      double square = dot(at.gradient, at.gradient);
      if (!(square > 0.0)) return false;
      point = point - (at.value / square) * at.gradient;
    }
    gradient = body.level_at(point).gradient;
    return true;
  };
  Real3 gradient_a, gradient_b;
  if (!next_to(a, points.a, gradient_a) || !next_to(b, points.b, gradient_b)) return false;
  double steep = length_of(gradient_b);
  points.lambda = -length_of(gradient_a) / steep, points.mu = dot(points.a - points.b, gradient_b) / (steep * steep);
  double length = std::max({length_of(points.a - a.position), length_of(points.a - points.b), length_of(points.b - b.position)});
  auto norm = [&](const Unknowns &u, int first, int end, double weight) {
    double sum = 0.0;
    for (int i = first; i < end; i++) sum += u[i] * u[i];
    return weight * weight * sum;
  };
  auto off = [&](const Unknowns &residual) { return std::sqrt(norm(residual, 0, 3, length) + norm(residual, 3, 8, 1.0)); };
  double last = HUGE_VAL;
  for (int i = 0; i < iterations; i++) {
    OpposingEquations equations(a, b, points);
    Unknowns step = equations.residual, from = in_a_row(points), trial;
    double before = off(equations.residual), share = 1.0;
    if (!solve(equations.jacobian, step)) return false;
    double size = std::sqrt(norm(step, 0, 6, 1.0));
    for (;; share *= 0.5) {
      for (int n = 0; n < 8; n++) trial[n] = from[n] - share * step[n];
      double after = off(OpposingEquations(a, b, opposing_points(trial)).residual);
      if (after < before || share < 1e-3) break;
    }
    for (double one : trial)
      if (!std::isfinite(one)) return false;
    points = opposing_points(trial);
    if (size <= 1e-10 * length && (size >= last || size <= 1e-15 * length)) return true;  // down to rounding
    last = size;
  }
  return false;
}

// Newton's method on (1) from opposing points nearby; false where it comes to no end.
inline bool settle(const MovingSurface &a, const MovingSurface &b, OpposingPoints &points) {
  constexpr int MOST_STEPS = 25;
  double size = 1e-3 + std::fabs(points.a[0]) + std::fabs(points.a[1]) + std::fabs(points.a[2]);
  for (int i = 0; i < MOST_STEPS; i++) {
    OpposingPoints before = points;
    if (!project(a, b, points)) return false;
    Real3 moved_a = points.a - before.a, moved_b = points.b - before.b;
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
  for (int i = 0; i < 3; i++)
    rates[i] = points.lambda * carried_b[i] - carried_a[i], rates[3 + i] = points.mu * carried_b[i];
  rates[6] = dot(equations.a.gradient, material_a), rates[7] = dot(equations.b.gradient, material_b);
  return solve(equations.jacobian, rates);
}

// Angular velocity [rad/s] of the contact frame whose third axis is A's normal, Omega = gamma x d(gamma)/dt (paper 1, section 2):
// it does not turn about its normal. `rate` is that of A's point.
inline Real3 spin_of_frame(const MovingSurface &a, const OpposingPoints &points, const Real3 &rate) {
  Level at = a.level_at(points.a);
  Real3 change = cross(a.spin, at.gradient) + at.hesse * (rate - a.velocity_at(points.a));
  double over = 1.0 / length_of(at.gradient);
  Real3 normal = over * at.gradient;
  return cross(normal, over * (change - dot(normal, change) * normal));
}

// A symmetric 2 x 2 tensor in tangent axes.
struct Tensor2 { double xx, xy, yy; };
inline Tensor2 operator+(const Tensor2 &a, const Tensor2 &b) { return {a.xx + b.xx, a.xy + b.xy, a.yy + b.yy}; }

// Curvature tensor [1/m] of a surface in tangent axes, positive where the body bulges: Hess g/|grad g|. The surface is
// z = -(k_xx x^2 + 2 k_xy x y + k_yy y^2)/2 along its outward normal (paper 1, eq. 4).
inline Tensor2 curvature_tensor(const Level &level, const TangentAxes &axes) {
  double over = 1.0 / length_of(level.gradient);
  Real3 by_x = level.hesse * axes.x, by_y = level.hesse * axes.y;
  return {over * dot(axes.x, by_x), over * dot(axes.x, by_y), over * dot(axes.y, by_y)};
}

// A contact in an ellipse, or what is wrong with a root of (1): it lies on a far side, is a saddle of the distance, or is no
// ellipse (surfaces that conform, cross or are flat).
enum class RootKind { found, far_side, saddle, no_ellipse };  // as in shapes/tracking.py

// From the curvature tensors, the distance -approach [m] and lambda. A contact's gap has the form (K_A + K_B)/2, eqs. (4)-(5),
// which must be positive definite. Followed out from touching to `distance`, the root stays the same kind of stationary point
// of the distance as long as det(K_A + K_B + s K_A K_B) keeps its sign: one change makes it a saddle, two a far side.
inline RootKind kind_of_root(const Tensor2 &a, const Tensor2 &b, double distance, double lambda) {
  if (!(lambda < 0.0)) return RootKind::far_side;
  Tensor2 total = a + b;
  double determinant = total.xx * total.yy - total.xy * total.xy, trace = total.xx + total.yy;
  if (!(determinant > 1e-12 * trace * trace && trace > 0.0)) return RootKind::no_ellipse;
  double product[2][2] = {{a.xx * b.xx + a.xy * b.xy, a.xx * b.xy + a.xy * b.yy}, {a.xy * b.xx + a.yy * b.xy, a.xy * b.xy + a.yy * b.yy}};
  double mixed = total.yy * product[0][0] + total.xx * product[1][1] - total.xy * (product[1][0] + product[0][1]);
  double square = product[0][0] * product[1][1] - product[0][1] * product[1][0];
  // determinant + mixed s + square s^2, as a function of t = s/distance in (0, 1]
  double linear = mixed * distance / determinant, quadratic = square * distance * distance / determinant;
  double root = std::sqrt(std::max(linear * linear - 4.0 * quadratic, 0.0));
  int crossings = (0.5 * (-linear - root) >= 1.0) + (0.5 * (-linear + root) >= 1.0);  // by 1/t of the zeros
  return crossings == 0 ? RootKind::found : crossings == 1 ? RootKind::saddle : RootKind::far_side;
}

// The gap z = P x^2 + Q y^2 (eqs. 5 and 6), P <= Q [1/m], 0 at least; turns the first of the axes along P.
struct GapForm { double small, large; };
inline GapForm gap_form(const Tensor2 &a, const Tensor2 &b, const Real3 &normal, TangentAxes &axes) {
  Tensor2 total = a + b;
  double xx = 0.5 * total.xx, xy = 0.5 * total.xy, yy = 0.5 * total.yy;
  double mean = 0.5 * (xx + yy), half = std::hypot(0.5 * (xx - yy), xy);
  double angle = half > 0.0 ? 0.5 * std::atan2(-xy, 0.5 * (yy - xx)) : 0.0;
  axes.x = std::cos(angle) * axes.x + std::sin(angle) * axes.y;
  axes.y = cross(normal, axes.x);
  return {std::max(mean - half, 0.0), mean + half};
}

// Where two surfaces face each other: normal outward of A, approach [m] > 0 in contact, the gap, axes of which the first is
// along P, and the kind of the root.
struct Opposition {
  Real3 normal;
  double approach;
  GapForm gap;
  TangentAxes axes;
  RootKind kind;
};
inline Opposition opposition(const MovingSurface &a, const MovingSurface &b, const OpposingPoints &points) {
  Level at_a = a.level_at(points.a), at_b = b.level_at(points.b);
  Opposition found;
  found.normal = (1.0 / length_of(at_a.gradient)) * at_a.gradient;
  found.approach = -points.mu * length_of(at_b.gradient);
  found.axes = tangent_axes(found.normal);
  Tensor2 form_a = curvature_tensor(at_a, found.axes), form_b = curvature_tensor(at_b, found.axes);
  found.kind = kind_of_root(form_a, form_b, -found.approach, points.lambda);
  found.gap = gap_form(form_a, form_b, found.normal, found.axes);
  return found;
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
  PlaneOpposition found;
  found.normal = exchanged ? up : -1.0 * up;
  found.approach = dot(plane.position - low, up);
  found.gap = {gap.small, gap.large};
  found.axes.x = body.rotation * (any_axes ? gap.axes.x : gap.major_axis()), found.axes.y = cross(found.normal, found.axes.x);
  found.kind = RootKind::found;
  Real3 foot = low + found.approach * up;
  found.a = exchanged ? foot : low, found.b = exchanged ? low : foot;
  found.excess = gap.excess, found.slopes = ellipsoid_slopes(semi_axes, down, reach), found.rotation = &body.rotation;
  return found;
}

// In closed form: of a plane and a convex body, of a sphere and what has a nearest point.

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
