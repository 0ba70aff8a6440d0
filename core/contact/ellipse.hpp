// From the curvatures of the gap to the ellipse of a Hertz contact, without cancellation near the circle. The gap of the
// undeformed bodies is z = P x^2 + Q y^2 with P = `small` <= Q = `large` [1/m] (paper 1, eq. 6).
#pragma once
#include "elliptic.hpp"

namespace core {

constexpr int MOST_RATIO_STEPS = 60;
constexpr double SURE_STEP = 1e-8;  // of ln(b/a): after a Newton step that is no longer, less than rounding is left

// Semi-axis ratio b/a in (0, 1] of contact ellipses, the root of paper 1, eq. (8). ln(Q/P) is a smooth, monotone, nearly
// straight function of x = ln(b/a), so that Newton's method converges from b/a = (P/Q)^0.64 in a few steps. With k = b/a
// and t = (k^2 D - B)/(1 - k^2) its slope is -3 - t (1/B + 1/D). NaN where the curvatures are not 0 < P <= Q.
inline Pack axis_ratio(const Pack &small, const Pack &large) {
  Mask legal = (small > 0.0) & (large >= small);
  Pack target = each_lane(select(legal, large / small, broadcast<Pack>(1.0)), [](double x) { return std::log(x); });
  Pack x = -0.64 * target, one = broadcast<Pack>(1.0);
  for (int i = 0; i < MOST_RATIO_STEPS; i++) {
    Pack k = each_lane(x, [](double one) { return std::exp(one); });
    auto [b, d] = elliptic_b_d(k);
    Pack off = each_lane(b / (k * k * d), [](double one) { return std::log(one); }) - target, m = (1.0 - k) * (1.0 + k);
    // Near a circle the difference has no digits left; there it is what it tends to, within m.
    Pack t = select(m > 1e-6, (k * k * d - b) / m, broadcast<Pack>(-3.0 * M_PI / 16.0));
    Pack next = minimum(maximum(x + off / (3.0 + t * (1.0 / b + 1.0 / d)), -target), 0.0 * x);
    bool last = !any(absolute(next - x) > SURE_STEP);
    x = next;
    if (last) break;
  }
  Pack ratio = each_lane(x, [](double one) { return std::exp(one); });
  return select(legal, select(target < 1e-13, one, ratio), broadcast<Pack>(NAN));
}

struct Ellipse { Pack semi_major, semi_minor, peak_pressure; };

// a^3 = 3 F D / (2 pi E* P (b/a)), peak pressure 3 F/(2 pi a b); all zero without load.
inline Ellipse ellipse(const Pack &small, const Pack &large, const Pack &modulus, const Pack &load) {
  Mask loaded = load > 0.0;
  Pack ratio = axis_ratio(small, large), d = elliptic_b_d(ratio).second;
  Pack major = each_lane(1.5 * load * d / (M_PI * modulus * small), [](double one) { return std::cbrt(one); });
  Pack minor = major * ratio;
  return {select(loaded, major, Pack{}), select(loaded, minor, Pack{}),
          select(loaded, 1.5 * load / (M_PI * major * minor), Pack{})};
}

}  // namespace core
