// A rigid body in motion, the laws of its contact, and the record of a contact from touch to parting.
#pragma once
#include "../contact/friction.hpp"
#include "../contact/laws.hpp"
#include "../math/linear.hpp"
#include "../methods/adaptive.hpp"

namespace core {

// A rigid body that moves freely or is held, and its part of a state: m dv/dt = F + m g, dL/dt = M, dq/dt = omega q / 2.

// Unit quaternion (x, y, z, w) from the body's to fixed axes. Steps leave its norm a little off, as it is then read.
using Orientation = std::array<double, 4>;

CORE_INLINE RealMatrix3 rotation_matrix(const Orientation &q) {
  double norm = 1.0 / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  double x = norm * q[0], y = norm * q[1], z = norm * q[2], w = norm * q[3];
  return {{{1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)},
           {2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)},
           {2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)}}};
}
inline Orientation orientation_rate(const Real3 &spin, const Orientation &q) {
  Real3 axis{q[0], q[1], q[2]}, half = 0.5 * spin, rate = q[3] * half + cross(half, axis);
  return {rate[0], rate[1], rate[2], -dot(half, axis)};
}
// Brings the norm back to 1; returns how far it was off.
inline double normalise(Orientation &q) {
  double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double &part : q) part /= norm;
  return std::fabs(norm - 1.0);
}

// Position and velocity [m/s] of the centre, angular momentum about it [kg m^2/s] in fixed axes. The momentum of a held body,
// whose moments of inertia are 1, is its angular velocity.
struct RigidState {
  Real3 position;
  Orientation orientation;
  Real3 velocity, momentum;
};

// Mass [kg], 0 of a held body, and principal moments of inertia [kg m^2].
struct RigidBody {
  double mass;
  Real3 inertia;

  bool held() const { return mass == 0.0; }
  CORE_INLINE Real3 spin(const RigidState &state, const RealMatrix3 &rotation) const {
    Real3 body_momentum = transposed(rotation) * state.momentum;
    return rotation * Real3{body_momentum[0] / inertia[0], body_momentum[1] / inertia[1], body_momentum[2] / inertia[2]};
  }
  // Change of the body's velocity there by a unit impulse along a direction at an arm: 1/m + (r x n) I^-1 (r x n).
  CORE_INLINE double mobility(const RealMatrix3 &rotation, const Real3 &arm, const Real3 &direction) const {
    if (held()) return 0.0;
    Real3 lever = transposed(rotation) * cross(arm, direction);
    return 1.0 / mass + (lever[0] * lever[0] / inertia[0] + lever[1] * lever[1] / inertia[1] + lever[2] * lever[2] / inertia[2]);
  }
  // Rates of a state without forces but gravity [m/s^2].
  RigidState free_rates(const RigidState &state, const Real3 &spin, const Real3 &gravity) const {
    return {state.velocity, orientation_rate(spin, state.orientation), held() ? Real3{} : gravity, {}};
  }
  // Adds a force and a moment about the centre, by `sign`; returns their power on a held body, which does not follow them.
  CORE_INLINE double push(double sign, const Real3 &force, const Real3 &moment, const RigidState &state, const Real3 &spin,
                          RigidState &rates) const {
    if (held()) return sign * (dot(force, state.velocity) + dot(moment, spin));
    rates.velocity = rates.velocity + (sign / mass) * force;
    rates.momentum = rates.momentum + sign * moment;
    return 0.0;
  }
  double kinetic_energy(const RigidState &state, const Real3 &spin) const {
    return held() ? 0.0 : 0.5 * (mass * dot(state.velocity, state.velocity) + dot(state.momentum, spin));
  }
};

// The laws of a contact, in the order in which kinds/bodies/motion.py writes their numbers; points are those of friction.
struct ContactLaws {
  Elasticity law;
  Damping damping;
  double regularisation;
  PatchFriction friction;
};
inline ContactLaws contact_laws_of(const double *n, const double *points) {
  return {{PointLaw(int(n[0])), n[1], n[2], n[3]}, {DampingLaw(int(n[4])), n[5], n[6]}, n[7], patch_friction_of(n + 8, points)};
}

// The record of a contact from touch to parting.

// Times [s]; the greatest load [N] with approach, curvatures, coefficient, semi-axes [m] and pressure [Pa] there; speeds [m/s];
// impulses [N s], in the present contact those at its start; greatest approach [m]; loads at ends of steps.
struct ContactRecord {
  double ended, began, peak_load, peak_approach, peak_small, peak_large, peak_coefficient, peak_major, peak_minor, peak_pressure;
  double speed_in, speed_out, impulse;
  Real3 friction_impulse;
  double deepest;
  Trail trail;

  // Takes a load if it is the greatest so far.
  template <class Contact>
  void update_peak(const Contact &contact) {
    if (!(contact.normal_load > peak_load)) return;
    peak_load = contact.normal_load, peak_approach = contact.approach, peak_small = contact.gap.small,
    peak_large = contact.gap.large;
    peak_coefficient = contact.coefficient, peak_major = contact.patch.semi_major, peak_minor = contact.patch.semi_minor;
    peak_pressure = contact.patch.peak_pressure;
  }
};

}  // namespace core
