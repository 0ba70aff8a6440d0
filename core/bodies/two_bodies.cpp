// The motion of two bodies, and its exported functions; arrays are C-contiguous doubles in the order of kinds/bodies/motion.py.
#include <bit>
#include <cstddef>
#include <optional>
#include <type_traits>
#include "../shapes/opposing.hpp"
#include "../shapes/overlap.hpp"
#include "rigid_body.hpp"

namespace core {

// The equations of motion of two bodies in contact: paper 1, sections 2 to 4, for any two implicit surfaces.
//
// The opposing points and the curvatures of the gap follow paper 1, eqs. (1)-(6): in closed form, by Newton's method from the
// last step's end, or as eight states by the differential equations (2)-(3), projected after each step. The load acts along A's
// outward normal n at the interface whose height follows from the compliances; by the law `overlap` at the centre of the overlap's
// volume.
//
// The elastic contact is a spring with the energy U = (2/5) c(P, Q) h^(5/2) of paper 1, section 4. When a body turns, the curvatures
// change and with them c: the load c h^(3/2) alone, applied at the opposing points, does not conserve energy (1e-4 a bounce for a
// spinning ellipsoid). The derivative of U by the orientation is a moment. For an ellipsoid on a plane in closed form it is modelled
// by a displacement of the load's point of application from the lowest point, 0.4 h grad(ln c), a small fraction of the contact's
// size. For other bodies it is not modelled.
//
// Limits: those of the half-space (validity flags) and of the law in b/a; rolling resistance and true sticking are not modelled
// (regularised friction creeps).

enum class Tracking { closed, algebraic, differential };  // as in kinds/bodies/parameters.py

// A body: its surface, the greatest distance [m] of its points from the centre, and a bound [m] of the second derivative of its extent
// along a direction by the angle of rotation, infinite where it is not known.
struct ShapedBody : RigidBody {
  Surface surface;
  double reach, max_curvature;

  CORE_INLINE MovingSurface surface_at(const RigidState &state) const {
    RealMatrix3 rotation = rotation_matrix(state.orientation);
    return {surface, state.position, rotation, state.velocity, spin(state, rotation)};
  }
  // The greatest possible angular velocity [rad/s] at this angular momentum.
  double max_spin(const RigidState &state) const {
    return length_of(state.momentum) / std::min({inertia[0], inertia[1], inertia[2]});
  }
};

// Both bodies, energies dissipated, impulses on A [N s], work done on held bodies and its absolute sum [J]; opposing points, and
// carried states of a law. All but the last are integrated; where A moves alone, those before B.
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
constexpr std::size_t PAIR_MOVING = offsetof(PairState, carried) / sizeof(double),
                      FIRST_MOVING = offsetof(PairState, b) / sizeof(double);

// The contact of one state: forces on A at `point`, in fixed axes. `approach_rate` and `slip` are A's velocity relative to B there,
// along A's outward `normal` and across it; `held` [m] is the approach times the ratio of the load to the elastic one, below zero where
// the load would be negative or the bodies are separated.
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
  bool a_alone;  // B is held without velocity, and points are no states

  // True of an ellipsoid or a sphere and a plane whose gap is taken in closed form.
  bool on_plane() const {
    auto is_round = [](SurfaceKind kind) { return kind == SurfaceKind::sphere || kind == SurfaceKind::ellipsoid; };
    SurfaceKind kind_a = a.surface.kind, kind_b = b.surface.kind;
    bool plane_and_round = (is_round(kind_a) && kind_b == SurfaceKind::plane) || (kind_a == SurfaceKind::plane && is_round(kind_b));
    return plane_and_round && tracking == Tracking::closed && !by_overlap;
  }
  // Solves for the opposing points; those of the differential form are states.
  void track(const MovingSurface &surface_a, const MovingSurface &surface_b, OpposingPoints &points) const {
    if (on_plane()) return;
    if (tracking == Tracking::closed) points = nearest_pair(surface_a, surface_b);
    else if (tracking == Tracking::algebraic) solve_opposing(surface_a, surface_b, points);
  }
  PairContact contact(const PairState &state) const {
    return contact(a.surface_at(state.a), b.surface_at(state.b), state.points, state.carried);
  }
  // Without `complete` the patch is omitted where only outputs need it.
  PairContact contact(const MovingSurface &surface_a, const MovingSurface &surface_b, const OpposingPoints &points,
                      const CarriedContact &carried, bool complete = true) const;
  void rates(const PairState &state, bool loaded, bool &tracked, PairState &rates) const;

 private:
  // The normal load: the elastic response, and of an overlap its half-widths, the pressure under the elastic load, and the load's
  // centre along the axes.
  struct NormalContact {
    double coefficient;
    Elastic<double, double, double> spring;
    Ellipse patch;
    double along_x, along_y;
  };
  NormalContact law_contact(const Opposition &opposed, double coefficient) const {
    return {coefficient, elastic(coefficient, law.power, opposed.approach), {}, 0.0, 0.0};
  }
  // c of the law, and d ln(c)/d(shape) where the moment of changing curvatures is known.
  CoefficientAndSlope coefficient_at(const Opposition &opposed, const PlaneOpposition *plane, const CarriedContact &carried) const {
    EllipseShape shape = carries_states(law.law) ? carried.shape_for(opposed.gap.small / opposed.gap.large) : EllipseShape{};
    if (plane) return coefficient_and_log_slope(law, opposed.gap.small, opposed.gap.large, plane->excess, shape);
    return {law_coefficient(law, opposed.gap.small, opposed.gap.large, shape), 0.0};
  }
  // The axes are exchanged where the second half-width is the longer one; `kind` is no ellipse where the overlap has no outline.
  NormalContact overlap_contact(const MovingSurface &surface_a, const MovingSurface &surface_b, const Real3 &middle,
                                Opposition &opposed) const {
    NormalContact negligible{4.0 / 3.0 * law.modulus * std::sqrt(size), {}, {}, 0.0, 0.0};  // a scale without contact
    if (opposed.approach <= 0.0 || opposed.kind != RootKind::contact) return negligible;
    Overlap overlap = overlap_of(surface_a, surface_b, middle, opposed.axes, opposed.normal, opposed.approach, size, law.modulus);
    if (!overlap.exists) {
      opposed.kind = RootKind::no_ellipse;
      return negligible;
    }
    double x = overlap.half_width_x, y = overlap.half_width_y, along_x = overlap.centre_x, along_y = overlap.centre_y;
    if (y > x) {
      opposed.axes = {opposed.axes.y, -1.0 * opposed.axes.x};
      std::swap(x, y);
      along_x = overlap.centre_y, along_y = -overlap.centre_x;
    }
    return {overlap.load / std::pow(opposed.approach, 1.5),
            {overlap.load, 1.5 * overlap.load / opposed.approach, overlap.energy},
            {std::sqrt(0.5) * x, std::sqrt(0.5) * y, 3.0 * overlap.load / overlap.area},
            along_x,
            along_y};
  }
};

constexpr double LEAST_RATIO = 1e-9;  // P/Q below which laws have no ellipse

// The contact of two bodies with these opposing points, loaded or not.
inline PairContact TwoBodies::contact(const MovingSurface &surface_a, const MovingSurface &surface_b, const OpposingPoints &points,
                                      const CarriedContact &carried, bool complete) const {
  std::optional<PlaneOpposition> plane;
  if (on_plane()) plane = plane_opposition(surface_a, surface_b, !complete && friction.model == FrictionModel::point);
  Opposition opposed = plane ? *plane : opposition(surface_a, surface_b, points);
  NormalContact normal_contact{};
  Real3 point = plane ? plane->a : points.a, gap_vector = plane ? plane->b - plane->a : points.b - points.a;
  if (by_overlap) {
    if (opposed.kind == RootKind::no_ellipse && opposed.gap.large >= 0.0 && points.lambda < 0.0) opposed.kind = RootKind::contact;
    normal_contact = overlap_contact(surface_a, surface_b, point + 0.5 * gap_vector, opposed);
    point = point + normal_contact.along_x * opposed.axes.x + normal_contact.along_y * opposed.axes.y;
  } else {
    if (opposed.kind == RootKind::contact && !(opposed.gap.small > LEAST_RATIO * opposed.gap.large))
      opposed.kind = RootKind::no_ellipse;
    if (opposed.kind == RootKind::contact) {
      auto [coefficient, log_slope] = coefficient_at(opposed, plane ? &*plane : nullptr, carried);
      normal_contact = law_contact(opposed, coefficient);
      if (plane && opposed.approach > 0.0 && follows_curvatures(law.law))
        point = point +
                *plane->rotation * (opposed.approach / (law.power + 1.0) * (plane->slopes.size + log_slope * plane->slopes.shape));
    }
  }
  if (opposed.approach > 0.0 || !plane) point = point + sink * gap_vector;
  Real3 relative = surface_a.velocity_at(point) - surface_b.velocity_at(point);
  PairContact result{};
  result.kind = opposed.kind, result.approach = opposed.approach, result.gap = opposed.gap, result.normal = opposed.normal,
  result.point = point;
  result.major_axis = opposed.axes.x, result.coefficient = normal_contact.coefficient;
  result.elastic_load = normal_contact.spring.load, result.elastic_energy = normal_contact.spring.energy;
  result.approach_rate = dot(relative, opposed.normal), result.slip = relative - result.approach_rate * opposed.normal;
  result.spin_rate = dot(surface_a.spin - surface_b.spin, opposed.normal);
  result.effective_mass = 1.0 / (a.mobility(surface_a.rotation, point - surface_a.position, opposed.normal) +
                                 b.mobility(surface_b.rotation, point - surface_b.position, opposed.normal));
  result.held = opposed.approach;
  if (!(normal_contact.spring.load > 0.0)) return result;
  double load =
      damping.pulling_load(normal_contact.coefficient, law.power, normal_contact.spring.load, normal_contact.spring.stiffness,
                           result.effective_mass, opposed.approach, result.approach_rate);
  result.held *= load / normal_contact.spring.load;
  result.normal_load = std::max(load, 0.0);
  if (result.normal_load == 0.0) return result;
  // Half-widths and pressure under the whole load, elastic and viscous, as in all other kinds.
  result.patch = normal_contact.patch;
  if (by_overlap) result.patch.peak_pressure *= result.normal_load / normal_contact.spring.load;
  else if (complete || friction.model != FrictionModel::point)
    result.patch = ellipse(opposed.gap.small, opposed.gap.large, law.modulus, result.normal_load);
  if (friction.coefficient > 0.0) {
    PatchForce force =
        contact_friction(friction, regularisation, result.normal_load, result.patch.semi_major, result.patch.semi_minor,
                         dot(result.slip, opposed.axes.x), dot(result.slip, opposed.axes.y), result.spin_rate);
    result.friction = force.force_major * opposed.axes.x + force.force_minor * opposed.axes.y;
    result.spin_moment = force.torque;
  }
  return result;
}

// Time derivative of the state, of its first numbers where A moves alone; without `loaded` contact forces are zero. `tracked` is false
// where the equations of the opposing points are singular.
CORE_INLINE void TwoBodies::rates(const PairState &state, bool loaded, bool &tracked, PairState &rates) const {
  MovingSurface surface_a = a.surface_at(state.a);
  rates.a = a.free_rates(state.a, surface_a.spin, gravity);
  rates.dissipated_viscous = rates.dissipated_friction = rates.load_impulse = 0.0, rates.friction_impulse = {};
  if (a_alone && !loaded) return;
  MovingSurface surface_b = b.surface_at(state.b);
  OpposingPoints points = state.points;
  if (!a_alone) {
    rates.b = b.free_rates(state.b, surface_b.spin, gravity);
    rates.held_work = rates.gross_work = 0.0, rates.points = {};
    if (tracking == Tracking::differential) {
      Unknowns slopes;
      tracked &= opposing_rates(surface_a, surface_b, points, slopes);
      rates.points = opposing_points(slopes);
    }
    if (!loaded) return;
  }
  track(surface_a, surface_b, points);
  PairContact contact_now = contact(surface_a, surface_b, points, state.carried, false);
  rates.dissipated_viscous = (contact_now.normal_load - contact_now.elastic_load) * contact_now.approach_rate;
  if (!(contact_now.normal_load > 0.0)) return;
  Real3 force = contact_now.friction - contact_now.normal_load * contact_now.normal,
        spin_torque = contact_now.spin_moment * contact_now.normal;
  double held =
      a.push(1.0, force, cross(contact_now.point - surface_a.position, force) + spin_torque, state.a, surface_a.spin, rates.a);
  rates.dissipated_friction = -(dot(contact_now.friction, contact_now.slip) + contact_now.spin_moment * contact_now.spin_rate);
  rates.load_impulse = contact_now.normal_load, rates.friction_impulse = contact_now.friction;
  if (a_alone) return;
  held += b.push(-1.0, force, cross(contact_now.point - surface_b.position, force) + spin_torque, state.b, surface_b.spin, rates.b);
  rates.held_work = held, rates.gross_work = std::fabs(held);
}

// The motion of two bodies: longest steps, error scales, ends of steps, and records of contacts.
//
// In flight a step ends at the touch or before it. The distance of convex bodies is no less than that along any fixed direction. Along
// the normal its second derivative is at most  B = g + w^2 max_curvature  of each body (w: greatest angular velocity at this angular
// momentum), so that a gap remains until h + h' t + B t^2/2 = 0: iterated, this converges quadratically. Where the curvature has no
// bound, the greatest relative speed of points limits the step. In contact a step is at most a sixth of 1/sqrt(k/m) at the greatest
// expected stiffness, some 24 a bounce, and longer in lasting contacts; error control resolves start and end.

// Method, rk4 (1) or dop853, tolerance of a contact, step of rk4 in contact [s], and the shortest step [s] of flight, which may end in
// contact.
struct PairPlan {
  double rk4, tolerance, fixed, shortest;
};

// Time and next step [s]; 1 in contact; greatest drift of a quaternion's norm; outputs written; greatest error [m] of the opposing
// points in their equations at the end of a step.
struct PairClock {
  double time, step, in_contact, drift, written, constraint_error;
};

template <std::size_t MOVING>
class TwoBodiesMotion : public AdaptiveMotion<TwoBodiesMotion<MOVING>, PAIR_NUMBERS, MOVING, PairClock> {
  using Base = AdaptiveMotion<TwoBodiesMotion, PAIR_NUMBERS, MOVING, PairClock>;
  using Base::after, Base::clock, Base::end_at_sign_change, Base::evaluate_inside, Base::scales, Base::state;

 public:
  using typename Base::Slopes, typename Base::State;

  // `record` is of the present contact, `step_start` the state at the start of the last step.
  TwoBodiesMotion(const TwoBodies &pair, const PairPlan &plan, State &state, PairClock &clock, ContactRecord &record,
                  State &step_start, Counts &counts, std::int64_t &touch_count)
      : Base(plan.rk4 != 0.0 ? RK4 : DOP853, state, clock, counts),
        pair(pair),
        plan(plan),
        contact_record(record),
        step_start(step_start),
        touch_count(touch_count),
        touch(contact_at(state)) {}

  void rates(const State &numbers, bool loaded, Slopes &slopes) {
    pair.rates(reinterpret_cast<const PairState &>(numbers), loaded, tracked, reinterpret_cast<PairState &>(slopes));
  }
  // Steps of flight do not enter a contact beyond rounding, except the shortest step, which may carry load.
  StepStart start_step() {
    bool loaded = touch.approach > 0.0;
    double least = 1e-6 * plan.shortest, flight = loaded ? 0.0 : flight_step();
    if (touch.kind != RootKind::contact) return {UNTRACKED, 0.0, least, loaded};
    if (loaded && clock.in_contact == 0.0) update_record(0.0, touch, pair_state(state), pair_state(state));  // at the start
    if (flight > 0.0) {
      set_flight_scales();
      return {OK, flight, least, false};
    }
    double longest = set_contact_scales(clock.in_contact > 0.0 ? clock.time - contact_record.began : 0.0);
    if (plan.fixed > 0.0) return {OK, plan.fixed, least, true};
    return {OK, loaded ? std::min(clock.step, longest) : plan.shortest, least, true};
  }
  // A step in which the load ends, or the bodies separate without load, ends there, as the rates have a kink. Where the curvature has
  // no bound, a flight from there would start with the shortest steps.
  StepEnd end_step(double step, bool loaded) {
    constexpr double UNLOADED = 1e-6;  // fraction of the approach that counts as no load
    const double negligible = UNLOADED * touch.approach;
    const bool pressed = touch.held > negligible;
    auto remaining = [=](const PairContact &contact) { return pressed ? contact.held : contact.approach; };
    touch_after = corrected_contact(after);
    const bool lands = loaded && (pressed || std::isfinite(pair.a.max_curvature + pair.b.max_curvature));
    if (lands && remaining(touch) > negligible && remaining(touch_after) < 0.0) {
      step = end_at_sign_change([&](State &numbers) { return remaining(corrected_contact(numbers)); }, step, negligible);
      touch_after = corrected_contact(after);
    }
    return {OK, step};
  }
  void correct(State &numbers) { correct_state(numbers); }
  Accepted accept(double step, double proposed, bool loaded) {
    constexpr double MAX_APPROACH = 0.5;  // of the bodies' size
    const State start = state;
    const PairContact touch_before = touch;
    PairState end = pair_state(after);
    touch = touch_after;
    if (!(touch.approach > 0.0)) end.carried.ratio = 0.0;  // a new contact starts with states that are solved for
    else if (carries_states(pair.law.law) && touch.gap.small > LEAST_RATIO * touch.gap.large)
      end.carried.advance(carried_law(pair.law.law), touch.gap.small / touch.gap.large);
    state = std::bit_cast<State>(end);
    if (touch.approach > MAX_APPROACH * pair.size) return {TOO_DEEP, false};
    clock.drift = std::max(clock.drift, drift), clock.constraint_error = std::max(clock.constraint_error, constraint_error);
    clock.step = !(touch.approach > 0.0) ? HUGE_VAL : loaded ? proposed : plan.shortest;
    // A flight ends at the contact, to rounding.
    bool ended = loaded ? update_record(step, touch_before, pair_state(start), end) : update_record(0.0, touch, end, end);
    if (clock.in_contact > 0.0) record_peak(step), record_depth(step, touch_before, start);
    step_start = start;
    return {OK, ended};
  }
  const ContactRecord &record() const { return contact_record; }
  // True unless the equations of the opposing points were singular.
  bool tracked = true;

 private:
  const TwoBodies &pair;
  const PairPlan &plan;
  ContactRecord &contact_record;
  State &step_start;
  std::int64_t &touch_count;
  PairContact touch, touch_after{};
  double drift = 0.0, constraint_error = 0.0;  // of the last `correct_state`

  static PairState pair_state(const State &numbers) { return std::bit_cast<PairState>(numbers); }
  PairContact contact_at(const State &numbers) const { return pair.contact(pair_state(numbers)); }
  // Corrects quaternions and opposing points at the end of a step.
  void correct_state(State &numbers) {
    PairState state = pair_state(numbers);
    drift = std::max(normalise(state.a.orientation), normalise(state.b.orientation));
    MovingSurface a = pair.a.surface_at(state.a), b = pair.b.surface_at(state.b);
    constraint_error = 0.0;
    if (pair.tracking == Tracking::differential) {
      constraint_error = OpposingEquations(a, b, state.points).distance();
      tracked &= project(a, b, state.points);
    } else {
      pair.track(a, b, state.points);
      if (pair.tracking == Tracking::algebraic) constraint_error = OpposingEquations(a, b, state.points).distance();
    }
    numbers = std::bit_cast<State>(state);
  }
  PairContact corrected_contact(State &numbers) {
    correct_state(numbers);
    return contact_at(numbers);
  }

  // Time [s] to step in flight, without contact but for rounding; 0 where only the shortest step is safe. Where opposing points follow
  // from the last ones, bodies turn little in a step.
  double flight_step() const {
    constexpr double LONGEST = 1.0, TURN = 0.1, FIXED_TURN = 0.02, ROUNDING = 1e-15;  // s; rad a step in flight; of places
    PairState now = pair_state(state);
    double spin_a = pair.a.max_spin(now.a), spin_b = pair.b.max_spin(now.b), gap = std::max(-touch.approach, 0.0);
    double acceleration = pair.a.held() != pair.b.held() ? length_of(pair.gravity) : 0.0, rate = touch.approach_rate,
           safe = HUGE_VAL;
    double turning = spin_a * spin_a * pair.a.max_curvature + spin_b * spin_b * pair.b.max_curvature;
    const bool bounded = std::isfinite(turning);
    if (bounded) acceleration += turning, gap += ROUNDING * (length_of(now.a.position) + length_of(now.b.position) + pair.size);
    else {
      // The greatest relative speed of points: of the centres, and by rotation within the reach of both bodies.
      double distance = length_of(now.a.position - now.b.position);
      rate = length_of(now.a.velocity - now.b.velocity) + spin_a * std::min(pair.a.reach, distance + pair.b.reach) +
             spin_b * std::min(pair.b.reach, distance + pair.a.reach);
    }
    double root = std::sqrt(rate * rate + 2.0 * acceleration * gap);
    if (rate > 0.0) safe = std::max(2.0 * gap / (root + rate), 1e-9 * plan.shortest);
    else if (acceleration > 0.0) safe = std::max((root - rate) / acceleration, plan.shortest);
    if (!bounded && !(safe > plan.shortest)) return 0.0;
    double turn = plan.fixed > 0.0 ? FIXED_TURN : pair.tracking == Tracking::closed ? HUGE_VAL : TURN;
    return std::min({safe, LONGEST, turn / std::max({spin_a, spin_b, 1e-9})});
  }
  // In flight only orientations and integrated points have an error.
  void set_flight_scales() {
    scales.fill(1e300);
    PairState s = pair_state(scales);
    s.a.orientation.fill(plan.tolerance), s.b.orientation.fill(plan.tolerance);
    if (pair.tracking == Tracking::differential) {
      double position_error = plan.tolerance * pair.size;
      s.points = {{position_error, position_error, position_error},
                  {position_error, position_error, position_error},
                  plan.tolerance,
                  position_error};
    }
    scales = std::bit_cast<State>(s);
  }
  // By the expected greatest approach; returns the longest step [s] for a contact of duration `lasted` [s].
  double set_contact_scales(double lasted) {
    constexpr double ROUNDING = 1e-15;
    double power = pair.law.power, weight = length_of(pair.gravity) * touch.effective_mass;
    double spent = greatest_approach(touch.coefficient, power, touch.effective_mass, touch.approach_rate);
    double ahead =
        std::max({std::max(touch.approach, 0.0) + spent, approach_of_load(touch.coefficient, power, weight), ROUNDING * pair.size});
    double rate = std::sqrt(elastic(touch.coefficient, power, ahead).stiffness / touch.effective_mass), speed = ahead * rate;
    double position_error = std::max(plan.tolerance * ahead, ROUNDING * pair.size);
    double velocity_error = std::max(plan.tolerance * speed, ROUNDING * pair.size * rate);
    double energy = velocity_error * touch.effective_mass * speed, impulse = velocity_error * touch.effective_mass;
    scales.fill(1e300);
    PairState s = pair_state(scales);
    for (auto [body, scales_of] : {std::pair{&pair.a, &s.a}, std::pair{&pair.b, &s.b}}) {
      if (body->held()) continue;
      scales_of->position.fill(position_error), scales_of->orientation.fill(position_error / pair.size);
      scales_of->velocity.fill(velocity_error), scales_of->momentum.fill(velocity_error * body->mass * pair.size);
    }
    s.dissipated_viscous = s.dissipated_friction = s.held_work = s.gross_work = energy;
    s.load_impulse = impulse, s.friction_impulse.fill(impulse);
    if (pair.tracking == Tracking::differential)
      s.points = {{position_error, position_error, position_error},
                  {position_error, position_error, position_error},
                  position_error / pair.size,
                  position_error};
    scales = std::bit_cast<State>(s);
    return longest_contact_step(lasted, rate);
  }

  // Opens or closes the record of a contact that starts or ends in the step; returns true where one has ended. `start` and `end` are the
  // states at both ends of the step, `touch` the contact at its end: the step in which bodies touch is part of the contact, as damping
  // acts at once.
  bool update_record(double step, const PairContact &at_start, const PairState &start, const PairState &end) {
    bool touches = touch.approach > 0.0;
    auto fraction = [&] {
      return crossing(step, {at_start.approach, at_start.approach_rate}, {touch.approach, touch.approach_rate});
    };
    if (touches && clock.in_contact == 0.0) {
      clock.in_contact = 1.0, touch_count++;
      contact_record = {};
      contact_record.began = clock.time - (at_start.approach <= 0.0 && 0.0 < step ? 1.0 - fraction() : 1.0) * step;
      contact_record.speed_in = at_start.approach_rate;
      contact_record.impulse = start.load_impulse, contact_record.friction_impulse = start.friction_impulse;
    }
    if (touches) contact_record.update_peak(touch);
    if (touches || clock.in_contact == 0.0) return false;
    clock.in_contact = 0.0;
    contact_record.ended = clock.time - (1.0 - fraction()) * step, contact_record.speed_out = -touch.approach_rate;
    contact_record.impulse = end.load_impulse - contact_record.impulse;
    contact_record.friction_impulse = end.friction_impulse - contact_record.friction_impulse;
    return true;
  }
  // The contact `length` [s] after a state, by a step of its own.
  PairContact contact_after(const State &from, double length) {
    State numbers;
    evaluate_inside(from, length, numbers);
    double drift_of_step = drift, off_of_step = constraint_error;
    PairContact contact_inside = corrected_contact(numbers);
    drift = drift_of_step, constraint_error = off_of_step;
    return contact_inside;
  }
  // The peak load, where the loads at the ends of the last two steps enclose a maximum.
  void record_peak(double step) {
    auto load = [&](double previous, double time) {
      PairContact contact_inside = contact_after(step_start, previous + time);
      contact_record.update_peak(contact_inside);
      return contact_inside.normal_load;
    };
    refine_maximum(load, contact_record.trail, step, touch.normal_load, contact_record.peak_load);
  }
  // The greatest approach in the step, after the greatest load where there is damping.
  void record_depth(double step, const PairContact &at_start, const State &start) {
    auto approach = [&](double time) -> ValueAndRate {
      PairContact contact_inside = contact_after(start, time);
      return {contact_inside.approach, contact_inside.approach_rate};
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
  for (double &number : body.inertia) number = *next++;
  body.surface.kind = SurfaceKind(int(*next++));
  for (double &number : body.surface.size) number = *next++;
  body.surface.side = *next++, body.reach = *next++, body.max_curvature = *next++;
  return body;
}

TwoBodies pair_of(const double *next, const double *points, const double *state) {
  TwoBodies pair{};
  pair.a = body_of(next), pair.b = body_of(next);
  for (double &number : pair.gravity) number = *next++;
  pair.sink = *next++, pair.size = *next++;
  pair.tracking = Tracking(int(*next++)), pair.by_overlap = *next++ != 0.0;
  static_cast<ContactLaws &>(pair) = contact_laws_of(next, points);
  const RigidState &b = reinterpret_cast<const PairState *>(state)->b;
  pair.a_alone = pair.b.held() && b.velocity == Real3{} && b.momentum == Real3{} && pair.tracking != Tracking::differential;
  return pair;
}

// Writes the channels of a state in their order, without those of the numerics.
void write_outputs(const TwoBodies &pair, const PairState &state, double *out) {
  auto put = [&](const auto &numbers) { out = std::copy(numbers.begin(), numbers.end(), out); };
  double kinetic = 0.0, potential = 0.0;
  for (auto [body, rigid] : {std::pair{&pair.a, state.a}, std::pair{&pair.b, state.b}}) {
    Real3 spin = body->spin(rigid, rotation_matrix(rigid.orientation));
    normalise(rigid.orientation);
    put(rigid.position), put(rigid.orientation), put(rigid.velocity), put(spin);
    put(body->held() ? Real3{} : rigid.momentum);
    kinetic += body->kinetic_energy(rigid, spin), potential -= body->mass * dot(pair.gravity, rigid.position);
  }
  PairContact contact = pair.contact(state);
  *out++ = contact.approach, *out++ = contact.normal_load;
  put(contact.friction);
  *out++ = contact.spin_moment, *out++ = contact.spin_rate;
  put(contact.point), put(contact.normal), put(contact.slip), put(contact.major_axis);
  *out++ = contact.patch.semi_major, *out++ = contact.patch.semi_minor, *out++ = contact.patch.peak_pressure;
  *out++ = contact.gap.small, *out++ = contact.gap.large, *out++ = contact.approach > 0.0;
  *out++ = kinetic, *out++ = potential, *out++ = contact.elastic_energy;
  *out++ = state.dissipated_viscous, *out++ = state.dissipated_friction, *out++ = state.held_work, *out++ = state.gross_work;
}

}  // namespace

// Integrates until a time [s]; `states` are those at the `instants` (outputs,) [s], `records` (capacity,) the `completed` contacts;
// `counts` (4,) ends with the number of contacts. Returns a status.
CORE_EXPORT std::int64_t core_two_bodies_advance(const double *numbers, const double *points, const double *plan, double *state,
                                                 double *clock, double *record, double *step_start, double until,
                                                 std::int64_t outputs, const double *instants, const volatile std::uint8_t *stop,
                                                 double *states, std::int64_t capacity, double *records, std::int64_t *completed,
                                                 std::int64_t *counts) {
  using State = Numbers<PAIR_NUMBERS>;
  TwoBodies pair = pair_of(numbers, points, state);
  auto advance = [&]<std::size_t MOVING>(std::integral_constant<std::size_t, MOVING>) {
    TwoBodiesMotion<MOVING> motion(pair, *reinterpret_cast<const PairPlan *>(plan), *reinterpret_cast<State *>(state),
                                   *reinterpret_cast<PairClock *>(clock), *reinterpret_cast<ContactRecord *>(record),
                                   *reinterpret_cast<State *>(step_start), *reinterpret_cast<Counts *>(counts), counts[3]);
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
