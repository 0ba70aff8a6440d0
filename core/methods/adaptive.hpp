// The motion of one system of few numbers by an explicit method whose steps adapt to errors and events. Outputs are steps of
// their own from the start of the step they fall into, so that they have the order of the method, and a step that reaches
// beyond the end of the stretch is left to the next call: neither touches the motion, which does not depend on how it is cut.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include "rosenbrock.hpp"
#include "events.hpp"

namespace core {

// Explicit Runge-Kutta methods and a step of one system whose state is a row of numbers.

constexpr int MOST_EXPLICIT_STAGES = 12;

// `error` weighs the stages for the error estimate, all zero: none. Where there is a `third`, the estimate is divided by the
// length of (`error`, 0.1 `third`), as Hairer does in dop853.
struct ExplicitMethod {
  int stages, order;
  double a[MOST_EXPLICIT_STAGES][MOST_EXPLICIT_STAGES];
  double weight[MOST_EXPLICIT_STAGES], error[MOST_EXPLICIT_STAGES], third[MOST_EXPLICIT_STAGES];
};

// The classical method (Kutta 1901).
constexpr ExplicitMethod RK4{4, 4, {{}, {0.5}, {0, 0.5}, {0, 0, 1}}, {1 / 6.0, 2 / 6.0, 2 / 6.0, 1 / 6.0}, {}, {}};

// Dormand and Prince's method of order 8 with error estimates of orders 5 and 3 (Hairer, Norsett and Wanner, Solving ODE I,
// section II.10; the numbers of SciPy's DOP853).
constexpr ExplicitMethod DOP853{
    12, 8,
    {
      {},
      {0.05260015195876773},
      {0.0197250569845379, 0.0591751709536137},
      {0.02958758547680685, 0, 0.08876275643042054},
      {0.2413651341592667, 0, -0.8845494793282861, 0.924834003261792},
      {0.037037037037037035, 0, 0, 0.17082860872947386, 0.12546768756682242},
      {0.037109375, 0, 0, 0.17025221101954405, 0.06021653898045596, -0.017578125},
      {0.03709200011850479, 0, 0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402, 0.008273789163814023},
      {0.6241109587160757, 0, 0, -3.3608926294469414, -0.868219346841726, 27.59209969944671, 20.154067550477894,
       -43.48988418106996},
      {0.47766253643826434, 0, 0, -2.4881146199716677, -0.590290826836843, 21.230051448181193, 15.279233632882423,
       -33.28821096898486, -0.020331201708508627},
      {-0.9371424300859873, 0, 0, 5.186372428844064, 1.0914373489967295, -8.149787010746927, -18.52006565999696,
       22.739487099350505, 2.4936055526796523, -3.0467644718982196},
      {2.273310147516538, 0, 0, -10.53449546673725, -2.0008720582248625, -17.9589318631188, 27.94888452941996,
       -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636},
    },
    {0.054293734116568765, 0, 0, 0, 0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, 0.3111643669578199,
     -0.1521609496625161, 0.20136540080403034, 0.04471061572777259},
    {0.01312004499419488, 0, 0, 0, 0, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864, -0.35032884874997366,
     0.3341791187130175, 0.08192320648511571, -0.022355307863886294},
    {-0.18980075407240762, 0, 0, 0, 0, 4.450312892752409, 1.8915178993145003, -5.801203960010585, -0.4226823213237919,
     -0.1521609496625161, 0.20136540080403034, 0.02265179219836082}};

template <std::size_t NUMBERS>
using Numbers = std::array<double, NUMBERS>;

// The state `step` [s] after `state`, written to `out`; returns the error, a root mean square in units of `scales`, zero
// without an estimate. `rates(state, slopes)` fills the slopes of the first MOVING numbers; the others stay.
template <std::size_t MOVING, std::size_t NUMBERS, class Rates>
double explicit_step(const ExplicitMethod &method, const Rates &rates, const Numbers<NUMBERS> &scales, const Numbers<NUMBERS> &state,
                     double step, Numbers<NUMBERS> &out) {
  std::array<Numbers<MOVING>, MOST_EXPLICIT_STAGES> slopes;
  Numbers<NUMBERS> trial = state;
  for (int i = 0; i < method.stages; i++) {
    for (std::size_t n = 0; n < MOVING; n++) trial[n] = state[n];
    for (int j = 0; j < i; j++)
      if (double weight = step * method.a[i][j]; weight != 0.0)
        for (std::size_t n = 0; n < MOVING; n++) trial[n] += weight * slopes[j][n];
    rates(trial, slopes[i]);
  }
  Numbers<MOVING> change{}, wide{}, narrow{};
  for (int i = 0; i < method.stages; i++)
    for (std::size_t n = 0; n < MOVING; n++) {
      change[n] += method.weight[i] * slopes[i][n];
      wide[n] += method.error[i] * slopes[i][n];
      narrow[n] += method.third[i] * slopes[i][n];
    }
  out = state;
  double fifth = 0.0, third = 0.0;
  for (std::size_t n = 0; n < MOVING; n++) {
    out[n] += step * change[n];
    double w = wide[n] / scales[n], t = narrow[n] / scales[n];
    fifth += w * w, third += t * t;
  }
  return fifth == 0.0 ? 0.0 : step * fifth / std::sqrt((fifth + 0.01 * third) * MOVING);
}

// Up to when to step [s], the instants of outputs (outputs,) [s], and a flag that is not 0 once somebody wants it to end.
struct Stretch {
  double until;
  int outputs;
  const double *instant;
  const volatile std::uint8_t *stop;
};

// Begin of a step: OK or why it cannot, the longest and the least step [s], whether bodies can press in it.
struct StepBegin {
  Status status;
  double longest, least;
  bool loaded;
};

// End of a step: OK or why it cannot, its length [s] up to an event in it; `again`: to be made again from clock.step.
struct StepEnd {
  Status status;
  double step;
  bool again = false;
};

// Acceptance of a step: OK or the end of the motion, and whether a record is complete.
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

  // Moves on until the next step would pass `until`; `states` (outputs,) are those at the instants, `records` (capacity,) those
  // completed, of which there are `completed`. FULL once there is no room for more.
  template <class Record>
  Status advance(const Stretch &stretch, State *states, Record *records, int capacity, int &completed) {
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
