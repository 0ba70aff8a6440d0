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

constexpr int MOST_RATIO_STEPS = 60;
constexpr double SURE_STEP = 1e-8;  // of ln(b/a): after a Newton step that is no longer, less than rounding is left

// Semi-axis ratio b/a in (0, 1] of contact ellipses, the root of paper 1, eq. (8). ln(Q/P) is a smooth, monotone, nearly
// straight function of x = ln(b/a), so that Newton's method converges from b/a = (P/Q)^0.64 in a few steps. With k = b/a
// and t = (k^2 D - B)/(1 - k^2) its slope is -3 - t (1/B + 1/D). NaN where the curvatures are not 0 < P <= Q.
inline double axis_ratio(double small, double large) {
  if (!(small > 0.0 && large >= small)) return NAN;
  double target = std::log(large / small), x = -0.64 * target;
  if (target < 1e-13) return 1.0;
  for (int i = 0; i < MOST_RATIO_STEPS; i++) {
    double k = std::exp(x);
    auto [b, d] = elliptic_b_d(k);
    double off = std::log(b / (k * k * d)) - target, m = (1.0 - k) * (1.0 + k);
    // Near a circle the difference has no digits left; there it is what it tends to, within m.
    double t = m > 1e-6 ? (k * k * d - b) / m : -3.0 * M_PI / 16.0;
    double next = std::min(std::max(x + off / (3.0 + t * (1.0 / b + 1.0 / d)), -target), 0.0);
    bool last = std::fabs(next - x) <= SURE_STEP;
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

struct Ellipse { double semi_major, semi_minor, peak_pressure; };

// a^3 = 3 F D / (2 pi E* P (b/a)), peak pressure 3 F/(2 pi a b); all zero without load. One contact at a time: side by
// side, the number of iterations, and with it the last bit, would depend on the others.
inline Ellipse ellipse(double small, double large, double modulus, double load) {
  if (!(load > 0.0)) return {0.0, 0.0, 0.0};
  double ratio = axis_ratio(small, large), d = elliptic_b_d(ratio).second;
  double major = std::cbrt(1.5 * load * d / (M_PI * modulus * small)), minor = major * ratio;
  return {major, minor, 1.5 * load / (M_PI * major * minor)};
}

}  // namespace core
