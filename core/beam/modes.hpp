// Modes of a beam under a force at one point, which is a cubic in time: each mode is one complex number, and moves exactly.
//
//     z' = lambda z + f shape / (modal mass),   coordinate of the mode q = Im z / Im lambda.
//
// bearing_twin/kinds/beam/modes.py says where the modes come from.
#pragma once
#include <array>
#include <cmath>
#include <vector>

namespace core::beam {

constexpr int TERMS = 4;  // coefficients of a cubic

struct Complex {
  double re, im;
};
inline Complex operator+(Complex a, Complex b) { return {a.re + b.re, a.im + b.im}; }
inline Complex operator*(Complex a, Complex b) { return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re}; }
inline Complex operator*(double a, Complex b) { return {a * b.re, a * b.im}; }
inline Complex exponential(Complex z) {
  double size = z.re == 0.0 ? 1.0 : std::exp(z.re);
  return {size * std::cos(z.im), size * std::sin(z.im)};
}

// A force [N] by powers of the share u = 0 .. 1 of a span of time.
struct Force : std::array<double, TERMS> {
  bool is_zero() const { return (*this)[0] == 0.0 && (*this)[1] == 0.0 && (*this)[2] == 0.0 && (*this)[3] == 0.0; }
  double at(double share) const {
    const Force &f = *this;
    return f[0] + share * (f[1] + share * (f[2] + share * f[3]));
  }
  double slope(double share) const {
    const Force &f = *this;
    return f[1] + share * (2.0 * f[2] + share * 3.0 * f[3]);
  }
  // The same force over the first `share` of the span.
  Force beginning(double share) const {
    Force found = *this;
    double power = 1.0;
    for (double &one : found) one *= power, power *= share;
    return found;
  }
};

struct Modes {
  int count;
  const Complex *rate;   // lambda [1/s]
  const double *shape;   // at the point of impact
  double mass, tail;     // modal mass [kg]; static compliance of all higher modes [m/N]
  std::vector<double> push, compliance;  // z' by a unit force; deflection at the point of impact by a unit Im z

  Modes(int count, const Complex *rate, const double *shape, double mass, double tail)
      : count(count), rate(rate), shape(shape), mass(mass), tail(tail), push(count), compliance(count) {
    for (int n = 0; n < count; n++) push[n] = shape[n] / mass, compliance[n] = shape[n] / rate[n].im;
  }
};

// One mode over a span [s]: z -> turn z + push span (sum of force[k] moment[k]).
struct ModeStep {
  Complex turn;
  std::array<Complex, TERMS> moment;  // integral of exp(z (1 - u)) u^k over u = 0 .. 1

  Complex pushed(const Force &force) const {
    return force[0] * moment[0] + force[1] * moment[1] + force[2] * moment[2] + force[3] * moment[3];
  }
};

// Moments J_k obey z J_k = k J_(k-1) - 1, J_0 = (exp z - 1) / z. That way up it loses digits for small z: there J_3 is the
// series 3! z^m / (m + 4)!, and the others follow downwards.
inline ModeStep mode_step(Complex z) {
  ModeStep step{exponential(z), {}};
  auto &moment = step.moment;
  double size = std::fabs(z.re) + std::fabs(z.im);
  if (size > 5.0) {
    Complex inverse = 1.0 / (z.re * z.re + z.im * z.im) * Complex{z.re, -z.im};
    moment[0] = inverse * (step.turn + Complex{-1.0, 0.0});
    for (int k = 1; k < TERMS; k++) moment[k] = inverse * (k * moment[k - 1] + Complex{-1.0, 0.0});
    return step;
  }
  Complex term{1.0 / TERMS, 0.0}, total = term;
  double bound = term.re;
  for (int m = 1; bound > 1e-18; m++) {
    term = 1.0 / (m + TERMS) * (z * term);
    bound *= size / (m + TERMS);
    total = total + term;
  }
  moment[TERMS - 1] = total;
  for (int k = TERMS - 1; k > 0; k--) moment[k - 1] = 1.0 / k * (z * moment[k] + Complex{1.0, 0.0});
  return step;
}

// All modes after a span [s] of a force that is a cubic over it.
inline void propagate(const Modes &modes, double span, const Force &force, const Complex *start, Complex *end) {
  bool pushes = !force.is_zero();
  for (int n = 0; n < modes.count; n++) {
    Complex z = span * modes.rate[n];
    if (pushes) {
      ModeStep step = mode_step(z);
      end[n] = step.turn * start[n] + modes.push[n] * span * step.pushed(force);
    } else {
      end[n] = exponential(z) * start[n];
    }
  }
}

// The steps of all modes over one span [s], made again when it changes.
struct ModeSteps {
  double span = 0.0;
  std::vector<ModeStep> of;
  Force gain{};  // deflection [m] at the point of impact, at the end of the span, by each power of a unit force

  void set(const Modes &modes, double length) {
    if (length == span) return;
    span = length, gain = {};
    of.resize(modes.count);
    for (int n = 0; n < modes.count; n++) {
      of[n] = mode_step(span * modes.rate[n]);
      for (int k = 0; k < TERMS; k++) gain[k] += modes.compliance[n] * modes.push[n] * span * of[n].moment[k].im;
    }
  }
  void move(const Modes &modes, const Force &force, const Complex *start, Complex *end) const {
    for (int n = 0; n < modes.count; n++)
      end[n] = of[n].turn * start[n] + modes.push[n] * span * of[n].pushed(force);
  }
  // Deflection [m] at the point of impact after the span without a force.
  double free_deflection(const Modes &modes, const Complex *start) const {
    double sum = 0.0;
    for (int n = 0; n < modes.count; n++) sum += modes.compliance[n] * (of[n].turn * start[n]).im;
    return sum;
  }
};

}  // namespace core::beam
