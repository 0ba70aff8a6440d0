// Newton's and Euler's equations of a ball between two raceways, and their derivatives by its motion.
#pragma once
#include "ball_raceway.hpp"
#include "tilted_ring.hpp"

namespace core {

template <class O, class V, class S, class P, class L>
struct BallRates { O orbit_rate; V acceleration; S angular_acceleration; P power; L loss; };
template <class O, class V, class S, class P, class L> BallRates(O, V, S, P, L) -> BallRates<O, V, S, P, L>;

// Rates of a ball whose neighbours are apart. In the frame that turns with it at `orbit_rate` about z, velocity and
// angular velocity gain the terms -orbit_rate z x (.): the centrifugal, Coriolis and gyroscopic effects.
template <bool PATCH, bool TILTED, class R, class A, class H, class V, class S>
CORE_INLINE auto ball_rates(const Bearing &bearing, const Pack &ring_speed, const CarriedBalls *carried, const Heights &heights, const R &radius, const A &angle,
                            const H &height, const V &velocity, const S &spin) {
  auto [cosine, sine] = cosine_sine(angle);
  auto minus_sine = -sine;
  auto in_ball_frame = [&](const double (&fixed)[3]) {
    return about_z(cosine, minus_sine, Vector3{fixed[0], fixed[1], fixed[2]});
  };
  Vector3 position{radius, Zero{}, height};
  Pack height_work{};
  auto action = [&](const Raceway &raceway, const CarriedContact *states, FilmBegin *film, const Height &height, const auto &offset, const auto &moves, const auto &spins,
                    const auto &speed) __attribute__((always_inline)) {
    auto [at, normal_radial] = contact_place(bearing, raceway, offset, speed, states, height);
    auto relative = (moves + cross(spins, at.arm)) - at.surface_velocity;
    auto about_normal = dot(spins, at.normal) - speed * at.normal.z;
    auto found = staged_action<PATCH>(bearing, raceway, at, normal_radial, relative, about_normal, moves, film);
    height_work += height_power(found.force, at.normal, height.rate);
    return found;
  };
  auto inner = [&]() __attribute__((always_inline)) {
    auto offset = position - in_ball_frame(bearing.offset);
    const CarriedContact *states = carried ? carried->inner : nullptr;
    FilmBegin *film = carried ? &carried->film[0] : nullptr;
    if constexpr (!TILTED) return action(bearing.inner, states, film, heights.inner, offset, velocity, spin, ring_speed);
    else {
      auto tilt = about_z(cosine, minus_sine, Vector3{bearing.tilt[0], bearing.tilt[1], Zero{}});
      auto axes = ring_axes(tilt.x, tilt.y);
      auto found = action(bearing.inner, states, film, heights.inner, into_ring(axes, offset), into_ring(axes, velocity), into_ring(axes, spin), ring_speed);
      return BallAction{out_of_ring(axes, found.force), out_of_ring(axes, found.torque), found.power, found.loss};
    }
  }();
  FilmBegin *film = carried ? &carried->film[1] : nullptr;
  auto outer = action(bearing.outer, carried ? carried->outer : nullptr, film, heights.outer, position, velocity, spin, Zero{});
  auto force = inner.force + outer.force, torque = inner.torque + outer.torque;
  auto gravity = in_ball_frame(bearing.gravity);
  auto orbit_rate = velocity.y / radius;
  double over_mass = 1.0 / bearing.ball_mass, over_inertia = 1.0 / bearing.ball_inertia;
  Vector3 acceleration{over_mass * force.x + gravity.x + orbit_rate * velocity.y,
                       over_mass * force.y + gravity.y - orbit_rate * velocity.x, over_mass * force.z + gravity.z};
  Vector3 angular_acceleration{over_inertia * torque.x + orbit_rate * spin.y, over_inertia * torque.y - orbit_rate * spin.x,
                               over_inertia * torque.z};
  return BallRates{orbit_rate, acceleration, angular_acceleration, (inner.power + outer.power) + height_work, inner.loss + outer.loss};
}

using BallState = std::array<Pack, COLUMNS>;

// Angular velocity [rad/s] against the frame that turns with the ball.
CORE_INLINE Triple spin_in_frame(const BallState &y) { return {y[SPIN], y[SPIN + 1], y[SPIN + 2] - y[VELOCITY + 1] / y[RADIUS]}; }

// Partial derivatives of a ball's rates; `power` and `loss` by position, velocity and spin.
struct BallJacobian {
  Pack orbit_by_radius, orbit_by_velocity, power_sign;
  Matrix3 velocity_by_position, velocity_by_velocity, velocity_by_spin;
  Matrix3 spin_by_position, spin_by_velocity, spin_by_spin;
  Triple power[3], loss[3];
};

template <class R>
CORE_INLINE void store_rates(const BallState &state, const R &rates, BallState &out) {
  const auto &a = rates.acceleration, &w = rates.angular_acceleration;
  out = {state[VELOCITY],   value_of(rates.orbit_rate), state[VELOCITY + 2],   value_of(a.x), value_of(a.y), value_of(a.z),
         value_of(w.x),     value_of(w.y),              value_of(w.z),         value_of(rates.power),
         value_of(rates.loss), absolute(value_of(rates.power))};
}

// `carried` is null where the law carries nothing.
template <bool PATCH, bool TILTED>
[[gnu::noinline]] inline void evaluate_rates(const Bearing &bearing, const Pack &ring_speed, const CarriedBalls *carried,
                                             const Heights &heights, const BallState &y, BallState &rates) {
  auto found = ball_rates<PATCH, TILTED>(bearing, ring_speed, carried, heights, y[RADIUS], y[ANGLE], y[HEIGHT],
                                 Vector3{y[VELOCITY], y[VELOCITY + 1], y[VELOCITY + 2]},
                                 Vector3{y[SPIN], y[SPIN + 1], y[SPIN + 2]});
  store_rates(y, found, rates);
}

template <bool PATCH, bool TILTED>
[[gnu::noinline]] inline void evaluate_rates_and_jacobian(const Bearing &bearing, const Pack &ring_speed,
                                                          const CarriedBalls *carried, const Heights &heights, const BallState &y,
                                                          BallState &rates, BallJacobian &j) {
  Vector3 velocity{variable<3>(y[VELOCITY]), variable<4>(y[VELOCITY + 1]), variable<5>(y[VELOCITY + 2])};
  Vector3 spin{variable<6>(y[SPIN]), variable<7>(y[SPIN + 1]), variable<8>(y[SPIN + 2])};
  auto found = ball_rates<PATCH, TILTED>(bearing, ring_speed, carried, heights, variable<0>(y[RADIUS]), variable<1>(y[ANGLE]),
                                 variable<2>(y[HEIGHT]), velocity, spin);
  store_rates(y, found, rates);
  auto triple = []<int C>(const auto &x) __attribute__((always_inline)) {
    return Triple{full_slope<C>(x), full_slope<C + 1>(x), full_slope<C + 2>(x)};
  };
  auto matrix = [&]<int C>(const auto &v) __attribute__((always_inline)) {
    return Matrix3{triple.template operator()<C>(v.x), triple.template operator()<C>(v.y),
                   triple.template operator()<C>(v.z)};
  };
  const auto &a = found.acceleration, &w = found.angular_acceleration;
  j.velocity_by_position = matrix.template operator()<0>(a), j.spin_by_position = matrix.template operator()<0>(w);
  j.velocity_by_velocity = matrix.template operator()<3>(a), j.spin_by_velocity = matrix.template operator()<3>(w);
  j.velocity_by_spin = matrix.template operator()<6>(a), j.spin_by_spin = matrix.template operator()<6>(w);
  j.power[0] = triple.template operator()<0>(found.power), j.loss[0] = triple.template operator()<0>(found.loss);
  j.power[1] = triple.template operator()<3>(found.power), j.loss[1] = triple.template operator()<3>(found.loss);
  j.power[2] = triple.template operator()<6>(found.power), j.loss[2] = triple.template operator()<6>(found.loss);
  j.orbit_by_radius = full_slope<0>(found.orbit_rate), j.orbit_by_velocity = full_slope<4>(found.orbit_rate);
  j.power_sign = select(value_of(found.power) >= 0.0, broadcast<Pack>(1.0), broadcast<Pack>(-1.0));
}

// Factors of W = I/g - J of a ball whose positions are eliminated first (position_i = g (right_i + ...)), then its
// velocities, by the Schur complement of the spins.
struct BallFactors { Pack by_radius, by_velocity; Matrix3 inverse, coupling, below, schur; };

CORE_INLINE Matrix3 through_positions(const Matrix3 &by_position, const BallFactors &f, const Pack &g) {
  Matrix3 result;
  for (int i = 0; i < 3; i++) {
    const Triple &row = by_position[i];
    result[i] = {row[0] * g + row[1] * f.by_radius, row[1] * f.by_velocity, row[2] * g};
  }
  return result;
}

[[gnu::noinline]] inline void factorise(const BallJacobian &j, const Pack &g, BallFactors &f) {
  f.by_radius = g * g * j.orbit_by_radius, f.by_velocity = g * j.orbit_by_velocity;
  f.below = j.spin_by_velocity + through_positions(j.spin_by_position, f, g);
  Pack over = 1.0 / g;
  f.inverse = inverse_of(shifted_negative(over, j.velocity_by_velocity + through_positions(j.velocity_by_position, f, g)));
  f.coupling = f.inverse * j.velocity_by_spin;
  f.schur = inverse_of(shifted_negative(over, j.spin_by_spin + f.below * f.coupling));
}

// Solves W x = right.
[[gnu::noinline]] inline void solve(const BallJacobian &j, const BallFactors &f, const Pack &g, const BallState &right,
                                    BallState &x) {
  Pack radius = g * right[RADIUS];
  Triple known{radius, g * (right[ANGLE] + j.orbit_by_radius * radius), g * right[HEIGHT]};
  Triple push = f.inverse * (Triple{right[3], right[4], right[5]} + j.velocity_by_position * known);
  Triple spin = f.schur * (Triple{right[6], right[7], right[8]} + j.spin_by_position * known + f.below * push);
  Triple velocity = push + f.coupling * spin;
  Triple position{known[0] + g * velocity[0], known[1] + f.by_radius * velocity[0] + f.by_velocity * velocity[1],
                  known[2] + g * velocity[2]};
  for (int i = 0; i < 3; i++) x[i] = position[i], x[VELOCITY + i] = velocity[i], x[SPIN + i] = spin[i];
  Pack power = dot(j.power[0], position) + dot(j.power[1], velocity) + dot(j.power[2], spin);
  Pack loss = dot(j.loss[0], position) + dot(j.loss[1], velocity) + dot(j.loss[2], spin);
  x[DRIVE_WORK] = g * (right[DRIVE_WORK] + power);
  x[DISSIPATED] = g * (right[DISSIPATED] + loss);
  x[GROSS_WORK] = g * (right[GROSS_WORK] + j.power_sign * power);
}

}  // namespace core
