// Rosenbrock methods of balls, ring, cage and shaft. Coupled balls have common steps with the bodies that couple them. Uncoupled
// balls, between rings whose motion is prescribed, have individual steps: a lane whose ball has reached the end of the chunk takes
// the next one.
#include "chunk.hpp"
#include "numbers.hpp"

namespace core {

constexpr double LONGEST_FLIGHT = 5e-5;  // s, of a step that starts in flight: a bounce takes about as long
constexpr double LATE_EVENT = 0.95;  // fraction of a step: an event later in it counts as one at its end
// Lower bound of a step's error, relative to the change of a ball's speed by a contact that starts or ends in it: as a function of
// the instant within the step the error estimate has zeros.
constexpr double EVENT_ERROR = 0.1;

// Change of a ball's speed [m/s] within a step by a contact that starts in it, or that it would have without its end; else 0.
inline double contact_change(const Bearing &bearing, const Raceway &raceway, double begin, double end, double step) {
  double lag = bearing.power * bearing.relaxation_time * std::min(end - begin, 0.0) / step;
  double before = begin + lag, after = end + lag;
  double lasts = step / std::max(std::fabs(end - begin), 1e-300);
  if (before <= 0.0 && after > 0.0) {
    double load = end > 0.0 ? raceway.nominal_coefficient * std::pow(end, bearing.power) : 0.0;
    return load * (bearing.relaxation_time + end * lasts / (bearing.power + 1.0)) / bearing.ball_mass;
  }
  if (after <= 0.0 && before > 0.0) {
    double stiffness = bearing.power * raceway.nominal_coefficient * std::pow(std::max(end - after, 0.0), bearing.power - 1.0);
    return 0.5 * stiffness / bearing.power * after * after * lasts / bearing.ball_mass;
  }
  return 0.0;
}

// Lower bound of the error of a step [s] in which contacts of a ball start or end. While the outer contact carries load
// throughout there is none.
inline double least_error(const Chunk &chunk, double step, const Approaches &first, const Approaches &last) {
  const Bearing &bearing = chunk.bearing;
  double lag = bearing.power * bearing.relaxation_time * std::min(last[1] - first[1], 0.0) / step;
  if (!(std::min(first[1], last[1]) + lag <= 0.0)) return 0.0;
  double change = std::max(contact_change(bearing, bearing.outer, first[1], last[1], step),
                           contact_change(bearing, bearing.inner, first[0], last[0], step));
  return EVENT_ERROR / (chunk.scale[VELOCITY] * std::sqrt(double(MOTION))) * change;
}

// A step: `limit_steps` shortens it, `solve_stages` linearises at its start and solves the stages (`solve_stage`), `end_step` computes
// the state at its end and the error. Then `test_errors` accepts or rejects it, `write_outputs` writes the outputs in it, `accept`
// makes its end the next start and `propose_step` sets the next step, lane by lane.
class RosenbrockBalls {
 public:
  RosenbrockBalls(const Chunk &chunk, const RosenbrockMethod &method)
      : chunk(chunk),
        bearing(chunk.bearing),
        method(method),
        bodies(chunk.bodies),
        layout(bodies),
        uncoupled(layout.unknowns == 0) {
    for (int c = 0; c < MOTION; c++) inverse_scale[c] = 1.0 / chunk.scale[c];
    time_dependent = !bodies.torque_driven() && chunk.drive.acceleration != 0.0;
    for (int k = 0; k < layout.unknowns; k++) time_dependent |= bodies.load_rate[layout.coordinate[k]] != 0.0;
    time_dependent |= bodies.unbalance != 0.0 && !bodies.torque_driven();
    for (int i = 0; i < method.stages; i++) evaluations += !method.repeats_first(i);
  }

  // Integrates the numbered balls over the chunk: with common steps of balls and bodies, in the order of neighbours, or with
  // individual steps.
  Status run(const std::vector<int> &numbers, bool common_steps) {
    start(numbers, common_steps);
    while (running > 0) {
      if (*chunk.stop != 0) return STOPPED;
      limit_steps();
      solve_stages();
      test_errors();
      write_outputs();
      accept();
      for (BallBlock &block : blocks)
        for (int lane = 0; lane < LANES; lane++)
          if (block.ball[lane] >= 0)
            if (Status status = propose_step(block, lane); status != OK) return status;
    }
    std::copy(body_step.start.begin(), body_step.start.end(), chunk.body_state);
    return OK;
  }

  // For tests: the rates of balls and bodies (count COLUMNS + BODY_NUMBERS,), and the solutions x (sides, as the rates) of
  // x/gamma_step - J x = rhs, with an orbit rate instead of the tangential velocity.
  void linear_solutions(const std::vector<int> &numbers, double gamma_step, int sides, const double *rhs, double *rates,
                        double *solutions) {
    start(numbers, true);
    int count = int(numbers.size());
    linearise();
    for (BallBlock &block : blocks) block.gamma_step = broadcast<Pack>(gamma_step);
    factorise_system();
    auto each_number = [&](auto function) {
      for (int i = 0; i < count; i++)
        for (int c = 0; c < COLUMNS; c++) function(blocks[i / LANES], i % LANES, c, i * COLUMNS + c);
    };
    each_number([&](BallBlock &block, int lane, int c, int number) { rates[number] = block.start_rates[c][lane]; });
    std::copy(body_step.start_rates.begin(), body_step.start_rates.end(), rates + count * COLUMNS);
    for (int n = count * COLUMNS + BODY_NUMBERS; sides-- > 0; rhs += n, solutions += n) {
      each_number([&](BallBlock &block, int lane, int c, int number) { block.rhs[c][lane] = rhs[number]; });
      std::copy(rhs + count * COLUMNS, rhs + n, body_step.rhs.begin());
      call_sized(layout, [&]<bool EVEN, int M>() { solve_stage<EVEN, M>(0); });
      each_number([&](BallBlock &block, int lane, int c, int number) { solutions[number] = block.stage[0][c][lane]; });
      std::copy(body_step.stage[0].begin(), body_step.stage[0].end(), solutions + count * COLUMNS);
    }
  }

 private:
  const Chunk &chunk;
  const Bearing &bearing;
  const RosenbrockMethod &method;
  const CoupledBodies &bodies;
  const Layout layout;
  const bool uncoupled;  // no ring and no cage couples the balls
  bool common = false, time_dependent;  // the second: forces depend on time explicitly
  std::vector<int> numbers;
  std::vector<BallBlock> blocks;
  int waiting = 0, running = 0, evaluations = 0, next_output = 0;
  double inverse_scale[MOTION];
  BodyStep body_step;
  // Of common steps: time, length, error of the bodies, the next step by error control, and the least step after a limited one.
  double time = 0.0, step = 0.0, error = 0.0, next = 0.0, least_next = 0.0;
  TouchingBalls touching;
  double land_acceleration = 0.0;  // m/s^2, of the cage's centre towards its land
  bool crosses_defects = false;  // of any ball in this step
  bool jacobian_is_current = false;  // as all last steps were rejected, rates and Jacobian at their starts are those of this step

  void start(const std::vector<int> &balls, bool common_steps) {
    numbers = balls, common = common_steps;
    touching.start(chunk.near, chunk.balls, numbers);
    blocks.assign(common ? (numbers.size() + LANES - 1) / LANES : 1, BallBlock{});
    std::copy(chunk.body_state, chunk.body_state + BODY_NUMBERS, body_step.start.begin());
    for (BallBlock &block : blocks) {
      for (int lane = 0; lane < LANES; lane++) running += start_ball(block, lane);
      follow_cage(block.start, body_step.start, block);
    }
    for (int k = 0; k < layout.unknowns; k++) body_step.inverse_inertia[k] = 1.0 / bodies.inertia[layout.coordinate[k]];
  }
  // Puts the next ball into a lane; a lane without a ball repeats the start of the last one.
  bool start_ball(BallBlock &block, int lane) {
    bool idle = waiting >= int(numbers.size());
    int ball = numbers[std::min(waiting, int(numbers.size()) - 1)];
    chunk.load(ball, block, lane);
    block.ball[lane] = idle ? -1 : ball, block.next_output[lane] = 0;
    block.occupied[lane] = block.separate[lane] = idle ? 0 : -1;
    block.pocket_angle[lane] = 2.0 * M_PI * ball / chunk.balls;
    block.time[lane] = 0.0, block.step[lane] = std::min(chunk.step[ball], chunk.duration);
    waiting += !idle;
    return !idle;
  }

  // Balls of an even cage orbit with it.
  void follow_cage(BallState &y, const BodyState &body, const BallBlock &block) const {
    if (!layout.even) return;
    y[ANGLE] = body[CAGE_ANGLE] + block.pocket_angle, y[ORBIT_RATE] = broadcast<Pack>(body[COORDINATES + CAGE_ANGLE]);
  }

  void prescribe_shaft(BodyState &y, double t) const {
    if (bodies.torque_driven()) return;
    y[SHAFT] = chunk.drive.angle_at(t), y[COORDINATES + SHAFT] = chunk.drive.speed_at(t);
  }

  // Steps end where the chunk ends and where balls reach defects and walls. Steps that start in flight are short: one that starts
  // and ends there may miss a bounce, which none of its stages evaluates.
  void limit_steps() {
    locate_defects();
    double least = HUGE_VAL;
    for (BallBlock &block : blocks) {
      Pack outer{};
      if (uncoupled) outer = outer_approach(bearing, block.start) + block.heights.outer.value;
      for (int lane = 0; lane < LANES; lane++) {
        double &uncut = block.uncut_step[lane];
        uncut = block.step[lane];
        if (uncoupled && uncut > LONGEST_FLIGHT && outer[lane] < 0.0 && approaches(block, block.start, lane, 0.0)[0] < 0.0)
          uncut = LONGEST_FLIGHT;
        if (bearing.defects.count) uncut = std::min(uncut, resolving_step(bearing.defects, block.surface, lane));
        if (block.occupied[lane]) least = std::min(least, uncut);
      }
    }
    for (BallBlock &block : blocks)
      for (int lane = 0; lane < LANES; lane++) {
        if (common) block.uncut_step[lane] = least;
        double remaining = chunk.duration - block.time[lane];
        block.step[lane] = block.uncut_step[lane] >= remaining - NEGLIGIBLE * chunk.duration ? remaining : block.uncut_step[lane];
      }
    time = blocks[0].time[0], step = blocks[0].step[0], least_next = 0.0;
    if (bodies.cage != CageKind::pockets) return;
    limit_at_walls();
    for (BallBlock &block : blocks) block.step = broadcast<Pack>(step);
  }

  // Positions of balls on surfaces with defects, and whether they cross any.
  void locate_defects() {
    if (!bearing.defects.count) return;
    crosses_defects = false;
    for (BallBlock &block : blocks) {
      Pack turned, speed;
      Mask first;
      for (int lane = 0; lane < LANES; lane++) {
        turned[lane] = bodies.torque_driven() ? body_step.start[SHAFT] : chunk.drive.angle_at(block.time[lane]);
        speed[lane] = bodies.torque_driven() ? body_step.start[COORDINATES + SHAFT] : chunk.drive.speed_at(block.time[lane]);
        first[lane] = block.ball[lane] == 0 ? -1 : 0;
      }
      block.surface = surface_positions(block.start[ANGLE], block.start[ORBIT_RATE], turned, speed, block.start_orientation,
                                        spin_in_frame(block.start), first);
      block.crosses_defects = false;
      for (int lane = 0; lane < LANES; lane++)
        block.crosses_defects |= crosses_defect(bearing.defects, block.surface, lane, block.step[lane]);
      block.heights = block.crosses_defects ? heights_at(bearing.defects, block.surface, Pack{}) : Heights{};
      crosses_defects |= block.crosses_defects;
    }
  }

  // Rates `f` of all at their states `y`, at a fraction of the step; those of an even cage by its inertia with its balls.
  template <bool DERIVATIVES>
  void evaluate(double fraction) {
    BodyForces forces{};
    Pack cage_inertia{};
    double t = time + fraction * step;
    prescribe_shaft(body_step.y, t);
    for (BallBlock &block : blocks) {
      Pack shaft_speed = broadcast<Pack>(body_step.y[COORDINATES + SHAFT]);
      if (uncoupled) shaft_speed = chunk.drive.speed_at(block.time + fraction * block.step);
      if (block.crosses_defects) block.heights = heights_at(bearing.defects, block.surface, fraction * block.step);
      if (DERIVATIVES && touching.active())
        std::fill(&block.jacobian[0][0], &block.jacobian[0][0] + JACOBIAN_ROWS * JACOBIAN_COLUMNS, Pack{});
      follow_cage(block.y, body_step.y, block);
      block_forces<DERIVATIVES>(bearing, bodies, layout, block, body_step.y, shaft_speed, forces);
    }
    if (touching.active()) touching.add<DERIVATIVES>(bearing, blocks);
    for (BallBlock &block : blocks) finish_rates<DERIVATIVES>(bearing, layout, block, forces, cage_inertia);
    if (uncoupled) return;
    double inverse_inertia[MAX_FREE];
    std::copy(body_step.inverse_inertia, body_step.inverse_inertia + MAX_FREE, inverse_inertia);
    if (layout.even) inverse_inertia[layout.slot[CAGE_ANGLE]] = 1.0 / (bodies.inertia[CAGE_ANGLE] + lane_sum(cage_inertia));
    body_rates<DERIVATIVES>(bodies, layout, t, inverse_inertia, body_step, forces);
    if (DERIVATIVES) std::copy(inverse_inertia, inverse_inertia + MAX_FREE, body_step.inverse_inertia);
  }

  // Calls function(step states) for all blocks of balls and, where they are coupled, for the bodies.
  template <class Function>
  void for_each_step(Function function) {
    for (BallBlock &block : blocks) function(block);
    if (!uncoupled) function(body_step);
  }

  void linearise() {
    for_each_step([](auto &s) { s.y = s.start; });
    evaluate<true>(0.0);
    for_each_step([](auto &s) { s.start_rates = s.f; });
    if (!layout.even) return;
    double acceleration =
        body_step.start_rates[COORDINATES + CAGE_ANGLE];  // the inertia of an even cage grows with its balls' radii
    for (BallBlock &block : blocks)
      block.jacobian[layout.row[ORBIT_ROW]][BALL_POSITIONS] -=
          masked(block.occupied, 2.0 * bearing.ball_mass * acceleration * block.start[RADIUS]);
  }

  // Rates a little later, for df/dt.
  void evaluate_later() {
    for (BallBlock &block : blocks) block.carried.forget_films();
    for_each_step([](auto &s) { s.y = s.start; });
    evaluate<false>(TIME_DIFFERENCE);
    for_each_step([](auto &s) { s.time_derivative = s.f; });
  }
  void difference_in_time() {
    for_each_step([](auto &s) {
      for (std::size_t n = 0; n < s.y.size(); n++)
        s.time_derivative[n] = (s.time_derivative[n] - s.start_rates[n]) * (1.0 / TIME_DIFFERENCE);
    });
  }

  // The state y + sum_j a_ij u_j of stage I, and sum_j c_ij u_j of its right-hand side.
  template <int I, class S>
  [[gnu::noinline]] static void combine_stages(const double *a, const double *c, const S *stage, const S &start, S &y, S &rhs) {
    double weight_a[I], weight_c[I];
    for (int i = 0; i < I; i++) weight_a[i] = a[i], weight_c[i] = c[i];
    for (int n = 0; n < int(start.size()); n++) {
      auto state = start[n] + weight_a[0] * stage[0][n];
      auto sum = weight_c[0] * stage[0][n];
      for (int i = 1; i < I; i++) state += weight_a[i] * stage[i][n], sum += weight_c[i] * stage[i][n];
      y[n] = state, rhs[n] = sum;
    }
  }

  void factorise_system() {
    double g = blocks[0].gamma_step[0];
    touching.choose_members(blocks);
    factorise(layout, blocks, body_step, g);
    if (touching.any_touch()) touching.factorise(layout, blocks, body_step, g);
  }

  void solve_stages() {
    bool explicit_time = time_dependent || crosses_defects;
    if (explicit_time) evaluate_later();
    if (!jacobian_is_current) linearise();
    if (explicit_time) difference_in_time();
    for (BallBlock &block : blocks) block.gamma_step = method.gamma * block.step, block.inverse_step = 1.0 / block.step;
    body_step.inverse_step = 1.0 / step;
    factorise_system();
    make_stage<0>(), make_stage<1>(), make_stage<2>(), make_stage<3>();
    if (method.stages > 4) make_stage<4>(), make_stage<5>();
    end_step();
  }

  template <int I>
  void make_stage() {
    if constexpr (I == 0) for_each_step([](auto &s) { s.rhs = s.f = s.start_rates, s.y = s.start; });
    else {
      for_each_step([&](auto &s) { combine_stages<I>(method.a[I], method.c[I], s.stage, s.start, s.y, s.rhs); });
      if (!method.repeats_first(I)) evaluate<false>(method.alpha[I]);
      for_each_step([](auto &s) {
        for (std::size_t n = 0; n < s.rhs.size(); n++) s.rhs[n] = s.f[n] + s.inverse_step * s.rhs[n];
      });
    }
    if (time_dependent || crosses_defects)
      for_each_step([&](auto &s) {
        for (std::size_t n = 0; n < s.rhs.size(); n++) s.rhs[n] += method.d[I] * s.time_derivative[n];
      });
    call_sized(layout, [&]<bool EVEN, int M>() { solve_stage<EVEN, M>(I); });
  }

  // Solves for a stage; M is the capacity for unknowns of the bodies, padded with zeros.
  template <bool EVEN, int M>
  [[gnu::noinline]] void solve_stage(int stage) {
    std::array<double, M> known_positions{}, positions{}, velocities{}, rhs{};
    std::array<Pack, M> force_sum{};
    BodyState &x = body_step.stage[stage];
    double g = blocks[0].gamma_step[0];
    for (int k = 0; k < layout.unknowns; k++) known_positions[k] = g * body_step.rhs[layout.coordinate[k]];
    for (BallBlock &block : blocks) forward_eliminate_block<EVEN, M>(block, known_positions.data(), force_sum.data());
    for (int i = 0; i < layout.unknowns; i++) {
      rhs[i] = body_step.rhs[COORDINATES + layout.coordinate[i]] + body_step.inverse_inertia[i] * lane_sum(force_sum[i]);
      for (int j = 0; j < M; j++) rhs[i] += body_step.position_coupling[i][j] * known_positions[j];
    }
    if (touching.any_touch()) touching.solve(layout, blocks, g, rhs.data());
    for (int i = 0; i < layout.unknowns; i++) {
      if (touching.any_touch()) velocities[i] = rhs[i];
      else
        for (int j = 0; j < M; j++) velocities[i] += body_step.inverse[i][j] * rhs[j];
      positions[i] = known_positions[i] + g * velocities[i];
      x[layout.coordinate[i]] = positions[i], x[COORDINATES + layout.coordinate[i]] = velocities[i];
    }
    for (int n = 0; n < INTEGRALS && M > 0; n++) {
      double sum = body_step.rhs[2 * COORDINATES + n];
      for (int j = 0; j < M; j++)
        sum += body_step.by_position[MAX_FREE + n][j] * positions[j] + body_step.by_velocity[MAX_FREE + n][j] * velocities[j];
      x[2 * COORDINATES + n] = g * sum;
    }
    double cage[2] = {x[CAGE_ANGLE], x[COORDINATES + CAGE_ANGLE]};
    for (BallBlock &block : blocks)
      back_substitute_block<EVEN, M>(block, positions.data(), velocities.data(), cage, block.stage[stage]);
    touching.add_losses(blocks, g, stage);
  }

  // States and orientations at the end, and the errors: root mean squares of the motion of each ball and of the bodies.
  void end_step() {
    int last = method.stages - 1, numbers_with_scale = 0;
    double squares = 0.0;
    for (int c = 0; c < BODY_NUMBERS; c++) body_step.end[c] = body_step.y[c] + body_step.stage[last][c];
    for (int k = 0; k < layout.unknowns; k++) {
      int c = layout.coordinate[k];
      for (auto [scale, difference] : {std::pair{bodies.position_scale[c], body_step.stage[last][c]},
                                       {bodies.velocity_scale[c], body_step.stage[last][COORDINATES + c]}}) {
        if (scale == 0.0) continue;
        squares += difference / scale * (difference / scale), numbers_with_scale++;
      }
    }
    error = std::sqrt(squares / std::max(numbers_with_scale, 1));
    for (BallBlock &block : blocks) {
      const BallState &s = block.stage[last];
      for (int c = 0; c < COLUMNS; c++) block.end[c] = block.y[c] + s[c];
      follow_cage(block.end, body_step.end, block);
      Pack weight = broadcast<Pack>(1.0);
      if (bodies.cage == CageKind::pockets)
        weight = walls::groove_error_weight(outer_approaches(block.start, body_step.start),
                                            outer_approaches(block.end, body_step.end), bodies.light);
      // A ball that leaves a raceway moves freely while its contact still dissipates the energy it stores.
      block.error = maximum(absolute(s[DISSIPATED]) * (1.0 / chunk.scale[MOTION]),
                            square_root(scaled_square_sum(block.start, s, weight, inverse_scale) * (1.0 / MOTION)));
      if (uncoupled) bound_event_errors(block);
      for (int c : {ORBIT_RATE, int(SPIN), SPIN + 1, SPIN + 2}) block.prepare_dense_output(method, c);
      block.end_orientation = rotated(block.start_orientation, spin_in_frame(block.start), spin_inside(block, broadcast<Pack>(0.5)),
                                      spin_in_frame(block.end), block.step);
    }
  }
  static Triple spin_inside(const BallBlock &block, const Pack &fraction) {
    return {block.dense_output(fraction, SPIN), block.dense_output(fraction, SPIN + 1),
            block.dense_output(fraction, SPIN + 2) - block.dense_output(fraction, ORBIT_RATE)};
  }
  void bound_event_errors(BallBlock &block) const {
    Heights end_heights = block.crosses_defects ? heights_at(bearing.defects, block.surface, block.step) : Heights{};
    Pack first = outer_approach(bearing, block.start), last = outer_approach(bearing, block.end) + end_heights.outer.value;
    if (block.crosses_defects) first += heights_at(bearing.defects, block.surface, Pack{}).outer.value;
    Pack least = minimum(first, last) + bearing.power * bearing.relaxation_time * minimum(last - first, 0.0) / block.step;
    for (int lane = 0; lane < LANES; lane++)
      if (least[lane] <= 0.0 && block.error[lane] <= 1.0)
        block.error[lane] =
            std::max(double(block.error[lane]), least_error(chunk, block.step[lane], approaches(block, block.start, lane, 0.0),
                                                            approaches(block, block.end, lane, 1.0)));
  }

  // Accepts or rejects the steps of lanes, all or none where steps are common, and sets up to when each writes outputs.
  void test_errors() {
    double worst = error < HUGE_VAL ? error : HUGE_VAL, fraction = 1.0;
    for (BallBlock &block : blocks)
      for (int lane = 0; lane < LANES; lane++) {
        if (block.ball[lane] < 0) continue;
        chunk.counts[2] += evaluations - jacobian_is_current, chunk.counts[3] += !jacobian_is_current;
        worst = std::max(worst, block.error[lane] < HUGE_VAL ? double(block.error[lane]) : HUGE_VAL);
      }
    if (common) next = next_step(step, worst, method.order);
    for (BallBlock &block : blocks)
      for (int lane = 0; lane < LANES; lane++) {
        if (common) block.error[lane] = worst;
        block.accepted_fraction[lane] = block.ball[lane] >= 0 && block.error[lane] <= 1.0 && method.ends_steps_at_contacts
                                            ? contact_fraction(block, lane)
                                            : 1.0;
        fraction = std::min(fraction, block.accepted_fraction[lane]);
      }
    for (BallBlock &block : blocks)
      for (int lane = 0; lane < LANES; lane++) {
        if (common) block.accepted_fraction[lane] = fraction;
        double end = block.time[lane] + block.step[lane];
        bool accepted =
            block.error[lane] <= 1.0 && block.accepted_fraction[lane] >= LATE_EVENT && (common || block.ball[lane] >= 0);
        block.output_end[lane] = !accepted ? -HUGE_VAL : end >= chunk.duration * (1.0 - NEGLIGIBLE) ? HUGE_VAL : end;
      }
  }

  void write_outputs() {
    for (BallBlock &block : blocks)
      for (bool first = true;; first = false) {
        Pack fraction{};
        bool any_due = false, due[LANES];
        for (int lane = 0; lane < LANES; lane++) {
          due[lane] = block.ball[lane] >= 0 && block.next_output[lane] < chunk.instants &&
                      chunk.instant[block.next_output[lane]] <= block.output_end[lane];
          if (due[lane]) fraction[lane] = (chunk.instant[block.next_output[lane]] - block.time[lane]) / block.step[lane];
          any_due |= due[lane];
        }
        if (!any_due) break;
        if (first)
          for (int c = 0; c < COLUMNS; c++) block.prepare_dense_output(method, c);
        BallState state;
        for (int c = 0; c < COLUMNS; c++) state[c] = block.dense_output(fraction, c);
        Quaternion orientation = rotated(block.start_orientation, spin_in_frame(block.start), spin_inside(block, 0.5 * fraction),
                                         spin_in_frame(state), fraction * block.step);
        for (int lane = 0; lane < LANES; lane++)
          if (due[lane]) chunk.store(block.next_output[lane]++, block.ball[lane], state, orientation, lane);
      }
    if (uncoupled) return;
    for (bool first = true; next_output < chunk.instants && chunk.instant[next_output] <= blocks[0].output_end[0];
         next_output++, first = false)
      for (int c = 0; c < BODY_NUMBERS; c++) {
        if (first) body_step.prepare_dense_output(method, c);
        chunk.body_states[next_output * BODY_NUMBERS + c] = body_step.dense_output((chunk.instant[next_output] - time) / step, c);
      }
  }

  void accept() {
    bool accepted = false;
    for (const BallBlock &block : blocks)
      for (double end : block.output_end) accepted |= end >= 0.0;
    jacobian_is_current = !accepted;
    if (jacobian_is_current) return;
    if (bodies.cage == CageKind::pockets) store_cage_accelerations();
    if (!uncoupled) body_step.start = body_step.end;
    for (BallBlock &block : blocks) {
      Mask moved;
      for (int lane = 0; lane < LANES; lane++) {
        moved[lane] = block.output_end[lane] >= 0.0 ? -1 : 0;
        if (bearing.carried != CarriedLaw::none && moved[lane])
          advance_carried(bearing, positions_in_rings(lane_state(block.end, lane), body_step.start), lane, block.carried);
      }
      block.time = select(moved, block.time + block.step, block.time);
      for (int c = 0; c < COLUMNS; c++) block.start[c] = select(moved, block.end[c], block.start[c]);
      for (int c = 0; c < 4; c++) block.start_orientation[c] = select(moved, block.end_orientation[c], block.start_orientation[c]);
    }
    if (!touching.active()) return;
    BallBlock &tail = blocks.back();  // balls in spare lanes have no contact forces of neighbours
    int last = (int(numbers.size()) - 1) % LANES;
    for (int lane = last + 1; lane < LANES; lane++)
      for (int c = 0; c < COLUMNS; c++) tail.start[c][lane] = tail.start[c][last];
  }

  // Sets the next step of a lane; at the end of the chunk its ball is replaced by the next one.
  Status propose_step(BallBlock &block, int lane) {
    int ball = block.ball[lane];
    double proposed = common ? next : next_step(block.step[lane], block.error[lane], method.order);
    if (block.output_end[lane] < 0.0) {
      chunk.counts[1] += 1;
      bool cut_at_event = block.error[lane] <= 1.0;
      block.step[lane] = cut_at_event ? block.step[lane] * block.accepted_fraction[lane] : proposed;
      return block.step[lane] < LEAST_STEP && !cut_at_event ? chunk.fail(STALLED, block.time[lane], ball) : OK;
    }
    chunk.counts[0] += 1;
    block.step[lane] = std::max(proposed, least_next);
    if (block.output_end[lane] < HUGE_VAL) return OK;
    chunk.step[ball] =
        std::max(block.uncut_step[lane], double(block.step[lane]));  // a step shortened by the end counts only if it is longer
    chunk.store(-1, ball, block.start, block.start_orientation, lane);
    store_carried(block.carried, lane, chunk.carried + ball * CARRIED);
    auto y = lane_state(block.start, lane);
    if (Status status = check_ball(bearing, y, positions_in_rings(y, body_step.start)); status != OK)
      return chunk.fail(status, chunk.duration, ball);
    running -= !start_ball(block, lane);
    return OK;
  }

  // Ends the step where a ball reaches a wall of its pocket or leaves it.
  void limit_at_walls() {
    double uncut = step, mass = walls::reduced_mass(bearing, bodies);
    double blur = chunk.scale[ORBIT_RATE] * bearing.ball_mass / bodies.pockets.wall.stiffness;
    walls::StepLimit limit{step, 0.0};
    for (const BallBlock &block : blocks) {
      PocketGap gap = cage_pocket(bearing, bodies, block.pocket_angle, ElementInput<false>{block.start, body_step.start},
                                  [](int, const auto &) {});
      for (int lane = 0; lane < LANES; lane++) {
        if (block.ball[lane] < 0) continue;
        double approach = gap.approach[lane], rate = gap.rate[lane];
        double kink =
            walls::time_to_kink(bodies.pockets.wall, mass, blur, approach, rate, gap.side[lane] * block.pocket_acceleration[lane]);
        if (kink < limit.step) limit = {kink, approach < 0.0 ? std::min(uncut, walls::FIRST_DEPTH * ONSET / rate) : uncut};
      }
    }
    if (bodies.guided) limit = walls::limit_at_land(bodies, body_step.start, land_acceleration, uncut, limit);
    step = limit.step, least_next = limit.least_next;
  }

  // Stores the accelerations of balls in their pockets, and of the cage towards its land, at the end of an accepted step.
  void store_cage_accelerations() {
    const double *acceleration = body_step.f.data() + COORDINATES;
    for (BallBlock &block : blocks) {
      auto [cosine, sine] = cosine_sine_value(block.end[ANGLE]);
      block.pocket_acceleration = bodies.pockets.radius * (block.f[ORBIT_RATE] - acceleration[CAGE_ANGLE]) -
                                  (cosine * acceleration[CAGE_Y] - sine * acceleration[CAGE_X]);
    }
    if (bodies.guided) land_acceleration = walls::land_acceleration(bodies, body_step.end, body_step.f);
  }

  // Positions of a ball in the axes of both rings.
  template <class Y>
  RingPositions positions_in_rings(const Y &y, const BodyState &body) const {
    if (bodies.ring == RingMotion::held || bodies.ring == RingMotion::tilted) return prescribed_positions(bearing, y);
    double housing[3], level[2] = {};
    for (int i = 0; i < 3; i++) housing[i] = body[HOUSING] * bodies.direction[i];
    return {position_in_ring(&body[RING_X], &body[TILT_X], y), position_in_ring(housing, level, y)};
  }
  Pack outer_approaches(const BallState &y, const BodyState &body) const {
    if (!bodies.free[HOUSING]) return outer_approach(bearing, y);
    Pack approach;
    for (int lane = 0; lane < LANES; lane++)
      approach[lane] = raceway_approaches(bearing, positions_in_rings(lane_state(y, lane), body))[1];
    return approach;
  }
  // Approaches of a ball at the position `y`, at a fraction of the step.
  template <class Y>
  Approaches approaches_at(const BallBlock &block, int lane, const Y &y, double fraction) const {
    Approaches smooth = raceway_approaches(bearing, positions_in_rings(y, body_step.start));
    if (!block.crosses_defects) return smooth;
    Heights heights = heights_at(bearing.defects, block.surface, fraction * block.step);
    return {smooth[0] + heights.inner.value[lane], smooth[1] + heights.outer.value[lane]};
  }
  Approaches approaches(const BallBlock &block, const BallState &y, int lane, double fraction) const {
    return approaches_at(block, lane, lane_state(y, lane), fraction);
  }

  // The fraction of the step at which a contact of the ball in a lane with a raceway has just started or ended; 1 where none does.
  double contact_fraction(BallBlock &block, int lane) {
    Approaches before = approaches(block, block.start, lane, 0.0);
    if (!changes_contact(before, approaches(block, block.end, lane, 1.0))) return 1.0;
    for (int c = 0; c < VELOCITY; c++) block.prepare_dense_output(method, c);
    return event_fraction(before, [&](double fraction) {
      std::array<double, 3> position;
      for (int c = 0; c < 3; c++) position[c] = block.dense_output(fraction, c)[lane];
      return approaches_at(block, lane, position, fraction);
    });
  }
};

// Divides the circle of balls into rows of neighbours that may touch.
inline std::vector<std::vector<int>> groups_of(const Chunk &chunk) {
  auto touches_previous = [&](int k) { return chunk.near[(k + chunk.balls - 1) % chunk.balls] != 0; };
  int first = 0;
  while (first < chunk.balls && touches_previous(first)) first++;
  std::vector<std::vector<int>> groups{{first % chunk.balls}};
  for (int k = first + 1; k < first + chunk.balls; k++) {
    if (!touches_previous(k % chunk.balls)) groups.emplace_back();
    groups.back().push_back(k % chunk.balls);
  }
  return groups;
}

Status by_rosenbrock(const Chunk &chunk, const RosenbrockMethod &method) {
  std::vector<std::vector<int>> coupled;
  std::vector<int> separate;
  if (Layout(chunk.bodies).unknowns > 0) {
    coupled.emplace_back();
    for (int ball = 0; ball < chunk.balls; ball++) coupled[0].push_back(ball);
  } else
    for (const std::vector<int> &group : groups_of(chunk))
      if (group.size() > 1) coupled.push_back(group);
      else separate.push_back(group[0]);
  Status status = separate.empty() ? OK : RosenbrockBalls(chunk, method).run(separate, false);
  for (const std::vector<int> &group : coupled)
    if (status == OK) status = RosenbrockBalls(chunk, method).run(group, true);
  return status;
}

}  // namespace core

using namespace core;

// For tests, of all balls, their tangential velocities in `state`, and the bodies: see `linear_solutions`.
CORE_EXPORT void core_linear_solutions(const double *bearing_numbers, const double *points, const double *body_numbers,
                                       const double *load, const double *load_rate, const double *drive, std::int64_t balls,
                                       const std::uint8_t *near, double *state, const double *border, double gain,
                                       std::int64_t sides, const double *right, double *rates, double *solutions) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  CoupledBodies bodies = bodies_of(body_numbers, load, load_rate);
  RosenbrockMethod method{};
  BodyState body_state = state_of(bearing, bodies, border);
  double scale[SCALES] = {};
  std::vector<double> orientations(4 * balls), steps(balls, 1.0), carried(CARRIED * balls);
  std::vector<int> numbers(balls);
  for (int ball = 0; ball < balls; ball++) numbers[ball] = ball;
  Chunk chunk{bearing,      bodies,         drive_of(drive),   1.0,     scale,   0,
              nullptr,      nullptr,        int(balls),        near,    state,   orientations.data(),
              steps.data(), carried.data(), body_state.data(), nullptr, nullptr, nullptr,
              nullptr,      nullptr};
  RosenbrockBalls(chunk, method).linear_solutions(numbers, gain, int(sides), right, rates, solutions);
}
