// Balls that touch each other: the contact of a ball with the next ahead, and the linear system of those that touch. It is
// dense, with the bodies' coordinates last, where elimination fills least; all other balls are eliminated before.
#pragma once
#include "../math/linear.hpp"
#include "ball_system.hpp"
#include "neighbours.hpp"

namespace core {

constexpr int PAIR_ROWS = 7;  // a ball's accelerations as in a tile, and the loss of the contact, which is the ball's behind

// Contact of each ball of a block with the next ahead.
struct PairBlock {
  BallState next{};
  Pack around{};  // what to add to the angle of the next [rad]
  Mask may_touch{}, meets{};
  Pack on_next[6]{};  // what the contact adds to the next ball's rates
  Pack by_next[PAIR_ROWS][MOTION]{}, next_by_own[6][MOTION]{}, next_by_next[6][MOTION]{};
};

// Gives rows of the ball, and as those from NEXT on of the next, whose motions are columns 0 to 8 and 9 to 17; returns the approach.
constexpr int NEXT = LOSS_ROW + 1;
template <bool DERIVATIVES, class Give>
CORE_INLINE Pack ball_and_next(const Bearing &bearing, double storing, const BallState &ball, const BallState &next, const Pack &around, Give give) {
  auto motion = [&]<int FIRST>(Index<FIRST>, const BallState &y) __attribute__((always_inline)) {
    auto number = [&]<int C>(Index<C>) __attribute__((always_inline)) { return input<DERIVATIVES, FIRST + C>(y[C]); };
    auto radius = number(index<RADIUS>);
    return std::tuple{Vector3{radius, Zero{}, number(index<HEIGHT>)},
                      Vector3{number(index<VELOCITY>), radius * number(index<ORBIT_RATE>), number(index<VELOCITY + 2>)},
                      Vector3{number(index<SPIN>), number(index<SPIN + 1>), number(index<SPIN + 2>)}, number(index<ANGLE>)};
  };
  auto [place, velocity, spin, angle] = motion(index<0>, ball);
  auto [next_place, next_velocity, next_spin, next_angle] = motion(index<MOTION>, next);
  auto [cosine, sine] = cosine_sine((next_angle - angle) + around);
  auto c = cosine, s = sine, minus_s = -sine;
  auto ahead = [&](const auto &v) __attribute__((always_inline)) { return about_z(c, s, v); };
  auto back = [&](const auto &v) __attribute__((always_inline)) { return about_z(c, minus_s, v); };
  auto between = ahead(next_place) - place, against = velocity - ahead(next_velocity), both = spin + ahead(next_spin);
  auto contact = pair_contact(bearing, local<0>(between), local<3>(against), local<6>(both));
  auto through = [&](const auto &x) __attribute__((always_inline)) {
    return composed(x, between.x, between.y, between.z, against.x, against.y, against.z, both.x, both.y, both.z);
  };
  auto force = through(contact.force), torque = through(contact.torque);
  double over_mass = 1.0 / bearing.ball_mass, over_inertia = 1.0 / bearing.ball_inertia;
  auto rows = [&]<int FIRST>(Index<FIRST>, double sign, const auto &radius, const auto &f, const auto &t) __attribute__((always_inline)) {
    give(index<FIRST + RADIAL_ROW>, (sign * over_mass) * f.x), give(index<FIRST + ORBIT_ROW>, sign * (radius * f.y));
    give(index<FIRST + AXIAL_ROW>, (sign * over_mass) * f.z), give(index<FIRST + SPIN_ROW>, over_inertia * t.x);
    give(index<FIRST + SPIN_ROW + 1>, over_inertia * t.y), give(index<FIRST + SPIN_ROW + 2>, over_inertia * t.z);
  };
  rows(index<0>, 1.0, place.x, force, torque);
  rows(index<NEXT>, -1.0, next_place.x, back(force), back(torque));
  // Elastic energy counts as lost while balls touch: damping that would pull loses what is left of it.
  give(index<LOSS_ROW>, through(contact.loss + storing * contact.stored));
  return value_of(contact.approach);
}

// Adds the contacts of a block to its rates; with DERIVATIVES to its tile, too. What they do to the next balls stays in `p`.
template <bool DERIVATIVES>
[[gnu::noinline]] inline void pairs_of_block(const Bearing &bearing, double storing, BallBlock &k, PairBlock &p) {
  if constexpr (DERIVATIVES) p = {p.next, p.around, p.may_touch};
  auto give = [&]<int ROW>(Index<ROW>, const auto &x) __attribute__((always_inline)) {
    constexpr int row = ROW == LOSS_ROW ? PAIR_ROWS - 1 : ROW % NEXT;
    if constexpr (ROW >= NEXT) p.on_next[row] = masked(p.may_touch, value_of(x));
    else k.f[VELOCITY + ROW] += masked(p.may_touch, value_of(x));
    if constexpr (DERIVATIVES) for_each_slope(x, [&](int variable, const Pack &any) __attribute__((always_inline)) {
      Pack slope = masked(p.may_touch, any);
      int column = variable % MOTION;
      if (ROW >= NEXT) (variable < MOTION ? p.next_by_own : p.next_by_next)[row][column] = slope;
      else if (variable < MOTION) k.tile[ROW][column] += slope;  // rows and columns of balls with an orbit of their own
      else p.by_next[row][column] = slope;
    });
  };
  Pack approach = ball_and_next<DERIVATIVES>(bearing, storing, k.y, p.next, p.around, give);
  if (DERIVATIVES) p.meets = (approach > 0.0) & p.may_touch;
}

class TouchingBalls {
 public:
  double storing = 1.0;  // share of the power into elastic energy that counts as lost

  // `near` (balls,) says which of all balls may touch the next ahead; `numbers` are those of a row of neighbours.
  void begin(const std::uint8_t *near, int balls, const std::vector<int> &numbers) {
    count = int(numbers.size()), pairs.clear(), members.clear();
    if (!std::any_of(near, near + balls, [](std::uint8_t one) { return one != 0; })) return;
    pairs.assign((count + LANES - 1) / LANES, PairBlock{});
    for (int place = 0; place < count; place++) {
      int own = numbers[place], next = numbers[(place + 1) % count];
      PairBlock &p = pairs[place / LANES];
      p.may_touch[place % LANES] = near[own] && next == (own + 1) % balls ? -1 : 0;
      p.around[place % LANES] = next < own ? 2.0 * M_PI : 0.0;
    }
  }
  bool active() const { return !pairs.empty(); }
  bool meets() const { return !members.empty(); }

  // Adds all contacts to the rates, between the forces of raceways and `finish_rates`.
  template <bool DERIVATIVES>
  void add(const Bearing &bearing, std::vector<BallBlock> &blocks) {
    for (int place = 0; place < count; place++)
      for (int c = 0; c < MOTION; c++) pairs[place / LANES].next[c][place % LANES] = blocks[next(place) / LANES].y[c][next(place) % LANES];
    for (std::size_t n = 0; n < pairs.size(); n++) pairs_of_block<DERIVATIVES>(bearing, storing, blocks[n], pairs[n]);
    for (int place = 0; place < count; place++) {
      const PairBlock &p = pairs[place / LANES];
      int lane = place % LANES, other = next(place) % LANES;
      if (!p.may_touch[lane]) continue;
      BallBlock &to = blocks[next(place) / LANES];
      for (int row = 0; row < 6; row++) {
        to.f[VELOCITY + row][other] += p.on_next[row][lane];
        if (DERIVATIVES && p.meets[lane])
          for (int c = 0; c < MOTION; c++) to.tile[row][c][other] += p.next_by_next[row][c][lane];
      }
    }
    if constexpr (DERIVATIVES)  // as `finish_rates` does with a ball's own tile
      for (std::size_t n = 0; n < pairs.size(); n++) {
        PairBlock &p = pairs[n];
        Pack own = 1.0 / (bearing.ball_mass * blocks[n].y[RADIUS] * blocks[n].y[RADIUS]), other = 1.0 / (bearing.ball_mass * p.next[RADIUS] * p.next[RADIUS]);
        for (int c = 0; c < MOTION; c++) p.by_next[ORBIT_ROW][c] *= own, p.next_by_own[ORBIT_ROW][c] *= other;
      }
  }

  // Finds the balls that touch; those are not eliminated one by one.
  void choose_members(std::vector<BallBlock> &blocks) {
    members.clear(), member.assign(count, -1);
    for (int place = 0; place < count; place++) {
      bool touches = meets(place) || meets((place + count - 1) % count);
      blocks[place / LANES].apart[place % LANES] = touches ? 0 : -1;
      if (touches) member[place] = int(members.size()), members.push_back(place);
    }
  }

  // Factors of the system of members and bodies, after `factorise`.
  void factorise(const Layout &layout, const std::vector<BallBlock> &blocks, const BodyStep &e, double g) {
    int first = 6 * int(members.size());
    size = first + layout.unknowns;
    matrix.assign(size * size, 0.0), right.assign(size, 0.0), pivot.resize(size);
    auto folded = [&](const auto &row, int j, int lane) { return j < 3 ? row[VELOCITY + j][lane] + g * row[j][lane] : row[VELOCITY + j][lane]; };
    for (int t = 0; t < int(members.size()); t++) {
      int place = members[t], lane = place % LANES, row = 6 * t;
      const BallBlock &k = blocks[place / LANES];
      for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) at(row + i, row + j) = (i == j ? 1.0 / g : 0.0) - folded(k.tile[i], j, lane);
        for (int c = 0; c < layout.unknowns; c++) {
          at(row + i, first + c) = -(k.tile[i][BODY_SPEEDS + c][lane] + g * k.tile[i][BODY_PLACES + c][lane]);
          at(first + c, row + i) = -e.over_inertia[c] * k.to_bodies[c][i][lane];
        }
      }
      if (!meets(place)) continue;
      const PairBlock &p = pairs[place / LANES];
      int other = 6 * member[next(place)];
      for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++) at(row + i, other + j) -= folded(p.by_next[i], j, lane), at(other + i, row + j) -= folded(p.next_by_own[i], j, lane);
    }
    for (int i = 0; i < layout.unknowns; i++)
      for (int j = 0; j < layout.unknowns; j++) at(first + i, first + j) = e.corner[i][j];
    factorise_dense(size, [this](int i, int j) -> double & { return at(i, j); }, pivot.data());
  }

  // Velocities and spins of the members and velocities of the bodies in a stage, from what is `known` of balls and the
  // right-hand side (unknowns,) of the bodies, which is replaced.
  void solve(const Layout &layout, std::vector<BallBlock> &blocks, double g, double *bodies) {
    for (int c = 0; c < layout.unknowns; c++) right[size - layout.unknowns + c] = bodies[c];
    for (int t = 0; t < int(members.size()); t++)
      for (int i = 0; i < 6; i++) right[6 * t + i] = blocks[members[t] / LANES].known[i][members[t] % LANES];
    for (int t = 0; t < int(members.size()); t++) {
      int place = members[t], lane = place % LANES, other = next(place);
      if (!meets(place)) continue;
      const PairBlock &p = pairs[place / LANES];
      const BallState &here = blocks[place / LANES].right, &there = blocks[other / LANES].right;
      for (int i = 0; i < 6; i++)
        for (int c = 0; c < 3; c++) {
          right[6 * t + i] += p.by_next[i][c][lane] * g * there[c][other % LANES];
          right[6 * member[other] + i] += p.next_by_own[i][c][lane] * g * here[c][lane];
        }
    }
    substitute_dense(size, [this](int i, int j) { return at(i, j); }, pivot.data(), right);
    for (int c = 0; c < layout.unknowns; c++) bodies[c] = right[size - layout.unknowns + c];
    for (int t = 0; t < int(members.size()); t++) {  // so that `follow_block` comes to what was solved
      int lane = members[t] % LANES;
      BallBlock &k = blocks[members[t] / LANES];
      for (int i = 0; i < 6; i++) {
        double velocity = right[6 * t + i];
        for (int c = 0; c < layout.unknowns; c++) velocity -= k.answer[i][c][lane] * bodies[c];
        k.eliminated[i][lane] = velocity;
      }
    }
  }

  // Adds to the losses in a stage what follows from the motion of the next balls.
  void add_losses(std::vector<BallBlock> &blocks, double g, int stage) const {
    for (int place : members) {
      if (!meets(place)) continue;
      const BallState &there = blocks[next(place) / LANES].stage[stage];
      double loss = 0.0;
      for (int c = 0; c < MOTION; c++) loss += pairs[place / LANES].by_next[PAIR_ROWS - 1][c][place % LANES] * there[c][next(place) % LANES];
      blocks[place / LANES].stage[stage][DISSIPATED][place % LANES] += g * loss;
    }
  }

 private:
  std::vector<PairBlock> pairs;
  std::vector<int> members, member, pivot;  // places of the balls that touch, and which of these each ball is, or -1
  std::vector<double> matrix, right;
  int count = 0, size = 0;

  int next(int place) const { return place + 1 < count ? place + 1 : 0; }
  bool meets(int place) const { return pairs[place / LANES].meets[place % LANES] != 0; }
  double &at(int row, int column) { return matrix[row * size + column]; }
};

}  // namespace core
