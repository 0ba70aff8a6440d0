// The motion of a sphere and a beam in pieces of time, within each of which the force between them is a cubic.
#pragma once
#include <algorithm>
#include <cstdint>
#include "../contact/laws.hpp"
#include "modes.hpp"

namespace core::beam {

// Shares of a piece at which work is summed and forces are found: the points of Gauss and Lobatto for four values.
constexpr double ROOT5 = 2.23606797749978969641;
constexpr double POINTS[TERMS] = {0.0, 0.5 - 0.1 * ROOT5, 0.5 + 0.1 * ROOT5, 1.0};
constexpr double WEIGHTS[TERMS] = {1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0};

constexpr double NEAR_ZERO = 1e-13;  // of the approach at the start of a last step: as good as separated

struct SphereMotion {
  double position, velocity;  // along the motion before the impact
};

// How far [m] a force holds a sphere back over a span.
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
  double until;                       // [s]
  const volatile std::uint8_t *stop;  // not 0 once somebody wants it to stop
  int room;                           // pieces that the arrays hold
  double *start, *length;
  Force *force;
  Complex *states;  // (room, modes)
  SphereMotion *motion;
  double *work;  // [J] on the beam

  Complex *state(int piece) const { return states + std::int64_t(piece) * modes.count; }

  // Closes a piece of that length and force, and begins the next.
  void close(int piece, double span, const Force &given, const ModeSteps &steps) const {
    length[piece] = span, force[piece] = given;
    start[piece + 1] = start[piece] + span;
    steps.move(modes, given, state(piece), state(piece + 1));
    motion[piece + 1] = sphere.moved(motion[piece], span, given);
    work[piece] = given.is_zero() ? 0.0 : work_of(motion[piece], span, given);
  }
  // Work [J] on the beam: [f w] less the integral of f' w, its deflection w being the sphere's travel less the approach.
  double work_of(SphereMotion begin, double span, const Force &given) const {
    double sum = 0.0;
    for (int i = 0; i < TERMS; i++) {
      double share = POINTS[i], load = given.at(share);
      double travel = sphere.free_position(begin, share * span) - drop(sphere.mass, share * span, given.beginning(share));
      double deflection = travel - sphere.approach(load);
      double edge = i == 0 ? -load : i == TERMS - 1 ? load : 0.0;
      sum += deflection * (edge - WEIGHTS[i] * given.slope(share));
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

}  // namespace core::beam
