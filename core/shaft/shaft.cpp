// Exported functions of the motion of a shaft on two bearings; arrays are C-contiguous doubles, structs of rotor.hpp
// and those below in the order of their members.
#include "rotor.hpp"
#include "../bearing/numbers.hpp"
#include "../exports.hpp"

namespace core::shaft {

// The motion of the shaft step by step. A step that reaches beyond what is asked for is kept, with its interpolant, so that a
// run does not depend on how it is cut. Steps end where drive or load change. Outputs have balls of their own: looking at a
// motion does not touch it.

constexpr double NEAR = 1e-3;  // of a step: no shorter one is left before a part of the course ends

// Begin and end [s] of the step kept, the next step [s], and the work of loads, bearings and damping [J], each step's counted
// by its size, up to that end and up to that begin.
struct Clock { double began, time, step, gross, gross_before; };

// The step kept: states at its ends, and its interpolant.
struct KeptStep {
  State start, end, third, fourth;

  State at(double share) const {
    State found;
    for (int n = 0; n < STATE; n++) found[n] = interpolated(share, start[n], end[n], third[n], fourth[n]);
    return found;
  }
  bool finite() const {
    double size = 0.0;
    for (const State *one : {&start, &end, &third, &fourth})
      for (double number : *one) size += std::fabs(number);
    return size < HUGE_VAL;
  }
};

// What a motion moves on in place.
struct Motion { Clock &clock; KeptStep &kept; std::int64_t *counts; };  // steps, rejections, evaluations

// The state at `time` [s] of the step kept, and the gross work there.
inline std::pair<State, double> state_at(const Clock &clock, const KeptStep &kept, double time) {
  const double lasts = clock.time - clock.began, share = lasts > 0.0 ? (time - clock.began) / lasts : 1.0;
  return {kept.at(share), clock.gross_before + share * (clock.gross - clock.gross_before)};
}

// Drops what of the step kept lies beyond `time` [s]: the motion goes on from there.
inline void restart(Clock &clock, KeptStep &kept, double time) {
  auto [state, gross] = state_at(clock, kept, time);
  kept.start = kept.end = state;
  clock.began = clock.time = time, clock.gross = clock.gross_before = gross;
}

// Instants [s] of outputs and where their rows go.
struct Instants { const double *time; int count; double *row; int width; };

// Steps are between `shortest` and `longest` [s], and end within `furthest` of the middle.
struct Bounds { double shortest, longest; Five furthest; };

class Integration {
 public:
  Integration(const Rotor &rotor, const CoursePart *course, int parts, const Bounds &bounds, Bearings &moved, Method &method,
              Outputs &outputs, const Motion &motion)
      : rotor(rotor), course(course), parts(parts), bounds(bounds), equations(rotor, moved), method(method), outputs(outputs),
        clock(motion.clock), kept(motion.kept), counts(motion.counts) {}

  // Steps until one reaches `until` [s], and writes the outputs.
  Status run(double until, const Instants &instants, int order, const volatile std::uint8_t *stop) {
    for (;;) {
      if (Status status = write_outputs(instants); status != OK || clock.time >= until) return status;
      if (*stop != 0) return STOPPED;
      if (phase + 1 < parts && clock.time >= course[phase + 1].begin) phase++;
      if (Status status = step(order); status != OK) return status;
    }
  }

 private:
  const Rotor &rotor;
  const CoursePart *course;
  const int parts;
  const Bounds &bounds;
  Equations equations;
  Method &method;
  Outputs &outputs;
  Clock &clock;
  KeptStep &kept;
  std::int64_t *counts;
  int phase = 0, cursor = 0;

  // The outputs that the step kept reaches; TOO_DEEP at the first whose contacts leave their limits.
  Status write_outputs(const Instants &instants) {
    for (; cursor < instants.count && instants.time[cursor] <= clock.time; cursor++) {
      const double time = instants.time[cursor];
      auto [state, gross] = state_at(clock, kept, time);
      const Turn turn = course[phase].turn_at(time);
      for (int i = 0; i < COORDINATES; i++)
        state[i] += rotor.whirl.along(i, turn), state[RATE + i] += rotor.whirl.rate(i, turn);
      if (outputs.write(course[phase], time, state, gross, instants.row + std::int64_t(instants.width) * cursor) > 1.0) {
        clock.time = time;
        return TOO_DEEP;
      }
    }
    return OK;
  }

  Status step(int order) {
    equations.part = &course[phase];
    const double begin = clock.time, wanted = std::min(clock.step, bounds.longest);
    const double ends = phase + 1 < parts ? course[phase + 1].begin : HUGE_VAL;
    const bool reaches = begin + (1.0 + NEAR) * wanted >= ends;
    double step = reaches ? ends - begin : wanted, following;
    bool rejected = false;
    for (;; step = following, rejected = true) {
      const double error = method.make(equations, begin, kept.end, step);
      following = next_step(step, error, order);
      counts[2] += method.evaluations();
      if (error <= 1.0) break;
      counts[1]++;
      if (!(step > bounds.shortest)) return STALLED;
    }
    for (int i = 0; i < COORDINATES; i++)
      if (!(std::fabs(method.after[i]) <= bounds.furthest[i])) {
        clock.time = begin + step;
        return TOO_DEEP;
      }
    counts[0]++;
    kept = {kept.end, method.after, method.dense_term(0), method.dense_term(1)};
    const bool arrived = reaches && !rejected;
    clock.began = begin, clock.time = arrived ? ends : begin + step;
    clock.step = arrived ? std::max(wanted, following) : following;
    clock.gross_before = clock.gross;
    clock.gross += works();
    return OK;
  }

  // The works [J] of loads, of bearings and of damping in the step kept, each by its size, added up.
  double works() const {
    const Turn begin = course[phase].turn_at(clock.began), end = course[phase].turn_at(clock.time);
    double steady = 0.0, weight = 0.0;
    for (int i = 0; i < COORDINATES; i++) {
      const double moved = rotor.whirl.along(i, end) - rotor.whirl.along(i, begin) + kept.end[i] - kept.start[i];
      steady += rotor.steady[i] * moved, weight += rotor.weight[i] * moved;
    }
    auto done = [&](StateIndex work) { return kept.end[work] - kept.start[work]; };
    return std::fabs(done(LOAD_WORK) + steady) + std::fabs(done(BEARING_WORK) + steady + weight) + std::fabs(done(DISSIPATED));
  }
};

}  // namespace core::shaft

using namespace core;
using namespace core::shaft;

namespace {

template <class Struct>
Struct &at(double *numbers) { return *reinterpret_cast<Struct *>(numbers); }
template <class Struct>
const Struct &at(const double *numbers) { return *reinterpret_cast<const Struct *>(numbers); }

template <class Struct>
constexpr int numbers_in = sizeof(Struct) / sizeof(double);
static_assert(numbers_in<Rotor> == 41 && numbers_in<CoursePart> == 14 && numbers_in<Bounds> == 7 && numbers_in<Clock> == 5 &&
              numbers_in<KeptStep> == 4 * STATE, "kinds/shaft in bearing_twin writes so many doubles");

}  // namespace

// Steps from the step kept on until one reaches `until` [s], and fills `rows` (instants, width) at `times` [s]. `seats` (2,
// SEAT) and `balls` (2,) are of both bearings; `course` (parts, 14) holds the parts from that of the step kept on; `scales`
// (10,) are errors that count as 1. `moved` and `shown` (N, BALL_MEMORY) are balls in equilibrium, of the motion and of its
// outputs. `clock` (5,), `kept` (4, 14), both memories and `counts` (3,) are moved on in place.
CORE_EXPORT std::int64_t core_shaft_advance(const double *rotor_numbers, const double *seats, const std::int64_t *balls,
                                            const double *course, std::int64_t parts, const double *method_numbers,
                                            const double *scales, const double *bounds, std::int64_t instants, const double *times,
                                            double until, const volatile std::uint8_t *stop, double *clock, double *kept,
                                            double *moved, double *shown, std::int64_t *counts, double *rows, std::int64_t width) {
  const Rotor &rotor = at<Rotor>(rotor_numbers);
  const RosenbrockMethod method = method_of(method_numbers);
  Method::Scales its_scales;
  std::copy(scales, scales + MOVING, its_scales.begin());
  Bearings of_motion(rotor, &at<Seat>(seats), balls, moved), of_outputs(rotor, &at<Seat>(seats), balls, shown);
  Method steps(method, its_scales);
  Outputs outputs(rotor, of_outputs, int(balls[0] + balls[1]));
  Motion motion{at<Clock>(clock), at<KeptStep>(kept), counts};
  Integration integration(rotor, &at<CoursePart>(course), int(parts), at<Bounds>(bounds), of_motion, steps, outputs, motion);
  const Status status = integration.run(until, {times, int(instants), rows, int(width)}, method.order, stop);
  return status == OK && !motion.kept.finite() ? NOT_FINITE : status;
}

// Drops what of the step kept lies beyond `time` [s].
CORE_EXPORT void core_shaft_restart(double *clock, double *kept, double time) {
  restart(at<Clock>(clock), at<KeptStep>(kept), time);
}
