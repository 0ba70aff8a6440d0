// The door to contact ellipses; arrays are C-contiguous doubles.
#include <algorithm>
#include "../door.hpp"
#include "ellipse.hpp"

using namespace core;

// Semi-axes [m] and peak pressures [Pa] of contacts with these curvatures [1/m], effective moduli [Pa] and loads [N].
CORE_EXPORT void core_ellipses(std::int64_t count, const double *small, const double *large, const double *modulus,
                               const double *load, double *semi_major, double *semi_minor, double *peak_pressure) {
  for (std::int64_t begin = 0; begin < count; begin += LANES) {
    auto lanes_of = [&](const double *numbers) {
      Pack lanes{};
      for (int lane = 0; lane < LANES; lane++) lanes[lane] = numbers[std::min(begin + lane, count - 1)];
      return lanes;
    };
    Ellipse found = ellipse(lanes_of(small), lanes_of(large), lanes_of(modulus), lanes_of(load));
    for (int lane = 0; lane < LANES && begin + lane < count; lane++) {
      semi_major[begin + lane] = found.semi_major[lane], semi_minor[begin + lane] = found.semi_minor[lane];
      peak_pressure[begin + lane] = found.peak_pressure[lane];
    }
  }
}
