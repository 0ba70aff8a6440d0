// Part of a run to integrate: approaches of balls to raceways, start and end of contacts, states of laws that are carried from
// step to step; input and output of all methods.
#pragma once
#include <vector>
#include "../math/linear.hpp"
#include "../methods/events.hpp"
#include "../methods/step_control.hpp"
#include "touching_balls.hpp"

namespace core {

constexpr double MAX_APPROACH = 0.1;  // over the ball radius; beyond it the motion is impossible

template <class T>
CORE_INLINE T raceway_approach(const Bearing &bearing, const Raceway &raceway, const T &axis_distance, const T &height) {
  T outwards = axis_distance - raceway.locus_radius;
  return root_and_inverse(outwards * outwards + height * height + 1e-300).first + bearing.ball_radius - raceway.groove_radius;
}
template <class State>
CORE_INLINE auto outer_approach(const Bearing &bearing, const State &y) {
  return raceway_approach(bearing, bearing.outer, y[RADIUS], y[HEIGHT]);
}
// Distance of a ball's centre from a ring's axis and its height above that ring's plane [m]; `y` begins with the ball's position.
struct RingPosition {
  double axis_distance, height;
};
template <class Y>
inline RingPosition position_in_ring(const double *centre, const double *tilt, const Y &y) {
  double c = std::cos(y[ANGLE]), s = std::sin(y[ANGLE]);
  Vector3 offset{y[RADIUS] - (c * centre[0] + s * centre[1]), s * centre[0] - c * centre[1], y[HEIGHT] - centre[2]};
  if (tilt[0] != 0.0 || tilt[1] != 0.0) offset = into_ring(ring_axes(c * tilt[0] + s * tilt[1], c * tilt[1] - s * tilt[0]), offset);
  return {std::sqrt(offset.x * offset.x + offset.y * offset.y), offset.z};
}

constexpr double TOUCHING = 1e-11;  // m: smaller approaches are neither contact nor gap
using RingPositions = std::array<RingPosition, 2>;  // in the inner and in the outer ring
using Approaches = std::array<double, 2>;  // at the inner and at the outer raceway [m]
inline Approaches raceway_approaches(const Bearing &bearing, const RingPositions &positions) {
  return {raceway_approach(bearing, bearing.inner, positions[0].axis_distance, positions[0].height),
          raceway_approach(bearing, bearing.outer, positions[1].axis_distance, positions[1].height)};
}
// The same for rings whose motion is prescribed.
template <class Y>
inline RingPositions prescribed_positions(const Bearing &bearing, const Y &y) {
  return {position_in_ring(bearing.offset, bearing.tilt, y), RingPosition{y[RADIUS], y[HEIGHT]}};
}

// True if a contact with a raceway starts or ends between two positions, other than by rounding.
inline bool changes_contact(const Approaches &before, const Approaches &after) {
  for (int i = 0; i < 2; i++)
    if (before[i] * after[i] < 0.0 && std::min(std::fabs(before[i]), std::fabs(after[i])) > TOUCHING) return true;
  return false;
}
// The fraction of a step at which a contact has just started or ended; `approaches(fraction)` are the approaches inside it.
template <class ApproachesInside>
inline double event_fraction(const Approaches &before, ApproachesInside approaches) {
  return bisected([&](double fraction) { return !changes_contact(before, approaches(fraction)); }, 1.0, 1e-6).high;
}

// Advances the states of the law to the position of the ball in a lane at the end of a step.
inline void advance_carried(const Bearing &bearing, const RingPositions &positions, int lane, CarriedBalls &carried) {
  auto advance = [&](const Raceway &raceway, const RingPosition &position, CarriedContact &contact) {
    double outwards = position.axis_distance - raceway.locus_radius;
    double radial = outwards / std::sqrt(outwards * outwards + position.height * position.height + 1e-300);
    contact.advance(bearing.carried, bearing.curvature_across(raceway) / bearing.curvature_along(raceway, radial));
  };
  advance(bearing.inner, positions[0], carried.inner.contact[lane]),
      advance(bearing.outer, positions[1], carried.outer.contact[lane]);
}
// States of laws between chunks (CARRIED,): of the inner and the outer contact P/Q, m, K and E.
constexpr int CARRIED = 2 * sizeof(CarriedContact) / sizeof(double);
inline void load_carried(const double *numbers, int lane, CarriedBalls &carried) {
  auto *contact = reinterpret_cast<const CarriedContact *>(numbers);
  carried.inner.contact[lane] = contact[0], carried.outer.contact[lane] = contact[1];
}
inline void store_carried(const CarriedBalls &carried, int lane, double *numbers) {
  auto *contact = reinterpret_cast<CarriedContact *>(numbers);
  contact[0] = carried.inner.contact[lane], contact[1] = carried.outer.contact[lane];
}

// OK if the state `y` of a ball at these positions is possible.
template <class Y>
inline Status check_ball(const Bearing &bearing, const Y &y, const RingPositions &positions) {
  double sum = 0.0;
  for (int c = 0; c < COLUMNS; c++) sum += std::fabs(y[c]);
  if (!(sum < HUGE_VAL)) return NOT_FINITE;
  auto [inner, outer] = raceway_approaches(bearing, positions);
  return std::max(inner, outer) > MAX_APPROACH * bearing.ball_radius ? TOO_DEEP : OK;
}

constexpr int SCALES = MOTION + 1;

// `scale` are the tolerated errors of a step in each coordinate and, last, in the energy dissipated [J]; `instant` [s] the times of
// outputs since the start of the chunk. Advanced in place are states (balls, COLUMNS), orientations (balls, 4), steps (balls,) [s],
// the states of laws `carried` (balls, CARRIED) and the bodies' state (BODY_NUMBERS,); filled are outputs (instants, ...).
struct Chunk {
  const Bearing &bearing;
  const CoupledBodies &bodies;
  Drive drive;
  double duration;
  const double *scale;
  int instants;
  const double *instant;
  const volatile std::uint8_t *stop;  // not 0 once a stop is requested
  int balls;
  const std::uint8_t *near;  // which balls may touch the next ahead
  double *state, *orientation, *step, *carried, *body_state, *states, *orientations, *body_states;
  std::int64_t *counts;  // steps, rejections, evaluations and Jacobians so far
  double *failure;  // (2,): the time [s] and the ball of a failure

  Status fail(Status status, double time, int ball) const {
    failure[0] = time, failure[1] = ball;
    return status;
  }
  // Puts a ball into a lane.
  void load(int ball, BallBlock &block, int lane) const {
    for (int c = 0; c < COLUMNS; c++) block.start[c][lane] = state[ball * COLUMNS + c];
    for (int c = 0; c < 4; c++) block.start_orientation[c][lane] = orientation[ball * 4 + c];
    block.start[ORBIT_RATE][lane] /= block.start[RADIUS][lane];
    load_carried(carried + ball * CARRIED, lane, block.carried);
  }
  // Writes the state of the ball in a lane to an output, or for -1 to the end of the chunk.
  void store(int row, int ball, const BallState &y, const Quaternion &q, int lane) const {
    double *numbers = row < 0 ? state + ball * COLUMNS : states + (long(row) * balls + ball) * COLUMNS;
    double *quaternion = row < 0 ? orientation + ball * 4 : orientations + (long(row) * balls + ball) * 4;
    for (int c = 0; c < COLUMNS; c++) numbers[c] = y[c][lane];
    for (int c = 0; c < 4; c++) quaternion[c] = q[c][lane];
    numbers[ORBIT_RATE] *= numbers[RADIUS];
  }
};

// Integrates all balls and bodies over a chunk.
Status by_rosenbrock(const Chunk &chunk, const RosenbrockMethod &method);

// The state of the ball in a lane.
inline std::array<double, COLUMNS> lane_state(const BallState &y, int lane) {
  std::array<double, COLUMNS> state;
  for (int c = 0; c < COLUMNS; c++) state[c] = y[c][lane];
  return state;
}

// Angular velocity [rad/s] relative to the frame that orbits with the ball.
CORE_INLINE Triple spin_in_frame(const BallState &y) { return {y[SPIN], y[SPIN + 1], y[SPIN + 2] - y[ORBIT_RATE]}; }

// Sum of the squares of errors of a ball's motion over their scales; the orbit rate counts as a velocity.
inline Pack scaled_square_sum(const BallState &y, const BallState &error, const Pack &weight, const double *inverse_scale) {
  Pack sum{};
  for (int c = 0; c < MOTION; c++) {
    Pack scaled = (c == ORBIT_RATE ? y[RADIUS] * error[c] + y[ORBIT_RATE] * error[RADIUS] : error[c]) * inverse_scale[c];
    if (c == ANGLE || c > VELOCITY) scaled *= weight;
    sum += scaled * scaled;
  }
  return sum;
}

}  // namespace core
