// Exported functions of the whole library. bearing_twin/core.py declares the functions.
#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <csignal>
#include "math/dual.hpp"

// Number of doubles in a SIMD pack.
CORE_EXPORT int core_lanes() { return LANES; }

namespace {
volatile std::sig_atomic_t code_at_alarm = 0;
}

// From now on SIGALRM ends this process at once with an exit code, whatever its threads do.
CORE_EXPORT void core_exit_at_alarm(int code) {
  code_at_alarm = code;
  std::signal(SIGALRM, [](int) { _exit(code_at_alarm); });
}

// Checks of outputs (run/health.py): numbers of a size that a scene may have, unit quaternions, no more energy than there was
// and was brought.

// True if all numbers (rows, columns) lie within their limits (columns,), and quaternions are unit within a tolerance.
CORE_EXPORT std::int64_t core_within_limits(const double *numbers, std::int64_t rows, std::int64_t columns, const double *limits,
                                            const std::int64_t *rotations, std::int64_t rotation_count, double tolerance) {
  std::int64_t beyond = 0;
  for (; rows > 0; rows--, numbers += columns) {
    for (std::int64_t i = 0; i < columns; i++) beyond |= !(std::fabs(numbers[i]) <= limits[i]);  // nor is a NaN
    for (std::int64_t i = 0; i < rotation_count; i++) {
      const double *q = numbers + rotations[i];
      beyond |= std::fabs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0) > tolerance;
    }
  }
  return !beyond;
}

// The first row with more energy than there can be (-1: none). `stored` are the columns of kinetic, elastic and
// potential energy, `brought` that of work (-1: none), `begin` (4,) [J] these numbers at the start. `state` (2,) [J]:
// the greatest energy so far, which is updated; the gain in that row.
CORE_EXPORT std::int64_t core_first_gain(const double *numbers, std::int64_t rows, std::int64_t columns, const std::int64_t *stored,
                                         std::int64_t brought, const double *begin, double allowed, double rounding,
                                         double *state) {
  double total = begin[0] + begin[1] + begin[2];
  for (std::int64_t row = 0; row < rows; row++, numbers += columns) {
    double kinetic = numbers[stored[0]], elastic = numbers[stored[1]], potential = numbers[stored[2]];
    double gained = kinetic + elastic + potential - total, work = brought >= 0 ? std::fabs(numbers[brought]) : 0.0;
    // The most so far: a body that falls and comes back up has all of it, though none at the instant it is back.
    state[0] = std::max(state[0], begin[0] + begin[1] + std::fabs(work - begin[3]) + std::fabs(potential - begin[2]));
    if (gained > (1.0 + allowed) * state[0] + rounding * (kinetic + elastic + std::fabs(potential))) {
      state[1] = gained;
      return row;
    }
  }
  return -1;
}
