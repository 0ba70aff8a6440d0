// The motion of an ellipsoid on a plane, and its exported functions; arrays are C-contiguous doubles in the order of kinds/bodies/motion.py.
#include <bit>
#include "../shapes/gaps.hpp"
#include "rigid_body.hpp"

namespace core {

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

// With dissipated energies [J], and what a law with states carries.
struct EllipsoidState {
  RigidState motion;
  double dissipated_viscous, dissipated_friction;
  EllipseShape shape;
};

// The contact of one state: forces on the body in fixed axes, about its centre with the arm `arm` [m]. `approach_rate` [m/s] is
// that of the point of application, `slip` [m/s] its velocity along the plane, `effective_mass` [kg] the mass that an impact there moves,
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

struct Ellipsoid : RigidBody, ContactLaws {
  Real3 semi_axes;
  double gravity, sink;  // sink: the body's share of the compliance

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
  double shift = follows_curvatures(law.law) ? depth / (law.power + 1.0) : 0.0;  // energy over load
  Real3 point = at.low.point;
  if (shift > 0.0) point = point + shift * (slopes.size + log_slope * slopes.shape);
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

// The motion of an ellipsoid on a plane: flight to the next touch, contact to the next separation, nothing stepped over.
//
// In flight the approach bends at most by  B = g + w^2 (spread + 2 lean)  (w: greatest angular velocity at this angular momentum),
// so from a gap it stays one until h + h' t + B t^2/2 = 0, and so on from there: quadratic convergence to the touch, which is known
// to a few roundings of the height. In contact a step is at most a sixth of 1/sqrt(k/m) at the greatest stiffness ahead, some 24 a
// bounce, and longer in a contact that lasts; separation is the zero of the approach as a function of the last step's length.

// Step control: dop853 or rk4 (1), the tolerance, the fixed step in contact [s] (0 = adaptive). `spread` and `lean` [m] bound how
// fast the body's extent downwards bends when it turns, `floor` [s] is the shortest step: lift-offs and touches shorter than that
// are passed.
struct EllipsoidPlan { double rk4, tolerance, fixed, spread, lean, floor; };

// Seconds; the next step; whether in contact; greatest drift of the quaternion's norm in a step; outputs written.
struct EllipsoidClock { double time, step, in_contact, drift, written; };

constexpr std::size_t ELLIPSOID_NUMBERS = sizeof(EllipsoidState) / sizeof(double);

class EllipsoidMotion : public AdaptiveMotion<EllipsoidMotion, ELLIPSOID_NUMBERS, ELLIPSOID_NUMBERS, EllipsoidClock> {
 public:
  // `record` is of the contact that goes on, `before` the state at the start of the last step.
  EllipsoidMotion(const Ellipsoid &body, const EllipsoidPlan &plan, State &state, EllipsoidClock &clock, ContactRecord &record,
                  State &before, Counts &counts, std::int64_t &touches)
      : AdaptiveMotion(plan.rk4 != 0.0 ? RK4 : DOP853, state, clock, counts), body(body), plan(plan), contact_record(record),
        before(before), touches(touches) {}

  void rates(const State &at, bool loaded, Slopes &slopes) const { slopes = std::bit_cast<State>(body.rates(read(at), loaded)); }

  // Opens a contact where the body has landed; how far the next step may go.
  StepBegin begin() {
    constexpr double LONGEST_FLIGHT = 1.0, FLIGHT_TURN = 0.02;  // s; rad a step of fixed length
    if (clock.in_contact == 0.0 && landed()) begin_contact();
    double least = 1e-9 * plan.floor, step = clock.step;
    if (clock.in_contact > 0.0) {
      touch = body.contact(read(state));
      double longest = set_contact_scales(clock.time - contact_record.began);
      return {OK, std::min(step, plan.fixed > 0.0 ? plan.fixed : longest), least, true};
    }
    set_flight_scales();
    step = std::min({step, safe_flight(), LONGEST_FLIGHT});
    if (plan.fixed > 0.0) step = std::min(step, FLIGHT_TURN / std::max(greatest_spin(), 1e-9));
    return {OK, step, least, false};
  }
  // Ends a step in contact where the bodies part.
  StepEnd end(double step, bool loaded) {
    constexpr double DEEPEST = 0.5;  // of the shortest semi-axis
    parted = false;
    if (!loaded) return {OK, step};
    double shortest = body.least(), height = std::fabs(read(state).motion.position[2]);
    auto approach = [&](const State &at) { return body.approach(read(at).motion).value; };
    double found = approach(after);
    if (found > DEEPEST * shortest) return {TOO_DEEP, step};
    parted = found <= 0.0;
    if (!parted) return {OK, step};
    if (approach(state) > ROUNDING * (height + shortest)) return {OK, land(approach, step, ROUNDING * (height + 1e-3))};
    if (step > plan.floor) {
      clock.step = 0.25 * step;  // a touch that leaves at once: find out how long it lasts
      return {OK, step, true};
    }
    return {OK, step};
  }
  void put_right(State &) const {}  // outputs take the quaternion at unit length
  Accepted accept(double step, double following, bool loaded) {
    EllipsoidState end = read(after);
    if (loaded) {
      note_peak(step, body.contact(end));
      note_depth(step, end);
    }
    if (clock.in_contact > 0.0) body.finish_shape(end);
    clock.drift = std::max(clock.drift, normalise(end.motion.orientation));
    before = state, state = std::bit_cast<State>(end);
    clock.step = plan.fixed == 0.0 ? following : HUGE_VAL;
    if (parted) end_contact();
    return {OK, parted};
  }
  const ContactRecord &record() const { return contact_record; }

 private:
  static constexpr double ROUNDING = 1e-15;  // of the body's size: gaps below are none
  const Ellipsoid &body;
  const EllipsoidPlan &plan;
  ContactRecord &contact_record;
  State &before;
  std::int64_t &touches;
  PlaneContact touch{};  // of the state, in contact
  bool parted = false;

  static EllipsoidState read(const State &at) { return std::bit_cast<EllipsoidState>(at); }

  // Approach from here on by an elastic impact, about, at its greatest: what the scales of a step follow.
  double expected_approach() const {
    return std::max(touch.approach, 0.0) + greatest_approach(touch.coefficient, body.law.power, touch.effective_mass, touch.approach_rate);
  }
  // From the contact ahead; returns the longest step [s] for one that has `lasted` [s].
  double set_contact_scales(double lasted) {
    double ahead = expected_approach(), size = body.size();
    double rate = std::sqrt(elastic(touch.coefficient, body.law.power, ahead).stiffness / touch.effective_mass), speed = ahead * rate;
    double swift = std::max(plan.tolerance * speed, ROUNDING * size * rate), form = 10.0 * std::max(plan.tolerance, ROUNDING);
    EllipsoidState s;
    s.motion.position.fill(std::max(plan.tolerance * ahead, ROUNDING * (std::fabs(read(state).motion.position[2]) + size)));
    s.motion.orientation.fill(std::max(plan.tolerance * ahead / size, ROUNDING));
    s.motion.velocity.fill(swift), s.motion.momentum.fill(swift * body.mass * size);
    s.dissipated_viscous = s.dissipated_friction = swift * body.mass * speed;
    s.shape = {form, form, form};
    scales = std::bit_cast<State>(s);
    return longest_contact_step(lasted, rate);
  }
  // In flight only the orientation has an error.
  void set_flight_scales() {
    scales.fill(1e300);
    EllipsoidState s = read(scales);
    s.motion.orientation.fill(plan.tolerance);
    scales = std::bit_cast<State>(s);
  }

  // Angular velocity [rad/s] that the body can come to at this angular momentum.
  double greatest_spin() const {
    return length_of(read(state).motion.momentum) / std::min({body.inertia[0], body.inertia[1], body.inertia[2]});
  }
  // Time [s] in which no touch is possible from a state in flight; infinite where there is none for ever.
  double safe_flight() const {
    auto [approach, rate] = body.approach(read(state).motion);
    double gap = std::max(-approach, 0.0), spin = greatest_spin(), bend = body.gravity + spin * spin * (plan.spread + 2.0 * plan.lean);
    if (bend == 0.0) return rate > 0.0 ? gap / rate : HUGE_VAL;
    double root = std::sqrt(rate * rate + 2.0 * bend * gap);
    return rate > 0.0 ? 2.0 * gap / (root + rate) : std::max((root - rate) / bend, plan.floor);
  }
  // True if the bodies overlap, or, where no number can tell, the gap is not opening.
  bool landed() const {
    RigidState now = read(state).motion;
    auto [approach, rate] = body.approach(now);
    double unknown = ROUNDING * (std::fabs(now.position[2]) + body.size());
    return approach > unknown || (rate > 0.0 && approach >= -unknown);
  }

  // Opens the record of a contact at this state; the next step suits its onset.
  void begin_contact() {
    constexpr double FIRST_STEP = 1e-6;  // of the contact time expected: loads begin as t^1.5, viscous ones as t^0.25
    EllipsoidState now = read(state);
    body.begin_shape(now);
    state = std::bit_cast<State>(now);
    touch = body.contact(now);
    contact_record = {};
    contact_record.began = clock.time, contact_record.ended = NAN, contact_record.speed_in = touch.approach_rate;
    contact_record.impulse = now.motion.velocity[2], contact_record.friction_impulse = now.motion.velocity;
    clock.in_contact = 1.0;
    double speed = std::max(touch.approach_rate, 1e-300);
    clock.step = plan.fixed > 0.0 ? plan.fixed : std::max(FIRST_STEP * 2.943 * expected_approach() / speed, plan.floor);
    touches++;
  }
  // Completes the record: the state is that of the separation. Impulses are those of the contact's forces.
  void end_contact() {
    EllipsoidState now = read(state);
    Real3 gained = now.motion.velocity - contact_record.friction_impulse;
    contact_record.ended = clock.time, contact_record.speed_out = -body.contact(now).approach_rate;
    contact_record.friction_impulse = {body.mass * gained[0], body.mass * gained[1], 0.0};
    contact_record.impulse = body.mass * (gained[2] + body.gravity * (clock.time - contact_record.began));
    clock.in_contact = 0.0, clock.step = HUGE_VAL;
  }

  // Keeps the greatest load of a contact: where three ends of steps show a peak, the load at their parabola's top.
  void note_peak(double step, const PlaneContact &end) {
    auto load = [&](double back, double place) {
      State there;
      if (place >= 0.0) look(state, place, there);
      else look(before, back + place, there);
      PlaneContact found = body.contact(read(there));
      contact_record.keep_peak(found);
      return found.normal_load;
    };
    look_at_top(load, contact_record.trail, step, end.normal_load, contact_record.peak_load, 1);
    contact_record.keep_peak(touch);
  }
  // Keeps the greatest approach over the step: damping puts it after the load's.
  void note_depth(double step, const EllipsoidState &end) {
    auto at = [&](const EllipsoidState &one) -> ValueAndRate {
      auto [value, rate] = body.approach(one.motion);
      return {value, rate};
    };
    auto inside = [&](double place) {
      State there;
      look(state, place, there);
      return at(read(there));
    };
    contact_record.deepest = greatest_within(inside, step, at(read(state)), at(end), contact_record.deepest);
  }
};

}  // namespace core

using namespace core;

namespace {

using State = Numbers<ELLIPSOID_NUMBERS>;

Ellipsoid ellipsoid_of(const double *n, const double *points) {
  return {{n[0], {n[1], n[2], n[3]}}, contact_laws_of(n + 9, points), {n[4], n[5], n[6]}, n[7], n[8]};
}

// Writes the channels of a state in their order, but that of the numerics.
void write_outputs(const Ellipsoid &body, EllipsoidState state, double *out) {
  auto put = [&](const auto &numbers) { out = std::copy(numbers.begin(), numbers.end(), out); };
  Ellipsoid::Pose pose = body.pose(state.motion);
  PlaneContact at = body.contact(state, pose);
  Ellipse patch = ellipse(at.gap.small, at.gap.large, body.law.modulus, at.normal_load);
  normalise(state.motion.orientation);
  put(state.motion.position), put(state.motion.orientation), put(state.motion.velocity), put(pose.spin), put(state.motion.momentum);
  *out++ = at.approach, *out++ = at.normal_load;
  put(at.friction);
  *out++ = at.spin_moment;
  put(state.motion.position + at.arm), put(at.slip), put(pose.rotation * at.gap.major_axis());
  *out++ = patch.semi_major, *out++ = patch.semi_minor, *out++ = patch.peak_pressure;
  *out++ = at.approach > 0.0;
  *out++ = body.kinetic_energy(state.motion, pose.spin);
  *out++ = body.mass * body.gravity * (state.motion.position[2] - body.least());
  *out++ = at.spring.energy, *out++ = state.dissipated_viscous, *out++ = state.dissipated_friction;
}

}  // namespace

// Completes a state whose momentum is an angular velocity, with its lowest point `height` [m] above the plane.
CORE_EXPORT void core_ellipsoid_start(const double *numbers, const double *points, double height, double *state) {
  Ellipsoid body = ellipsoid_of(numbers, points);
  auto &place = *reinterpret_cast<State *>(state);
  EllipsoidState start = std::bit_cast<EllipsoidState>(place);
  RealMatrix3 rotation = rotation_matrix(start.motion.orientation);
  Real3 spin = transposed(rotation) * start.motion.momentum;
  for (int i = 0; i < 3; i++) spin[i] *= body.inertia[i];
  start.motion.momentum = rotation * spin;
  start.motion.position[2] = height + body.pose(start.motion).low.extent;
  body.begin_shape(start);
  place = std::bit_cast<State>(start);
}
// See `advance_until`; `counts` (4,) ends with touches. Returns a status.
CORE_EXPORT std::int64_t core_ellipsoid_advance(const double *numbers, const double *points, const double *plan, double *state, double *clock,
                                                double *record, double *before, double until, std::int64_t outputs, const double *instants,
                                                const volatile std::uint8_t *stop, double *states, std::int64_t capacity, double *records,
                                                std::int64_t *completed, std::int64_t *counts) {
  Ellipsoid body = ellipsoid_of(numbers, points);
  EllipsoidMotion motion(body, *reinterpret_cast<const EllipsoidPlan *>(plan), *reinterpret_cast<State *>(state),
                         *reinterpret_cast<EllipsoidClock *>(clock), *reinterpret_cast<ContactRecord *>(record),
                         *reinterpret_cast<State *>(before), *reinterpret_cast<Counts *>(counts), counts[3]);
  return advance_until(motion, until, outputs, instants, stop, states, capacity, records, completed);
}
// Outputs (count, width) of states (count, numbers).
CORE_EXPORT void core_ellipsoid_outputs(const double *numbers, const double *points, std::int64_t count, const double *states,
                                        std::int64_t width, double *rows) {
  Ellipsoid body = ellipsoid_of(numbers, points);
  for (std::int64_t i = 0; i < count; i++)
    write_outputs(body, std::bit_cast<EllipsoidState>(reinterpret_cast<const State *>(states)[i]), rows + i * width);
}
// Where an ellipsoid reaches farthest along directions (count, 3), and its gap there (count, 16): extent, point, P, Q, direction of
// the longer axis, excess, gradients of size and shape.
CORE_EXPORT void core_ellipsoid_gaps(const double *semi_axes, std::int64_t count, const double *directions, double *found) {
  Real3 axes{semi_axes[0], semi_axes[1], semi_axes[2]};
  for (std::int64_t i = 0; i < count; i++, directions += 3) {
    Real3 direction{directions[0], directions[1], directions[2]};
    Reach reach = ellipsoid_reach(axes, direction);
    PlaneGap gap = ellipsoid_gap(axes, direction, reach);
    GapSlopes slopes = ellipsoid_slopes(axes, direction, reach);
    auto put = [&](const Real3 &vector) { found = std::copy(vector.begin(), vector.end(), found); };
    *found++ = reach.extent, put(reach.point), *found++ = gap.small, *found++ = gap.large, put(gap.major_axis());
    *found++ = gap.excess, put(slopes.size), put(slopes.shape);
  }
}
