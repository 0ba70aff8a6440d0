// Rosenbrock steps of one system of few numbers whose Jacobian is dense. The first MOVING of its NUMBERS decide how all
// change; the others are integrals over time, which cost a row of the Jacobian each and add nothing to the equations.
#pragma once
#include <array>
#include <cstdint>
#include "../math/dense_solve.hpp"
#include "rosenbrock.hpp"

namespace core {

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
