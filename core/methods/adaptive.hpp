// The motion of one small system by an explicit method with adaptive steps and events. Outputs are steps of their own from the
// start of the step they fall into, so that they have the order of the method, and a step that reaches beyond the end of the
// interval is left to the next call: neither affects the motion, which does not depend on how it is divided.
#pragma once
#include "events.hpp"
#include "runge_kutta.hpp"
#include "step_control.hpp"

namespace core {

// The end of an interval [s], the instants (outputs,) [s] of its outputs, and a flag that is not 0 once a stop is requested.
struct Interval {
  double end;
  int outputs;
  const double *instants;
  const volatile std::uint8_t *stop;
};

// Start of a step: OK or why there is none, the longest and the least step [s], whether contacts can carry load in it.
struct StepStart {
  Status status;
  double longest, least;
  bool loaded;
};

// End of a step: OK or why there is none, its length [s] up to an event in it; `repeat`: the step is repeated with clock.step.
struct StepEnd {
  Status status;
  double step;
  bool repeat = false;
};

// Acceptance of a step: OK or the end of the motion, and whether a record is complete.
struct Accepted {
  Status status;
  bool complete;
};

// `Clock` has at least the numbers time [s], step (the next to try) [s] and written (outputs so far); `Derived` has
//   rates(state, loaded, slopes)    the slopes of the first MOVING numbers of a state; `loaded`: contacts can carry load
//   start_step()                    sets `scales` and returns a StepStart
//   end_step(step, loaded)          corrects `after`, the end of the step, ends it at an event, and returns a StepEnd
//   correct(state)                  corrects an output
//   accept(step, proposed, loaded)  makes `after` the state, the clock being at the step's end, sets clock.step, for which
//                                   error control proposes `proposed` [s], and returns an Accepted
//   record()                        the completed record.
template <class Derived, std::size_t NUMBERS, std::size_t MOVING, class Clock>
class AdaptiveMotion {
 public:
  using State = Numbers<NUMBERS>;
  using Slopes = Numbers<MOVING>;

  AdaptiveMotion(const ExplicitMethod &method, State &state, Clock &clock, Counts &counts)
      : method(method), state(state), clock(clock), counts(counts) {}

  // Steps until the next step would pass the end of the interval; fills `states` (outputs,) at the instants and `records`
  // (capacity,), of which `completed` are filled. Returns FULL when there is no room for more.
  template <class Record>
  Status advance(const Interval &interval, State *states, Record *records, int capacity, int &completed) {
    completed = 0;
    for (;;) {
      if (*interval.stop != 0) return STOPPED;
      StepStart start = derived().start_step();
      if (start.status != OK) return start.status;
      double proposed, step = longest_step(start, proposed);
      if (step < 0.0) return STALLED;
      StepEnd end = derived().end_step(step, start.loaded);
      if (end.repeat) continue;
      if (end.status != OK) return end.status;
      for (double number : after)
        if (!std::isfinite(number)) return NOT_FINITE;
      double time = clock.time + end.step;
      write_outputs(interval, std::min(time, interval.end), start.loaded, states);
      if (time > interval.end) return OK;
      clock.time = time;
      counts.steps++;
      Accepted accepted = derived().accept(end.step, proposed, start.loaded);
      if (accepted.complete) {
        records[completed++] = derived().record();
        if (completed == capacity) return FULL;
      }
      if (accepted.status != OK) return accepted.status;
    }
  }

 protected:
  const ExplicitMethod &method;
  State &state;
  Clock &clock;
  Counts &counts;
  State after{}, scales{};

  // The state `length` [s] after `from`; returns the error in units of `scales`.
  double step_from(const State &from, double length, bool loaded, State &to) {
    return explicit_step<MOVING>(
        method, [&](const State &trial, Slopes &slopes) { derived().rates(trial, loaded, slopes); }, scales, from, length, to);
  }
  // The same inside a step in contact, which is counted.
  void evaluate_inside(const State &from, double length, State &to) {
    counts.evaluations += method.stages;
    step_from(from, length, true, to);
  }
  // Ends the step where `value(state)` has just changed its sign, as `step_to_sign_change`; returns its length [s].
  template <class Value>
  double end_at_sign_change(const Value &value, double step, double nearest) {
    return step_to_sign_change(value, [&](double length) { evaluate_inside(state, length, after); }, state, after, step, nearest);
  }

 private:
  Derived &derived() { return static_cast<Derived &>(*this); }

  // The longest step whose error is at most 1, and the next one to try; negative where the least step is still too long.
  double longest_step(const StepStart &start, double &proposed) {
    for (double step = start.longest;; step = proposed) {
      double error = step_from(state, step, start.loaded, after);
      proposed = next_step(step, error, method.order);
      counts.evaluations += method.stages;
      if (error <= 1.0) return step;
      counts.rejections++;
      if (!(step > start.least)) return -1.0;
    }
  }
  void write_outputs(const Interval &interval, double end, bool loaded, State *states) {
    for (int row = int(clock.written); row < interval.outputs && interval.instants[row] <= end; row++) {
      step_from(state, interval.instants[row] - clock.time, loaded, states[row]);
      derived().correct(states[row]);
      clock.written = row + 1;
    }
  }
};

}  // namespace core
