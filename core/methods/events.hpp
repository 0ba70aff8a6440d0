// Events within a step: sign changes and maxima of a function of the state.
#pragma once
#include <algorithm>
#include <cmath>

namespace core {

// The cubic with these values and rates at the ends of a step [s], at a fraction of it.
template <class T>
inline T hermite(double fraction, double step, const T &start, const T &start_rate, const T &end, const T &end_rate) {
  double complement = 1.0 - fraction;
  T value = complement * complement * ((1.0 + 2.0 * fraction) * start + fraction * step * start_rate);
  return value + fraction * fraction * ((3.0 - 2.0 * fraction) * end - complement * step * end_rate);
}

constexpr int MAX_BISECTIONS = 100, MAX_REGULA_FALSI = 100;
constexpr double LEAST_WIDTH = 4e-16;  // fraction of a step to which a sign change is located
constexpr int MAXIMUM_EVALUATIONS = 2;  // of a function about a sign change of its rate
constexpr int PARABOLAS = 4;  // about a maximum of a function whose rate is not known
constexpr double NEAR_GREATEST = 0.9, SAME_MAXIMUM = 1e-3;  // of the greatest value so far; of the interval about a maximum

struct Bracket {
  double low, high, middle;
};  // before the event, after it, the last point evaluated

// Bisects 0 to `longest` about an event down to `width`; `before(x)` is true at 0 and false at `longest`.
template <class Before>
Bracket bisected(const Before &before, double longest, double width) {
  Bracket bracket{0.0, longest, 0.5 * longest};
  for (int i = 0; i < MAX_BISECTIONS; i++) {
    bracket.middle = 0.5 * (bracket.low + bracket.high);
    (before(bracket.middle) ? bracket.low : bracket.high) = bracket.middle;
    if (!(bracket.high - bracket.low > width)) break;
  }
  return bracket;
}

struct ValueAndRate {
  double value, rate;
};

// Fraction of a step [s] at which the cubic with these ends changes its sign.
inline double crossing(double step, const ValueAndRate &start, const ValueAndRate &end) {
  auto before = [&](double fraction) {
    return (hermite(fraction, step, start.value, start.rate, end.value, end.rate) > 0.0) == (start.value > 0.0);
  };
  Bracket bracket = bisected(before, 1.0, 1e-14);
  return 0.5 * (bracket.low + bracket.high);
}

// Length [s] of the step from `state` at whose end `value(after)` has just changed its sign, by regula falsi with the weights of
// the Illinois method. `make_step(length)` writes the end of such a step to `after`, which holds that of `step`, where the sign has
// changed. A value not above `negligible` counts as zero.
template <class State, class Value, class MakeStep>
double step_to_sign_change(const Value &value, const MakeStep &make_step, State &state, State &after, double step,
                           double negligible) {
  double first = value(state), low = 0.0, value_low = first, high = step, value_high = value(after), length = step;
  int side = 0;
  bool before = false;
  for (int i = 0; i < MAX_REGULA_FALSI; i++) {
    length = (low * value_high - high * value_low) / (value_high - value_low);
    if (!(low < length && length < high)) length = 0.5 * (low + high);
    make_step(length);
    double trial = value(after);
    before = (trial > 0.0) == (first > 0.0);
    if (before) {
      low = length, value_low = trial;
      if (side == 1) value_high *= 0.5;
      side = 1;
    } else {
      high = length, value_high = trial;
      if (side == -1) value_low *= 0.5;
      side = -1;
      if (std::fabs(trial) <= negligible) break;
    }
    if (high - low <= LEAST_WIDTH * step) break;
  }
  if (before) make_step(length = high);
  return length;
}

// The greater of `greatest` and the maximum of a function within a step [s], located by the zero of its rate by regula falsi;
// the remaining distance to the maximum is that of a parabola with this rate. `evaluate(time)` is the function `time` [s] after the start.
template <class Evaluate>
double greatest_within(const Evaluate &evaluate, double step, const ValueAndRate &start, const ValueAndRate &end, double greatest) {
  greatest = std::max({greatest, start.value, end.value});
  if (!(start.rate > 0.0 && 0.0 > end.rate) || std::max(start.value, end.value) < NEAR_GREATEST * greatest) return greatest;
  double low = 0.0, rise = start.rate, high = step, fall = end.rate;
  for (int i = 0; i < MAXIMUM_EVALUATIONS; i++) {
    double time = (rise * high - fall * low) / (rise - fall), curvature = (rise - fall) / (high - low);
    auto [value, rate] = evaluate(time);
    greatest = std::max(greatest, value + 0.5 * rate * rate / curvature);
    if (rate > 0.0) low = time, rise = rate;
    else high = time, fall = rate;
    if (rate == 0.0 || !(low < high)) break;
  }
  return greatest;
}

// The maximum, within `low` to `high`, of the parabola through three values, of which that at `centre` is the greatest.
inline double parabola_maximum(double low, double centre, double high, double first, double middle, double last) {
  double rise = (middle - first) / (centre - low), fall = (middle - last) / (high - centre);
  double maximum = centre + 0.5 * (rise * (high - centre) - fall * (centre - low)) / (rise + fall);
  return std::min(std::max(maximum, low), high);
}

// The values at both ends of the step before the last, and its length [s].
struct Trail {
  double before, last, step;
};

// Refines a maximum, not far below the `greatest` so far, that three ends of steps enclose: evaluates the function at the maximum of
// the parabola through the three points about the greatest value. `trail` advances to the last step, of `step` [s], with the value
// `end` at its end. `evaluate(previous, time)` is the value `time` [s] after the start of the last step, where the step before is
// `previous` [s] long.
template <class Evaluate>
void refine_maximum(const Evaluate &evaluate, Trail &trail, double step, double end, double greatest) {
  double first = trail.before, middle = trail.last, last = end, previous = trail.step;
  trail = {middle, end, step};
  if (!(middle >= first && middle > last && middle > NEAR_GREATEST * greatest && previous > 0.0)) return;
  double low = -previous, centre = 0.0, high = step;
  for (int i = 0; i < PARABOLAS; i++) {
    double maximum = parabola_maximum(low, centre, high, first, middle, last), value = evaluate(previous, maximum);
    if (std::fabs(maximum - centre) <= SAME_MAXIMUM * (high - low)) return;
    if (value <= middle) {
      if (maximum > centre) high = maximum, last = value;
      else low = maximum, first = value;
      continue;
    }
    if (maximum > centre) low = centre, first = middle;
    else high = centre, last = middle;
    centre = maximum, middle = value;
  }
}

}  // namespace core
