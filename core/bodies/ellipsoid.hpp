// The equations of an ellipsoid on an elastic plane: paper 1, section 5, first example, for any three semi-axes.
//
//     m dv/dt = F - m g e_z,   dL/dt = r x F + T e_z,   dq/dt = omega q / 2,   omega = R I^-1 R^T L
//
// Fixed axes, z up, the plane is z = 0. L is the angular momentum about the centre, q the orientation.
//
// The elastic contact is a spring with the energy U = (2/5) c(P, Q) h^(5/2) of paper 1, section 4. When the body turns, the
// curvatures change and with them c: the load c h^(3/2) alone, applied at the lowest point, would make or lose energy (a
// ten-thousandth a bounce for a spinning ellipsoid). The derivative of U by the orientation is a moment; it puts the load's point
// of application beside the lowest point, by 0.4 h grad(ln c), a small part of the contact's size. All forces act there, for both
// bodies at the height of the interface that their compliances give.
//
// Breaks: where the half-space does (validity flags), at the b/a where the law does, and in true rolling resistance and sticking,
// which this friction does not know (it creeps).
#pragma once
#include "../contact/laws.hpp"
#include "../contact/friction.hpp"
#include "../shapes/gaps.hpp"
#include "rigid_body.hpp"

namespace core {

// With dissipated energies [J], and what a law with states carries.
struct EllipsoidState {
  RigidState motion;
  double dissipated_viscous, dissipated_friction;
  EllipseShape shape;
};

// The contact of one state: forces on the body in fixed axes, about its centre with the arm `arm` [m]. `approach_rate` [m/s] is
// that of the point of application, `slip` [m/s] its velocity along the plane, `effective_mass` [kg] what a blow there moves,
// `ratio_rate` [1/s] that of P/Q.
struct PlaneContact {
  double approach, approach_rate, normal_load;
  Elastic<double, double, double> spring;
  double coefficient, effective_mass;
  PlaneGap gap;
  Ellipse patch;  // where friction or an output wants it
  Real3 arm, slip, friction;
  double spin_moment, ratio_rate;
};

struct Ellipsoid : RigidBody {
  Real3 semi_axes;
  double gravity, sink;  // sink: the body's share of the compliance
  Elasticity law;
  Damping damping;
  PatchFriction friction;
  double regularisation;

  double least() const { return std::min({semi_axes[0], semi_axes[1], semi_axes[2]}); }
  double size() const { return std::max({semi_axes[0], semi_axes[1], semi_axes[2]}); }

  // Orientation and angular velocity [rad/s] of a state, downwards in the body's axes, and the lowest point.
  struct Pose {
    RealMatrix3 rotation;
    Real3 down, own_spin, spin;
    Reach low;
  };
  Pose pose(const RigidState &state) const {
    Pose at;
    at.rotation = rotation_matrix(state.orientation);
    at.down = -1.0 * at.rotation[2];
    Real3 own = transposed(at.rotation) * state.momentum;
    at.own_spin = {own[0] / inertia[0], own[1] / inertia[1], own[2] / inertia[2]};
    at.spin = at.rotation * at.own_spin;
    at.low = ellipsoid_reach(semi_axes, at.down);
    return at;
  }
  // Approach [m] of the lowest point and its rate [m/s].
  struct Approach { double value, rate; };
  Approach approach(const RigidState &state) const {
    Pose at = pose(state);
    return {at.low.extent - state.position[2], dot(at.low.point, cross(at.down, at.own_spin)) - state.velocity[2]};
  }

  PlaneContact contact(const EllipsoidState &state) const { return contact(state, pose(state.motion)); }
  PlaneContact contact(const EllipsoidState &state, const Pose &at) const;

  // Time derivative of the state; without `loaded` the plane is not there: the stages of a long flight would reach below it.
  EllipsoidState rates(const EllipsoidState &state, bool loaded) const {
    Pose at = pose(state.motion);
    EllipsoidState rates{};
    rates.motion = free_rates(state.motion, at.spin, {0.0, 0.0, -gravity});
    if (!loaded || at.low.extent <= state.motion.position[2]) return rates;
    PlaneContact touch = contact(state, at);
    Real3 force = touch.friction, moment;
    force[2] = touch.normal_load;
    moment = cross(touch.arm, force);
    moment[2] += touch.spin_moment;
    push(1.0, force, moment, state.motion, at.spin, rates.motion);
    rates.dissipated_viscous = (touch.normal_load - touch.spring.load) * touch.approach_rate;
    rates.dissipated_friction = -(dot(touch.friction, touch.slip) + touch.spin_moment * at.spin[2]);
    if (carries_states(law.law)) rates.shape = carried::plus({}, touch.ratio_rate, carried::slopes(state.shape));
    return rates;
  }

  // Solves the carried states afresh, as at a new contact.
  void begin_shape(EllipsoidState &state) const {
    if (carries_states(law.law)) state.shape = carried::shape_at(ratio(state));
  }
  // Ends a step in contact: puts the carried states right if the law does so.
  void finish_shape(EllipsoidState &state) const {
    if (!carries_states(law.law)) return;
    CarriedContact carried{ratio(state), state.shape};
    carried.carry_on(carried_law(law.law), carried.ratio);
    state.shape = carried.shape;
  }

 private:
  double ratio(const EllipsoidState &state) const {
    Pose at = pose(state.motion);
    PlaneGap gap = ellipsoid_gap(semi_axes, at.down, at.low);
    return gap.small / gap.large;
  }
};

// The contact of a state, loaded or not.
inline PlaneContact Ellipsoid::contact(const EllipsoidState &state, const Pose &at) const {
  PlaneContact found{};
  found.gap = ellipsoid_gap(semi_axes, at.down, at.low);
  auto [small, large, excess] = std::tuple{found.gap.small, found.gap.large, found.gap.excess};
  found.approach = at.low.extent - state.motion.position[2];
  auto [coefficient, log_slope] = coefficient_and_log_slope(law, small, large, excess, state.shape);
  found.coefficient = coefficient;
  GapSlopes slopes = ellipsoid_slopes(semi_axes, at.down, at.low);
  double depth = std::max(found.approach, 0.0);
  double aside = follows_curvatures(law.law) ? depth / (law.power + 1.0) : 0.0;  // energy over load
  Real3 point = at.low.point;
  if (aside > 0.0) point = point + aside * (slopes.size + log_slope * slopes.shape);
  found.arm = at.rotation * point;
  found.arm[2] = sink * depth - at.low.extent;
  Real3 velocity = state.motion.velocity + cross(at.spin, found.arm);
  found.effective_mass = 1.0 / mobility(at.rotation, found.arm, {0.0, 0.0, 1.0});
  found.approach_rate = -velocity[2], found.slip = {velocity[0], velocity[1], 0.0};
  found.spring = elastic(found.coefficient, law.power, found.approach);
  found.normal_load = damping.load(found.coefficient, law.power, found.spring.load, found.spring.stiffness, found.effective_mass,
                                   found.approach, found.approach_rate);
  if (excess > 1e-12) found.ratio_rate = -2.0 * small / large * dot(slopes.shape, cross(at.down, at.own_spin)) / excess;
  if (!(found.normal_load > 0.0 && friction.coefficient > 0.0)) return found;
  Real3 along{1.0, 0.0, 0.0};
  if (friction.model != FrictionModel::point) {
    found.patch = ellipse(small, large, law.modulus, found.normal_load);
    along = at.rotation * found.gap.major_axis();
  }
  Real3 across{-along[1], along[0], 0.0};
  PatchForce force = contact_friction(friction, regularisation, found.normal_load, found.patch.semi_major, found.patch.semi_minor,
                                      dot(found.slip, along), dot(found.slip, across), at.spin[2]);
  found.friction = force.force_major * along + force.force_minor * across;
  found.friction[2] = 0.0;
  found.spin_moment = force.torque;
  return found;
}

}  // namespace core
