// Exported functions of surfaces, their opposing points and overlaps; arrays are C-contiguous doubles. A surface is (7,): kind, five sizes,
// side; a body (25,): its surface, position, rotation (3, 3) to fixed axes, velocity, angular velocity; unknowns are (8,).
#include "opposing.hpp"
#include "gaps.hpp"
#include "overlap.hpp"

using namespace core;

namespace {

Surface surface_of(const double *n) { return {SurfaceKind(int(n[0])), {n[1], n[2], n[3], n[4], n[5]}, n[6]}; }
Real3 real3_of(const double *n) { return {n[0], n[1], n[2]}; }
MovingSurface body_of(const double *n) {
  return {
      surface_of(n), real3_of(n + 7), {real3_of(n + 10), real3_of(n + 13), real3_of(n + 16)}, real3_of(n + 19), real3_of(n + 22)};
}
OpposingPoints points_of(const double *u) { return {real3_of(u), real3_of(u + 3), u[6], u[7]}; }
void write(const OpposingPoints &points, double *unknowns) {
  Unknowns row = unknowns_of(points);
  std::copy(row.begin(), row.end(), unknowns);
}
double *write(const Real3 &vector, double *out) { return std::copy(vector.begin(), vector.end(), out); }

}  // namespace

// f [m] of a surface at a point in its own axes, its gradient (3,) and Hesse matrix (3, 3).
CORE_EXPORT double core_level(const double *surface, const double *point, double *gradient, double *hesse) {
  Level result = level(surface_of(surface), real3_of(point));
  write(result.gradient, gradient);
  for (const Real3 &row : result.hesse) hesse = write(row, hesse);
  return result.value;
}
// The farthest points (count, 3) of a convex body along directions, in its own axes.
CORE_EXPORT void core_support(const double *surface, std::int64_t count, const double *directions, double *points) {
  for (std::int64_t i = 0; i < count; i++) points = write(support(surface_of(surface), real3_of(directions + 3 * i)), points);
}
CORE_EXPORT void core_nearest_pair(const double *a, const double *b, double *unknowns) {
  write(nearest_pair(body_of(a), body_of(b)), unknowns);
}

// Residual (8,) of the equations (1); one step of Newton's method on them; Newton's method from a point
// near the contact. The last two are false where they come to no end.
CORE_EXPORT void core_opposing_residual(const double *a, const double *b, const double *unknowns, double *residual) {
  OpposingEquations equations(body_of(a), body_of(b), points_of(unknowns));
  std::copy(equations.residual.begin(), equations.residual.end(), residual);
}
CORE_EXPORT std::int64_t core_project(const double *a, const double *b, double *unknowns) {
  OpposingPoints points = points_of(unknowns);
  bool regular = project(body_of(a), body_of(b), points);
  write(points, unknowns);
  return regular;
}
CORE_EXPORT std::int64_t core_find_opposing(const double *a, const double *b, const double *near, std::int64_t iterations,
                                            double *unknowns) {
  OpposingPoints points{};
  bool converged = find_opposing(body_of(a), body_of(b), real3_of(near), int(iterations), points);
  write(points, unknowns);
  return converged;
}
// Rates (8,) of the unknowns; false where the equations are singular.
CORE_EXPORT std::int64_t core_opposing_rates(const double *a, const double *b, const double *unknowns, double *rates) {
  Unknowns unknown_rates;
  bool regular = opposing_rates(body_of(a), body_of(b), points_of(unknowns), unknown_rates);
  std::copy(unknown_rates.begin(), unknown_rates.end(), rates);
  return regular;
}
// Where two bodies face each other (12,): normal outward of A, approach, P, Q, axis along P, axis across, as `Opposition`. Returns
// the kind of the root.
CORE_EXPORT std::int64_t core_opposition(const double *a, const double *b, const double *unknowns, double *out) {
  Opposition opposed = opposition(body_of(a), body_of(b), points_of(unknowns));
  out = write(opposed.normal, out);
  *out++ = opposed.approach, *out++ = opposed.gap.small, *out++ = opposed.gap.large;
  write(opposed.axes.y, write(opposed.axes.x, out));
  return std::int64_t(opposed.kind);
}
// The overlap (10,) of two bodies as `Overlap`, from its origin (3,), tangent axes (2, 3) and normal (3,).
CORE_EXPORT void core_overlap(const double *a, const double *b, const double *origin, const double *axes, const double *normal,
                              double approach, double size, double modulus, double *out) {
  Overlap o = overlap_of(body_of(a), body_of(b), real3_of(origin), {real3_of(axes), real3_of(axes + 3)}, real3_of(normal), approach,
                         size, modulus);
  for (double number :
       {double(o.exists), o.energy, o.load, o.volume, o.area, o.perimeter, o.half_width_x, o.half_width_y, o.centre_x, o.centre_y})
    *out++ = number;
}
// Curvatures across and along the groove (count,) [1/m] of the gap between a ball and a groove where the contact's normal has
// these radial parts.
CORE_EXPORT void core_groove_curvatures(double ball, double locus, double groove, std::int64_t count, const double *radial,
                                        double *across, double *along) {
  for (std::int64_t i = 0; i < count; i++)
    across[i] = curvature_across_groove(ball, groove), along[i] = curvature_along_groove(ball, locus, groove, radial[i]);
}
// Where an ellipsoid reaches farthest along directions (count, 3), and its gap there (count, 10): extent, point, P, Q, direction of
// the longer axis, excess.
CORE_EXPORT void core_ellipsoid_gaps(const double *semi_axes, std::int64_t count, const double *directions, double *out) {
  Real3 axes = real3_of(semi_axes);
  for (std::int64_t i = 0; i < count; i++, directions += 3) {
    Real3 direction = real3_of(directions);
    Reach reach = ellipsoid_reach(axes, direction);
    PlaneGap gap = ellipsoid_gap(axes, direction, reach);
    *out++ = reach.extent, out = write(reach.point, out), *out++ = gap.small, *out++ = gap.large;
    out = write(major_axis(gap.axes, gap.diagonal, gap.off_diagonal), out), *out++ = gap.excess;
  }
}
