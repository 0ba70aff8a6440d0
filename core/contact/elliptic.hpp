// Complete elliptic integrals without cancellation near the circle.
#pragma once
#include "../math/dual.hpp"

namespace core {

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

}  // namespace core
