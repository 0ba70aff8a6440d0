// Balls between rings whose motion is prescribed, alone or stepped together, and where they start; exported functions on
// C-contiguous arrays of doubles.
#include <cmath>
#include "ball_rates.hpp"
#include "free_balls.hpp"
#include "neighbours.hpp"
#include "numbers.hpp"
#include "raceway_contact.hpp"

namespace core {

// All balls between rings whose motion is prescribed, stepped together by explicit or implicit-explicit methods, with what
// neighbours do to each other.

using Blocks = std::vector<BallState>;  // ball after ball in lanes; a lane without one repeats the last ball

inline Blocks blocks_of(const double *state, int balls) {
  Blocks blocks((balls + LANES - 1) / LANES);
  for (int place = 0; place < int(blocks.size()) * LANES; place++)
    for (int c = 0; c < COLUMNS; c++)
      blocks[place / LANES][c][place % LANES] = state[std::min(place, balls - 1) * COLUMNS + c];
  return blocks;
}

// Rates of all balls. near[k] says whether ball k may touch the next ahead. Damping never pulls, and what elastic energy is
// left then is lost at once, which no error of a motion shows: with `storing` = 1 the integral of losses takes in what
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

// Where balls rest between the raceways of a bearing whose rings are held, and the motion with which they roll there.
namespace core::start {

constexpr double REACH = 0.02;  // of the ball radius: rest is looked for so far around the middle between the raceways
constexpr double EXACT = 1e-16;  // m, of a rest
constexpr int MOST_STEPS = 60;
constexpr double ROUNDING_SPIN = 1e-9, DRILLING_SPIN = 0.03;  // of a ball's surface speed: spin that changes slip by less

// Radial and axial force [N] on a ball by the elastic loads of both contacts and its orbit.
template <Number R, Number Z>
inline auto static_force(const Bearing &bearing, double orbit_rate, const R &radius, double angle, const Z &height) {
  double cosine = std::cos(angle), sine = std::sin(angle);
  Vector3 position{radius, Zero{}, height};
  auto push = [&](const Raceway &raceway, const auto &offset) {
    auto at = contact_place(bearing, raceway, offset, Zero{});
    return std::pair{-1.0 * (at.load * at.normal.x), -1.0 * (at.load * at.normal.z)};
  };
  const double *o = bearing.offset;
  auto inner = push(bearing.inner, position - about_z(cosine, -sine, Vector3{o[0], o[1], o[2]}));
  auto outer = push(bearing.outer, position);
  auto centrifugal = bearing.ball_mass * orbit_rate * orbit_rate * radius;
  return std::pair{inner.first + outer.first + centrifugal, inner.second + outer.second};
}

// Newton's method within a bracket of a force that falls.
struct Bracket {
  double low, high;
  double next(double force, double slope, double at) {
    (force > 0.0 ? low : high) = at;
    double wanted = slope < 0.0 ? at - force / slope : high;
    return low < wanted && wanted < high ? wanted : 0.5 * (low + high);
  }
};

// Axis distance [m] without radial force at this height; not a number where there is none near the nominal one.
inline double radial_rest(const Bearing &bearing, double orbit_rate, double angle, double nominal, double height) {
  double reach = REACH * bearing.ball_radius, distance = nominal;
  Bracket bracket{nominal - reach, nominal + reach};
  auto radial = [&](double r) { return static_force(bearing, orbit_rate, r, angle, height).first; };
  if (!(radial(bracket.low) >= 0.0 && 0.0 >= radial(bracket.high))) return NAN;
  for (int i = 0; i < MOST_STEPS; i++) {
    auto force = static_force(bearing, orbit_rate, variable<0>(distance), angle, height).first;
    double before = distance;
    if (force.value != 0.0) distance = bracket.next(force.value, force.slope[0], distance);
    if (std::fabs(distance - before) <= EXACT) break;
  }
  return distance;
}

struct Rest { double distance, height; };

// With clearance a ball rests on the raceway that its orbit presses it to, in the middle where nothing does.
inline Rest rest(const Bearing &bearing, double orbit_rate, double angle) {
  const Raceway &inner = bearing.inner, &outer = bearing.outer;
  double share = (inner.groove_radius - bearing.ball_radius) / (inner.groove_radius + outer.groove_radius - 2.0 * bearing.ball_radius);
  double nominal = inner.locus_radius + (outer.locus_radius - inner.locus_radius) * share;
  nominal += 0.5 * (std::cos(angle) * bearing.offset[0] + std::sin(angle) * bearing.offset[1]);
  double offset = bearing.offset[2], height = 0.5 * offset;
  Bracket bracket{std::fmin(0.0, offset), std::fmax(0.0, offset)};
  double distance = radial_rest(bearing, orbit_rate, angle, nominal, height);
  for (int i = 0; i < MOST_STEPS; i++) {
    if (bracket.low == bracket.high || !(distance < HUGE_VAL)) break;
    auto [radial, axial] = static_force(bearing, orbit_rate, variable<0>(distance), angle, variable<1>(height));
    double before = height;
    if (axial.value != 0.0) {  // along the heights at which nothing pushes radially
      double slope = axial.slope[1] - axial.slope[0] * radial.slope[1] / radial.slope[0];
      height = bracket.next(axial.value, slope, height);
    }
    if (std::fabs(height - before) <= EXACT) break;
    distance = radial_rest(bearing, orbit_rate, angle, nominal, height);
  }
  return {distance, height};
}

using Doubles = Vector3<double>;

struct Slips { double slip[6]; bool pressed; };

// Slip at both raceways of a ball with this tangential velocity and angular velocity.
inline Slips slips(const Bearing &bearing, double ring_speed, double angle, const Rest &place, const double (&motion)[4]) {
  double cosine = std::cos(angle), sine = std::sin(angle);
  const double *o = bearing.offset;
  Doubles position{place.distance, 0.0, place.height}, velocity{0.0, motion[0], 0.0}, spin{motion[1], motion[2], motion[3]};
  Slips found{{}, true};
  double *to = found.slip;
  for (bool inner : {true, false}) {
    Doubles offset = inner ? position - about_z(cosine, -sine, Doubles{o[0], o[1], o[2]}) : position;
    auto at = contact_place(bearing, inner ? bearing.inner : bearing.outer, offset, inner ? ring_speed : 0.0);
    auto surface = Doubles{at.surface_velocity.x, at.surface_velocity.y, 0.0};
    auto relative = (velocity + cross(spin, at.arm)) - surface;
    auto slip = relative - dot(relative, at.normal) * at.normal;
    *to++ = slip.x, *to++ = slip.y, *to++ = slip.z;
    found.pressed &= at.approach > 0.0;
  }
  return found;
}

// The shortest x that makes |matrix x - right| least; singular values below `share` of the greatest count as zero.
// One-sided Jacobi (Golub and Van Loan, Matrix Computations, 4th ed., section 8.6.3).
inline void least_squares(double (&matrix)[6][4], const double (&right)[6], double share, double (&x)[4]) {
  double turned[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}, square[4] = {}, greatest = 0.0;
  auto rotate = [](auto &table, int p, int q, double cosine, double sine) {
    for (auto &row : table) {
      double first = row[p], second = row[q];
      row[p] = cosine * first - sine * second, row[q] = sine * first + cosine * second;
    }
  };
  for (int sweep = 0, settled = 0; sweep < 30 && !settled; sweep++) {
    settled = 1;
    for (int p = 0; p < 3; p++)
      for (int q = p + 1; q < 4; q++) {
        double alpha = 0.0, beta = 0.0, gamma = 0.0;
        for (auto &row : matrix) alpha += row[p] * row[p], beta += row[q] * row[q], gamma += row[p] * row[q];
        if (gamma * gamma <= 1e-32 * alpha * beta) continue;
        settled = 0;
        double zeta = (beta - alpha) / (2.0 * gamma);
        double tangent = std::copysign(1.0, zeta) / (std::fabs(zeta) + std::sqrt(1.0 + zeta * zeta));
        double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent);
        rotate(matrix, p, q, cosine, cosine * tangent), rotate(turned, p, q, cosine, cosine * tangent);
      }
  }
  for (int p = 0; p < 4; p++) {
    x[p] = 0.0;
    for (auto &row : matrix) square[p] += row[p] * row[p];
    greatest = std::fmax(greatest, square[p]);
  }
  for (int p = 0; p < 4; p++) {
    if (!(square[p] > share * share * greatest)) continue;
    double along = 0.0;
    for (int i = 0; i < 6; i++) along += matrix[i][p] * right[i];
    for (int i = 0; i < 4; i++) x[i] += turned[i][p] * along / square[p];
  }
}

// Tangential velocity and angular velocity of a ball that slips on neither raceway, by least squares: slip is linear in
// them. Among several motions the one with least spin; spin that changes slip by less than `share` is left out.
inline void rolling(const Bearing &bearing, double ring_speed, double angle, const Rest &place, double share, double (&motion)[4]) {
  double unit[4] = {}, matrix[6][4], right[6], scale[4];
  Slips none = slips(bearing, ring_speed, angle, place, unit);
  for (int j = 0; j < 4; j++) {
    scale[j] = j > 0 ? 1.0 / bearing.ball_radius : 1.0;
    unit[j] = 1.0;
    Slips one = slips(bearing, ring_speed, angle, place, unit);
    unit[j] = 0.0;
    for (int i = 0; i < 6; i++) matrix[i][j] = (one.slip[i] - none.slip[i]) * scale[j];
  }
  for (int i = 0; i < 6; i++) right[i] = -none.slip[i];
  least_squares(matrix, right, share, motion);
  for (int j = 0; j < 4; j++) motion[j] *= scale[j];
}

inline void let_roll(const Bearing &bearing, double ring_speed, double share, double *ball) {
  double motion[4];
  rolling(bearing, ring_speed, ball[ANGLE], {ball[RADIUS], ball[HEIGHT]}, share, motion);
  ball[VELOCITY + 1] = motion[0];
  for (int i = 0; i < 3; i++) ball[SPIN + i] = motion[1 + i];
}

// Fills the states (balls, COLUMNS) of evenly spaced balls that rest between the raceways, and roll there if they are to.
// Balls that both raceways press roll without spin about their contacts: it changes slip only by as much as an inner
// ring off the axis puts the contacts off one line, and takes seconds to settle. False where a ball has no rest.
inline bool place_balls(const Bearing &bearing, double ring_speed, bool rolls, int balls, double *state) {
  bool pressed = true;
  for (int k = 0; k < balls; k++) {
    double angle = 2.0 * M_PI * k / balls, motion[4] = {};
    Rest place = rest(bearing, 0.0, angle);
    for (int i = 0; rolls && i < 3; i++) {
      rolling(bearing, ring_speed, angle, place, ROUNDING_SPIN, motion);
      place = rest(bearing, motion[0] / place.distance, angle);
    }
    if (!(place.distance < HUGE_VAL)) return false;
    double *ball = state + k * COLUMNS;
    ball[RADIUS] = place.distance, ball[ANGLE] = angle, ball[HEIGHT] = place.height;
    if (rolls) let_roll(bearing, ring_speed, ROUNDING_SPIN, ball);
    pressed &= slips(bearing, ring_speed, angle, place, motion).pressed;
  }
  for (int k = 0; rolls && pressed && k < balls; k++) let_roll(bearing, ring_speed, DRILLING_SPIN, state + k * COLUMNS);
  return true;
}

}  // namespace core::start

using namespace core;

CORE_EXPORT int core_free_balls(
    const double *bearing_numbers, const double *points, const double *method_numbers, const double *drive,
    const double *scales, double duration, std::int64_t instants, const double *times, const volatile std::uint8_t *stop,
    std::int64_t count, const std::int64_t *numbers, std::int64_t balls, double *state, double *orientation, double *steps, double *carried, double *states,
    double *orientations, std::int64_t *counts, double *failure) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  RosenbrockMethod method = method_of(method_numbers);
  Chunk chunk{bearing, method, {drive[0], drive[1], drive[2]}, duration, {}, int(instants), times, stop};
  std::copy(scales, scales + SCALES, chunk.scale);
  Results results{int(balls), state, orientation, steps, carried, states, orientations, counts, failure};
  return for_kind_of(bearing, [&]<bool PATCH, bool TILTED>() {
    return free_balls::Integration<PATCH, TILTED>(chunk, results).run(numbers, int(count));
  });
}

// Rates (12,) and Jacobian (9, 9) of one ball's motion, for tests: values and derivatives of the same functions. `carried`
// (CARRIED,) counts where the law carries states.
CORE_EXPORT void core_ball_rates(const double *bearing_numbers, const double *points, double ring_speed,
                                                    const double *state, const double *carried, double *rates, double *jacobian) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  BallState y, f;
  BallJacobian j;
  for (int c = 0; c < COLUMNS; c++) y[c] = broadcast<Pack>(state[c]);
  Pack speed = broadcast<Pack>(ring_speed);
  CarriedBalls states;
  for (int lane = 0; lane < LANES; lane++) load_carried(carried, lane, states);
  const CarriedBalls *given = bearing.carried == CarriedLaw::none ? nullptr : &states;
  for_kind_of(bearing, [&]<bool PATCH, bool TILTED>() { evaluate_rates_and_jacobian<PATCH, TILTED>(bearing, speed, given, Heights{}, y, f, j); });
  for (int c = 0; c < COLUMNS; c++) rates[c] = f[c][0];
  std::fill(jacobian, jacobian + MOTION * MOTION, 0.0);
  jacobian[0 * MOTION + VELOCITY] = jacobian[2 * MOTION + VELOCITY + 2] = 1.0;
  jacobian[1 * MOTION + RADIUS] = j.orbit_by_radius[0], jacobian[1 * MOTION + VELOCITY + 1] = j.orbit_by_velocity[0];
  for (int row = 0; row < 6; row++)
    for (int column = 0; column < MOTION; column++) jacobian[(VELOCITY + row) * MOTION + column] = j.row[row][column][0];
}
// States (balls, COLUMNS) of evenly spaced balls at rest between the raceways, rolling there if they are to; 0 where one
// has no rest.
CORE_EXPORT std::int64_t core_place_balls(const double *bearing_numbers, const double *points, double ring_speed,
                                          std::int64_t rolls, std::int64_t balls, double *state) {
  return start::place_balls(bearing_of(bearing_numbers, points), ring_speed, rolls != 0, int(balls), state);
}

namespace {

RungeKuttaMethod runge_kutta_of(const double *numbers) {
  RungeKuttaMethod m{};
  Reader read(numbers);
  m.stages = read.integer(), m.order = read.integer();
  read(m.a, m.node, m.weight, m.error);
  return m;
}

}  // namespace

// An explicit method, or for a method of no stages the implicit-explicit one. Without an error estimate steps between two
// instants are equal, none longer than `longest` [s]; with one they adapt from there, and `next` [s] is the step to go on with.
CORE_EXPORT int core_common_balls(const double *bearing_numbers, const double *points, const double *method_numbers, const double *drive,
                                  const double *scales, double longest, double duration, std::int64_t instants, const double *times,
                                  const volatile std::uint8_t *stop, std::int64_t number, const std::uint8_t *near, double *state,
                                  double *orientation, double *carried, double *states, double *orientations, std::int64_t *counts, double *failure,
                                  double *next) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  bool implicit = method_numbers[0] == 0.0;
  AllBalls all{bearing, {drive[0], drive[1], drive[2]}, int(number), near, implicit ? 0.0 : 1.0};
  all.load(carried);
  CommonResults results{state, orientation, states, orientations};
  auto stepped = [&](auto &balls, const Pace &pace) {
    Status status = step_together(balls, pace, duration, int(instants), times, stop, counts, failure, *next);
    all.store(carried);
    return status;
  };
  if (implicit) {
    ImexBalls balls(all, results, counts);
    return stepped(balls, {longest, 0, true});
  }
  RungeKuttaMethod method = runge_kutta_of(method_numbers);
  ExplicitBalls balls(all, results, method, scales, counts);
  return stepped(balls, {longest, method.adapts() ? method.order : 0, false});
}

// Rates (balls, COLUMNS) of all balls in a state (balls, COLUMNS) with the ring at this speed [rad/s] and angle [rad].
CORE_EXPORT void core_all_rates(const double *bearing_numbers, const double *points, double ring_speed, double ring_angle, std::int64_t number,
                                const std::uint8_t *near, const double *state, double *rates) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  Blocks y = blocks_of(state, int(number)), found(y.size());
  AllBalls{bearing, {ring_speed, 0.0, ring_angle}, int(number), near, 1.0}.rates(0.0, y, found);
  for (int k = 0; k < number; k++)
    for (int c = 0; c < COLUMNS; c++) rates[k * COLUMNS + c] = found[k / LANES][c][k % LANES];
}

// See `add_stored`; states (instants, balls, COLUMNS).
CORE_EXPORT void core_add_stored(const double *bearing_numbers, const double *points, std::int64_t number, const std::uint8_t *near,
                                 double share, std::int64_t instants, double *states) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  for (int i = 0; i < instants; i++) add_stored(bearing, int(number), near, share, states + i * number * COLUMNS);
}

// Which balls may meet.
CORE_EXPORT void core_mark_near(double ball_radius, const double *state, std::int64_t balls, double reach, double ahead, std::uint8_t *near) {
  neighbours::mark_near(ball_radius, {state, int(balls)}, reach, ahead, near);
}
CORE_EXPORT std::int64_t core_mark_met(double ball_radius, const double *state, std::int64_t balls, const double *states,
                                       std::int64_t instants, double reach, std::uint8_t *near) {
  return neighbours::mark_met(ball_radius, {state, int(balls)}, states, int(instants), reach, near);
}
CORE_EXPORT double core_time_apart(double ball_radius, const double *state, std::int64_t balls, double reach) {
  return neighbours::time_apart(ball_radius, {state, int(balls)}, reach);
}
