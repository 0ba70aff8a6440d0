// Coulomb friction in the contact plane, regularised by a speed v_s [m/s], at the contact point or over its patch; the
// film of a lubricant.
#pragma once
#include <array>
#include <tuple>
#include "ellipse.hpp"

namespace core {

// Coulomb friction over an elliptic contact patch that slides and spins (Contensou, Erismann), regularised by v_s.
//
// With Hertz's pressure p, the patch's semi-axes a (across the groove) and b (along it), slip (u, v) of its centre along
// them and spin w about its normal, the means over the pressure of the slip's direction
//     along = <(u - w y)/s>,  across = <(v + w x)/s>,  moment = <x (v + w x)/s - y (u - w y)/s>,
// s = sqrt((u - w y)^2 + (v + w x)^2 + v_s^2), give the force -mu N (along, across) and the torque -mu N moment.

enum class FrictionModel { point, quadrature, pade1, pade2 };

// A friction model in use. A quadrature sums `points` (x, y, share of the pressure) on the unit disc; where the rim's
// speed by spin, squared, over slip^2 + v_s^2 is below `easy`, twelve points are as accurate, and up to `hard` both are
// blended.
struct PatchFriction {
  FrictionModel model;
  double coefficient, easy, hard;
  int points;
  const double *point;
};

template <class X>
struct PatchMeans {
  X along, across, moment;
};

namespace patch {

constexpr double ROUND = 1.5;  // weight of the semi-minor axis in the rim's speed
// Position and weight of the points on the axes, and of the near and far ones on the diagonals: a rule for
// the pressure times a polynomial of degree 7 (Stroud and Secrest).
constexpr double ON_AXES[2] = {0.816496580927726, 9.0 / 140.0};
constexpr double NEAR[2] = {0.29670979404458075, 0.14365634107133865};
constexpr double FAR[2] = {0.6153291515804278, 0.04205794464294707};

// Of two points that lie opposite each other, with share/s as weight: the sum, the difference times x and times y, and
// the sum times r^2.
template <class A, class B, class M>
CORE_INLINE auto opposite(const A &x, const B &y, double share, const M &motion) {
  auto distance = x * x + y * y;
  auto middle = motion.square + motion.spin * motion.spin * distance;
  auto offset = 2.0 * motion.spin * (motion.slip_minor * x - motion.slip_major * y);
  auto first = root_and_inverse(maximum(middle + offset, 1e-300)).second;
  auto second = root_and_inverse(maximum(middle - offset, 1e-300)).second;
  auto sum = share * (first + second), difference = share * (first - second);
  return std::tuple{sum, x * difference, y * difference, distance * sum};
}

template <class S, class U, class V, class W>
struct Motion {
  S square;
  U slip_major;
  V slip_minor;
  W spin;
};
template <class S, class U, class V, class W>
Motion(S, U, V, W) -> Motion<S, U, V, W>;

template <class A, class B, class M>
CORE_INLINE auto twelve_points(const A &major, const B &minor, const M &motion) {
  auto x = ON_AXES[0] * major, y = ON_AXES[0] * minor;
  auto [a, a_x, a_y, a_2] = opposite(x, 0.0 * minor, ON_AXES[1], motion);
  auto [b, b_x, b_y, b_2] = opposite(0.0 * major, y, ON_AXES[1], motion);
  auto sum = a + b, by_x = a_x + b_x, by_y = a_y + b_y, by_square = a_2 + b_2;
  for (const double *diagonal : {NEAR, FAR})
    for (double side : {1.0, -1.0}) {
      auto [c, c_x, c_y, c_2] = opposite(diagonal[0] * major, side * diagonal[0] * minor, diagonal[1], motion);
      sum = sum + c, by_x = by_x + c_x, by_y = by_y + c_y, by_square = by_square + c_2;
    }
  return PatchMeans{motion.slip_major * sum - motion.spin * by_y, motion.slip_minor * sum + motion.spin * by_x,
                    motion.slip_minor * by_x - motion.slip_major * by_y + motion.spin * by_square};
}

template <class R, class A, class B, class U, class V, class W>
inline PatchMeans<R> all_points(const PatchFriction &friction, double smooth, const A &major, const B &minor, const U &u,
                                const V &v, const W &spin) {
  R along{}, across{}, moment{};
  for (const double *point = friction.point; point < friction.point + 3 * friction.points; point += 3) {
    auto x = point[0] * major, y = point[1] * minor;
    auto slip_u = u - spin * y, slip_v = v + spin * x;
    auto square = maximum(slip_u * slip_u + slip_v * slip_v + smooth, 1e-300);
    auto factor = point[2] * root_and_inverse(square).second;
    auto part_u = factor * slip_u, part_v = factor * slip_v;
    along = along + part_u, across = across + part_v, moment = moment + (x * part_v - y * part_u);
  }
  return {along, across, moment};
}

// Twelve points below `easy`, all points above `hard`, and a smooth blend in between.
template <class A, class B, class U, class V, class W>
inline auto by_quadrature(const PatchFriction &friction, double smooth, const A &major, const B &minor, const U &u, const V &v,
                          const W &spin) {
  auto square = u * u + v * v + smooth;
  auto rim = spin * spin * (major * major + ROUND * (minor * minor));
  auto transition = (rim - friction.easy * square) / ((friction.hard - friction.easy) * maximum(square, 1e-300));
  transition = minimum(maximum(transition, 0.0), 1.0);
  auto part = transition * transition * (3.0 - 2.0 * transition), complement = 1.0 - part;
  auto twelve = twelve_points(major, minor, Motion{square, u, v, spin});
  auto along = complement * twelve.along, across = complement * twelve.across, moment = complement * twelve.moment;
  using R = decltype(along);
  if (any(value_of(part) > 0.0)) {
    auto full = all_points<R>(friction, smooth, major, minor, u, v, spin);
    along = along + part * full.along, across = across + part * full.across, moment = moment + part * full.moment;
  }
  return PatchMeans<R>{along, across, moment};
}

// end x (x + c)/(x (x + c) + bend): end (1 - bend/x^2) far out, slope x near zero.
template <class X, class S, class E, class B>
CORE_INLINE auto quotient(const X &x, const E &end, const S &slope, const B &bend) {
  auto shifted = x * (x + slope * bend / end);
  return end * shifted / (shifted + bend);
}

// Closed forms by quotients of first degree (Zhuravlev 1998) and of second degree (Kireenkov 2008).
template <class A, class B, class U, class V, class W>
inline auto by_closed_form(FrictionModel model, double smooth, const A &major, const B &minor, const U &u, const V &v,
                           const W &spin) {
  using T = ValueOf<A>;
  constexpr unsigned columns = columns_of<A> | columns_of<B> | columns_of<U> | columns_of<V> | columns_of<W>;
  auto ratio = minor / major;
  auto [b, d] = elliptic_b_d(ratio);
  auto ratio_square = ratio * ratio;
  auto share = u * u / maximum(u * u + v * v, 1e-300);
  auto pure = 0.375 * (b + ratio_square * d), width = 0.2 * (share + ratio_square * (1.0 - share));
  auto turning = maximum(absolute(spin) * major, 1e-300);
  auto speed = square_root(u * u + v * v + smooth);
  auto sign = select(value_of(spin) >= 0.0, broadcast<T>(1.0), broadcast<T>(-1.0));
  auto all = [&](const auto &along, const auto &across, const auto &moment) {
    using R = decltype(widened<columns>(along));
    return PatchMeans<R>{widened<columns>(along), widened<columns>(across), widened<columns>(moment)};
  };
  if (model == FrictionModel::pade1)
    return all(u / (speed + turning / (1.5 * d)), v / (speed + turning / (1.5 * b)),
               sign * (major * (turning / (turning / pure + speed / width))));
  auto x = speed / maximum(turning, 1e-9 * value_of(speed));
  auto unit = ratio * 0.0 + 1.0;
  auto along = quotient(x, unit, 1.5 * d, unit * 0.1), across = quotient(x, unit, 1.5 * b, 0.1 * ratio_square);
  auto torque = quotient(1.0 / x, pure, width, 0.75 * (share * d + (1.0 - share) * b) / pure);
  return all(along * u / speed, across * v / speed, sign * (major * torque));
}

template <class A, class B, class U, class V, class W>
inline auto means_of(const PatchFriction &friction, double smooth, const A &major, const B &minor, const U &u, const V &v,
                     const W &spin) {
  if (friction.model == FrictionModel::quadrature) return by_quadrature(friction, smooth, major, minor, u, v, spin);
  return by_closed_form(friction.model, smooth, major, minor, u, v, spin);
}

}  // namespace patch

// The means for semi-axes [m], slip [m/s] and spin [rad/s] of any type, `regularisation` v_s [m/s]. They are
// differentiated by these five numbers, and then by the chain rule.
template <class A, class B, class U, class V, class W>
CORE_INLINE auto patch_means(const PatchFriction &friction, double regularisation, const A &major, const B &minor, const U &u,
                             const V &v, const W &spin) {
  double smooth = regularisation * regularisation;
  if constexpr ((columns_of<A> | columns_of<B> | columns_of<U> | columns_of<V> | columns_of<W>) == 0)
    return patch::means_of(friction, smooth, major, minor, u, v, spin);
  else {
    auto means = patch::means_of(friction, smooth, variable<0>(value_of(major)), variable<1>(value_of(minor)),
                                 variable<2>(value_of(u)), variable<3>(value_of(v)), variable<4>(value_of(spin)));
    auto chain = [&](const auto &y) __attribute__((always_inline)) { return composed(y, major, minor, u, v, spin); };
    return PatchMeans{chain(means.along), chain(means.across), chain(means.moment)};
  }
}

// Coulomb friction in the contact plane, regularised by a speed v_s [m/s], at the contact point or over its patch.

// Resistance f [N s/m] of the force -f * slip at a point, where `square` is slip^2: f = mu N/sqrt(slip^2 + v_s^2). The force
// grows linearly with slip, reaches 71 % of mu N at v_s, and mu N far above it; true sticking creeps.
template <class L, class S>
CORE_INLINE auto point_resistance(const L &limit, const S &square, double regularisation) {
  auto smooth = square + regularisation * regularisation;
  return limit * root_and_inverse(smooth).second;
}

// From its numbers as `contact/friction.py` writes them, and the points of its quadrature (points, 3), x, y and weight.
constexpr int FRICTION_NUMBERS = 5;
inline PatchFriction patch_friction_of(const double *numbers, const double *points) {
  return {FrictionModel(int(numbers[0])), numbers[1], numbers[2], numbers[3], int(numbers[4]), points};
}

// Friction on the slipping body along the patch's axes [N], and about the normal [N m].
struct PatchForce {
  double force_major, force_minor, torque;
};

// By a model, for the semi-axes [m] of the patch, slip [m/s] along them and spin [rad/s] about the normal.
inline PatchForce contact_friction(const PatchFriction &friction, double regularisation, double normal_load, double semi_major,
                                   double semi_minor, double slip_major, double slip_minor, double spin) {
  double limit = -friction.coefficient * normal_load;
  if (!(normal_load > 0.0)) return {0.0, 0.0, 0.0};
  if (friction.model == FrictionModel::point) {
    double resistance = point_resistance(limit, slip_major * slip_major + slip_minor * slip_minor + 1e-300, regularisation);
    return {resistance * slip_major, resistance * slip_minor, 0.0};
  }
  auto [along, across, moment] = patch_means(friction, regularisation, semi_major, semi_minor, slip_major, slip_minor, spin);
  return {limit * along, limit * across, limit * moment};
}

// The lubricant's film in an elliptic contact that rolls at the speed u [m/s] under the load Q [N], and the other rolling
// resistances; steady and isothermal. Of equal bodies E' = E/(1 - nu^2), R_x and R_y are the radii of the gap along
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

enum class LubricantKind { none, grease, oil };

// `heating` is c [(s/m)^1.28], `starvation` s [s/m]; coefficients of friction where surfaces touch and on a whole film.
struct Lubricant {
  LubricantKind kind;
  double viscosity = 0.0, pressure_coefficient = 0.0, log_roughness = 0.0;  // [Pa s], [1/Pa], of metres
  double boundary_friction = 0.0, film_friction = 0.0, heating = 0.0, starvation = 0.0;
  bool works() const { return kind != LubricantKind::none; }
};
// From its numbers in this order.
constexpr int LUBRICANT_NUMBERS = 8;
inline Lubricant lubricant_of(const double *n) { return {LubricantKind(int(n[0])), n[1], n[2], n[3], n[4], n[5], n[6], n[7]}; }

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
  FilmNumbers numbers;
  numbers[RESISTANCE] =
      grease ? std::log(1.544 * e * along * along) + std::log(beta) / 3.0 - 0.577 * std::log(ratio) + 0.656 * std::log(2.0 * u) +
                   0.466 * std::log(w) + 0.022 * std::log(g)
             : flooded + std::log(0.77) - std::log(beta) / 3.0 + 0.12 * std::log(ratio) + 2.0 / 3.0 * std::log(2.0 * u);
  numbers[ELASTIC_RESISTANCE] = flooded + std::log(1.8) - 0.25 * std::log(beta) + 0.75 * std::log(2.0 * u);
  numbers[ELASTIC_SHARE] = 0.25 * std::log(beta) + std::log(ratio) + std::log(w) - 0.75 * std::log(2.0 * u) - std::log(6.6);
  numbers[THICKNESS] = std::log(2.69 * along * (1.0 - 0.61 * std::exp(-0.73 / ratio))) + 0.67 * std::log(u) + 0.53 * std::log(g) -
                       0.067 * std::log(w);
  numbers[HYSTERESIS] = std::log(7.48e-7 * std::pow(ball_radius, 0.33) *
                                 std::max(1.0 - 3.519e-3 * std::pow(std::max(large / small - 1.0, 0.0), 0.8063), 1e-6));
  numbers[DIFFERENTIAL_SLIP] = std::log(HEATHCOTE * major * major / curved);
  return numbers;
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
CORE_INLINE auto hysteresis_moment(const N &numbers, const Q &load) {
  return exponential(numbers[HYSTERESIS] + 1.33 * load);
}
// For a coefficient of friction of 1.
template <class N, class Q>
CORE_INLINE auto slip_moment(const N &numbers, const Q &load) {
  return exponential(numbers[DIFFERENTIAL_SLIP] + (5.0 / 3.0) * load);
}
// Coefficient of friction at a logarithm of thickness over roughness; 1 - exp(-1.8 Lambda^1.2) of the load is on the film.
template <class X>
CORE_INLINE auto mixed_friction(const Lubricant &lubricant, const X &ratio) {
  auto touching = exponential(-1.8 * exponential(1.2 * ratio));
  return lubricant.film_friction + (lubricant.boundary_friction - lubricant.film_friction) * touching;
}

}  // namespace core
