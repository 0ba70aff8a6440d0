// Explicit and implicit-explicit methods of balls between rings whose motion is prescribed, with common steps and contacts between
// neighbours; exported functions on C-contiguous arrays of doubles.
#include "chunk.hpp"
#include "numbers.hpp"

namespace core {

// All balls and their rates `f` at their states `y`.
class PrescribedBalls {
 public:
  const std::int64_t number;

  explicit PrescribedBalls(const Chunk &chunk)
      : number(chunk.balls), chunk(chunk), bearing(chunk.bearing), layout(chunk.bodies), blocks((number + LANES - 1) / LANES) {
    std::vector<int> numbers(number);
    for (int i = 0; i < int(blocks.size()) * LANES; i++) {
      int ball = std::min(i, int(number) - 1);
      chunk.load(ball, blocks[i / LANES], i % LANES);
      numbers[ball] = ball;
    }
    touching.start(chunk.near, chunk.balls, numbers);
  }

  // With DERIVATIVES those without contacts between balls.
  template <bool DERIVATIVES>
  void evaluate(double time) {
    BodyForces forces{};
    Pack cage_inertia{}, speed = broadcast<Pack>(chunk.drive.speed_at(time));
    for (BallBlock &block : blocks) {
      if (bearing.defects.count) block.heights = heights(time, speed, block.y);
      block_forces<DERIVATIVES>(bearing, chunk.bodies, layout, block, BodyState{}, speed, forces);
    }
    if (touching.active()) touching.add<false>(bearing, blocks);
    for (BallBlock &block : blocks) finish_rates<DERIVATIVES>(bearing, layout, block, forces, cage_inertia);
  }
  // Rates (balls, COLUMNS) at the start, of the tangential velocity instead of the orbit rate.
  void start_rates(double *rates) {
    for (BallBlock &block : blocks) block.y = block.start;
    evaluate<false>(0.0);
    for (int ball = 0; ball < number; ball++) {
      auto y = lane_state(blocks[ball / LANES].start, ball % LANES), f = lane_state(blocks[ball / LANES].f, ball % LANES);
      f[ORBIT_RATE] = y[RADIUS] * f[ORBIT_RATE] + y[VELOCITY] * y[ORBIT_RATE];
      std::copy(f.begin(), f.end(), rates + ball * COLUMNS);
    }
  }
  void store(int row) const {
    for (int ball = 0; ball < number; ball++)
      chunk.store(row, ball, blocks[ball / LANES].start, blocks[ball / LANES].start_orientation, ball % LANES);
    for (int ball = 0; ball < number && row < 0; ball++)
      store_carried(blocks[ball / LANES].carried, ball % LANES, chunk.carried + ball * CARRIED);
  }
  std::pair<Status, int> check() const {
    for (int ball = 0; ball < number; ball++) {
      auto y = lane_state(blocks[ball / LANES].start, ball % LANES);
      if (Status status = check_ball(bearing, y, prescribed_positions(bearing, y)); status != OK) return {status, ball};
    }
    return {OK, 0};
  }

 protected:
  const Chunk &chunk;
  const Bearing &bearing;
  const Layout layout;
  std::vector<BallBlock> blocks;
  TouchingBalls touching;

  // States of laws at the end of a step.
  void advance_carried_laws() {
    for (BallBlock &block : blocks)
      for (int lane = 0; lane < LANES && bearing.carried != CarriedLaw::none; lane++)
        advance_carried(bearing, prescribed_positions(bearing, lane_state(block.start, lane)), lane, block.carried);
  }

 private:
  // Of raceways alone: defects of balls need their orientations, which are integrated at longer intervals.
  Heights heights(double time, const Pack &speed, const BallState &y) const {
    Pack ring_angle = broadcast<Pack>(chunk.drive.angle_at(time));
    return heights_at(bearing.defects,
                      surface_positions(y[ANGLE], y[ORBIT_RATE], ring_angle, speed, Quaternion{}, Triple{}, Mask{}), Pack{});
  }
};

// Explicit Runge-Kutta methods. Unstable for steps above about 3 / (fastest rate): contact frequency or mu N / (m v_s).
class ExplicitBalls : public PrescribedBalls {
 public:
  ExplicitBalls(const Chunk &chunk, const RungeKuttaMethod &method)
      : PrescribedBalls(chunk),
        method(method),
        adapts(method.adapts()),
        before(blocks.size()),
        before_rates(before),
        errors(blocks.size()),
        slopes(method.stages + 1, before) {
    for (int c = 0; c < MOTION; c++) inverse_scale[c] = 1.0 / chunk.scale[c];
  }

  double step(double time, double h, bool warm) {
    int stages = method.stages;
    for (int stage = warm ? 1 : 0; stage <= stages; stage++) {
      bool end = stage == stages;
      combine(h, end ? method.weight : method.a[stage], stage);
      evaluate<false>(end ? time + h : time + method.node[stage] * h);
      for (std::size_t b = 0; b < blocks.size(); b++) slopes[stage][b] = blocks[b].f;
    }
    chunk.counts[2] += stages * number;
    if (!adapts) return 0.0;  // `check` detects states that are not finite
    double greatest = 0.0;
    for (std::size_t b = 0; b < blocks.size(); b++) {
      BallState error{};
      for (int j = 0; j <= stages; j++)
        for (int c = 0; c < MOTION; c++) error[c] += h * method.error[j] * slopes[j][b][c];
      errors[b] = scaled_square_sum(blocks[b].start, error, broadcast<Pack>(1.0), inverse_scale);
    }
    for (int k = 0; k < number; k++) greatest = std::max(greatest, error_of(k));
    return std::sqrt(greatest / MOTION);
  }
  int worst() const {
    int worst = 0;
    for (int k = 1; k < number; k++)
      if (error_of(k) > error_of(worst)) worst = k;
    return worst;
  }
  void accept(bool fresh) {
    for (std::size_t b = 0; b < blocks.size(); b++) {
      if (fresh) before[b] = blocks[b].start, before_rates[b] = slopes[0][b];
      blocks[b].start = blocks[b].y, slopes[0][b] = slopes[method.stages][b];
    }
    advance_carried_laws();
  }
  void turn(double seconds, double, int) {
    for (std::size_t b = 0; b < blocks.size(); b++) {
      BallBlock &block = blocks[b];
      BallState middle;
      for (int c = 0; c < MOTION; c++)
        middle[c] = hermite(0.5, seconds, before[b][c], before_rates[b][c], block.start[c], slopes[0][b][c]);
      block.start_orientation = rotated(block.start_orientation, spin_in_frame(before[b]), spin_in_frame(middle),
                                        spin_in_frame(block.start), broadcast<Pack>(seconds));
      before[b] = block.start, before_rates[b] = slopes[0][b];
    }
  }

 private:
  const RungeKuttaMethod &method;
  const bool adapts;
  double inverse_scale[MOTION];
  std::vector<BallState> before, before_rates;
  std::vector<Pack> errors;
  std::vector<std::vector<BallState>> slopes;

  double error_of(int k) const {
    double error = errors[k / LANES][k % LANES];
    return error < HUGE_VAL ? error : HUGE_VAL;
  }
  void combine(double h, const double *weight, int count) {
    for (std::size_t b = 0; b < blocks.size(); b++) {
      blocks[b].y = blocks[b].start;
      for (int j = 0; j < count; j++)
        if (double factor = h * weight[j]; factor != 0.0)
          for (int c = 0; c < COLUMNS; c++) blocks[b].y[c] += factor * slopes[j][b][c];
    }
  }
};

// An implicit-explicit method: leapfrog (Stoermer, Verlet) for elastic forces, linearly implicit for friction and damping.
// Positions advance half a step, then velocities a whole one at these positions by the linearly implicit midpoint rule,
// (I - h/2 dF/dv) dv = h F, then positions the other half. Second order; elastic contacts limit the step as in leapfrog,
// friction does not, but slip that should decay within a step oscillates instead (its factor tends to -1). Contacts between
// balls are explicit.
class ImexBalls : public PrescribedBalls {
 public:
  explicit ImexBalls(const Chunk &chunk) : PrescribedBalls(chunk), first_spin(blocks.size()), spin_sum(blocks.size()) {
    start_turning();
  }

  double step(double time, double h, bool) {
    for (BallBlock &block : blocks) drift(0.5 * h, block.start), block.y = block.start;
    evaluate<true>(time + 0.5 * h);
    for (std::size_t b = 0; b < blocks.size(); b++) {
      kick(h, blocks[b]);
      drift(0.5 * h, blocks[b].start);
      spin_sum[b] = spin_sum[b] + spin_in_frame(blocks[b].start);
    }
    advance_carried_laws();
    chunk.counts[2] += number, chunk.counts[3] += number;
    return 0.0;
  }
  int worst() const { return 0; }
  void accept(bool) {}
  void turn(double, double step, int steps) {  // by the trapezoidal mean of spin
    for (std::size_t b = 0; b < blocks.size(); b++) {
      Triple last = spin_in_frame(blocks[b].start), middle;
      for (int i = 0; i < 3; i++) {  // such that Simpson's rule in `rotated` gives that mean
        Pack mean = (1.0 / steps) * (spin_sum[b][i] + 0.5 * (first_spin[b][i] - last[i]));
        middle[i] = 0.25 * (6.0 * mean - (first_spin[b][i] + last[i]));
      }
      blocks[b].start_orientation =
          rotated(blocks[b].start_orientation, first_spin[b], middle, last, broadcast<Pack>(steps * step));
    }
    start_turning();
  }

 private:
  std::vector<Triple> first_spin, spin_sum;

  void start_turning() {
    for (std::size_t b = 0; b < blocks.size(); b++) first_spin[b] = spin_in_frame(blocks[b].start), spin_sum[b] = Triple{};
  }
  static void drift(double h, BallState &ball) {
    for (int c = 0; c < VELOCITY; c++) ball[c] += h * ball[VELOCITY + c];
  }
  // The midpoint rule at fixed places: W = I/(h/2) - dF/dv, right-hand side 2 F.
  static void kick(double h, BallBlock &block) {
    BodyMatrix schur, by_position;  // unused without bodies
    for (int row = MOTION_ROWS; row < BODY_ROWS; row++)
      for (int c = 0; c < 3; c++) block.jacobian[row][BALL_POSITIONS + c] = Pack{};
    block.gamma_step = broadcast<Pack>(0.5 * h), block.start_rates = block.f;
    for (int c = 0; c < COLUMNS; c++) block.rhs[c] = 2.0 * block.f[c];
    factorise_block<false, 0>(block, schur, by_position);
    forward_eliminate_block<false, 0>(block, nullptr, nullptr);
    back_substitute_block<false, 0>(block, nullptr, nullptr, nullptr, block.stage[0]);
    for (int c = VELOCITY; c < COLUMNS; c++) block.start[c] += block.stage[0][c];
  }
};

}  // namespace core

using namespace core;

namespace {

enum Family { IMEX, RUNGE_KUTTA, LINEARLY_IMPLICIT };

}  // namespace

// Integrates balls, and ring, cage and shaft, over a chunk by a method of this family. Methods without an error estimate take equal
// steps between two outputs, none longer than `longest` [s].
CORE_EXPORT int core_integrate(const double *bearing_numbers, const double *points, std::int64_t family,
                               const double *method_numbers, const double *body_numbers, const double *load,
                               const double *load_rate, const double *drive, const double *scales, double longest, double duration,
                               std::int64_t instants, const double *times, const volatile std::uint8_t *stop, std::int64_t balls,
                               const std::uint8_t *near, double *state, double *orientation, double *steps, double *carried,
                               double *border, double *states, double *orientations, double *borders, std::int64_t *counts,
                               double *failure) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  CoupledBodies bodies = bodies_of(body_numbers, load, load_rate);
  BodyState body_state = state_of(bearing, bodies, border);
  std::vector<double> body_states(instants * BODY_NUMBERS);
  Chunk chunk{bearing, bodies, drive_of(drive), duration, scales,  int(instants),     times,  stop,         int(balls),
              near,    state,  orientation,     steps,    carried, body_state.data(), states, orientations, body_states.data(),
              counts,  failure};
  auto with_common_steps = [&](auto &&motion, const Pace &pace) {
    double next = 0.0;
    Status status = integrate_together(motion, pace, duration, int(instants), times, stop, counts, failure, next);
    if (status == OK) std::fill(steps, steps + balls, next);
    return status;
  };
  if (family == IMEX) return with_common_steps(ImexBalls(chunk), {longest, 0, true});
  if (family == RUNGE_KUTTA) {
    RungeKuttaMethod method = runge_kutta_of(method_numbers);
    return with_common_steps(ExplicitBalls(chunk, method),
                             {method.adapts() ? steps[0] : longest, method.adapts() ? method.order : 0, false});
  }
  Status status = by_rosenbrock(chunk, rosenbrock_of(method_numbers));
  if (status != OK || Layout(bodies).unknowns == 0) return status;
  auto write = [&](const double *body_numbers, double *out) {
    for_each_number(bodies, true, [&](int number, int border_number) { out[border_number] = body_numbers[number]; });
  };
  write(body_state.data(), border);
  for (int i = 0; i < instants; i++) write(body_states.data() + i * BODY_NUMBERS, borders + i * BORDER);
  return status;
}

// Rates (balls, COLUMNS) of all balls in a state (balls, COLUMNS) with the ring at this speed [rad/s] and angle [rad].
CORE_EXPORT void core_all_rates(const double *bearing_numbers, const double *points, double ring_speed, double ring_angle,
                                std::int64_t balls, const std::uint8_t *near, double *state, double *rates) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  CoupledBodies bodies{};
  std::vector<double> orientations(4 * balls), carried(CARRIED * balls);
  Chunk chunk{bearing, bodies, {ring_angle, ring_speed, 0.0}, 0.0,     nullptr,        0,       nullptr, nullptr, int(balls),
              near,    state,  orientations.data(),           nullptr, carried.data(), nullptr, nullptr, nullptr, nullptr,
              nullptr, nullptr};
  PrescribedBalls(chunk).start_rates(rates);
}

// See `neighbours`.
CORE_EXPORT void core_mark_near(double ball_radius, const double *state, std::int64_t balls, double reach, double ahead,
                                std::uint8_t *near) {
  neighbours::mark_near(ball_radius, {state, int(balls)}, reach, ahead, near);
}
CORE_EXPORT std::int64_t core_mark_met(double ball_radius, const double *state, std::int64_t balls, const double *states,
                                       std::int64_t instants, double reach, std::uint8_t *near) {
  return neighbours::mark_met(ball_radius, {state, int(balls)}, states, int(instants), reach, near);
}
CORE_EXPORT double core_time_apart(double ball_radius, const double *state, std::int64_t balls, double reach) {
  return neighbours::time_apart(ball_radius, {state, int(balls)}, reach);
}
