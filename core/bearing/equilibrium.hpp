// Equilibrium of a ring on its balls, or of a shaft on two rings: five coordinates (x, y, z, theta_x, theta_y), each held or
// free. The coordinates act on a ball through its `opening`; forces and moments follow by the derivatives of that. The free
// coordinates are solved for by Newton's method with the condensed stiffness of the balls, with a bracketed line search for
// the point at which the work along the step vanishes (without speed the energy is nearly convex). The equilibrium of a single
// ring is stable.
#pragma once
#include <algorithm>
#include <array>
#include <vector>
#include "raceway_contact.hpp"

namespace core::equilibria {

// One ball between two grooves in equilibrium (Jones 1960; Harris, Rolling Bearing Analysis), LANES balls side by side.
//
// Opening. The ring's centre lies at d = x cos(psi) + y sin(psi) outwards and s = y cos(psi) - x sin(psi) ahead of a ball
// at the azimuth psi, where its groove, a circle about the ring's own axis, is displaced inwards by s^2/(2 r), r = d_m/2. Of a
// tilt theta, b = theta_x sin(psi) - theta_y cos(psi) acts in the ball's plane and l = theta_x cos(psi) + theta_y sin(psi)
// across it. The inner groove's centre against the outer one's is, tilts being of first order,
//
//     A_r = A_0 + d - s^2/(2 r),   A_z = z + R b - s l.
//
// Balance. The meridian plane of the ball has axes (radial, axial); `position` is the ball's centre relative to the outer
// groove's. Both contacts pull the ball towards its groove's centre: Q_i along n_i = (opening - position)/|.|, and -Q_o along
// n_o = position/|.|. With t = (-n_z, n_r), and the gyroscopic moment M_g carried by friction in the shares lambda,
//
//     0 = Q_i n_i - Q_o n_o + F_c e_r + weight + (M_g / D) (lambda_i t_i - lambda_o t_o).
//
// Raceway control determines the shares (lambda_i, lambda_o) and the pitch beta of the ball's axis: `outer` has (0, 2)
// and tan(beta) = sin(a_o)/(cos(a_o) + gamma), gamma = D/d_m; `inner` (2, 0) and sin(a_i)/(cos(a_i) - gamma); `shared`
// (1, 1) and the pitch of outer control.

using core::select;

struct Groove {
  double locus_radius, groove_radius;
  GroovePolynomial coefficient;
};

// The numbers of the balance (SI): doubles alone, in the order in which Python writes them (`Setting.numbers`). `arm` [m]
// turns a tilt into axial displacement and an axial force into a moment; `lever` [m] is the arm of the friction that
// carries the gyroscopic moment, about the point at the end of `arm`. The last three are those of a ring on a shaft: its
// axial position [m], the side it faces, and `middle` [m] along its own axis.
struct Seat {
  Groove inner, outer;
  double power, ball_radius, ball_mass, pitch_diameter, arm, lever, speed, share_inner, share_outer;
  double gravity[3], position, facing, middle;

  double gamma() const { return 2.0 * ball_radius / pitch_diameter; }
  double reach(const Groove &groove) const { return groove.groove_radius - ball_radius; }
};

constexpr double STEEPEST_COSINE = 0.5;  // cosine of the steepest contact angle
constexpr double STEEPEST_SINE = 0.8660254037844386;  // its sine
constexpr int MAX_ITERATIONS = 120, MAX_HALVINGS = 20, MAX_BISECTIONS = 40;
constexpr double BALANCE_TOLERANCE = 1e-9;  // of the loads: residual before the last step, which squares it and is not evaluated
constexpr double SMALLEST_STEP = 4e-17;  // of the groove's radius: a smaller step is below rounding
constexpr double PROBE = 1e-6;  // m: approach at which a law's coefficient is read

// In the meridian plane.
template <class R, class Z = R>
struct Plane {
  R r;
  Z z;
};
template <class R, class Z>
Plane(R, Z) -> Plane<R, Z>;

CORE_INLINE Plane<Pack> select(const Mask &which, const Plane<Pack> &yes, const Plane<Pack> &no) {
  return {select(which, yes.r, no.r), select(which, yes.z, no.z)};
}

// One contact: approach [m], load [N] and direction.
template <class X>
struct ContactLoad {
  X approach, load, n_r, n_z;
};
template <class X>
ContactLoad(X, X, X, X) -> ContactLoad<X>;

// The contact where `v` [m] points from the ball's centre to the inner groove's, or from the outer one's to it.
template <class R, class Z>
CORE_INLINE auto contact_load(const Seat &seat, const Groove &groove, const Plane<R, Z> &v, const Pack &height = Pack{}) {
  auto [distance, inverse] = root_and_inverse(v.r * v.r + v.z * v.z + 1e-300);
  auto n_r = v.r * inverse, n_z = v.z * inverse;
  auto approach = distance - seat.reach(groove) + height;
  auto load = elastic(along_groove(groove.coefficient, n_r), seat.power, approach).load;
  return ContactLoad{approach, load, n_r, n_z};
}

// Forces on a ball other than of contacts [N], and heights of the raceways under it [m].
struct ExternalLoad : Plane<Pack> {
  Pack inner{}, outer{};
};

// For `ball_speeds`: cosine and sine of a contact angle a, beyond 60 degrees those of 120 - |a| degrees, at least 0.
template <class X>
CORE_INLINE auto reflected_angle(const ContactLoad<X> &push) {
  auto level = value_of(push.n_r) >= STEEPEST_COSINE, beyond = value_of(push.n_r) <= -STEEPEST_COSINE;
  auto size = absolute(push.n_z);
  auto cosine = select(level, push.n_r, select(beyond, 0.0 * size + 1.0, STEEPEST_SINE * size - STEEPEST_COSINE * push.n_r));
  auto sign = select(value_of(push.n_z) >= 0.0, broadcast<ValueOf<X>>(1.0), broadcast<ValueOf<X>>(-1.0));
  auto sine = select(level, push.n_z, select(beyond, 0.0 * size, sign * (STEEPEST_SINE * push.n_r + STEEPEST_COSINE * size)));
  return std::pair{cosine, sine};
}

// A ball that is clear of the inner raceway by this fraction of the distance between both centres orbits as at angle zero.
constexpr double LOOSE_GAP = 0.3;  // tuned: below 0.1 runs of shafts take more steps, as speeds of balls that come off change fast
// A ball whose load on the inner raceway exceeds this fraction of its centrifugal load may be under inner control.
constexpr double GRIPPING_LOAD = 0.25;  // tuned: Harris' criterion is far from inner control at such a load

// Centrifugal load F_c = m d_m omega_m^2 / 2 [N] and M_g / D [N], M_g = J omega_R omega_m sin(beta), J = m D^2/10; and over
// the ring's speed: the orbit's, and the roll's along the ball's axis times gamma, and times its pitch.
template <class X>
struct BallSpeeds {
  X centrifugal, gyroscopic, orbit, roll, pitch;
};

// From 0 to 1 with slopes of 0 at both ends, for a part from 0 to 1.
template <class X>
CORE_INLINE auto smooth_step(const X &part) {
  auto within = minimum(maximum(part, 0.0), 1.0);
  return within * within * (3.0 - 2.0 * within);
}

// The speeds of a ball that touches both raceways follow from both contact angles, whatever its loads (Harris). As the ball leaves
// the inner one they go over to those at angle zero: with a jump the balance may have no solution. Beyond 60 degrees angles are
// reflected. Under inner control the pitch, without which there is no gyroscopic moment, vanishes with the load that carries it.
template <class I, class O>
CORE_INLINE auto ball_speeds(const Seat &seat, const ContactLoad<I> &inner, const ContactLoad<O> &outer) {
  constexpr unsigned COLUMNS = columns_of<I> | columns_of<O>;
  const double gamma = seat.gamma(), square = seat.ball_mass * seat.pitch_diameter * seat.speed * seat.speed;
  const double level_orbit = 0.5 * (1.0 - gamma), level_roll = 0.5 * (1.0 - gamma * gamma);
  auto [c_o, s_o] = reflected_angle(outer);
  auto [c_i, s_i] = reflected_angle(inner);
  auto lean = widened<COLUMNS>(s_o / (c_o + gamma));
  if (seat.share_inner > seat.share_outer) {
    const double enough = GRIPPING_LOAD * 0.5 * square * level_orbit * level_orbit;
    lean = widened<COLUMNS>(smooth_step((1.0 / (enough + 1e-300)) * inner.load) * (s_i / (c_i - gamma)));
  }
  auto p_o = (c_o + lean * s_o) / (1.0 + gamma * c_o), p_i = (c_i + lean * s_i) / (1.0 - gamma * c_i);
  auto rolls = smooth_step(1.0 + (1.0 / (LOOSE_GAP * seat.reach(seat.inner))) * inner.approach);
  auto rolling = 1.0 / (p_o + p_i);
  auto orbit = level_orbit + rolls * (p_o * rolling - level_orbit), roll = level_roll + rolls * (rolling - level_roll);
  auto pitch = rolls * (lean * rolling);
  return BallSpeeds<decltype(roll)>{0.5 * square * (orbit * orbit), 0.1 * square * (pitch * orbit), orbit, roll, pitch};
}

// Columns: the vector between the ball's centre and the inner groove's (radial, axial), and between the outer one's and it.
constexpr unsigned BY_PLACES = 0b1111;

// Residual of a ball's balance [N], and its part of the ring's load: external `force` [N] and `moment` [N m] on the ring that
// balance the ball. `scale` [N] is that of its loads.
template <class X>
struct Balance {
  X residual_r, residual_z, force_r, force_z, moment;
  ValueOf<X> scale;
};

template <class I, class O>
CORE_INLINE auto balance(const Seat &seat, const ContactLoad<I> &inner, const ContactLoad<O> &outer, const ExternalLoad &weight) {
  constexpr unsigned COLUMNS = columns_of<I> | columns_of<O>;
  auto none = widened<COLUMNS>(Pack{});
  auto centrifugal = none, gyroscopic = none;
  if (seat.speed != 0.0) {
    auto speeds = ball_speeds(seat, inner, outer);
    centrifugal = speeds.centrifugal;
    gyroscopic = speeds.gyroscopic;
  }
  auto gyroscopic_inner = seat.share_inner * gyroscopic, gyroscopic_outer = seat.share_outer * gyroscopic;
  auto force_r = inner.load * inner.n_r - gyroscopic_inner * inner.n_z,
       force_z = inner.load * inner.n_z + gyroscopic_inner * inner.n_r;
  auto residual_r = force_r - outer.load * outer.n_r + gyroscopic_outer * outer.n_z + centrifugal + weight.r;
  auto residual_z = force_z - outer.load * outer.n_z - gyroscopic_outer * outer.n_r + weight.z;
  return Balance<decltype(residual_r)>{residual_r,
                                       residual_z,
                                       force_r,
                                       force_z,
                                       -seat.lever * gyroscopic_inner,
                                       value_of(inner.load) + value_of(outer.load) + value_of(centrifugal)};
}

using Number = Dual<BY_PLACES, Pack>;

inline Balance<Number> differentiated_balance(const Seat &seat, const Plane<Pack> &opening, const Plane<Pack> &position,
                                              const ExternalLoad &weight) {
  Plane inner{variable<0>(Pack(opening.r - position.r)), variable<1>(Pack(opening.z - position.z))};
  Plane outer{variable<2>(position.r), variable<3>(position.z)};
  return balance(seat, contact_load(seat, seat.inner, inner, weight.inner), contact_load(seat, seat.outer, outer, weight.outer),
                 weight);
}

// Derivatives by the ball's position at constant opening, and by the opening at constant position.
CORE_INLINE Plane<Pack> by_position(const Number &x) { return {x.slope[2] - x.slope[0], x.slope[3] - x.slope[1]}; }
CORE_INLINE Plane<Pack> by_opening(const Number &x) { return {x.slope[0], x.slope[1]}; }
CORE_INLINE Pack dot(const Plane<Pack> &a, const Plane<Pack> &b) { return a.r * b.r + a.z * b.z; }

// The linear equations of a Newton step of the position.
struct PositionEquations {
  Plane<Pack> radial, axial;
  Pack determinant;
  explicit PositionEquations(const Balance<Number> &current)
      : radial(by_position(current.residual_r)),
        axial(by_position(current.residual_z)),
        determinant(radial.r * axial.z - radial.z * axial.r) {}
  Mask singular() const { return ~(absolute(determinant) > 1e-14 * (absolute(radial.r * axial.z) + absolute(radial.z * axial.r))); }
  // The step that cancels this residual; 0 where the ball has no contact.
  Plane<Pack> solved(const Pack &residual_r, const Pack &residual_z) const {
    Pack inverse = select(determinant == 0.0, Pack{}, 1.0 / determinant);
    return {(radial.z * residual_z - axial.z * residual_r) * inverse, (axial.r * residual_r - radial.r * residual_z) * inverse};
  }
};

struct BallEquilibrium {
  Plane<Pack> position;
  Balance<Number> balance;
  Mask done;
};

CORE_INLINE Balance<Number> select(const Mask &which, const Balance<Number> &yes, const Balance<Number> &no) {
  return {select(which, yes.residual_r, no.residual_r), select(which, yes.residual_z, no.residual_z),
          select(which, yes.force_r, no.force_r),       select(which, yes.force_z, no.force_z),
          select(which, yes.moment, no.moment),         select(which, yes.scale, no.scale)};
}

// Damped Newton steps from an initial position, individual for each ball.
inline BallEquilibrium newton(const Seat &seat, const Plane<Pack> &opening, const Plane<Pack> &begin, const ExternalLoad &weight) {
  const double smallest = SMALLEST_STEP * seat.outer.groove_radius;
  BallEquilibrium best{begin, {}, Mask{}};
  Plane<Pack> trial = begin;
  Pack size = broadcast<Pack>(HUGE_VAL), factor = broadcast<Pack>(1.0), failures{};
  Mask running = ~Mask{};
  for (int iteration = 0; iteration < MAX_ITERATIONS; iteration++) {
    Balance<Number> current = differentiated_balance(seat, opening, trial, weight);
    Pack residual = absolute(current.residual_r.value) + absolute(current.residual_z.value);
    // Without contact the residual may be smaller, but the equations are singular.
    Mask better =
        running & (residual < size) & ~(PositionEquations(current).singular() & (residual > BALANCE_TOLERANCE * current.scale));
    best.balance = iteration == 0 ? current : select(better, current, best.balance);
    best.position = select(better, trial, best.position);
    size = select(better, residual, size);
    failures = select(better, Pack{}, failures + 1.0);
    factor = select(better, broadcast<Pack>(1.0), 0.35 * factor);

    Balance<Number> &accepted = best.balance;
    PositionEquations equations(accepted);
    Plane<Pack> step = equations.solved(accepted.residual_r.value, accepted.residual_z.value);
    Mask converged = running & (size <= BALANCE_TOLERANCE * accepted.scale), singular = equations.singular();
    Mask stalled = running & ~singular & (absolute(step.r) + absolute(step.z) <= smallest);
    if (Mask last = converged & ~singular; any(last)) {
      best.position = select(last, {best.position.r + step.r, best.position.z + step.z}, best.position);
      for (Number *number : {&accepted.force_r, &accepted.force_z, &accepted.moment})
        number->value = select(last, number->value + dot(by_position(*number), step), number->value);
    }
    best.done |= converged | stalled;
    running &= ~(converged | stalled | singular | (failures >= double(MAX_HALVINGS)));
    if (!any(running)) break;
    trial = {best.position.r + factor * step.r, best.position.z + factor * step.z};
  }
  return best;
}

// The vector between the centres of groove and ball for a ball pressed against one raceway alone by this force [N].
inline Plane<Pack> resting_position(const Seat &seat, const Groove &groove, const Plane<Pack> &along, const Pack &height) {
  Pack load = square_root(along.r * along.r + along.z * along.z + 1e-300);
  Plane<Pack> n{along.r / load, along.z / load};
  const double deep = seat.reach(groove) + PROBE;
  Pack coefficient = contact_load(seat, groove, Plane<Pack>{n.r * deep, n.z * deep}).load / std::pow(PROBE, seat.power);
  Pack length =
      seat.reach(groove) - height + each_lane(load / coefficient, [&](double x) { return std::pow(x, 1.0 / seat.power); });
  return {n.r * length, n.z * length};
}

struct InitialGuess {
  Plane<Pack> position;
  Mask floats;
};

// Initial position of a ball, and whether it floats free of forces, so that any position is a solution. The energy of both contacts
// is convex in the position, so that rest on one raceway without contact to the other is the solution but for the gyroscopic moment.
inline InitialGuess initial_guess(const Seat &seat, const Plane<Pack> &opening, const ExternalLoad &weight) {
  Pack reach_i = seat.reach(seat.inner) - weight.inner, reach_o = seat.reach(seat.outer) - weight.outer;
  Pack distance = square_root(opening.r * opening.r + opening.z * opening.z + 1e-300);
  Pack squeeze = distance - reach_i - reach_o, share = (reach_o + 0.5 * squeeze) / distance;
  Plane<Pack> between{share * opening.r, share * opening.z};
  Mask loose = ~(squeeze > 0.0);
  if (!any(loose)) return {between, Mask{}};
  // the centrifugal load at contact angle zero, where the orbit speed is (1 - gamma)/2 of the ring's
  const double orbit = 0.5 * seat.speed * (1.0 - seat.gamma());
  Plane<Pack> force{0.5 * seat.ball_mass * seat.pitch_diameter * orbit * orbit + weight.r, weight.z};
  Mask floats = loose & (force.r == 0.0) & (force.z == 0.0);
  Plane<Pack> on_outer = resting_position(seat, seat.outer, force, weight.outer);
  Plane<Pack> on_inner = resting_position(seat, seat.inner, {-force.r, -force.z}, weight.inner);
  Plane<Pack> to_inner{opening.r - on_outer.r, opening.z - on_outer.z}, to_outer{opening.r - on_inner.r, opening.z - on_inner.z};
  Mask clear_inner = dot(to_inner, to_inner) <= reach_i * reach_i;
  Mask clear_outer = dot(to_outer, to_outer) <= reach_o * reach_o;
  // In contact with both, the ball is at an intersection of circles about their centres, on the side of the force. The initial
  // loads exceed those of the solution: from there Newton's method loses no contact.
  Plane<Pack> greatest{absolute(force.r - weight.r) + absolute(weight.r) + absolute(weight.z), Pack{}};
  Pack r_o = resting_position(seat, seat.outer, greatest, weight.outer).r,
       r_i = resting_position(seat, seat.inner, greatest, weight.inner).r;
  Pack along = 0.5 * (distance + (r_o * r_o - r_i * r_i) / distance);
  Pack across = square_root(maximum(r_o * r_o - along * along, 0.0) + 1e-300);
  across = select(force.z * opening.r - force.r * opening.z < 0.0, -across, across);
  Plane<Pack> wedged{(along * opening.r - across * opening.z) / distance, (along * opening.z + across * opening.r) / distance};
  Plane<Pack> position = select(~loose | floats, between, select(clear_inner, on_outer, select(clear_outer, to_outer, wedged)));
  return {position, floats};
}

// A ball's position by nested bisection: the radial residual decreases with the radial position, and that left axially with the
// axial one, as the energy is convex while speeds change little with the angles.
inline Plane<Pack> bisected(const Seat &seat, const Plane<Pack> &opening, const ExternalLoad &weight) {
  auto balance_at = [&](const Plane<Pack> &position) {
    Plane<Pack> inner{opening.r - position.r, opening.z - position.z};
    return balance(seat, contact_load(seat, seat.inner, inner, weight.inner),
                   contact_load(seat, seat.outer, position, weight.outer), weight);
  };
  Pack extent = square_root(opening.r * opening.r + opening.z * opening.z) + (seat.inner.groove_radius + seat.outer.groove_radius);
  Pack low_z = -extent, high_z = extent;
  Plane<Pack> position{};
  for (int i = 0; i < MAX_BISECTIONS; i++) {
    position.z = 0.5 * (low_z + high_z);
    Pack low_r = -extent, high_r = extent;
    for (int j = 0; j < MAX_BISECTIONS; j++) {
      position.r = 0.5 * (low_r + high_r);
      Mask below = balance_at(position).residual_r > 0.0;
      low_r = select(below, position.r, low_r), high_r = select(below, high_r, position.r);
    }
    Mask below = balance_at(position).residual_z > 0.0;
    low_z = select(below, position.z, low_z), high_z = select(below, high_z, position.z);
  }
  position.z = 0.5 * (low_z + high_z);
  return position;
}

// Equilibrium of balls by Newton's method; where it fails, from a position by nested bisection.
inline BallEquilibrium ball_equilibrium(const Seat &seat, const Plane<Pack> &opening, const ExternalLoad &weight) {
  const InitialGuess guess = initial_guess(seat, opening, weight);
  BallEquilibrium result = newton(seat, opening, guess.position, weight);
  if (Mask failed = ~(result.done | guess.floats); any(failed)) {
    BallEquilibrium retried = newton(seat, opening, bisected(seat, opening, weight), weight);
    result = {select(failed, retried.position, result.position), select(failed, retried.balance, result.balance),
              result.done | retried.done};
  }
  return result;
}

// The ring on its balls.

constexpr int COORDINATES = 5;
constexpr int CONTACT_NUMBERS = 17;  // of a ball: see `System::contacts`
constexpr int MAX_TRIALS = 40, MAX_RING_EVALUATIONS = 300, PARTS = 12;
constexpr double RING_TOLERANCE = 1e-11;  // of the loads: residual of the ring's balance
constexpr double ACCEPTED_RESIDUAL = 1e-9;  // as above, where no step reduces it any more
constexpr double ROUNDING = 4e-15;  // of the opening: rounding of a ball's position
constexpr double SOFT_PIVOT = 1e-9;  // of the greatest stiffness: smaller ones count as none
constexpr double NEGATIVE_PIVOT = 1e-12;  // as above: a stiffness below minus this is negative beyond rounding
constexpr double PERTURBATION = 1e-6;  // of the greatest displacement: first step from an unstable equilibrium
constexpr double MAX_DISPLACEMENT = 0.2;  // of the ball diameter

using Vector5 = std::array<double, COORDINATES>;
using Matrix5 = std::array<Vector5, COORDINATES>;
using FreeMask = std::array<bool, COORDINATES>;

enum Status { CONVERGED, UNLOADED, NOT_CONVERGED, STOPPED };

// LANES balls of one ring; `present` is 0 in lanes that repeat the last ball.
struct Balls {
  Pack cosine, sine, present;
  ExternalLoad weight;
  Plane<Pack> position;
};

// A number with derivatives by the five coordinates, from those by the opening.
template <class R, class Z>
CORE_INLINE auto chained_by_opening(const Pack &value, const Plane<Pack> &derivatives, const R &radial, const Z &axial) {
  return dual < columns_of<R> | columns_of < Z >> (value, [&]<int C>() __attribute__((always_inline)) {
                                  return derivatives.r * slope_of<C>(radial) + derivatives.z * slope_of<C>(axial);
                                });
}

// The inner groove's centre relative to the outer one's [m], and terms of its slopes.
template <class R, class Z, class S, class L>
struct Opening {
  R radial;
  Z axial;
  S tangential, side;
  L across;
};
template <class R, class Z, class S, class L>
Opening(R, Z, S, S, L) -> Opening<R, Z, S, L>;

class Ring {
 public:
  const Seat *seat = nullptr;
  int count = 0;
  std::vector<Balls> balls;
  bool balanced = false;  // of each ball in the last `loads_at`

  void set(const Seat &its_seat, int its_count) {
    seat = &its_seat, count = its_count;
    balls.resize((count + LANES - 1) / LANES);
  }
  // Places the balls at these azimuths [rad]; `heights` (N, 2) [m] of the inner and the outer raceway under them, null: none.
  void place_balls(const double *azimuth, const double *heights = nullptr) {
    for_each_lane([&](Balls &b, int lane, int ball, bool present) {
      b.weight.inner[lane] = heights ? heights[2 * ball] : 0.0, b.weight.outer[lane] = heights ? heights[2 * ball + 1] : 0.0;
      b.cosine[lane] = std::cos(azimuth[ball]), b.sine[lane] = std::sin(azimuth[ball]), b.present[lane] = present;
    });
    const double *g = seat->gravity;
    for (Balls &b : balls)
      b.weight.r = seat->ball_mass * (g[0] * b.cosine + g[1] * b.sine), b.weight.z = broadcast<Pack>(seat->ball_mass * g[2]);
  }
  // Positions (N, 2) [m] of the balls relative to the outer groove's centre: radial, axial.
  void write_positions(double *out) const {
    for (int ball = 0; ball < count; ball++) {
      const Plane<Pack> &position = balls[ball / LANES].position;
      *out++ = position.r[ball % LANES], *out++ = position.z[ball % LANES];
    }
  }

  // The opening with its slopes by the five coordinates, or its values alone.
  template <bool DERIVATIVES>
  CORE_INLINE auto opening(const Balls &b, const Vector5 &q) const {
    auto coordinate = [&]<int C>(Index<C>) __attribute__((always_inline)) { return input<DERIVATIVES, C>(broadcast<Pack>(q[C])); };
    auto x = coordinate(index<0>), y = coordinate(index<1>), z = coordinate(index<2>), tilt_x = coordinate(index<3>),
         tilt_y = coordinate(index<4>);
    auto outwards = b.cosine * x + b.sine * y, tangential = b.cosine * y - b.sine * x;
    auto along = b.sine * tilt_x - b.cosine * tilt_y, across = b.cosine * tilt_x + b.sine * tilt_y;
    auto side = (2.0 / seat->pitch_diameter) * tangential;
    auto radial = outwards + (seat->inner.locus_radius - seat->outer.locus_radius) - 0.5 * side * tangential;
    auto axial = z + seat->arm * along - tangential * across;
    return Opening{radial, axial, tangential, side, across};
  }
  CORE_INLINE Plane<Pack> opening_at(const Balls &b, const Vector5 &q) const {
    auto opening_values = opening<false>(b, q);
    return {opening_values.radial, opening_values.axial};
  }

  // External load (5,) [N, N m] that holds the ring at `q`, and its derivative; returns the scale of the loads [N].
  double loads_at(const Vector5 &q, Vector5 &load, Matrix5 &stiffness) {
    constexpr unsigned ALL = 0b11111;
    Dual<ALL, Pack> total[COORDINATES]{};
    Pack scale{};
    balanced = true;
    for (Balls &b : balls) {
      auto slopes = opening<true>(b, q);
      Plane<Pack> opening{slopes.radial.value, slopes.axial.value};
      BallEquilibrium solution = ball_equilibrium(*seat, opening, b.weight);
      const Balance<Number> &current = solution.balance;
      balanced &= !any(~solution.done);
      // d(position)/d(opening) at zero residual
      PositionEquations equations(current);
      Plane<Pack> by_r = equations.solved(current.residual_r.slope[0], current.residual_z.slope[0]);
      Plane<Pack> by_z = equations.solved(current.residual_r.slope[1], current.residual_z.slope[1]);
      b.position = solution.position;
      auto condensed = [&](const Number &number) __attribute__((always_inline)) {
        Plane<Pack> position = by_position(number), direct = by_opening(number);
        Plane<Pack> total_derivative{direct.r + dot(position, by_r), direct.z + dot(position, by_z)};
        return b.present * chained_by_opening(number.value, total_derivative, slopes.radial, slopes.axial);
      };
      auto radial = condensed(current.force_r), axial = condensed(current.force_z), moment = condensed(current.moment);
      // virtual work: each load is the ball's force times the opening's slope by that coordinate
      auto add = [&](int i, const auto &term) __attribute__((always_inline)) { total[i] = total[i] + widened<ALL>(term); };
      add(0, radial * (b.cosine + slopes.side * b.sine) + axial * (slopes.across * b.sine));
      add(1, radial * (b.sine - slopes.side * b.cosine) - axial * (slopes.across * b.cosine));
      add(2, axial);
      add(3, axial * (seat->arm * b.sine - slopes.tangential * b.cosine) + b.sine * moment);
      add(4, -(axial * (seat->arm * b.cosine + slopes.tangential * b.sine)) - b.cosine * moment);
      scale += b.present * current.scale;
    }
    for (int i = 0; i < COORDINATES; i++) {
      load[i] = lane_sum(total[i].value);
      for (int j = 0; j < COORDINATES; j++) stiffness[i][j] = lane_sum(total[i].slope[j]);
    }
    return lane_sum(scale);
  }

  // Of each ball, with the ring at `q`: approach, load, angle, friction, small and large curvature, each inner and outer, then
  // orbit, roll along the axis and pitch along the radius [rad/s], both relative to the orbit, centrifugal load, and the ratio of
  // orbit to ring speed.
  void write_contacts(const Vector5 &q, double *out) {
    for (Balls &b : balls) {
      Plane<Pack> opening = opening_at(b, q);
      auto inner =
          contact_load(*seat, seat->inner, Plane<Pack>{opening.r - b.position.r, opening.z - b.position.z}, b.weight.inner);
      auto outer = contact_load(*seat, seat->outer, b.position, b.weight.outer);
      auto speeds = ball_speeds(*seat, inner, outer);
      for (int lane = 0; lane < LANES; lane++) {
        int ball = int(&b - balls.data()) * LANES + lane;
        if (ball >= count) break;
        double *row = out + CONTACT_NUMBERS * ball;
        for (int race = 0; race < 2; race++) {
          const ContactLoad<Pack> &contact = race == 0 ? inner : outer;
          const Groove &groove = race == 0 ? seat->inner : seat->outer;
          double n = contact.n_r[lane], friction_share = race == 0 ? seat->share_inner : -seat->share_outer;
          row[0 + race] = contact.approach[lane], row[2 + race] = contact.load[lane];
          row[4 + race] = std::atan2(contact.n_z[lane], n), row[6 + race] = friction_share * speeds.gyroscopic[lane];
          row[8 + race] = curvature_across_groove(seat->ball_radius, groove.groove_radius);
          row[10 + race] = curvature_along_groove(seat->ball_radius, groove.locus_radius, groove.groove_radius, race == 0 ? -n : n);
        }
        row[12] = seat->speed * speeds.orbit[lane];
        row[13] = seat->speed * speeds.roll[lane] / seat->gamma();
        row[14] = seat->speed * speeds.pitch[lane] / seat->gamma();
        row[15] = speeds.centrifugal[lane];
        row[16] = speeds.orbit[lane];
      }
    }
  }

 private:
  // Each lane with its ball, or with the last one, which it repeats.
  template <class Function>
  void for_each_lane(Function function) {
    for (int slot = 0; slot < int(balls.size()) * LANES; slot++)
      function(balls[slot / LANES], slot % LANES, std::min(slot, count - 1), slot < count);
  }
};

// A single ring, or a shaft on several: the inner ring of a bearing at the axial position a, facing s, has in its own frame the
// coordinates (x + a theta_y, y - a theta_x, s z + middle, s theta_x, s theta_y); its loads transform by the transpose.
class System {
 public:
  std::vector<Ring> rings;
  std::vector<Vector5> ring_load;
  std::vector<Matrix5> ring_stiffness;
  Vector5 q{}, load{}, scales{};  // scales [1 or m] convert tilts to displacements
  Matrix5 stiffness{};
  double rounding = 0.0, longest = 0.0, imbalance = 0.0;

  void set(const Seat *seats, int count, const std::int64_t *balls) {
    double lever = 0.0, widest = 0.0, middle = 0.0, opening = 0.0;
    rings.resize(count), ring_load.resize(count), ring_stiffness.resize(count);
    for (int i = 0; i < count; i++) {
      const Seat &seat = seats[i];
      rings[i].set(seat, int(balls[i]));
      lever = std::max(lever, std::fabs(seat.position) + seat.arm), widest = std::max(widest, 2.0 * seat.ball_radius);
      middle = std::max(middle, std::fabs(seat.middle));
      opening = std::max(opening, seat.inner.locus_radius - seat.outer.locus_radius);
    }
    scales = {1.0, 1.0, 1.0, lever, lever};
    longest = MAX_DISPLACEMENT * widest + middle, rounding = ROUNDING * opening;
  }
  void place_balls(const double *azimuth, const double *heights = nullptr) {
    for (Ring &ring : rings) {
      ring.place_balls(azimuth, heights), azimuth += ring.count;
      if (heights) heights += 2 * ring.count;
    }
  }
  void write_positions(double *out) const {
    for (const Ring &ring : rings) ring.write_positions(out), out += 2 * ring.count;
  }
  void write_contacts(double *out) {
    for (std::size_t i = 0; i < rings.size(); i++) {
      rings[i].write_contacts(ring_coordinates(*rings[i].seat, q), out);
      out += CONTACT_NUMBERS * rings[i].count;
    }
  }

  // The coordinates of a seat's ring in its own frame.
  template <class X>
  static std::array<X, COORDINATES> ring_coordinates(const Seat &seat, const std::array<X, COORDINATES> &shaft_coordinates) {
    return {shaft_coordinates[0] + seat.position * shaft_coordinates[4],
            shaft_coordinates[1] - seat.position * shaft_coordinates[3], seat.facing * shaft_coordinates[2] + seat.middle,
            seat.facing * shaft_coordinates[3], seat.facing * shaft_coordinates[4]};
  }

  // Load and stiffness at these coordinates, and the scale of the loads.
  double loads_at(const Vector5 &shaft_coordinates) {
    load = {}, stiffness = {};
    double scale = 0.0;
    for (std::size_t i = 0; i < rings.size(); i++) {
      const Seat &seat = *rings[i].seat;
      scale += rings[i].loads_at(ring_coordinates(seat, shaft_coordinates), ring_load[i], ring_stiffness[i]);
      const double s = seat.facing, a = seat.position;
      const double turn[COORDINATES][COORDINATES] = {
          {1, 0, 0, 0, a}, {0, 1, 0, -a, 0}, {0, 0, s, 0, 0}, {0, 0, 0, s, 0}, {0, 0, 0, 0, s}};
      for (int r = 0; r < COORDINATES; r++)
        for (int m = 0; m < COORDINATES; m++) {
          load[m] += turn[r][m] * ring_load[i][r];
          for (int c = 0; c < COORDINATES && turn[r][m] != 0.0; c++)
            for (int n = 0; n < COORDINATES; n++) stiffness[m][n] += turn[r][m] * ring_stiffness[i][r][c] * turn[c][n];
        }
    }
    return scale;
  }

  // Solves for the free coordinates under the `requested` loads [N, N m] from their present values; `imbalance` [N] remains.
  Status solve_from_present(const FreeMask &free, const Vector5 &requested) {
    Vector5 residual{}, step{}, trial{};
    double scale = loads_at(q), greatest_load = 0.0;
    double size = residual_of(free, requested, residual);
    for (int i = 0; i < COORDINATES; i++)
      if (free[i]) greatest_load = std::max(greatest_load, std::fabs(requested[i]) / scales[i]);
    const double cap = 0.05 * longest;
    auto is_within = [&](double share) {
      return size <= std::max(share * std::max(greatest_load, 1e-3 * scale), rounding * stiffest());
    };
    for (int evaluations = 0; evaluations < MAX_RING_EVALUATIONS;) {
      if (is_within(RING_TOLERANCE)) {
        // a shaft leaves an unstable equilibrium in its motion
        if (rings.size() > 1 || !leave_unstable(free, requested, step)) break;
        for (int i = 0; i < COORDINATES; i++) q[i] += step[i];
        scale = loads_at(q);
        size = residual_of(free, requested, residual);
      }
      bool is_held = newton_step(residual, free, step);
      double length = greatest_displacement(step);
      if (work(step, residual) <= 0.0 || length == 0.0) {  // no stiffness: along the residual
        for (int i = 0; i < COORDINATES; i++) step[i] = residual[i] / (scales[i] * scales[i]) / size * cap;
        is_held = false, length = cap;
      }
      if (length > cap)
        for (double &component : step) component *= cap / length;
      const double first_work = work(step, residual), before = size;
      double factor = 1.0, low = 0.0, high = HUGE_VAL;
      for (int i = 0; i < MAX_TRIALS; i++) {
        evaluations++;
        for (int j = 0; j < COORDINATES; j++) trial[j] = q[j] + factor * step[j];
        if (greatest_displacement(trial) > longest) return imbalance = size, NOT_CONVERGED;
        scale = loads_at(trial);
        size = residual_of(free, requested, residual);
        double new_work = work(step, residual);
        if (size < 0.7 * before || std::fabs(new_work) <= 0.3 * first_work) break;
        if (new_work > 0.0) {
          low = factor;
          if (is_held) break;
        } else high = factor;
        factor = high == HUGE_VAL ? 2.0 * factor : 0.5 * (low + high);
      }
      q = trial;
      if (size >= before && is_within(ACCEPTED_RESIDUAL)) break;
    }
    imbalance = size;
    if (!is_within(ACCEPTED_RESIDUAL)) return NOT_CONVERGED;
    for (const Ring &ring : rings)
      if (!ring.balanced) return NOT_CONVERGED;
    bool carried = stiffness[0][0] != 0.0 || stiffness[2][2] != 0.0;
    for (double component : load) carried |= component != 0.0;
    return carried || std::find(free.begin(), free.end(), true) == free.end() ? CONVERGED : UNLOADED;
  }

  // The same from zero; where this fails, by continuation in loads and held coordinates.
  Status solve_in_parts(const FreeMask &free, const Vector5 &requested, const Vector5 &held_coordinates) {
    Status status = NOT_CONVERGED;
    for (int parts : {1, PARTS}) {
      q = {};
      for (int part = 1; part <= parts; part++) {
        Vector5 load;
        for (int i = 0; i < COORDINATES; i++) {
          load[i] = requested[i] * part / parts;
          if (!free[i]) q[i] = held_coordinates[i] * part / parts;
        }
        status = solve_from_present(free, load);
      }
      if (status != NOT_CONVERGED) break;
    }
    return status;
  }

 private:
  double residual_of(const FreeMask &free, const Vector5 &requested, Vector5 &residual) const {
    double size = 0.0;
    for (int i = 0; i < COORDINATES; i++) {
      residual[i] = free[i] ? requested[i] - load[i] : 0.0;
      size = std::max(size, std::fabs(residual[i]) / scales[i]);
    }
    return size;
  }
  // Work of the residual loads along a step: positive while a longer step lowers the energy.
  static double work(const Vector5 &step, const Vector5 &residual) {
    double total = 0.0;
    for (int i = 0; i < COORDINATES; i++) total += step[i] * residual[i];
    return total;
  }
  // The greatest coordinate as a displacement [m].
  double greatest_displacement(const Vector5 &coordinates) const {
    double greatest = 0.0;
    for (int i = 0; i < COORDINATES; i++) greatest = std::max(greatest, std::fabs(coordinates[i]) * scales[i]);
    return greatest;
  }
  // The greatest stiffness against a displacement [N/m].
  double stiffest() const {
    double greatest = 0.0;
    for (int i = 0; i < COORDINATES; i++) greatest = std::max(greatest, std::fabs(stiffness[i][i]) / (scales[i] * scales[i]));
    return greatest;
  }

  // Where the equilibrium is unstable, as that of a ring with clearance right over one ball, `step` is a small perturbation,
  // counter-clockwise from the load; false where it is stable.
  bool leave_unstable(const FreeMask &free, const Vector5 &requested, Vector5 &step) const {
    bool unstable = false;
    newton_step({}, free, step, &unstable);
    if (!unstable) return false;
    const double side = requested[0] * step[1] - requested[1] * step[0] < 0.0 ? -1.0 : 1.0;
    const double factor = side * PERTURBATION * longest / greatest_displacement(step);
    for (double &component : step) component *= factor;
    return true;
  }

  // The Newton step of the free coordinates by elimination; false where the ring has no stiffness in some direction. Rows and
  // columns are scaled, and pivots are the greatest diagonal entries, as the matrix is nearly symmetric. A soft pivot is
  // replaced, so that unsupported directions do not move. A negative one changes its sign, so that the step leaves an unstable
  // equilibrium; with `unstable` the step is along that direction alone.
  bool newton_step(const Vector5 &right, const FreeMask &free, Vector5 &step, bool *unstable = nullptr) const {
    int n = 0, index[COORDINATES];
    double a[COORDINATES][COORDINATES + 1], greatest = 0.0;
    step = {};
    for (int i = 0; i < COORDINATES; i++)
      if (free[i]) index[n++] = i;
    for (int i = 0; i < n; i++) {
      for (int j = 0; j < n; j++) a[i][j] = stiffness[index[i]][index[j]] / (scales[index[i]] * scales[index[j]]);
      a[i][n] = right[index[i]] / scales[index[i]];
      greatest = std::max(greatest, std::fabs(a[i][i]));
    }
    if (greatest == 0.0) return false;
    bool is_held = true;
    for (int i = 0; i < n; i++) {
      int best = i;
      for (int r = i + 1; r < n; r++)
        if (a[r][r] > a[best][best]) best = r;
      if (best != i) {
        std::swap(index[i], index[best]);
        std::swap(a[i], a[best]);
        for (int r = 0; r < n; r++) std::swap(a[r][i], a[r][best]);
      }
      const bool negative = a[i][i] < -NEGATIVE_PIVOT * greatest;
      if (a[i][i] < SOFT_PIVOT * greatest) is_held = false, a[i][i] = negative ? -a[i][i] : greatest;
      for (int r = i + 1; r < n; r++) {
        double factor = a[r][i] / a[i][i];
        for (int j = i; j <= n; j++) a[r][j] -= factor * a[i][j];
      }
      if (negative && unstable) *unstable = true, a[i][n] = a[i][i];
    }
    for (int i = n - 1; i >= 0; i--) {
      for (int j = i + 1; j < n; j++) a[i][n] -= a[i][j] * a[j][n];
      a[i][n] /= a[i][i];
      step[index[i]] = a[i][n] / scales[index[i]];
    }
    return is_held;
  }
};

}  // namespace core::equilibria
