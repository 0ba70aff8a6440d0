// A ball and the next ahead: their contact, and which may meet. Balls never pass each other in the groove, so neighbours stay such.
#pragma once
#include <cstdint>
#include <vector>
#include "raceway_contact.hpp"

namespace core {

// Their contact: sphere on sphere by Hertz, damping as on the raceways, friction at the contact point.

// In the first ball's frame: `between` from its centre to the other's [m], `velocity` [m/s] against the other's centre,
// `spin` [rad/s] the sum of both. Loads act on the first ball; on the other the force is the opposite, the torque about
// its centre the same. `energy` [J] and `loss` [W] are of both.
template <class A, class N, class R, class L, class S, class F, class G, class T, class E, class D>
struct PairContact {
  A approach;
  N normal;
  R arm;
  L normal_load;
  S slip;
  F friction;
  G force;
  T torque;
  E energy;
  D loss;
};
template <class A, class N, class R, class L, class S, class F, class G, class T, class E, class D>
PairContact(A, N, R, L, S, F, G, T, E, D) -> PairContact<A, N, R, L, S, F, G, T, E, D>;

template <class B, class V, class W>
CORE_INLINE auto pair_contact(const Bearing &bearing, const B &between, const V &velocity, const W &spin) {
  auto [distance, inverse] = root_and_inverse(dot(between, between) + 1e-300);
  auto approach = 2.0 * bearing.ball_radius - distance;
  auto normal = inverse * between;
  auto arm = 0.5 * between;
  auto relative = velocity + cross(spin, arm);
  auto approach_rate = dot(relative, normal);
  auto slip = relative - approach_rate * normal;
  auto [load, stiffness, energy] = elastic(bearing.pair_coefficient, HERTZIAN, approach);
  auto normal_load = maximum(proportional_load(load, stiffness, approach_rate, bearing.damping, bearing.relaxation_time), 0.0);
  auto square = dot(slip, slip);
  auto resistance = point_resistance(bearing.pair_friction * normal_load, square, bearing.regularisation);
  auto friction = (-resistance) * slip;
  return PairContact{approach,
                     normal,
                     arm,
                     normal_load,
                     slip,
                     friction,
                     friction - normal_load * normal,
                     cross(arm, friction),
                     energy,
                     resistance * square + (normal_load - load) * approach_rate};
}

// The contact of ball k with the next ahead, in the frame of ball k, and cosine and sine of the angle between both;
// `get(ball, column)` is a number of a ball's state.
template <class Get>
CORE_INLINE auto contact_with_next(const Bearing &bearing, int ball, int next, Get get) {
  auto vector = [&](int k, int first) { return Vector3{get(k, first), get(k, first + 1), get(k, first + 2)}; };
  auto position = [&](int k) { return Vector3{get(k, RADIUS), 0.0, get(k, HEIGHT)}; };
  double angle = get(next, ANGLE) - get(ball, ANGLE), c = std::cos(angle), s = std::sin(angle);
  auto contact = pair_contact(bearing, about_z(c, s, position(next)) - position(ball),
                              vector(ball, VELOCITY) - about_z(c, s, vector(next, VELOCITY)),
                              vector(ball, SPIN) + about_z(c, s, vector(next, SPIN)));
  return std::tuple{contact, c, s};
}

namespace neighbours {

struct Row {
  const double *state;  // (balls, COLUMNS)
  int balls;

  const double *ball(int k) const { return state + k * COLUMNS; }
  // Orbit angle [rad] from ball k to the next ahead.
  double angle_ahead(int k) const {
    double angle = ball(k + 1 < balls ? k + 1 : 0)[ANGLE] - ball(k)[ANGLE];
    return k + 1 < balls ? angle : angle + 2.0 * M_PI;
  }
};

struct Meeting {
  double gap, closing;
};

// Gap [m] from ball k to the next ahead, and twice the speed [m/s] at which their orbits close it. A gap that cannot
// close, because there is no other ball or the way round is the longer one, is infinite; one that the ball has passed
// through is below minus its diameter.
inline Meeting meeting(double ball_radius, const Row &row, int k) {
  double angle = row.angle_ahead(k);
  if (row.balls == 1 || (row.balls == 2 && angle > M_PI)) return {HUGE_VAL, 0.0};
  const double *ball = row.ball(k), *next = row.ball(k + 1 < row.balls ? k + 1 : 0);
  double x = std::cos(angle) * next[RADIUS] - ball[RADIUS], y = std::sin(angle) * next[RADIUS], z = next[HEIGHT] - ball[HEIGHT];
  return {std::copysign(std::sqrt(x * x + y * y + z * z), angle) - 2.0 * ball_radius,
          2.0 * std::fabs(next[VELOCITY + 1] - ball[VELOCITY + 1])};
}

// Sets near[k] where ball k and the next ahead may come closer than `reach` [m] within `ahead` [s].
inline void mark_near(double ball_radius, const Row &row, double reach, double ahead, std::uint8_t *near) {
  for (int k = 0; k < row.balls; k++) {
    Meeting approaching = meeting(ball_radius, row, k);
    near[k] = approaching.gap < reach + ahead * approaching.closing;
  }
}

// Sets near[k] where ball k was closer than `reach` [m] to the next ahead, in `row` or in any of the states (instants,
// balls, COLUMNS); returns whether any was not set yet.
inline bool mark_met(double ball_radius, const Row &row, const double *states, int instants, double reach, std::uint8_t *near) {
  bool any_new = false;
  for (int k = 0; k < row.balls; k++) {
    Row closest = row;
    double least_angle = row.angle_ahead(k);
    for (int i = 0; i < instants; i++) {
      Row later{states + long(i) * row.balls * COLUMNS, row.balls};
      if (double angle = later.angle_ahead(k); angle < least_angle) closest = later, least_angle = angle;
    }
    if (meeting(ball_radius, closest, k).gap < reach) any_new |= !near[k], near[k] = 1;
  }
  return any_new;
}

// Seconds for which no two balls can come closer than `reach` [m], by their present speeds.
inline double time_apart(double ball_radius, const Row &row, double reach) {
  double least_time = HUGE_VAL;
  for (int k = 0; k < row.balls; k++) {
    Meeting approaching = meeting(ball_radius, row, k);
    least_time = std::min(least_time, std::max(approaching.gap - reach, 0.0) / (approaching.closing + 1e-300));
  }
  return least_time;
}

}  // namespace neighbours
}  // namespace core
