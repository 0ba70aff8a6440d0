// All balls between rings whose motion is prescribed, stepped together by explicit or implicit-explicit methods, with what
// neighbours do to each other.
#pragma once
#include "ball_rates.hpp"
#include "neighbours.hpp"

namespace core {

using Blocks = std::vector<BallState>;  // ball after ball in lanes; a lane without one repeats the last ball

inline Blocks blocks_of(const double *state, int balls) {
  Blocks blocks((balls + LANES - 1) / LANES);
  for (int place = 0; place < int(blocks.size()) * LANES; place++)
    for (int c = 0; c < COLUMNS; c++)
      blocks[place / LANES][c][place % LANES] = state[std::min(place, balls - 1) * COLUMNS + c];
  return blocks;
}

// Rates of all balls. near[k] says whether ball k may touch the next ahead. Damping never pulls, and what elastic energy is
// left then is lost at once, of which no error of a motion tells: with `storing` = 1 the integral of losses takes in what
// contacts of balls store, too (`add_stored`).
struct AllBalls {
  const Bearing &bearing;
  Drive drive;
  int balls;
  const std::uint8_t *near;
  double storing;
  std::vector<CarriedBalls> carried;  // block after block; none where the law carries no states

  AllBalls(const Bearing &bearing, const Drive &drive, int balls, const std::uint8_t *near, double storing)
      : bearing(bearing), drive(drive), balls(balls), near(near), storing(storing) {}

  const CarriedBalls *states(std::size_t block) const { return carried.empty() ? nullptr : &carried[block]; }
  void load(const double *numbers) {
    if (bearing.carried == CarriedLaw::none) return;
    carried.resize((balls + LANES - 1) / LANES);
    for (int place = 0; place < int(carried.size()) * LANES; place++)
      load_carried(numbers + std::min(place, balls - 1) * CARRIED, place % LANES, carried[place / LANES]);
  }
  void store(double *numbers) const {
    for (int k = 0; k < balls && !carried.empty(); k++) store_carried(carried[k / LANES], k % LANES, numbers + k * CARRIED);
  }
  // Ends a step.
  void carry_on(const Blocks &y) {
    for (std::size_t b = 0; b < carried.size(); b++)
      for (int lane = 0; lane < LANES; lane++) core::carry_on(bearing, y[b], lane, carried[b]);
  }

  // Of raceways: orientations, on which heights of balls depend, turn apart from the states.
  Heights heights(double time, const Pack &speed, const BallState &y) const {
    if (!bearing.defects.count) return {};
    Pack turned = broadcast<Pack>(drive.angle_at(time));
    return heights_at(bearing.defects, surface_places(y[ANGLE], y[VELOCITY + 1] / y[RADIUS], turned, speed, Quaternion{}, Triple{}, Mask{}), Pack{});
  }

  template <class Evaluate>
  void rates(double time, const Blocks &y, Blocks &out, Evaluate evaluate) const {
    Pack speed = broadcast<Pack>(drive.speed + drive.acceleration * time);
    for (std::size_t b = 0; b < y.size(); b++) evaluate(b, speed, heights(time, speed, y[b]), y[b], out[b]);
    for (int k = 0; k < balls; k++)
      if (near[k]) add_contact(k, k + 1 < balls ? k + 1 : 0, y, out);
  }
  void rates(double time, const Blocks &y, Blocks &out) const {
    for_kind_of(bearing, [&]<bool PATCH, bool TILTED>() {
      rates(time, y, out, [&](std::size_t b, const Pack &speed, const Heights &heights, const BallState &ball, BallState &rate) {
        evaluate_rates<PATCH, TILTED>(bearing, speed, states(b), heights, ball, rate);
      });
    });
  }

 private:
  void add_contact(int own, int next, const Blocks &y, Blocks &out) const {
    auto [contact, c, s] = contact_with_next(bearing, own, next, [&](int k, int column) { return double(y[k / LANES][column][k % LANES]); });
    auto add = [&](int k, int first, const Vector3<double> &v) {
      BallState &to = out[k / LANES];
      to[first][k % LANES] += v.x, to[first + 1][k % LANES] += v.y, to[first + 2][k % LANES] += v.z;
    };
    auto acceleration = (1.0 / bearing.ball_mass) * contact.force, turning = (1.0 / bearing.ball_inertia) * contact.torque;
    add(own, VELOCITY, acceleration), add(own, SPIN, turning);
    out[own / LANES][DISSIPATED][own % LANES] += contact.loss + storing * contact.stored;
    add(next, VELOCITY, about_z(c, -s, -1.0 * acceleration)), add(next, SPIN, about_z(c, -s, turning));
  }
};

// Adds a share of what contacts of neighbours store [J] to the losses of the ball behind, in states (balls, COLUMNS).
inline void add_stored(const Bearing &bearing, int balls, const std::uint8_t *near, double share, double *state) {
  for (int k = 0; k < balls; k++) {
    if (!near[k]) continue;
    auto get = [&](int ball, int column) { return state[ball * COLUMNS + column]; };
    state[k * COLUMNS + DISSIPATED] += share * std::get<0>(contact_with_next(bearing, k, k + 1 < balls ? k + 1 : 0, get)).energy;
  }
}

// Start and results of a chunk (`Results` of integrate.py): state (balls, COLUMNS) and orientation (balls, 4), in place, and both at
// the instants.
struct CommonResults { double *state, *orientation, *states, *orientations; };

// Shared part of all methods: motion and orientation in lanes.
class CommonBalls {
 public:
  const std::int64_t number;

  CommonBalls(AllBalls &all, const CommonResults &results)
      : number(all.balls), all(all), out(results), y(blocks_of(results.state, all.balls)), turned(y.size()) {
    for (int place = 0; place < int(y.size()) * LANES; place++)
      for (int c = 0; c < 4; c++)
        turned[place / LANES][c][place % LANES] = out.orientation[std::min<std::int64_t>(place, number - 1) * 4 + c];
  }

  void keep(int row) const {
    double *state = row < 0 ? out.state : out.states + row * number * COLUMNS;
    double *orientation = row < 0 ? out.orientation : out.orientations + row * number * 4;
    for (int k = 0; k < number; k++) {
      for (int c = 0; c < COLUMNS; c++) state[k * COLUMNS + c] = y[k / LANES][c][k % LANES];
      for (int c = 0; c < 4; c++) orientation[k * 4 + c] = turned[k / LANES][c][k % LANES];
    }
  }
  std::pair<Status, int> check() const {
    for (int k = 0; k < number; k++) {
      double state[COLUMNS];
      for (int c = 0; c < COLUMNS; c++) state[c] = y[k / LANES][c][k % LANES];
      if (Status status = check_ball(all.bearing, state); status != OK) return {status, k};
    }
    return {OK, 0};
  }

 protected:
  AllBalls &all;
  const CommonResults &out;
  Blocks y;
  std::vector<Quaternion> turned;
};

// By an explicit method. Unstable above about 3 / (fastest rate): contact frequency or mu N / (m v_s).
class ExplicitBalls : public CommonBalls {
 public:
  ExplicitBalls(AllBalls &all, const CommonResults &results, const RungeKuttaMethod &method, const double *scales, std::int64_t *counts)
      : CommonBalls(all, results), method(method), adapts(method.adapts()), scales(scales), counts(counts), trial(y), before(y),
        before_rates(y.size()), errors(y.size()), slopes(method.stages + 1, Blocks(y.size())) {}

  double step(double time, double h, bool begun) {
    int stages = method.stages;
    for (int stage = begun ? 1 : 0; stage <= stages; stage++) {
      bool end = stage == stages;
      combine(h, end ? method.weight : method.a[stage], stage);
      all.rates(end ? time + h : time + method.node[stage] * h, trial, slopes[stage]);
    }
    counts[2] += stages * number;
    if (!adapts) return 0.0;  // what is not finite is found by `check`
    double greatest = 0.0;
    for (std::size_t b = 0; b < y.size(); b++) {
      errors[b] = Pack{};
      for (int c = 0; c < MOTION; c++) {
        Pack sum{};
        for (int j = 0; j <= stages; j++) sum += method.error[j] * slopes[j][b][c];
        Pack ratio = h * sum / scales[c];
        errors[b] += ratio * ratio;
      }
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
  void move_on(bool fresh) {
    if (fresh) before = y, before_rates = slopes[0];
    y = trial, slopes[0] = slopes[method.stages];
    all.carry_on(y);
  }
  void turn(double seconds, double, int) {
    for (std::size_t b = 0; b < y.size(); b++) {
      BallState middle;
      for (int c = 0; c < MOTION; c++) middle[c] = hermite(0.5, seconds, before[b][c], before_rates[b][c], y[b][c], slopes[0][b][c]);
      turned[b] = rotated(turned[b], spin_in_frame(before[b]), spin_in_frame(middle), spin_in_frame(y[b]), broadcast<Pack>(seconds));
    }
    before = y, before_rates = slopes[0];
  }

 private:
  const RungeKuttaMethod &method;
  const bool adapts;
  const double *scales;
  std::int64_t *counts;
  Blocks trial, before, before_rates;
  std::vector<Pack> errors;
  std::vector<Blocks> slopes;

  double error_of(int k) const {
    double error = errors[k / LANES][k % LANES];
    return error < HUGE_VAL ? error : HUGE_VAL;
  }
  void combine(double h, const double *weight, int count) {
    trial = y;
    for (int j = 0; j < count; j++)
      if (double factor = h * weight[j]; factor != 0.0)
        for (std::size_t b = 0; b < y.size(); b++)
          for (int c = 0; c < COLUMNS; c++) trial[b][c] += factor * slopes[j][b][c];
  }
};

// By an implicit-explicit step: leapfrog (Stoermer, Verlet) for what contacts push, linearly implicit for what resists
// motion. Places take half a step, then velocities a whole one at the places in between by the linearly implicit midpoint
// rule, (I - h/2 dF/dv) dv = h F, then places the other half. Second order; elastic contacts limit the step as in leapfrog,
// friction does not, but slip that ought to die within a step rings instead (its factor tends to -1). What balls do to each
// other is taken explicitly.
class ImexBalls : public CommonBalls {
 public:
  ImexBalls(AllBalls &all, const CommonResults &results, std::int64_t *counts)
      : CommonBalls(all, results), counts(counts), rates(y.size()), jacobians(y.size()), first_spin(y.size()), spin_sum(y.size()) {
    begin_turning();
  }

  double step(double time, double h, bool) {
    for (BallState &ball : y) drift(0.5 * h, true, ball);
    for_kind_of(all.bearing, [&]<bool PATCH, bool TILTED>() {
      all.rates(time + 0.5 * h, y, rates, [&](std::size_t b, const Pack &speed, const Heights &heights, const BallState &ball, BallState &rate) {
        evaluate_rates_and_jacobian<PATCH, TILTED>(all.bearing, speed, all.states(b), heights, ball, rate, jacobians[b]);
      });
    });
    for (std::size_t b = 0; b < y.size(); b++) {
      kick(h, rates[b], jacobians[b], y[b]);
      drift(0.5 * h, false, y[b]);
      spin_sum[b] = spin_sum[b] + spin_in_frame(y[b]);
    }
    all.carry_on(y);
    counts[2] += number, counts[3] += number;
    return 0.0;
  }
  int worst() const { return 0; }
  void move_on(bool) {}
  void turn(double, double step, int steps) {  // by the trapezoidal mean of spin
    for (std::size_t b = 0; b < y.size(); b++) {
      Triple last = spin_in_frame(y[b]), middle;
      for (int i = 0; i < 3; i++) {  // of which `rotated` finds that mean
        Pack mean = (1.0 / steps) * (spin_sum[b][i] + 0.5 * (first_spin[b][i] - last[i]));
        middle[i] = 0.25 * (6.0 * mean - (first_spin[b][i] + last[i]));
      }
      turned[b] = rotated(turned[b], first_spin[b], middle, last, broadcast<Pack>(steps * step));
    }
    begin_turning();
  }

 private:
  std::int64_t *counts;
  Blocks rates;
  std::vector<BallJacobian> jacobians;
  std::vector<Triple> first_spin, spin_sum;

  void begin_turning() {
    for (std::size_t b = 0; b < y.size(); b++) first_spin[b] = spin_in_frame(y[b]), spin_sum[b] = Triple{};
  }
  // Moves places by h; the angle turns at the radius in the middle of the step, `before` it or after.
  static void drift(double h, bool before, BallState &ball) {
    Pack radius = ball[RADIUS], moved = radius + h * ball[VELOCITY];
    ball[RADIUS] = moved;
    ball[ANGLE] += h * ball[VELOCITY + 1] / (before ? moved : radius);
    ball[HEIGHT] += h * ball[VELOCITY + 2];
  }
  // The midpoint rule at fixed places: W = I/(h/2) - dF/dv, right-hand side 2 F.
  static void kick(double h, const BallState &rate, BallJacobian &j, BallState &ball) {
    j.orbit_by_radius = j.orbit_by_velocity = Pack{};
    for (auto &row : j.row) row[RADIUS] = row[ANGLE] = row[HEIGHT] = Pack{};
    Pack g = broadcast<Pack>(0.5 * h);
    BallFactors factors;
    BallState right, change;
    for (int c = 0; c < COLUMNS; c++) right[c] = 2.0 * rate[c];
    factorise(j, g, factors);
    solve(j, factors, g, right, change);
    for (int c = VELOCITY; c < COLUMNS; c++) ball[c] += change[c];
  }
};

}  // namespace core
