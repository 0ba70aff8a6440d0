// Exported functions of contacts, on arrays of them, which are C-contiguous doubles.
#include <cmath>
#include <tuple>
#include "ellipse.hpp"
#include "friction.hpp"
#include "laws.hpp"

using namespace core;

// Semi-axes [m] and peak pressures [Pa] of contacts with these curvatures [1/m], effective moduli [Pa] and loads [N].
CORE_EXPORT void core_ellipses(std::int64_t count, const double *small, const double *large, const double *modulus,
                               const double *load, double *semi_major, double *semi_minor, double *peak_pressure) {
  for (std::int64_t i = 0; i < count; i++) {
    Ellipse result = ellipse(small[i], large[i], modulus[i], load[i]);
    semi_major[i] = result.semi_major, semi_minor[i] = result.semi_minor, peak_pressure[i] = result.peak_pressure;
  }
}
// Semi-axis ratios b/a of contact ellipses.
CORE_EXPORT void core_axis_ratios(std::int64_t count, const double *small, const double *large, double *ratio) {
  for (std::int64_t i = 0; i < count; i++) ratio[i] = axis_ratio(small[i], large[i]);
}
// The integrals B and D at kc = sqrt(1 - m).
CORE_EXPORT void core_elliptic(std::int64_t count, const double *complementary, double *b, double *d) {
  for (std::int64_t i = 0; i < count; i++) std::tie(b[i], d[i]) = elliptic_b_d(complementary[i]);
}

// The numbers (count, FILM_NUMBERS) of contacts with these curvatures (count,).
CORE_EXPORT void core_film_numbers(const double *lubricant, std::int64_t count, const double *small, const double *large,
                                   double modulus, double ball_radius, double *out) {
  for (std::int64_t i = 0; i < count; i++) {
    FilmNumbers logarithms = film_numbers(lubricant_of(lubricant), small[i], large[i], modulus, ball_radius);
    out = std::copy(logarithms.begin(), logarithms.end(), out);
  }
}

// Of contacts (count, 6) with numbers (count, FILM_NUMBERS), loads and speeds (count,) above 0: thickness [m], thickness over
// roughness, resistance [N], moments of hysteresis and of differential slip [N m], coefficient of friction.
CORE_EXPORT void core_films(const double *lubricant, std::int64_t count, const double *numbers, const double *load,
                            const double *speed, double *out) {
  const Lubricant oil = lubricant_of(lubricant);
  for (std::int64_t i = 0; i < count; i++, numbers += FILM_NUMBERS, out += 6) {
    double q = std::log(load[i]), u = std::log(speed[i]), ratio = film_thickness(numbers, q, u) - oil.log_roughness;
    double friction = mixed_friction(oil, ratio);
    out[0] = std::exp(ratio + oil.log_roughness), out[1] = std::exp(ratio), out[2] = film_resistance(oil, numbers, q, u, speed[i]);
    out[3] = hysteresis_moment(numbers, q), out[4] = friction * slip_moment(numbers, q), out[5] = friction;
  }
}

// c [N/m^p] of the law of that number; states, if any, are solved for.
CORE_EXPORT void core_law_coefficients(std::int64_t law, double given, std::int64_t count, const double *small, const double *large,
                                       const double *modulus, double *coefficient) {
  for (std::int64_t i = 0; i < count; i++)
    coefficient[i] = fresh_coefficient({PointLaw(law), HERTZIAN, modulus[i], given}, small[i], large[i]);
}
// Loads, stiffnesses and energies of c h^p at approaches [m].
CORE_EXPORT void core_elastic(double power, std::int64_t count, const double *coefficient, const double *approach, double *load,
                              double *stiffness, double *energy) {
  for (std::int64_t i = 0; i < count; i++) {
    auto result = elastic(coefficient[i], power, approach[i]);
    load[i] = result.load, stiffness[i] = result.stiffness, energy[i] = result.energy;
  }
}
// The states m, K and E (count, 3) of a law carried from step to step along C = P/Q (count,). c (count,) for Q = 1/m, E* = 1 Pa.
CORE_EXPORT void core_carried_course(std::int64_t number, std::int64_t count, const double *ratio, double *states,
                                     double *coefficient) {
  Elasticity law{PointLaw(number), HERTZIAN, 1.0, 0.0};
  CarriedContact contact{};
  for (std::int64_t k = 0; k < count; k++) {
    contact.advance(carried_law(law.law), ratio[k]);
    const EllipseShape &shape = contact.shape;
    *states++ = shape.parameter, *states++ = shape.first_kind, *states++ = shape.second_kind;
    coefficient[k] = law_coefficient(law, ratio[k], 1.0, shape);
  }
}
// Scales [m^2] of a line contact's law.
CORE_EXPORT void core_line_scales(std::int64_t law, std::int64_t count, const double *radius, const double *half_thickness,
                                  double *scale) {
  for (std::int64_t i = 0; i < count; i++) scale[i] = line_scale(LineLaw(law), radius[i], half_thickness[i]);
}
// Branch -1 of Lambert's function.
CORE_EXPORT void core_lambert_lower(std::int64_t count, const double *x, double *w) {
  for (std::int64_t i = 0; i < count; i++) w[i] = lambert_lower(x[i]);
}
// Friction (count, 3) by a model: force on the slipping body along the patch's axes [N], and about the normal [N m].
// `motion` (count, 6): normal load [N], semi-axes [m], slip along them [m/s], spin [rad/s].
CORE_EXPORT void core_friction(const double *friction, const double *points, std::int64_t count, const double *motion,
                               double regularisation, double *out) {
  PatchFriction patch = patch_friction_of(friction, points);
  for (std::int64_t i = 0; i < count; i++, motion += 6) {
    auto [major, minor, torque] =
        contact_friction(patch, regularisation, motion[0], motion[1], motion[2], motion[3], motion[4], motion[5]);
    *out++ = major, *out++ = minor, *out++ = torque;
  }
}
