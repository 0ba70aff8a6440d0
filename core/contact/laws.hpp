// The normal load of contacts: elastic laws and the viscous part.
#pragma once
#include <algorithm>
#include "../math/dual.hpp"
#include "ellipse.hpp"

namespace core {

// Elastic laws of point contacts, whose load is c h^p at an approach h [m] > 0, and of line contacts. They are
// chosen at run time by their number in the table `bearing_twin/contact/laws.py`; they differ in where c comes from. The gap
// of the undeformed bodies is z = P x^2 + Q y^2 with P = `small` <= Q = `large` [1/m], the modulus E* is in Pa.

enum class PointLaw { hertz, hertz_exact, volumetric, given, carried, carried_left };  // as in laws.py

constexpr double HERTZIAN = 1.5;  // power of a point contact between smooth curved bodies
constexpr double LEAST_DEPTH = 1e-12;  // m: derivatives of a root no nearer to the onset of a contact than this

// The root h^(1/2) of the depth, whose slope is bounded where a contact starts.
template <Number X>
CORE_INLINE auto root_of_depth(const X &depth) {
  return with_slope(depth, square_root(value_of(depth)), [&] { return 0.5 / square_root(maximum(value_of(depth), LEAST_DEPTH)); });
}
[[gnu::noinline]] inline double power_of(double x, double power) { return std::pow(x, power); }
[[gnu::noinline]] inline Pack power_of(const Pack &x, double power) {
  return each_lane(x, [=](double depth) { return std::pow(depth, power); });
}

// h^(p - 1) of a depth h >= 0.
template <Number X>
CORE_INLINE auto depth_factor(double power, const X &depth) {
  using T = ValueOf<X>;
  if (power == HERTZIAN) return root_of_depth(depth);
  if (power == 1.0) return with_slope(depth, select(value_of(depth) > 0.0, broadcast<T>(1.0), T{}), [] { return T{}; });
  return with_slope(depth, power_of(value_of(depth), power - 1.0),
                    [&] { return (power - 1.0) * power_of(maximum(value_of(depth), LEAST_DEPTH), power - 2.0); });
}

// Response to an approach, zero for a gap: load [N], stiffness d(load)/dh [N/m] and stored energy [J], the integral of
// the load at constant coefficient (paper 1, section 4).
template <class L, class S, class E>
struct Elastic {
  L load;
  S stiffness;
  E energy;
};
template <class L, class S, class E>
Elastic(L, S, E) -> Elastic<L, S, E>;

template <class L, class D>
CORE_INLINE auto elastic_energy(double power, const L &load, const D &depth) {
  return 1.0 / (power + 1.0) * load * depth;
}
template <Number C, Number X>
CORE_INLINE auto elastic(const C &coefficient, double power, const X &approach) {
  auto depth = maximum(approach, 0.0);
  auto factor = depth_factor(power, depth);
  auto load = coefficient * depth * factor;
  return Elastic{load, power * coefficient * factor, elastic_energy(power, load, depth)};
}

// The approach at a load [N], and that at which the energy of masses [kg] that meet at this speed [m/s] is stored.
inline double approach_of_load(double coefficient, double power, double load) { return std::pow(load / coefficient, 1.0 / power); }
inline double greatest_approach(double coefficient, double power, double mass, double speed) {
  return std::pow(0.5 * (power + 1.0) * mass * speed * speed / coefficient, 1.0 / (power + 1.0));
}

// c [N/m^1.5] of exact Hertz, differentiated by the curvatures in closed form: d ln(c)/dQ = -(1 - D/K)/(2 Q), and c falls
// with the root of both.
template <Number P, Number Q>
inline auto hertz_exact(const P &small, const Q &large, double modulus) {
  double p = value_of(small), q = value_of(large);
  auto [b, d] = elliptic_b_d(axis_ratio(p, q));
  double k = b + d, coefficient = coefficient_of_integrals(k, d, p, modulus);
  if constexpr ((columns_of<P> | columns_of<Q>) == 0) return coefficient;
  else {
    Dual<3, double> with_slopes{coefficient, {-0.5 * coefficient * (d / k) / p, -0.5 * coefficient * (b / k) / q}};
    return composed(with_slopes, small, large);
  }
}

// The same by a rational function, within 1e-10 for b/a >= 0.01 (`tests/reference/fit_hertz.py`). The coefficient is even in
// ln(P/Q), hence a smooth function of u = (P + Q - 2 g)/(P + Q + 2 g), g = sqrt(PQ): 0 for a circle, towards 1 for a line.
template <Number P, Number Q>
inline auto hertz(const P &small, const Q &large, double modulus) {
  constexpr double NUMERATOR[8] = {0.9428090415108946,  -2.2748176815803363, 0.9378562259855627,  1.6040560661961734,
                                   -1.5922300284502826, 0.33038099553435757, 0.07054558921003161, -0.018492343366157776};
  constexpr double DENOMINATOR[8] = {1.0,
                                     -2.7461418617107927,
                                     1.7064242073744869,
                                     1.5252752099605271,
                                     -2.226158010720357,
                                     0.7560290750065166,
                                     0.01298585635130083,
                                     -0.028403177407893734};
  constexpr double LAST = 0.9144848400609057;
  auto g = square_root(small * large), total = small + large;
  auto u = (total - 2.0 * g) / (total + 2.0 * g);
  if (!(value_of(u) <= LAST)) return hertz_exact(small, large, modulus);
  auto polynomial = [&](const double(&term)[8]) {
    auto sum = u * term[7] + term[6];
    for (int i = 5; i >= 0; i--) sum = sum * u + term[i];
    return sum;
  };
  return modulus * (polynomial(NUMERATOR) / (polynomial(DENOMINATOR) * square_root(g)));
}

// c [N/m^1.5] of the volumetric law, paper 1, eq. (9) with the square root over E(c1) restored:
// c = 0.357469 (2/3) sqrt(E(c1)) / ((thetaA + thetaB) P^(3/8) Q^(1/8)), c1 = 1 - P/Q, thetaA + thetaB = 1/(pi E*).
// Against exact Hertz: -0.48 % for a circle, +0.46 % at b/a = 0.14, -0.8 % at 0.055, -6.7 % at 0.015 and falling.
template <Number P, Number Q>
inline auto volumetric(const P &small, const Q &large, double modulus) {
  auto kc = square_root(small / large);
  auto [b, d] = elliptic_b_d(kc);
  auto g = square_root(small * large);  // P^(3/8) Q^(1/8) = g^(1/4) P^(1/4)
  return (0.357469 * (2.0 / 3.0) * M_PI * modulus) * square_root(b + kc * kc * d) / square_root(square_root(g * small));
}

// A law of a point contact in use. `given`: the number that laws are given which follow no curvatures.
struct Elasticity {
  PointLaw law;
  double power, modulus, given;
};

CORE_INLINE bool follows_curvatures(PointLaw law) { return law != PointLaw::given; }
CORE_INLINE CarriedLaw carried_law(PointLaw law) {
  return law == PointLaw::carried        ? CarriedLaw::projected
         : law == PointLaw::carried_left ? CarriedLaw::unprojected
                                         : CarriedLaw::none;
}
CORE_INLINE bool carries_states(PointLaw law) { return carried_law(law) != CarriedLaw::none; }

// c [N/m^p] of a law where the gap has these curvatures; `shape` are the states of a law that carries any.
template <Number P, Number Q>
inline auto law_coefficient(const Elasticity &law, const P &small, const Q &large, const EllipseShape &shape = {}) {
  using X = decltype(hertz_exact(small, large, 1.0));
  switch (law.law) {
    case PointLaw::hertz: return hertz(small, large, law.modulus);
    case PointLaw::hertz_exact: return hertz_exact(small, large, law.modulus);
    case PointLaw::volumetric: return volumetric(small, large, law.modulus);
    case PointLaw::given: return X(widened<columns_of<X>>(law.given));
    default: {
      double p = value_of(small), q = value_of(large), k = shape.first_kind, d = carried::d_of(shape);
      double coefficient = coefficient_of_integrals(k, d, p, law.modulus);
      Dual<3, double> with_slopes{coefficient, {-0.5 * coefficient * (d / k) / p, -0.5 * coefficient * (1.0 - d / k) / q}};
      if constexpr (columns_of<X> == 0) return coefficient;
      else return composed(with_slopes, small, large);
    }
  }
}

// c [N/m^p] of a law; states, if any, are solved for.
inline double fresh_coefficient(const Elasticity &law, double small, double large) {
  return law_coefficient(law, small, large, carries_states(law.law) ? carried::shape_at(small / large) : EllipseShape{});
}

// c [N/m^p] of a law and d ln(c)/d(shape) at constant sqrt(PQ), shape = (P + Q)/(2 sqrt(PQ)) = sqrt(1 + excess^2), `excess` = 0
// for a circle. With ln(Q/P) = 2 arcosh(shape) it is (Q dc/dQ - P dc/dP)/(c excess); near a circle it is that of the circle.
struct CoefficientAndSlope {
  double coefficient, log_slope;
};
inline CoefficientAndSlope coefficient_and_log_slope(const Elasticity &law, double small, double large, double excess,
                                                     const EllipseShape &shape = {}) {
  constexpr double ROUND = 1e-3;
  if (!follows_curvatures(law.law)) return {law.given, 0.0};
  if (excess < ROUND) return {law_coefficient(law, small, large, shape), 1.0 / 6.0};
  auto c = law_coefficient(law, variable<0>(small), variable<1>(large), shape);
  return {c.value, (large * c.slope[1] - small * c.slope[0]) / (c.value * excess)};
}

// The line contact of two equal cylinders side by side, half their thickness a [m] and V = (1 - nu^2)/(pi E) [1/Pa]:
//   x = (F V/a) [ln(B/(F V)) + s],  `scale` = B e^s [m^2].  line: paper 3, eq. (14), after Puttock and Thwaite, B = 8 a^3/r,
// s = 1; johnson: Johnson, Contact Mechanics, section 5.6, plane strain, B = 8 a r, s = -1.
enum class LineLaw { puttock, johnson };  // as in laws.py
struct LineContact {
  double scale, compliance, half_thickness;
};

inline double line_scale(LineLaw law, double radius, double half) {
  return law == LineLaw::puttock ? 8.0 * half * half * half / radius * M_E : 8.0 * half * radius / M_E;
}

// Branch -1 of Lambert's function, w exp(w) = x with w <= -1, for -1/e <= x < 0; NaN elsewhere, -inf at 0. The series in
// p = -sqrt(2 (1 + e x)) near the branch point, logarithms near zero, then Newton's steps.
inline double lambert_lower(double x) {
  if (x == 0.0) return -INFINITY;
  double below = 1.0 + M_E * x, w;
  if (!(below >= -4e-16 && x < 0.0)) return NAN;
  if (below <= 0.0) return -1.0;
  if (below < 0.3) {
    double p = -std::sqrt(2.0 * below);
    w = -1.0 + p * (1.0 + p * (-1.0 / 3.0 + p * (11.0 / 72.0 + p * (-43.0 / 540.0 + p * 769.0 / 17280.0))));
    if (below < 1e-6) return w;
  } else {
    double first = std::log(-x), second = std::log(-first);
    w = first - second + second / first;
  }
  for (int i = 0; i < 8; i++) {
    // w + ln(w/x) = 0 keeps its digits where exp(w) is tiny; Newton's step on it converges from both sides.
    double step = (w + std::log(w / x)) * w / (w + 1.0);
    w -= step;
    if (std::fabs(step) < 4e-16 * std::fabs(w)) break;
  }
  return w;
}

// Response of a line contact to an approach [m]; a load of NaN beyond the greatest approach, scale/(e a), for which one
// exists. With y = F V/scale the law reads x a/scale = -y ln(y), whose branch of small loads is y = exp(W(-x a/scale)).
inline Elastic<double, double, double> line_elastic(const LineContact &line, double approach) {
  if (approach <= 0.0) return {0.0, 0.0, 0.0};
  double ratio = approach * line.half_thickness / line.scale;
  double product = -ratio / lambert_lower(-ratio) * line.scale, logarithm = std::log(line.scale / product);
  return {product / line.compliance, line.half_thickness / line.compliance / (logarithm - 1.0),
          product * product * (logarithm - 0.5) / (2.0 * line.half_thickness * line.compliance)};
}

// The viscous part d(h) dh/dt of the normal load, d(h) -> 0 as h -> 0 (paper 1, section 5), and the longest step in a contact.

// Normal load [N] of an elastic one with its stiffness [N/m] and a viscous part in proportion to both; below zero where the
// bodies would attract each other.
template <class L, class S, class R>
CORE_INLINE auto proportional_load(const L &load, const S &stiffness, const R &approach_rate, double damping,
                                   double relaxation_time) {
  return load + (damping * load + relaxation_time * stiffness) * approach_rate;
}

// proportional: d(h) = number * load + relaxation_time * stiffness. The first part is Hunt and Crossley's (1975), `number`
//     [s/m]: restitution falls with speed. The second is a viscoelastic half-space's (Brilliantov et al. 1996) [s]: the damping
//     proportional to stiffness that Kraemer (1993) gives for rolling bearings.
// steady: d(h) = number * h^((p - 1)/2), after Tsuji, Tanaka and Ishida (Powder Technology 71, 1992), in N s/m^(5/4) for
//     Hertz's power p = 1.5, in N s/m for a linear spring. In s = (2/sqrt 5) h^(5/4) it is a linear oscillator, so restitution
//     is the same at every speed.
// steady_ratio: the same by the damping ratio, `number` [1], of that oscillator.
enum class DampingLaw { proportional, steady, steady_ratio };

struct Damping {
  DampingLaw law;
  double number, relaxation_time;

  // Normal load [N] with the viscous part, below zero where the bodies would have to pull. The elastic contact has the
  // coefficient c [N/m^p], a load [N] and a stiffness d(load)/dh [N/m] at its approach [m], which changes at a rate [m/s];
  // `mass` [kg] is the reduced mass, m1 m2/(m1 + m2) in central impact.
  double pulling_load(double coefficient, double power, double elastic_load, double stiffness, double mass, double approach,
                      double approach_rate) const {
    double factor = number;
    switch (law) {
      case DampingLaw::proportional: return proportional_load(elastic_load, stiffness, approach_rate, number, relaxation_time);
      case DampingLaw::steady_ratio: factor *= std::sqrt(2.0 * (power + 1.0) * mass * coefficient); [[fallthrough]];
      case DampingLaw::steady: break;
    }
    double depth = std::max(approach, 0.0);
    double root = power == 1.5 ? std::sqrt(std::sqrt(depth)) : std::pow(depth, 0.5 * (power - 1.0));
    return elastic_load + factor * root * approach_rate;
  }
  // The same, zero in a gap and where it would be negative: the contact ends there, and the remaining elastic energy is lost.
  double load(double coefficient, double power, double elastic_load, double stiffness, double mass, double approach,
              double approach_rate) const {
    if (approach <= 0.0) return 0.0;
    return std::max(pulling_load(coefficient, power, elastic_load, stiffness, mass, approach, approach_rate), 0.0);
  }
};

// The longest step [s] in a contact of duration `lasted` [s] so far; `rate` [1/s] is sqrt(k/m) at the greatest expected stiffness.
// A bounce lasts 4/rate; in contacts beyond 20/rate error control determines the step.
inline double longest_contact_step(double lasted, double rate) { return (lasted * rate < 20.0 ? 1.0 / 6.0 : 2.0) / rate; }

}  // namespace core
