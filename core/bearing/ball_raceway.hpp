// The contact of a ball with a raceway (paper 1, section 5), written once over the type of its numbers: where, how fast,
// how hard. `normal` points from the ball's centre to the raceway, so the load on the ball is -normal_load * normal;
// `slip` is the velocity of the ball's surface relative to the raceway. All vectors are in the ball's frame, forces act
// on the ball, half the approach inside its surface. A gap gives zero loads.
#pragma once
#include "../math/vector3.hpp"
#include "contact_film.hpp"
#include "model.hpp"

namespace core {

struct NoHeight { Zero value, rate; };

// Where: the meridian plane of the ring through the ball's centre. How hard, as far as the place alone says.
template <class O, class N, class A, class D, class R, class T, class W, class L, class S, class H>
struct ContactPlace {
  O offset;  // of the ball's centre from the ring's [m]
  N normal;
  A approach;  // [m]; above zero in contact
  D axis_distance;  // of the ball's centre from the ring's axis [m]
  R arm;  // from the ball's centre to the contact point [m]
  T surface_velocity;  // of the raceway at the contact point [m/s]
  W ring_speed;  // about the axis [rad/s]
  L load;  // elastic [N]
  S stiffness;  // [N/m]
  H height_rate;  // by which heights that come by close the contact [m/s]
};
template <class O, class N, class A, class D, class R, class T, class W, class L, class S, class H>
ContactPlace(O, N, A, D, R, T, W, L, S, H) -> ContactPlace<O, N, A, D, R, T, W, L, S, H>;

// The coefficient of the elastic law where the normal has this radial part, from what is `carried` (LANES,) if anything is.
[[gnu::noinline]] inline std::pair<Pack, Pack> carried_coefficient(const Bearing &bearing, const Raceway &raceway, const Pack &radial,
                                                                   const CarriedContact *carried) {
  Pack value{}, slope{};
  for (int lane = 0; lane < LANES; lane++) {
    double over = 1.0 / (raceway.locus_radius + raceway.groove_radius * radial[lane]);
    double small = bearing.curvature_across(raceway), large = bearing.curvature_along(raceway, double(radial[lane]));
    auto [coefficient, by_large] = coefficient_and_slope(carried[lane], small, large, raceway.modulus);
    value[lane] = coefficient, slope[lane] = by_large * -0.5 * raceway.locus_radius * over * over;
  }
  return {value, slope};
}
template <Number N>
CORE_INLINE auto coefficient_at(const Bearing &bearing, const Raceway &raceway, const N &radial, const CarriedContact *carried) {
  if constexpr (std::is_same_v<ValueOf<N>, Pack>)
    if (carried && bearing.carried != CarriedLaw::none) {
      std::pair<Pack, Pack> found = carried_coefficient(bearing, raceway, value_of(radial), carried);
      return with_slope(radial, found.first, [&] { return found.second; });
    }
  return along_groove(raceway.coefficient, radial);
}

template <class O, class W, class H = NoHeight>
CORE_INLINE auto contact_place(const Bearing &bearing, const Raceway &raceway, const O &offset, const W &ring_speed,
                               const CarriedContact *carried = nullptr, const H &height = {}) {
  auto [axis_distance, over_distance] = [&] {
    if constexpr (IsZero<decltype(offset.y)>) return std::pair{offset.x, 1.0 / offset.x};
    else return root_and_inverse(offset.x * offset.x + offset.y * offset.y);
  }();
  auto outwards = axis_distance - raceway.locus_radius;
  auto [distance, inverse] = root_and_inverse(outwards * outwards + offset.z * offset.z + 1e-300);
  auto normal_radial = outwards * inverse;
  auto in_plane = normal_radial * over_distance;
  Vector3 normal{in_plane * offset.x, in_plane * offset.y, offset.z * inverse};
  auto approach = distance + (bearing.ball_radius - raceway.groove_radius) + height.value;
  auto arm = (bearing.ball_radius - 0.5 * approach) * normal;
  auto point = offset + arm;
  Vector3 surface_velocity{-(ring_speed * point.y), ring_speed * point.x, Zero{}};

  auto coefficient = coefficient_at(bearing, raceway, normal_radial, carried);
  auto spring = elastic(coefficient, bearing.power, approach);
  return std::pair{ContactPlace{offset, normal, approach, axis_distance, arm, surface_velocity, ring_speed, spring.load,
                               spring.stiffness, height.rate},
                   normal_radial};
}

// What a contact does to the ball: force [N], torque about the ball's centre [N m], power of the ring's rotation on the
// ball and power lost [W]; and what these consist of: normal load [N], slip [m/s], friction force [N], and the friction
// torque about the normal [N m] (drilling), which friction at a point has not.
template <class F, class T, class P, class L, class N, class S, class R, class D>
struct ContactAction { F force; T torque; P power; L loss; N normal_load; S slip; R friction; D drilling; };
template <class F, class T, class P, class L, class N, class S, class R, class D>
ContactAction(F, T, P, L, N, S, R, D) -> ContactAction<F, T, P, L, N, S, R, D>;

// How hard, for `relative`, the velocity of the ball's surface against the raceway at the contact point, the spin of the
// ball against it about the normal, and a coefficient of friction.
template <bool PATCH, class P, class N, class U, class W>
CORE_INLINE auto contact_action(const Bearing &bearing, const Raceway &raceway, const P &at, const N &normal_radial,
                                const U &relative, const W &spin, const Pack &coefficient) {
  auto approach_rate = dot(relative, at.normal);
  auto slip = relative - approach_rate * at.normal;
  auto closing = approach_rate + at.height_rate;
  auto normal_load = maximum(proportional_load(at.load, at.stiffness, closing, bearing.damping, bearing.relaxation_time), 0.0);
  auto damping_loss = (normal_load - at.load) * closing;
  if constexpr (!PATCH) {
    auto square = dot(slip, slip);
    auto resistance = point_resistance(coefficient * normal_load, square, bearing.regularisation);
    auto friction = (-resistance) * slip;
    auto force = friction - normal_load * at.normal;
    return ContactAction{force, cross(at.arm, friction), dot(force, at.surface_velocity),
                         resistance * square + damping_loss, normal_load, slip, friction, Zero{}};
  } else {
    // The patch's axes: major across the groove, minor (x, y, 0) along the ring's circumference.
    auto over = 1.0 / at.axis_distance;
    auto x = -(over * at.offset.y);
    auto y = over * at.offset.x;
    auto root = root_of_depth(maximum(at.approach, LEAST_DEPTH));
    auto major = root * along_groove(raceway.semi_major, normal_radial);
    auto minor = root * along_groove(raceway.semi_minor, normal_radial);
    auto slip_major = at.normal.z * (y * slip.x - x * slip.y) - normal_radial * slip.z;
    auto slip_minor = x * slip.x + y * slip.y;
    auto means = patch_means(bearing.patch, bearing.regularisation, major, minor, slip_major, slip_minor, spin);
    auto in_ball_frame = [&](const auto &along_major, const auto &along_minor, const auto &along_normal) {
      auto outwards = along_major * at.normal.z + along_normal * normal_radial;
      return Vector3{outwards * y + along_minor * x, along_minor * y - outwards * x,
                     along_normal * at.normal.z - along_major * normal_radial};
    };
    auto limit = coefficient * normal_load, lever = bearing.ball_radius - 0.5 * at.approach;
    auto along = limit * means.along, across = limit * means.across, moment = limit * means.moment;
    auto friction = in_ball_frame(-along, -across, Zero{});
    auto force = friction - normal_load * at.normal;
    auto torque = in_ball_frame(lever * across, -(lever * along), -moment);
    auto loss = along * slip_major + across * slip_minor + moment * spin + damping_loss;
    auto power = dot(force, at.surface_velocity) - moment * (at.ring_speed * at.normal.z);
    return ContactAction{force, torque, power, loss, normal_load, slip, friction, -moment};
  }
}

// What heights that come by do to a contact [W], of the force on the ball.
template <class F, class N>
CORE_INLINE Pack height_power(const F &force, const N &normal, const Pack &rate) {
  Pack load = -(value_of(force.x) * value_of(normal.x) + value_of(force.z) * value_of(normal.z));
  if constexpr (!IsZero<decltype(normal.y)>) load -= value_of(force.y) * value_of(normal.y);
  return load * rate;
}

// What the equations of motion take of a contact.
template <class F, class T, class P, class L>
struct BallAction { F force; T torque; P power; L loss; };
template <class F, class T, class P, class L> BallAction(F, T, P, L) -> BallAction<F, T, P, L>;

// What the film does to the ball, beside friction by its coefficient.
template <class P, class A>
CORE_INLINE A with_film(const P &at, const ContactFilm &film, const A &action) {
  auto resistance = with_slope(at.load, film.resistance, [&] { return film.by_load; });
  auto pull = (film.lead - 1.0) * resistance;
  Vector3 force{pull * film.x, pull * film.y, Zero{}};
  auto torque = resistance * film.turning;
  auto axial = (at.offset.x * force.y - at.offset.y * force.x) + torque.z;
  return {action.force + force, action.torque + torque, action.power + at.ring_speed * axial,
          action.loss + 2.0 * film.speed * resistance};
}

// A contact that is differentiated first by the place, the relative velocity and the spin about the normal (columns 10 to
// 13), and then by what these depend on: fewer columns through the friction. `velocity` is that of the ball's centre against
// the ring's; `begin` may be null.
template <bool PATCH, class P, class N, class U, class W, class V>
CORE_INLINE auto staged_action(const Bearing &bearing, const Raceway &raceway, const P &at, const N &normal_radial,
                               const U &relative, const W &spin, const V &velocity, FilmBegin *begin) {
  constexpr int FIRST = 10;
  constexpr bool DERIVATIVES = IsDual<decltype(relative.x)>;
  Pack coefficient = broadcast<Pack>(PATCH ? bearing.patch.coefficient : bearing.friction_coefficient);
  ContactFilm film{};
  if (bearing.lubricant.works()) {
    film = contact_film<DERIVATIVES>(bearing, raceway, at, normal_radial, relative, velocity, begin);
    coefficient = film.friction;
  }
  auto finished = [&](const auto &action) __attribute__((always_inline)) {
    return bearing.lubricant.works() ? with_film(at, film, action) : action;
  };
  if constexpr (!DERIVATIVES) {
    auto action = contact_action<PATCH>(bearing, raceway, at, normal_radial, relative, spin, coefficient);
    return finished(BallAction{action.force, action.torque, action.power, action.loss});
  } else {
    Vector3 free{variable<FIRST>(value_of(relative.x)), variable<FIRST + 1>(value_of(relative.y)),
                 variable<FIRST + 2>(value_of(relative.z))};
    auto action = contact_action<PATCH>(bearing, raceway, at, normal_radial, free, variable<FIRST + 3>(value_of(spin)), coefficient);
    auto through = [&](const auto &y) __attribute__((always_inline)) {
      if constexpr (IsZero<decltype(y)>) return Zero{};
      else {
        constexpr unsigned found = columns_of<decltype(y)>;
        constexpr unsigned own = found & ((1u << FIRST) - 1);
        constexpr unsigned by_spin = found >> (FIRST + 3) & 1 ? columns_of<W> : 0u;
        constexpr unsigned columns = own | columns_of<decltype(relative.x)> | columns_of<decltype(relative.y)> |
                                     columns_of<decltype(relative.z)> | by_spin;
        return dual<columns>(value_of(y), [&]<int C>() __attribute__((always_inline)) {
          return ((slope_of<C>(y) + slope_of<FIRST>(y) * slope_of<C>(relative.x)) +
                  (slope_of<FIRST + 1>(y) * slope_of<C>(relative.y) + slope_of<FIRST + 2>(y) * slope_of<C>(relative.z))) +
                 slope_of<FIRST + 3>(y) * slope_of<C>(spin);
        });
      }
    };
    auto vector = [&](const auto &v) __attribute__((always_inline)) {
      return Vector3{through(v.x), through(v.y), through(v.z)};
    };
    return finished(BallAction{vector(action.force), vector(action.torque), through(action.power), through(action.loss)});
  }
}

}  // namespace core
