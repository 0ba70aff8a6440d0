// A ring on its balls, or a shaft on two rings, in equilibrium: five coordinates (x, y, z, theta_x, theta_y), each held or
// free. A ball sees the coordinates as its `opening`; forces and moments come back through its derivatives. The free
// coordinates are found by Newton's method with the condensed stiffness of the balls, guarded by a bracketed search along
// the step for the place where the step does no more work (without speed the energy is nearly convex). A ring alone is
// in stable balance.
#pragma once
#include <algorithm>
#include <array>
#include <vector>
#include "raceway_contact.hpp"

namespace core::equilibria {

// One ball between two grooves in equilibrium (Jones 1960; Harris, Rolling Bearing Analysis), LANES balls side by side.
//
// Opening. The ring's centre lies at d = x cos(psi) + y sin(psi) outwards and s = y cos(psi) - x sin(psi) ahead of a ball
// at the azimuth psi, which meets it beside the middle: its groove, a circle round the ring's own axis, has gone back by
// s^2/(2 r) there, r = d_m/2. Of a tilt theta, b = theta_x sin(psi) - theta_y cos(psi) acts in the ball's plane and
// l = theta_x cos(psi) + theta_y sin(psi) across it. The inner groove's centre against the outer one's is, tilts being of
// first order,
//
//     A_r = A_0 + d - s^2/(2 r),   A_z = z + R b - s l.
//
// Balance. The meridian plane of the ball has axes (radial, axial); `place` is the ball's centre against the outer
// groove's. Both contacts pull the ball towards its groove's centre: Q_i along n_i = (opening - place)/|.|, and -Q_o along
// n_o = place/|.|. With t = (-n_z, n_r), and the gyroscopic moment M_g carried by friction in the shares lambda,
//
//     0 = Q_i n_i - Q_o n_o + F_c e_r + weight + (M_g / D) (lambda_i t_i - lambda_o t_o).
//
// Raceway control says what the shares (lambda_i, lambda_o) and the pitch beta of the ball's axis are: `outer` has (0, 2)
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
// place [m], the side it faces, and `middle` [m] along its own axis.
struct Seat {
  Groove inner, outer;
  double power, ball_radius, ball_mass, pitch_diameter, arm, lever, speed, share_inner, share_outer;
  double gravity[3], place, facing, middle;

  double gamma() const { return 2.0 * ball_radius / pitch_diameter; }
  double reach(const Groove &groove) const { return groove.groove_radius - ball_radius; }
};

constexpr double LEVEL = 0.5;  // cosine of an angle beyond which no contact is legal
constexpr double ACROSS = 0.8660254037844386;  // its sine
constexpr int MOST_LOOKS = 120, MOST_HALVINGS = 20, MOST_BISECTIONS = 40;
constexpr double NEAR = 1e-9;  // of the loads: what is left of a balance whose last step, which squares it, is not evaluated
constexpr double SMALLEST_STEP = 4e-17;  // of the groove's radius: a step below it changes nothing any more
constexpr double PROBE = 1e-6;  // m: approach at which a law's coefficient is read

// In the meridian plane.
template <class R, class Z = R>
struct Plane { R r; Z z; };
template <class R, class Z> Plane(R, Z) -> Plane<R, Z>;

CORE_INLINE Plane<Pack> select(const Mask &which, const Plane<Pack> &yes, const Plane<Pack> &no) {
  return {select(which, yes.r, no.r), select(which, yes.z, no.z)};
}

// One contact: approach [m], load [N] and direction.
template <class X>
struct Push { X approach, load, n_r, n_z; };
template <class X> Push(X, X, X, X) -> Push<X>;

// The contact where `v` [m] points from the ball's centre to the inner groove's, or from the outer one's to it.
template <class R, class Z>
CORE_INLINE auto push_of(const Seat &seat, const Groove &groove, const Plane<R, Z> &v, const Pack &height = Pack{}) {
  auto [distance, inverse] = root_and_inverse(v.r * v.r + v.z * v.z + 1e-300);
  auto n_r = v.r * inverse, n_z = v.z * inverse;
  auto approach = distance - seat.reach(groove) + height;
  auto load = elastic(along_groove(groove.coefficient, n_r), seat.power, approach).load;
  return Push{approach, load, n_r, n_z};
}

// Forces on a ball besides its contacts [N], and heights of the raceways under it [m].
struct Surroundings : Plane<Pack> { Pack inner{}, outer{}; };

// For `speeds_of`: cosine and sine of a contact angle a, beyond 60 degrees those of 120 - |a| degrees, at least 0.
template <class X>
CORE_INLINE auto turned_back(const Push<X> &push) {
  auto level = value_of(push.n_r) >= LEVEL, beyond = value_of(push.n_r) <= -LEVEL;
  auto size = absolute(push.n_z);
  auto cosine = select(level, push.n_r, select(beyond, 0.0 * size + 1.0, ACROSS * size - LEVEL * push.n_r));
  auto sign = select(value_of(push.n_z) >= 0.0, broadcast<ValueOf<X>>(1.0), broadcast<ValueOf<X>>(-1.0));
  auto sine = select(level, push.n_z, select(beyond, 0.0 * size, sign * (ACROSS * push.n_r + LEVEL * size)));
  return std::pair{cosine, sine};
}

// A ball that presses on the inner raceway with more than this share of its centrifugal load rolls on both.
constexpr double ROLLS = 0.25;  // tuned: below the share of 0.7 at which equilibria were compared with motion

// Centrifugal load F_c = m d_m omega_m^2 / 2 [N] and M_g / D [N], M_g = J omega_R omega_m sin(beta), J = m D^2/10; and over
// the ring's speed: the orbit's, and the roll's along the ball's axis times gamma, and times its pitch.
template <class X>
struct Speeds { X centrifugal, gyroscopic, orbit, roll, pitch; };

// The speeds of a ball that rolls on both raceways follow from both contact angles. A ball clear of the inner one has none
// there: it orbits and rolls as at angle zero, without a gyroscopic moment. In between speeds change with the load on the
// inner raceway, and beyond 60 degrees angles go back to those of level contacts: at a jump a ball finds no balance.
template <class I, class O>
CORE_INLINE auto speeds_of(const Seat &seat, const Push<I> &inner, const Push<O> &outer) {
  constexpr unsigned COLUMNS = columns_of<I> | columns_of<O>;
  const double gamma = seat.gamma(), square = seat.ball_mass * seat.pitch_diameter * seat.speed * seat.speed;
  const double level_orbit = 0.5 * (1.0 - gamma), level_roll = 0.5 * (1.0 - gamma * gamma);
  auto [c_o, s_o] = turned_back(outer);
  auto [c_i, s_i] = turned_back(inner);
  auto lean = widened<COLUMNS>(s_o / (c_o + gamma));
  if (seat.share_inner > seat.share_outer) lean = widened<COLUMNS>(s_i / (c_i - gamma));
  auto p_o = (c_o + lean * s_o) / (1.0 + gamma * c_o), p_i = (c_i + lean * s_i) / (1.0 - gamma * c_i);
  const double enough = ROLLS * 0.5 * square * level_orbit * level_orbit;
  auto part = minimum((1.0 / (enough + 1e-300)) * inner.load, 1.0);
  auto rolls = part * part * (3.0 - 2.0 * part);
  auto rolling = 1.0 / (p_o + p_i);
  auto orbit = level_orbit + rolls * (p_o * rolling - level_orbit), roll = level_roll + rolls * (rolling - level_roll);
  auto pitch = rolls * (lean * rolling);
  return Speeds<decltype(roll)>{0.5 * square * (orbit * orbit), 0.1 * square * (pitch * orbit), orbit, roll, pitch};
}

// Columns: the vector between the ball's centre and the inner groove's (radial, axial), and between the outer one's and it.
constexpr unsigned BY_PLACES = 0b1111;

// Residual of a ball's balance [N], and the share of the ring's load on this ball: `force` [N] and `moment` [N m] act
// on the ring from outside to hold it against the ball. `scale` [N] is that of its loads.
template <class X>
struct Balance { X left_r, left_z, force_r, force_z, moment; ValueOf<X> scale; };

template <class I, class O>
CORE_INLINE auto balance_of(const Seat &seat, const Push<I> &inner, const Push<O> &outer, const Surroundings &weight) {
  constexpr unsigned COLUMNS = columns_of<I> | columns_of<O>;
  auto none = widened<COLUMNS>(Pack{});
  auto centrifugal = none, gyroscopic = none;
  if (seat.speed != 0.0) {
    auto speeds = speeds_of(seat, inner, outer);
    centrifugal = speeds.centrifugal;
    gyroscopic = speeds.gyroscopic;
  }
  auto of_inner = seat.share_inner * gyroscopic, of_outer = seat.share_outer * gyroscopic;
  auto force_r = inner.load * inner.n_r - of_inner * inner.n_z, force_z = inner.load * inner.n_z + of_inner * inner.n_r;
  auto left_r = force_r - outer.load * outer.n_r + of_outer * outer.n_z + centrifugal + weight.r;
  auto left_z = force_z - outer.load * outer.n_z - of_outer * outer.n_r + weight.z;
  return Balance<decltype(left_r)>{left_r, left_z, force_r, force_z, -seat.lever * of_inner,
                                   value_of(inner.load) + value_of(outer.load) + value_of(centrifugal)};
}

using Number = Dual<BY_PLACES, Pack>;

inline Balance<Number> balance_at(const Seat &seat, const Plane<Pack> &opening, const Plane<Pack> &place,
                                  const Surroundings &weight) {
  Plane inner{variable<0>(Pack(opening.r - place.r)), variable<1>(Pack(opening.z - place.z))};
  Plane outer{variable<2>(place.r), variable<3>(place.z)};
  return balance_of(seat, push_of(seat, seat.inner, inner, weight.inner), push_of(seat, seat.outer, outer, weight.outer), weight);
}

// Derivatives by the ball's place, the opening kept, and by the opening, the place kept.
CORE_INLINE Plane<Pack> by_position(const Number &x) { return {x.slope[2] - x.slope[0], x.slope[3] - x.slope[1]}; }
CORE_INLINE Plane<Pack> by_opening(const Number &x) { return {x.slope[0], x.slope[1]}; }
CORE_INLINE Pack dot(const Plane<Pack> &a, const Plane<Pack> &b) { return a.r * b.r + a.z * b.z; }

// The 2 x 2 equations of what is left for a change of the place.
struct PlaceEquations {
  Plane<Pack> radial, axial;
  Pack determinant;
  explicit PlaceEquations(const Balance<Number> &here)
      : radial(by_position(here.left_r)), axial(by_position(here.left_z)), determinant(radial.r * axial.z - radial.z * axial.r) {}
  Mask singular() const {
    return ~(absolute(determinant) > 1e-14 * (absolute(radial.r * axial.z) + absolute(radial.z * axial.r)));
  }
  // The change that takes away these parts of what is left; 0 where the ball touches nothing.
  Plane<Pack> solved(const Pack &left_r, const Pack &left_z) const {
    Pack inverse = select(determinant == 0.0, Pack{}, 1.0 / determinant);
    return {(radial.z * left_z - axial.z * left_r) * inverse, (axial.r * left_r - radial.r * left_z) * inverse};
  }
};

struct Settled { Plane<Pack> place; Balance<Number> here; Mask done; };

CORE_INLINE Balance<Number> select(const Mask &which, const Balance<Number> &yes, const Balance<Number> &no) {
  return {select(which, yes.left_r, no.left_r), select(which, yes.left_z, no.left_z),
          select(which, yes.force_r, no.force_r), select(which, yes.force_z, no.force_z),
          select(which, yes.moment, no.moment), select(which, yes.scale, no.scale)};
}

// The balance from this place on by damped Newton steps, each ball's own.
inline Settled newton(const Seat &seat, const Plane<Pack> &opening, const Plane<Pack> &begin, const Surroundings &weight) {
  const double smallest = SMALLEST_STEP * seat.outer.groove_radius;
  Settled found{begin, {}, Mask{}};
  Plane<Pack> trial = begin;
  Pack size = broadcast<Pack>(HUGE_VAL), factor = broadcast<Pack>(1.0), failures{};
  Mask running = ~Mask{};
  for (int look = 0; look < MOST_LOOKS; look++) {
    Balance<Number> here = balance_at(seat, opening, trial, weight);
    Pack left = absolute(here.left_r.value) + absolute(here.left_z.value);
    // Clear of both raceways less may be left, but no step leads back.
    Mask better = running & (left < size) & ~(PlaceEquations(here).singular() & (left > NEAR * here.scale));
    found.here = look == 0 ? here : select(better, here, found.here);
    found.place = select(better, trial, found.place);
    size = select(better, left, size);
    failures = select(better, Pack{}, failures + 1.0);
    factor = select(better, broadcast<Pack>(1.0), 0.35 * factor);

    Balance<Number> &at = found.here;
    PlaceEquations equations(at);
    Plane<Pack> step = equations.solved(at.left_r.value, at.left_z.value);
    Mask enough = running & (size <= NEAR * at.scale), singular = equations.singular();
    Mask resting = running & ~singular & (absolute(step.r) + absolute(step.z) <= smallest);
    if (Mask last = enough & ~singular; any(last)) {
      found.place = select(last, {found.place.r + step.r, found.place.z + step.z}, found.place);
      for (Number *one : {&at.force_r, &at.force_z, &at.moment})
        one->value = select(last, one->value + dot(by_position(*one), step), one->value);
    }
    found.done |= enough | resting;
    running &= ~(enough | resting | singular | (failures >= double(MOST_HALVINGS)));
    if (!any(running)) break;
    trial = {found.place.r + factor * step.r, found.place.z + factor * step.z};
  }
  return found;
}

// The vector between the centres of a ball that rests on one raceway alone, pressed along by this force [N].
inline Plane<Pack> resting_on(const Seat &seat, const Groove &groove, const Plane<Pack> &along, const Pack &height) {
  Pack load = square_root(along.r * along.r + along.z * along.z + 1e-300);
  Plane<Pack> n{along.r / load, along.z / load};
  const double deep = seat.reach(groove) + PROBE;
  Pack coefficient = push_of(seat, groove, Plane<Pack>{n.r * deep, n.z * deep}).load / std::pow(PROBE, seat.power);
  Pack length = seat.reach(groove) - height + each_lane(load / coefficient, [&](double x) { return std::pow(x, 1.0 / seat.power); });
  return {n.r * length, n.z * length};
}

struct FirstPlace { Plane<Pack> place; Mask floats; };

// Where to begin a ball's balance, and whether nothing pushes it, so that any place is one. The energy of both contacts is
// convex in the place, so a ball that rests on one raceway clear of the other is there, but for its gyroscopic moment.
inline FirstPlace first_place(const Seat &seat, const Plane<Pack> &opening, const Surroundings &weight) {
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
  Plane<Pack> outside = resting_on(seat, seat.outer, force, weight.outer);
  Plane<Pack> dense_output = resting_on(seat, seat.inner, {-force.r, -force.z}, weight.inner);
  Plane<Pack> gap{opening.r - outside.r, opening.z - outside.z}, low{opening.r - dense_output.r, opening.z - dense_output.z};
  Mask clear_inner = dot(gap, gap) <= reach_i * reach_i;
  Mask clear_outer = dot(low, low) <= reach_o * reach_o;
  // Pressed against both, it is where circles about their centres meet, on the side to which the force points. It begins
  // with more load than it has in the end: from there Newton's method leaves no contact.
  Plane<Pack> most{absolute(force.r - weight.r) + absolute(weight.r) + absolute(weight.z), Pack{}};
  Pack r_o = resting_on(seat, seat.outer, most, weight.outer).r, r_i = resting_on(seat, seat.inner, most, weight.inner).r;
  Pack along = 0.5 * (distance + (r_o * r_o - r_i * r_i) / distance);
  Pack beside = square_root(maximum(r_o * r_o - along * along, 0.0) + 1e-300);
  beside = select(force.z * opening.r - force.r * opening.z < 0.0, -beside, beside);
  Plane<Pack> wedged{(along * opening.r - beside * opening.z) / distance, (along * opening.z + beside * opening.r) / distance};
  Plane<Pack> place = select(~loose | floats, between, select(clear_inner, outside, select(clear_outer, low, wedged)));
  return {place, floats};
}

// A ball's place by nested bisection: the radial balance falls with the radial place, what is left axially too. Both
// follow from the energy being convex; it holds as long as speeds change little with the angles.
inline Plane<Pack> bracketed(const Seat &seat, const Plane<Pack> &opening, const Surroundings &weight) {
  auto left_at = [&](const Plane<Pack> &place) {
    Plane<Pack> inner{opening.r - place.r, opening.z - place.z};
    return balance_of(seat, push_of(seat, seat.inner, inner, weight.inner), push_of(seat, seat.outer, place, weight.outer), weight);
  };
  Pack wide = square_root(opening.r * opening.r + opening.z * opening.z) + (seat.inner.groove_radius + seat.outer.groove_radius);
  Pack low_z = -wide, high_z = wide;
  Plane<Pack> place{};
  for (int i = 0; i < MOST_BISECTIONS; i++) {
    place.z = 0.5 * (low_z + high_z);
    Pack low_r = -wide, high_r = wide;
    for (int j = 0; j < MOST_BISECTIONS; j++) {
      place.r = 0.5 * (low_r + high_r);
      Mask below = left_at(place).left_r > 0.0;
      low_r = select(below, place.r, low_r), high_r = select(below, high_r, place.r);
    }
    Mask below = left_at(place).left_z > 0.0;
    low_z = select(below, place.z, low_z), high_z = select(below, high_z, place.z);
  }
  place.z = 0.5 * (low_z + high_z);
  return place;
}

// The balance of balls: Newton's method, where it fails from a place by nested bisection on.
inline Settled settled(const Seat &seat, const Plane<Pack> &opening, const Surroundings &weight) {
  const FirstPlace first = first_place(seat, opening, weight);
  Settled found = newton(seat, opening, first.place, weight);
  if (Mask lost = ~(found.done | first.floats); any(lost)) {
    Settled again = newton(seat, opening, bracketed(seat, opening, weight), weight);
    found = {select(lost, again.place, found.place), select(lost, again.here, found.here), found.done | again.done};
  }
  return found;
}

// The ring on its balls.

constexpr int COORDINATES = 5;
constexpr int CONTACT_NUMBERS = 17;  // of a ball: see `System::contacts`
constexpr int MOST_TRIALS = 40, MOST_RING_LOOKS = 300, PARTS = 12;
constexpr double RING_EXACT = 1e-11;  // of the loads: what is left of the ring's balance
constexpr double RING_LEFT = 1e-9;  // as above: more is no balance, and less is enough where no step improves any more
constexpr double ROUNDING = 4e-15;  // of the opening: what the place of a ball is known to
constexpr double SOFT = 1e-9;  // of the greatest stiffness: what is softer counts as not held
constexpr double NEGATIVE = 1e-12;  // as above: what is as far below zero is no rounding
constexpr double OFF = 1e-6;  // of the longest way: a ring's first step off an unstable balance
constexpr double LONGEST = 0.2;  // of the ball diameter: no coordinate goes further

using Five = std::array<double, COORDINATES>;
using Matrix5 = std::array<Five, COORDINATES>;
using FreeOnes = std::array<bool, COORDINATES>;

enum Status { FOUND, NOTHING_CARRIES, TOO_MUCH, STOPPED };

// LANES balls of one ring; `present` is 0 in lanes that only repeat the last ball.
struct Balls {
  Pack cosine, sine, present;
  Surroundings weight;
  Plane<Pack> place;
};

// The derivative of something by the five coordinates, given by the opening.
template <class R, class Z>
CORE_INLINE auto through_opening(const Pack &value, const Plane<Pack> &by, const R &radial, const Z &axial) {
  return dual<columns_of<R> | columns_of<Z>>(value, [&]<int C>() __attribute__((always_inline)) {
    return by.r * slope_of<C>(radial) + by.z * slope_of<C>(axial);
  });
}

// The inner groove's centre against the outer one's [m], and what its slopes are made of.
template <class R, class Z, class S, class L>
struct Opening { R radial; Z axial; S tangential, side; L across; };
template <class R, class Z, class S, class L> Opening(R, Z, S, S, L) -> Opening<R, Z, S, L>;

class Ring {
 public:
  const Seat *seat = nullptr;
  int count = 0;
  std::vector<Balls> balls;
  bool balanced = false;  // each ball, where loads were found last

  void set(const Seat &its_seat, int its_count) {
    seat = &its_seat, count = its_count;
    balls.resize((count + LANES - 1) / LANES);
  }
  // Puts the balls at these azimuths [rad].
  // `heights` (N, 2) [m] of the inner and the outer raceway under the balls; null: none.
  void place(const double *azimuth, const double *heights = nullptr) {
    each([&](Balls &b, int lane, int ball, bool present) {
      b.weight.inner[lane] = heights ? heights[2 * ball] : 0.0, b.weight.outer[lane] = heights ? heights[2 * ball + 1] : 0.0;
      b.cosine[lane] = std::cos(azimuth[ball]), b.sine[lane] = std::sin(azimuth[ball]), b.present[lane] = present;
    });
    const double *g = seat->gravity;
    for (Balls &b : balls)
      b.weight.r = seat->ball_mass * (g[0] * b.cosine + g[1] * b.sine), b.weight.z = broadcast<Pack>(seat->ball_mass * g[2]);
  }
  // Places (N, 2) [m] of the balls against the outer groove's centre: radial, axial.
  void write_places(double *out) const {
    for (int ball = 0; ball < count; ball++) {
      const Plane<Pack> &place = balls[ball / LANES].place;
      *out++ = place.r[ball % LANES], *out++ = place.z[ball % LANES];
    }
  }

  // The opening with its slopes by the five coordinates, or its values alone.
  template <bool DERIVATIVES>
  CORE_INLINE auto opening(const Balls &b, const Five &q) const {
    auto at = [&]<int C>(Index<C>) __attribute__((always_inline)) { return input<DERIVATIVES, C>(broadcast<Pack>(q[C])); };
    auto x = at(index<0>), y = at(index<1>), z = at(index<2>), tilt_x = at(index<3>), tilt_y = at(index<4>);
    auto outwards = b.cosine * x + b.sine * y, tangential = b.cosine * y - b.sine * x;
    auto along = b.sine * tilt_x - b.cosine * tilt_y, across = b.cosine * tilt_x + b.sine * tilt_y;
    auto side = (2.0 / seat->pitch_diameter) * tangential;
    auto radial = outwards + (seat->inner.locus_radius - seat->outer.locus_radius) - 0.5 * side * tangential;
    auto axial = z + seat->arm * along - tangential * across;
    return Opening{radial, axial, tangential, side, across};
  }
  CORE_INLINE Plane<Pack> opening_at(const Balls &b, const Five &q) const {
    auto found = opening<false>(b, q);
    return {found.radial, found.axial};
  }

  // External load (5,) [N, N m] that holds the ring at `q`, and its derivative; returns the scale of the loads [N].
  double loads_at(const Five &q, Five &load, Matrix5 &stiffness) {
    constexpr unsigned ALL = 0b11111;
    Dual<ALL, Pack> total[COORDINATES]{};
    Pack scale{};
    balanced = true;
    for (Balls &b : balls) {
      auto seen = opening<true>(b, q);
      Plane<Pack> opening{seen.radial.value, seen.axial.value};
      Settled found = settled(*seat, opening, b.weight);
      const Balance<Number> &here = found.here;
      balanced &= !any(~found.done);
      // d(place)/d(opening): what is left stays nothing
      PlaceEquations equations(here);
      Plane<Pack> by_r = equations.solved(here.left_r.slope[0], here.left_z.slope[0]);
      Plane<Pack> by_z = equations.solved(here.left_r.slope[1], here.left_z.slope[1]);
      b.place = found.place;
      auto condensed = [&](const Number &one) __attribute__((always_inline)) {
        Plane<Pack> place = by_position(one), own = by_opening(one);
        Plane<Pack> by{own.r + dot(place, by_r), own.z + dot(place, by_z)};
        return b.present * through_opening(one.value, by, seen.radial, seen.axial);
      };
      auto radial = condensed(here.force_r), axial = condensed(here.force_z), moment = condensed(here.moment);
      // virtual work: each load is the ball's force along the opening's slope by that coordinate
      auto add = [&](int i, const auto &more) __attribute__((always_inline)) { total[i] = total[i] + widened<ALL>(more); };
      add(0, radial * (b.cosine + seen.side * b.sine) + axial * (seen.across * b.sine));
      add(1, radial * (b.sine - seen.side * b.cosine) - axial * (seen.across * b.cosine));
      add(2, axial);
      add(3, axial * (seat->arm * b.sine - seen.tangential * b.cosine) + b.sine * moment);
      add(4, -(axial * (seat->arm * b.cosine + seen.tangential * b.sine)) - b.cosine * moment);
      scale += b.present * here.scale;
    }
    for (int i = 0; i < COORDINATES; i++) {
      load[i] = sum(total[i].value);
      for (int j = 0; j < COORDINATES; j++) stiffness[i][j] = sum(total[i].slope[j]);
    }
    return sum(scale);
  }

  // Of each ball at its place, the ring at `q`: approach, load, angle, friction, small and large curvature, each inner and
  // outer, then orbit, roll along the axis and pitch along the radius [rad/s], both against the orbit, centrifugal load,
  // and the orbit's speed over the ring's.
  void write_contacts(const Five &q, double *out) {
    for (Balls &b : balls) {
      Plane<Pack> opening = opening_at(b, q);
      auto inner = push_of(*seat, seat->inner, Plane<Pack>{opening.r - b.place.r, opening.z - b.place.z}, b.weight.inner);
      auto outer = push_of(*seat, seat->outer, b.place, b.weight.outer);
      auto speeds = speeds_of(*seat, inner, outer);
      for (int lane = 0; lane < LANES; lane++) {
        int ball = int(&b - balls.data()) * LANES + lane;
        if (ball >= count) break;
        double *row = out + CONTACT_NUMBERS * ball;
        for (int race = 0; race < 2; race++) {
          const Push<Pack> &push = race == 0 ? inner : outer;
          const Groove &groove = race == 0 ? seat->inner : seat->outer;
          double n = push.n_r[lane], share = race == 0 ? seat->share_inner : -seat->share_outer;
          row[0 + race] = push.approach[lane], row[2 + race] = push.load[lane];
          row[4 + race] = std::atan2(push.n_z[lane], n), row[6 + race] = share * speeds.gyroscopic[lane];
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
  static double sum(const Pack &lanes) {
    double total = 0.0;
    for (int lane = 0; lane < LANES; lane++) total += lanes[lane];
    return total;
  }
  // Each lane with the ball that it holds, or the last one, which it only repeats.
  template <class Function>
  void each(Function function) {
    for (int slot = 0; slot < int(balls.size()) * LANES; slot++)
      function(balls[slot / LANES], slot % LANES, std::min(slot, count - 1), slot < count);
  }
};

// One ring alone, or a shaft on several: the inner ring of a bearing at the place a, facing s, stands in its own frame at
// (x + a theta_y, y - a theta_x, s z + middle, s theta_x, s theta_y); its loads come back through the transpose.
class System {
 public:
  std::vector<Ring> rings;
  std::vector<Five> ring_load;
  std::vector<Matrix5> ring_stiffness;
  Five q{}, load{}, scales{};  // scales [1 or m] make displacements of tilts
  Matrix5 stiffness{};
  double rounding = 0.0, longest = 0.0, left = 0.0;

  void set(const Seat *seats, int count, const std::int64_t *balls) {
    double lever = 0.0, widest = 0.0, middle = 0.0, opening = 0.0;
    rings.resize(count), ring_load.resize(count), ring_stiffness.resize(count);
    for (int i = 0; i < count; i++) {
      const Seat &seat = seats[i];
      rings[i].set(seat, int(balls[i]));
      lever = std::max(lever, std::fabs(seat.place) + seat.arm), widest = std::max(widest, 2.0 * seat.ball_radius);
      middle = std::max(middle, std::fabs(seat.middle));
      opening = std::max(opening, seat.inner.locus_radius - seat.outer.locus_radius);
    }
    scales = {1.0, 1.0, 1.0, lever, lever};
    longest = LONGEST * widest + middle, rounding = ROUNDING * opening;
  }
  void place(const double *azimuth, const double *heights = nullptr) {
    for (Ring &ring : rings) {
      ring.place(azimuth, heights), azimuth += ring.count;
      if (heights) heights += 2 * ring.count;
    }
  }
  void write_places(double *out) const {
    for (const Ring &ring : rings) ring.write_places(out), out += 2 * ring.count;
  }
  void write_contacts(double *out) {
    for (std::size_t i = 0; i < rings.size(); i++) {
      rings[i].write_contacts(turned_in(*rings[i].seat, q), out);
      out += CONTACT_NUMBERS * rings[i].count;
    }
  }

  // The coordinates of a seat's ring in its own frame.
  template <class X>
  static std::array<X, COORDINATES> turned_in(const Seat &seat, const std::array<X, COORDINATES> &at) {
    return {at[0] + seat.place * at[4], at[1] - seat.place * at[3], seat.facing * at[2] + seat.middle, seat.facing * at[3],
            seat.facing * at[4]};
  }

  // Load and stiffness at these coordinates, and the scale of the loads.
  double loads_at(const Five &at) {
    load = {}, stiffness = {};
    double scale = 0.0;
    for (std::size_t i = 0; i < rings.size(); i++) {
      const Seat &seat = *rings[i].seat;
      scale += rings[i].loads_at(turned_in(seat, at), ring_load[i], ring_stiffness[i]);
      const double s = seat.facing, a = seat.place;
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

  // Moves the free coordinates to where `wanted` [N, N m] loads them, from where they are; `left` [N] is missing then.
  Status balance(const FreeOnes &free, const Five &wanted) {
    Five missing{}, step{}, trial{};
    double scale = loads_at(q), greatest_load = 0.0;
    double size = missing_of(free, wanted, missing);
    for (int i = 0; i < COORDINATES; i++)
      if (free[i]) greatest_load = std::max(greatest_load, std::fabs(wanted[i]) / scales[i]);
    const double cap = 0.05 * longest;
    auto within = [&](double share) {
      return size <= std::max(share * std::max(greatest_load, 1e-3 * scale), rounding * stiffest());
    };
    for (int looks = 0; looks < MOST_RING_LOOKS;) {
      if (within(RING_EXACT)) {
        // a shaft in an unstable balance leaves it in its run
        if (rings.size() > 1 || !leaves_unstable(free, wanted, step)) break;
        for (int i = 0; i < COORDINATES; i++) q[i] += step[i];
        scale = loads_at(q);
        size = missing_of(free, wanted, missing);
      }
      bool held = solve(missing, free, step);
      double length = size_of(step);
      if (work(step, missing) <= 0.0 || length == 0.0) {  // nothing resists: along what is missing
        for (int i = 0; i < COORDINATES; i++) step[i] = missing[i] / (scales[i] * scales[i]) / size * cap;
        held = false, length = cap;
      }
      if (length > cap)
        for (double &one : step) one *= cap / length;
      const double begin = work(step, missing), before = size;
      double factor = 1.0, low = 0.0, high = HUGE_VAL;
      for (int i = 0; i < MOST_TRIALS; i++) {
        looks++;
        for (int j = 0; j < COORDINATES; j++) trial[j] = q[j] + factor * step[j];
        if (size_of(trial) > longest) return left = size, TOO_MUCH;
        scale = loads_at(trial);
        size = missing_of(free, wanted, missing);
        double done = work(step, missing);
        if (size < 0.7 * before || std::fabs(done) <= 0.3 * begin) break;
        if (done > 0.0) {
          low = factor;
          if (held) break;
        } else high = factor;
        factor = high == HUGE_VAL ? 2.0 * factor : 0.5 * (low + high);
      }
      q = trial;
      if (size >= before && within(RING_LEFT)) break;
    }
    left = size;
    if (!within(RING_LEFT)) return TOO_MUCH;
    for (const Ring &ring : rings)
      if (!ring.balanced) return TOO_MUCH;
    bool carried = stiffness[0][0] != 0.0 || stiffness[2][2] != 0.0;
    for (double one : load) carried |= one != 0.0;
    return carried || std::find(free.begin(), free.end(), true) == free.end() ? FOUND : NOTHING_CARRIES;
  }

  // As `balance`, from nothing; where that leads nowhere, each part of loads and held coordinates from the one before on.
  Status settle(const FreeOnes &free, const Five &wanted, const Five &held) {
    Status status = TOO_MUCH;
    for (int parts : {1, PARTS}) {
      q = {};
      for (int part = 1; part <= parts; part++) {
        Five load;
        for (int i = 0; i < COORDINATES; i++) {
          load[i] = wanted[i] * part / parts;
          if (!free[i]) q[i] = held[i] * part / parts;
        }
        status = balance(free, load);
      }
      if (status != TOO_MUCH) break;
    }
    return status;
  }

 private:
  double missing_of(const FreeOnes &free, const Five &wanted, Five &missing) const {
    double size = 0.0;
    for (int i = 0; i < COORDINATES; i++) {
      missing[i] = free[i] ? wanted[i] - load[i] : 0.0;
      size = std::max(size, std::fabs(missing[i]) / scales[i]);
    }
    return size;
  }
  // Work of the missing loads along a step: positive while going on lowers the energy.
  static double work(const Five &step, const Five &missing) {
    double total = 0.0;
    for (int i = 0; i < COORDINATES; i++) total += step[i] * missing[i];
    return total;
  }
  // The greatest coordinate as a displacement [m].
  double size_of(const Five &at) const {
    double greatest = 0.0;
    for (int i = 0; i < COORDINATES; i++) greatest = std::max(greatest, std::fabs(at[i]) * scales[i]);
    return greatest;
  }
  // The greatest stiffness against a displacement [N/m].
  double stiffest() const {
    double greatest = 0.0;
    for (int i = 0; i < COORDINATES; i++) greatest = std::max(greatest, std::fabs(stiffness[i][i]) / (scales[i] * scales[i]));
    return greatest;
  }

  // Where the balance is unstable, as that of a ring with clearance right over one ball, `step` leads a little way off, of
  // both sides counter-clockwise from the load; false where it is stable.
  bool leaves_unstable(const FreeOnes &free, const Five &wanted, Five &step) const {
    bool unstable = false;
    solve({}, free, step, &unstable);
    if (!unstable) return false;
    const double side = wanted[0] * step[1] - wanted[1] * step[0] < 0.0 ? -1.0 : 1.0;
    const double factor = side * OFF * longest / size_of(step);
    for (double &one : step) one *= factor;
    return true;
  }

  // The Newton step of the free coordinates by elimination; false where something does not hold the ring. Rows and columns
  // are scaled and taken by the greatest pivot on the diagonal, as the matrix is nearly symmetric. A soft pivot is lifted:
  // what nothing holds stays where it is. A negative one changes its sign, so that the step leads off an unstable balance;
  // with `unstable` the step is then along that direction alone.
  bool solve(const Five &right, const FreeOnes &free, Five &step, bool *unstable = nullptr) const {
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
    bool held = true;
    for (int i = 0; i < n; i++) {
      int best = i;
      for (int r = i + 1; r < n; r++)
        if (a[r][r] > a[best][best]) best = r;
      if (best != i) {
        std::swap(index[i], index[best]);
        std::swap(a[i], a[best]);
        for (int r = 0; r < n; r++) std::swap(a[r][i], a[r][best]);
      }
      const bool negative = a[i][i] < -NEGATIVE * greatest;
      if (a[i][i] < SOFT * greatest) held = false, a[i][i] = negative ? -a[i][i] : greatest;
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
    return held;
  }

};

}  // namespace core::equilibria
