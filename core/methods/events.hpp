// Where within a step something happens: between a place before it and one after it, and at the top of a curve.
#pragma once
#include <algorithm>
#include <cmath>
#include "rosenbrock.hpp"

namespace core {

constexpr int MOST_HALVINGS = 100, MOST_LOOKS = 100;  // the second of regula falsi
constexpr double CLOSE = 4e-16;  // share of a step that is no shorter
constexpr int TOP_LOOKS = 2;  // at a number where its rate changes its sign
constexpr double NEAR_GREATEST = 0.9, SAME_TOP = 1e-3;  // of the greatest value so far; of the span between places about a top

struct Halved { double low, high, middle; };  // the last place before, the first after, the last tried

// Halves 0 to `longest` about an event until `width` is left; `before(place)` is true at 0 and false at `longest`.
template <class Before>
Halved halved(const Before &before, double longest, double width) {
  Halved found{0.0, longest, 0.5 * longest};
  for (int i = 0; i < MOST_HALVINGS; i++) {
    found.middle = 0.5 * (found.low + found.high);
    (before(found.middle) ? found.low : found.high) = found.middle;
    if (!(found.high - found.low > width)) break;
  }
  return found;
}

struct ValueAndRate { double value, rate; };

// Share of a step [s] at which a number, the cubic with these ends, changes its sign.
inline double crossing(double step, const ValueAndRate &start, const ValueAndRate &end) {
  auto before = [&](double share) {
    return (hermite(share, step, start.value, start.rate, end.value, end.rate) > 0.0) == (start.value > 0.0);
  };
  Halved found = halved(before, 1.0, 1e-14);
  return 0.5 * (found.low + found.high);
}

// Length [s] of the step from `state` at whose end `value(after)` has just changed its sign; `make(length)` writes the end of
// such a step to `after`, which has that of `step`, where the sign has changed. By regula falsi with Illinois' weights; a
// value not above `nearest` is as good as zero.
template <class State, class Value, class Make>
double landing_step(const Value &value, const Make &make, State &state, State &after, double step, double nearest) {
  double first = value(state), low = 0.0, value_low = first, high = step, value_high = value(after), length = step;
  int side = 0;
  bool before = false;
  for (int look = 0; look < MOST_LOOKS; look++) {
    length = (low * value_high - high * value_low) / (value_high - value_low);
    if (!(low < length && length < high)) length = 0.5 * (low + high);
    make(length);
    double found = value(after);
    before = (found > 0.0) == (first > 0.0);
    if (before) {
      low = length, value_low = found;
      if (side == 1) value_high *= 0.5;
      side = 1;
    } else {
      high = length, value_high = found;
      if (side == -1) value_low *= 0.5;
      side = -1;
      if (std::fabs(found) <= nearest) break;
    }
    if (high - low <= CLOSE * step) break;
  }
  if (before) make(length = high);
  return length;
}

// The greater of `greatest` and the most that a number comes to in a step [s], by the zero of its rate. `look(place)` is the
// number `place` [s] after the start. By regula falsi; what the last look is still off the top goes with the square of its rate.
template <class Look>
double greatest_within(const Look &look, double step, const ValueAndRate &start, const ValueAndRate &end, double greatest) {
  greatest = std::max({greatest, start.value, end.value});
  if (!(start.rate > 0.0 && 0.0 > end.rate) || std::max(start.value, end.value) < NEAR_GREATEST * greatest) return greatest;
  double low = 0.0, rise = start.rate, high = step, fall = end.rate;
  for (int i = 0; i < TOP_LOOKS; i++) {
    double place = (rise * high - fall * low) / (rise - fall), bend = (rise - fall) / (high - low);
    auto [value, rate] = look(place);
    greatest = std::max(greatest, value + 0.5 * rate * rate / bend);
    if (rate > 0.0) low = place, rise = rate;
    else high = place, fall = rate;
    if (rate == 0.0 || !(low < high)) break;
  }
  return greatest;
}

// Where, from `low` to `high`, the parabola through three values is greatest; the `middle` one is the greatest.
inline double parabola_top(double low, double at, double high, double first, double middle, double last) {
  double rise = (middle - first) / (at - low), fall = (middle - last) / (high - at);
  double top = at + 0.5 * (rise * (high - at) - fall * (at - low)) / (rise + fall);
  return std::min(std::max(top, low), high);
}

// The values at both ends of the step before the last, and its length [s].
struct Trail { double before, last, step; };

// Where three ends of steps show a top not far below the `greatest` so far, looks at it so many times, always at the top of
// the parabola through the three places about the greatest value. `trail` is moved on to the last step, of `step` [s] with
// the value `end` at its end. `look(back, place)` is the value `place` [s] after the start of the last step, the one before
// being `back` [s] long.
template <class Look>
void look_at_top(const Look &look, Trail &trail, double step, double end, double greatest, int rounds) {
  double first = trail.before, middle = trail.last, last = end, back = trail.step;
  trail = {middle, end, step};
  if (!(middle >= first && middle > last && middle > NEAR_GREATEST * greatest && back > 0.0)) return;
  double low = -back, at = 0.0, high = step;
  for (int i = 0; i < rounds; i++) {
    double top = parabola_top(low, at, high, first, middle, last), found = look(back, top);
    if (found <= middle || std::fabs(top - at) <= SAME_TOP * (high - low)) return;
    if (top > at) low = at, first = middle;
    else high = at, last = middle;
    at = top, middle = found;
  }
}

}  // namespace core
