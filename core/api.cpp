// Exported functions of the whole library. bearing_twin/core.py declares the functions.
#include "math/dual.hpp"

// Number of doubles in a SIMD pack.
CORE_EXPORT int core_lanes() { return LANES; }

// Replaces the `count` numbers by their squares, and returns the sum of these, added up lane by lane.
CORE_EXPORT double core_self_check(double *numbers, std::int64_t count) {
  core::Pack sums{};
  for (std::int64_t i = 0; i < count; i++) {
    numbers[i] *= numbers[i];
    sums[i % LANES] += numbers[i];
  }
  double sum = 0;
  for (int lane = 0; lane < LANES; lane++) sum += sums[lane];
  return sum;
}
