// Methods of at most six stages for systems of bodies, how their steps are controlled, and the loop that steps all together.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include "../math/linear.hpp"

namespace core {

// Status and cost of a stretch of an integration (bearing_twin/methods.py), and the control of steps.

constexpr double LEAST_STEP = 1e-15;  // s; a shorter step is lost in the time
constexpr double NEGLIGIBLE = 1e-12;  // share of a stretch that is too short for a step

enum Status { OK, NOT_FINITE, TOO_DEEP, STALLED, FULL, SEPARATED, TIME_UP, STOPPED, UNTRACKED };

struct Counts { std::int64_t steps, rejections, evaluations; };

// The step that should just meet an error of 1, given the error of this one; changes by 0.2 to 6 at most.
inline double next_step(double step, double error, int order) {
  if (!(error < HUGE_VAL)) return 0.2 * step;
  double least = std::max(error, 1e-10);
  double root = order == 4 ? std::sqrt(std::sqrt(least)) : std::pow(least, 1.0 / order);
  return step * std::min(6.0, std::max(0.2, 0.9 / root));
}

// Rosenbrock methods in transformed form (Hairer and Wanner, Solving ODE II, section IV.7) and the control of their
// steps: with W = I/(h gamma) - J the stages solve
//     W k_i = f(t + alpha_i h, y + sum_j a_ij k_j) + sum_j (c_ij / h) k_j + h d_i df/dt.
// The methods are stiffly accurate: the last stage is the error estimate, and added to the last stage's state it gives
// the new one.

constexpr int MOST_STAGES = 6;
constexpr double TIME_DIFFERENCE = 1e-6;  // share of a step over which df/dt is taken

struct RosenbrockMethod {
  int stages, order;
  bool ends_steps_at_contacts;
  double gamma, a[MOST_STAGES][MOST_STAGES - 1], c[MOST_STAGES][MOST_STAGES - 1], alpha[MOST_STAGES], d[MOST_STAGES];
  double dense[2][MOST_STAGES - 1];

  // True if a later stage lies where the first does, so that its rates are the same.
  bool repeats_first(int stage) const {
    double away = alpha[stage];
    for (int before = 0; before < stage; before++) away += std::fabs(a[stage][before]);
    return stage > 0 && away == 0.0;
  }
};

// The interpolant at a fraction of a step, from its start, its end and two terms.
template <class T, class F>
inline T interpolated(const F &fraction, const T &start, const T &end, const T &third, const T &fourth) {
  F rest = 1.0 - fraction;
  return start * rest + fraction * (end + rest * (third + fraction * fourth));
}

// Start and end of a step, its stages, and the two terms of its interpolant.
template <class State>
struct StepStates {
  State start{}, end{}, stage[MOST_STAGES]{}, third{}, fourth{};

  // Weighted sum of the first I stages in column c.
  template <int I>
  [[gnu::always_inline]] inline auto weighted(const double *weight, int c) const {
    auto sum = weight[0] * stage[0][c];
    if constexpr (I > 1)
      for (int i = 1; i < I; i++) sum += weight[i] * stage[i][c];
    return sum;
  }
  [[gnu::always_inline]] inline void prepare_interpolant(const RosenbrockMethod &method, int c) {
    third[c] = weighted<MOST_STAGES - 1>(method.dense[0], c);
    fourth[c] = weighted<MOST_STAGES - 1>(method.dense[1], c);
  }
  template <class F>
  [[gnu::always_inline]] inline auto inside(const F &fraction, int c) const {
    return interpolated(fraction, start[c], end[c], third[c], fourth[c]);
  }
};

// Explicit Runge-Kutta methods. `error` weighs all slopes and that at the new state for the error estimate; all zero: none.

struct RungeKuttaMethod {
  int stages, order;
  double a[MOST_STAGES][MOST_STAGES - 1], node[MOST_STAGES], weight[MOST_STAGES], error[MOST_STAGES + 1];

  bool adapts() const {
    return std::any_of(error, error + stages + 1, [](double one) { return one != 0.0; });
  }
};

// A number at a share of a step [s], by the cubic with these values and rates at its ends.
template <class T>
inline T hermite(double share, double step, const T &start, const T &start_rate, const T &end, const T &end_rate) {
  double rest = 1.0 - share;
  T value = rest * rest * ((1.0 + 2.0 * share) * start + share * step * start_rate);
  return value + share * share * ((3.0 - 2.0 * share) * end - rest * step * end_rate);
}

// The loop of methods that step all bodies together, with one step size, so that instants are ends of steps.

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

// Rosenbrock steps of one system of few numbers whose Jacobian is dense. The first MOVING of its NUMBERS decide how all
// change; the others are integrals over time, which cost a row of the Jacobian each and add nothing to the equations.

constexpr double AROUND = 1e-3;  // tuned: share of a step on either side, over which the rates' change with time is taken

template <int NUMBERS, int MOVING>
class DenseRosenbrock {
 public:
  using State = std::array<double, NUMBERS>;
  using Jacobian = std::array<std::array<double, MOVING>, NUMBERS>;
  using Scales = std::array<double, MOVING>;
  State after{};

  // `scales` are errors that count as 1.
  DenseRosenbrock(const RosenbrockMethod &method, const Scales &scales) : method(method), scales(scales) {}

  // Evaluations of the rates in a step.
  int evaluations() const { return method.stages + 2; }

  // Makes `after` the state `step` [s] later; returns the error as a root mean square. `System` has
  // rates(time, state, rates), and rates_and_jacobian(time, state, rates, jacobian) with the derivatives by the moving numbers.
  template <class System>
  double make(System &system, double time, const State &state, double step) {
    const double inverse = 1.0 / (method.gamma * step);
    State before, change, rates;
    system.rates(time - AROUND * step, state, before);
    system.rates(time + AROUND * step, state, change);
    for (int n = 0; n < NUMBERS; n++) change[n] = (change[n] - before[n]) / (2.0 * AROUND);  // times the step
    for (int i = 0; i < method.stages; i++) {
      after = state;
      for (int j = 0; j < i; j++)
        for (int n = 0; n < NUMBERS; n++) after[n] += method.a[i][j] * stage[j][n];
      if (i == 0) {
        system.rates_and_jacobian(time, state, rates, jacobian);
        factorise(inverse);
      } else {
        system.rates(time + method.alpha[i] * step, after, rates);
      }
      State &right = stage[i];
      for (int n = 0; n < NUMBERS; n++) {
        right[n] = rates[n] + method.d[i] * change[n];
        for (int j = 0; j < i; j++) right[n] += method.c[i][j] / step * stage[j][n];
      }
      solve(right, inverse);
    }
    const State &last = stage[method.stages - 1];
    double error = 0.0;
    for (int n = 0; n < NUMBERS; n++) after[n] += last[n];
    for (int n = 0; n < MOVING; n++) error += (last[n] / scales[n]) * (last[n] / scales[n]);
    return std::sqrt(error / MOVING);
  }

  // One of the two terms of the last step's interpolant; see `interpolated`.
  State dense_term(int which) const {
    State term{};
    for (int j = 0; j < method.stages - 1; j++)
      for (int n = 0; n < NUMBERS; n++) term[n] += method.dense[which][j] * stage[j][n];
    return term;
  }

 private:
  const RosenbrockMethod &method;
  const Scales scales;
  State stage[MOST_STAGES];
  Jacobian jacobian;
  double factors[MOVING][MOVING];
  int exchange[MOVING];

  // Factors of 1/(gamma step) - J for the moving numbers.
  void factorise(double inverse) {
    for (int r = 0; r < MOVING; r++)
      for (int n = 0; n < MOVING; n++) factors[r][n] = (r == n ? inverse : 0.0) - jacobian[r][n];
    factorise_dense(MOVING, [this](int i, int j) -> double & { return factors[i][j]; }, exchange);
  }
  void solve(State &right, double inverse) const {
    substitute_dense(MOVING, [this](int i, int j) { return factors[i][j]; }, exchange, right);
    for (int r = MOVING; r < NUMBERS; r++) {
      for (int n = 0; n < MOVING; n++) right[r] += jacobian[r][n] * right[n];
      right[r] /= inverse;
    }
  }
};

}  // namespace core
