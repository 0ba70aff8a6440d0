// The lubricant's film in an elliptic contact that rolls at the speed u [m/s] under the load Q [N], and what else resists
// rolling there; steady and isothermal. Of equal bodies E' = E/(1 - nu^2), R_x and R_y are the radii of the gap along
// rolling and across, a >= b the semi-axes across and along, k = a/b, 𝓔 Hertz's complete elliptic integral of the second kind, and
//
//     U = eta u/(E' R_x),  V = 2 U,  G = alpha E',  W = Q/(E' R_x^2),  beta = (4/pi) 𝓔/(1 + R_x/R_y).
//
// Film, at its centre (Hamrock and Dowson 1977): h = 2.69 R_x U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73 k)).
// Rolling resistance F on each surface, with little oil (grease; Houpert 1987, 2010),
//     F = 1.544 E' R_x^2 beta^(1/3) (b/a)^-0.577 V^0.656 W^0.466 G^0.022,
// and flooded (oil; Biboulet and Houpert 2010), M = beta^(1/4) (b/a) W V^(-3/4),
//     F = 2 a E' R_x V^(3/4) {[0.77 beta^(-1/3) (b/a)^0.12 V^(-1/12) - 1.8 beta^(-1/4)]/(1 + M/6.6) + 1.8 beta^(-1/4)},
// both times 1/(1 + c u^1.28) for heating of the inlet, grease also times exp(-s u) for its starvation (SKF).
// Hysteresis of the steel (Houpert): moment 7.48e-7 r^0.33 Q^1.33 (1 - 3.519e-3 (R_y/R_x - 1)^0.8063) about the ball's
// axis; differential slip (Heathcote), moment 0.0806 mu Q a^2/R_d, R_d = 4 f r/(2 f + 1) the radius of the curved patch.
//
// All of these are products of powers of Q and u: their logarithms are held as numbers of a contact, `FilmNumbers`.
#pragma once
#include <array>
#include "../math/dual.hpp"
#include "ellipse.hpp"

namespace core {

enum class LubricantKind { none, grease, oil };

// `heating` is c [(s/m)^1.28], `starvation` s [s/m]; coefficients of friction where surfaces touch and on a whole film.
struct Lubricant {
  LubricantKind kind;
  double viscosity = 0.0, pressure_coefficient = 0.0, log_roughness = 0.0;  // [Pa s], [1/Pa], of metres
  double boundary_friction = 0.0, film_friction = 0.0, heating = 0.0, starvation = 0.0;
  bool works() const { return kind != LubricantKind::none; }
};

// Logarithms of the coefficients: resistance [N], flooded in its two limits; M; thickness [m]; moments of hysteresis and, for
// a coefficient of friction of 1, of differential slip [N m].
enum FilmNumber { RESISTANCE, ELASTIC_RESISTANCE, ELASTIC_SHARE, THICKNESS, HYSTERESIS, DIFFERENTIAL_SLIP, FILM_NUMBERS };
using FilmNumbers = std::array<double, FILM_NUMBERS>;

// 2 (3/8) [t^3/3 - t^5/5 from 0 to 1, less twice that to 0.3473, where slip changes its sign, so that it has no net force].
constexpr double HEATHCOTE = 0.08057119887217787;

// The numbers for curvatures of the gap [1/m], `modulus` E* = E'/2 [Pa] and a ball of this radius [m].
inline FilmNumbers film_numbers(const Lubricant &lubricant, double small, double large, double modulus, double ball_radius) {
  const double ratio = axis_ratio(small, large), e = 2.0 * modulus, along = 0.5 / large;  // b/a, E', R_x
  auto [b, d] = elliptic_b_d(ratio);
  const double beta = 4.0 / M_PI * (b + ratio * ratio * d) / (1.0 + small / large);
  const double major = std::cbrt(3.0 * d / (M_PI * e * small));  // a/Q^(1/3)
  const double u = lubricant.viscosity / (e * along), g = lubricant.pressure_coefficient * e, w = 1.0 / (e * along * along);
  const double curved = 2.0 / (1.0 / ball_radius + (1.0 / ball_radius - 2.0 * small));  // R_d = 4 f r/(2 f + 1)
  const bool grease = lubricant.kind != LubricantKind::oil;
  const double flooded = std::log(2.0 * major * e * along);
  FilmNumbers found;
  found[RESISTANCE] = grease ? std::log(1.544 * e * along * along) + std::log(beta) / 3.0 - 0.577 * std::log(ratio) +
                                   0.656 * std::log(2.0 * u) + 0.466 * std::log(w) + 0.022 * std::log(g)
                             : flooded + std::log(0.77) - std::log(beta) / 3.0 + 0.12 * std::log(ratio) + 2.0 / 3.0 * std::log(2.0 * u);
  found[ELASTIC_RESISTANCE] = flooded + std::log(1.8) - 0.25 * std::log(beta) + 0.75 * std::log(2.0 * u);
  found[ELASTIC_SHARE] = 0.25 * std::log(beta) + std::log(ratio) + std::log(w) - 0.75 * std::log(2.0 * u) - std::log(6.6);
  found[THICKNESS] = std::log(2.69 * along * (1.0 - 0.61 * std::exp(-0.73 / ratio))) + 0.67 * std::log(u) + 0.53 * std::log(g) -
                     0.067 * std::log(w);
  found[HYSTERESIS] = std::log(7.48e-7 * std::pow(ball_radius, 0.33) * std::max(1.0 - 3.519e-3 * std::pow(std::max(large / small - 1.0, 0.0), 0.8063), 1e-6));
  found[DIFFERENTIAL_SLIP] = std::log(HEATHCOTE * major * major / curved);
  return found;
}

// At a contact whose numbers may have any type; `load` and `speed` are logarithms, of Q and of `rolling` u, above zero.
// The logarithm of the thickness [m].
template <class N, class Q, class U>
CORE_INLINE auto film_thickness(const N &numbers, const Q &load, const U &speed) {
  return numbers[THICKNESS] + 0.67 * speed - 0.067 * load;
}
// F [N].
template <class N, class Q, class U>
CORE_INLINE auto film_resistance(const Lubricant &lubricant, const N &numbers, const Q &load, const U &speed, const U &rolling) {
  auto inlet = 1.0 / (1.0 + lubricant.heating * exponential(1.28 * speed));
  if (lubricant.kind == LubricantKind::grease)
    return inlet * exponential(numbers[RESISTANCE] + 0.656 * speed + 0.466 * load - lubricant.starvation * rolling);
  auto rigid = exponential(numbers[RESISTANCE] + (2.0 / 3.0) * speed + (1.0 / 3.0) * load);
  auto elastic = exponential(numbers[ELASTIC_RESISTANCE] + 0.75 * speed + (1.0 / 3.0) * load);
  return inlet * ((rigid - elastic) / (1.0 + exponential(numbers[ELASTIC_SHARE] + load - 0.75 * speed)) + elastic);
}
template <class N, class Q>
CORE_INLINE auto hysteresis_moment(const N &numbers, const Q &load) { return exponential(numbers[HYSTERESIS] + 1.33 * load); }
// For a coefficient of friction of 1.
template <class N, class Q>
CORE_INLINE auto slip_moment(const N &numbers, const Q &load) { return exponential(numbers[DIFFERENTIAL_SLIP] + (5.0 / 3.0) * load); }
// Coefficient of friction at a logarithm of thickness over roughness; 1 - exp(-1.8 Lambda^1.2) of the load is on the film.
template <class X>
CORE_INLINE auto mixed_friction(const Lubricant &lubricant, const X &ratio) {
  auto touching = exponential(-1.8 * exponential(1.2 * ratio));
  return lubricant.film_friction + (lubricant.boundary_friction - lubricant.film_friction) * touching;
}

}  // namespace core
