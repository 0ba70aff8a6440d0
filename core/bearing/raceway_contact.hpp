// Parameters of the equations of motion of a bearing, and the contact of a ball with a raceway.
#pragma once
#include "../contact/friction.hpp"
#include "../contact/laws.hpp"
#include "../math/linear.hpp"
#include "../shapes/gaps.hpp"
#include "surface_heights.hpp"

namespace core {

// Parameters of the equations of motion of a bearing, in SI units.
//
// Frames. `bearing_link` has its origin at the outer ring's centre and z along the axis. The motion of each ball is
// written in the frame that turns with that ball about the axis, with unit vectors (radial, tangential, axial).

constexpr int POLYNOMIAL_TERMS = 10;
// A polynomial in |n| - 1, n the radial part of a contact's normal, and the least |n| - 1 at which it is evaluated.
struct GroovePolynomial {
  double term[POLYNOMIAL_TERMS], least;
};

// A toroidal groove: the radius of its centre circle and of its meridian [m], the coefficient c [N/m^power] of the
// elastic law c h^power of its contacts, their effective modulus [Pa], and the semi-axes of their ellipse over the root of the
// approach [m^0.5].
struct Raceway {
  double locus_radius, groove_radius, nominal_coefficient, modulus;
  GroovePolynomial coefficient, semi_major, semi_minor;
  double film[FILM_NUMBERS][3];  // the numbers of a film, as polynomials of degree 2 in |n| - 1
};

struct Bearing {
  double ball_radius, ball_mass, ball_inertia;
  double offset[3], tilt[2], gravity[3];  // of the inner ring's centre [m]; its tilt about x and y [rad]; [m/s^2]
  double damping, relaxation_time;  // Hunt and Crossley's [s/m]; of the viscous part in proportion to the stiffness [s]
  double friction_coefficient, regularisation;  // at a point; v_s [m/s]
  double power;  // of the elastic law: 1.5 (Hertz) or 1 (linear spring)
  double pair_coefficient, pair_friction;  // of two balls: c [N/m^1.5] and the coefficient of friction at a point
  Raceway inner, outer;
  PatchFriction patch;
  CarriedLaw carried;
  Lubricant lubricant;
  SurfaceDefects defects;
  bool carries() const { return carried != CarriedLaw::none || lubricant.works(); }  // anything within or between steps
  bool tilted() const { return tilt[0] != 0.0 || tilt[1] != 0.0; }
  // Curvatures of a contact's gap [1/m], across the groove, and along it where its normal has this radial part.
  double curvature_across(const Raceway &raceway) const { return curvature_across_groove(ball_radius, raceway.groove_radius); }
  template <class N>
  CORE_INLINE auto curvature_along(const Raceway &raceway, const N &radial) const {
    return curvature_along_groove(ball_radius, raceway.locus_radius, raceway.groove_radius, radial);
  }
  bool over_patch() const { return patch.model != FrictionModel::point; }
};

// Prescribed rotation of the inner ring: at time t [s] it has speed + acceleration t [rad/s], and from `angle` [rad] on.
struct Drive {
  double angle, speed, acceleration;
  double angle_at(double time) const { return angle + time * (speed + 0.5 * acceleration * time); }
  template <class T>
  CORE_INLINE T speed_at(const T &time) const {
    return speed + acceleration * time;
  }
};

// A ball's state: position (axis distance, orbit angle, height), velocity and angular velocity (radial, tangential,
// axial), and the integrals of the drive's power, of the losses, and of the size of the drive's power.
enum Column { RADIUS, ANGLE, HEIGHT, VELOCITY, SPIN = 6, DRIVE_WORK = 9, DISSIPATED, GROSS_WORK, COLUMNS };
constexpr int MOTION = DRIVE_WORK;
using BallState = std::array<Pack, COLUMNS>;

// A film at the start of a step: 1 over load and rolling speed, its resistance [N] and coefficient of friction, and their
// exponents e of load and speed, as 1 + e and 1 - e. It is set where the rates are differentiated.
struct FilmStart {
  bool is_set = false;
  Pack over_load{}, over_speed{}, value[2]{}, load[2][2]{}, speed[2][2]{};
};
// States of a law at the contacts of balls in lanes with a raceway, and their films; then with both.
struct CarriedContacts {
  CarriedContact contact[LANES];
  mutable FilmStart film;
};
struct CarriedBalls {
  CarriedContacts inner, outer;
  void forget_films() const { inner.film.is_set = outer.film.is_set = false; }
};

template <Number X>
CORE_INLINE auto along_groove(const GroovePolynomial &polynomial, const X &radial) {
  return chained(
      [&](auto n) __attribute__((always_inline)) {
        const double *t = polynomial.term;
        auto x = maximum(absolute(n) - 1.0, polynomial.least);
        auto x2 = x * x, x4 = x2 * x2;
        auto low = (t[0] + t[1] * x) + (t[2] + t[3] * x) * x2;
        auto high = (t[4] + t[5] * x) + (t[6] + t[7] * x) * x2;
        return low + (high + (t[8] + t[9] * x) * x4) * x4;
      },
      radial);
}

// The contact of a ball with a raceway (paper 1, section 5), written once over the type of its numbers: geometry, velocities,
// forces. `normal` points from the ball's centre to the raceway, so the load on the ball is -normal_load * normal;
// `slip` is the velocity of the ball's surface relative to the raceway. All vectors are in the ball's frame, forces act
// on the ball, half the approach inside its surface. A gap gives zero loads.

// A ring whose tilt is taken to first order: a point at p of it goes to p + theta x p.

// The axes of a tilted ring, as rows in the frame in which its tilt is x, y: the inverse of 1 + tilt x.
template <class X, class Y, class Z>
struct RingAxes {
  X x;
  Y y;
  Z z;
};
template <class X, class Y, class Z>
RingAxes(X, Y, Z) -> RingAxes<X, Y, Z>;
template <class X, class Y>
CORE_INLINE auto ring_axes(const X &x, const Y &y) {
  auto xx = x * x, yy = y * y;
  auto share = 1.0 / (1.0 + (xx + yy));
  auto xy = share * (x * y), sx = share * x, sy = share * y;
  return RingAxes{Vector3{share * (1.0 + xx), xy, -sy}, Vector3{xy, share * (1.0 + yy), sx}, Vector3{sy, -sx, share}};
}
template <class A, class V>
CORE_INLINE auto into_ring(const A &axes, const V &v) {
  return Vector3{dot(axes.x, v), dot(axes.y, v), dot(axes.z, v)};
}
template <class A, class V>
CORE_INLINE auto out_of_ring(const A &axes, const V &v) {
  return (v.x * axes.x + v.y * axes.y) + v.z * axes.z;
}

struct NoHeight {
  Zero value, rate;
};

// A number that is 0 without surface heights, whose slopes seldom matter.
template <class Function>
CORE_INLINE auto if_heights_move(const Pack &rate, Function function) {
  decltype(function()) result{};
  if (any(rate != 0.0)) result = function();
  return result;
}

// Geometry in the meridian plane of the ring through the ball's centre, and the elastic load.
template <class O, class N, class Q, class A, class D, class R, class T, class W, class L, class S, class H>
struct ContactGeometry {
  O offset;  // of the ball's centre from the ring's [m]
  N normal;
  Q radial;  // the normal's part in the plane of the ring
  A approach;  // [m]; above zero in contact
  D axis_distance;  // of the ball's centre from the ring's axis [m]
  R arm;  // from the ball's centre to the contact point [m]
  T surface_velocity;  // of the raceway at the contact point [m/s]
  W ring_speed;  // about the axis [rad/s]
  L load;  // elastic [N]
  S stiffness;  // [N/m]
  H height_rate;  // part of the approach rate by surface heights [m/s]
};
template <class O, class N, class Q, class A, class D, class R, class T, class W, class L, class S, class H>
ContactGeometry(O, N, Q, A, D, R, T, W, L, S, H) -> ContactGeometry<O, N, Q, A, D, R, T, W, L, S, H>;

// The coefficient of a carried law and its derivative by the radial part of the normal, from its states (LANES,).
[[gnu::noinline]] inline std::pair<Pack, Pack> carried_coefficient(const Bearing &bearing, const Raceway &raceway,
                                                                   const Pack &radial, const CarriedContact *carried) {
  Pack value{}, slope{};
  for (int lane = 0; lane < LANES; lane++) {
    double inverse = 1.0 / (raceway.locus_radius + raceway.groove_radius * radial[lane]);
    double small = bearing.curvature_across(raceway), large = bearing.curvature_along(raceway, double(radial[lane]));
    auto [coefficient, by_large] = coefficient_and_slope(carried[lane], small, large, raceway.modulus);
    value[lane] = coefficient, slope[lane] = by_large * -0.5 * raceway.locus_radius * inverse * inverse;
  }
  return {value, slope};
}
template <Number N>
CORE_INLINE auto coefficient_at(const Bearing &bearing, const Raceway &raceway, const N &radial, const CarriedContact *carried) {
  if constexpr (std::is_same_v<ValueOf<N>, Pack>)
    if (carried && bearing.carried != CarriedLaw::none) {
      std::pair<Pack, Pack> law = carried_coefficient(bearing, raceway, value_of(radial), carried);
      return with_slope(radial, law.first, [&] { return law.second; });
    }
  return along_groove(raceway.coefficient, radial);
}

template <class O, class W, class H = NoHeight>
CORE_INLINE auto contact_geometry(const Bearing &bearing, const Raceway &raceway, const O &offset, const W &ring_speed,
                                  const CarriedContact *carried = nullptr, const H &height = {}) {
  auto [axis_distance, over_distance] = [&] {
    if constexpr (IsZero<decltype(offset.y)>) return std::pair{offset.x, 1.0 / offset.x};
    else return root_and_inverse(offset.x * offset.x + offset.y * offset.y);
  }();
  auto outwards = axis_distance - raceway.locus_radius;
  auto [distance, inverse] = root_and_inverse(outwards * outwards + offset.z * offset.z + 1e-300);
  auto radial = outwards * inverse;
  auto in_plane = radial * over_distance;
  Vector3 normal{in_plane * offset.x, in_plane * offset.y, offset.z * inverse};
  auto approach = distance + (bearing.ball_radius - raceway.groove_radius) + height.value;
  auto arm = (bearing.ball_radius - 0.5 * approach) * normal;
  auto point = offset + arm;
  Vector3 surface_velocity{-(ring_speed * point.y), ring_speed * point.x, Zero{}};

  auto coefficient = coefficient_at(bearing, raceway, radial, carried);
  auto spring = elastic(coefficient, bearing.power, approach);
  return ContactGeometry{offset,           normal,     radial,      approach,         axis_distance, arm,
                         surface_velocity, ring_speed, spring.load, spring.stiffness, height.rate};
}

// Action of a contact on the ball: force [N], torque about the ball's centre [N m], power lost [W]; normal load [N], slip [m/s],
// friction force [N], and the friction moment about the normal [N m], zero for friction at a point.
template <class F, class T, class L, class N, class S, class R, class D>
struct ContactAction {
  F force;
  T torque;
  L loss;
  N normal_load;
  S slip;
  R friction;
  D spin_moment;
};
template <class F, class T, class L, class N, class S, class R, class D>
ContactAction(F, T, L, N, S, R, D) -> ContactAction<F, T, L, N, S, R, D>;

// Action for `relative`, the velocity of the ball's surface relative to the raceway at the contact point, the relative spin about
// the normal, and a coefficient of friction.
template <bool PATCH, class P, class U, class W>
CORE_INLINE auto contact_action(const Bearing &bearing, const Raceway &raceway, const P &geometry, const U &relative, const W &spin,
                                const Pack &coefficient) {
  auto approach_rate = dot(relative, geometry.normal);
  auto slip = relative - approach_rate * geometry.normal;
  auto closing = approach_rate + geometry.height_rate;
  auto normal_load =
      maximum(proportional_load(geometry.load, geometry.stiffness, closing, bearing.damping, bearing.relaxation_time), 0.0);
  auto damping_loss = (normal_load - geometry.load) * closing;
  if constexpr (!PATCH) {
    auto square = dot(slip, slip);
    auto resistance = point_resistance(coefficient * normal_load, square, bearing.regularisation);
    auto friction = (-resistance) * slip;
    auto force = friction - normal_load * geometry.normal;
    return ContactAction{force, cross(geometry.arm, friction), resistance * square + damping_loss, normal_load, slip, friction,
                         Zero{}};
  } else {
    // The patch's axes: major across the groove, minor (x, y, 0) along the ring's circumference.
    auto inverse = 1.0 / geometry.axis_distance;
    auto x = -(inverse * geometry.offset.y);
    auto y = inverse * geometry.offset.x;
    auto root = root_of_depth(maximum(geometry.approach, LEAST_DEPTH));
    auto major = root * along_groove(raceway.semi_major, geometry.radial);
    auto minor = root * along_groove(raceway.semi_minor, geometry.radial);
    auto slip_major = geometry.normal.z * (y * slip.x - x * slip.y) - geometry.radial * slip.z;
    auto slip_minor = x * slip.x + y * slip.y;
    auto means = patch_means(bearing.patch, bearing.regularisation, major, minor, slip_major, slip_minor, spin);
    auto in_ball_frame = [&](const auto &along_major, const auto &along_minor, const auto &along_normal) {
      auto outwards = along_major * geometry.normal.z + along_normal * geometry.radial;
      return Vector3{outwards * y + along_minor * x, along_minor * y - outwards * x,
                     along_normal * geometry.normal.z - along_major * geometry.radial};
    };
    auto limit = coefficient * normal_load, lever = bearing.ball_radius - 0.5 * geometry.approach;
    auto along = limit * means.along, across = limit * means.across, moment = limit * means.moment;
    auto friction = in_ball_frame(-along, -across, Zero{});
    auto force = friction - normal_load * geometry.normal;
    auto torque = in_ball_frame(lever * across, -(lever * along), -moment);
    auto loss = along * slip_major + across * slip_minor + moment * spin + damping_loss;
    return ContactAction{force, torque, loss, normal_load, slip, friction, -moment};
  }
}

// Power of surface heights on a contact [W]; its slopes preserve the order of the method.
template <class F, class N>
CORE_INLINE auto height_power(const F &force, const N &normal, const Pack &rate) {
  return if_heights_move(rate, [&]() __attribute__((always_inline)) { return -rate * dot(force, normal); });
}

// The lubricant's film in the contact of a ball with a raceway: rolling resistance by film, hysteresis and differential slip, and
// the coefficient of friction (`core/contact/friction.hpp`).
//
// The film drags both surfaces by F against their motion, and its pressure, whose centre lies ahead of the contact's, acts on
// the ball by 2 F R_x/r and on the ring by 2 F R_x/R in opposite directions, through their centres, without moment or loss (R_x is
// the radius of the gap along rolling; R that of the race, below zero for the outer one). The sums of these four forces and of their
// moments vanish: the action on the ring is that on the ball, reversed. With t along the groove, in the direction in which both
// surfaces move against the contact at their mean speed u, the ball gets the force (2 R_x/r - 1) F t and about its centre
// the torque -F arm x t, and 2 F u is lost, where R_x/r is the contact point's distance from the axis over the ball's. A moment M
// about the ball's axis is taken as F = M/(2 r).

constexpr double LIGHT = 1e-6;  // N: resistance sets in smoothly with the load  # tuned: far below the weight of a ball
constexpr double SLOW = 1e-4;  // m/s: and with the speed  # tuned: far below speeds of interest

// F [N] and the coefficient of friction, if requested with derivatives by load and speed; the logarithm of thickness over
// roughness; u [m/s], the x and y of t, 2 R_x/r, and -arm x t [m].
template <class X>
struct ContactFilm {
  X resistance, friction;
  Pack log_ratio, speed, x, y, lead;
  Vector3<Pack> turning;
};

template <class X>
struct FilmValues {
  X resistance, friction, log_ratio;
};

inline std::array<Pack, FILM_NUMBERS> film_numbers_at(const Raceway &raceway, const Pack &radial) {
  std::array<Pack, FILM_NUMBERS> numbers;
  Pack x = absolute(radial) - 1.0;
  for (int i = 0; i < FILM_NUMBERS; i++) numbers[i] = raceway.film[i][0] + x * (raceway.film[i][1] + x * raceway.film[i][2]);
  return numbers;
}

// Resistance at a load [N] and a speed [m/s] of any sign, coefficient of friction and logarithm of thickness over roughness, where
// the normal has this radial part; the negligible slopes by that are omitted.
template <class Q, class U>
[[gnu::noinline]] inline FilmValues<decltype(Q{} * U{})> film_values(const Bearing &bearing, const Raceway &raceway,
                                                                     const Pack &radial, const Q &load, const U &speed) {
  const Lubricant &lubricant = bearing.lubricant;
  auto numbers = film_numbers_at(raceway, radial);
  auto [size, over_size] = root_and_inverse(speed * speed + SLOW * SLOW);
  auto pressed = load + LIGHT;
  auto log_load = logarithm(pressed);
  auto log_speed = logarithm(size);
  auto log_ratio = film_thickness(numbers, log_load, log_speed) - lubricant.log_roughness;
  auto friction = mixed_friction(lubricant, log_ratio);
  auto moments = hysteresis_moment(numbers, log_load) + friction * slip_moment(numbers, log_load);
  auto resistance = film_resistance(lubricant, numbers, log_load, log_speed, size) + 0.5 / bearing.ball_radius * moments;
  return {(load / pressed) * (speed * over_size) * resistance, friction, log_ratio};
}

// Sets the approximation within the step.
[[gnu::noinline]] inline void start_film(const FilmValues<Dual<3, Pack>> &values, const Pack &load, const Pack &speed,
                                         FilmStart &start) {
  auto inverse = [](const Pack &x) { return select(absolute(x) > 1e-12, 1.0 / x, Pack{}); };
  start.over_load = inverse(load), start.over_speed = inverse(speed), start.is_set = true;
  int i = 0;
  for (const auto *factor : {&values.resistance, &values.friction}) {
    Pack inverse_value = inverse(factor->value), by_load = factor->slope[0] * load * inverse_value,
         by_speed = factor->slope[1] * speed * inverse_value;
    start.value[i] = factor->value;
    start.load[i][0] = 1.0 + by_load, start.load[i][1] = 1.0 - by_load;
    start.speed[i][0] = 1.0 + by_speed, start.speed[i][1] = 1.0 - by_speed, i++;
  }
}
// Within the step x^e is (2 + (1 + e) p)/(2 + (1 - e) p), p = x - 1, with the same value and first two derivatives at p = 0.
CORE_INLINE FilmValues<Pack> film_in_step(const FilmStart &start, const Pack &load, const Pack &speed) {
  constexpr double MAX_RATIO = 8.0;  // of load or speed to those at the start; beyond it a power is constant
  Pack p = minimum(load * start.over_load, MAX_RATIO) - 1.0, w = minimum(maximum(speed * start.over_speed, 0.0), MAX_RATIO) - 1.0;
  Pack numerator[2], denominator[2];
  for (int i = 0; i < 2; i++) {
    numerator[i] = start.value[i] * ((2.0 + start.load[i][0] * p) * (2.0 + start.speed[i][0] * w));
    denominator[i] = (2.0 + start.load[i][1] * p) * (2.0 + start.speed[i][1] * w);
  }
  Pack inverse = 1.0 / (denominator[0] * denominator[1]);
  return {select(load > 0.0, numerator[0] * (denominator[1] * inverse), Pack{}), numerator[1] * (denominator[0] * inverse), Pack{}};
}

// `velocity` of the ball's centre relative to the ring's. With DERIVATIVES values and slopes go into `start`, for evaluations within
// the step.
template <bool DERIVATIVES, class P, class R, class V>
CORE_INLINE auto contact_film(const Bearing &bearing, const Raceway &raceway, const P &geometry, const R &relative,
                              const V &velocity, FilmStart *start) {
  using X = std::conditional_t<DERIVATIVES, Dual<3, Pack>, Pack>;
  ContactFilm<X> film;
  Pack inverse = 1.0 / as_pack(geometry.axis_distance), load = as_pack(geometry.load);
  film.x = -inverse * as_pack(geometry.offset.y), film.y = inverse * as_pack(geometry.offset.x);
  Vector3<Pack> arm = as_packs(geometry.arm);
  film.turning = {arm.z * film.y, -arm.z * film.x, arm.y * film.x - arm.x * film.y};
  film.lead = 2.0 - 2.0 * inverse * film.turning.z;  // twice the contact point's distance from the axis over that of the ball
  auto along = [&](const auto &v) __attribute__((always_inline)) { return film.x * as_pack(v.x) + film.y * as_pack(v.y); };
  film.speed = 0.5 * along(relative) + along(geometry.surface_velocity) - 0.5 * film.lead * along(velocity);
  auto set = [&](const FilmValues<X> &values) {
    film.resistance = values.resistance, film.friction = values.friction, film.log_ratio = value_of(values.log_ratio);
  };
  if constexpr (DERIVATIVES) {
    auto values = film_values(bearing, raceway, as_pack(geometry.radial), variable<0>(load), variable<1>(film.speed));
    if (start) start_film(values, load, film.speed, *start);
    set(values);
  } else if (start && start->is_set) set(film_in_step(*start, load, film.speed));
  else set(film_values(bearing, raceway, as_pack(geometry.radial), load, film.speed));
  return film;
}

// Terms of a contact in the equations of motion: `moment` [N m] about the ring's axis, power of surface heights [W].
template <class F, class T, class L>
struct BallLoads {
  F force;
  T torque;
  L loss;
};
template <class F, class T, class L>
BallLoads(F, T, L) -> BallLoads<F, T, L>;
template <class F, class T, class M, class L, class H>
struct BallAction {
  F force;
  T torque;
  M moment;
  L loss;
  H height_power;
};
template <class F, class T, class M, class L, class H>
BallAction(F, T, M, L, H) -> BallAction<F, T, M, L, H>;

// Loads on the ball with the resistance of the film, and the slopes of its coefficient of friction.
template <class C, class V, class A>
CORE_INLINE A with_film(const C &contact, const V &velocity, const A &loads) {
  const auto &geometry = contact.geometry;
  const auto &film = contact.film;
  // for its slopes; t is about tangential
  auto speed = film.y * (0.5 * contact.relative.y + geometry.surface_velocity.y - (0.5 * film.lead) * velocity.y);
  auto resistance = composed(film.resistance, geometry.load, speed), pull = (film.lead - 1.0) * resistance;
  auto force = loads.force + Vector3{pull * film.x, pull * film.y, Zero{}};
  auto torque = loads.torque + resistance * film.turning;
  auto loss = loads.loss + 2.0 * film.speed * resistance;
  if constexpr (!IsDual<decltype(film.resistance)>) return {force, torque, loss};
  else {
    const auto &mu = film.friction;
    auto change = (1.0 / mu.value) * composed(Dual<3, Pack>{Pack{}, {mu.slope[0], mu.slope[1]}}, geometry.load, speed);
    Vector3<Pack> friction = as_packs(contact.action.friction);
    Pack friction_power =
        dot(friction, as_packs(contact.action.slip)) + as_pack(contact.action.spin_moment) * as_pack(contact.spin);
    return {force + change * friction, torque + change * as_packs(contact.action.torque), loss - friction_power * change};
  }
}

// A contact with all its parts. `action` is differentiated by the position, and by the relative velocity and the spin about the
// normal as columns FREE to FREE + 3: fewer columns through the friction.
constexpr int FREE = 10;
template <class P, class U, class W, class M, class C>
struct RacewayContact {
  P geometry;
  U relative;
  W spin;
  M film;
  C action;
};
template <class P, class U, class W, class M, class C>
RacewayContact(P, U, W, M, C) -> RacewayContact<P, U, W, M, C>;

// `offset` and `velocity` of the ball's centre relative to the ring's, its spin and the ring's speed; `carried` may be null.
template <bool PATCH, class O, class V, class S, class W>
CORE_INLINE auto raceway_contact(const Bearing &bearing, const Raceway &raceway, const CarriedContacts *carried,
                                 const Height &height, const O &offset, const V &velocity, const S &spin, const W &speed) {
  auto geometry = contact_geometry(bearing, raceway, offset, speed, carried ? carried->contact : nullptr, height);
  auto relative = (velocity + cross(spin, geometry.arm)) - geometry.surface_velocity;
  auto about_normal = dot(spin, geometry.normal) - speed * geometry.normal.z;
  constexpr bool DERIVATIVES = IsDual<decltype(relative.x)>;
  Pack coefficient = broadcast<Pack>(PATCH ? bearing.patch.coefficient : bearing.friction_coefficient);
  decltype(contact_film<DERIVATIVES>(bearing, raceway, geometry, relative, velocity, nullptr)) film{};
  if (bearing.lubricant.works()) {
    film = contact_film<DERIVATIVES>(bearing, raceway, geometry, relative, velocity, carried ? &carried->film : nullptr);
    coefficient = value_of(film.friction);
  }
  auto action =
      contact_action<PATCH>(bearing, raceway, geometry, local<FREE>(relative), local<FREE + 3>(about_normal), coefficient);
  return RacewayContact{geometry, relative, about_normal, film, action};
}

// Action of a raceway on a ball, differentiated by the variables of its motion.
template <bool PATCH, class O, class V, class S, class W>
CORE_INLINE auto raceway_action(const Bearing &bearing, const Raceway &raceway, const CarriedContacts *carried,
                                const Height &height, const O &offset, const V &velocity, const S &spin, const W &speed) {
  auto contact = raceway_contact<PATCH>(bearing, raceway, carried, height, offset, velocity, spin, speed);
  const auto &relative = contact.relative;
  auto chain = [&]<class Y>(const Y &y) __attribute__((always_inline)) {
    if constexpr (!IsDual<Y>) return y;
    else {
      constexpr unsigned columns_of_y = columns_of<Y>, outer_columns = columns_of_y & ((1u << FREE) - 1);
      constexpr unsigned by_spin = columns_of_y >> (FREE + 3) & 1 ? columns_of<decltype(contact.spin)> : 0u;
      constexpr unsigned columns = outer_columns | columns_of<decltype(relative.x)> | columns_of<decltype(relative.y)> |
                                   columns_of<decltype(relative.z)> | by_spin;
      return dual<columns>(value_of(y), [&]<int C>() __attribute__((always_inline)) {
        return ((slope_of<C>(y) + slope_of<FREE>(y) * slope_of<C>(relative.x)) +
                (slope_of<FREE + 1>(y) * slope_of<C>(relative.y) + slope_of<FREE + 2>(y) * slope_of<C>(relative.z))) +
               slope_of<FREE + 3>(y) * slope_of<C>(contact.spin);
      });
    }
  };
  auto vector = [&](const auto &v) __attribute__((always_inline)) { return Vector3{chain(v.x), chain(v.y), chain(v.z)}; };
  BallLoads dry{vector(contact.action.force), vector(contact.action.torque), chain(contact.action.loss)};
  auto [force, torque, loss] = bearing.lubricant.works() ? with_film(contact, velocity, dry) : dry;
  auto moment = (offset.x * force.y - offset.y * force.x) + torque.z;
  return BallAction{force, torque, moment, loss, height_power(force, contact.geometry.normal, height.rate)};
}

}  // namespace core
