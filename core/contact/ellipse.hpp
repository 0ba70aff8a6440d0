// Complete elliptic integrals, and the ellipse of a Hertz contact by the curvatures of the gap.
#pragma once
#include <algorithm>
#include "../math/dual.hpp"

namespace core {

// Complete elliptic integrals without cancellation near the circle.

// B(m) = int cos^2 / sqrt(1 - m sin^2) and D(m) = int sin^2 / sqrt(1 - m sin^2) over (0, pi/2), as functions of
// kc = sqrt(1 - m) in (0, 1]: K = B + D, E = B + (1 - m) D. Bulirsch's iteration (Numer. Math. 7, 1965) for both at
// once, until all lanes have converged; derivatives by the same arithmetic.
template <Number X>
inline auto elliptic_b_d(const X &complementary) {
  X kc = complementary, product = kc, mean = kc * 0.0 + 1.0, p = mean;
  X a_b = mean, b_b = kc * 0.0, a_d = b_b, b_d = mean;
  for (int iteration = 0; iteration < 60; iteration++) {
    X g = product / p;
    X next_a_b = a_b + b_b / p, next_b_b = 2.0 * (b_b + a_b * g);
    X next_a_d = a_d + b_d / p, next_b_d = 2.0 * (b_d + a_d * g);
    a_b = next_a_b, b_b = next_b_b, a_d = next_a_d, b_d = next_b_d;
    p = p + g;
    X last = mean;
    mean = mean + kc;
    if (!any(absolute(value_of(last) - value_of(kc)) > 1e-8 * value_of(last))) break;
    kc = 2.0 * square_root(product);
    product = kc * mean;
  }
  X scale = 1.5707963267948966 / (mean * (mean + p));
  return std::pair{scale * (b_b + a_b * mean), scale * (b_d + a_d * mean)};
}

// From the curvatures of the gap to the ellipse of a Hertz contact, without cancellation near the circle. The gap of the
// undeformed bodies is z = P x^2 + Q y^2 with P = `small` <= Q = `large` [1/m] (paper 1, eq. 6).

constexpr int MAX_RATIO_STEPS = 60;
constexpr double CONVERGED_STEP = 1e-8;  // of ln(b/a): the error after a smaller Newton step is below rounding

// Semi-axis ratio b/a in (0, 1] of contact ellipses, the root of paper 1, eq. (8). ln(Q/P) is a smooth, monotone, nearly
// straight function of x = ln(b/a), so that Newton's method converges from b/a = (P/Q)^0.64 in a few steps. With k = b/a
// and t = (k^2 D - B)/(1 - k^2) its slope is -3 - t (1/B + 1/D). NaN where the curvatures are not 0 < P <= Q.
inline double axis_ratio(double small, double large) {
  if (!(small > 0.0 && large >= small)) return NAN;
  double target = std::log(large / small), x = -0.64 * target;
  if (target < 1e-13) return 1.0;
  for (int i = 0; i < MAX_RATIO_STEPS; i++) {
    double k = std::exp(x);
    auto [b, d] = elliptic_b_d(k);
    double residual = std::log(b / (k * k * d)) - target, m = (1.0 - k) * (1.0 + k);
    // Near a circle the difference cancels; its limit holds within m.
    double t = m > 1e-6 ? (k * k * d - b) / m : -3.0 * M_PI / 16.0;
    double next = std::min(std::max(x + residual / (3.0 + t * (1.0 / b + 1.0 / d)), -target), 0.0);
    bool last = std::fabs(next - x) <= CONVERGED_STEP;
    x = next;
    if (last) break;
  }
  return std::exp(x);
}

// c [N/m^1.5] of the Hertz load c h^1.5 from the integrals K and D (Hertz 1882; paper 1, eqs. 7 and 8), for a circle
// 4/3 E* sqrt(R): c = (2 pi/3) E* K^(-3/2) sqrt(D/P).
inline double coefficient_of_integrals(double k, double d, double small, double modulus) {
  return (2.0 * M_PI / 3.0) * modulus * std::sqrt(d / (small * k * k * k));
}

struct Ellipse {
  double semi_major, semi_minor, peak_pressure;
};

// a^3 = 3 F D / (2 pi E* P (b/a)), peak pressure 3 F/(2 pi a b); all zero without load. One contact at a time: side by
// side, the number of iterations, and with it the last bit, would depend on the others.
inline Ellipse ellipse(double small, double large, double modulus, double load) {
  if (!(load > 0.0)) return {0.0, 0.0, 0.0};
  double ratio = axis_ratio(small, large), d = elliptic_b_d(ratio).second;
  double major = std::cbrt(1.5 * load * d / (M_PI * modulus * small)), minor = major * ratio;
  return {major, minor, 1.5 * load / (M_PI * major * minor)};
}

// Hertz's law whose elliptic integrals are carried along as states (paper 1, section 3). While the curvatures of a contact
// change smoothly, K(m), E(m) and the root m = 1 - (b/a)^2 of equation (8) can be integrated instead of solved for. The
// integration is only neutrally stable, so errors grow; `projected` corrects them by one Newton step on (8).

enum class CarriedLaw { none, projected, unprojected };

struct EllipseShape {
  double parameter, first_kind, second_kind;
};  // m, K(m), E(m)

namespace carried {

constexpr double SERIES_BELOW = 0.05;  // m: the differential equations of K and E are 0/0 at the circle
constexpr int SERIES_TERMS = 16;
constexpr double GREATEST_PARAMETER = 1.0 - 1e-15;
constexpr double SOLVE_ABOVE = 0.98;  // C = P/Q above which states are solved for: C has a kink at 1

inline EllipseShape shape_at(double ratio) {
  double k = axis_ratio(ratio, 1.0);
  auto [b, d] = elliptic_b_d(k);
  return {(1.0 - k) * (1.0 + k), b + d, b + k * k * d};
}

// dK/dm = (E - (1-m) K)/(2 m (1-m)), d2K/dm2 by Legendre's equation; near zero both by the power series.
inline std::pair<double, double> first_kind_slopes(const EllipseShape &shape) {
  double m = shape.parameter;
  if (m >= SERIES_BELOW) {
    double product = m * (1.0 - m), first = (shape.second_kind - (1.0 - m) * shape.first_kind) / (2.0 * product);
    return {first, (0.25 * shape.first_kind - (1.0 - 2.0 * m) * first) / product};
  }
  double first = 0.0, second = 0.0, factor = 0.5 * M_PI, power = 1.0, previous = 0.0, before_previous = 0.0;
  for (int n = 0; n < SERIES_TERMS; n++) {
    first += n * factor * previous, second += n * (n - 1) * factor * before_previous;
    before_previous = previous, previous = power, power *= m;
    double next = (2.0 * n + 1.0) / (2.0 * n + 2.0);
    factor *= next * next;
  }
  return {first, second};
}

// Derivatives of the states by C = P/Q (paper 1, after Theorem 1): (3/2 K'^2 - 1/2 K K'') dm/dC = K'^2, dK/dm = K',
// dE/dm = (E - K)/(2m).
inline EllipseShape slopes(const EllipseShape &shape) {
  auto [first, second] = first_kind_slopes(shape);
  double m = shape.parameter, rate = first * first / (1.5 * first * first - 0.5 * shape.first_kind * second);
  double by_parameter =
      m < SERIES_BELOW ? (1.0 - m) * first - 0.5 * shape.first_kind : (shape.second_kind - shape.first_kind) / (2.0 * m);
  return {rate, first * rate, by_parameter * rate};
}

inline EllipseShape plus(const EllipseShape &shape, double factor, const EllipseShape &slope) {
  return {shape.parameter + factor * slope.parameter, shape.first_kind + factor * slope.first_kind,
          shape.second_kind + factor * slope.second_kind};
}

// The states after C has changed, by one step of the classical Runge-Kutta method.
inline EllipseShape moved(const EllipseShape &shape, double change) {
  EllipseShape k1 = slopes(shape), k2 = slopes(plus(shape, 0.5 * change, k1));
  EllipseShape k3 = slopes(plus(shape, 0.5 * change, k2)), k4 = slopes(plus(shape, change, k3));
  double sixth = change / 6.0;
  return plus(plus(plus(plus(shape, sixth, k1), 2.0 * sixth, k2), 2.0 * sixth, k3), sixth, k4);
}

// One Newton step on equation (8), K/(2K') - (1-m) = C, from the carried parameter; K and E are evaluated at its end.
inline EllipseShape projected(const EllipseShape &shape, double ratio) {
  struct Evaluation {
    EllipseShape shape;
    double b, d;
  };
  auto evaluate = [](double parameter) -> Evaluation {
    double m = std::fmin(std::fmax(parameter, 0.0), GREATEST_PARAMETER);
    std::pair<double, double> bd = elliptic_b_d(std::sqrt(1.0 - m));
    return {{m, bd.first + bd.second, bd.first + (1.0 - m) * bd.second}, bd.first, bd.second};
  };
  auto [current, b, d] = evaluate(shape.parameter);
  auto [first, second] = first_kind_slopes(current);
  double slope = 1.5 - 0.5 * current.first_kind * second / (first * first), m = current.parameter;
  return evaluate(m - ((1.0 - m) * d / b - ratio) / slope).shape;
}

// D = (K - E)/m.
inline double d_of(const EllipseShape &shape) {
  double m = shape.parameter;
  if (m < SERIES_BELOW) return shape.first_kind - 2.0 * (1.0 - m) * first_kind_slopes(shape).first;
  return (shape.first_kind - shape.second_kind) / m;
}

}  // namespace carried

// Carried states of a contact: C = P/Q at the start of the step, 0 for none yet, and the states there.
struct CarriedContact {
  double ratio;
  EllipseShape shape;

  EllipseShape shape_for(double new_ratio) const {
    return ratio == 0.0 ? carried::shape_at(new_ratio) : carried::moved(shape, new_ratio - ratio);
  }

  // Advances to the end of a step at this ratio.
  void advance(CarriedLaw law, double new_ratio) {
    shape = shape_for(new_ratio);
    if (law == CarriedLaw::projected)
      shape = new_ratio > carried::SOLVE_ABOVE ? carried::shape_at(new_ratio) : carried::projected(shape, new_ratio);
    ratio = new_ratio;
  }
};

// c [N/m^1.5] and its derivative by Q at constant P, from d ln(c)/dQ = -(1 - D/K)/(2 Q).
inline std::pair<double, double> coefficient_and_slope(const CarriedContact &contact, double small, double large, double modulus) {
  EllipseShape shape = contact.shape_for(small / large);
  double k = shape.first_kind, d = carried::d_of(shape);
  double coefficient = coefficient_of_integrals(k, d, small, modulus);
  return {coefficient, coefficient * (-0.5 * (1.0 - d / k) / large)};
}

}  // namespace core
