// A part of a run to integrate, which all methods read and fill.
#pragma once
#include <vector>
#include "approaches.hpp"
#include "touching_balls.hpp"

namespace core {

constexpr int SCALES = MOTION + 1;

// `scale` are the errors that a step may make in each coordinate, and last [J] in what is lost; `instant` [s] the times of
// outputs, from the chunk's begin. Moved on in place are states (balls, COLUMNS), orientations (balls, 4), steps (balls,) [s],
// what is `carried` (balls, CARRIED) and the bodies' state (BODY_NUMBERS,); filled are those at the instants (instants, ...).
struct Chunk {
  const Bearing &bearing;
  const CoupledBodies &bodies;
  Drive drive;
  double duration;
  const double *scale;
  int instants;
  const double *instant;
  const volatile std::uint8_t *stop;  // not 0 once somebody wants it to end
  int balls;
  const std::uint8_t *near;  // which balls may touch the next ahead
  double *state, *orientation, *step, *carried, *body_state, *states, *orientations, *body_states;
  std::int64_t *counts;  // steps, rejections, evaluations and Jacobians so far
  double *failure;  // (2,): the time [s] and the ball of a failure

  Status failed(Status status, double when, int ball) const {
    failure[0] = when, failure[1] = ball;
    return status;
  }
  // Puts a ball into a lane.
  void load(int ball, BallBlock &k, int lane) const {
    for (int c = 0; c < COLUMNS; c++) k.start[c][lane] = state[ball * COLUMNS + c];
    for (int c = 0; c < 4; c++) k.before[c][lane] = orientation[ball * 4 + c];
    k.start[ORBIT_RATE][lane] /= k.start[RADIUS][lane];
    load_carried(carried + ball * CARRIED, lane, k.carried);
  }
  // Writes a ball as it is in a lane at an instant, or for -1 at the end.
  void store(int row, int ball, const BallState &y, const Quaternion &turned, int lane) const {
    double *to = row < 0 ? state + ball * COLUMNS : states + (long(row) * balls + ball) * COLUMNS;
    double *angles = row < 0 ? orientation + ball * 4 : orientations + (long(row) * balls + ball) * 4;
    for (int c = 0; c < COLUMNS; c++) to[c] = y[c][lane];
    for (int c = 0; c < 4; c++) angles[c] = turned[c][lane];
    to[ORBIT_RATE] *= to[RADIUS];
  }
};

// Moves all balls and bodies through a chunk.
Status by_rosenbrock(const Chunk &chunk, const RosenbrockMethod &method);

// The numbers of the ball in a lane.
inline std::array<double, COLUMNS> in_lane(const BallState &y, int lane) {
  std::array<double, COLUMNS> found;
  for (int c = 0; c < COLUMNS; c++) found[c] = y[c][lane];
  return found;
}

// Angular velocity [rad/s] against the frame that turns with the ball.
CORE_INLINE Triple spin_in_frame(const BallState &y) { return {y[SPIN], y[SPIN + 1], y[SPIN + 2] - y[ORBIT_RATE]}; }

// Rates of a block of balls between rings whose motion is prescribed, but for those of contacts between balls.
template <bool DERIVATIVES>
inline void prescribed_forces(const Bearing &bearing, const Pack &ring_speed, BallBlock &k) {
  if (bearing.over_patch())
    bearing.tilted() ? prescribed_raceways<true, true, DERIVATIVES>(bearing, ring_speed, k) : prescribed_raceways<true, false, DERIVATIVES>(bearing, ring_speed, k);
  else bearing.tilted() ? prescribed_raceways<false, true, DERIVATIVES>(bearing, ring_speed, k) : prescribed_raceways<false, false, DERIVATIVES>(bearing, ring_speed, k);
}

// Sum of the squares of changes of a ball's motion over what each may be, of that along the orbit as a velocity.
inline Pack squares_of(const BallState &y, const BallState &change, const Pack &weight, const double *over_scale) {
  Pack sum{};
  for (int c = 0; c < MOTION; c++) {
    Pack scaled = (c == ORBIT_RATE ? y[RADIUS] * change[c] + y[ORBIT_RATE] * change[RADIUS] : change[c]) * over_scale[c];
    if (c == ANGLE || c > VELOCITY) scaled *= weight;
    sum += scaled * scaled;
  }
  return sum;
}

}  // namespace core
