// Contact of a ball with the next: sphere on sphere by Hertz, damping as on the raceways, friction at the contact point.
#pragma once
#include "ball_raceway.hpp"

namespace core {

// In the first ball's frame: `between` from its centre to the other's [m], `velocity` [m/s] against the other's centre,
// `spin` [rad/s] the sum of both. Loads act on the first ball; on the other the force is the opposite, the torque about
// its centre the same. `energy` [J], `loss` and `stored` [W], the power that goes into elastic energy, are of both.
template <class A, class N, class R, class L, class S, class F, class G, class T, class E, class D, class P>
struct PairContact { A approach; N normal; R arm; L normal_load; S slip; F friction; G force; T torque; E energy; D loss; P stored; };
template <class A, class N, class R, class L, class S, class F, class G, class T, class E, class D, class P>
PairContact(A, N, R, L, S, F, G, T, E, D, P) -> PairContact<A, N, R, L, S, F, G, T, E, D, P>;

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
  return PairContact{approach, normal, arm, normal_load, slip, friction, friction - normal_load * normal,
                     cross(arm, friction), energy, resistance * square + (normal_load - load) * approach_rate,
                     load * approach_rate};
}

}  // namespace core
