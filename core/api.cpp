// The door: plain C functions on arrays, as bearing_twin/core.py declares them. Rooms have doors of their own.
#include "door.hpp"



namespace {

#ifdef __AVX512F__
constexpr int LANES = 8;
#else
constexpr int LANES = 4;
#endif
using Pack = double __attribute__((vector_size(8 * LANES)));

}  // namespace

// How many doubles stand side by side.
CORE_EXPORT int core_lanes() { return LANES; }

// Replaces the `count` numbers by their squares, and returns the sum of these, added up lane by lane.
CORE_EXPORT double core_self_check(double *numbers, std::int64_t count) {
  Pack sums{};
  for (std::int64_t i = 0; i < count; i++) {
    numbers[i] *= numbers[i];
    sums[i % LANES] += numbers[i];
  }
  double sum = 0;
  for (int lane = 0; lane < LANES; lane++) sum += sums[lane];
  return sum;
}
