// The viscous part d(h) dh/dt of the normal load, d(h) -> 0 as h -> 0 (paper 1, section 5), and what steps in a contact follow.
#pragma once
#include <algorithm>
#include "../math/dual.hpp"

namespace core {

// Normal load [N] of an elastic one with its stiffness [N/m] and a viscous part in proportion to both; below zero where the
// bodies would have to pull.
template <class L, class S, class R>
CORE_INLINE auto proportional_load(const L &load, const S &stiffness, const R &approach_rate, double damping, double relaxation_time) {
  return load + (damping * load + relaxation_time * stiffness) * approach_rate;
}

// proportional: d(h) = number * load + relaxation_time * stiffness. The first part is Hunt and Crossley's (1975), `number`
//     [s/m]: restitution falls with speed. The second is a viscoelastic half-space's (Brilliantov et al. 1996) [s]: the damping
//     proportional to stiffness that Kraemer (1993) gives for rolling bearings.
// steady: d(h) = number * h^((p - 1)/2), after Tsuji, Tanaka and Ishida (Powder Technology 71, 1992), in N s/m^(5/4) for
//     Hertz's power p = 1.5, in N s/m for a linear spring. In s = (2/sqrt 5) h^(5/4) it is a linear oscillator, so restitution
//     is the same at every speed.
// steady_ratio: the same by the damping ratio, `number` [1], of that oscillator.
enum class DampingLaw { proportional, steady, steady_ratio };

struct Damping {
  DampingLaw law;
  double number, relaxation_time;

  // Normal load [N] with the viscous part, below zero where the bodies would have to pull. The elastic contact has the
  // coefficient c [N/m^p], a load [N] and a stiffness d(load)/dh [N/m] at its approach [m], which changes at a rate [m/s];
  // `mass` [kg] is what moves, m1 m2/(m1 + m2) in central impact.
  double pulling_load(double coefficient, double power, double elastic_load, double stiffness, double mass, double approach,
                      double approach_rate) const {
    double factor = number;
    switch (law) {
      case DampingLaw::proportional: return proportional_load(elastic_load, stiffness, approach_rate, number, relaxation_time);
      case DampingLaw::steady_ratio: factor *= std::sqrt(2.0 * (power + 1.0) * mass * coefficient); [[fallthrough]];
      case DampingLaw::steady: break;
    }
    double depth = std::max(approach, 0.0);
    double root = power == 1.5 ? std::sqrt(std::sqrt(depth)) : std::pow(depth, 0.5 * (power - 1.0));
    return elastic_load + factor * root * approach_rate;
  }
  // The same, zero in a gap and where it would pull: the contact ends there, and the elastic energy that is left is lost.
  double load(double coefficient, double power, double elastic_load, double stiffness, double mass, double approach,
              double approach_rate) const {
    if (approach <= 0.0) return 0.0;
    return std::max(pulling_load(coefficient, power, elastic_load, stiffness, mass, approach, approach_rate), 0.0);
  }
};

// The longest step [s] in a contact that has `lasted` [s]; `rate` [1/s] is sqrt(k/m) at the stiffness ahead. A bounce lasts
// 4/rate; beyond 20/rate a contact is none, and left to error control.
inline double longest_contact_step(double lasted, double rate) { return (lasted * rate < 20.0 ? 1.0 / 6.0 : 2.0) / rate; }

}  // namespace core
