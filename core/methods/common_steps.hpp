// The loop of methods that step all bodies together, with one step size, so that instants are ends of steps.
#pragma once
#include <cstdint>
#include "rosenbrock.hpp"

namespace core {

// Orientations need fewer steps than contacts do; a state that cannot be right is looked for now and then.
constexpr int TURN_EVERY = 8, CHECK_EVERY = 64;

// Steps are at most `longest` [s], the first one where an error estimate of this `order` adapts them. Without an estimate
// `order` is 0 and steps between two instants are equal.
struct Pace { double longest; int order; bool counted; };  // counted: times of steps from the instant before, not summed

// Steps `bodies` over `duration` [s] through the instants [s]; `next` becomes the size of the next step [s].
//
// `Bodies` has their `number`; `step(time, step, begun)`, which returns the error in units of the tolerance, 0 without an
// estimate; `worst()`, the body with that error; `move_on(fresh)`, which takes a step's end as the next start, `fresh` after
// an instant; `turn(seconds, step, steps)`, which turns bodies over what was done since they were turned last; `keep(row)`,
// which stores what they are at an instant, or for -1 at the end; and `check()`, which returns the body that cannot be
// right and why.
template <class Bodies>
Status step_together(Bodies &bodies, const Pace &pace, double duration, int instants, const double *instant,
                     const volatile std::uint8_t *stop, std::int64_t *counts, double *failure, double &next) {
  double time = 0.0;
  bool begun = false;
  next = pace.longest;
  for (int row = 0; row <= instants; row++) {
    double goal = row < instants ? instant[row] : duration, begin = time, turned_at = time, step = next;
    int done = 0, turned = 0;
    while (goal - time > NEGLIGIBLE * duration) {
      if (*stop != 0) return STOPPED;
      if (done == 0 || !pace.counted) step = (goal - time) / std::max(1.0, std::ceil((goal - time) / next - 1e-9));
      double error = bodies.step(time, step, begun);
      begun = true;
      if (pace.order > 0) next = next_step(step, error, pace.order);
      if (!(error <= 1.0)) {
        counts[1] += bodies.number;
        if (!(next < LEAST_STEP)) continue;
        failure[0] = time, failure[1] = bodies.worst();
        return STALLED;
      }
      counts[0] += bodies.number;
      bool last = goal - time - step < NEGLIGIBLE * duration;
      bodies.move_on(done == 0);
      done++;
      time = pace.counted ? begin + done * step : last ? goal : time + step;
      if (done % TURN_EVERY == 0 || last) {
        bodies.turn(time - turned_at, step, done - turned);
        turned_at = time, turned = done;
      }
      if (done % CHECK_EVERY == 0 || last)
        if (auto [status, body] = bodies.check(); status != OK) {
          failure[0] = time, failure[1] = body;
          return status;
        }
    }
    bodies.keep(row < instants ? row : -1);
  }
  return OK;
}

}  // namespace core
