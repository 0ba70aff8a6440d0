// Balls in the pockets of a cage: a wall pushes a ball back that is further than half the clearance from the middle of
// its pocket, and friction acts on the ball's surface there, a ball radius ahead or behind. Steps end where a ball meets
// a wall or leaves it, and where a cage does so with its land, as forces have a bend there that no error estimate sees.
#pragma once
#include "coupled_elements.hpp"

namespace core {

// Load [N], loss [W], and friction on the ball along the pocket's radius and along the axis [N], from the slip there.
template <class A, class R, class S, class T>
CORE_INLINE auto wall_action(const Bearing &bearing, const Wall &wall, const A &approach, const R &rate, const S &radial, const T &axial) {
  auto [elastic, load] = wall_load(wall, approach, rate);
  auto square = radial * radial + axial * axial;
  auto resistance = point_resistance(wall.friction * load, square, bearing.regularisation);
  return std::tuple{load, resistance * square + (load - elastic) * rate, -(resistance * radial), -(resistance * axial)};
}

CORE_INLINE Pack side_of_pocket(const Pack &ahead) { return select(ahead >= 0.0, broadcast<Pack>(1.0), broadcast<Pack>(-1.0)); }

// A cage whose centre stays: the ball leaves the middle of its pocket along the pitch circle.
template <bool DERIVATIVES, class Give>
CORE_INLINE void in_pocket(const Bearing &bearing, const Pockets &pockets, const Pack &pocket, const ElementInput<DERIVATIVES> &in, Give give) {
  auto ahead = (in.template own<ANGLE>() - in.template place<CAGE_ANGLE>()) - pocket;
  auto cage_speed = in.template speed<CAGE_ANGLE>();
  Pack side = side_of_pocket(value_of(ahead)), arc = pockets.radius * side, lever = bearing.ball_radius * side;
  auto rate = arc * (in.template own<ORBIT_RATE>() - cage_speed);
  auto [load, loss, radial, axial] = wall_action(
      bearing, pockets.wall, arc * ahead - pockets.half_clearance, rate,
      in.template own<VELOCITY>() - lever * (in.template own<SPIN + 2>() - cage_speed),
      in.template own<VELOCITY + 2>() + lever * in.template own<SPIN>());
  double over_mass = 1.0 / bearing.ball_mass, over_inertia = 1.0 / bearing.ball_inertia;
  auto push = arc * load;
  give.template operator()<RADIAL_ROW>(over_mass * radial), give.template operator()<AXIAL_ROW>(over_mass * axial);
  give.template operator()<ORBIT_ROW>(-push), give.template operator()<LOSS_ROW>(loss);
  give.template operator()<SPIN_ROW>((over_inertia * lever) * axial);
  give.template operator()<SPIN_ROW + 2>((-over_inertia * lever) * radial);
  give.template operator()<ON_BODY + CAGE_ANGLE>(push + lever * radial);
}

// A cage whose centre moves: the pocket's walls are flat, across its tangent, and open along its radius.
template <bool DERIVATIVES, class Give>
CORE_INLINE void in_moving_pocket(const Bearing &bearing, const Pockets &pockets, const Pack &pocket, const ElementInput<DERIVATIVES> &in, Give give) {
  auto radius = in.template own<RADIUS>(), angle = in.template own<ANGLE>();
  auto cage_speed = in.template speed<CAGE_ANGLE>();
  auto [cosine, sine] = cosine_sine(angle);
  auto [c, s] = cosine_sine((angle - in.template place<CAGE_ANGLE>()) - pocket);
  auto orbit_cosine = cosine, orbit_sine = sine, minus_sine = -sine, across_c = c, across_s = s;
  auto centre = about_z(orbit_cosine, minus_sine, Vector3{in.template place<CAGE_X>(), in.template place<CAGE_Y>(), Zero{}});
  auto drift = about_z(orbit_cosine, minus_sine, Vector3{in.template speed<CAGE_X>(), in.template speed<CAGE_Y>(), Zero{}});
  auto x = radius - centre.x, y = -centre.y;
  auto along = x * across_s + y * across_c, out = x * across_c - y * across_s;
  auto u = in.template own<VELOCITY>() - drift.x, v = radius * in.template own<ORBIT_RATE>() - drift.y;
  auto spin_x = in.template own<SPIN>(), spin_y = in.template own<SPIN + 1>(), spin_z = in.template own<SPIN + 2>();
  Pack side = side_of_pocket(value_of(along)), lever = bearing.ball_radius * side;
  auto rate = side * (u * across_s + v * across_c - cage_speed * out);
  auto [load, loss, radial, axial] = wall_action(
      bearing, pockets.wall, side * along - pockets.half_clearance, rate,
      u * across_c - v * across_s - lever * spin_z + cage_speed * (along + lever),
      in.template own<VELOCITY + 2>() + lever * (spin_x * across_c - spin_y * across_s));
  auto push = -side * load;
  auto force_x = push * across_s + radial * across_c, force_y = push * across_c - radial * across_s;
  double over_mass = 1.0 / bearing.ball_mass, over_inertia = 1.0 / bearing.ball_inertia;
  auto turned = (over_inertia * lever) * axial;
  give.template operator()<RADIAL_ROW>(over_mass * force_x), give.template operator()<ORBIT_ROW>(radius * force_y);
  give.template operator()<AXIAL_ROW>(over_mass * axial), give.template operator()<LOSS_ROW>(loss);
  give.template operator()<SPIN_ROW>(turned * across_c), give.template operator()<SPIN_ROW + 1>(-(turned * across_s));
  give.template operator()<SPIN_ROW + 2>((-over_inertia * lever) * radial);
  give.template operator()<ON_BODY + CAGE_X>(orbit_sine * force_y - orbit_cosine * force_x);
  give.template operator()<ON_BODY + CAGE_Y>(-(orbit_sine * force_x) - orbit_cosine * force_y);
  give.template operator()<ON_BODY + CAGE_ANGLE>((along + lever) * radial - out * push);
}

namespace walls {

constexpr double NEVER = 1e30, NOWHERE = 1e-30;  // s, m
constexpr double BEHIND = 0.5;  // of the approach that makes a ball err by all its scale where the stiffness is not known of
constexpr double FIRST = 0.2;  // of ONSET: what a ball may go into a wall in the first step there

struct Gap { double approach, rate, side; };  // to a wall [m], [m/s]; the wall ahead (1) or behind (-1)

// Of a ball whose motion is `y`, its orbit rate in place of the tangential velocity.
inline Gap gap_of(const CoupledBodies &bodies, const double *y, double pocket, const BodyState &e) {
  double ahead = y[ANGLE] - e[CAGE_ANGLE] - pocket, speed = e[COORDINATES + CAGE_ANGLE];
  if (!bodies.guided) {
    double side = ahead >= 0.0 ? 1.0 : -1.0;
    return {bodies.pockets.radius * std::fabs(ahead) - bodies.pockets.half_clearance, side * bodies.pockets.radius * (y[ORBIT_RATE] - speed), side};
  }
  double c = std::cos(y[ANGLE]), s = std::sin(y[ANGLE]), cosine = std::cos(ahead), sine = std::sin(ahead);
  const double *drift = e.data() + COORDINATES;
  double x = y[RADIUS] - (c * e[CAGE_X] + s * e[CAGE_Y]), across = s * e[CAGE_X] - c * e[CAGE_Y];
  double u = y[VELOCITY] - (c * drift[CAGE_X] + s * drift[CAGE_Y]);
  double v = y[RADIUS] * y[ORBIT_RATE] - (c * drift[CAGE_Y] - s * drift[CAGE_X]);
  double along = x * sine + across * cosine, side = along >= 0.0 ? 1.0 : -1.0;
  double rate = side * (u * sine + v * cosine - speed * (x * cosine - across * sine));
  return {side * along - bodies.pockets.half_clearance, rate, side};
}

// Seconds until a wall is met or left behind; where the approach is below 0, `growth` [m/s^2] is that of the rate. The
// push of a wall falls off about evenly.
inline double next_bend(const Wall &wall, double mass, double blur, const Gap &gap, double growth) {
  double margin = BEHIND * std::sqrt(blur * std::fabs(gap.rate));
  if (gap.approach < 0.0) {
    double far = margin - gap.approach, square = gap.rate * gap.rate + 2.0 * growth * far;
    double speed = gap.rate + std::sqrt(std::max(square, 0.0));
    return square >= 0.0 && speed > 0.0 ? 2.0 * far / speed : NEVER;
  }
  double share = wall.relaxation_time * gap.rate * gap.approach / (gap.approach + ONSET);
  if (gap.rate >= 0.0 || gap.approach + share <= 0.0) return NEVER;
  // The viscous part draws back as much as the spring pushes where the approach is T |rate| - ONSET.
  double far = gap.approach - std::max(-wall.relaxation_time * gap.rate - ONSET, 0.0) + margin;
  double push = wall.stiffness * (gap.approach + share) / (3.0 * mass);
  return 2.0 * far / (std::sqrt(gap.rate * gap.rate + 4.0 * push * far) - gap.rate);
}

// A coming step, and the least one to go on with after it [s].
struct Cut { double step, resume; };

// The mass [kg] by which a ball and the cage are pushed apart.
inline double mass_between(const Bearing &bearing, const CoupledBodies &b) {
  double inverse = 1.0 / bearing.ball_mass + b.pockets.radius * b.pockets.radius / b.inertia[CAGE_ANGLE];
  return 1.0 / (b.guided ? inverse + 1.0 / b.inertia[CAGE_X] : inverse);
}

inline Cut cut_at_land(const CoupledBodies &b, const BodyState &e, double closing, double wanted, const Cut &cut) {
  double inner = b.land.side < 0.0 ? 1.0 : 0.0;
  auto off = [&](int first) { return std::pair{e[first + CAGE_X] - inner * e[first + RING_X], e[first + CAGE_Y] - inner * e[first + RING_Y]}; };
  auto [x, y] = off(0);
  auto [u, v] = off(COORDINATES);
  double distance = std::sqrt(x * x + y * y) + NOWHERE, rate = (x * u + y * v) / distance, turn = (x * v - y * u) / distance;
  double inverse = 1.0 / b.inertia[CAGE_X] + inner * b.free[RING_X] / b.inertia[RING_X];
  double blur = b.speed_scale[CAGE_X] / (inverse * b.land.wall.stiffness);
  Gap gap{distance - b.land.clearance, rate, 1.0};
  double until = next_bend(b.land.wall, 1.0 / inverse, blur, gap, turn * turn / distance + closing);
  if (!(until < cut.step)) return cut;
  return {until, std::min(wanted, gap.approach < 0.0 ? FIRST * ONSET / rate : NEVER)};
}

// How fast the cage's centre comes to move towards its land [m/s^2], its way round it left out.
inline double land_closing(const CoupledBodies &b, const BodyState &e, const BodyState &rates) {
  double inner = b.land.side < 0.0 ? 1.0 : 0.0, x = e[CAGE_X] - inner * e[RING_X], y = e[CAGE_Y] - inner * e[RING_Y];
  const double *growth = rates.data() + COORDINATES;
  double along = growth[CAGE_X] - inner * growth[RING_X], across = growth[CAGE_Y] - inner * growth[RING_Y];
  return (x * along + y * across) / (std::sqrt(x * x + y * y) + NOWHERE);
}

constexpr double LEAST_WEIGHT = 0.1;  // of errors along the groove of a ball that carries next to nothing

// How much errors along the groove count of a ball with these approaches at the outer raceway: nearly as its load.
CORE_INLINE Pack weight_of_light(const Pack &begin, const Pack &end, double light) {
  Pack share = minimum(maximum(maximum(begin, end) * (1.0 / light), 0.0), 1.0);
  return maximum(share * square_root(share), LEAST_WEIGHT);
}

}  // namespace walls
}  // namespace core
