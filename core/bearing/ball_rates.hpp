// Newton's and Euler's equations of a ball between two raceways, and their derivatives by its motion.
#pragma once
#include "../math/linear.hpp"
#include "../methods/rosenbrock.hpp"
#include "elements.hpp"

namespace core {

// In the frame that turns with the ball at its orbit rate about z, velocity and angular velocity gain the terms
// -orbit_rate z x (.): the centrifugal, Coriolis and gyroscopic effects.

// A ball between rings whose motion is prescribed, with its tangential velocity as a variable.
template <bool DERIVATIVES>
struct BallInput {
  const Bearing &bearing;
  const BallState &ball;
  const Pack &ring_speed;
  const CarriedBalls *carried;
  const Heights &heights;
  template <int C> CORE_INLINE auto own(Index<C>) const { return input<DERIVATIVES, C>(ball[C]); }
  CORE_INLINE double place(int c) const { return c < TILT_X ? bearing.offset[c] : bearing.tilt[c - TILT_X]; }
  CORE_INLINE Pack speed(int) const { return ring_speed; }
  CORE_INLINE auto orbit_rate() const { return own(index<VELOCITY + 1>) / own(index<RADIUS>); }
  CORE_INLINE auto velocity() const { return Vector3{own(index<VELOCITY>), own(index<VELOCITY + 1>), own(index<VELOCITY + 2>)}; }
  template <class F, class R>
  CORE_INLINE auto along_orbit(const Bearing &, const F &force, const R &rate) const {
    return (1.0 / bearing.ball_mass) * force - rate * own(index<VELOCITY>);
  }
};

// Angular velocity [rad/s] against the frame that turns with the ball.
CORE_INLINE Triple spin_in_frame(const BallState &y) { return {y[SPIN], y[SPIN + 1], y[SPIN + 2] - y[VELOCITY + 1] / y[RADIUS]}; }

// Partial derivatives of a ball's rates by its motion: rows are those of elements.
struct BallJacobian { Pack orbit_by_radius, orbit_by_velocity, power_sign, row[ON_BODY][MOTION]; };

// `carried` is null where the law carries nothing; `j` is filled where DERIVATIVES.
template <bool PATCH, bool TILTED, bool DERIVATIVES>
CORE_INLINE void evaluate_ball(const Bearing &bearing, const Pack &ring_speed, const CarriedBalls *carried, const Heights &heights,
                               const BallState &y, BallState &rates, BallJacobian *j) {
  auto give = [&]<int ROW>(Index<ROW>, const auto &x) __attribute__((always_inline)) {
    if constexpr (ROW < ON_BODY) {
      rates[VELOCITY + ROW] = value_of(x);
      if constexpr (DERIVATIVES) [&]<int... C>(std::integer_sequence<int, C...>) __attribute__((always_inline)) {
        ((j->row[ROW][C] = full_slope<C>(x)), ...);
      }(std::make_integer_sequence<int, MOTION>{});
    }
  };
  between_raceways<TILTED ? RingMotion::tilted : RingMotion::held, PATCH>(
      bearing, BallInput<DERIVATIVES>{bearing, y, ring_speed, carried, heights}, give);
  Pack over = 1.0 / y[RADIUS], orbit_rate = y[VELOCITY + 1] * over, power = rates[DRIVE_WORK];
  rates[RADIUS] = y[VELOCITY], rates[ANGLE] = orbit_rate, rates[HEIGHT] = y[VELOCITY + 2], rates[GROSS_WORK] = absolute(power);
  if constexpr (DERIVATIVES) {
    j->orbit_by_radius = -orbit_rate * over, j->orbit_by_velocity = over;
    j->power_sign = select(power >= 0.0, broadcast<Pack>(1.0), broadcast<Pack>(-1.0));
  }
}
template <bool PATCH, bool TILTED>
[[gnu::noinline]] inline void evaluate_rates(const Bearing &bearing, const Pack &ring_speed, const CarriedBalls *carried,
                                             const Heights &heights, const BallState &y, BallState &rates) {
  evaluate_ball<PATCH, TILTED, false>(bearing, ring_speed, carried, heights, y, rates, nullptr);
}
template <bool PATCH, bool TILTED>
[[gnu::noinline]] inline void evaluate_rates_and_jacobian(const Bearing &bearing, const Pack &ring_speed, const CarriedBalls *carried,
                                                          const Heights &heights, const BallState &y, BallState &rates, BallJacobian &j) {
  evaluate_ball<PATCH, TILTED, true>(bearing, ring_speed, carried, heights, y, rates, &j);
}

// W = I/g - J of a ball whose positions are eliminated first, position_i = g (right_i + ...): the inverse of what is left.
struct BallFactors { Pack by_radius, by_velocity, inverse[6][6]; };

[[gnu::noinline]] inline void factorise(const BallJacobian &j, const Pack &g, BallFactors &f) {
  f.by_radius = g * g * j.orbit_by_radius, f.by_velocity = g * j.orbit_by_velocity;
  Pack over = 1.0 / g;
  for (int i = 0; i < 6; i++) {
    const Pack *row = j.row[i];
    Pack folded[6] = {row[3] + (row[0] * g + row[1] * f.by_radius), row[4] + row[1] * f.by_velocity, row[5] + row[2] * g, row[6], row[7], row[8]};
    for (int c = 0; c < 6; c++) f.inverse[i][c] = i == c ? over - folded[c] : -folded[c];
  }
  invert_in_lanes<6>(f.inverse);
}

// Solves W x = right.
[[gnu::noinline]] inline void solve(const BallJacobian &j, const BallFactors &f, const Pack &g, const BallState &right,
                                    BallState &x) {
  Pack radius = g * right[RADIUS], known[3] = {radius, g * (right[ANGLE] + j.orbit_by_radius * radius), g * right[HEIGHT]}, left[6], v[6];
  for (int i = 0; i < 6; i++) left[i] = right[VELOCITY + i] + (j.row[i][0] * known[0] + j.row[i][1] * known[1] + j.row[i][2] * known[2]);
  multiply_in_lanes<6>(f.inverse, left, v);
  x[RADIUS] = known[0] + g * v[0], x[ANGLE] = known[1] + f.by_radius * v[0] + f.by_velocity * v[1], x[HEIGHT] = known[2] + g * v[2];
  for (int i = 0; i < 6; i++) x[VELOCITY + i] = v[i];
  Pack found[2]{};
  for (int n = 0; n < 2; n++)
    for (int c = 0; c < MOTION; c++) found[n] += j.row[POWER_ROW + n][c] * x[c];
  x[DRIVE_WORK] = g * (right[DRIVE_WORK] + found[0]), x[DISSIPATED] = g * (right[DISSIPATED] + found[1]);
  x[GROSS_WORK] = g * (right[GROSS_WORK] + j.power_sign * found[0]);
}

// Approaches of a ball to the raceways [m], and whether its state can be right.

constexpr double DEEPEST = 0.1;  // approach over ball radius beyond which bodies have run through each other

template <class T>
CORE_INLINE T approach_at(const Bearing &bearing, const Raceway &raceway, const T &axis_distance, const T &height) {
  T outwards = axis_distance - raceway.locus_radius;
  return root_and_inverse(outwards * outwards + height * height + 1e-300).first + bearing.ball_radius - raceway.groove_radius;
}
template <class State>
CORE_INLINE auto outer_approach(const Bearing &bearing, const State &y) {
  return approach_at(bearing, bearing.outer, y[RADIUS], y[HEIGHT]);
}
// Distance of a ball's centre from the inner ring's axis and its height above that ring's plane [m].
struct RingPlace { double axis_distance, height; };
inline RingPlace inner_place(const double *centre, const double *tilt, double radius, double angle, double height) {
  double c = std::cos(angle), s = std::sin(angle);
  Vector3 offset{radius - (c * centre[0] + s * centre[1]), s * centre[0] - c * centre[1], height - centre[2]};
  if (tilt[0] != 0.0 || tilt[1] != 0.0) offset = into_ring(ring_axes(c * tilt[0] + s * tilt[1], c * tilt[1] - s * tilt[0]), offset);
  return {std::sqrt(offset.x * offset.x + offset.y * offset.y), offset.z};
}
inline RingPlace inner_place(const Bearing &bearing, double radius, double angle, double height) {
  return inner_place(bearing.offset, bearing.tilt, radius, angle, height);
}
inline double inner_approach(const Bearing &bearing, double radius, double angle, double height) {
  auto [distance, above] = inner_place(bearing, radius, angle, height);
  return approach_at(bearing, bearing.inner, distance, above);
}

constexpr double TOUCHING = 1e-11;  // m: approaches below are neither contact nor gap
using Approaches = std::array<double, 2>;  // at the inner and at the outer raceway [m]

inline Approaches approaches_at(const Bearing &bearing, double radius, double angle, double height) {
  return {inner_approach(bearing, radius, angle, height), approach_at(bearing, bearing.outer, radius, height)};
}
// True if a contact with a raceway begins or ends between two places, other than by rounding.
inline bool changes_contact(const Approaches &before, const Approaches &after) {
  for (int i = 0; i < 2; i++)
    if (before[i] * after[i] < 0.0 && std::min(std::fabs(before[i]), std::fabs(after[i])) > TOUCHING) return true;
  return false;
}
// The share of a step after which a contact has just begun or ended; `at(share)` are the approaches inside it.
template <class At>
inline double share_of_change(const Approaches &before, At at) {
  double low = 0.0, high = 1.0;
  while (high - low > 1e-6) {
    double middle = 0.5 * (low + high);
    (changes_contact(before, at(middle)) ? high : low) = middle;
  }
  return high;
}

// Ends a step of the ball in a lane, whose centre is there in the axes of either ring.
inline void carry_on(const Bearing &bearing, const RingPlace &inner, const RingPlace &outer, int lane, CarriedBalls &carried) {
  auto end = [&](const Raceway &raceway, const RingPlace &at, CarriedContact &contact) {
    double outwards = at.axis_distance - raceway.locus_radius;
    double radial = outwards / std::sqrt(outwards * outwards + at.height * at.height + 1e-300);
    contact.carry_on(bearing.carried, bearing.curvature_across(raceway) / bearing.curvature_along(raceway, radial));
  };
  end(bearing.inner, inner, carried.inner.contact[lane]), end(bearing.outer, outer, carried.outer.contact[lane]);
}
template <class State>
inline void carry_on(const Bearing &bearing, const State &y, int lane, CarriedBalls &carried) {
  double radius = y[RADIUS][lane], height = y[HEIGHT][lane];
  carry_on(bearing, inner_place(bearing, radius, y[ANGLE][lane], height), {radius, height}, lane, carried);
}

// States of a ball's contacts that are carried between chunks (CARRIED,): of the inner and the outer contact P/Q, m, K and E.
constexpr int CARRIED = 8;
inline void load_carried(const double *numbers, int lane, CarriedBalls &carried) {
  carried.inner.contact[lane] = {numbers[0], {numbers[1], numbers[2], numbers[3]}};
  carried.outer.contact[lane] = {numbers[4], {numbers[5], numbers[6], numbers[7]}};
}
inline void store_carried(const CarriedBalls &carried, int lane, double *numbers) {
  for (const CarriedContact &one : {carried.inner.contact[lane], carried.outer.contact[lane]}) {
    *numbers++ = one.ratio;
    *numbers++ = one.shape.parameter, *numbers++ = one.shape.first_kind, *numbers++ = one.shape.second_kind;
  }
}

// True if a ball's state (COLUMNS,) is possible.
inline Status check_ball(const Bearing &bearing, const double *y) {
  double sum = 0.0, deepest = DEEPEST * bearing.ball_radius;
  for (int c = 0; c < COLUMNS; c++) sum += std::fabs(y[c]);
  if (!(sum < HUGE_VAL)) return NOT_FINITE;
  bool deep = inner_approach(bearing, y[RADIUS], y[ANGLE], y[HEIGHT]) > deepest || outer_approach(bearing, y) > deepest;
  return deep ? TOO_DEEP : OK;
}

}  // namespace core
