// The equations of two bodies on each other: paper 1, sections 2 to 4, for any two implicit surfaces.
//
// The opposing points and the curvatures of the gap follow paper 1, eqs. (1)-(6): in closed form, by Newton's method from the
// last step's end, or as eight states by the differential equations (2)-(3), put right after each step. The load acts along A's
// outward normal n at the height of the interface that the compliances give; by the law `overlap` at the centre of the overlap's
// volume. What a load does by turning bodies whose curvatures change is left out: it makes or loses about a ten-thousandth of a
// bounce's energy.
#pragma once
#include <bit>
#include "../contact/laws.hpp"
#include "../contact/friction.hpp"
#include "../shapes/opposing.hpp"
#include "../shapes/overlap.hpp"
#include "rigid_body.hpp"

namespace core {

enum class Tracking { closed, algebraic, differential };  // as in kinds/bodies/parameters.py

// A body: its surface, and a distance [m] from its centre that no point exceeds.
struct ShapedBody : RigidBody {
  Surface surface;
  double reach;

  MovingSurface at(const RigidState &state) const {
    RealMatrix3 rotation = rotation_matrix(state.orientation);
    return {surface, state.position, rotation, state.velocity, spin(state, rotation)};
  }
};

// Both bodies, energies dissipated, work done on held bodies, and that with each moment's work counted by its size [J]; impulses
// on A [N s]; opposing points, and what a law carries. All but the last moves by its rates.
struct PairState {
  RigidState a, b;
  double dissipated_viscous, dissipated_friction, held_work, gross_work, load_impulse;
  Real3 friction_impulse;
  OpposingPoints points;
  CarriedContact carried;
};
constexpr std::size_t PAIR_NUMBERS = sizeof(PairState) / sizeof(double), PAIR_MOVING = PAIR_NUMBERS - 4;

// The contact of one state: forces on A at `point`, in fixed axes. `approach_rate` and `slip` are A's velocity against B there,
// along A's outward `normal` and across it; `held` [N] is the load, below zero where the bodies would have to pull, or are apart.
struct PairContact {
  RootKind kind;
  double approach, approach_rate, normal_load, elastic_load, elastic_energy, coefficient, effective_mass;
  GapForm gap;
  Ellipse patch;
  Real3 point, normal, major_axis, slip, friction;
  double spin_moment, spin_rate, held;
};

struct TwoBodies {
  ShapedBody a, b;
  Real3 gravity;
  double sink, size;  // A's share of the compliance; about the least radius [m]
  Tracking tracking;
  bool by_overlap;  // the load is that of the true overlap
  Elasticity law;
  Damping damping;
  PatchFriction friction;
  double regularisation;

  // Brings opposing points up to the bodies' place; those of the differential form are taken.
  void track(const MovingSurface &one, const MovingSurface &other, OpposingPoints &points) const {
    if (tracking == Tracking::closed) points = nearest_pair(one, other);
    else if (tracking == Tracking::algebraic) settle(one, other, points);
  }
  PairContact contact(const PairState &state) const { return contact(a.at(state.a), b.at(state.b), state.points, state.carried); }
  // Without `complete` the patch is left out where nothing but outputs asks for it.
  PairContact contact(const MovingSurface &one, const MovingSurface &other, const OpposingPoints &points, const CarriedContact &carried,
                      bool complete = true) const;
  PairState rates(const PairState &state, bool loaded, bool &tracked) const;

 private:
  // What presses: the elastic answer, and of an overlap its half-widths, the pressure under the elastic load, and where the load's
  // centre is along the axes.
  struct Pressing {
    double coefficient;
    Elastic<double, double, double> spring;
    Ellipse patch;
    double along_x, along_y;
  };
  Pressing by_law(const Opposition &at, const CarriedContact &carried) const {
    double coefficient = law_coefficient(law, at.gap.small, at.gap.large,
                                         carries_states(law.law) ? carried.at(at.gap.small / at.gap.large) : EllipseShape{});
    return {coefficient, elastic(coefficient, law.power, at.approach), {}, 0.0, 0.0};
  }
  // The axes are exchanged where the second half-width is the longer one; `kind` is no ellipse where the overlap has no outline.
  Pressing by_true_overlap(const MovingSurface &one, const MovingSurface &other, const Real3 &middle, Opposition &at) const {
    Pressing none{4.0 / 3.0 * law.modulus * std::sqrt(size), {}, {}, 0.0, 0.0};  // a scale while nothing presses
    if (at.approach <= 0.0 || at.kind != RootKind::found) return none;
    Overlap found = overlap_of(one, other, middle, at.axes, at.normal, at.approach, size, law.modulus);
    if (!found.found) {
      at.kind = RootKind::no_ellipse;
      return none;
    }
    double x = found.half_width_x, y = found.half_width_y, along_x = found.centre_x, along_y = found.centre_y;
    if (y > x) {
      at.axes = {at.axes.y, -1.0 * at.axes.x};
      std::swap(x, y);
      along_x = found.centre_y, along_y = -found.centre_x;
    }
    return {found.load / std::pow(at.approach, 1.5), {found.load, 1.5 * found.load / at.approach, found.energy},
            {std::sqrt(0.5) * x, std::sqrt(0.5) * y, 3.0 * found.load / found.area}, along_x, along_y};
  }
};

constexpr double FLAT = 1e-9;  // P/Q below which the gap has no ellipse that a law could take

// The contact of two bodies with these opposing points, loaded or not.
inline PairContact TwoBodies::contact(const MovingSurface &one, const MovingSurface &other, const OpposingPoints &points,
                                      const CarriedContact &carried, bool complete) const {
  Opposition at(one, other, points);
  Pressing pressing{};
  if (by_overlap) {
    if (at.kind == RootKind::no_ellipse && at.gap.large >= 0.0 && points.lambda < 0.0) at.kind = RootKind::found;
    pressing = by_true_overlap(one, other, 0.5 * (points.a + points.b), at);
  } else {
    if (at.kind == RootKind::found && !(at.gap.small > FLAT * at.gap.large)) at.kind = RootKind::no_ellipse;
    if (at.kind == RootKind::found) pressing = by_law(at, carried);
  }
  Real3 point = points.a + sink * (points.b - points.a) + pressing.along_x * at.axes.x + pressing.along_y * at.axes.y;
  Real3 relative = one.velocity_at(point) - other.velocity_at(point);
  PairContact found{};
  found.kind = at.kind, found.approach = at.approach, found.gap = at.gap, found.normal = at.normal, found.point = point;
  found.major_axis = at.axes.x, found.coefficient = pressing.coefficient;
  found.elastic_load = pressing.spring.load, found.elastic_energy = pressing.spring.energy;
  found.approach_rate = dot(relative, at.normal), found.slip = relative - found.approach_rate * at.normal;
  found.spin_rate = dot(one.spin - other.spin, at.normal);
  found.effective_mass = 1.0 / (a.mobility(one.rotation, point - one.position, at.normal) +
                                b.mobility(other.rotation, point - other.position, at.normal));
  found.held = -pressing.coefficient * std::pow(std::fabs(at.approach), 1.5);
  if (!(pressing.spring.load > 0.0)) return found;
  found.held = damping.pulling_load(pressing.coefficient, law.power, pressing.spring.load, pressing.spring.stiffness,
                                    found.effective_mass, at.approach, found.approach_rate);
  found.normal_load = std::max(found.held, 0.0);
  if (found.normal_load == 0.0) return found;
  // Half-widths and pressure under the whole load, elastic and viscous, as in all other kinds.
  found.patch = pressing.patch;
  if (by_overlap) found.patch.peak_pressure *= found.normal_load / pressing.spring.load;
  else if (complete || friction.model != FrictionModel::point) found.patch = ellipse(at.gap.small, at.gap.large, law.modulus, found.normal_load);
  if (friction.coefficient > 0.0) {
    PatchForce force = contact_friction(friction, regularisation, found.normal_load, found.patch.semi_major, found.patch.semi_minor,
                                        dot(found.slip, at.axes.x), dot(found.slip, at.axes.y), found.spin_rate);
    found.friction = force.force_major * at.axes.x + force.force_minor * at.axes.y;
    found.spin_moment = force.torque;
  }
  return found;
}

// Time derivative of the state; without `loaded` the bodies do not press. Not `tracked` where the opposing points are lost.
inline PairState TwoBodies::rates(const PairState &state, bool loaded, bool &tracked) const {
  MovingSurface one = a.at(state.a), other = b.at(state.b);
  PairState rates{};
  rates.a = a.free_rates(state.a, one.spin, gravity), rates.b = b.free_rates(state.b, other.spin, gravity);
  OpposingPoints points = state.points;
  if (tracking == Tracking::differential) {
    Unknowns slopes;
    tracked &= opposing_rates(one, other, points, slopes);
    rates.points = opposing_points(slopes);
  }
  if (!loaded) return rates;
  track(one, other, points);
  if (approach_of(other, points) <= 0.0) return rates;
  PairContact at = contact(one, other, points, state.carried, false);
  Real3 force = at.friction - at.normal_load * at.normal, twist = at.spin_moment * at.normal;
  double held = a.push(1.0, force, cross(at.point - one.position, force) + twist, state.a, one.spin, rates.a) +
                b.push(-1.0, force, cross(at.point - other.position, force) + twist, state.b, other.spin, rates.b);
  rates.dissipated_viscous = (at.normal_load - at.elastic_load) * at.approach_rate;
  rates.dissipated_friction = -(dot(at.friction, at.slip) + at.spin_moment * at.spin_rate);
  rates.held_work = held, rates.gross_work = std::fabs(held);
  rates.load_impulse = at.normal_load, rates.friction_impulse = at.friction;
  return rates;
}

}  // namespace core
