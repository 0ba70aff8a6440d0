// What a ball and the bodies it meets do to each other, written once over the type of the numbers.
//
// The independent variables are the ball's place, its velocity and spin, and places and velocities of the bodies. A
// ball's velocity along its orbit is its orbit rate, so that the rate of every place is a variable: of an even cage the
// ball's angle and orbit rate are the cage's, and all else stays as it is.
#pragma once
#include "ball_rates.hpp"
#include "coupled_bodies.hpp"

namespace core {

// Variables: the columns of a ball's motion, then places and velocities of the bodies.
constexpr int ORBIT_RATE = VELOCITY + 1, BODY_PLACE = MOTION, BODY_SPEED = BODY_PLACE + COORDINATES;
constexpr int VARIABLES = BODY_SPEED + COORDINATES;
// What elements give: accelerations of the ball, but along the orbit the moment on it about the axis [N m], less 2 m r v_r
// times the orbit rate; its angular acceleration; power of the drive and loss [W]; then forces on the coordinates.
enum ElementRow { RADIAL_ROW, ORBIT_ROW, AXIAL_ROW, SPIN_ROW, POWER_ROW = 6, LOSS_ROW };
constexpr int ON_BODY = LOSS_ROW + 1, ELEMENT_ROWS = ON_BODY + COORDINATES;

// The motion of a ball and of the bodies, as variables or as values.
template <bool DERIVATIVES>
struct ElementInput {
  const BallState &ball;  // its VELOCITY + 1 is the orbit rate
  const BodyState &bodies;
  template <int C> CORE_INLINE auto own() const { return input<DERIVATIVES, C>(ball[C]); }
  template <int C> CORE_INLINE auto place() const { return input<DERIVATIVES, BODY_PLACE + C>(broadcast<Pack>(bodies[C])); }
  template <int C> CORE_INLINE auto speed() const {
    return input<DERIVATIVES, BODY_SPEED + C>(broadcast<Pack>(bodies[COORDINATES + C]));
  }
};

template <class F, class T, class M, class L>
struct RingAction { F force; T torque; M moment; L loss; };  // on the ball; moment [N m]: about the ring's axis
template <class F, class T, class M, class L> RingAction(F, T, M, L) -> RingAction<F, T, M, L>;

// The inner raceway, all in the ring's axes: differentiated by the ball's offset, velocity and spin against the ring and
// by the ring's speed, and then by what these depend on.
template <bool PATCH, bool DERIVATIVES, class O, class V, class S, class W>
CORE_INLINE auto inner_action(const Bearing &bearing, const O &offset, const V &velocity, const S &spin, const W &speed) {
  auto local = [&]<int C>(const auto &x) __attribute__((always_inline)) { return input<DERIVATIVES, C>(value_of(x)); };
  auto three = [&]<int C>(const auto &v) __attribute__((always_inline)) {
    return Vector3{local.template operator()<C>(v.x), local.template operator()<C + 1>(v.y), local.template operator()<C + 2>(v.z)};
  };
  auto o = three.template operator()<0>(offset), v = three.template operator()<3>(velocity);
  auto s = three.template operator()<6>(spin);
  auto w = local.template operator()<9>(speed);
  auto [at, normal_radial] = contact_place(bearing, bearing.inner, o, w);
  auto relative = (v + cross(s, at.arm)) - at.surface_velocity;
  auto about_normal = dot(s, at.normal) - w * at.normal.z;
  auto action = staged_action<PATCH>(bearing, bearing.inner, at, normal_radial, relative, about_normal);
  auto through = [&](const auto &x) __attribute__((always_inline)) {
    return composed(x, offset.x, offset.y, offset.z, velocity.x, velocity.y, velocity.z, spin.x, spin.y, spin.z, speed);
  };
  auto vector = [&](const auto &x) __attribute__((always_inline)) { return Vector3{through(x.x), through(x.y), through(x.z)}; };
  auto moment = (o.x * action.force.y - o.y * action.force.x) + action.torque.z;
  return RingAction{vector(action.force), vector(action.torque), through(moment), through(action.loss)};
}

// The axes of a tilted ring, as rows in the frame in which its tilt is x, y: the inverse of 1 + tilt x.
template <class X, class Y, class Z>
struct RingAxes { X x; Y y; Z z; };
template <class X, class Y, class Z> RingAxes(X, Y, Z) -> RingAxes<X, Y, Z>;
template <class X, class Y>
CORE_INLINE auto ring_axes(const X &x, const Y &y) {
  auto xx = x * x, yy = y * y;
  auto share = 1.0 / (1.0 + (xx + yy));
  auto xy = share * (x * y), sx = share * x, sy = share * y;
  return RingAxes{Vector3{share * (1.0 + xx), xy, -sy}, Vector3{xy, share * (1.0 + yy), sx}, Vector3{sy, -sx, share}};
}
template <class A, class V>
CORE_INLINE auto into_ring(const A &axes, const V &v) { return Vector3{dot(axes.x, v), dot(axes.y, v), dot(axes.z, v)}; }
template <class A, class V>
CORE_INLINE auto out_of_ring(const A &axes, const V &v) { return (v.x * axes.x + v.y * axes.y) + v.z * axes.z; }

// A ball between its raceways: gives all rows but forces on the cage.
template <RingMotion RING, bool PATCH, bool DERIVATIVES, class Give>
CORE_INLINE void between_raceways(const Bearing &bearing, const ElementInput<DERIVATIVES> &in, Give give) {
  auto radius = in.template own<RADIUS>(), angle = in.template own<ANGLE>(), height = in.template own<HEIGHT>();
  auto radial = in.template own<VELOCITY>(), orbit_rate = in.template own<ORBIT_RATE>(), axial = in.template own<VELOCITY + 2>();
  Vector3 spin{in.template own<SPIN>(), in.template own<SPIN + 1>(), in.template own<SPIN + 2>()};
  auto shaft_speed = in.template speed<SHAFT>();
  auto [cosine, sine] = cosine_sine(angle);
  auto c = cosine, s = sine, minus_s = -sine;
  auto in_ball_frame = [&](const auto &v) __attribute__((always_inline)) { return about_z(c, minus_s, v); };
  auto in_fixed_frame = [&](const auto &v) __attribute__((always_inline)) { return about_z(c, s, v); };
  Vector3 velocity{radial, radius * orbit_rate, axial};

  auto [at, normal_radial] = contact_place(bearing, bearing.outer, Vector3{radius, Zero{}, height}, Zero{});
  auto outer = staged_action<PATCH>(bearing, bearing.outer, at, normal_radial, velocity + cross(spin, at.arm), dot(spin, at.normal));
  auto finish = [&](const auto &force, const auto &torque, const auto &inner, const auto &offset) __attribute__((always_inline)) {
    auto all = force + outer.force, turning = torque + outer.torque;
    auto gravity = in_ball_frame(Vector3{bearing.gravity[0], bearing.gravity[1], bearing.gravity[2]});
    double over_mass = 1.0 / bearing.ball_mass, over_inertia = 1.0 / bearing.ball_inertia;
    give.template operator()<RADIAL_ROW>(over_mass * all.x + gravity.x + orbit_rate * velocity.y);
    give.template operator()<ORBIT_ROW>(radius * (all.y + bearing.ball_mass * (gravity.y - 2.0 * (orbit_rate * radial))));
    give.template operator()<AXIAL_ROW>(over_mass * all.z + gravity.z);
    give.template operator()<SPIN_ROW>(over_inertia * turning.x + orbit_rate * spin.y);
    give.template operator()<SPIN_ROW + 1>(over_inertia * turning.y - orbit_rate * spin.x);
    give.template operator()<SPIN_ROW + 2>(over_inertia * turning.z);
    give.template operator()<POWER_ROW>(shaft_speed * inner.moment);
    give.template operator()<LOSS_ROW>(inner.loss + outer.loss);
    give.template operator()<ON_BODY + SHAFT>(-inner.moment);
    if constexpr (RING != RingMotion::held) {
      auto on_ring = in_fixed_frame(force);
      give.template operator()<ON_BODY + RING_X>(-on_ring.x), give.template operator()<ON_BODY + RING_Y>(-on_ring.y);
      give.template operator()<ON_BODY + RING_Z>(-on_ring.z);
    }
    if constexpr (RING == RingMotion::tilting) {
      auto moment = in_fixed_frame(cross(offset, force) + torque);
      give.template operator()<ON_BODY + TILT_X>(-moment.x), give.template operator()<ON_BODY + TILT_Y>(-moment.y);
    }
  };
  Vector3 position{radius, Zero{}, height};
  if constexpr (RING == RingMotion::held) {
    auto offset = position - in_ball_frame(Vector3{bearing.offset[0], bearing.offset[1], bearing.offset[2]});
    auto inner = inner_action<PATCH, DERIVATIVES>(bearing, offset, velocity, spin, shaft_speed);
    finish(inner.force, inner.torque, inner, offset);
  } else {
    auto from_centre = position - in_ball_frame(Vector3{in.template place<RING_X>(), in.template place<RING_Y>(), in.template place<RING_Z>()});
    auto against = velocity - in_ball_frame(Vector3{in.template speed<RING_X>(), in.template speed<RING_Y>(), in.template speed<RING_Z>()});
    if constexpr (RING == RingMotion::level) {
      auto inner = inner_action<PATCH, DERIVATIVES>(bearing, from_centre, against, spin, shaft_speed);
      finish(inner.force, inner.torque, inner, from_centre);
    } else {
      auto tilt = in_ball_frame(Vector3{in.template place<TILT_X>(), in.template place<TILT_Y>(), Zero{}});
      auto turning = in_ball_frame(Vector3{in.template speed<TILT_X>(), in.template speed<TILT_Y>(), Zero{}});
      auto axes = ring_axes(tilt.x, tilt.y);
      auto offset = into_ring(axes, from_centre);
      auto inner = inner_action<PATCH, DERIVATIVES>(bearing, offset, into_ring(axes, against - cross(turning, offset)),
                                                    into_ring(axes, spin - turning), shaft_speed);
      finish(out_of_ring(axes, inner.force), out_of_ring(axes, inner.torque), inner, offset);
    }
  }
}

}  // namespace core
