// The motion of two bodies, and its exported functions; arrays are C-contiguous doubles in the order of kinds/bodies/motion.py.
#include <bit>
#include <cstddef>
#include <optional>
#include <type_traits>
#include "../shapes/opposing.hpp"
#include "../shapes/overlap.hpp"
#include "rigid_body.hpp"

namespace core {

// The equations of two bodies on each other: paper 1, sections 2 to 4, for any two implicit surfaces.
//
// The opposing points and the curvatures of the gap follow paper 1, eqs. (1)-(6): in closed form, by Newton's method from the
// last step's end, or as eight states by the differential equations (2)-(3), put right after each step. The load acts along A's
// outward normal n at the height of the interface that the compliances give; by the law `overlap` at the centre of the overlap's
// volume.
//
// The elastic contact is a spring with the energy U = (2/5) c(P, Q) h^(5/2) of paper 1, section 4. When a body turns, the curvatures
// change and with them c: the load c h^(3/2) alone, applied at the opposing points, makes or loses energy (a ten-thousandth a bounce
// for a spinning ellipsoid). The derivative of U by the orientation is a moment. Of an ellipsoid on a plane in closed form it is there:
// it puts the load's point of application beside the lowest point, by 0.4 h grad(ln c), a small part of the contact's size. Of other
// bodies it is left out.
//
// Breaks: where the half-space does (validity flags), at the b/a where the law does, and in true rolling resistance and sticking,
// which this friction does not know (it creeps).

enum class Tracking { closed, algebraic, differential };  // as in kinds/bodies/parameters.py

// A body: its surface, a distance [m] from its centre that no point exceeds, and how much its extent along a direction bends at most
// as it turns [m]: times the square of the angular velocity, infinite where that is not known.
struct ShapedBody : RigidBody {
  Surface surface;
  double reach, bend;

  CORE_INLINE MovingSurface at(const RigidState &state) const {
    RealMatrix3 rotation = rotation_matrix(state.orientation);
    return {surface, state.position, rotation, state.velocity, spin(state, rotation)};
  }
  // Angular velocity [rad/s] that the body can come to at this angular momentum.
  double greatest_spin(const RigidState &state) const { return length_of(state.momentum) / std::min({inertia[0], inertia[1], inertia[2]}); }
};

// Both bodies, energies dissipated, impulses on A [N s], work done on held bodies, and that with each moment's work counted by its
// size [J]; opposing points, and what a law carries. All but the last moves by its rates; where A moves alone, what stands
// before B.
struct PairState {
  RigidState a;
  double dissipated_viscous, dissipated_friction, load_impulse;
  Real3 friction_impulse;
  RigidState b;
  double held_work, gross_work;
  OpposingPoints points;
  CarriedContact carried;
};
constexpr std::size_t PAIR_NUMBERS = sizeof(PairState) / sizeof(double);
constexpr std::size_t PAIR_MOVING = offsetof(PairState, carried) / sizeof(double), FIRST_MOVING = offsetof(PairState, b) / sizeof(double);

// The contact of one state: forces on A at `point`, in fixed axes. `approach_rate` and `slip` are A's velocity against B there,
// along A's outward `normal` and across it; `held` [m] is the approach times the share of the load in the elastic one, below zero where
// the bodies would have to pull, or are apart.
struct PairContact {
  RootKind kind;
  double approach, approach_rate, normal_load, elastic_load, elastic_energy, coefficient, effective_mass;
  GapForm gap;
  Ellipse patch;
  Real3 point, normal, major_axis, slip, friction;
  double spin_moment, spin_rate, held;
};

struct TwoBodies : ContactLaws {
  ShapedBody a, b;
  Real3 gravity;
  double sink, size;  // A's share of the compliance; about the least radius [m]
  Tracking tracking;
  bool by_overlap;  // the load is that of the true overlap
  bool a_alone;     // B is held without velocity, and points are found anew

  // True of an ellipsoid or a sphere and a plane whose gap is taken in closed form.
  bool on_plane() const {
    auto is_round = [](SurfaceKind kind) { return kind == SurfaceKind::sphere || kind == SurfaceKind::ellipsoid; };
    SurfaceKind one = a.surface.kind, other = b.surface.kind;
    bool both = (is_round(one) && other == SurfaceKind::plane) || (one == SurfaceKind::plane && is_round(other));
    return both && tracking == Tracking::closed && !by_overlap;
  }
  // Brings opposing points up to the bodies' place; those of the differential form are taken.
  void track(const MovingSurface &one, const MovingSurface &other, OpposingPoints &points) const {
    if (on_plane()) return;
    if (tracking == Tracking::closed) points = nearest_pair(one, other);
    else if (tracking == Tracking::algebraic) settle(one, other, points);
  }
  PairContact contact(const PairState &state) const { return contact(a.at(state.a), b.at(state.b), state.points, state.carried); }
  // Without `complete` the patch is left out where nothing but outputs asks for it.
  PairContact contact(const MovingSurface &one, const MovingSurface &other, const OpposingPoints &points, const CarriedContact &carried,
                      bool complete = true) const;
  void rates(const PairState &state, bool loaded, bool &tracked, PairState &rates) const;

 private:
  // The normal load: the elastic answer, and of an overlap its half-widths, the pressure under the elastic load, and where the load's
  // centre is along the axes.
  struct Pressing {
    double coefficient;
    Elastic<double, double, double> spring;
    Ellipse patch;
    double along_x, along_y;
  };
  Pressing by_law(const Opposition &at, double coefficient) const {
    return {coefficient, elastic(coefficient, law.power, at.approach), {}, 0.0, 0.0};
  }
  // c of the law, and d ln(c)/d(shape) where the moment of changing curvatures is known.
  CoefficientAndSlope coefficient_at(const Opposition &at, const PlaneOpposition *plane, const CarriedContact &carried) const {
    EllipseShape shape = carries_states(law.law) ? carried.at(at.gap.small / at.gap.large) : EllipseShape{};
    if (plane) return coefficient_and_log_slope(law, at.gap.small, at.gap.large, plane->excess, shape);
    return {law_coefficient(law, at.gap.small, at.gap.large, shape), 0.0};
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
  std::optional<PlaneOpposition> plane;
  if (on_plane()) plane = plane_opposition(one, other, !complete && friction.model == FrictionModel::point);
  Opposition at = plane ? *plane : opposition(one, other, points);
  Pressing pressing{};
  Real3 point = plane ? plane->a : points.a, across = plane ? plane->b - plane->a : points.b - points.a;
  if (by_overlap) {
    if (at.kind == RootKind::no_ellipse && at.gap.large >= 0.0 && points.lambda < 0.0) at.kind = RootKind::found;
    pressing = by_true_overlap(one, other, point + 0.5 * across, at);
    point = point + pressing.along_x * at.axes.x + pressing.along_y * at.axes.y;
  } else {
    if (at.kind == RootKind::found && !(at.gap.small > FLAT * at.gap.large)) at.kind = RootKind::no_ellipse;
    if (at.kind == RootKind::found) {
      auto [coefficient, log_slope] = coefficient_at(at, plane ? &*plane : nullptr, carried);
      pressing = by_law(at, coefficient);
      if (plane && at.approach > 0.0 && follows_curvatures(law.law))
        point = point + *plane->rotation * (at.approach / (law.power + 1.0) * (plane->slopes.size + log_slope * plane->slopes.shape));
    }
  }
  if (at.approach > 0.0 || !plane) point = point + sink * across;
  Real3 relative = one.velocity_at(point) - other.velocity_at(point);
  PairContact found{};
  found.kind = at.kind, found.approach = at.approach, found.gap = at.gap, found.normal = at.normal, found.point = point;
  found.major_axis = at.axes.x, found.coefficient = pressing.coefficient;
  found.elastic_load = pressing.spring.load, found.elastic_energy = pressing.spring.energy;
  found.approach_rate = dot(relative, at.normal), found.slip = relative - found.approach_rate * at.normal;
  found.spin_rate = dot(one.spin - other.spin, at.normal);
  found.effective_mass = 1.0 / (a.mobility(one.rotation, point - one.position, at.normal) +
                                b.mobility(other.rotation, point - other.position, at.normal));
  found.held = at.approach;
  if (!(pressing.spring.load > 0.0)) return found;
  double load = damping.pulling_load(pressing.coefficient, law.power, pressing.spring.load, pressing.spring.stiffness,
                                     found.effective_mass, at.approach, found.approach_rate);
  found.held *= load / pressing.spring.load;
  found.normal_load = std::max(load, 0.0);
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

// Time derivative of the state, of its first numbers where A moves alone; without `loaded` the bodies do not press. Not `tracked` where
// the opposing points are lost.
CORE_INLINE void TwoBodies::rates(const PairState &state, bool loaded, bool &tracked, PairState &rates) const {
  MovingSurface one = a.at(state.a);
  rates.a = a.free_rates(state.a, one.spin, gravity);
  rates.dissipated_viscous = rates.dissipated_friction = rates.load_impulse = 0.0, rates.friction_impulse = {};
  if (a_alone && !loaded) return;
  MovingSurface other = b.at(state.b);
  OpposingPoints points = state.points;
  if (!a_alone) {
    rates.b = b.free_rates(state.b, other.spin, gravity);
    rates.held_work = rates.gross_work = 0.0, rates.points = {};
    if (tracking == Tracking::differential) {
      Unknowns slopes;
      tracked &= opposing_rates(one, other, points, slopes);
      rates.points = opposing_points(slopes);
    }
    if (!loaded) return;
  }
  track(one, other, points);
  PairContact at = contact(one, other, points, state.carried, false);
  rates.dissipated_viscous = (at.normal_load - at.elastic_load) * at.approach_rate;
  if (!(at.normal_load > 0.0)) return;
  Real3 force = at.friction - at.normal_load * at.normal, twist = at.spin_moment * at.normal;
  double held = a.push(1.0, force, cross(at.point - one.position, force) + twist, state.a, one.spin, rates.a);
  rates.dissipated_friction = -(dot(at.friction, at.slip) + at.spin_moment * at.spin_rate);
  rates.load_impulse = at.normal_load, rates.friction_impulse = at.friction;
  if (a_alone) return;
  held += b.push(-1.0, force, cross(at.point - other.position, force) + twist, state.b, other.spin, rates.b);
  rates.held_work = held, rates.gross_work = std::fabs(held);
}

// The motion of two bodies: how far a step may go, what its error is measured by, where it ends, and the records of contacts.
//
// In flight a step ends at the touch or before it. The distance of convex bodies is no less than that along any fixed direction. Along
// the normal it bends at most by  B = g + w^2 bend  of each body (w: greatest angular velocity at this angular momentum), so from a gap
// it stays one until h + h' t + B t^2/2 = 0, and so on from there: quadratic convergence. Where a bend is not known, no point comes
// nearer than the bodies' greatest speeds against each other allow. In contact a step is at most a sixth of 1/sqrt(k/m) at the
// greatest stiffness ahead, some 24 a bounce, and longer where the contact lasts; the error control finds begin and end.

// Whether by rk4 (1) or dop853, the tolerance of a contact, the step of rk4 in contact [s], and the shortest step [s] of flight, which
// may end in a touch.
struct PairPlan { double rk4, tolerance, fixed, floor; };

// Seconds; the next step; whether in contact; greatest drift of a quaternion's norm; outputs written; greatest distance [m] of the
// opposing points from meeting their equations at the end of a step.
struct PairClock { double time, step, in_contact, drift, written, off; };

template <std::size_t MOVING>
class TwoBodiesMotion : public AdaptiveMotion<TwoBodiesMotion<MOVING>, PAIR_NUMBERS, MOVING, PairClock> {
  using Base = AdaptiveMotion<TwoBodiesMotion, PAIR_NUMBERS, MOVING, PairClock>;
  using Base::after, Base::clock, Base::end_at_sign_change, Base::evaluate_inside, Base::scales, Base::state;

 public:
  using typename Base::Slopes, typename Base::State;

  // `record` is of the contact that goes on, `before` the state at the start of the last step.
  TwoBodiesMotion(const TwoBodies &pair, const PairPlan &plan, State &state, PairClock &clock, ContactRecord &record, State &before,
                  Counts &counts, std::int64_t &touch_count)
      : Base(plan.rk4 != 0.0 ? RK4 : DOP853, state, clock, counts), pair(pair), plan(plan), contact_record(record), before(before), touch_count(touch_count),
        touch(contact_at(state)) {}

  void rates(const State &at, bool loaded, Slopes &slopes) {
    pair.rates(reinterpret_cast<const PairState &>(at), loaded, tracked, reinterpret_cast<PairState &>(slopes));
  }
  // In flight never into a contact but to rounding, or by the shortest step, which may press.
  StepStart start_step() {
    bool loaded = touch.approach > 0.0;
    double least = 1e-6 * plan.floor, flight = loaded ? 0.0 : flight_step();
    if (touch.kind != RootKind::found) return {UNTRACKED, 0.0, least, loaded};
    if (loaded && clock.in_contact == 0.0) note(0.0, touch, pair_state(state), pair_state(state));  // at the start
    if (flight > 0.0) {
      set_flight_scales();
      return {OK, flight, least, false};
    }
    double longest = set_contact_scales(clock.in_contact > 0.0 ? clock.time - contact_record.began : 0.0);
    if (plan.fixed > 0.0) return {OK, plan.fixed, least, true};
    return {OK, loaded ? std::min(clock.step, longest) : plan.floor, least, true};
  }
  // A step in which the load ends, or the bodies part without load, ends there: what follows is another motion, and no step is smooth
  // across a corner. Where no bend is known, a flight from there would begin with the shortest steps.
  StepEnd end_step(double step, bool loaded) {
    constexpr double UNLOADED = 1e-6;  // share of the elastic load that is none
    const double none = UNLOADED * touch.approach;
    const bool pressed = touch.held > none;
    auto left = [=](const PairContact &at) { return pressed ? at.held : at.approach; };
    touch_after = finished(after);
    const bool lands = loaded && (pressed || std::isfinite(pair.a.bend + pair.b.bend));
    if (lands && left(touch) > none && left(touch_after) < 0.0) {
      step = end_at_sign_change([&](State &at) { return left(finished(at)); }, step, none);
      touch_after = finished(after);
    }
    return {OK, step};
  }
  void correct(State &at) { finish(at); }
  Accepted accept(double step, double following, bool loaded) {
    constexpr double DEEPEST = 0.5;  // of the bodies' size
    const State start = state;
    const PairContact touch_before = touch;
    PairState end = pair_state(after);
    touch = touch_after;
    if (!(touch.approach > 0.0)) end.carried.ratio = 0.0;  // a new contact begins with states solved afresh
    else if (carries_states(pair.law.law) && touch.gap.small > FLAT * touch.gap.large)
      end.carried.advance(carried_law(pair.law.law), touch.gap.small / touch.gap.large);
    state = std::bit_cast<State>(end);
    if (touch.approach > DEEPEST * pair.size) return {TOO_DEEP, false};
    clock.drift = std::max(clock.drift, drift), clock.off = std::max(clock.off, off);
    clock.step = !(touch.approach > 0.0) ? HUGE_VAL : loaded ? following : plan.floor;
    // A flight ends at the touch, to rounding.
    bool ended = loaded ? note(step, touch_before, pair_state(start), end) : note(0.0, touch, end, end);
    if (clock.in_contact > 0.0) note_peak(step), note_depth(step, touch_before, start);
    before = start;
    return {OK, ended};
  }
  const ContactRecord &record() const { return contact_record; }
  // True unless the equations of the opposing points were singular.
  bool tracked = true;

 private:
  const TwoBodies &pair;
  const PairPlan &plan;
  ContactRecord &contact_record;
  State &before;
  std::int64_t &touch_count;
  PairContact touch, touch_after{};
  double drift = 0.0, off = 0.0;  // found by `finish` last

  static PairState pair_state(const State &at) { return std::bit_cast<PairState>(at); }
  PairContact contact_at(const State &at) const { return pair.contact(pair_state(at)); }
  // Puts right at the end of a step what it leaves open: quaternions, opposing points.
  void finish(State &at) {
    PairState state = pair_state(at);
    drift = std::max(normalise(state.a.orientation), normalise(state.b.orientation));
    MovingSurface a = pair.a.at(state.a), b = pair.b.at(state.b);
    off = 0.0;
    if (pair.tracking == Tracking::differential) {
      off = OpposingEquations(a, b, state.points).distance();
      tracked &= project(a, b, state.points);
    } else {
      pair.track(a, b, state.points);
      if (pair.tracking == Tracking::algebraic) off = OpposingEquations(a, b, state.points).distance();
    }
    at = std::bit_cast<State>(state);
  }
  PairContact finished(State &at) {
    finish(at);
    return contact_at(at);
  }

  // Time [s] to step in flight: nothing touches before, but to rounding; 0 where only the shortest step is left. Where opposing points
  // are followed from the last ones, bodies turn little in a step.
  double flight_step() const {
    constexpr double LONGEST = 1.0, TURN = 0.1, FIXED_TURN = 0.02, ROUNDING = 1e-15;  // s; rad a step in flight; of places
    PairState now = pair_state(state);
    double spin_a = pair.a.greatest_spin(now.a), spin_b = pair.b.greatest_spin(now.b), gap = std::max(-touch.approach, 0.0);
    double bend = pair.a.held() != pair.b.held() ? length_of(pair.gravity) : 0.0, rate = touch.approach_rate, safe = HUGE_VAL;
    double turning = spin_a * spin_a * pair.a.bend + spin_b * spin_b * pair.b.bend;
    const bool known = std::isfinite(turning);
    if (known) bend += turning, gap += ROUNDING * (length_of(now.a.position) + length_of(now.b.position) + pair.size);
    else {
      // No point of a body is faster than its centre and its turning together, seen as far out as the other one reaches.
      double distance = length_of(now.a.position - now.b.position);
      rate = length_of(now.a.velocity - now.b.velocity) + spin_a * std::min(pair.a.reach, distance + pair.b.reach) +
             spin_b * std::min(pair.b.reach, distance + pair.a.reach);
    }
    double root = std::sqrt(rate * rate + 2.0 * bend * gap);
    if (rate > 0.0) safe = std::max(2.0 * gap / (root + rate), 1e-9 * plan.floor);
    else if (bend > 0.0) safe = std::max((root - rate) / bend, plan.floor);
    if (!known && !(safe > plan.floor)) return 0.0;
    double turn = plan.fixed > 0.0 ? FIXED_TURN : pair.tracking == Tracking::closed ? HUGE_VAL : TURN;
    return std::min({safe, LONGEST, turn / std::max({spin_a, spin_b, 1e-9})});
  }
  // In flight only orientations and points followed have an error.
  void set_flight_scales() {
    scales.fill(1e300);
    PairState s = pair_state(scales);
    s.a.orientation.fill(plan.tolerance), s.b.orientation.fill(plan.tolerance);
    if (pair.tracking == Tracking::differential) {
      double place = plan.tolerance * pair.size;
      s.points = {{place, place, place}, {place, place, place}, plan.tolerance, place};
    }
    scales = std::bit_cast<State>(s);
  }
  // From the contact ahead; returns the longest step [s] for one that has `lasted` [s].
  double set_contact_scales(double lasted) {
    constexpr double ROUNDING = 1e-15;
    double power = pair.law.power, weight = length_of(pair.gravity) * touch.effective_mass;
    double spent = greatest_approach(touch.coefficient, power, touch.effective_mass, touch.approach_rate);
    double ahead = std::max({std::max(touch.approach, 0.0) + spent, approach_of_load(touch.coefficient, power, weight), ROUNDING * pair.size});
    double rate = std::sqrt(elastic(touch.coefficient, power, ahead).stiffness / touch.effective_mass), speed = ahead * rate;
    double place = std::max(plan.tolerance * ahead, ROUNDING * pair.size);
    double swift = std::max(plan.tolerance * speed, ROUNDING * pair.size * rate);
    double energy = swift * touch.effective_mass * speed, impulse = swift * touch.effective_mass;
    scales.fill(1e300);
    PairState s = pair_state(scales);
    for (auto [body, of] : {std::pair{&pair.a, &s.a}, std::pair{&pair.b, &s.b}}) {
      if (body->held()) continue;
      of->position.fill(place), of->orientation.fill(place / pair.size);
      of->velocity.fill(swift), of->momentum.fill(swift * body->mass * pair.size);
    }
    s.dissipated_viscous = s.dissipated_friction = s.held_work = s.gross_work = energy;
    s.load_impulse = impulse, s.friction_impulse.fill(impulse);
    if (pair.tracking == Tracking::differential) s.points = {{place, place, place}, {place, place, place}, place / pair.size, place};
    scales = std::bit_cast<State>(s);
    return longest_contact_step(lasted, rate);
  }

  // Opens or closes the record of a contact where the step did; returns whether one has ended. `start` and `end` are the states at
  // both ends of the step, `touch` the contact at its end: what the step in which bodies touch brings is of the contact, too, where
  // damping answers at once.
  bool note(double step, const PairContact &at_start, const PairState &start, const PairState &end) {
    bool touches = touch.approach > 0.0;
    auto share = [&] { return crossing(step, {at_start.approach, at_start.approach_rate}, {touch.approach, touch.approach_rate}); };
    if (touches && clock.in_contact == 0.0) {
      clock.in_contact = 1.0, touch_count++;
      contact_record = {};
      contact_record.began = clock.time - (at_start.approach <= 0.0 && 0.0 < step ? 1.0 - share() : 1.0) * step;
      contact_record.speed_in = at_start.approach_rate;
      contact_record.impulse = start.load_impulse, contact_record.friction_impulse = start.friction_impulse;
    }
    if (touches) contact_record.keep_peak(touch);
    if (touches || clock.in_contact == 0.0) return false;
    clock.in_contact = 0.0;
    contact_record.ended = clock.time - (1.0 - share()) * step, contact_record.speed_out = -touch.approach_rate;
    contact_record.impulse = end.load_impulse - contact_record.impulse;
    contact_record.friction_impulse = end.friction_impulse - contact_record.friction_impulse;
    return true;
  }
  // The contact `length` [s] after a state, by a step of its own.
  PairContact contact_after(const State &from, double length) {
    State at;
    evaluate_inside(from, length, at);
    double drift_of_step = drift, off_of_step = off;
    PairContact found = finished(at);
    drift = drift_of_step, off = off_of_step;
    return found;
  }
  // Where the loads at the ends of the last two steps and between them show a peak, the load at its top.
  void note_peak(double step) {
    constexpr int ROUNDS = 2;  // parabolas through the greatest load, each about the top of the one before
    auto load = [&](double back, double place) {
      PairContact at = contact_after(before, back + place);
      contact_record.keep_peak(at);
      return at.normal_load;
    };
    refine_maximum(load, contact_record.trail, step, touch.normal_load, contact_record.peak_load, ROUNDS);
  }
  // The greatest approach over the step: damping puts it after the load's.
  void note_depth(double step, const PairContact &at_start, const State &start) {
    auto approach = [&](double place) -> ValueAndRate {
      PairContact at = contact_after(start, place);
      return {at.approach, at.approach_rate};
    };
    contact_record.deepest = greatest_within(approach, step, {at_start.approach, at_start.approach_rate},
                                             {touch.approach, touch.approach_rate}, contact_record.deepest);
  }
};

}  // namespace core

using namespace core;

namespace {

ShapedBody body_of(const double *&next) {
  ShapedBody body{};
  body.mass = *next++;
  for (double &one : body.inertia) one = *next++;
  body.surface.kind = SurfaceKind(int(*next++));
  for (double &one : body.surface.size) one = *next++;
  body.surface.side = *next++, body.reach = *next++, body.bend = *next++;
  return body;
}

TwoBodies pair_of(const double *next, const double *points, const double *state) {
  TwoBodies pair{};
  pair.a = body_of(next), pair.b = body_of(next);
  for (double &one : pair.gravity) one = *next++;
  pair.sink = *next++, pair.size = *next++;
  pair.tracking = Tracking(int(*next++)), pair.by_overlap = *next++ != 0.0;
  static_cast<ContactLaws &>(pair) = contact_laws_of(next, points);
  const RigidState &b = reinterpret_cast<const PairState *>(state)->b;
  pair.a_alone = pair.b.held() && b.velocity == Real3{} && b.momentum == Real3{} && pair.tracking != Tracking::differential;
  return pair;
}

// Writes the channels of a state in their order, but those of the numerics.
void write_outputs(const TwoBodies &pair, const PairState &state, double *out) {
  auto put = [&](const auto &numbers) { out = std::copy(numbers.begin(), numbers.end(), out); };
  double kinetic = 0.0, potential = 0.0;
  for (auto [body, its] : {std::pair{&pair.a, state.a}, std::pair{&pair.b, state.b}}) {
    Real3 spin = body->spin(its, rotation_matrix(its.orientation));
    normalise(its.orientation);
    put(its.position), put(its.orientation), put(its.velocity), put(spin);
    put(body->held() ? Real3{} : its.momentum);
    kinetic += body->kinetic_energy(its, spin), potential -= body->mass * dot(pair.gravity, its.position);
  }
  PairContact at = pair.contact(state);
  *out++ = at.approach, *out++ = at.normal_load;
  put(at.friction);
  *out++ = at.spin_moment, *out++ = at.spin_rate;
  put(at.point), put(at.normal), put(at.slip), put(at.major_axis);
  *out++ = at.patch.semi_major, *out++ = at.patch.semi_minor, *out++ = at.patch.peak_pressure;
  *out++ = at.gap.small, *out++ = at.gap.large, *out++ = at.approach > 0.0;
  *out++ = kinetic, *out++ = potential, *out++ = at.elastic_energy;
  *out++ = state.dissipated_viscous, *out++ = state.dissipated_friction, *out++ = state.held_work, *out++ = state.gross_work;
}

}  // namespace

// Moves bodies on until an instant [s]; `states` are those at the `instants` (outputs,) [s], `records` (capacity,) the contacts
// that have ended, of which there are `completed`; `counts` (4,) ends with touches. Returns a status.
CORE_EXPORT std::int64_t core_two_bodies_advance(const double *numbers, const double *points, const double *plan, double *state, double *clock,
                                                 double *record, double *before, double until, std::int64_t outputs, const double *instants,
                                                 const volatile std::uint8_t *stop, double *states, std::int64_t capacity, double *records,
                                                 std::int64_t *completed, std::int64_t *counts) {
  using State = Numbers<PAIR_NUMBERS>;
  TwoBodies pair = pair_of(numbers, points, state);
  auto advance = [&]<std::size_t MOVING>(std::integral_constant<std::size_t, MOVING>) {
    TwoBodiesMotion<MOVING> motion(pair, *reinterpret_cast<const PairPlan *>(plan), *reinterpret_cast<State *>(state),
                                   *reinterpret_cast<PairClock *>(clock), *reinterpret_cast<ContactRecord *>(record),
                                   *reinterpret_cast<State *>(before), *reinterpret_cast<Counts *>(counts), counts[3]);
    int count;
    Status status = motion.advance({until, int(outputs), instants, stop}, reinterpret_cast<State *>(states),
                                   reinterpret_cast<ContactRecord *>(records), int(capacity), count);
    *completed = count;
    return !motion.tracked && (status == STALLED || status == NOT_FINITE) ? UNTRACKED : status;
  };
  if (pair.a_alone) return advance(std::integral_constant<std::size_t, FIRST_MOVING>());
  return advance(std::integral_constant<std::size_t, PAIR_MOVING>());
}
// Outputs (count, width) of states (count, numbers).
CORE_EXPORT void core_two_bodies_outputs(const double *numbers, const double *points, std::int64_t count, const double *states,
                                         std::int64_t width, double *rows) {
  TwoBodies pair = pair_of(numbers, points, states);
  for (std::int64_t i = 0; i < count; i++) write_outputs(pair, reinterpret_cast<const PairState *>(states)[i], rows + i * width);
}
