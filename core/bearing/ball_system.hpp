// The rates of balls and of the bodies coupled to them, their Jacobian J, and the linear system I/g - J of a Rosenbrock stage,
// g = gamma h. Each ball has its block of the Jacobian: derivatives of its rates by its own motion and by that of the bodies, and
// of the forces on the bodies by its motion.
//
// Positions are eliminated by position = g (right-hand side + velocity). In the velocities v_j of ball j and s of the bodies the
// system is an arrowhead matrix, which is reduced to the bodies by its Schur complement (`factorise_block`, `factorise`):
//
//     B_j v_j - U_j s = r_j           B_j = I/g - J_jj  (`inverse`),  B_j^-1 U_j  (`body_response`)
//     -sum_j V_j v_j + C s = r        V_j: the inverse of the inertia times `force_rows`
//     (C - sum_j V_j B_j^-1 U_j) s = r + sum_j V_j B_j^-1 r_j        (`schur`, `forward_eliminate_block`)
//     v_j = B_j^-1 r_j + B_j^-1 U_j s                                (`ball_solution`, `back_substitute_block`)
//
// Balls that touch others are not eliminated one by one: `TouchingBalls` solves them together with the bodies.
#pragma once
#include <vector>
#include "elements.hpp"
#include "../methods/rosenbrock.hpp"

namespace core {

constexpr int MAX_FREE = 8;
// Columns of a ball's Jacobian: unknown positions and velocities of the ball, its spin, positions and velocities of the free
// coordinates of bodies; the last column collects derivatives by held coordinates. Rows: accelerations of the ball, power and
// loss, forces on the free coordinates, and again a spare one.
constexpr int BALL_POSITIONS = 0, BALL_VELOCITIES = 3, BALL_SPINS = 6, BODY_POSITIONS = 9,
              BODY_VELOCITIES = BODY_POSITIONS + MAX_FREE;
constexpr int SPARE_COLUMN = BODY_VELOCITIES + MAX_FREE, JACOBIAN_COLUMNS = SPARE_COLUMN + 1;
constexpr int MOTION_ROWS = 0, SPIN_ROWS = 3, POWER_ROWS = 6, BODY_ROWS = 8, SPARE_ROW = BODY_ROWS + MAX_FREE,
              JACOBIAN_ROWS = SPARE_ROW + 1;

// The free coordinates, and the rows and columns of a ball's Jacobian by rows and variables of elements.
struct Layout {
  int unknowns = 0, coordinate[MAX_FREE], slot[COORDINATES], row[ELEMENT_ROWS], column[VARIABLES];
  bool even, touching = false;

  explicit Layout(const CoupledBodies &bodies) : even(bodies.cage == CageKind::even) {
    for (int c = 0; c < COORDINATES; c++) {
      slot[c] = MAX_FREE;
      if (bodies.free[c]) slot[c] = unknowns, coordinate[unknowns++] = c;
      row[FORCE_ROW + c] = BODY_ROWS + slot[c];
      column[BODY_POSITION + c] = bodies.free[c] ? BODY_POSITIONS + slot[c] : SPARE_COLUMN;
      column[BODY_VELOCITY + c] = bodies.free[c] ? BODY_VELOCITIES + slot[c] : SPARE_COLUMN;
    }
    for (int i = 0; i < 3; i++) {
      row[RADIAL_ROW + i] = MOTION_ROWS + i, row[SPIN_ROW + i] = SPIN_ROWS + i;
      column[RADIUS + i] = BALL_POSITIONS + i, column[VELOCITY + i] = BALL_VELOCITIES + i, column[SPIN + i] = BALL_SPINS + i;
    }
    row[POWER_ROW] = POWER_ROWS, row[LOSS_ROW] = POWER_ROWS + 1;
    if (!even) return;
    row[ORBIT_ROW] = row[FORCE_ROW + CAGE_ANGLE], row[AXIAL_ROW] = MOTION_ROWS + 1;
    column[ANGLE] = column[BODY_POSITION + CAGE_ANGLE], column[ORBIT_RATE] = column[BODY_VELOCITY + CAGE_ANGLE];
    column[HEIGHT] = BALL_POSITIONS + 1, column[VELOCITY + 2] = BALL_VELOCITIES + 1;
  }
};

// Balls in the lanes of packs in a step: states and terms of the linear system. Lanes without a ball repeat the last one and exert
// no forces: their `occupied` is 0, else all bits are set.
struct BallBlock : StepStates<BallState> {
  int ball[LANES], next_output[LANES];  // the ball in a lane, -1 without one
  Pack time{}, step{}, inverse_step{}, gamma_step{}, error{};
  double uncut_step[LANES], output_end[LANES], accepted_fraction[LANES];  // output_end: time up to which outputs are due
  Mask occupied{}, separate{};  // separate: touches no other ball
  Pack pocket_angle{};  // from the cage to the ball's pocket [rad]
  Pack pocket_acceleration{};  // of the ball along the orbit against its pocket [m/s^2]
  BallState y{}, f{}, start_rates{}, rhs{}, time_derivative{};
  Quaternion start_orientation{}, end_orientation{};
  CarriedBalls carried{};
  SurfacePositions surface{};  // at the start of a step
  Heights heights{};
  bool crosses_defects = false;  // in a step
  Pack jacobian[JACOBIAN_ROWS][JACOBIAN_COLUMNS]{};
  Pack inverse[6][6]{};
  Pack force_rows[MAX_FREE][6]{}, body_response[6][MAX_FREE]{}, reduced_rhs[6]{}, ball_solution[6]{};
};

// The bodies in a step; derivatives by positions and velocities of the free coordinates are those of forces other than of balls.
struct BodyStep : StepStates<BodyState> {
  BodyState y{}, f{}, start_rates{}, rhs{}, time_derivative{};
  double inverse_step = 0.0, inverse_inertia[MAX_FREE]{};  // of the free coordinates, at the start of the step
  double by_position[MAX_FREE + INTEGRALS][MAX_FREE]{}, by_velocity[MAX_FREE + INTEGRALS][MAX_FREE]{};
  double position_coupling[MAX_FREE][MAX_FREE]{}, schur[MAX_FREE][MAX_FREE]{}, inverse[MAX_FREE][MAX_FREE]{};
};

using BodyForces = std::array<Pack, MAX_FREE + 1>;  // forces on the free coordinates, lane by lane

CORE_INLINE Pack masked(const Mask &mask, const Pack &x) { return (Pack)((Mask)x & mask); }

// Stores results of elements: sets rates and Jacobian of a block of balls, or with ADD adds to them.
template <bool ADD, bool DERIVATIVES>
struct ElementStore {
  const Layout &layout;
  BallBlock &block;
  BodyForces &forces;
  template <int ROW, class X>
  CORE_INLINE void operator()(Index<ROW>, const X &x) const {
    int row = layout.row[ROW];
    if constexpr (ROW >= FORCE_ROW) forces[row - BODY_ROWS] += masked(block.occupied, value_of(x));
    else if constexpr (ADD) block.f[VELOCITY + ROW] += value_of(x);
    else block.f[VELOCITY + ROW] = value_of(x);
    if constexpr (DERIVATIVES) {
      Mask mask = ROW >= FORCE_ROW || (ROW == ORBIT_ROW && layout.even) ? block.occupied : ~Mask{};
      for_each_slope(x, [&](int variable, const Pack &slope) __attribute__((always_inline)) {
        Pack &entry = block.jacobian[row][layout.column[variable]];
        Pack derivative = ROW >= FORCE_ROW || ROW == ORBIT_ROW ? masked(mask, slope) : slope;
        if constexpr (ADD) entry += derivative;
        else entry = derivative;
      });
    }
  }
};

template <RingMotion RING, bool COUPLED, bool PATCH, bool DERIVATIVES>
[[gnu::noinline]] inline void block_raceway_forces(const Bearing &bearing, const double *housing, const Layout &layout,
                                                   BallBlock &block, const BodyState &y, const Pack &shaft_speed,
                                                   BodyForces &forces) {
  ElementStore<false, DERIVATIVES> store{layout, block, forces};
  const CarriedBalls *carried = bearing.carries() ? &block.carried : nullptr;
  ElementInput<DERIVATIVES, COUPLED> in{block.y, y, shaft_speed, carried, block.heights, housing};
  raceway_forces<RING, PATCH>(bearing, in, store);
}

template <bool DERIVATIVES>
[[gnu::noinline]] inline void block_pocket_forces(const Bearing &bearing, const CoupledBodies &bodies, const Layout &layout,
                                                  BallBlock &block, const BodyState &y, BodyForces &forces) {
  ElementStore<true, DERIVATIVES> store{layout, block, forces};
  ElementInput<DERIVATIVES> in{block.y, y};
  cage_pocket(bearing, bodies, block.pocket_angle, in, store);
}

// Forces of raceways and pockets on a block of balls and on the bodies; with DERIVATIVES its Jacobian, too.
template <bool DERIVATIVES>
inline void block_forces(const Bearing &bearing, const CoupledBodies &bodies, const Layout &layout, BallBlock &block,
                         const BodyState &y, const Pack &shaft_speed, BodyForces &forces) {
  if (DERIVATIVES && bodies.cage == CageKind::pockets)
    for (auto &row : block.jacobian)
      for (Pack &entry : row) entry = Pack{};  // pockets add to entries that raceways do not set
  auto raceways = [&]<RingMotion RING, bool COUPLED>() {
    auto forces_of = bearing.over_patch() ? block_raceway_forces<RING, COUPLED, true, DERIVATIVES>
                                          : block_raceway_forces<RING, COUPLED, false, DERIVATIVES>;
    forces_of(bearing, bodies.direction, layout, block, y, shaft_speed, forces);
  };
  if (layout.unknowns == 0)
    bearing.tilted() ? raceways.template operator()<RingMotion::tilted, false>()
                     : raceways.template operator()<RingMotion::held, false>();
  else if (bodies.ring == RingMotion::held) raceways.template operator()<RingMotion::held, true>();
  else if (bodies.ring == RingMotion::level) raceways.template operator()<RingMotion::level, true>();
  else raceways.template operator()<RingMotion::tilting, true>();  // held coordinates have the spare row and column
  if (bodies.cage == CageKind::pockets) block_pocket_forces<DERIVATIVES>(bearing, bodies, layout, block, y, forces);
}

// The rates once all forces are known; `cage_inertia` sums m r^2 of the balls of an even cage, whose moments act on the cage.
template <bool DERIVATIVES>
inline void finish_rates(const Bearing &bearing, const Layout &layout, BallBlock &block, BodyForces &forces, Pack &cage_inertia) {
  Pack inertia = bearing.ball_mass * block.y[RADIUS] * block.y[RADIUS], moment = block.f[ORBIT_RATE];
  block.f[RADIUS] = block.y[VELOCITY], block.f[ANGLE] = block.y[ORBIT_RATE], block.f[HEIGHT] = block.y[VELOCITY + 2];
  block.f[GROSS_WORK] = absolute(block.f[DRIVE_WORK]);
  if (layout.even) {
    forces[layout.row[ORBIT_ROW] - BODY_ROWS] += masked(block.occupied, moment), cage_inertia += masked(block.occupied, inertia);
    return;
  }
  Pack inverse = 1.0 / inertia;
  block.f[ORBIT_RATE] = inverse * moment;
  if constexpr (DERIVATIVES) {
    Pack *row = block.jacobian[MOTION_ROWS + 1];
    row[BALL_POSITIONS] -= 2.0 * bearing.ball_mass * block.y[RADIUS] * block.f[ORBIT_RATE];  // the inertia grows with the radius
    for (int c = 0; c < (layout.unknowns ? int(SPARE_COLUMN) : int(BODY_POSITIONS)); c++) row[c] *= inverse;
  }
}

// Rates of the bodies at `time` by their inertia there and the `forces` of balls; with DERIVATIVES those of all other forces, too.
template <bool DERIVATIVES>
inline void body_rates(const CoupledBodies &bodies, const Layout &layout, double time, const double *inverse_inertia,
                       BodyStep &body, const BodyForces &forces) {
  double force[COORDINATES + INTEGRALS] = {};
  if constexpr (DERIVATIVES)
    for (int i = 0; i < MAX_FREE + INTEGRALS; i++)
      for (int j = 0; j < MAX_FREE; j++) body.by_position[i][j] = body.by_velocity[i][j] = 0.0;
  auto add = [&]<int ROW>(Index<ROW>, const auto &x) {
    force[ROW] += value_of(x);
    if constexpr (DERIVATIVES) {
      int row = ROW < COORDINATES ? layout.slot[ROW < COORDINATES ? ROW : 0] : MAX_FREE + ROW - COORDINATES;
      for_each_slope(x, [&](int variable, double slope) {
        int column = layout.slot[variable % COORDINATES];
        if (column < MAX_FREE) (variable < COORDINATES ? body.by_position : body.by_velocity)[row][column] += slope;
      });
    }
  };
  body_forces<DERIVATIVES>(bodies, time, body.y, add);
  body.f.fill(0.0);
  for (int k = 0; k < layout.unknowns; k++) {
    int c = layout.coordinate[k];
    body.f[c] = body.y[COORDINATES + c];
    body.f[COORDINATES + c] = inverse_inertia[k] * (force[c] + lane_sum(forces[k]));
  }
  for (int i = 0; i < INTEGRALS; i++) body.f[2 * COORDINATES + i] = force[COORDINATES + i];
}

// The unknown positions of a ball: with an even cage its orbit angle is that of the cage.
template <bool EVEN>
struct Unknown {
  static constexpr int count = EVEN ? 2 : 3;
  static constexpr int column(int i) { return EVEN ? 2 * i : i; }  // of a state
};

template <class T>
CORE_INLINE T reduced_ball_entry(const T *row, int j, const T &g) {
  return row[BALL_VELOCITIES + j] + g * row[BALL_POSITIONS + j];
}
template <class T>
CORE_INLINE T reduced_body_entry(const T *row, int c, const T &g) {
  return row[BODY_VELOCITIES + c] + g * row[BODY_POSITIONS + c];
}

using BodyMatrix = Pack[MAX_FREE][MAX_FREE];

// Factors of a block, and its part of the Schur complement; M is the capacity for unknowns of the bodies.
template <bool EVEN, int M>
[[gnu::noinline]] inline void factorise_block(BallBlock &block, BodyMatrix &schur, BodyMatrix &by_position) {
  constexpr int N = Unknown<EVEN>::count;
  const Pack g = block.gamma_step, diagonal = 1.0 / g;
  auto row_of = [&](int i) { return block.jacobian[i < N ? MOTION_ROWS + i : SPIN_ROWS + i - N]; };
  for (int i = 0; i < N + 3; i++) {
    const Pack *row = row_of(i);
    for (int j = 0; j < N; j++) block.inverse[i][j] = -reduced_ball_entry(row, j, g);
    for (int j = 0; j < 3; j++) block.inverse[i][N + j] = -row[BALL_SPINS + j];
    block.inverse[i][i] += diagonal;
  }
  invert_in_lanes<N + 3>(block.inverse);
  for (int r = 0; r < M; r++) {
    const Pack *row = block.jacobian[BODY_ROWS + r];
    for (int j = 0; j < N; j++) block.force_rows[r][j] = reduced_ball_entry(row, j, g);
    for (int j = 0; j < 3; j++) block.force_rows[r][N + j] = row[BALL_SPINS + j];
  }
  for (int c = 0; c < M; c++) {
    Pack right[N + 3], x[N + 3];
    for (int i = 0; i < N + 3; i++) right[i] = reduced_body_entry(row_of(i), c, g);
    multiply_in_lanes<N + 3>(block.inverse, right, x);
    for (int i = 0; i < N + 3; i++) block.body_response[i][c] = x[i];
    for (int r = 0; r < M; r++) {
      Pack sum = block.force_rows[r][0] * x[0];
      for (int i = 1; i < N + 3; i++) sum += block.force_rows[r][i] * x[i];
      schur[r][c] += reduced_body_entry(block.jacobian[BODY_ROWS + r], c, g) + masked(block.separate, sum);
      by_position[r][c] += block.jacobian[BODY_ROWS + r][BODY_POSITIONS + c];
    }
  }
}

// Forward elimination in a stage: `body_positions` (M,) are the known parts of the bodies' positions. `force_sum` sums the forces of
// the balls on the bodies.
template <bool EVEN, int M>
[[gnu::noinline]] inline void forward_eliminate_block(BallBlock &block, const double *body_positions, Pack *force_sum) {
  constexpr int N = Unknown<EVEN>::count;
  Pack ball_position[N], body_position[M];
  const Pack g = block.gamma_step;
  for (int c = 0; c < M; c++) body_position[c] = broadcast<Pack>(body_positions[c]);
  for (int i = 0; i < N; i++) ball_position[i] = g * block.rhs[Unknown<EVEN>::column(i)];
  for (int i = 0; i < N + 3; i++) {
    const Pack *row = block.jacobian[i < N ? MOTION_ROWS + i : SPIN_ROWS + i - N];
    Pack sum = block.rhs[i < N ? VELOCITY + Unknown<EVEN>::column(i) : SPIN + i - N], body_part{};
    for (int j = 0; j < N; j++) sum += row[BALL_POSITIONS + j] * ball_position[j];
    for (int c = 0; c < M; c++) body_part += row[BODY_POSITIONS + c] * body_position[c];
    block.reduced_rhs[i] = sum + body_part;
  }
  multiply_in_lanes<N + 3>(block.inverse, block.reduced_rhs, block.ball_solution);
  for (int r = 0; r < M; r++) {
    const Pack *row = block.jacobian[BODY_ROWS + r];
    Pack sum = row[BALL_POSITIONS] * ball_position[0], velocity_part = block.force_rows[r][0] * block.ball_solution[0];
    for (int j = 1; j < N; j++) sum += row[BALL_POSITIONS + j] * ball_position[j];
    for (int j = 1; j < N + 3; j++) velocity_part += block.force_rows[r][j] * block.ball_solution[j];
    force_sum[r] += sum + masked(block.separate, velocity_part);
  }
}

// Back substitution: the stage of the balls, once `positions` and `velocities` (M,) of the bodies are known; `cage` (2,) are those
// of an even cage.
template <bool EVEN, int M>
[[gnu::noinline]] inline void back_substitute_block(BallBlock &block, const double *positions, const double *velocities,
                                                    const double *cage, BallState &stage) {
  constexpr int N = Unknown<EVEN>::count;
  const Pack g = block.gamma_step;
  Pack p[M], s[M], v[N + 3];
  for (int c = 0; c < M; c++) p[c] = broadcast<Pack>(positions[c]), s[c] = broadcast<Pack>(velocities[c]);
  for (int i = 0; i < N + 3; i++) {
    v[i] = block.ball_solution[i];
    for (int c = 0; c < M; c++) v[i] += block.body_response[i][c] * s[c];
  }
  if (EVEN) stage[ANGLE] = broadcast<Pack>(cage[0]), stage[ORBIT_RATE] = broadcast<Pack>(cage[1]);
  Pack position[N];
  for (int i = 0; i < N; i++) {
    int c = Unknown<EVEN>::column(i);
    stage[c] = position[i] = g * (block.rhs[c] + v[i]), stage[VELOCITY + c] = v[i];
  }
  for (int i = 0; i < 3; i++) stage[SPIN + i] = v[N + i];
  Pack power[2];
  for (int n = 0; n < 2; n++) {
    const Pack *row = block.jacobian[POWER_ROWS + n];
    Pack sum = row[BALL_SPINS] * v[N] + row[BALL_SPINS + 1] * v[N + 1] + row[BALL_SPINS + 2] * v[N + 2], body_part{};
    for (int i = 0; i < N; i++) sum += row[BALL_VELOCITIES + i] * v[i] + row[BALL_POSITIONS + i] * position[i];
    for (int c = 0; c < M; c++) body_part += row[BODY_POSITIONS + c] * p[c];
    for (int c = 0; c < M; c++) body_part += row[BODY_VELOCITIES + c] * s[c];
    power[n] = sum + body_part;
  }
  stage[DRIVE_WORK] = g * (block.rhs[DRIVE_WORK] + power[0]), stage[DISSIPATED] = g * (block.rhs[DISSIPATED] + power[1]);
  stage[GROSS_WORK] = g * (block.rhs[GROSS_WORK] + select(block.start_rates[DRIVE_WORK] >= 0.0, power[0], -power[0]));
}

// Calls the instance for even cages or others, with capacity for the unknowns of the bodies.
template <class Function>
CORE_INLINE void call_sized(const Layout &layout, Function function) {
  auto with_capacity = [&]<bool EVEN>() __attribute__((always_inline)) {
    if (layout.unknowns == 0) function.template operator()<EVEN, 0>();
    else if (layout.unknowns == 1) function.template operator()<EVEN, 1>();
    else if (layout.unknowns <= 4) function.template operator()<EVEN, 4>();
    else if (layout.unknowns <= 6) function.template operator()<EVEN, 6>();
    else function.template operator()<EVEN, MAX_FREE>();
  };
  if (layout.even) with_capacity.template operator()<true>();
  else with_capacity.template operator()<false>();
}

// The inverse of the first n rows and columns, by Gauss and Jordan with pivots: a product a stage takes a third of a substitution.
inline void invert(const double (&matrix)[MAX_FREE][MAX_FREE], int n, double (&inverse)[MAX_FREE][MAX_FREE]) {
  double a[MAX_FREE][MAX_FREE];
  for (int i = 0; i < n; i++)
    for (int j = 0; j < n; j++) a[i][j] = matrix[i][j], inverse[i][j] = i == j ? 1.0 : 0.0;
  for (int c = 0; c < n; c++) {
    int pivot = c;
    for (int i = c + 1; i < n; i++)
      if (std::fabs(a[i][c]) > std::fabs(a[pivot][c])) pivot = i;
    if (pivot != c)
      for (int j = 0; j < n; j++) std::swap(a[c][j], a[pivot][j]), std::swap(inverse[c][j], inverse[pivot][j]);
    double inverse_pivot = 1.0 / a[c][c];
    for (int j = 0; j < n; j++) a[c][j] *= inverse_pivot, inverse[c][j] *= inverse_pivot;
    for (int i = 0; i < n; i++) {
      if (i == c) continue;
      double factor = a[i][c];
      for (int j = 0; j < n; j++) a[i][j] -= factor * a[c][j], inverse[i][j] -= factor * inverse[c][j];
    }
  }
}

// Factors of all blocks, and the Schur complement of the bodies and its inverse.
inline void factorise(const Layout &layout, std::vector<BallBlock> &blocks, BodyStep &body, double g) {
  BodyMatrix schur{}, by_position{};
  call_sized(layout, [&]<bool EVEN, int M>() __attribute__((always_inline)) {
    for (BallBlock &block : blocks) factorise_block<EVEN, M>(block, schur, by_position);
  });
  for (int i = 0; i < layout.unknowns; i++)
    for (int j = 0; j < layout.unknowns; j++) {
      body.position_coupling[i][j] = body.inverse_inertia[i] * (lane_sum(by_position[i][j]) + body.by_position[i][j]);
      double derivative = lane_sum(schur[i][j]) + body.by_velocity[i][j] + g * body.by_position[i][j];
      body.schur[i][j] = (i == j ? 1.0 / g : 0.0) - body.inverse_inertia[i] * derivative;
    }
  invert(body.schur, layout.unknowns, body.inverse);
}

}  // namespace core
