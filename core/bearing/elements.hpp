// Forces between the bodies of a bearing, written once over the type of the numbers: balls, inner ring, cage, housing and shaft.
#pragma once
#include "raceway_contact.hpp"

namespace core {

// The bodies coupled to all balls: inner ring, cage, housing and shaft. Each coordinate is free, where it follows from
// the forces on it, or held; the shaft's angle is prescribed where it is not free.
//
// Ring: M dv/dt = load + weight + unbalance + forces of the balls - D v - K (q - q_0), and about its diameters, at the
// speed W of the shaft, I_t d2(theta_x) + I_p W d(theta_y) = M_x, I_t d2(theta_y) - I_p W d(theta_x) = M_y (small tilts).
// Housing, along a direction, with the outer ring in it: M dv/dt = weight + forces of the balls - D v - K q; the origin of
// bearing_link is the outer ring's centre at q = 0.
// Shaft: J dw/dt = torque - damping w + moments of balls and land.

// Positions [m], [rad] in bearing_link; a state holds them, their velocities, and integrals over time.
enum Coordinate { RING_X, RING_Y, RING_Z, TILT_X, TILT_Y, CAGE_X, CAGE_Y, CAGE_ANGLE, HOUSING, SHAFT };
constexpr int COORDINATES = SHAFT + 1;
// Work of the loads on the ring, dissipation of support and land, work of the drive through the land, work of the torque [J].
enum Integral { LOAD_WORK, LOST, LAND_WORK, TORQUE_WORK };
constexpr int INTEGRALS = TORQUE_WORK + 1, BODY_NUMBERS = 2 * COORDINATES + INTEGRALS;
using BodyState = std::array<double, BODY_NUMBERS>;

// Motion of the rings: an inner ring that is held, held and tilted, that moves and does not tilt, or moves and tilts; the last
// together with an outer ring that may move with its housing.
enum class RingMotion { held, tilted, level, tilting };
enum class CageKind { none, even, pockets };

// A wall of the cage: a spring and a parallel damper, whose force sets in over the roughness of the wall.
struct Wall {
  double stiffness, relaxation_time, friction;
};
constexpr double ONSET = 1e-6;  // m

struct Pockets {
  double radius, half_clearance;
  Wall wall;
};  // on a circle of this radius [m]
// The land of the outer ring (side 1) or the inner (-1) that guides a cage; 0 without one.
struct Land {
  double side, radius, clearance, smoothing;
  Wall wall;
};

struct CoupledBodies {
  RingMotion ring;
  CageKind cage;
  bool free[COORDINATES], guided;  // a guided cage's centre moves
  double inertia[COORDINATES], stiffness[COORDINATES], damping[COORDINATES], rest_position[COORDINATES], weight[COORDINATES];
  double load[COORDINATES], load_rate[COORDINATES];  // at the start of the chunk [N], [N m], and its rate
  double position_scale[COORDINATES], velocity_scale[COORDINATES];  // tolerated errors of a step; 0: not controlled
  double polar_inertia, unbalance, phase;  // [kg m^2]; mass times radius [kg m], its angle ahead of the shaft's [rad]
  Pockets pockets;
  double light;  // approach [m] at the outer raceway below which errors along the orbit count less
  Land land;
  double direction[3];  // of the housing's motion, of length 1
  bool torque_driven() const { return free[SHAFT]; }
};

// Elastic load of a wall, and that of spring and damper together, which do not pull [N].
template <Number A, class R>
CORE_INLINE auto wall_load(const Wall &wall, const A &approach, const R &rate) {
  auto depth = maximum(approach, 0.0);
  auto elastic = wall.stiffness * depth;
  auto viscous = (wall.stiffness * wall.relaxation_time) * (rate * (depth / (depth + ONSET)));
  return std::pair{elastic, maximum(elastic + viscous, 0.0)};
}

// x and y of the cage's centre relative to its land; `value(coordinate)` are positions, velocities or accelerations.
template <class Value>
CORE_INLINE auto relative_to_land(const CoupledBodies &b, Value value) {
  double moves = b.land.side < 0.0 ? 1.0 : 0.0;
  return std::pair{value(index<CAGE_X>) - moves * value(index<RING_X>), value(index<CAGE_Y>) - moves * value(index<RING_Y>)};
}

// The land of a ring that guides a cage, two round surfaces in the plane across the axis; `add` as for `body_forces`.
template <class P, class V, class Add>
inline void land_forces(const CoupledBodies &b, P position, V velocity, Add add) {
  bool inner = b.land.side < 0.0;
  auto [x, y] = relative_to_land(b, position);
  auto [u, v] = relative_to_land(b, velocity);
  auto square = x * x + y * y;
  if (!(std::sqrt(value_of(square)) > b.land.clearance)) return;
  auto [distance, inverse] = root_and_inverse(square);
  auto along = x * inverse, across = y * inverse;
  auto rate = along * u + across * v;
  auto [elastic, load] = wall_load(b.land.wall, distance - b.land.clearance, rate);
  auto lever = b.land.side * b.land.radius - distance;  // from the cage's centre to where they touch
  auto ring_speed = (inner ? 1.0 : 0.0) * velocity(index<SHAFT>);
  auto slip = along * v - across * u + velocity(index<CAGE_ANGLE>) * lever - b.land.side * b.land.radius * ring_speed;
  auto drag = -(b.land.wall.friction * load) * slip * root_and_inverse(slip * slip + b.land.smoothing * b.land.smoothing).second;
  auto force_x = -(load * along) - drag * across, force_y = drag * along - load * across;
  auto ring_torque = -(b.land.side * b.land.radius) * drag;
  add(index<CAGE_X>, force_x), add(index<CAGE_Y>, force_y), add(index<CAGE_ANGLE>, lever * drag);
  add(index<COORDINATES + LOST>, (load - elastic) * rate - drag * slip);
  if (!inner) return;
  if (b.free[RING_X]) add(index<RING_X>, -force_x);
  if (b.free[RING_Y]) add(index<RING_Y>, -force_y);
  add(index<SHAFT>, ring_torque);
  add(index<COORDINATES + LAND_WORK>, -(ring_speed * ring_torque));
}

// Forces on the coordinates except those of the balls, and powers of the integrals. `add`<ROW> adds to the force on coordinate
// ROW, or to the power of integral ROW - COORDINATES. With DERIVATIVES its columns are those of `y`.
template <bool DERIVATIVES, class Add>
inline void body_forces(const CoupledBodies &b, double time, const BodyState &y, Add add) {
  auto position = [&]<int C>(Index<C>) { return input<DERIVATIVES, C>(y[C]); };
  auto velocity = [&]<int C>(Index<C>) { return input<DERIVATIVES, COORDINATES + C>(y[COORDINATES + C]); };
  auto shaft_speed = velocity(index<SHAFT>);
  auto on_ring = [&]<int C>(Index<C>) {
    if (!b.free[C]) return;
    auto speed = velocity(index<C>);
    double load = b.load[C] + time * b.load_rate[C];
    auto drag = b.damping[C] * speed;
    add(index<C>, load + b.weight[C] - drag - b.stiffness[C] * (position(index<C>) - b.rest_position[C]));
    add(index<COORDINATES + LOAD_WORK>, load * speed);
    add(index<COORDINATES + LOST>, drag * speed);
  };
  on_ring(index<RING_X>), on_ring(index<RING_Y>), on_ring(index<RING_Z>);
  on_ring(index<TILT_X>), on_ring(index<TILT_Y>), on_ring(index<HOUSING>);
  if (b.polar_inertia != 0.0) {
    auto spin = b.polar_inertia * shaft_speed;
    if (b.free[TILT_X]) add(index<TILT_X>, -(spin * velocity(index<TILT_Y>)));
    if (b.free[TILT_Y]) add(index<TILT_Y>, spin * velocity(index<TILT_X>));
  }
  if (b.unbalance != 0.0) {
    auto [cosine, sine] = cosine_sine(position(index<SHAFT>) + b.phase);
    auto size = b.unbalance * (shaft_speed * shaft_speed);
    auto add_rotating = [&]<int C>(Index<C>, const auto &part) {
      if (!b.free[C]) return;
      auto force = size * part;
      add(index<C>, force);
      add(index<COORDINATES + LOAD_WORK>, force * velocity(index<C>));
    };
    add_rotating(index<RING_X>, cosine), add_rotating(index<RING_Y>, sine);
  }
  if (b.guided) {
    add(index<CAGE_X>, b.weight[CAGE_X]), add(index<CAGE_Y>, b.weight[CAGE_Y]);
    land_forces(b, position, velocity, add);
  }
  if (b.free[SHAFT]) {
    double torque = b.load[SHAFT] + time * b.load_rate[SHAFT];
    auto drag = b.damping[SHAFT] * shaft_speed;
    add(index<SHAFT>, torque - drag);
    add(index<COORDINATES + TORQUE_WORK>, torque * shaft_speed);
    add(index<COORDINATES + LOST>, drag * shaft_speed);
  }
}

// Forces between a ball and the bodies coupled to it, written once over the type of the numbers.
//
// The independent variables are the ball's position, velocity and spin, and positions and velocities of the bodies. A
// ball's velocity along its orbit is its orbit rate, so that the rate of every position is a variable: in an even cage the
// ball's angle and orbit rate are those of the cage, without other changes.

// Variables: the columns of a ball's motion, then positions and velocities of the bodies.
constexpr int ORBIT_RATE = VELOCITY + 1, BODY_POSITION = MOTION, BODY_VELOCITY = BODY_POSITION + COORDINATES;
constexpr int VARIABLES = BODY_VELOCITY + COORDINATES;
// Results of elements: accelerations of the ball, but along the orbit the moment on it about the axis [N m], less 2 m r v_r
// times the orbit rate; its angular acceleration; power of the drive and loss [W]; then forces on the coordinates.
enum ElementRow { RADIAL_ROW, ORBIT_ROW, AXIAL_ROW, SPIN_ROW, POWER_ROW = 6, LOSS_ROW };
constexpr int FORCE_ROW = LOSS_ROW + 1, ELEMENT_ROWS = FORCE_ROW + COORDINATES;

inline const Heights NO_HEIGHTS{};

// The motion of a ball, as variables or as values, and of the bodies coupled to it; that of bodies that are not COUPLED is prescribed.
template <bool DERIVATIVES, bool COUPLED = true>
struct ElementInput {
  const BallState &ball_state;  // its VELOCITY + 1 is the orbit rate
  const BodyState &bodies;
  Pack shaft_speed{};  // [rad/s]
  const CarriedBalls *carried = nullptr;
  const Heights &heights = NO_HEIGHTS;
  const double *direction = nullptr;  // of the housing
  template <int C>
  CORE_INLINE auto ball(Index<C>) const {
    return input<DERIVATIVES, C>(ball_state[C]);
  }
  template <int C>
  CORE_INLINE auto position(Index<C>) const {
    return input < DERIVATIVES && COUPLED, BODY_POSITION + C > (broadcast<Pack>(bodies[C]));
  }
  template <int C>
  CORE_INLINE auto speed(Index<C>) const {
    return input < DERIVATIVES && COUPLED,
           BODY_VELOCITY + C > (C == SHAFT ? shaft_speed : broadcast<Pack>(bodies[COORDINATES + C]));
  }
};

// Action of a raceway in its ring's axes: differentiated by the ball's offset, velocity and spin relative to the ring and by the
// ring's speed, and by the chain rule by the variables of these.
template <bool PATCH, class O, class V, class S, class W>
CORE_INLINE auto ring_contact_action(const Bearing &bearing, const Raceway &raceway, const CarriedContacts *carried,
                                     const Height &height, const O &offset, const V &velocity, const S &spin, const W &speed) {
  auto action = raceway_action<PATCH>(bearing, raceway, carried, height, local<0>(offset), local<3>(velocity), local<6>(spin),
                                      local<9>(speed));
  auto chain = [&](const auto &x) __attribute__((always_inline)) {
    return composed(x, offset.x, offset.y, offset.z, velocity.x, velocity.y, velocity.z, spin.x, spin.y, spin.z, speed);
  };
  auto heights = if_heights_move(height.rate, [&]() __attribute__((always_inline)) { return chain(action.height_power); });
  return BallAction{chain(action.force), chain(action.torque), chain(action.moment), chain(action.loss), heights};
}
template <bool PATCH, class O, class V, class S, class W>
CORE_INLINE auto inner_contact_action(const Bearing &bearing, const CarriedBalls *carried, const Height &height, const O &offset,
                                      const V &velocity, const S &spin, const W &speed) {
  return ring_contact_action<PATCH>(bearing, bearing.inner, carried ? &carried->inner : nullptr, height, offset, velocity, spin,
                                    speed);
}

// The same for a ring of any motion, in the ball's frame: `offset` of the ball's centre and its `velocity` relative to the
// ring's centre, its spin, the ring's tilt (x, y), tilt rate and speed.
template <class A, class X, class Y>
struct TiltedAction {
  A action;
  X moment_x;
  Y moment_y;
};  // moments about the ring's centre, conjugate to its tilts
template <class A, class X, class Y>
TiltedAction(A, X, Y) -> TiltedAction<A, X, Y>;
template <bool PATCH, class O, class V, class S, class T, class R, class W>
CORE_INLINE auto tilted_contact_action(const Bearing &bearing, const CarriedBalls *carried, const Height &height, const O &offset,
                                       const V &velocity, const S &spin, const T &tilt, const R &tilt_rate, const W &speed) {
  auto t = local<10>(tilt), rate = local<13>(tilt_rate);
  auto axes = ring_axes(t.x, t.y);
  auto from_centre = into_ring(axes, local<0>(offset));
  auto action = inner_contact_action<PATCH>(bearing, carried, height, from_centre,
                                            into_ring(axes, local<3>(velocity) - cross(rate, from_centre)),
                                            into_ring(axes, local<6>(spin) - rate), local<9>(speed));
  auto chain = [&](const auto &x) __attribute__((always_inline)) {
    return composed(x, offset.x, offset.y, offset.z, velocity.x, velocity.y, velocity.z, spin.x, spin.y, spin.z, speed, tilt.x,
                    tilt.y, tilt.z, tilt_rate.x, tilt_rate.y, tilt_rate.z);
  };
  auto force = out_of_ring(axes, action.force), torque = out_of_ring(axes, action.torque);
  auto moment = cross(from_centre, force) + torque;
  auto heights = if_heights_move(height.rate, [&]() __attribute__((always_inline)) { return chain(action.height_power); });
  return TiltedAction{BallAction{chain(force), chain(torque), chain(action.moment), chain(action.loss), heights}, chain(moment.x),
                      chain(moment.y)};
}

// A ball between its raceways: all rows but forces on the cage. Newton's and Euler's equations in the frame that turns
// with the ball at its orbit rate about z: to the rates of velocity and angular velocity come the terms -orbit_rate z x (.), the
// centrifugal, Coriolis and gyroscopic effects.
template <RingMotion RING, bool PATCH, class Input, class Put>
CORE_INLINE void raceway_forces(const Bearing &bearing, const Input &in, Put put) {
  constexpr bool MOVES = RING == RingMotion::level || RING == RingMotion::tilting;
  Vector3 position{in.ball(index<RADIUS>), Zero{}, in.ball(index<HEIGHT>)};
  Vector3 spin{in.ball(index<SPIN>), in.ball(index<SPIN + 1>), in.ball(index<SPIN + 2>)};
  auto orbit_rate = in.ball(index<ORBIT_RATE>);
  Vector3 velocity{in.ball(index<VELOCITY>), position.x * orbit_rate, in.ball(index<VELOCITY + 2>)};
  auto shaft_speed = in.speed(index<SHAFT>);
  const CarriedBalls *carried = in.carried;
  auto [cosine, sine] = cosine_sine(in.ball(index<ANGLE>));
  auto c = cosine, s = sine, minus_s = -sine;
  auto in_ball_frame = [&](const auto &v) __attribute__((always_inline)) { return about_z(c, minus_s, v); };

  const CarriedContacts *at_outer = carried ? &carried->outer : nullptr;
  auto outer = [&]() __attribute__((always_inline)) {
    if constexpr (RING == RingMotion::tilting) {
      auto along = in_ball_frame(Vector3{in.direction[0], in.direction[1], in.direction[2]});
      auto action = ring_contact_action<PATCH>(bearing, bearing.outer, at_outer, in.heights.outer,
                                               position - in.position(index<HOUSING>) * along,
                                               velocity - in.speed(index<HOUSING>) * along, spin, broadcast<Pack>(0.0));
      put(index<FORCE_ROW + HOUSING>, -dot(along, action.force));
      return action;
    } else return raceway_action<PATCH>(bearing, bearing.outer, at_outer, in.heights.outer, position, velocity, spin, Zero{});
  }();
  auto finish = [&](const auto &inner) __attribute__((always_inline)) {
    auto force = inner.force + outer.force, torque = inner.torque + outer.torque;
    auto gravity = in_ball_frame(Vector3{bearing.gravity[0], bearing.gravity[1], bearing.gravity[2]});
    double inverse_mass = 1.0 / bearing.ball_mass, inverse_inertia = 1.0 / bearing.ball_inertia;
    put(index<RADIAL_ROW>, inverse_mass * force.x + gravity.x + orbit_rate * velocity.y);
    auto along = force.y + bearing.ball_mass * gravity.y - (2.0 * bearing.ball_mass) * (orbit_rate * velocity.x);
    put(index<ORBIT_ROW>, position.x * along);
    put(index<AXIAL_ROW>, inverse_mass * force.z + gravity.z);
    put(index<SPIN_ROW>, inverse_inertia * torque.x + orbit_rate * spin.y);
    put(index<SPIN_ROW + 1>, inverse_inertia * torque.y - orbit_rate * spin.x);
    put(index<SPIN_ROW + 2>, inverse_inertia * torque.z);
    put(index<POWER_ROW>, shaft_speed * inner.moment + (inner.height_power + outer.height_power));
    put(index<LOSS_ROW>, inner.loss + outer.loss);
    put(index<FORCE_ROW + SHAFT>, -inner.moment);
    if constexpr (MOVES) {
      auto on_ring = about_z(c, s, inner.force);
      put(index<FORCE_ROW + RING_X>, -on_ring.x), put(index<FORCE_ROW + RING_Y>, -on_ring.y);
      put(index<FORCE_ROW + RING_Z>, -on_ring.z);
    }
  };
  auto coordinate = [&](auto free, double held) __attribute__((always_inline)) {
    if constexpr (MOVES) return in.position(free);
    else return held;
  };
  auto rate = [&](auto free) __attribute__((always_inline)) {
    if constexpr (MOVES) return in.speed(free);
    else return Zero{};
  };
  Vector3 centre{coordinate(index<RING_X>, bearing.offset[0]), coordinate(index<RING_Y>, bearing.offset[1]),
                 coordinate(index<RING_Z>, bearing.offset[2])};
  Vector3 drift{rate(index<RING_X>), rate(index<RING_Y>), rate(index<RING_Z>)};
  auto offset = position - in_ball_frame(centre), relative = velocity - in_ball_frame(drift);
  if constexpr (RING == RingMotion::held || RING == RingMotion::level) {
    finish(inner_contact_action<PATCH>(bearing, carried, in.heights.inner, offset, relative, spin, shaft_speed));
  } else {
    auto tilt =
        in_ball_frame(Vector3{coordinate(index<TILT_X>, bearing.tilt[0]), coordinate(index<TILT_Y>, bearing.tilt[1]), Zero{}});
    auto tilt_rate = in_ball_frame(Vector3{rate(index<TILT_X>), rate(index<TILT_Y>), Zero{}});
    auto inner =
        tilted_contact_action<PATCH>(bearing, carried, in.heights.inner, offset, relative, spin, tilt, tilt_rate, shaft_speed);
    finish(inner.action);
    if constexpr (MOVES) {
      auto moment = about_z(c, s, Vector3{inner.moment_x, inner.moment_y, Zero{}});
      put(index<FORCE_ROW + TILT_X>, -moment.x), put(index<FORCE_ROW + TILT_Y>, -moment.y);
    }
  }
}

// Balls in the pockets of a cage: a ball further than half the clearance from the middle of its pocket presses on a wall, and
// friction acts on its surface there, a ball radius ahead or behind. Steps end where a ball reaches a wall or leaves it, and
// likewise a cage its land, as forces have a kink there that the error estimate does not resolve.

// Load [N], loss [W], and friction on the ball along the pocket's radius and along the axis [N], from the slip there.
template <class A, class R, class S, class T>
CORE_INLINE auto wall_action(const Bearing &bearing, const Wall &wall, const A &approach, const R &rate, const S &radial,
                             const T &axial) {
  auto [elastic, load] = wall_load(wall, approach, rate);
  auto square = radial * radial + axial * axial;
  auto resistance = point_resistance(wall.friction * load, square, bearing.regularisation);
  return std::tuple{load, resistance * square + (load - elastic) * rate, -(resistance * radial), -(resistance * axial)};
}

// Approach of balls to a wall of their pockets [m], its rate [m/s], and whether that is the one ahead (1) or behind (-1).
struct PocketGap {
  Pack approach, rate, side;
};

CORE_INLINE Pack pocket_side(const Pack &ahead) { return select(ahead >= 0.0, broadcast<Pack>(1.0), broadcast<Pack>(-1.0)); }

// Rows of a ball in its pocket, whose walls are flat, across its tangent, and open along its radius; its gap to the walls. The centre
// of a guided cage moves.
template <bool GUIDED, bool DERIVATIVES, class Put>
CORE_INLINE PocketGap pocket_forces(const Bearing &bearing, const Pockets &pockets, const Pack &pocket,
                                    const ElementInput<DERIVATIVES> &in, Put put) {
  auto position = [&](auto coordinate) __attribute__((always_inline)) {
    if constexpr (GUIDED) return in.position(coordinate);
    else return Zero{};
  };
  auto speed = [&](auto coordinate) __attribute__((always_inline)) {
    if constexpr (GUIDED) return in.speed(coordinate);
    else return Zero{};
  };
  auto radius = in.ball(index<RADIUS>), angle = in.ball(index<ANGLE>);
  auto cage_speed = in.speed(index<CAGE_ANGLE>);
  auto [cosine, sine] = cosine_sine(angle);
  auto [c, s] = cosine_sine((angle - in.position(index<CAGE_ANGLE>)) - pocket);
  auto orbit_cosine = cosine, orbit_sine = sine, minus_sine = -sine, across_c = c, across_s = s;
  auto centre = about_z(orbit_cosine, minus_sine, Vector3{position(index<CAGE_X>), position(index<CAGE_Y>), Zero{}});
  auto drift = about_z(orbit_cosine, minus_sine, Vector3{speed(index<CAGE_X>), speed(index<CAGE_Y>), Zero{}});
  auto x = radius - centre.x, y = -centre.y;
  auto along = x * across_s + y * across_c, out = x * across_c - y * across_s;
  auto u = in.ball(index<VELOCITY>) - drift.x, v = radius * in.ball(index<ORBIT_RATE>) - drift.y;
  auto spin_x = in.ball(index<SPIN>), spin_y = in.ball(index<SPIN + 1>), spin_z = in.ball(index<SPIN + 2>);
  Pack side = pocket_side(value_of(along)), lever = bearing.ball_radius * side;
  auto rate = side * (u * across_s + v * across_c - cage_speed * out);
  auto approach = side * along - pockets.half_clearance;
  auto [load, loss, radial, axial] = wall_action(bearing, pockets.wall, approach, rate,
                                                 u * across_c - v * across_s - lever * spin_z + cage_speed * (along + lever),
                                                 in.ball(index<VELOCITY + 2>) + lever * (spin_x * across_c - spin_y * across_s));
  auto push = -side * load;
  auto force_x = push * across_s + radial * across_c, force_y = push * across_c - radial * across_s;
  double inverse_mass = 1.0 / bearing.ball_mass, inverse_inertia = 1.0 / bearing.ball_inertia;
  auto turned = (inverse_inertia * lever) * axial;
  put(index<RADIAL_ROW>, inverse_mass * force_x), put(index<ORBIT_ROW>, radius * force_y);
  put(index<AXIAL_ROW>, inverse_mass * axial), put(index<LOSS_ROW>, loss);
  put(index<SPIN_ROW>, turned * across_c), put(index<SPIN_ROW + 1>, -(turned * across_s));
  put(index<SPIN_ROW + 2>, (-inverse_inertia * lever) * radial);
  if constexpr (GUIDED) {
    put(index<FORCE_ROW + CAGE_X>, orbit_sine * force_y - orbit_cosine * force_x);
    put(index<FORCE_ROW + CAGE_Y>, -(orbit_sine * force_x) - orbit_cosine * force_y);
  }
  put(index<FORCE_ROW + CAGE_ANGLE>, (along + lever) * radial - out * push);
  return {value_of(approach), value_of(rate), side};
}

template <bool DERIVATIVES, class Put>
CORE_INLINE PocketGap cage_pocket(const Bearing &bearing, const CoupledBodies &b, const Pack &pocket,
                                  const ElementInput<DERIVATIVES> &in, Put put) {
  return b.guided ? pocket_forces<true>(bearing, b.pockets, pocket, in, put)
                  : pocket_forces<false>(bearing, b.pockets, pocket, in, put);
}

namespace walls {

constexpr double INFINITE_TIME = 1e30, LEAST_DISTANCE = 1e-30;  // s, m
constexpr double MARGIN = 0.5;  // of the approach at which the unresolved stiffness of a wall makes an error of one scale
constexpr double FIRST_DEPTH = 0.2;  // of ONSET: the approach to a wall in the first step there

// Time [s] until a wall at this approach [m] and rate [m/s] is reached or left; where the approach is below 0, `acceleration`
// [m/s^2] is that of the approach. The load of a wall decreases about linearly.
inline double time_to_kink(const Wall &wall, double mass, double blur, double approach, double rate, double acceleration) {
  double margin = MARGIN * std::sqrt(blur * std::fabs(rate));
  if (approach < 0.0) {
    double distance = margin - approach, square = rate * rate + 2.0 * acceleration * distance;
    double speed = rate + std::sqrt(std::max(square, 0.0));
    return square >= 0.0 && speed > 0.0 ? 2.0 * distance / speed : INFINITE_TIME;
  }
  double viscous = wall.relaxation_time * rate * approach / (approach + ONSET);
  if (rate >= 0.0 || approach + viscous <= 0.0) return INFINITE_TIME;
  // The viscous part cancels the elastic one where the approach is T |rate| - ONSET.
  double distance = approach - std::max(-wall.relaxation_time * rate - ONSET, 0.0) + margin;
  double push = wall.stiffness * (approach + viscous) / (3.0 * mass);
  return 2.0 * distance / (std::sqrt(rate * rate + 4.0 * push * distance) - rate);
}

// The next step, and the least one after it [s].
struct StepLimit {
  double step, least_next;
};

// Reduced mass [kg] of a ball and the cage.
inline double reduced_mass(const Bearing &bearing, const CoupledBodies &b) {
  double inverse = 1.0 / bearing.ball_mass + b.pockets.radius * b.pockets.radius / b.inertia[CAGE_ANGLE];
  return 1.0 / (b.guided ? inverse + 1.0 / b.inertia[CAGE_X] : inverse);
}

// The same of positions, velocities or accelerations, which begin at `first` of a state.
inline auto relative_to_land(const CoupledBodies &b, const BodyState &state, int first) {
  return core::relative_to_land(b, [&](int c) { return state[first + c]; });
}

inline StepLimit limit_at_land(const CoupledBodies &b, const BodyState &body_state, double acceleration, double uncut,
                               const StepLimit &limit) {
  auto [x, y] = relative_to_land(b, body_state, 0);
  auto [u, v] = relative_to_land(b, body_state, COORDINATES);
  double distance = std::sqrt(x * x + y * y) + LEAST_DISTANCE, rate = (x * u + y * v) / distance, turn = (x * v - y * u) / distance;
  double inverse = 1.0 / b.inertia[CAGE_X] + (b.land.side < 0.0 && b.free[RING_X] ? 1.0 / b.inertia[RING_X] : 0.0);
  double blur = b.velocity_scale[CAGE_X] / (inverse * b.land.wall.stiffness), approach = distance - b.land.clearance;
  double kink = time_to_kink(b.land.wall, 1.0 / inverse, blur, approach, rate, turn * turn / distance + acceleration);
  if (!(kink < limit.step)) return limit;
  return {kink, std::min(uncut, approach < 0.0 ? FIRST_DEPTH * ONSET / rate : INFINITE_TIME)};
}

// Acceleration of the cage's centre towards its land [m/s^2], without the centripetal one.
inline double land_acceleration(const CoupledBodies &b, const BodyState &body_state, const BodyState &rates) {
  auto [x, y] = relative_to_land(b, body_state, 0);
  auto [along, across] = relative_to_land(b, rates, COORDINATES);
  return (x * along + y * across) / (std::sqrt(x * x + y * y) + LEAST_DISTANCE);
}

constexpr double LEAST_WEIGHT = 0.1;  // of errors along the groove of an unloaded ball

// Weight of errors along the groove of a ball with these approaches at the outer raceway: about proportional to its load.
CORE_INLINE Pack groove_error_weight(const Pack &begin, const Pack &end, double light) {
  Pack fraction = minimum(maximum(maximum(begin, end) * (1.0 / light), 0.0), 1.0);
  return maximum(fraction * square_root(fraction), LEAST_WEIGHT);
}

}  // namespace walls

}  // namespace core
