// Paper 2, eq. (9): the contact force of a sphere on a beam as a Volterra integral equation, by product integration.
//
//     (f / c)^(2/3) = s_0(t) - w_0(t) - integral of f(u) [(t - u) / m + G(t - u)] du - tail f(t),
//     G(t) = sum shape^2 / (modal mass * Im lambda) exp(Re lambda t) sin(Im lambda t),
//
// s_0 and w_0 being sphere and beam without the force. The force is piecewise linear on even steps and the kernel is
// integrated exactly against it, so that the error falls as step^2. The kernel is a sum of exponentials and a power of
// time: what the force has done so far is known from the modes and the sphere alone, and each step is one scalar
// equation, solved by Newton's method; Picard's iteration diverges in steps longer than a fifth to a half of the contact.
#pragma once
#include <functional>
#include "../methods/events.hpp"
#include "pieces.hpp"

namespace core::beam {

class Volterra {
 public:
  Volterra(const Impact &impact, double length) : impact(impact), length(length) {}

  // One contact, as `Collocation::contact`.
  Status contact(int &first) {
    int &piece = first;
    double low = 0.0;
    steps.set(impact.modes, length);
    double compliance = response(steps, 0.0, 1.0) + impact.modes.tail;
    for (; piece + 1 < impact.room; piece++) {
      if (*impact.stop) return STOPPED;
      double high = load(free_approach(piece, steps, low), compliance);
      if (!std::isfinite(high)) return NOT_FINITE;
      if (high <= 0.0) {
        ModeSteps last;
        double before = impact.sphere.approach(low), after = 0.0;
        auto make = [&](double span) {
          last.set(impact.modes, span);
          after = free_approach(piece, last, low);
        };
        make(length);
        if (after < 0.0 && before > 0.0) landing_step(std::identity{}, make, before, after, length, NEAR_ZERO * before);
        impact.close(piece++, last.span, line(low, 0.0), last);
        return SEPARATED;
      }
      impact.close(piece, length, line(low, high), steps);
      low = high;
      if (impact.start[piece + 1] >= impact.until) return piece++, TIME_UP;
    }
    return FULL;
  }

 private:
  const Impact &impact;
  double length;
  ModeSteps steps;

  static Force line(double low, double high) { return {low, high - low, 0.0, 0.0}; }

  // Approach [m] lost at the end of a step by a force that goes from `low` to `high` in it.
  double response(const ModeSteps &step, double low, double high) const {
    Force force = line(low, high);
    return drop(impact.sphere.mass, step.span, force) + force[0] * step.gain[0] + force[1] * step.gain[1];
  }

  // Approach [m] at the end of a step over which the force falls from `low` to zero.
  double free_approach(int piece, const ModeSteps &step, double low) const {
    double travel = impact.sphere.free_position(impact.motion[piece], step.span);
    return travel - step.free_deflection(impact.modes, impact.state(piece)) - response(step, low, 0.0);
  }

  // Force [N] with (f / c)^(2/3) + compliance f = approach, by Newton's method on y = f^(1/3); zero for a gap.
  double load(double approach, double compliance) const {
    if (approach <= 0.0) return 0.0;
    double scale = impact.sphere.approach(1.0), y = std::sqrt(approach / scale);
    for (int iteration = 0; iteration < 100; iteration++) {
      double change = (y * y * (scale + compliance * y) - approach) / (y * (2.0 * scale + 3.0 * compliance * y));
      y -= change;
      if (std::fabs(change) <= 1e-15 * y) break;
    }
    return y * y * y;
  }
};

}  // namespace core::beam
