// The rates of balls and of the bodies they meet, their Jacobian, and its linear system I/g - J. The Jacobian of a ball is
// a tile: its rates by its own motion and by the bodies', and the bodies' forces by its motion.
//
// With the places put in by their velocities, place = g (right + velocity), and the velocities v_j of ball j and s of the
// bodies the system is an arrowhead, whose bodies the balls' Schur complement leaves (`factorise_block`, `factorise`):
//
//     B_j v_j - U_j s = r_j           B_j = I/g - J_jj  (`inverse`),  B_j^-1 U_j  (`answer`)
//     -sum_j V_j v_j + C s = r        V_j: the inverse of the inertia times `to_bodies`
//     (C - sum_j V_j B_j^-1 U_j) s = r + sum_j V_j B_j^-1 r_j        (`corner`, `eliminate_block`)
//     v_j = B_j^-1 r_j + B_j^-1 U_j s                                (`eliminated`, `follow_block`)
//
// Balls that touch others are not eliminated one by one: `TouchingBalls` solves them with the bodies.
#pragma once
#include <vector>
#include "elements.hpp"
#include "../methods/rosenbrock.hpp"

namespace core {

constexpr int MOST_FREE = 8;
// Columns of a tile: places and velocities of a ball's own that are unknown, its spin, places and velocities of the free
// coordinates; the last takes what nothing asks for. Rows: a ball's own accelerations, power and loss, forces on the
// free coordinates, and again a spare one.
constexpr int OWN_PLACES = 0, OWN_SPEEDS = 3, OWN_SPINS = 6, BODY_PLACES = 9, BODY_SPEEDS = BODY_PLACES + MOST_FREE;
constexpr int SPARE_COLUMN = BODY_SPEEDS + MOST_FREE, TILE_COLUMNS = SPARE_COLUMN + 1;
constexpr int MOTION_ROWS = 0, SPIN_ROWS = 3, POWER_ROWS = 6, BODY_ROWS = 8, SPARE_ROW = BODY_ROWS + MOST_FREE, TILE_ROWS = SPARE_ROW + 1;

// Which coordinates are free, and where elements find rows and columns of a tile.
struct Layout {
  int unknowns = 0, coordinate[MOST_FREE], slot[COORDINATES], row[ELEMENT_ROWS], column[VARIABLES];
  bool even, touching = false;

  explicit Layout(const CoupledBodies &bodies) : even(bodies.cage == CageKind::even) {
    for (int c = 0; c < COORDINATES; c++) {
      slot[c] = MOST_FREE;
      if (bodies.free[c]) slot[c] = unknowns, coordinate[unknowns++] = c;
      row[ON_BODY + c] = BODY_ROWS + slot[c];
      column[BODY_PLACE + c] = bodies.free[c] ? BODY_PLACES + slot[c] : SPARE_COLUMN;
      column[BODY_SPEED + c] = bodies.free[c] ? BODY_SPEEDS + slot[c] : SPARE_COLUMN;
    }
    for (int i = 0; i < 3; i++) {
      row[RADIAL_ROW + i] = MOTION_ROWS + i, row[SPIN_ROW + i] = SPIN_ROWS + i;
      column[RADIUS + i] = OWN_PLACES + i, column[VELOCITY + i] = OWN_SPEEDS + i, column[SPIN + i] = OWN_SPINS + i;
    }
    row[POWER_ROW] = POWER_ROWS, row[LOSS_ROW] = POWER_ROWS + 1;
    if (!even) return;
    row[ORBIT_ROW] = row[ON_BODY + CAGE_ANGLE], row[AXIAL_ROW] = MOTION_ROWS + 1;
    column[ANGLE] = column[BODY_PLACE + CAGE_ANGLE], column[ORBIT_RATE] = column[BODY_SPEED + CAGE_ANGLE];
    column[HEIGHT] = OWN_PLACES + 1, column[VELOCITY + 2] = OWN_SPEEDS + 1;
  }
};

// Balls side by side in a step: states, and what the linear system works with. Lanes without a ball repeat the last one,
// which then does nothing to others: their `live` is 0, else all bits are set.
struct BallBlock : StepStates<BallState> {
  int ball[LANES], cursor[LANES];  // the ball in a lane, -1 without one; its next instant
  Pack time{}, step{}, over_step{}, gain{}, error{};
  double wanted[LANES], until[LANES], share[LANES];  // step before it is cut; time up to which to give out; part of it to make
  Mask live{}, apart{};  // apart: touches no other ball
  Pack pocket{};  // angle from the cage to the ball's pocket [rad]
  Pack closing{};  // growth of the rate at which the ball comes forward in its pocket [m/s^2]
  BallState y{}, f{}, first{}, right{}, slope{};
  Quaternion before{}, after{};
  CarriedBalls carried{};
  SurfacePlaces places{};  // where a step starts
  Heights heights{};
  bool meets_defects = false;  // in a step
  Pack tile[TILE_ROWS][TILE_COLUMNS]{};
  Pack inverse[6][6]{};
  Pack to_bodies[MOST_FREE][6]{}, answer[6][MOST_FREE]{}, known[6]{}, eliminated[6]{};
};

// The bodies in a step; `force` and its derivatives by places and velocities of the free coordinates are their own.
struct BodyStep : StepStates<BodyState> {
  BodyState y{}, f{}, first{}, right{}, slope{};
  double over_inertia[MOST_FREE]{};  // 1 / inertia of the free coordinates, where the step starts
  double by_place[MOST_FREE + INTEGRALS][MOST_FREE]{}, by_speed[MOST_FREE + INTEGRALS][MOST_FREE]{};
  double answer_to_place[MOST_FREE][MOST_FREE]{}, corner[MOST_FREE][MOST_FREE]{}, inverse[MOST_FREE][MOST_FREE]{};
};

using Pushes = std::array<Pack, MOST_FREE + 1>;  // forces on the free coordinates, lane by lane

CORE_INLINE double total(const Pack &x) {
  double sum = 0.0;
  for (int lane = 0; lane < LANES; lane++) sum += x[lane];
  return sum;
}
CORE_INLINE Pack masked(const Mask &mask, const Pack &x) { return (Pack)((Mask)x & mask); }

// Takes what an element gives of a block of balls: sets rates and tile, or with ADD adds to them.
template <bool ADD, bool DERIVATIVES>
struct ElementStore {
  const Layout &layout;
  BallBlock &k;
  Pushes &push;

  template <int ROW, class X>
  CORE_INLINE void operator()(Index<ROW>, const X &x) const {
    int row = layout.row[ROW];
    if constexpr (ROW >= ON_BODY) push[row - BODY_ROWS] += masked(k.live, value_of(x));
    else if constexpr (ADD) k.f[VELOCITY + ROW] += value_of(x);
    else k.f[VELOCITY + ROW] = value_of(x);
    if constexpr (DERIVATIVES) {
      Mask counts = ROW >= ON_BODY || (ROW == ORBIT_ROW && layout.even) ? k.live : ~Mask{};
      for_each_slope(x, [&](int variable, const Pack &slope) __attribute__((always_inline)) {
        Pack &to = k.tile[row][layout.column[variable]];
        Pack counted = ROW >= ON_BODY || ROW == ORBIT_ROW ? masked(counts, slope) : slope;
        if constexpr (ADD) to += counted;
        else to = counted;
      });
    }
  }
};

// Forces of raceways whose motion is prescribed on a block of balls; with DERIVATIVES its tile, too.
template <bool PATCH, bool TILTED, bool DERIVATIVES>
[[gnu::noinline]] inline void prescribed_raceways(const Bearing &bearing, const Pack &ring_speed, BallBlock &k) {
  auto give = [&]<int ROW>(Index<ROW>, const auto &x) __attribute__((always_inline)) {
    if constexpr (ROW < ON_BODY) {
      k.f[VELOCITY + ROW] = value_of(x);
      if constexpr (DERIVATIVES)
        for_each_slope(x, [&](int variable, const Pack &slope) __attribute__((always_inline)) { k.tile[ROW][variable] = slope; });
    }
  };
  between_raceways<TILTED ? RingMotion::tilted : RingMotion::held, PATCH>(
      bearing, PrescribedInput<DERIVATIVES>{k.y, bearing, ring_speed, bearing.carries() ? &k.carried : nullptr, k.heights}, give);
}

template <RingMotion RING, bool PATCH, bool DERIVATIVES>
[[gnu::noinline]] inline void raceways_of_block(const Bearing &bearing, const double *housing, const Layout &layout, BallBlock &k,
                                                const BodyState &y, Pushes &push) {
  ElementStore<false, DERIVATIVES> store{layout, k, push};
  ElementInput<DERIVATIVES> in{k.y, y, bearing.carries() ? &k.carried : nullptr, k.heights, housing};
  between_raceways<RING, PATCH>(bearing, in, store);
}

template <bool DERIVATIVES>
[[gnu::noinline]] inline void pockets_of_block(const Bearing &bearing, const CoupledBodies &bodies, const Layout &layout, BallBlock &k, const BodyState &y, Pushes &push) {
  ElementStore<true, DERIVATIVES> store{layout, k, push};
  ElementInput<DERIVATIVES> in{k.y, y};
  in_cage(bearing, bodies, k.pocket, in, store);
}

// Forces of raceways and pockets on a block of balls and on the bodies; with DERIVATIVES its tile, too.
template <bool PATCH, bool DERIVATIVES>
inline void forces_of_block(const Bearing &bearing, const CoupledBodies &bodies, const Layout &layout, BallBlock &k, const BodyState &y, Pushes &push) {
  if (DERIVATIVES && bodies.cage == CageKind::pockets)
    for (auto &row : k.tile)
      for (Pack &entry : row) entry = Pack{};  // raceways leave what pockets add to
  auto raceways = [&]<RingMotion RING>() { raceways_of_block<RING, PATCH, DERIVATIVES>(bearing, bodies.direction, layout, k, y, push); };
  switch (bodies.ring) {
    case RingMotion::held: raceways.template operator()<RingMotion::held>(); break;
    case RingMotion::level: raceways.template operator()<RingMotion::level>(); break;
    default: raceways.template operator()<RingMotion::housed>();  // rows and columns of coordinates that are held are spare
  }
  if (bodies.cage == CageKind::pockets) pockets_of_block<DERIVATIVES>(bearing, bodies, layout, k, y, push);
}

// The rates once all forces are known; `carried` gathers m r^2 of an even cage's balls, whose moments push the cage.
template <bool DERIVATIVES>
inline void finish_rates(const Bearing &bearing, const Layout &layout, BallBlock &k, Pushes &push, Pack &carried) {
  Pack inertia = bearing.ball_mass * k.y[RADIUS] * k.y[RADIUS], moment = k.f[ORBIT_RATE];
  k.f[RADIUS] = k.y[VELOCITY], k.f[ANGLE] = k.y[ORBIT_RATE], k.f[HEIGHT] = k.y[VELOCITY + 2];
  k.f[GROSS_WORK] = absolute(k.f[DRIVE_WORK]);
  if (layout.even) {
    push[layout.row[ORBIT_ROW] - BODY_ROWS] += masked(k.live, moment), carried += masked(k.live, inertia);
    return;
  }
  Pack over = 1.0 / inertia;
  k.f[ORBIT_RATE] = over * moment;
  if constexpr (DERIVATIVES) {
    Pack *row = k.tile[MOTION_ROWS + 1];
    row[OWN_PLACES] -= 2.0 * bearing.ball_mass * k.y[RADIUS] * k.f[ORBIT_RATE];  // the inertia grows with the radius
    for (int c = 0; c < (layout.unknowns ? int(SPARE_COLUMN) : int(BODY_PLACES)); c++) row[c] *= over;
  }
}

// Rates of the bodies at `time` by their inertia there, from what balls do; with DERIVATIVES those of their own forces, too.
template <bool DERIVATIVES>
inline void body_rates(const CoupledBodies &bodies, const Layout &layout, double time, const double *over_inertia, BodyStep &e,
                       const Pushes &push) {
  double force[COORDINATES + INTEGRALS] = {};
  if constexpr (DERIVATIVES)
    for (int i = 0; i < MOST_FREE + INTEGRALS; i++)
      for (int j = 0; j < MOST_FREE; j++) e.by_place[i][j] = e.by_speed[i][j] = 0.0;
  auto add = [&]<int ROW>(Index<ROW>, const auto &x) {
    force[ROW] += value_of(x);
    if constexpr (DERIVATIVES) {
      int row = ROW < COORDINATES ? layout.slot[ROW < COORDINATES ? ROW : 0] : MOST_FREE + ROW - COORDINATES;
      for_each_slope(x, [&](int variable, double slope) {
        int column = layout.slot[variable % COORDINATES];
        if (column < MOST_FREE) (variable < COORDINATES ? e.by_place : e.by_speed)[row][column] += slope;
      });
    }
  };
  body_forces<DERIVATIVES>(bodies, time, e.y, add);
  e.f.fill(0.0);
  for (int k = 0; k < layout.unknowns; k++) {
    int c = layout.coordinate[k];
    e.f[c] = e.y[COORDINATES + c];
    e.f[COORDINATES + c] = over_inertia[k] * (force[c] + total(push[k]));
  }
  for (int i = 0; i < INTEGRALS; i++) e.f[2 * COORDINATES + i] = force[COORDINATES + i];
}

// The unknown motion of a ball: that of an even cage has no orbit of its own.
template <bool EVEN>
struct Unknown {
  static constexpr int count = EVEN ? 2 : 3;
  static constexpr int place(int i) { return EVEN ? 2 * i : i; }  // among the columns of a state
};

template <class T>
CORE_INLINE T folded_own(const T *row, int j, const T &g) { return row[OWN_SPEEDS + j] + g * row[OWN_PLACES + j]; }
template <class T>
CORE_INLINE T folded_body(const T *row, int c, const T &g) { return row[BODY_SPEEDS + c] + g * row[BODY_PLACES + c]; }

using Corner = Pack[MOST_FREE][MOST_FREE];

// Factors of a block, and what its balls leave of the bodies' system; M is the room for unknowns of the bodies.
template <bool EVEN, int M>
[[gnu::noinline]] inline void factorise_block(BallBlock &k, Corner &corner, Corner &by_place) {
  constexpr int N = Unknown<EVEN>::count;
  const Pack g = k.gain, over = 1.0 / g;
  auto row_of = [&](int i) { return k.tile[i < N ? MOTION_ROWS + i : SPIN_ROWS + i - N]; };
  for (int i = 0; i < N + 3; i++) {
    const Pack *row = row_of(i);
    for (int j = 0; j < N; j++) k.inverse[i][j] = -folded_own(row, j, g);
    for (int j = 0; j < 3; j++) k.inverse[i][N + j] = -row[OWN_SPINS + j];
    k.inverse[i][i] += over;
  }
  invert_in_lanes<N + 3>(k.inverse);
  for (int r = 0; r < M; r++) {
    const Pack *row = k.tile[BODY_ROWS + r];
    for (int j = 0; j < N; j++) k.to_bodies[r][j] = folded_own(row, j, g);
    for (int j = 0; j < 3; j++) k.to_bodies[r][N + j] = row[OWN_SPINS + j];
  }
  for (int c = 0; c < M; c++) {
    Pack right[N + 3], x[N + 3];
    for (int i = 0; i < N + 3; i++) right[i] = folded_body(row_of(i), c, g);
    multiply_in_lanes<N + 3>(k.inverse, right, x);
    for (int i = 0; i < N + 3; i++) k.answer[i][c] = x[i];
    for (int r = 0; r < M; r++) {
      Pack sum = k.to_bodies[r][0] * x[0];
      for (int i = 1; i < N + 3; i++) sum += k.to_bodies[r][i] * x[i];
      corner[r][c] += folded_body(k.tile[BODY_ROWS + r], c, g) + masked(k.apart, sum);
      by_place[r][c] += k.tile[BODY_ROWS + r][BODY_PLACES + c];
    }
  }
}

// A stage before it is solved: `known` (M,) changes of the bodies' places. `share` gathers what balls do
// to the bodies.
template <bool EVEN, int M>
[[gnu::noinline]] inline void eliminate_block(BallBlock &k, const double *known, Pack *share) {
  constexpr int N = Unknown<EVEN>::count;
  Pack at[N], there[M];
  const Pack g = k.gain;
  for (int c = 0; c < M; c++) there[c] = broadcast<Pack>(known[c]);
  for (int i = 0; i < N; i++) at[i] = g * k.right[Unknown<EVEN>::place(i)];
  for (int i = 0; i < N + 3; i++) {
    const Pack *row = k.tile[i < N ? MOTION_ROWS + i : SPIN_ROWS + i - N];
    Pack sum = k.right[i < N ? VELOCITY + Unknown<EVEN>::place(i) : SPIN + i - N], more{};
    for (int j = 0; j < N; j++) sum += row[OWN_PLACES + j] * at[j];
    for (int c = 0; c < M; c++) more += row[BODY_PLACES + c] * there[c];
    k.known[i] = sum + more;
  }
  multiply_in_lanes<N + 3>(k.inverse, k.known, k.eliminated);
  for (int r = 0; r < M; r++) {
    const Pack *row = k.tile[BODY_ROWS + r];
    Pack sum = row[OWN_PLACES] * at[0], more = k.to_bodies[r][0] * k.eliminated[0];
    for (int j = 1; j < N; j++) sum += row[OWN_PLACES + j] * at[j];
    for (int j = 1; j < N + 3; j++) more += k.to_bodies[r][j] * k.eliminated[j];
    share[r] += sum + masked(k.apart, more);
  }
}

// The balls once `places` and `speeds` (M,) of the bodies are known; `cage` (2,) are those of an even cage.
template <bool EVEN, int M>
[[gnu::noinline]] inline void follow_block(BallBlock &k, const double *places, const double *speeds, const double *cage, BallState &to) {
  constexpr int N = Unknown<EVEN>::count;
  const Pack g = k.gain;
  Pack p[M], s[M], v[N + 3];
  for (int c = 0; c < M; c++) p[c] = broadcast<Pack>(places[c]), s[c] = broadcast<Pack>(speeds[c]);
  for (int i = 0; i < N + 3; i++) {
    v[i] = k.eliminated[i];
    for (int c = 0; c < M; c++) v[i] += k.answer[i][c] * s[c];
  }
  if (EVEN) to[ANGLE] = broadcast<Pack>(cage[0]), to[ORBIT_RATE] = broadcast<Pack>(cage[1]);
  Pack place[N];
  for (int i = 0; i < N; i++) {
    int c = Unknown<EVEN>::place(i);
    to[c] = place[i] = g * (k.right[c] + v[i]), to[VELOCITY + c] = v[i];
  }
  for (int i = 0; i < 3; i++) to[SPIN + i] = v[N + i];
  Pack found[2];
  for (int n = 0; n < 2; n++) {
    const Pack *row = k.tile[POWER_ROWS + n];
    Pack sum = row[OWN_SPINS] * v[N] + row[OWN_SPINS + 1] * v[N + 1] + row[OWN_SPINS + 2] * v[N + 2], more{};
    for (int i = 0; i < N; i++) sum += row[OWN_SPEEDS + i] * v[i] + row[OWN_PLACES + i] * place[i];
    for (int c = 0; c < M; c++) more += row[BODY_PLACES + c] * p[c];
    for (int c = 0; c < M; c++) more += row[BODY_SPEEDS + c] * s[c];
    found[n] = sum + more;
  }
  to[DRIVE_WORK] = g * (k.right[DRIVE_WORK] + found[0]), to[DISSIPATED] = g * (k.right[DISSIPATED] + found[1]);
  to[GROSS_WORK] = g * (k.right[GROSS_WORK] + select(k.first[DRIVE_WORK] >= 0.0, found[0], -found[0]));
}

// Calls what is made for even cages or others, with room for so many unknowns of the bodies.
template <class Function>
CORE_INLINE void sized(const Layout &layout, Function function) {
  auto with_room = [&]<bool EVEN>() __attribute__((always_inline)) {
    if (layout.unknowns == 0) function.template operator()<EVEN, 0>();
    else if (layout.unknowns == 1) function.template operator()<EVEN, 1>();
    else if (layout.unknowns <= 4) function.template operator()<EVEN, 4>();
    else if (layout.unknowns <= 6) function.template operator()<EVEN, 6>();
    else function.template operator()<EVEN, MOST_FREE>();
  };
  if (layout.even) with_room.template operator()<true>();
  else with_room.template operator()<false>();
}

// The inverse of the first n rows and columns, by Gauss and Jordan with pivots.
inline void invert(const double (&matrix)[MOST_FREE][MOST_FREE], int n, double (&inverse)[MOST_FREE][MOST_FREE]) {
  double a[MOST_FREE][MOST_FREE];
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) a[i][j] = matrix[i][j], inverse[i][j] = i == j ? 1.0 : 0.0;
  for (int c = 0; c < n; c++) {
    int pivot = c;
    for (int i = c + 1; i < n; i++)
      if (std::fabs(a[i][c]) > std::fabs(a[pivot][c])) pivot = i;
    if (pivot != c)
      for (int j = 0; j < n; j++) std::swap(a[c][j], a[pivot][j]), std::swap(inverse[c][j], inverse[pivot][j]);
    double over = 1.0 / a[c][c];
    for (int j = 0; j < n; j++) a[c][j] *= over, inverse[c][j] *= over;
    for (int i = 0; i < n; i++) {
      if (i == c) continue;
      double factor = a[i][c];
      for (int j = 0; j < n; j++) a[i][j] -= factor * a[c][j], inverse[i][j] -= factor * inverse[c][j];
    }
  }
}

inline void factorise(const Layout &layout, std::vector<BallBlock> &blocks, BodyStep &e, double g) {
  Corner corner{}, by_place{};
  sized(layout, [&]<bool EVEN, int M>() __attribute__((always_inline)) {
    for (BallBlock &k : blocks) factorise_block<EVEN, M>(k, corner, by_place);
  });
  for (int i = 0; i < layout.unknowns; i++)
    for (int j = 0; j < layout.unknowns; j++) {
      e.answer_to_place[i][j] = e.over_inertia[i] * (total(by_place[i][j]) + e.by_place[i][j]);
      double answer = total(corner[i][j]) + e.by_speed[i][j] + g * e.by_place[i][j];
      e.corner[i][j] = (i == j ? 1.0 / g : 0.0) - e.over_inertia[i] * answer;
    }
  invert(e.corner, layout.unknowns, e.inverse);
}

}  // namespace core
