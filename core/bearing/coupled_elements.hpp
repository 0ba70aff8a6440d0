// What a ball and the bodies it meets do to each other, written once over the type of the numbers.
//
// The independent variables are the ball's place, its velocity and spin, and places and velocities of the bodies. A
// ball's velocity along its orbit is its orbit rate, so that the rate of every place is a variable: of an even cage the
// ball's angle and orbit rate are the cage's, and all else stays as it is.
#pragma once
#include "ball_rates.hpp"
#include "coupled_bodies.hpp"
#include "tilted_ring.hpp"

namespace core {

// Variables: the columns of a ball's motion, then places and velocities of the bodies.
constexpr int ORBIT_RATE = VELOCITY + 1, BODY_PLACE = MOTION, BODY_SPEED = BODY_PLACE + COORDINATES;
constexpr int VARIABLES = BODY_SPEED + COORDINATES;
// What elements give: accelerations of the ball, but along the orbit the moment on it about the axis [N m], less 2 m r v_r
// times the orbit rate; its angular acceleration; power of the drive and loss [W]; then forces on the coordinates.
enum ElementRow { RADIAL_ROW, ORBIT_ROW, AXIAL_ROW, SPIN_ROW, POWER_ROW = 6, LOSS_ROW };
constexpr int ON_BODY = LOSS_ROW + 1, ELEMENT_ROWS = ON_BODY + COORDINATES;

inline const Heights NO_HEIGHTS{};

// The motion of a ball and of the bodies, as variables or as values.
template <bool DERIVATIVES>
struct ElementInput {
  const BallState &ball;  // its VELOCITY + 1 is the orbit rate
  const BodyState &bodies;
  const CarriedBalls *carried = nullptr;
  const Heights &heights = NO_HEIGHTS;
  template <int C> CORE_INLINE auto own() const { return input<DERIVATIVES, C>(ball[C]); }
  template <int C> CORE_INLINE auto place() const { return input<DERIVATIVES, BODY_PLACE + C>(broadcast<Pack>(bodies[C])); }
  template <int C> CORE_INLINE auto speed() const {
    return input<DERIVATIVES, BODY_SPEED + C>(broadcast<Pack>(bodies[COORDINATES + C]));
  }
};

template <class F, class T, class M, class L>
// On the ball; moment [N m]: about the ring's axis; power of heights that come by [W].
struct RingAction { F force; T torque; M moment; L loss; Pack height_power; };
template <class F, class T, class M, class L> RingAction(F, T, M, L, Pack) -> RingAction<F, T, M, L>;

// The inner raceway, all in the ring's axes: differentiated by the ball's offset, velocity and spin against the ring and
// by the ring's speed, and then by what these depend on.
template <bool PATCH, bool DERIVATIVES, class O, class V, class S, class W>
CORE_INLINE auto inner_action(const Bearing &bearing, const CarriedBalls *carried, const Height &height, const O &offset, const V &velocity, const S &spin, const W &speed) {
  auto local = [&]<int C>(const auto &x) __attribute__((always_inline)) { return input<DERIVATIVES, C>(value_of(x)); };
  auto three = [&]<int C>(const auto &v) __attribute__((always_inline)) {
    return Vector3{local.template operator()<C>(v.x), local.template operator()<C + 1>(v.y), local.template operator()<C + 2>(v.z)};
  };
  auto o = three.template operator()<0>(offset), v = three.template operator()<3>(velocity);
  auto s = three.template operator()<6>(spin);
  auto w = local.template operator()<9>(speed);
  auto [at, normal_radial] = contact_place(bearing, bearing.inner, o, w, carried ? carried->inner : nullptr, height);
  auto relative = (v + cross(s, at.arm)) - at.surface_velocity;
  auto about_normal = dot(s, at.normal) - w * at.normal.z;
  auto action = staged_action<PATCH>(bearing, bearing.inner, at, normal_radial, relative, about_normal, v, carried ? &carried->film[0] : nullptr);
  auto through = [&](const auto &x) __attribute__((always_inline)) {
    return composed(x, offset.x, offset.y, offset.z, velocity.x, velocity.y, velocity.z, spin.x, spin.y, spin.z, speed);
  };
  auto vector = [&](const auto &x) __attribute__((always_inline)) { return Vector3{through(x.x), through(x.y), through(x.z)}; };
  auto moment = (o.x * action.force.y - o.y * action.force.x) + action.torque.z;
  return RingAction{vector(action.force), vector(action.torque), through(moment), through(action.loss),
                    height_power(action.force, at.normal, height.rate)};
}

// The same for a ring of any motion, all in the ball's frame: `offset` of the ball's centre and its `velocity` against the
// ring's centre, its spin, the ring's tilt (x, y) and the rate of that, and its speed.
template <class A, class X, class Y>
struct TiltedAction { A action; X moment_x; Y moment_y; };  // moments about the ring's centre as its tilts work
template <class A, class X, class Y> TiltedAction(A, X, Y) -> TiltedAction<A, X, Y>;
template <bool PATCH, bool DERIVATIVES, class O, class V, class S, class T, class R, class W>
CORE_INLINE auto tilted_action(const Bearing &bearing, const CarriedBalls *carried, const Height &height, const O &offset, const V &velocity, const S &spin, const T &tilt,
                               const R &turning, const W &speed) {
  auto local = [&]<int C, class X>(const X &x) __attribute__((always_inline)) {
    if constexpr (!IsDual<X>) return x;
    else return variable<C>(value_of(x));
  };
  auto three = [&]<int C>(const auto &v) __attribute__((always_inline)) {
    return Vector3{local.template operator()<C>(v.x), local.template operator()<C + 1>(v.y), local.template operator()<C + 2>(v.z)};
  };
  auto o = three.template operator()<0>(offset), v = three.template operator()<3>(velocity);
  auto s = three.template operator()<6>(spin);
  auto w = local.template operator()<9>(speed);
  auto t = three.template operator()<10>(tilt), r = three.template operator()<13>(turning);
  auto axes = ring_axes(t.x, t.y);
  auto from_centre = into_ring(axes, o);
  auto found = inner_action<PATCH, DERIVATIVES>(bearing, carried, height, from_centre, into_ring(axes, v - cross(r, from_centre)), into_ring(axes, s - r), w);
  auto through = [&](const auto &x) __attribute__((always_inline)) {
    return composed(x, offset.x, offset.y, offset.z, velocity.x, velocity.y, velocity.z, spin.x, spin.y, spin.z, speed,
                    tilt.x, tilt.y, tilt.z, turning.x, turning.y, turning.z);
  };
  auto vector = [&](const auto &x) __attribute__((always_inline)) { return Vector3{through(x.x), through(x.y), through(x.z)}; };
  auto force = out_of_ring(axes, found.force), torque = out_of_ring(axes, found.torque);
  auto moment = cross(from_centre, force) + torque;
  return TiltedAction{RingAction{vector(force), vector(torque), through(found.moment), through(found.loss), found.height_power},
                      through(moment.x), through(moment.y)};
}

// A ball between its raceways: gives all rows but forces on the cage.
template <RingMotion RING, bool PATCH, bool DERIVATIVES, class Give>
CORE_INLINE void between_raceways(const Bearing &bearing, const ElementInput<DERIVATIVES> &in, Give give) {
  auto radius = in.template own<RADIUS>(), angle = in.template own<ANGLE>(), height = in.template own<HEIGHT>();
  auto radial = in.template own<VELOCITY>(), orbit_rate = in.template own<ORBIT_RATE>(), axial = in.template own<VELOCITY + 2>();
  Vector3 spin{in.template own<SPIN>(), in.template own<SPIN + 1>(), in.template own<SPIN + 2>()};
  auto shaft_speed = in.template speed<SHAFT>();
  const CarriedBalls *carried = in.carried;
  auto [cosine, sine] = cosine_sine(angle);
  auto c = cosine, s = sine, minus_s = -sine;
  auto in_ball_frame = [&](const auto &v) __attribute__((always_inline)) { return about_z(c, minus_s, v); };
  Vector3 position{radius, Zero{}, height}, velocity{radial, radius * orbit_rate, axial};

  auto [at, normal_radial] = contact_place(bearing, bearing.outer, position, Zero{}, carried ? carried->outer : nullptr, in.heights.outer);
  auto outer = staged_action<PATCH>(bearing, bearing.outer, at, normal_radial, velocity + cross(spin, at.arm), dot(spin, at.normal), velocity,
                                    carried ? &carried->film[1] : nullptr);
  Pack outer_height = height_power(outer.force, at.normal, in.heights.outer.rate);
  auto finish = [&](const auto &inner) __attribute__((always_inline)) {
    auto force = inner.force + outer.force, torque = inner.torque + outer.torque;
    auto gravity = in_ball_frame(Vector3{bearing.gravity[0], bearing.gravity[1], bearing.gravity[2]});
    double over_mass = 1.0 / bearing.ball_mass, over_inertia = 1.0 / bearing.ball_inertia;
    give.template operator()<RADIAL_ROW>(over_mass * force.x + gravity.x + orbit_rate * velocity.y);
    give.template operator()<ORBIT_ROW>(radius * (force.y + bearing.ball_mass * (gravity.y - 2.0 * (orbit_rate * radial))));
    give.template operator()<AXIAL_ROW>(over_mass * force.z + gravity.z);
    give.template operator()<SPIN_ROW>(over_inertia * torque.x + orbit_rate * spin.y);
    give.template operator()<SPIN_ROW + 1>(over_inertia * torque.y - orbit_rate * spin.x);
    give.template operator()<SPIN_ROW + 2>(over_inertia * torque.z);
    give.template operator()<POWER_ROW>(shaft_speed * inner.moment + (inner.height_power + outer_height));
    give.template operator()<LOSS_ROW>(inner.loss + outer.loss);
    give.template operator()<ON_BODY + SHAFT>(-inner.moment);
    if constexpr (RING == RingMotion::level || RING == RingMotion::tilting) {
      auto on_ring = about_z(c, s, inner.force);
      give.template operator()<ON_BODY + RING_X>(-on_ring.x), give.template operator()<ON_BODY + RING_Y>(-on_ring.y);
      give.template operator()<ON_BODY + RING_Z>(-on_ring.z);
    }
  };
  if constexpr (RING == RingMotion::held) {
    auto offset = position - in_ball_frame(Vector3{bearing.offset[0], bearing.offset[1], bearing.offset[2]});
    finish(inner_action<PATCH, DERIVATIVES>(bearing, carried, in.heights.inner, offset, velocity, spin, shaft_speed));
  } else {
    constexpr bool MOVES = RING != RingMotion::tilted;
    ElementInput<DERIVATIVES && MOVES> ring{in.ball, in.bodies};
    auto rate = [&]<int C>() __attribute__((always_inline)) {
      if constexpr (MOVES) return ring.template speed<C>();
      else return Zero{};
    };
    Vector3 centre{ring.template place<RING_X>(), ring.template place<RING_Y>(), ring.template place<RING_Z>()};
    Vector3 drift{rate.template operator()<RING_X>(), rate.template operator()<RING_Y>(), rate.template operator()<RING_Z>()};
    auto offset = position - in_ball_frame(centre), against = velocity - in_ball_frame(drift);
    if constexpr (RING == RingMotion::level) {
      finish(inner_action<PATCH, DERIVATIVES>(bearing, carried, in.heights.inner, offset, against, spin, shaft_speed));
    } else {
      auto tilt = in_ball_frame(Vector3{ring.template place<TILT_X>(), ring.template place<TILT_Y>(), Zero{}});
      auto turning = in_ball_frame(Vector3{rate.template operator()<TILT_X>(), rate.template operator()<TILT_Y>(), Zero{}});
      auto inner = tilted_action<PATCH, DERIVATIVES>(bearing, carried, in.heights.inner, offset, against, spin, tilt, turning, shaft_speed);
      finish(inner.action);
      if constexpr (RING == RingMotion::tilting) {
        auto moment = about_z(c, s, Vector3{inner.moment_x, inner.moment_y, Zero{}});
        give.template operator()<ON_BODY + TILT_X>(-moment.x), give.template operator()<ON_BODY + TILT_Y>(-moment.y);
      }
    }
  }
}

}  // namespace core
