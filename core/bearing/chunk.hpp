// Part of a run to integrate: input and output of all methods.
#pragma once
#include <vector>
#include "approaches.hpp"
#include "touching_balls.hpp"

namespace core {

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

// Rates of a block of balls between rings whose motion is prescribed, without contacts between balls.
template <bool DERIVATIVES>
inline void prescribed_forces(const Bearing &bearing, const Pack &ring_speed, BallBlock &block) {
  if (bearing.over_patch())
    bearing.tilted() ? prescribed_raceway_forces<true, true, DERIVATIVES>(bearing, ring_speed, block) : prescribed_raceway_forces<true, false, DERIVATIVES>(bearing, ring_speed, block);
  else bearing.tilted() ? prescribed_raceway_forces<false, true, DERIVATIVES>(bearing, ring_speed, block) : prescribed_raceway_forces<false, false, DERIVATIVES>(bearing, ring_speed, block);
}

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
