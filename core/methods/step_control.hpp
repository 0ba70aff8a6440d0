// Status, cost and step sizes of an integration, and the loop of methods that step all bodies together.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace core {

constexpr int MAX_STAGES = 6;  // of methods of bearings (bearing_twin/coefficients.py)
constexpr double LEAST_STEP = 1e-15;  // s; a shorter step is lost in the time
constexpr double NEGLIGIBLE = 1e-12;  // fraction of an interval that is too short for a step

// In the order of bearing_twin/methods.py.
enum Status { OK, NOT_FINITE, TOO_DEEP, STALLED, FULL, SEPARATED, TIME_UP, STOPPED, UNTRACKED };

struct Counts {
  std::int64_t steps, rejections, evaluations;
};

// The step whose error should just be 1, given the error of this step; the ratio of both steps is limited to 0.2 to 6.
inline double next_step(double step, double error, int order) {
  if (!(error < HUGE_VAL)) return 0.2 * step;
  double least = std::max(error, 1e-10);
  double root = order == 4 ? std::sqrt(std::sqrt(least)) : std::pow(least, 1.0 / order);
  return step * std::min(6.0, std::max(0.2, 0.9 / root));
}

// Orientations need fewer steps than contacts do; impossible states are searched for at intervals.
constexpr int TURN_EVERY = 8, CHECK_EVERY = 64;

// Steps are at most `longest` [s], which is the first step where an error estimate of this `order` adapts them. Without an
// estimate `order` is 0 and steps between two outputs are equal. `counted`: times are multiples of the step since the last
// output instead of sums.
struct Pace {
  double longest;
  int order;
  bool counted;
};

// Integrates `bodies` over `duration` [s] with one step size for all, so that the `instants` [s] of outputs are ends of steps;
// `next` becomes the size of the next step [s].
//
// `Bodies` has their `number`; `step(time, step, warm)`, which returns the error in units of the tolerance, 0 without an
// estimate, `warm` where the slopes at the start are known; `worst()`, the body with that error; `accept(fresh)`, which makes
// the end of a step the next start, `fresh` after an output; `turn(seconds, step, steps)`, which integrates orientations over
// the steps since the last call; `store(row)`, which writes an output, or for -1 the end; and `check()`, which returns a body
// whose state is impossible and why.
template <class Bodies>
Status integrate_together(Bodies &bodies, const Pace &pace, double duration, int outputs, const double *instants,
                          const volatile std::uint8_t *stop, std::int64_t *counts, double *failure, double &next) {
  double time = 0.0;
  bool warm = false;
  next = pace.longest;
  for (int row = 0; row <= outputs; row++) {
    double goal = row < outputs ? instants[row] : duration, start = time, turned_time = time, step = next;
    int steps = 0, turned_steps = 0;
    while (goal - time > NEGLIGIBLE * duration) {
      if (*stop != 0) return STOPPED;
      if (steps == 0 || !pace.counted) step = (goal - time) / std::max(1.0, std::ceil((goal - time) / next - 1e-9));
      double error = bodies.step(time, step, warm);
      warm = true;
      if (pace.order > 0) next = next_step(step, error, pace.order);
      if (!(error <= 1.0)) {
        counts[1] += bodies.number;
        if (!(next < LEAST_STEP)) continue;
        failure[0] = time, failure[1] = bodies.worst();
        return STALLED;
      }
      counts[0] += bodies.number;
      bool last = goal - time - step < NEGLIGIBLE * duration;
      bodies.accept(steps == 0);
      steps++;
      time = pace.counted ? start + steps * step : last ? goal : time + step;
      if (steps % TURN_EVERY == 0 || last) {
        bodies.turn(time - turned_time, step, steps - turned_steps);
        turned_time = time, turned_steps = steps;
      }
      if (steps % CHECK_EVERY == 0 || last)
        if (auto [status, body] = bodies.check(); status != OK) {
          failure[0] = time, failure[1] = body;
          return status;
        }
    }
    bodies.store(row < outputs ? row : -1);
  }
  return OK;
}

}  // namespace core
