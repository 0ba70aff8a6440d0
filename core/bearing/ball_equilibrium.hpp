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
#pragma once
#include "ball_raceway.hpp"

namespace core::equilibria {

using core::select;

struct Groove {
  double locus_radius, groove_radius;
  GroovePolynomial coefficient;
};

// The numbers of the balance (SI): doubles alone, in the order in which Python writes them (`Setting.numbers`). `arm` [m]
// turns a tilt into axial displacement and an axial force into a moment; `lever` [m] is the arm of the friction that
// carries the gyroscopic moment, about the point at the end of `arm`. A ball's last step may leave `unseen` of the loads,
// for which stiffness is to the root of that; 0 where it is to be exact. The last three are those of a ring on a shaft:
// its place [m], the side it faces, and `middle` [m] along its own axis.
struct Seat {
  Groove inner, outer;
  double power, ball_radius, ball_mass, pitch_diameter, arm, lever, speed, share_inner, share_outer, unseen;
  double gravity[3], place, facing, middle;

  double gamma() const { return 2.0 * ball_radius / pitch_diameter; }
  double reach(const Groove &groove) const { return groove.groove_radius - ball_radius; }
};

constexpr double LEVEL = 0.5;  // cosine of an angle beyond which no contact is legal
constexpr double ACROSS = 0.8660254037844386;  // its sine
constexpr int MOST_LOOKS = 120, MOST_HALVINGS = 6, MOST_BISECTIONS = 40;
constexpr double EXACT = 1e-12;  // of the loads: what is left of a ball's balance
// Of the loads: what is left of a balance whose last step is taken without another evaluation, and which counts as found
// where rounding lets no step improve any more.
constexpr double NEAR = 1e-9;
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

// What acts on a ball besides its contacts [N], and heights of the raceways under it [m].
struct Surroundings : Plane<Pack> { Pack inner{}, outer{}; };

// Cosine and sine of a contact angle a, beyond 60 degrees those of 120 - |a| degrees, at least 0.
template <class X>
CORE_INLINE auto turned_back(const Push<X> &push) {
  auto level = value_of(push.n_r) >= LEVEL, beyond = value_of(push.n_r) <= -LEVEL;
  auto size = absolute(push.n_z);
  auto cosine = select(level, push.n_r, select(beyond, 0.0 * size + 1.0, ACROSS * size - LEVEL * push.n_r));
  auto sign = select(value_of(push.n_z) >= 0.0, broadcast<ValueOf<X>>(1.0), broadcast<ValueOf<X>>(-1.0));
  auto sine = select(level, push.n_z, select(beyond, 0.0 * size, sign * (ACROSS * push.n_r + LEVEL * size)));
  return std::pair{cosine, sine};
}

// Centrifugal load F_c = m d_m omega_m^2 / 2 [N] and M_g / D [N], M_g = J omega_R omega_m sin(beta), J = m D^2/10; and over
// the ring's speed: the orbit's, and the roll's along the ball's axis times gamma, and times its pitch.
template <class X>
struct Speeds { X centrifugal, gyroscopic, orbit, roll, pitch; };

// Beyond 60 degrees, where only a ball that carries next to nothing has its centre, they go back to those of level
// contacts, without a jump, at which a ball would find no balance.
template <class I, class O>
CORE_INLINE auto speeds_of(const Seat &seat, const Push<I> &inner, const Push<O> &outer) {
  constexpr unsigned COLUMNS = columns_of<I> | columns_of<O>;
  const double gamma = seat.gamma(), square = seat.ball_mass * seat.pitch_diameter * seat.speed * seat.speed;
  auto [c_o, s_o] = turned_back(outer);
  auto [c_i, s_i] = turned_back(inner);
  auto lean = widened<COLUMNS>(s_o / (c_o + gamma));
  if (seat.share_inner > seat.share_outer) lean = widened<COLUMNS>(s_i / (c_i - gamma));
  auto p_o = (c_o + lean * s_o) / (1.0 + gamma * c_o), p_i = (c_i + lean * s_i) / (1.0 - gamma * c_i);
  auto roll = 1.0 / (p_o + p_i);
  auto orbit = p_o * roll, pitch = lean * roll;
  return Speeds<decltype(roll)>{0.5 * square * (orbit * orbit), 0.1 * square * (pitch * orbit), orbit, roll, pitch};
}

// Columns: the vector between the ball's centre and the inner groove's (radial, axial), and between the outer one's and it.
constexpr unsigned BY_INNER = 0b0011, BY_OUTER = 0b1100, BY_PLACES = 0b1111;

// What is left of a ball's balance [N], and what the ring must bring up for this ball: `force` [N] and `moment` [N m] act
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
    gyroscopic = select(value_of(inner.load) > 0.0, speeds.gyroscopic, none);
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
CORE_INLINE Plane<Pack> by_place(const Number &x) { return {x.slope[2] - x.slope[0], x.slope[3] - x.slope[1]}; }
CORE_INLINE Plane<Pack> by_opening(const Number &x) { return {x.slope[0], x.slope[1]}; }
CORE_INLINE Pack dot(const Plane<Pack> &a, const Plane<Pack> &b) { return a.r * b.r + a.z * b.z; }

// The 2 x 2 equations of what is left for a change of the place.
struct PlaceEquations {
  Plane<Pack> radial, axial;
  Pack determinant;
  explicit PlaceEquations(const Balance<Number> &here)
      : radial(by_place(here.left_r)), axial(by_place(here.left_z)), determinant(radial.r * axial.z - radial.z * axial.r) {}
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
    Mask better = running & (left < size);
    found.here = look == 0 ? here : select(better, here, found.here);
    found.place = select(better, trial, found.place);
    size = select(better, left, size);
    failures = select(better, Pack{}, failures + 1.0);
    factor = select(better, broadcast<Pack>(1.0), 0.35 * factor);

    Balance<Number> &at = found.here;
    PlaceEquations equations(at);
    Plane<Pack> step = equations.solved(at.left_r.value, at.left_z.value);
    Pack carried = absolute(at.force_r.value) + absolute(at.force_z.value);
    Mask exact = size <= EXACT * at.scale, enough = size <= NEAR * at.scale;
    Mask movable = running & ~exact & ~equations.singular();
    Mask resting = movable & (absolute(step.r) + absolute(step.z) <= smallest);
    // A step leaves about what was off, squared, over a contact's load, and the ring bears no more than that load.
    Mask last = movable & ~resting & (enough | (size * size <= seat.unseen * at.scale * carried));
    Mask stuck = running & ~exact & ~resting & ~last & (~movable | (failures >= double(MOST_HALVINGS)));
    if (any(last)) {
      found.place = select(last, {found.place.r + step.r, found.place.z + step.z}, found.place);
      for (Number *one : {&at.force_r, &at.force_z, &at.moment})
        one->value = select(last, one->value + dot(by_place(*one), step), one->value);
    }
    found.done |= (running & exact) | resting | last | (stuck & enough);
    running &= ~(exact | resting | last | stuck);
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

struct FirstPlace { Plane<Pack> place; Mask alone; };

// Where to begin a ball's balance, and whether that is the answer already (at most one raceway carries). The energy of
// both contacts is convex in the place, so a ball that rests on one raceway clear of the other is there.
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
  Plane<Pack> inside = resting_on(seat, seat.inner, {-force.r, -force.z}, weight.inner);
  Plane<Pack> gap{opening.r - outside.r, opening.z - outside.z}, low{opening.r - inside.r, opening.z - inside.z};
  Mask clear_inner = dot(gap, gap) <= reach_i * reach_i;
  Mask clear_outer = dot(low, low) <= reach_o * reach_o;
  Plane<Pack> place = select(~loose | floats, between, select(clear_inner | ~clear_outer, outside, low));
  return {place, floats | (loose & (clear_inner | clear_outer))};
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

// The balance of balls, begun at a place, NaN for a cold start: Newton's method, then nested bisection.
inline Settled settled(const Seat &seat, const Plane<Pack> &opening, Plane<Pack> begin, const Surroundings &weight) {
  Mask cold = begin.r != begin.r;
  FirstPlace first{};
  if (any(cold)) {
    first = first_place(seat, opening, weight);
    begin = select(cold, first.place, begin);
  }
  Settled found = newton(seat, opening, begin, weight);
  auto begin_again = [&](const Plane<Pack> &place, const Mask &lost) {
    Settled again = newton(seat, opening, place, weight);
    found = {select(lost, again.place, found.place), select(lost, again.here, found.here), found.done | again.done};
  };
  if (Mask lost = ~(found.done | cold); any(lost)) {
    first = first_place(seat, opening, weight);
    begin_again(first.place, lost);
  }
  if (Mask lost = ~(found.done | first.alone); any(lost)) begin_again(bracketed(seat, opening, weight), lost);
  return found;
}

}  // namespace core::equilibria
