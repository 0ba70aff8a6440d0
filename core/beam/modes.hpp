// Modes of a beam under a force at one point, which is a cubic in time: each mode is one complex number, and moves exactly.
//
//     z' = lambda z + f shape / (modal mass),   coordinate of the mode q = Im z / Im lambda.
//
// bearing_twin/kinds/beam/motion.py says where the modes come from.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>
#include "../contact/laws.hpp"

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

// A force [N] by powers of the fraction u = 0 .. 1 of a time span.
struct Force : std::array<double, TERMS> {
  bool is_zero() const { return (*this)[0] == 0.0 && (*this)[1] == 0.0 && (*this)[2] == 0.0 && (*this)[3] == 0.0; }
  double value_at(double share) const {
    const Force &f = *this;
    return f[0] + share * (f[1] + share * (f[2] + share * f[3]));
  }
  double slope(double share) const {
    const Force &f = *this;
    return f[1] + share * (2.0 * f[2] + share * 3.0 * f[3]);
  }
  // The same force over the first `share` of the span.
  Force first_part(double share) const {
    Force scaled = *this;
    double power = 1.0;
    for (double &coefficient : scaled) coefficient *= power, power *= share;
    return scaled;
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
  std::vector<ModeStep> mode;
  Force compliance_of_powers{};  // deflection [m] at the point of impact, at the end of the span, by each power of a unit force

  void set(const Modes &modes, double length) {
    if (length == span) return;
    span = length, compliance_of_powers = {};
    mode.resize(modes.count);
    for (int n = 0; n < modes.count; n++) {
      mode[n] = mode_step(span * modes.rate[n]);
      for (int k = 0; k < TERMS; k++) compliance_of_powers[k] += modes.compliance[n] * modes.push[n] * span * mode[n].moment[k].im;
    }
  }
  void move(const Modes &modes, const Force &force, const Complex *start, Complex *end) const {
    for (int n = 0; n < modes.count; n++) end[n] = mode[n].turn * start[n] + modes.push[n] * span * mode[n].pushed(force);
  }
  // Deflection [m] at the point of impact after the span without a force.
  double free_deflection(const Modes &modes, const Complex *start) const {
    double sum = 0.0;
    for (int n = 0; n < modes.count; n++) sum += modes.compliance[n] * (mode[n].turn * start[n]).im;
    return sum;
  }
};

// The motion of a sphere and a beam in pieces of time: contacts and the free flights between them. Within each piece the force is
// a cubic.

// Fractions of a piece at which work is summed and forces are computed: the points of Gauss and Lobatto for four values.
constexpr double ROOT5 = 2.23606797749978969641;
constexpr double POINTS[TERMS] = {0.0, 0.5 - 0.1 * ROOT5, 0.5 + 0.1 * ROOT5, 1.0};
constexpr double WEIGHTS[TERMS] = {1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0};

constexpr double NEAR_ZERO = 1e-13;  // of the approach at the start of a last step: as good as separated

struct SphereMotion {
  double position, velocity;  // along the motion before the impact
};

// Distance [m] by which a force holds a sphere back over a span.
inline double drop(double mass, double span, const Force &force) {
  double sum = 0.0;
  for (int k = 0; k < TERMS; k++) sum += force[k] / ((k + 1) * (k + 2));
  return span * span * sum / mass;
}

struct Sphere {
  double mass, coefficient, gravity;  // [kg], of Hertz's spring [N/m^1.5], along its motion [m/s^2]

  auto spring(double approach) const { return elastic(coefficient, HERTZIAN, approach); }
  double approach(double load) const { return approach_of_load(coefficient, HERTZIAN, std::max(load, 0.0)); }
  double free_position(SphereMotion start, double span) const {
    return start.position + span * (start.velocity + 0.5 * gravity * span);
  }
  SphereMotion moved(SphereMotion start, double span, const Force &force) const {
    double impulse = 0.0;
    for (int k = 0; k < TERMS; k++) impulse += force[k] * span / (k + 1);
    return {free_position(start, span) - drop(mass, span, force), start.velocity + gravity * span - impulse / mass};
  }
};

struct Impact {
  Modes modes;
  Sphere sphere;
  double end_time;                       // [s]
  const volatile std::uint8_t *stop;  // not 0 once a stop is requested
  int capacity;                           // pieces that the arrays hold
  double *start, *length;
  Force *force;
  Complex *states;  // (capacity, modes)
  SphereMotion *motion;
  double *work;  // [J] on the beam

  Complex *state(int piece) const { return states + std::int64_t(piece) * modes.count; }

  // Ends a piece with that length and force, and starts the next one.
  void close(int piece, double span, const Force &piece_force, const ModeSteps &steps) const {
    length[piece] = span, force[piece] = piece_force;
    start[piece + 1] = start[piece] + span;
    steps.move(modes, piece_force, state(piece), state(piece + 1));
    motion[piece + 1] = sphere.moved(motion[piece], span, piece_force);
    work[piece] = piece_force.is_zero() ? 0.0 : beam_work(motion[piece], span, piece_force);
  }
  // Work [J] on the beam: [f w] less the integral of f' w, its deflection w being the sphere's travel less the approach.
  double beam_work(SphereMotion begin, double span, const Force &piece_force) const {
    double sum = 0.0;
    for (int i = 0; i < TERMS; i++) {
      double share = POINTS[i], load = piece_force.value_at(share);
      double travel = sphere.free_position(begin, share * span) - drop(sphere.mass, share * span, piece_force.first_part(share));
      double deflection = travel - sphere.approach(load);
      double edge = i == 0 ? -load : i == TERMS - 1 ? load : 0.0;
      sum += deflection * (edge - WEIGHTS[i] * piece_force.slope(share));
    }
    return sum;
  }
  // d(approach) / dt at the start of a piece without a force.
  double approach_rate(int piece) const {
    double rate = motion[piece].velocity;
    for (int n = 0; n < modes.count; n++) {
      Complex z = state(piece)[n];
      rate -= modes.shape[n] * (z.re + modes.rate[n].re * z.im / modes.rate[n].im);
    }
    return rate;
  }
};

// Sphere and beam separated: both move in closed form, and the next touch is found without stepping over any.

struct Approach {
  double value, rate;  // [m], [m/s]
};

// The approach `time` [s] after the start of a piece of free flight.
inline Approach approach_after(const Impact &impact, int piece, double time) {
  SphereMotion start = impact.motion[piece];
  Approach approach{impact.sphere.free_position(start, time), start.velocity + impact.sphere.gravity * time};
  for (int n = 0; n < impact.modes.count; n++) {
    Complex rate = impact.modes.rate[n], z = exponential(time * rate) * impact.state(piece)[n];
    approach.value -= impact.modes.compliance[n] * z.im;
    approach.rate -= impact.modes.shape[n] * (z.re + rate.re * z.im / rate.im);
  }
  return approach;
}

// Time [s] until sphere and freely swinging beam touch again, `limit` if not before, infinite if never.
//
// No contact is missed: the second derivative of the approach is at most  B = g + sum |shape lambda^2 z| / Im lambda, so that a gap
// remains until alpha + alpha' t + B t^2 / 2 = 0, which is iterated; contacts shorter than `shortest` [s] are ignored.
inline double next_touch(const Impact &impact, int piece, double limit, double shortest) {
  const Sphere &sphere = impact.sphere;
  SphereMotion start = impact.motion[piece];
  double max_acceleration = std::fabs(sphere.gravity), reach = 0.0, time = 0.0;
  for (int n = 0; n < impact.modes.count; n++) {
    Complex rate = impact.modes.rate[n], z = impact.state(piece)[n];
    double size = std::fabs(impact.modes.compliance[n]) * std::hypot(z.re, z.im);
    reach += size;
    max_acceleration += size * (rate.re * rate.re + rate.im * rate.im);
  }
  for (int i = 0; i < 10'000'000; i++) {
    Approach approach = approach_after(impact, piece, time);
    bool leaves = sphere.gravity <= 0.0 && start.velocity + sphere.gravity * time <= 0.0;
    if (leaves && sphere.free_position(start, time) < -reach) return std::numeric_limits<double>::infinity();
    if (time >= limit || !std::isfinite(approach.value) || *impact.stop) return limit;
    if (approach.value >= 0.0 && approach.rate > 0.0 && time > 0.0) return time;
    double depth = std::max(-approach.value, 0.0), root = std::sqrt(approach.rate * approach.rate + 2.0 * max_acceleration * depth);
    // (root - rate) / bend without cancellation for a closing gap
    double safe_step = approach.rate > 0.0 ? 2.0 * depth / (root + approach.rate) : (root - approach.rate) / max_acceleration;
    time += std::max(safe_step, shortest);
  }
  return limit;
}

}  // namespace core::beam
