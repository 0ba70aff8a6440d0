// The bodies that all balls of a bearing meet: inner ring, cage and shaft. Each coordinate is free, where it follows from
// the forces on it, or held; the shaft's angle that is not free is prescribed.
//
// Ring: M dv/dt = load + weight + unbalance + what the balls do - D v - K (q - rest), and about its diameters, at the
// speed W of the shaft, I_t d2(theta_x) + I_p W d(theta_y) = M_x, I_t d2(theta_y) - I_p W d(theta_x) = M_y (small tilts).
// Shaft: J dw/dt = torque - damping w + what balls and land do.
#pragma once
#include "ball_raceway.hpp"

namespace core {

// Places [m], [rad] in bearing_link; a state holds them, their velocities, and integrals that only listen.
enum Coordinate { RING_X, RING_Y, RING_Z, TILT_X, TILT_Y, CAGE_X, CAGE_Y, CAGE_ANGLE, SHAFT };
constexpr int COORDINATES = SHAFT + 1;
// Work of the loads on the ring, what support and land lose, work of the drive through the land, work of the torque [J].
enum Integral { LOAD_WORK, LOST, LAND_WORK, TORQUE_WORK };
constexpr int INTEGRALS = TORQUE_WORK + 1, BODY_NUMBERS = 2 * COORDINATES + INTEGRALS;
using BodyState = std::array<double, BODY_NUMBERS>;

// What balls meet: a ring that is held, held and tilted, that moves and does not tilt, or moves and tilts.
enum class RingMotion { held, tilted, level, tilting };
enum class CageKind { none, even, pockets };

// A wall of the cage: a spring and a damper side by side, whose viscous part sets in over the roughness of the wall.
struct Wall { double stiffness, relaxation_time, friction; };
constexpr double ONSET = 1e-6;  // m

struct Pockets { double radius, half_clearance; Wall wall; };  // on a circle of this radius [m]
// The land of the outer ring (side 1) or the inner (-1) that guides a cage; 0 without one.
struct Land { double side, radius, clearance, smoothing; Wall wall; };

struct CoupledBodies {
  RingMotion ring;
  CageKind cage;
  bool free[COORDINATES], guided;  // a guided cage's centre moves
  double inertia[COORDINATES], stiffness[COORDINATES], damping[COORDINATES], rest[COORDINATES], weight[COORDINATES];
  double load[COORDINATES], load_rate[COORDINATES];  // at the chunk's begin [N], [N m], and its growth a second
  double place_scale[COORDINATES], speed_scale[COORDINATES];  // errors that a step may make; 0: not judged
  double polar_inertia, unbalance, phase;  // [kg m^2]; mass times radius [kg m], its angle ahead of the shaft's [rad]
  Pockets pockets;
  double light;  // approach [m] at the outer raceway below which errors along the orbit count less
  Land land;
  double shaft_angle, shaft_speed, shaft_acceleration;  // prescribed, at the chunk's begin
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

// The land of a ring that guides a cage, two round surfaces in the plane across the axis; `add` as for `body_forces`.
template <class P, class V, class Add>
inline void land_forces(const CoupledBodies &b, P place, V velocity, Add add) {
  bool inner = b.land.side < 0.0;
  double moves = inner ? 1.0 : 0.0;
  auto off = [&]<int C, int R>(const auto &of) { return of.template operator()<C>() - moves * of.template operator()<R>(); };
  auto x = off.template operator()<CAGE_X, RING_X>(place), y = off.template operator()<CAGE_Y, RING_Y>(place);
  auto u = off.template operator()<CAGE_X, RING_X>(velocity), v = off.template operator()<CAGE_Y, RING_Y>(velocity);
  auto square = x * x + y * y;
  if (!(std::sqrt(value_of(square)) > b.land.clearance)) return;
  auto [distance, inverse] = root_and_inverse(square);
  auto along = x * inverse, across = y * inverse;
  auto rate = along * u + across * v;
  auto [elastic, load] = wall_load(b.land.wall, distance - b.land.clearance, rate);
  auto lever = b.land.side * b.land.radius - distance;  // from the cage's centre to where they touch
  auto ring_speed = moves * velocity.template operator()<SHAFT>();
  auto slip = along * v - across * u + velocity.template operator()<CAGE_ANGLE>() * lever - b.land.side * b.land.radius * ring_speed;
  auto drag = -(b.land.wall.friction * load) * slip * root_and_inverse(slip * slip + b.land.smoothing * b.land.smoothing).second;
  auto force_x = -(load * along) - drag * across, force_y = drag * along - load * across;
  auto ring_torque = -(b.land.side * b.land.radius) * drag;
  add.template operator()<CAGE_X>(force_x), add.template operator()<CAGE_Y>(force_y), add.template operator()<CAGE_ANGLE>(lever * drag);
  add.template operator()<COORDINATES + LOST>((load - elastic) * rate - drag * slip);
  if (!inner) return;
  if (b.free[RING_X]) add.template operator()<RING_X>(-force_x);
  if (b.free[RING_Y]) add.template operator()<RING_Y>(-force_y);
  add.template operator()<SHAFT>(ring_torque);
  add.template operator()<COORDINATES + LAND_WORK>(-(ring_speed * ring_torque));
}

// Forces on the coordinates but for those of the balls, and powers of the integrals. `add`<ROW> takes a part of the force
// on coordinate ROW, or of the power of integral ROW - COORDINATES. Where DERIVATIVES, its columns are those of `y`.
template <bool DERIVATIVES, class Add>
inline void body_forces(const CoupledBodies &b, double time, const BodyState &y, Add add) {
  auto place = [&]<int C>() { return input<DERIVATIVES, C>(y[C]); };
  auto velocity = [&]<int C>() { return input<DERIVATIVES, COORDINATES + C>(y[COORDINATES + C]); };
  auto shaft_speed = velocity.template operator()<SHAFT>();
  auto on_ring = [&]<int C>() {
    if (!b.free[C]) return;
    auto speed = velocity.template operator()<C>();
    double load = b.load[C] + time * b.load_rate[C];
    auto drag = b.damping[C] * speed;
    add.template operator()<C>(load + b.weight[C] - drag - b.stiffness[C] * (place.template operator()<C>() - b.rest[C]));
    add.template operator()<COORDINATES + LOAD_WORK>(load * speed);
    add.template operator()<COORDINATES + LOST>(drag * speed);
  };
  on_ring.template operator()<RING_X>(), on_ring.template operator()<RING_Y>(), on_ring.template operator()<RING_Z>();
  on_ring.template operator()<TILT_X>(), on_ring.template operator()<TILT_Y>();
  if (b.polar_inertia != 0.0) {
    auto spin = b.polar_inertia * shaft_speed;
    if (b.free[TILT_X]) add.template operator()<TILT_X>(-(spin * velocity.template operator()<TILT_Y>()));
    if (b.free[TILT_Y]) add.template operator()<TILT_Y>(spin * velocity.template operator()<TILT_X>());
  }
  if (b.unbalance != 0.0) {
    auto [cosine, sine] = cosine_sine(place.template operator()<SHAFT>() + b.phase);
    auto size = b.unbalance * (shaft_speed * shaft_speed);
    auto turning = [&]<int C>(const auto &part) {
      if (!b.free[C]) return;
      auto force = size * part;
      add.template operator()<C>(force);
      add.template operator()<COORDINATES + LOAD_WORK>(force * velocity.template operator()<C>());
    };
    turning.template operator()<RING_X>(cosine), turning.template operator()<RING_Y>(sine);
  }
  if (b.guided) {
    add.template operator()<CAGE_X>(b.weight[CAGE_X]), add.template operator()<CAGE_Y>(b.weight[CAGE_Y]);
    land_forces(b, place, velocity, add);
  }
  if (b.free[SHAFT]) {
    double torque = b.load[SHAFT] + time * b.load_rate[SHAFT];
    auto drag = b.damping[SHAFT] * shaft_speed;
    add.template operator()<SHAFT>(torque - drag);
    add.template operator()<COORDINATES + TORQUE_WORK>(torque * shaft_speed);
    add.template operator()<COORDINATES + LOST>(drag * shaft_speed);
  }
}

}  // namespace core
