// Balls that nothing couples: the rings' motion is prescribed, and no ball touches another. Each lane holds a ball with
// its own time and step; all lanes take a step together, each accepts or repeats its own, and a lane whose ball has
// reached the end of the chunk takes the next one.
#pragma once
#include "../methods/rosenbrock.hpp"
#include "ball_rates.hpp"

namespace core {

constexpr int SCALES = MOTION + 1;
constexpr double LONGEST_FLIGHT = 5e-5;  // s, of a step that begins in flight: a bounce takes about as long
constexpr double LANDED = 0.95;  // share of a step: a contact that changes later in it is as good as at its end
// Of what a contact that begins or ends does to a ball's speed: a step's error is no less, as the estimate passes
// through zero by chance where the instant moves through the step.
constexpr double LANDING_SHARE = 0.1;

// A chunk to integrate; `scale` are the errors that a step may make in each coordinate, and last [J] in what is lost,
// `instant` [s] the times of outputs, from the chunk's begin.
struct Chunk {
  const Bearing &bearing;
  const RosenbrockMethod &method;
  Drive drive;
  double duration, scale[SCALES];
  int instants;
  const double *instant;
  const volatile std::uint8_t *stop;  // not 0 once somebody wants it to end
};

// Arrays it integrates and fills: states (balls, COLUMNS), orientations (balls, 4), steps (balls,) and what is carried, in place; states and
// orientations at the instants (instants, balls, ...); steps, rejections, evaluations and Jacobians so far.
struct Results {
  int balls;
  double *state, *orientation, *step, *carried, *states, *orientations;
  std::int64_t *counts;
  double *failure;  // (2,): the time [s] and the ball of a failure
};

namespace free_balls {

// Speed [m/s] that a contact which begins in a step gives a ball in it, or would take where one ends; 0 where none does.
inline double contact_change(const Bearing &bearing, const Raceway &raceway, double begin, double end, double step) {
  double lag = bearing.power * bearing.relaxation_time * std::min(end - begin, 0.0) / step;
  double before = begin + lag, after = end + lag;
  double lasts = step / std::max(std::fabs(end - begin), 1e-300);
  if (before <= 0.0 && after > 0.0) {
    double load = end > 0.0 ? raceway.given * std::pow(end, bearing.power) : 0.0;
    return load * (bearing.relaxation_time + end * lasts / (bearing.power + 1.0)) / bearing.ball_mass;
  }
  if (after <= 0.0 && before > 0.0) {
    double stiffness = bearing.power * raceway.given * std::pow(std::max(end - after, 0.0), bearing.power - 1.0);
    return 0.5 * stiffness / bearing.power * after * after * lasts / bearing.ball_mass;
  }
  return 0.0;
}

// The least error of a step [s] in which contacts of a ball begin or end: a share of what they do to its speed. A contact
// beside one that carries load throughout is soon forgotten.
inline double least_error(const Chunk &chunk, double step, const Approaches &first, const Approaches &last) {
  const Bearing &bearing = chunk.bearing;
  double lag = bearing.power * bearing.relaxation_time * std::min(last[1] - first[1], 0.0) / step;
  if (!(std::min(first[1], last[1]) + lag <= 0.0)) return 0.0;
  double change = std::max(contact_change(bearing, bearing.outer, first[1], last[1], step),
                           contact_change(bearing, bearing.inner, first[0], last[0], step));
  return LANDING_SHARE / (chunk.scale[VELOCITY] * std::sqrt(double(MOTION))) * change;
}

template <bool PATCH, bool TILTED>
class Integration : StepStates<BallState> {
 public:
  Integration(const Chunk &chunk, const Results &results) : chunk(chunk), bearing(chunk.bearing), method(chunk.method), out(results) {
    for (int c = 0; c < MOTION; c++) over_scale[c] = 1.0 / chunk.scale[c];
    if (bearing.carries()) states = &carried;
  }

  // Moves the numbered balls through the chunk.
  Status run(const std::int64_t *numbers, int count) {
    waiting = running = 0;
    this->numbers = numbers, this->count = count;
    for (int lane = 0; lane < LANES; lane++) running += begin(lane);
    while (running > 0) {
      if (*chunk.stop != 0) return STOPPED;
      cut_steps();
      make_step();
      judge();
      give_out();
      move_on();
      for (int lane = 0; lane < LANES; lane++)
        if (held[lane] >= 0)
          if (Status status = propose(lane); status != OK) return status;
    }
    return OK;
  }

 private:
  const Chunk &chunk;
  const Bearing &bearing;
  const RosenbrockMethod &method;
  const Results &out;
  const std::int64_t *numbers = nullptr;
  int count = 0, waiting = 0, running = 0;
  int held[LANES], cursor[LANES];  // the ball in a lane, -1 without one; its next instant
  double wanted[LANES], until[LANES], share[LANES];
  BallState rates, time_slope;
  Quaternion before, after;
  CarriedBalls carried;
  const CarriedBalls *states = nullptr;  // null where the law carries none
  Pack time, step, over_step, gain, error;
  bool varies, meets_defects = false;
  SurfacePlaces places;  // where a step starts
  double over_scale[MOTION];
  BallJacobian jacobian;
  BallFactors factors;

  // Puts the next ball into a lane; a lane without a ball repeats the last one's start.
  bool begin(int lane) {
    bool idle = waiting >= count;
    int ball = int(numbers[std::min(waiting, count - 1)]);
    for (int c = 0; c < COLUMNS; c++) start[c][lane] = out.state[ball * COLUMNS + c];
    for (int c = 0; c < 4; c++) before[c][lane] = out.orientation[ball * 4 + c];
    load_carried(out.carried + ball * CARRIED, lane, carried);
    time[lane] = 0.0, step[lane] = std::min(out.step[ball], chunk.duration), cursor[lane] = 0;
    held[lane] = idle ? -1 : ball;
    waiting += !idle;
    return !idle;
  }

  // A step that begins and ends in flight may pass over a bounce that none of its stages sees: it is kept short.
  void cut_steps() {
    find_places();
    Heights now = heights(0.0);
    Pack approach = outer_approach(bearing, start) + now.outer.value;
    for (int lane = 0; lane < LANES; lane++) {
      double left = chunk.duration - time[lane];
      wanted[lane] = step[lane];
      if (wanted[lane] > LONGEST_FLIGHT && approach[lane] < 0.0 &&
          inner_approach(bearing, start[RADIUS][lane], start[ANGLE][lane], start[HEIGHT][lane]) + now.inner.value[lane] < 0.0)
        wanted[lane] = LONGEST_FLIGHT;
      if (bearing.defects.count) wanted[lane] = std::min(wanted[lane], resolving_step(bearing.defects, places, lane));
      step[lane] = wanted[lane] >= left - NEGLIGIBLE * chunk.duration ? left : wanted[lane];
    }
  }

  void find_places() {
    if (!bearing.defects.count) return;
    Pack turned;
    Mask first;
    for (int lane = 0; lane < LANES; lane++) first[lane] = held[lane] == 0 ? -1 : 0, turned[lane] = chunk.drive.angle_at(time[lane]);
    places = surface_places(start[ANGLE], start[VELOCITY + 1] / start[RADIUS], turned, chunk.drive.speed + chunk.drive.acceleration * time,
                            before, spin_in_frame(start), first);
    meets_defects = false;
    for (int lane = 0; lane < LANES; lane++) meets_defects |= meets(bearing.defects, places, lane, step[lane]);
  }
  // After this share of a step.
  Heights heights(double alpha) const {
    return meets_defects ? heights_at(bearing.defects, places, alpha * step) : Heights{};
  }

  Pack ring_speed(double alpha) const {
    return chunk.drive.speed + chunk.drive.acceleration * (time + alpha * step);
  }

  void make_step() {
    over_step = 1.0 / step;
    gain = method.gamma * step;
    varies = chunk.drive.acceleration != 0.0 || meets_defects;
    carried.forget_films();
    if (varies) evaluate_rates<PATCH, TILTED>(bearing, ring_speed(TIME_DIFFERENCE), states, heights(TIME_DIFFERENCE), start, time_slope);
    make_stage<0>(), make_stage<1>(), make_stage<2>(), make_stage<3>();
    if (method.stages > 4) make_stage<4>(), make_stage<5>();
    const BallState &last = stage[method.stages - 1];
    error = Pack{};
    for (int c = 0; c < COLUMNS; c++) end[c] += last[c];
    for (int c = 0; c < MOTION; c++) {
      Pack scaled = last[c] * over_scale[c];
      error += scaled * scaled;
    }
    // A ball that leaves a raceway moves freely while its contact still loses what it stores.
    error = maximum(absolute(last[DISSIPATED]) * (1.0 / chunk.scale[MOTION]), square_root(error * (1.0 / MOTION)));
    for (int c : {int(RADIUS), VELOCITY + 1, int(SPIN), SPIN + 1, SPIN + 2}) prepare_interpolant(method, c);
    after = rotated(before, spin_in_frame(start), spin_inside(broadcast<Pack>(0.5)), spin_in_frame(end), step);
    weigh_contact_changes();
  }

  template <int I>
  CORE_INLINE void make_stage() {
    BallState right;
    if constexpr (I == 0) {
      evaluate_rates_and_jacobian<PATCH, TILTED>(bearing, ring_speed(0.0), states, heights(0.0), start, rates, jacobian);
      factorise(jacobian, gain, factors);
      if (varies)
        for (int c = 0; c < COLUMNS; c++) time_slope[c] = (time_slope[c] - rates[c]) * (1.0 / TIME_DIFFERENCE);
      right = rates;
    } else {
      for (int c = 0; c < COLUMNS; c++) end[c] = start[c] + weighted<I>(method.a[I], c);
      if (!method.repeats_first(I)) evaluate_rates<PATCH, TILTED>(bearing, ring_speed(method.alpha[I]), states, heights(method.alpha[I]), end, rates);
      for (int c = 0; c < COLUMNS; c++) right[c] = rates[c] + over_step * weighted<I>(method.c[I], c);
    }
    if (varies)
      for (int c = 0; c < COLUMNS; c++) right[c] += method.d[I] * time_slope[c];
    solve(jacobian, factors, gain, right, stage[I]);
    for (Pack &one : stage[I]) one = select(absolute(one) < HUGE_VAL, one, Pack{});  // must not haunt the next attempt
  }

  Triple spin_inside(const Pack &fraction) const {
    return {inside(fraction, SPIN), inside(fraction, SPIN + 1),
            inside(fraction, SPIN + 2) - inside(fraction, VELOCITY + 1) / inside(fraction, RADIUS)};
  }

  Approaches approaches(const Heights &more, int lane, double radius, double angle, double height) const {
    Approaches found = approaches_at(bearing, radius, angle, height);
    return {found[0] + more.inner.value[lane], found[1] + more.outer.value[lane]};
  }
  Approaches approaches(const Heights &more, int lane, const BallState &y) const {
    return approaches(more, lane, y[RADIUS][lane], y[ANGLE][lane], y[HEIGHT][lane]);
  }

  void weigh_contact_changes() {
    Heights early = heights(0.0), late = heights(1.0);
    Pack first = outer_approach(bearing, start) + early.outer.value, last = outer_approach(bearing, end) + late.outer.value;
    Pack least = minimum(first, last) + bearing.power * bearing.relaxation_time * minimum(last - first, 0.0) / step;
    for (int lane = 0; lane < LANES; lane++)
      if (least[lane] <= 0.0 && error[lane] <= 1.0)
        error[lane] = std::max(double(error[lane]), least_error(chunk, step[lane], approaches(early, lane, start), approaches(late, lane, end)));
  }

  // The share of a step after which a contact has just begun or ended; 1 where none does.
  double landing_share(int lane) {
    Approaches before = approaches(heights(0.0), lane, start);
    if (!changes_contact(before, approaches(heights(1.0), lane, end))) return 1.0;
    for (int c = 0; c < VELOCITY; c++) prepare_interpolant(method, c);
    return share_of_change(before, [&](double share) {
      auto at = [&](int c) { return interpolated(share, double(start[c][lane]), double(end[c][lane]), double(third[c][lane]), double(fourth[c][lane])); };
      return approaches(heights(share), lane, at(RADIUS), at(ANGLE), at(HEIGHT));
    });
  }

  // True where a lane's step is accepted: `until` is the time up to which it may give out, infinite at the chunk's end.
  void judge() {
    int evaluations = 0;
    for (int i = 0; i < method.stages; i++) evaluations += !method.repeats_first(i);
    for (int lane = 0; lane < LANES; lane++) {
      share[lane] = 1.0, until[lane] = -HUGE_VAL;
      if (held[lane] < 0) continue;
      out.counts[2] += evaluations, out.counts[3] += 1;
      if (!(error[lane] <= 1.0)) continue;
      if (method.ends_steps_at_contacts) share[lane] = landing_share(lane);
      if (share[lane] < LANDED) continue;
      double end_time = time[lane] + step[lane];
      until[lane] = end_time >= chunk.duration * (1.0 - NEGLIGIBLE) ? HUGE_VAL : end_time;
    }
  }

  void give_out() {
    for (bool first = true;; first = false) {
      Pack fraction{};
      bool found = false, has[LANES];
      for (int lane = 0; lane < LANES; lane++) {
        has[lane] = until[lane] > 0.0 && cursor[lane] < chunk.instants && chunk.instant[cursor[lane]] <= until[lane];
        if (has[lane]) fraction[lane] = (chunk.instant[cursor[lane]] - time[lane]) / step[lane];
        found |= has[lane];
      }
      if (!found) return;
      if (first)
        for (int c = 0; c < COLUMNS; c++) prepare_interpolant(method, c);
      BallState there;
      for (int c = 0; c < COLUMNS; c++) there[c] = inside(fraction, c);
      Quaternion turned = rotated(before, spin_in_frame(start), spin_inside(0.5 * fraction), spin_in_frame(there), fraction * step);
      for (int lane = 0; lane < LANES; lane++) {
        if (!has[lane]) continue;
        long row = long(cursor[lane]++) * out.balls + held[lane];
        for (int c = 0; c < COLUMNS; c++) out.states[row * COLUMNS + c] = there[c][lane];
        for (int c = 0; c < 4; c++) out.orientations[row * 4 + c] = turned[c][lane];
      }
    }
  }

  void move_on() {
    Mask moved;
    for (int lane = 0; lane < LANES; lane++) {
      moved[lane] = until[lane] >= 0.0 ? -1 : 0;
      if (bearing.carried != CarriedLaw::none && moved[lane]) carry_on(bearing, end, lane, carried);
    }
    time = select(moved, time + step, time);
    for (int c = 0; c < COLUMNS; c++) start[c] = select(moved, end[c], start[c]);
    for (int c = 0; c < 4; c++) before[c] = select(moved, after[c], before[c]);
  }

  // The next step of a lane; takes its ball out at the chunk's end and the next one in.
  Status propose(int lane) {
    int ball = held[lane];
    double proposed = next_step(step[lane], error[lane], method.order);
    if (until[lane] < 0.0) {
      out.counts[1] += 1;
      step[lane] = error[lane] <= 1.0 ? step[lane] * share[lane] : proposed;
      if (step[lane] < LEAST_STEP && !(error[lane] <= 1.0)) return failed(STALLED, time[lane], ball);
      return OK;
    }
    out.counts[0] += 1;
    step[lane] = proposed;
    if (until[lane] < HUGE_VAL) return OK;
    out.step[ball] = std::max(wanted[lane], proposed);  // a step cut short by the end counts only if it is longer
    for (int c = 0; c < COLUMNS; c++) out.state[ball * COLUMNS + c] = start[c][lane];
    for (int c = 0; c < 4; c++) out.orientation[ball * 4 + c] = before[c][lane];
    if (states) store_carried(carried, lane, out.carried + ball * CARRIED);
    if (Status status = check_ball(bearing, out.state + ball * COLUMNS); status != OK) return failed(status, chunk.duration, ball);
    running -= !begin(lane);
    return OK;
  }

  Status failed(Status status, double when, int ball) {
    out.failure[0] = when, out.failure[1] = ball;
    return status;
  }
};

}  // namespace free_balls
}  // namespace core
