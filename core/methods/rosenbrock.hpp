// Rosenbrock methods in transformed form (Hairer and Wanner, Solving ODE II, section IV.7). With W = I/(h gamma) - J the
// stages u_i solve
//
//     W u_i = f(t + alpha_i h, y + sum_j a_ij u_j) + sum_j (c_ij / h) u_j + h d_i df/dt.
//
// The methods are stiffly accurate: the last stage is the error estimate, and added to the last stage's state it gives
// the new state. Coefficients: bearing_twin/coefficients.py. Steps of bearings: bearing/rosenbrock_balls.cpp.
#pragma once
#include <array>
#include "../math/linear.hpp"
#include "step_control.hpp"

namespace core {

constexpr double TIME_DIFFERENCE = 1e-6;  // fraction of a step over which df/dt is taken

struct RosenbrockMethod {
  int stages, order;
  bool ends_steps_at_contacts;
  double gamma, a[MAX_STAGES][MAX_STAGES - 1], c[MAX_STAGES][MAX_STAGES - 1], alpha[MAX_STAGES], d[MAX_STAGES];
  double dense[2][MAX_STAGES - 1];

  // True if a later stage has the time and the state of the first one, so that its rates are the same.
  bool repeats_first(int stage) const {
    double distance = alpha[stage];
    for (int j = 0; j < stage; j++) distance += std::fabs(a[stage][j]);
    return stage > 0 && distance == 0.0;
  }
};

// Dense output at a fraction of a step, from its start, its end and two terms.
template <class T, class F>
inline T interpolated(const F &fraction, const T &start, const T &end, const T &third, const T &fourth) {
  F complement = 1.0 - fraction;
  return start * complement + fraction * (end + complement * (third + fraction * fourth));
}

// Start and end of a step, its stages, and the two terms of its dense output.
template <class State>
struct StepStates {
  State start{}, end{}, stage[MAX_STAGES]{}, third{}, fourth{};

  [[gnu::always_inline]] inline void prepare_dense_output(const RosenbrockMethod &method, int column) {
    third[column] = weighted(method.dense[0], column);
    fourth[column] = weighted(method.dense[1], column);
  }
  template <class F>
  [[gnu::always_inline]] inline auto dense_output(const F &fraction, int column) const {
    return interpolated(fraction, start[column], end[column], third[column], fourth[column]);
  }

 private:
  [[gnu::always_inline]] inline auto weighted(const double *weight, int column) const {
    auto sum = weight[0] * stage[0][column];
    for (int i = 1; i < MAX_STAGES - 1; i++) sum += weight[i] * stage[i][column];
    return sum;
  }
};

// Rosenbrock steps of one small system whose Jacobian is dense. The rates depend on the first MOVING of its NUMBERS; the others
// are integrals over time, which are rows of the Jacobian but no unknowns of the linear system.

constexpr double TIME_OFFSET = 1e-3;  // tuned: fraction of a step on either side, over which df/dt is taken

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
  double step_from(System &system, double time, const State &state, double step) {
    const double diagonal = 1.0 / (method.gamma * step);
    State before, time_derivative, rates;
    system.rates(time - TIME_OFFSET * step, state, before);
    system.rates(time + TIME_OFFSET * step, state, time_derivative);
    for (int n = 0; n < NUMBERS; n++)
      time_derivative[n] = (time_derivative[n] - before[n]) / (2.0 * TIME_OFFSET);  // times the step
    for (int i = 0; i < method.stages; i++) {
      after = state;
      for (int j = 0; j < i; j++)
        for (int n = 0; n < NUMBERS; n++) after[n] += method.a[i][j] * stage[j][n];
      if (i == 0) {
        system.rates_and_jacobian(time, state, rates, jacobian);
        factorise(diagonal);
      } else {
        system.rates(time + method.alpha[i] * step, after, rates);
      }
      State &right = stage[i];
      for (int n = 0; n < NUMBERS; n++) {
        right[n] = rates[n] + method.d[i] * time_derivative[n];
        for (int j = 0; j < i; j++) right[n] += method.c[i][j] / step * stage[j][n];
      }
      solve(right, diagonal);
    }
    const State &last = stage[method.stages - 1];
    double error = 0.0;
    for (int n = 0; n < NUMBERS; n++) after[n] += last[n];
    for (int n = 0; n < MOVING; n++) error += (last[n] / scales[n]) * (last[n] / scales[n]);
    return std::sqrt(error / MOVING);
  }

  // One of the two terms of the last step's dense output; see `interpolated`.
  State dense_term(int index) const {
    State term{};
    for (int j = 0; j < method.stages - 1; j++)
      for (int n = 0; n < NUMBERS; n++) term[n] += method.dense[index][j] * stage[j][n];
    return term;
  }

 private:
  const RosenbrockMethod &method;
  const Scales scales;
  State stage[MAX_STAGES];
  Jacobian jacobian;
  double factors[MOVING][MOVING];
  int pivot[MOVING];

  // Factors of 1/(gamma step) - J for the moving numbers.
  void factorise(double diagonal) {
    for (int r = 0; r < MOVING; r++)
      for (int n = 0; n < MOVING; n++) factors[r][n] = (r == n ? diagonal : 0.0) - jacobian[r][n];
    factorise_dense(MOVING, [this](int i, int j) -> double & { return factors[i][j]; }, pivot);
  }
  void solve(State &right, double diagonal) const {
    substitute_dense(MOVING, [this](int i, int j) { return factors[i][j]; }, pivot, right);
    for (int r = MOVING; r < NUMBERS; r++) {
      for (int n = 0; n < MOVING; n++) right[r] += jacobian[r][n] * right[n];
      right[r] /= diagonal;
    }
  }
};

}  // namespace core
