// The motion of one system of few numbers by an explicit method whose steps adapt to errors and events. Outputs are steps of
// their own from the start of the step they fall into, so that they have the order of the method, and a step that reaches
// beyond the end of the stretch is left to the next call: neither touches the motion, which does not depend on how it is cut.
#pragma once
#include <cstdint>
#include "rosenbrock.hpp"
#include "events.hpp"
#include "explicit_methods.hpp"

namespace core {

// Up to when to step [s], the instants of outputs (outputs,) [s], and a flag that is not 0 once somebody wants it to end.
struct Stretch {
  double until;
  int outputs;
  const double *instant;
  const volatile std::uint8_t *stop;
};

// How a step begins: OK or why it cannot, the longest and the least step [s], whether bodies can press in it.
struct StepBegin {
  Status status;
  double longest, least;
  bool loaded;
};

// How a step ends: OK or why it cannot, its length [s] up to an event in it; `again`: to be made again from clock.step.
struct StepEnd {
  Status status;
  double step;
  bool again = false;
};

// What is accepted: OK or the end of the motion, and whether a record is complete.
struct Accepted {
  Status status;
  bool complete;
};

// `Clock` has at least the numbers time [s], step (the next to try) [s] and written (outputs so far); `Own` has
//   rates(state, loaded, slopes)    the slopes of the first MOVING numbers of a state; `loaded`: bodies can press
//   begin()                         sets `scales` and returns a StepBegin
//   end(step, loaded)               puts `after`, the end of the step, right, ends it at an event, and returns a StepEnd
//   put_right(state)                the same for an output
//   accept(step, following, loaded) takes `after` as the state, the clock being at the step's end, sets clock.step, for which
//                                   error control proposes `following` [s], and returns an Accepted
//   record()                        the record that is complete.
template <class Own, std::size_t NUMBERS, std::size_t MOVING, class Clock>
class AdaptiveMotion {
 public:
  using State = Numbers<NUMBERS>;
  using Slopes = Numbers<MOVING>;

  AdaptiveMotion(const ExplicitMethod &method, State &state, Clock &clock, Counts &counts)
      : method(method), state(state), clock(clock), counts(counts) {}

  // Moves on until the next step would pass `until`; `states` (outputs,) are those at the instants, `records` (room,) those
  // completed, of which there are `completed`. FULL once there is no room for more.
  template <class Record>
  Status advance(const Stretch &stretch, State *states, Record *records, int room, int &completed) {
    completed = 0;
    for (;;) {
      if (*stretch.stop != 0) return STOPPED;
      StepBegin begin = own().begin();
      if (begin.status != OK) return begin.status;
      double following, step = longest_step(begin, following);
      if (step < 0.0) return STALLED;
      StepEnd end = own().end(step, begin.loaded);
      if (end.again) continue;
      if (end.status != OK) return end.status;
      for (double number : after)
        if (!std::isfinite(number)) return NOT_FINITE;
      double moment = clock.time + end.step;
      write_outputs(stretch, std::min(moment, stretch.until), begin.loaded, states);
      if (moment > stretch.until) return OK;
      clock.time = moment;
      counts.steps++;
      Accepted accepted = own().accept(end.step, following, begin.loaded);
      if (accepted.complete) {
        records[completed++] = own().record();
        if (completed == room) return FULL;
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
        method, [&](const State &at, Slopes &slopes) { own().rates(at, loaded, slopes); }, scales, from, length, to);
  }
  // The same for a look into a step in contact, which is counted.
  void look(const State &from, double length, State &to) {
    counts.evaluations += method.stages;
    step_from(from, length, true, to);
  }
  // Ends the step where `value(state)` has just changed its sign, as `landing_step`; returns its length [s].
  template <class Value>
  double land(const Value &value, double step, double nearest) {
    return landing_step(value, [&](double length) { look(state, length, after); }, state, after, step, nearest);
  }

 private:
  Own &own() { return static_cast<Own &>(*this); }

  // The longest step whose error is at most 1, and the one to try next; negative where the least one is still too long.
  double longest_step(const StepBegin &begin, double &following) {
    for (double step = begin.longest;; step = following) {
      double error = step_from(state, step, begin.loaded, after);
      following = next_step(step, error, method.order);
      counts.evaluations += method.stages;
      if (error <= 1.0) return step;
      counts.rejections++;
      if (!(step > begin.least)) return -1.0;
    }
  }
  void write_outputs(const Stretch &stretch, double end, bool loaded, State *states) {
    for (int row = int(clock.written); row < stretch.outputs && stretch.instant[row] <= end; row++) {
      step_from(state, stretch.instant[row] - clock.time, loaded, states[row]);
      own().put_right(states[row]);
      clock.written = row + 1;
    }
  }
};

}  // namespace core
