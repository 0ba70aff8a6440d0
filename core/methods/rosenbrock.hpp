// Rosenbrock methods in transformed form (Hairer and Wanner, Solving ODE II, section IV.7) and the control of their
// steps: with W = I/(h gamma) - J the stages solve
//     W k_i = f(t + alpha_i h, y + sum_j a_ij k_j) + sum_j (c_ij / h) k_j + h d_i df/dt.
// The methods are stiffly accurate: the last stage is the error estimate, and added to the last stage's state it gives
// the new one.
#pragma once
#include "control.hpp"

namespace core {

constexpr int MOST_STAGES = 6;
constexpr double TIME_DIFFERENCE = 1e-6;  // share of a step over which df/dt is taken

struct RosenbrockMethod {
  int stages, order;
  bool ends_steps_at_contacts;
  double gamma, a[MOST_STAGES][MOST_STAGES - 1], c[MOST_STAGES][MOST_STAGES - 1], alpha[MOST_STAGES], d[MOST_STAGES];
  double dense[2][MOST_STAGES - 1];

  // Whether a later stage lies where the first does, so that its rates are the same.
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

}  // namespace core
