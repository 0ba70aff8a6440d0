// Balls that touch each other: the contact of a ball with the next ahead, and the dense linear system of those that touch and of the
// bodies, whose coordinates come last, where elimination fills least; all other balls are eliminated before.
#pragma once
#include "../math/linear.hpp"
#include "ball_system.hpp"
#include "neighbours.hpp"

namespace core {

constexpr int PAIR_ROWS = 7;  // a ball's accelerations, and the loss of the contact, which counts for the ball behind

// Contact of each ball of a block with the next ahead.
struct PairBlock {
  BallState next{};
  Pack full_turn{};  // added to the angle of the next [rad]
  Mask may_touch{}, touches{};
  Pack on_next[6]{};  // rates of the next ball by the contact
  Pack by_next[PAIR_ROWS][MOTION]{}, next_by_own[6][MOTION]{}, next_by_next[6][MOTION]{};
};

// Rows of the ball and, from NEXT on, of the next one, whose motions are columns 0 to 8 and 9 to 17; returns the approach.
constexpr int NEXT = LOSS_ROW + 1;
template <bool DERIVATIVES, class Put>
CORE_INLINE Pack ball_and_next(const Bearing &bearing, const BallState &ball, const BallState &next, const Pack &full_turn,
                               Put put) {
  auto motion = [&]<int FIRST>(Index<FIRST>, const BallState &y) __attribute__((always_inline)) {
    auto number = [&]<int C>(Index<C>) __attribute__((always_inline)) { return input<DERIVATIVES, FIRST + C>(y[C]); };
    auto radius = number(index<RADIUS>);
    return std::tuple{Vector3{radius, Zero{}, number(index<HEIGHT>)},
                      Vector3{number(index<VELOCITY>), radius * number(index<ORBIT_RATE>), number(index<VELOCITY + 2>)},
                      Vector3{number(index<SPIN>), number(index<SPIN + 1>), number(index<SPIN + 2>)}, number(index<ANGLE>)};
  };
  auto [position, velocity, spin, angle] = motion(index<0>, ball);
  auto [next_position, next_velocity, next_spin, next_angle] = motion(index<MOTION>, next);
  auto [cosine, sine] = cosine_sine((next_angle - angle) + full_turn);
  auto c = cosine, s = sine, minus_s = -sine;
  auto ahead = [&](const auto &v) __attribute__((always_inline)) { return about_z(c, s, v); };
  auto back = [&](const auto &v) __attribute__((always_inline)) { return about_z(c, minus_s, v); };
  auto between = ahead(next_position) - position, relative = velocity - ahead(next_velocity), spin_sum = spin + ahead(next_spin);
  auto contact = pair_contact(bearing, local<0>(between), local<3>(relative), local<6>(spin_sum));
  auto chain = [&](const auto &x) __attribute__((always_inline)) {
    return composed(x, between.x, between.y, between.z, relative.x, relative.y, relative.z, spin_sum.x, spin_sum.y, spin_sum.z);
  };
  auto force = chain(contact.force), torque = chain(contact.torque);
  double inverse_mass = 1.0 / bearing.ball_mass, inverse_inertia = 1.0 / bearing.ball_inertia;
  auto rows = [&]<int FIRST>(Index<FIRST>, double sign, const auto &radius, const auto &f,
                             const auto &t) __attribute__((always_inline)) {
    put(index<FIRST + RADIAL_ROW>, (sign * inverse_mass) * f.x), put(index<FIRST + ORBIT_ROW>, sign * (radius * f.y));
    put(index<FIRST + AXIAL_ROW>, (sign * inverse_mass) * f.z), put(index<FIRST + SPIN_ROW>, inverse_inertia * t.x);
    put(index<FIRST + SPIN_ROW + 1>, inverse_inertia * t.y), put(index<FIRST + SPIN_ROW + 2>, inverse_inertia * t.z);
  };
  rows(index<0>, 1.0, position.x, force, torque);
  rows(index<NEXT>, -1.0, next_position.x, back(force), back(torque));
  put(index<LOSS_ROW>, chain(contact.loss));
  return value_of(contact.approach);
}

// Adds the contacts of a block to its rates; with DERIVATIVES to its Jacobian, too. Those of the next balls are left in `pair`.
template <bool DERIVATIVES>
[[gnu::noinline]] inline void block_pair_forces(const Bearing &bearing, BallBlock &block, PairBlock &pair) {
  if constexpr (DERIVATIVES) pair = {pair.next, pair.full_turn, pair.may_touch};
  auto put = [&]<int ROW>(Index<ROW>, const auto &x) __attribute__((always_inline)) {
    constexpr int row = ROW == LOSS_ROW ? PAIR_ROWS - 1 : ROW % NEXT;
    if constexpr (ROW >= NEXT) pair.on_next[row] = masked(pair.may_touch, value_of(x));
    else block.f[VELOCITY + ROW] += masked(pair.may_touch, value_of(x));
    if constexpr (DERIVATIVES)
      for_each_slope(x, [&](int variable, const Pack &unmasked) __attribute__((always_inline)) {
        Pack slope = masked(pair.may_touch, unmasked);
        int column = variable % MOTION;
        if (ROW >= NEXT) (variable < MOTION ? pair.next_by_own : pair.next_by_next)[row][column] = slope;
        else if (variable < MOTION) block.jacobian[ROW][column] += slope;  // rows and columns of balls with an orbit of their own
        else pair.by_next[row][column] = slope;
      });
  };
  Pack approach = ball_and_next<DERIVATIVES>(bearing, block.y, pair.next, pair.full_turn, put);
  if (DERIVATIVES) pair.touches = (approach > 0.0) & pair.may_touch;
}

class TouchingBalls {
 public:
  // `near` (balls,) marks the balls that may touch the next ahead; `numbers` are those of a row of neighbours.
  void start(const std::uint8_t *near, int balls, const std::vector<int> &numbers) {
    count = int(numbers.size()), pairs.clear(), members.clear();
    if (!std::any_of(near, near + balls, [](std::uint8_t flag) { return flag != 0; })) return;
    pairs.assign((count + LANES - 1) / LANES, PairBlock{});
    for (int index = 0; index < count; index++) {
      int ball = numbers[index], next = numbers[(index + 1) % count];
      PairBlock &pair = pairs[index / LANES];
      pair.may_touch[index % LANES] = near[ball] && next == (ball + 1) % balls ? -1 : 0;
      pair.full_turn[index % LANES] = next < ball ? 2.0 * M_PI : 0.0;
    }
  }
  bool active() const { return !pairs.empty(); }
  bool any_touch() const { return !members.empty(); }

  // Adds all contacts to the rates, after the forces of raceways and before `finish_rates`.
  template <bool DERIVATIVES>
  void add(const Bearing &bearing, std::vector<BallBlock> &blocks) {
    for (int index = 0; index < count; index++)
      for (int c = 0; c < MOTION; c++)
        pairs[index / LANES].next[c][index % LANES] = blocks[next(index) / LANES].y[c][next(index) % LANES];
    for (std::size_t n = 0; n < pairs.size(); n++) block_pair_forces<DERIVATIVES>(bearing, blocks[n], pairs[n]);
    for (int index = 0; index < count; index++) {
      const PairBlock &pair = pairs[index / LANES];
      int lane = index % LANES, next_lane = next(index) % LANES;
      if (!pair.may_touch[lane]) continue;
      BallBlock &next_block = blocks[next(index) / LANES];
      for (int row = 0; row < 6; row++) {
        next_block.f[VELOCITY + row][next_lane] += pair.on_next[row][lane];
        if (DERIVATIVES && pair.touches[lane])
          for (int c = 0; c < MOTION; c++) next_block.jacobian[row][c][next_lane] += pair.next_by_next[row][c][lane];
      }
    }
    if constexpr (DERIVATIVES)  // as in `finish_rates`
      for (std::size_t n = 0; n < pairs.size(); n++) {
        PairBlock &pair = pairs[n];
        Pack inverse = 1.0 / (bearing.ball_mass * blocks[n].y[RADIUS] * blocks[n].y[RADIUS]),
             next_inverse = 1.0 / (bearing.ball_mass * pair.next[RADIUS] * pair.next[RADIUS]);
        for (int c = 0; c < MOTION; c++) pair.by_next[ORBIT_ROW][c] *= inverse, pair.next_by_own[ORBIT_ROW][c] *= next_inverse;
      }
  }

  // Determines the balls that touch, which are not eliminated one by one.
  void choose_members(std::vector<BallBlock> &blocks) {
    members.clear(), member.assign(count, -1);
    for (int index = 0; index < count && active(); index++) {
      bool touches = touches_next(index) || touches_next((index + count - 1) % count);
      blocks[index / LANES].separate[index % LANES] = touches ? 0 : -1;
      if (touches) member[index] = int(members.size()), members.push_back(index);
    }
  }

  // Factorises the system of members and bodies, after the function `factorise`.
  void factorise(const Layout &layout, const std::vector<BallBlock> &blocks, const BodyStep &body, double g) {
    int first = 6 * int(members.size());
    size = first + layout.unknowns;
    matrix.assign(size * size, 0.0), right.assign(size, 0.0), pivot.resize(size);
    auto reduced = [&](const auto &row, int j, int lane) {
      return j < 3 ? row[VELOCITY + j][lane] + g * row[j][lane] : row[VELOCITY + j][lane];
    };
    for (int t = 0; t < int(members.size()); t++) {
      int index = members[t], lane = index % LANES, row = 6 * t;
      const BallBlock &block = blocks[index / LANES];
      for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) entry(row + i, row + j) = (i == j ? 1.0 / g : 0.0) - reduced(block.jacobian[i], j, lane);
        for (int c = 0; c < layout.unknowns; c++) {
          entry(row + i, first + c) =
              -(block.jacobian[i][BODY_VELOCITIES + c][lane] + g * block.jacobian[i][BODY_POSITIONS + c][lane]);
          entry(first + c, row + i) = -body.inverse_inertia[c] * block.force_rows[c][i][lane];
        }
      }
      if (!touches_next(index)) continue;
      const PairBlock &pair = pairs[index / LANES];
      int next_row = 6 * member[next(index)];
      for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
          entry(row + i, next_row + j) -= reduced(pair.by_next[i], j, lane),
              entry(next_row + i, row + j) -= reduced(pair.next_by_own[i], j, lane);
    }
    for (int i = 0; i < layout.unknowns; i++)
      for (int j = 0; j < layout.unknowns; j++) entry(first + i, first + j) = body.schur[i][j];
    factorise_dense(size, [this](int i, int j) -> double & { return entry(i, j); }, pivot.data());
  }

  // Velocities and spins of the members and velocities of the bodies in a stage, from the reduced right-hand sides of balls and
  // that (unknowns,) of the bodies, which is replaced.
  void solve(const Layout &layout, std::vector<BallBlock> &blocks, double g, double *body_rhs) {
    for (int c = 0; c < layout.unknowns; c++) right[size - layout.unknowns + c] = body_rhs[c];
    for (int t = 0; t < int(members.size()); t++)
      for (int i = 0; i < 6; i++) right[6 * t + i] = blocks[members[t] / LANES].reduced_rhs[i][members[t] % LANES];
    for (int t = 0; t < int(members.size()); t++) {
      int index = members[t], lane = index % LANES, next_index = next(index);
      if (!touches_next(index)) continue;
      const PairBlock &pair = pairs[index / LANES];
      const BallState &ball_rhs = blocks[index / LANES].rhs, &next_rhs = blocks[next_index / LANES].rhs;
      for (int i = 0; i < 6; i++)
        for (int c = 0; c < 3; c++) {
          right[6 * t + i] += pair.by_next[i][c][lane] * g * next_rhs[c][next_index % LANES];
          right[6 * member[next_index] + i] += pair.next_by_own[i][c][lane] * g * ball_rhs[c][lane];
        }
    }
    substitute_dense(size, [this](int i, int j) { return entry(i, j); }, pivot.data(), right);
    for (int c = 0; c < layout.unknowns; c++) body_rhs[c] = right[size - layout.unknowns + c];
    for (int t = 0; t < int(members.size()); t++) {  // from which `back_substitute_block` restores the solution
      int lane = members[t] % LANES;
      BallBlock &block = blocks[members[t] / LANES];
      for (int i = 0; i < 6; i++) {
        double velocity = right[6 * t + i];
        for (int c = 0; c < layout.unknowns; c++) velocity -= block.body_response[i][c][lane] * body_rhs[c];
        block.ball_solution[i][lane] = velocity;
      }
    }
  }

  // Adds to the losses of a stage those by the motion of the next balls.
  void add_losses(std::vector<BallBlock> &blocks, double g, int stage) const {
    for (int index : members) {
      if (!touches_next(index)) continue;
      const BallState &next_stage = blocks[next(index) / LANES].stage[stage];
      double loss = 0.0;
      for (int c = 0; c < MOTION; c++)
        loss += pairs[index / LANES].by_next[PAIR_ROWS - 1][c][index % LANES] * next_stage[c][next(index) % LANES];
      blocks[index / LANES].stage[stage][DISSIPATED][index % LANES] += g * loss;
    }
  }

 private:
  std::vector<PairBlock> pairs;
  std::vector<int> members, member, pivot;  // indices of the balls that touch, and the index of each ball among these, or -1
  std::vector<double> matrix, right;
  int count = 0, size = 0;

  int next(int index) const { return index + 1 < count ? index + 1 : 0; }
  bool touches_next(int index) const { return pairs[index / LANES].touches[index % LANES] != 0; }
  double &entry(int row, int column) { return matrix[row * size + column]; }
};

}  // namespace core
