// The door to the laws of contacts and to friction: what Python asks of arrays of contacts. Arrays are C-contiguous doubles.
#include "../door.hpp"
#include "friction.hpp"
#include "laws.hpp"

using namespace core;

// Semi-axis ratios b/a of contact ellipses; c [N/m^1.5] of exact Hertz for E* = 1 Pa.
CORE_EXPORT void core_axis_ratios(std::int64_t count, const double *small, const double *large, double *ratio) {
  for (std::int64_t i = 0; i < count; i++) ratio[i] = axis_ratio(small[i], large[i]);
}
// The integrals B and D at kc = sqrt(1 - m).
CORE_EXPORT void core_elliptic(std::int64_t count, const double *complementary, double *b, double *d) {
  for (std::int64_t i = 0; i < count; i++) std::tie(b[i], d[i]) = elliptic_b_d(complementary[i]);
}
// c [N/m^p] of the law of that number, its states, if any, solved afresh.
CORE_EXPORT void core_law_coefficients(std::int64_t law, double given, std::int64_t count, const double *small, const double *large,
                                       const double *modulus, double *coefficient) {
  for (std::int64_t i = 0; i < count; i++)
    coefficient[i] = fresh_coefficient({PointLaw(law), HERTZIAN, modulus[i], given}, small[i], large[i]);
}
// Coefficient, load, stiffness and energy (4, count) of c h^p at approaches [m].
CORE_EXPORT void core_elastic(double power, std::int64_t count, const double *coefficient, const double *approach, double *found) {
  for (std::int64_t i = 0; i < count; i++) {
    auto [load, stiffness, energy] = elastic(coefficient[i], power, approach[i]);
    found[i] = coefficient[i], found[count + i] = load, found[2 * count + i] = stiffness, found[3 * count + i] = energy;
  }
}
// The states m, K and E (count/2 + 1, 3) of a law carried over steps [s] along a history of C = P/Q, by the classical
// Runge-Kutta method: `ratio` and its rates stand at the ends and middles of the steps. c [N/m^1.5] for E* = 1 Pa at the end.
CORE_EXPORT double core_carried_course(std::int64_t law, std::int64_t steps, double step, const double *ratio, const double *rate,
                                       double *states) {
  using namespace carried;
  EllipseShape shape = shape_at(ratio[0]);
  for (std::int64_t k = 0;; k++, ratio += 2, rate += 2) {
    *states++ = shape.parameter, *states++ = shape.first_kind, *states++ = shape.second_kind;
    if (k == steps) return law_coefficient({PointLaw(law), HERTZIAN, 1.0, 0.0}, ratio[0], 1.0, shape);
    EllipseShape k1 = slopes(shape), k2 = slopes(plus(shape, 0.5 * step * rate[0], k1));
    EllipseShape k3 = slopes(plus(shape, 0.5 * step * rate[1], k2)), k4 = slopes(plus(shape, step * rate[1], k3));
    double third = step / 3.0 * rate[1];
    shape = plus(plus(plus(plus(shape, step / 6.0 * rate[0], k1), third, k2), third, k3), step / 6.0 * rate[2], k4);
    if (carried_law(PointLaw(law)) == CarriedLaw::projected) shape = projected(shape, ratio[2]);
  }
}
// The scale [m^2] of a line contact's law; its load, stiffness and energy (3, count) at approaches [m].
CORE_EXPORT double core_line_scale(std::int64_t law, double radius, double half_thickness) {
  return line_scale(LineLaw(law), radius, half_thickness);
}
CORE_EXPORT void core_line_elastic(double scale, double compliance, double half_thickness, std::int64_t count, const double *approach,
                                   double *found) {
  for (std::int64_t i = 0; i < count; i++) {
    auto [load, stiffness, energy] = line_elastic({scale, compliance, half_thickness}, approach[i]);
    found[i] = load, found[count + i] = stiffness, found[2 * count + i] = energy;
  }
}
// Branch -1 of Lambert's function.
CORE_EXPORT void core_lambert_lower(std::int64_t count, const double *x, double *w) {
  for (std::int64_t i = 0; i < count; i++) w[i] = lambert_lower(x[i]);
}
// Friction (count, 3) by a model: force on the slipping body along the patch's axes [N], and about the normal [N m].
// `motion` (count, 6): normal load [N], semi-axes [m], slip along them [m/s], spin [rad/s].
CORE_EXPORT void core_friction(const double *friction, const double *points, std::int64_t count, const double *motion, double regularisation,
                               double *found) {
  PatchFriction patch = patch_friction_of(friction, points);
  for (std::int64_t i = 0; i < count; i++, motion += 6) {
    auto [major, minor, torque] = contact_friction(patch, regularisation, motion[0], motion[1], motion[2], motion[3], motion[4], motion[5]);
    *found++ = major, *found++ = minor, *found++ = torque;
  }
}
// Means (3,) over the pressure of the slip's direction along both axes and of its moment [m], by the points of a quadrature.
CORE_EXPORT void core_patch_means(std::int64_t count, const double *points, const double *motion, double regularisation, double *found) {
  PatchFriction all{FrictionModel::quadrature, 1.0, 0.0, 1.0, int(count), points};
  auto [along, across, moment] =
      patch::all_points<double>(all, regularisation * regularisation, motion[0], motion[1], motion[2], motion[3], motion[4]);
  found[0] = along, found[1] = across, found[2] = moment;
}
