// Balls, ring, cage and shaft as one system with common steps: a chunk by a Rosenbrock method; exported functions on
// C-contiguous arrays of doubles.
#include "free_balls.hpp"
#include "numbers.hpp"
#include "touching_balls.hpp"

namespace core {

// State of the bodies at the chunk's begin, moved on in place, and at the instants (instants, BODY_NUMBERS).
struct BodyResults { double *state, *states; };

namespace coupled_balls {

// A step: `cut_at_walls` shortens it, `make_step` linearises at its start (`linearise`, `factorise_system`) and solves the
// stages (`solve_stage`), `end_step` finds the state at its end and the error. Then it is repeated, or `give_out` writes the
// outputs in it and `move_on` begins the next.
class Integration {
 public:
  Integration(const Chunk &chunk, const CoupledBodies &bodies, const Results &results, const BodyResults &body_results)
      : chunk(chunk), bearing(chunk.bearing), method(chunk.method), bodies(bodies), layout(bodies), out(results), body_out(body_results) {
    for (int c = 0; c < MOTION; c++) over_scale[c] = 1.0 / chunk.scale[c];
    alone = layout.unknowns == 0;
    varies = !bodies.torque_driven() && bodies.shaft_acceleration != 0.0;
    for (int k = 0; k < layout.unknowns; k++) varies |= bodies.load_rate[layout.coordinate[k]] != 0.0;
    varies |= bodies.unbalance != 0.0 && !bodies.torque_driven();
    for (int i = 0; i < method.stages; i++) evaluations += !method.repeats_first(i);
  }

  // Moves the numbered balls, neighbours one after the other, and the bodies through the chunk.
  // `near` says which of all balls may touch the next ahead.
  Status run(const std::int64_t *numbers, int count, const std::uint8_t *near) {
    begin(numbers, count);
    touching.begin(near, out.balls, numbers, count);
    for (;;) {
      if (*chunk.stop != 0) return STOPPED;
      double wanted = step, left = chunk.duration - time;
      find_places(wanted);
      if (alone && wanted > LONGEST_FLIGHT && any_flies()) wanted = LONGEST_FLIGHT;
      for (int place = 0; bearing.defects.count && place < count; place++)
        wanted = std::min(wanted, resolving_step(bearing.defects, blocks[place / LANES].places, place % LANES));
      step = wanted >= left - NEGLIGIBLE * chunk.duration ? left : wanted;
      double resume = cut_at_walls();
      make_step();
      out.counts[2] += count * (evaluations - again), out.counts[3] += count * !again;
      double proposed = next_step(step, error, method.order);
      double share = error <= 1.0 && method.ends_steps_at_contacts ? landing_share() : 1.0;
      if (!(error <= 1.0) || share < LANDED) {
        out.counts[1] += count;
        bool landed = error <= 1.0;
        step = landed ? step * share : proposed, again = true;
        if (step < LEAST_STEP && !landed) return failed(STALLED, time, numbers[0]);
        continue;
      }
      out.counts[0] += count;
      bool last = time + step >= chunk.duration * (1.0 - NEGLIGIBLE);
      give_out(last ? HUGE_VAL : time + step);
      move_on();
      step = std::max(proposed, resume);
      if (last) return finish(std::max(wanted, step));
    }
  }

  // For tests: the rates of balls and bodies (count COLUMNS + BODY_NUMBERS,), and the solutions x (sides, as the rates) of
  // x/gain - J x = right, an orbit rate in place of the tangential velocity.
  void linear_answers(const std::int64_t *numbers, int count, const std::uint8_t *near, double its_gain, int sides, const double *right,
                      double *rates, double *answers) {
    begin(numbers, count);
    touching.begin(near, out.balls, numbers, count);
    linearise();
    factorise_system(its_gain);
    auto each_number = [&](auto function) {
      for (int place = 0; place < count; place++)
        for (int c = 0; c < COLUMNS; c++) function(blocks[place / LANES], place % LANES, c, place * COLUMNS + c);
    };
    each_number([&](BallBlock &k, int lane, int c, int number) { rates[number] = k.first[c][lane]; });
    std::copy(e.first.begin(), e.first.end(), rates + count * COLUMNS);
    for (int n = count * COLUMNS + BODY_NUMBERS; sides-- > 0; right += n, answers += n) {
      each_number([&](BallBlock &k, int lane, int c, int number) { k.right[c][lane] = right[number]; });
      std::copy(right + count * COLUMNS, right + n, e.right.begin());
      sized(layout, [&]<bool EVEN, int M>() { solve_stage<EVEN, M>(0); });
      each_number([&](BallBlock &k, int lane, int c, int number) { answers[number] = k.stage[0][c][lane]; });
      std::copy(e.stage[0].begin(), e.stage[0].end(), answers + count * COLUMNS);
    }
  }

 private:
  const Chunk &chunk;
  const Bearing &bearing;
  const RosenbrockMethod &method;
  const CoupledBodies &bodies;
  Layout layout;
  const Results &out;
  const BodyResults &body_out;
  const std::int64_t *numbers = nullptr;
  int count = 0, cursor = 0, evaluations = 0;
  std::vector<BallBlock> blocks;
  BodyStep e;
  double time = 0.0, step = 0.0, gain = 0.0, error = 0.0, over_scale[MOTION];
  TouchingBalls touching;
  double land_closing = 0.0;  // m/s^2: how fast the cage's centre comes to move towards its land
  bool alone = false;  // no ring and no cage couples the balls
  // True if the bodies' forces change with time by themselves; true if a ball meets a defect in this step.
  bool varies, meets_defects = false;
  bool again = false;  // the step before was rejected, and rates and Jacobian at its start still hold

  void begin(const std::int64_t *balls, int size) {
    numbers = balls, count = size;
    blocks.assign((count + LANES - 1) / LANES, BallBlock{});
    step = chunk.duration;
    for (int place = 0; place < int(blocks.size()) * LANES; place++) {
      BallBlock &k = blocks[place / LANES];
      int lane = place % LANES, ball = int(numbers[std::min(place, count - 1)]);
      for (int c = 0; c < COLUMNS; c++) k.start[c][lane] = out.state[ball * COLUMNS + c];
      for (int c = 0; c < 4; c++) k.before[c][lane] = out.orientation[ball * 4 + c];
      k.start[ORBIT_RATE][lane] /= k.start[RADIUS][lane];
      load_carried(out.carried + ball * CARRIED, lane, k.carried);
      k.live[lane] = k.apart[lane] = place < count ? -1 : 0;
      k.pocket[lane] = 2.0 * M_PI * ball / out.balls;
      step = std::min(step, out.step[ball]);
    }
    std::copy(body_out.state, body_out.state + BODY_NUMBERS, e.start.begin());
    for (BallBlock &k : blocks) follow_cage(k.start, e.start, k);
    for (int k = 0; k < layout.unknowns; k++) e.over_inertia[k] = 1.0 / bodies.inertia[layout.coordinate[k]];
  }

  // Balls of an even cage go round with it.
  void follow_cage(BallState &y, const BodyState &body, const BallBlock &k) const {
    if (!layout.even) return;
    y[ANGLE] = body[CAGE_ANGLE] + k.pocket, y[ORBIT_RATE] = broadcast<Pack>(body[COORDINATES + CAGE_ANGLE]);
  }

  void prescribe_shaft(BodyState &y, double instant) const {
    if (bodies.torque_driven()) return;
    y[SHAFT] = bodies.shaft_angle + instant * (bodies.shaft_speed + 0.5 * bodies.shaft_acceleration * instant);
    y[COORDINATES + SHAFT] = bodies.shaft_speed + bodies.shaft_acceleration * instant;
  }

  // Rates `f` of all at their states `y`, at an instant [s] of the chunk; those of an even cage by its inertia with its balls there.
  template <bool DERIVATIVES>
  void evaluate(double instant) {
    Pushes push{};
    Pack carried{};
    prescribe_shaft(e.y, instant);
    for (BallBlock &k : blocks) {
      if (k.meets_defects) k.heights = heights_at(bearing.defects, k.places, broadcast<Pack>(instant - time));
      follow_cage(k.y, e.y, k);
      if (DERIVATIVES && touching.active()) std::fill(&k.tile[0][0], &k.tile[0][0] + TILE_ROWS * TILE_COLUMNS, Pack{});
      if (bearing.over_patch()) forces_of_block<true, DERIVATIVES>(bearing, bodies, layout, k, e.y, push);
      else forces_of_block<false, DERIVATIVES>(bearing, bodies, layout, k, e.y, push);
    }
    if (touching.active()) touching.add<DERIVATIVES>(bearing, blocks);
    for (BallBlock &k : blocks) finish_rates<DERIVATIVES>(bearing, layout, k, push, carried);
    double over_inertia[MOST_FREE];
    std::copy(e.over_inertia, e.over_inertia + MOST_FREE, over_inertia);
    if (layout.even) over_inertia[layout.slot[CAGE_ANGLE]] = 1.0 / (bodies.inertia[CAGE_ANGLE] + total(carried));
    body_rates<DERIVATIVES>(bodies, layout, instant, over_inertia, e, push);
    if (DERIVATIVES) std::copy(over_inertia, over_inertia + MOST_FREE, e.over_inertia);
  }

  // Where balls stand on surfaces with defects, and whether they meet any within this time.
  void find_places(double ahead) {
    if (!bearing.defects.count) return;
    meets_defects = false;
    BodyState now = e.start;
    prescribe_shaft(now, time);
    for (std::size_t block = 0; block < blocks.size(); block++) {
      BallBlock &k = blocks[block];
      Mask first{};
      for (int lane = 0; lane < LANES; lane++)
        if (int place = int(block) * LANES + lane; place < count && numbers[place] == 0) first[lane] = -1;
      k.places = surface_places(k.start[ANGLE], k.start[ORBIT_RATE], broadcast<Pack>(now[SHAFT]),
                                broadcast<Pack>(now[COORDINATES + SHAFT]), k.before, spin_in_frame(k.start), first);
      k.meets_defects = false, k.heights = {};
      for (int lane = 0; lane < LANES; lane++) k.meets_defects |= meets(bearing.defects, k.places, lane, ahead);
      meets_defects |= k.meets_defects;
    }
  }
  // Approaches of the ball in a lane at the place `y`, this share of the step after its start.
  template <class Y>
  Approaches approaches(const BallBlock &k, int lane, const Y &y, double share) const {
    Approaches found{inner_approach(y), outer_approach(y)};
    if (!k.meets_defects) return found;
    Heights more = heights_at(bearing.defects, k.places, broadcast<Pack>(share * step));
    return {found[0] + more.inner.value[lane], found[1] + more.outer.value[lane]};
  }

  void linearise() {
    for (BallBlock &k : blocks) k.y = k.start;
    e.y = e.start;
    evaluate<true>(time);
    for (BallBlock &k : blocks) k.first = k.f;
    e.first = e.f;
    if (!layout.even) return;
    double acceleration = e.first[COORDINATES + CAGE_ANGLE];  // the inertia of an even cage grows with its balls' radii
    for (BallBlock &k : blocks)
      k.tile[layout.row[ORBIT_ROW]][OWN_PLACES] -= masked(k.live, 2.0 * bearing.ball_mass * acceleration * k.start[RADIUS]);
  }

  // Rates a little later, for their change with time by itself.
  void evaluate_later() {
    for (BallBlock &k : blocks) k.y = k.start, k.carried.forget_films();
    e.y = e.start;
    evaluate<false>(time + TIME_DIFFERENCE * step);
    for (BallBlock &k : blocks) k.slope = k.f;
    e.slope = e.f;
  }
  void take_slope() {
    for (BallBlock &k : blocks)
      for (int c = 0; c < COLUMNS; c++) k.slope[c] = (k.slope[c] - k.first[c]) * (1.0 / TIME_DIFFERENCE);
    for (int c = 0; c < BODY_NUMBERS; c++) e.slope[c] = (e.slope[c] - e.first[c]) * (1.0 / TIME_DIFFERENCE);
  }

  // The state of stage I, and the weighted sum of those before it that its right-hand side takes.
  template <int I, class S>
  [[gnu::noinline]] static void mix(const double *a, const double *c, const S *stage, const S &start, S &y, S &before) {
    double to_state[I], to_right[I];
    for (int i = 0; i < I; i++) to_state[i] = a[i], to_right[i] = c[i];
    for (int n = 0; n < int(start.size()); n++) {
      auto state = start[n] + to_state[0] * stage[0][n];
      auto right = to_right[0] * stage[0][n];
      for (int i = 1; i < I; i++) state += to_state[i] * stage[i][n], right += to_right[i] * stage[i][n];
      y[n] = state, before[n] = right;
    }
  }

  void factorise_system(double its_gain) {
    gain = its_gain;
    if (touching.active()) touching.choose_members(blocks);
    factorise(layout, blocks, e, gain);
    if (touching.meets()) touching.factorise(layout, blocks, e, gain);
  }

  void make_step() {
    bool later = varies || meets_defects;
    if (later) evaluate_later();
    if (!again) linearise();
    if (later) take_slope();
    factorise_system(method.gamma * step);
    make_stage<0>(), make_stage<1>(), make_stage<2>(), make_stage<3>();
    if (method.stages > 4) make_stage<4>(), make_stage<5>();
    end_step();
  }

  template <int I>
  void make_stage() {
    double over_step = 1.0 / step;
    if constexpr (I == 0) {
      for (BallBlock &k : blocks) k.right = k.f = k.first, k.y = k.start;
      e.right = e.f = e.first, e.y = e.start;
    } else {
      for (BallBlock &k : blocks) mix<I>(method.a[I], method.c[I], k.stage, k.start, k.y, k.right);
      mix<I>(method.a[I], method.c[I], e.stage, e.start, e.y, e.right);
      if (!method.repeats_first(I)) evaluate<false>(time + method.alpha[I] * step);
      for (BallBlock &k : blocks)
        for (int c = 0; c < COLUMNS; c++) k.right[c] = k.f[c] + over_step * k.right[c];
      for (int c = 0; c < BODY_NUMBERS; c++) e.right[c] = e.f[c] + over_step * e.right[c];
    }
    if (varies || meets_defects) {
      for (BallBlock &k : blocks)
        for (int c = 0; c < COLUMNS; c++) k.right[c] += method.d[I] * k.slope[c];
      for (int c = 0; c < BODY_NUMBERS; c++) e.right[c] += method.d[I] * e.slope[c];
    }
    sized(layout, [&]<bool EVEN, int M>() { solve_stage<EVEN, M>(I); });
  }

  // Solves for a stage; M is the room for unknowns of the bodies, filled up with zeros.
  template <bool EVEN, int M>
  [[gnu::noinline]] void solve_stage(int stage) {
    double known[M] = {}, places[M] = {}, speeds[M] = {}, right[M] = {};
    Pack share[M] = {};
    BodyState &x = e.stage[stage];
    for (int k = 0; k < layout.unknowns; k++) known[k] = gain * e.right[layout.coordinate[k]];
    for (BallBlock &k : blocks) eliminate_block<EVEN, M>(k, gain, known, share);
    for (int i = 0; i < layout.unknowns; i++) {
      right[i] = e.right[COORDINATES + layout.coordinate[i]] + e.over_inertia[i] * total(share[i]);
      for (int j = 0; j < M; j++) right[i] += e.answer_to_place[i][j] * known[j];
    }
    if (touching.meets()) touching.solve(layout, blocks, gain, right);
    for (int i = 0; i < layout.unknowns; i++) {
      if (touching.meets()) speeds[i] = right[i];
      else
        for (int j = 0; j < M; j++) speeds[i] += e.inverse[i][j] * right[j];
      places[i] = known[i] + gain * speeds[i];
      x[layout.coordinate[i]] = places[i], x[COORDINATES + layout.coordinate[i]] = speeds[i];
    }
    for (int n = 0; n < INTEGRALS; n++) {
      double sum = e.right[2 * COORDINATES + n];
      for (int j = 0; j < M; j++) sum += e.by_place[MOST_FREE + n][j] * places[j] + e.by_speed[MOST_FREE + n][j] * speeds[j];
      x[2 * COORDINATES + n] = gain * sum;
    }
    double cage[2] = {x[CAGE_ANGLE], x[COORDINATES + CAGE_ANGLE]};
    for (BallBlock &k : blocks) follow_block<EVEN, M>(k, gain, places, speeds, cage, k.stage[stage]);
    if (touching.meets()) touching.add_losses(blocks, gain, stage);
  }

  // States at the end, orientations there, and the error: the greatest of the balls' and the bodies' root mean squares.
  void end_step() {
    int last = method.stages - 1, judged = 0;
    double squares = 0.0;
    for (int c = 0; c < BODY_NUMBERS; c++) e.end[c] = e.y[c] + e.stage[last][c];
    for (int k = 0; k < layout.unknowns; k++) {
      int c = layout.coordinate[k];
      for (auto [scale, change] : {std::pair{bodies.place_scale[c], e.stage[last][c]}, {bodies.speed_scale[c], e.stage[last][COORDINATES + c]}}) {
        if (scale == 0.0) continue;
        squares += change / scale * (change / scale), judged++;
      }
    }
    error = std::sqrt(squares / std::max(judged, 1));
    for (BallBlock &k : blocks) {
      const BallState &s = k.stage[last];
      for (int c = 0; c < COLUMNS; c++) k.end[c] = k.y[c] + s[c];
      follow_cage(k.end, e.end, k);
      Pack weight = broadcast<Pack>(1.0), sum{};
      if (bodies.cage == CageKind::pockets)
        weight = walls::weight_of_light(outer_approaches(k.start, e.start), outer_approaches(k.end, e.end), bodies.light);
      for (int c = 0; c < MOTION; c++) {
        Pack scaled = (c == ORBIT_RATE ? k.start[RADIUS] * s[c] + k.start[ORBIT_RATE] * s[RADIUS] : s[c]) * over_scale[c];
        if (c == ANGLE || c > VELOCITY) scaled *= weight;
        sum += scaled * scaled;
      }
      sum = maximum(absolute(s[DISSIPATED]) * (1.0 / chunk.scale[MOTION]), square_root(sum * (1.0 / MOTION)));
      for (int lane = 0; lane < LANES; lane++) {
        if (!k.live[lane]) continue;
        double own = alone && sum[lane] <= 1.0 ? std::max(double(sum[lane]), least_error(k, lane)) : double(sum[lane]);
        if (!(own <= error)) error = own;
      }
      for (int c : {ORBIT_RATE, int(SPIN), SPIN + 1, SPIN + 2}) k.prepare_interpolant(method, c);
      auto middle = [&](int c) { return k.inside(0.5, c); };
      k.after = rotated(k.before, spin_in_frame(k.start), {middle(SPIN), middle(SPIN + 1), middle(SPIN + 2) - middle(ORBIT_RATE)},
                        spin_in_frame(k.end), broadcast<Pack>(step));
    }
  }
  static Triple spin_in_frame(const BallState &y) { return {y[SPIN], y[SPIN + 1], y[SPIN + 2] - y[ORBIT_RATE]}; }

  void give_out(double until) {
    bool prepared = false;
    for (; cursor < chunk.instants && chunk.instant[cursor] <= until; cursor++) {
      if (!prepared) {
        for (BallBlock &k : blocks)
          for (int c = 0; c < COLUMNS; c++) k.prepare_interpolant(method, c);
        for (int c = 0; c < BODY_NUMBERS; c++) e.prepare_interpolant(method, c);
        prepared = true;
      }
      double share = (chunk.instant[cursor] - time) / step;
      for (int c = 0; c < BODY_NUMBERS; c++) body_out.states[cursor * BODY_NUMBERS + c] = e.inside(share, c);
      for (int n = 0; n < int(blocks.size()); n++) {
        const BallBlock &k = blocks[n];
        BallState there;
        for (int c = 0; c < COLUMNS; c++) there[c] = k.inside(share, c);
        auto middle = [&](int c) { return k.inside(0.5 * share, c); };
        Quaternion turned = rotated(k.before, spin_in_frame(k.start), {middle(SPIN), middle(SPIN + 1), middle(SPIN + 2) - middle(ORBIT_RATE)},
                                    spin_in_frame(there), broadcast<Pack>(share * step));
        there[ORBIT_RATE] *= there[RADIUS];
        for (int lane = 0; lane < LANES && n * LANES + lane < count; lane++) {
          long row = long(cursor) * out.balls + numbers[n * LANES + lane];
          for (int c = 0; c < COLUMNS; c++) out.states[row * COLUMNS + c] = there[c][lane];
          for (int c = 0; c < 4; c++) out.orientations[row * 4 + c] = turned[c][lane];
        }
      }
    }
  }

  void move_on() {
    note_closing();
    time += step, again = false;
    e.start = e.end;
    for (BallBlock &k : blocks) {
      k.start = k.end, k.before = k.after;
      for (int lane = 0; lane < LANES && bearing.carried != CarriedLaw::none; lane++) {
        auto y = place_of(k.start, lane);
        carry_on(bearing, inner_place(y), outer_place(y, e.start), lane, k.carried);
      }
    }
    if (!touching.active()) return;
    BallBlock &tail = blocks.back();  // no contact holds what spare lanes repeat
    for (int lane = (count - 1) % LANES + 1; lane < LANES; lane++)
      for (int c = 0; c < COLUMNS; c++) tail.start[c][lane] = tail.start[c][(count - 1) % LANES];
  }

  Status finish(double next) {
    std::copy(e.start.begin(), e.start.end(), body_out.state);
    for (int place = 0; place < count; place++) {
      const BallBlock &k = blocks[place / LANES];
      int lane = place % LANES, ball = int(numbers[place]);
      double sum = 0.0, *y = out.state + ball * COLUMNS;
      out.step[ball] = next;
      for (int c = 0; c < COLUMNS; c++) y[c] = k.start[c][lane];
      y[VELOCITY + 1] *= y[RADIUS];
      for (int c = 0; c < COLUMNS; c++) sum += std::fabs(y[c]);
      for (int c = 0; c < 4; c++) out.orientation[ball * 4 + c] = k.before[c][lane];
      store_carried(k.carried, lane, out.carried + ball * CARRIED);
      if (!(sum < HUGE_VAL)) return failed(NOT_FINITE, chunk.duration, ball);
      double deepest = DEEPEST * bearing.ball_radius;
      if (inner_approach(y) > deepest || outer_approach(y) > deepest)
        return failed(TOO_DEEP, chunk.duration, ball);
    }
    return OK;
  }

  // Steps end where a ball meets a wall of its pocket or leaves it; the least step to go on with [s], 0 where uncut.
  double cut_at_walls() {
    if (bodies.cage != CageKind::pockets) return 0.0;
    double wanted = step, mass = walls::mass_between(bearing, bodies);
    double blur = chunk.scale[ORBIT_RATE] * bearing.ball_mass / bodies.pockets.wall.stiffness;
    walls::Cut cut{step, 0.0};
    for (int place = 0; place < count; place++) {
      const BallBlock &k = blocks[place / LANES];
      int lane = place % LANES;
      double y[MOTION];
      for (int c = 0; c < MOTION; c++) y[c] = k.start[c][lane];
      walls::Gap gap = walls::gap_of(bodies, y, k.pocket[lane], e.start);
      double until = walls::next_bend(bodies.pockets.wall, mass, blur, gap, gap.side * k.closing[lane]);
      if (until < cut.step) cut = {until, gap.approach < 0.0 ? std::min(wanted, walls::FIRST * ONSET / gap.rate) : wanted};
    }
    if (bodies.guided) cut = walls::cut_at_land(bodies, e.start, land_closing, wanted, cut);
    step = cut.step;
    return cut.resume;
  }

  // Keeps how fast balls come forward in their pockets, and the cage towards its land, at the end of an accepted step.
  void note_closing() {
    if (bodies.cage != CageKind::pockets) return;
    const double *growth = e.f.data() + COORDINATES;
    for (BallBlock &k : blocks) {
      k.closing = bodies.pockets.radius * (k.f[ORBIT_RATE] - growth[CAGE_ANGLE]);
      if (!bodies.guided) continue;
      auto [cosine, sine] = cosine_sine_value(k.end[ANGLE]);
      k.closing -= cosine * growth[CAGE_Y] - sine * growth[CAGE_X];
    }
    if (bodies.guided) land_closing = walls::land_closing(bodies, e.end, e.f);
  }

  // A ball's place in the axes of the inner ring, where that is at the step's start.
  template <class Y>
  RingPlace inner_place(const Y &y) const {
    if (bodies.ring == RingMotion::held) return core::inner_place(bearing, y[RADIUS], y[ANGLE], y[HEIGHT]);
    return core::inner_place(&e.start[RING_X], &e.start[TILT_X], y[RADIUS], y[ANGLE], y[HEIGHT]);
  }
  template <class Y>
  double inner_approach(const Y &y) const {
    auto [axis_distance, height] = inner_place(y);
    return approach_at(bearing, bearing.inner, axis_distance, height);
  }
  template <class Y>
  double outer_approach(const Y &y, const BodyState &body) const {
    auto [axis_distance, height] = outer_place(y, body);
    return approach_at(bearing, bearing.outer, axis_distance, height);
  }
  template <class Y>
  double outer_approach(const Y &y) const { return outer_approach(y, e.start); }
  // The same in the axes of the outer ring.
  template <class Y>
  RingPlace outer_place(const Y &y, const BodyState &body) const {
    if (bodies.ring != RingMotion::housed) return {y[RADIUS], y[HEIGHT]};
    double centre[3], level[2] = {};
    for (int i = 0; i < 3; i++) centre[i] = body[HOUSING] * bodies.direction[i];
    return core::inner_place(centre, level, y[RADIUS], y[ANGLE], y[HEIGHT]);
  }
  Pack outer_approaches(const BallState &y, const BodyState &body) const {
    if (bodies.ring != RingMotion::housed) return core::outer_approach(bearing, y);
    Pack found;
    for (int lane = 0; lane < LANES; lane++) found[lane] = outer_approach(place_of(y, lane), body);
    return found;
  }
  static std::array<double, 3> place_of(const BallState &y, int lane) { return {y[RADIUS][lane], y[ANGLE][lane], y[HEIGHT][lane]}; }

  bool any_flies() const {
    for (int place = 0; place < count; place++) {
      const BallBlock &k = blocks[place / LANES];
      auto [inner, outer] = approaches(k, place % LANES, place_of(k.start, place % LANES), 0.0);
      if (outer < 0.0 && inner < 0.0) return true;
    }
    return false;
  }

  double least_error(const BallBlock &k, int lane) const {
    return free_balls::least_error(chunk, step, approaches(k, lane, place_of(k.start, lane), 0.0), approaches(k, lane, place_of(k.end, lane), 1.0));
  }

  // The share of the step after which a contact of a ball with a raceway has just begun or ended; 1 where none does.
  double landing_share() {
    double least = 1.0;
    for (int place = 0; place < count; place++) {
      BallBlock &k = blocks[place / LANES];
      int lane = place % LANES;
      Approaches before = approaches(k, lane, place_of(k.start, lane), 0.0);
      if (!changes_contact(before, approaches(k, lane, place_of(k.end, lane), 1.0))) continue;
      for (int c = 0; c < VELOCITY; c++) k.prepare_interpolant(method, c);
      double share = share_of_change(before, [&](double fraction) {
        std::array<double, 3> there;
        for (int c = 0; c < 3; c++) there[c] = k.inside(fraction, c)[lane];
        return approaches(k, lane, there, fraction);
      });
      least = std::min(least, share);
    }
    return least;
  }

  Status failed(Status status, double when, std::int64_t ball) {
    out.failure[0] = when, out.failure[1] = double(ball);
    return status;
  }
};

}  // namespace coupled_balls

}  // namespace core

using namespace core;

CORE_EXPORT int core_coupled_balls(
    const double *bearing_numbers, const double *points, const double *method_numbers, const double *body_numbers,
    const double *load, const double *load_rate, const double *drive, const double *scales, double duration, std::int64_t instants, const double *times,
    const volatile std::uint8_t *stop, std::int64_t count, const std::int64_t *numbers,
    const std::uint8_t *near, std::int64_t balls, double *state,
    double *orientation, double *steps, double *carried, double *border, double *states, double *orientations, double *borders,
    std::int64_t *counts, double *failure) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  RosenbrockMethod method = method_of(method_numbers);
  CoupledBodies bodies = bodies_of(body_numbers, load, load_rate, drive);
  Chunk chunk{bearing, method, {bodies.shaft_speed, bodies.shaft_acceleration, bodies.shaft_angle}, duration, {}, int(instants), times, stop};
  std::copy(scales, scales + SCALES, chunk.scale);
  Results results{int(balls), state, orientation, steps, carried, states, orientations, counts, failure};
  BodyState body_state = state_of(bearing, bodies, border);
  std::vector<double> body_states(instants * BODY_NUMBERS);
  BodyResults body_results{body_state.data(), body_states.data()};
  Status status = coupled_balls::Integration(chunk, bodies, results, body_results).run(numbers, int(count), near);
  if (status != OK) return status;
  auto write = [&](const double *from, double *to) {
    for_each_number(bodies, true, [&](int number, int place) { to[place] = from[number]; });
  };
  write(body_state.data(), border);
  for (int i = 0; i < instants; i++) write(body_states.data() + i * BODY_NUMBERS, borders + i * BORDER);
  return status;
}

// For tests, of all balls, their tangential velocities in `state`, and the bodies: see `linear_answers`.
CORE_EXPORT void core_linear_answers(
    const double *bearing_numbers, const double *points, const double *method_numbers, const double *body_numbers,
    const double *load, const double *load_rate, const double *drive, std::int64_t balls, const std::uint8_t *near,
    double *state, const double *border, double gain, std::int64_t sides, const double *right, double *rates, double *answers) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  RosenbrockMethod method = method_of(method_numbers);
  CoupledBodies bodies = bodies_of(body_numbers, load, load_rate, drive);
  std::uint8_t stop = 0;
  Chunk chunk{bearing, method, {}, 1.0, {}, 0, nullptr, &stop};
  std::vector<double> orientations(4 * balls), steps(balls, 1.0), carried(CARRIED * balls, 0.0);
  std::vector<std::int64_t> numbers(balls);
  for (int ball = 0; ball < balls; ball++) numbers[ball] = ball;
  Results results{int(balls), state, orientations.data(), steps.data(), carried.data(), nullptr, nullptr, nullptr, nullptr};
  BodyState body_state = state_of(bearing, bodies, border);
  BodyResults body_results{body_state.data(), nullptr};
  coupled_balls::Integration(chunk, bodies, results, body_results)
      .linear_answers(numbers.data(), int(balls), near, gain, int(sides), right, rates, answers);
}
