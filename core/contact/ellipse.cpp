// The door to contact ellipses; arrays are C-contiguous doubles.
#include "../door.hpp"
#include <tuple>
#include "ellipse.hpp"

using namespace core;

// Semi-axes [m] and peak pressures [Pa] of contacts with these curvatures [1/m], effective moduli [Pa] and loads [N].
CORE_EXPORT void core_ellipses(std::int64_t count, const double *small, const double *large, const double *modulus,
                               const double *load, double *semi_major, double *semi_minor, double *peak_pressure) {
  for (std::int64_t i = 0; i < count; i++) {
    Ellipse found = ellipse(small[i], large[i], modulus[i], load[i]);
    semi_major[i] = found.semi_major, semi_minor[i] = found.semi_minor, peak_pressure[i] = found.peak_pressure;
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
