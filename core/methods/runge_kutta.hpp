// Explicit Runge-Kutta methods. `error` weighs all slopes and that at the new state for the error estimate; all zero: none.
#pragma once
#include "rosenbrock.hpp"

namespace core {

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

}  // namespace core
