// Rosenbrock methods of balls, ring, cage and shaft. Balls that something couples have steps in common with it; balls that nothing
// couples, between rings whose motion is prescribed, each have steps of their own: a lane whose ball has reached the end of the
// chunk takes the next one.
#include "chunk.hpp"
#include "numbers.hpp"

namespace core {

constexpr double LONGEST_FLIGHT = 5e-5;  // s, of a step that begins in flight: a bounce takes about as long
constexpr double LANDED = 0.95;  // share of a step: a contact that changes later in it is as good as at its end
// Of what a contact that begins or ends does to a ball's speed: a step's error is no less, as the estimate passes
// through zero by chance where the instant moves through the step.
constexpr double LANDING_SHARE = 0.1;

// Speed [m/s] that a contact which begins in a step gives a ball in it, or would take where one ends; 0 where none does.
inline double contact_change(const Bearing &bearing, const Raceway &raceway, double begin, double end, double step) {
  double lag = bearing.power * bearing.relaxation_time * std::min(end - begin, 0.0) / step;
  double before = begin + lag, after = end + lag;
  double lasts = step / std::max(std::fabs(end - begin), 1e-300);
  if (before <= 0.0 && after > 0.0) {
    double load = end > 0.0 ? raceway.given * std::pow(end, bearing.power) : 0.0;
    return load * (bearing.relaxation_time + end * lasts / (bearing.power + 1.0)) / bearing.ball_mass;
  }
  if (after <= 0.0 && before > 0.0) {
    double stiffness = bearing.power * raceway.given * std::pow(std::max(end - after, 0.0), bearing.power - 1.0);
    return 0.5 * stiffness / bearing.power * after * after * lasts / bearing.ball_mass;
  }
  return 0.0;
}

// The least error of a step [s] in which contacts of a ball begin or end: a share of what they do to its speed. A contact
// beside one that carries load throughout is soon forgotten.
inline double least_error(const Chunk &chunk, double step, const Approaches &first, const Approaches &last) {
  const Bearing &bearing = chunk.bearing;
  double lag = bearing.power * bearing.relaxation_time * std::min(last[1] - first[1], 0.0) / step;
  if (!(std::min(first[1], last[1]) + lag <= 0.0)) return 0.0;
  double change = std::max(contact_change(bearing, bearing.outer, first[1], last[1], step),
                           contact_change(bearing, bearing.inner, first[0], last[0], step));
  return LANDING_SHARE / (chunk.scale[VELOCITY] * std::sqrt(double(MOTION))) * change;
}

// A step: `cut_steps` shortens it, `make_step` linearises at its start and solves the stages (`solve_stage`), `end_step` finds the
// state at its end and the error. Then `judge` accepts or rejects it, `give_out` writes the outputs in it, `move_on` takes its end
// as the next start and `propose` sets the next step, lane by lane.
class RosenbrockBalls {
 public:
  RosenbrockBalls(const Chunk &chunk, const RosenbrockMethod &method)
      : chunk(chunk), bearing(chunk.bearing), method(method), bodies(chunk.bodies), layout(bodies), alone(layout.unknowns == 0) {
    for (int c = 0; c < MOTION; c++) over_scale[c] = 1.0 / chunk.scale[c];
    varies = !bodies.torque_driven() && chunk.drive.acceleration != 0.0;
    for (int k = 0; k < layout.unknowns; k++) varies |= bodies.load_rate[layout.coordinate[k]] != 0.0;
    varies |= bodies.unbalance != 0.0 && !bodies.torque_driven();
    for (int i = 0; i < method.stages; i++) evaluations += !method.repeats_first(i);
  }

  // Moves the numbered balls through the chunk: with steps in common with each other and the bodies, neighbours one after the
  // other, or each with steps of its own.
  Status run(const std::vector<int> &numbers, bool in_common) {
    begin(numbers, in_common);
    while (running > 0) {
      if (*chunk.stop != 0) return STOPPED;
      cut_steps();
      make_step();
      judge();
      give_out();
      move_on();
      for (BallBlock &k : blocks)
        for (int lane = 0; lane < LANES; lane++)
          if (k.ball[lane] >= 0)
            if (Status status = propose(k, lane); status != OK) return status;
    }
    std::copy(e.start.begin(), e.start.end(), chunk.body_state);
    return OK;
  }

  // For tests: the rates of balls and bodies (count COLUMNS + BODY_NUMBERS,), and the solutions x (sides, as the rates) of
  // x/gain - J x = right, an orbit rate in place of the tangential velocity.
  void linear_answers(const std::vector<int> &numbers, double its_gain, int sides, const double *right, double *rates, double *answers) {
    begin(numbers, true);
    int count = int(numbers.size());
    linearise();
    for (BallBlock &k : blocks) k.gain = broadcast<Pack>(its_gain);
    factorise_system();
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
  const Layout layout;
  const bool alone;  // no ring and no cage couples the balls
  bool common = false, varies;  // the second: forces change with time by themselves
  std::vector<int> numbers;
  std::vector<BallBlock> blocks;
  int waiting = 0, running = 0, evaluations = 0, cursor = 0;
  double over_scale[MOTION];
  BodyStep e;
  // Of steps in common: time, length, error of the bodies, the next one by the error, and the least to go on with after a cut.
  double time = 0.0, step = 0.0, error = 0.0, next = 0.0, resume = 0.0;
  TouchingBalls touching;
  double land_closing = 0.0;  // m/s^2: how fast the cage's centre comes to move towards its land
  bool meets_defects = false;  // a ball does in this step
  bool again = false;  // all steps before were rejected, and rates and Jacobian at their starts still hold

  void begin(const std::vector<int> &balls, bool in_common) {
    numbers = balls, common = in_common;
    touching.begin(chunk.near, chunk.balls, numbers);
    blocks.assign(common ? (numbers.size() + LANES - 1) / LANES : 1, BallBlock{});
    std::copy(chunk.body_state, chunk.body_state + BODY_NUMBERS, e.start.begin());
    for (BallBlock &k : blocks) {
      for (int lane = 0; lane < LANES; lane++) running += begin_ball(k, lane);
      follow_cage(k.start, e.start, k);
    }
    for (int k = 0; k < layout.unknowns; k++) e.over_inertia[k] = 1.0 / bodies.inertia[layout.coordinate[k]];
  }
  // Puts the next ball into a lane; a lane without a ball repeats the last one's start.
  bool begin_ball(BallBlock &k, int lane) {
    bool idle = waiting >= int(numbers.size());
    int ball = numbers[std::min(waiting, int(numbers.size()) - 1)];
    chunk.load(ball, k, lane);
    k.ball[lane] = idle ? -1 : ball, k.cursor[lane] = 0;
    k.live[lane] = k.apart[lane] = idle ? 0 : -1;
    k.pocket[lane] = 2.0 * M_PI * ball / chunk.balls;
    k.time[lane] = 0.0, k.step[lane] = std::min(chunk.step[ball], chunk.duration);
    waiting += !idle;
    return !idle;
  }

  // Balls of an even cage go round with it.
  void follow_cage(BallState &y, const BodyState &body, const BallBlock &k) const {
    if (!layout.even) return;
    y[ANGLE] = body[CAGE_ANGLE] + k.pocket, y[ORBIT_RATE] = broadcast<Pack>(body[COORDINATES + CAGE_ANGLE]);
  }

  void prescribe_shaft(BodyState &y, double instant) const {
    if (bodies.torque_driven()) return;
    y[SHAFT] = chunk.drive.angle_at(instant), y[COORDINATES + SHAFT] = chunk.drive.speed_at(instant);
  }

  // Steps end where the chunk ends, where balls meet defects and walls, and soon after they begin in flight: a step that begins
  // and ends there may pass over a bounce that none of its stages sees.
  void cut_steps() {
    find_places();
    double least = HUGE_VAL;
    for (BallBlock &k : blocks) {
      Pack outer{};
      if (alone) outer = outer_approach(bearing, k.start) + k.heights.outer.value;
      for (int lane = 0; lane < LANES; lane++) {
        double &wanted = k.wanted[lane];
        wanted = k.step[lane];
        if (alone && wanted > LONGEST_FLIGHT && outer[lane] < 0.0 && approaches(k, k.start, lane, 0.0)[0] < 0.0) wanted = LONGEST_FLIGHT;
        if (bearing.defects.count) wanted = std::min(wanted, resolving_step(bearing.defects, k.places, lane));
        if (k.live[lane]) least = std::min(least, wanted);
      }
    }
    for (BallBlock &k : blocks)
      for (int lane = 0; lane < LANES; lane++) {
        if (common) k.wanted[lane] = least;
        double left = chunk.duration - k.time[lane];
        k.step[lane] = k.wanted[lane] >= left - NEGLIGIBLE * chunk.duration ? left : k.wanted[lane];
      }
    time = blocks[0].time[0], step = blocks[0].step[0], resume = 0.0;
    if (bodies.cage != CageKind::pockets) return;
    cut_at_walls();
    for (BallBlock &k : blocks) k.step = broadcast<Pack>(step);
  }

  // Where balls stand on surfaces with defects, and whether they meet any.
  void find_places() {
    if (!bearing.defects.count) return;
    meets_defects = false;
    for (BallBlock &k : blocks) {
      Pack turned, speed;
      Mask first;
      for (int lane = 0; lane < LANES; lane++) {
        turned[lane] = bodies.torque_driven() ? e.start[SHAFT] : chunk.drive.angle_at(k.time[lane]);
        speed[lane] = bodies.torque_driven() ? e.start[COORDINATES + SHAFT] : chunk.drive.speed_at(k.time[lane]);
        first[lane] = k.ball[lane] == 0 ? -1 : 0;
      }
      k.places = surface_places(k.start[ANGLE], k.start[ORBIT_RATE], turned, speed, k.before, spin_in_frame(k.start), first);
      k.meets_defects = false;
      for (int lane = 0; lane < LANES; lane++) k.meets_defects |= meets(bearing.defects, k.places, lane, k.step[lane]);
      k.heights = k.meets_defects ? heights_at(bearing.defects, k.places, Pack{}) : Heights{};
      meets_defects |= k.meets_defects;
    }
  }

  // Rates `f` of all at their states `y`, this share of the step after its start; those of an even cage by its inertia with its
  // balls there.
  template <bool DERIVATIVES>
  void evaluate(double share) {
    Pushes push{};
    Pack carried{};
    double instant = time + share * step;
    prescribe_shaft(e.y, instant);
    for (BallBlock &k : blocks) {
      if (k.meets_defects) k.heights = heights_at(bearing.defects, k.places, share * k.step);
      if (DERIVATIVES && touching.active()) std::fill(&k.tile[0][0], &k.tile[0][0] + TILE_ROWS * TILE_COLUMNS, Pack{});
      follow_cage(k.y, e.y, k);
      if (alone) prescribed_forces<DERIVATIVES>(bearing, chunk.drive.speed_at(k.time + share * k.step), k);
      else if (bearing.over_patch()) forces_of_block<true, DERIVATIVES>(bearing, bodies, layout, k, e.y, push);
      else forces_of_block<false, DERIVATIVES>(bearing, bodies, layout, k, e.y, push);
    }
    if (touching.active()) touching.add<DERIVATIVES>(bearing, blocks);
    for (BallBlock &k : blocks) finish_rates<DERIVATIVES>(bearing, layout, k, push, carried);
    if (alone) return;
    double over_inertia[MOST_FREE];
    std::copy(e.over_inertia, e.over_inertia + MOST_FREE, over_inertia);
    if (layout.even) over_inertia[layout.slot[CAGE_ANGLE]] = 1.0 / (bodies.inertia[CAGE_ANGLE] + total(carried));
    body_rates<DERIVATIVES>(bodies, layout, instant, over_inertia, e, push);
    if (DERIVATIVES) std::copy(over_inertia, over_inertia + MOST_FREE, e.over_inertia);
  }

  void linearise() {
    for (BallBlock &k : blocks) k.y = k.start;
    e.y = e.start;
    evaluate<true>(0.0);
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
    evaluate<false>(TIME_DIFFERENCE);
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

  void factorise_system() {
    double gain = blocks[0].gain[0];
    if (touching.active()) touching.choose_members(blocks);
    factorise(layout, blocks, e, gain);
    if (touching.meets()) touching.factorise(layout, blocks, e, gain);
  }

  void make_step() {
    bool later = varies || meets_defects;
    if (later) evaluate_later();
    if (!again) linearise();
    if (later) take_slope();
    for (BallBlock &k : blocks) k.gain = method.gamma * k.step, k.over_step = 1.0 / k.step;
    factorise_system();
    make_stage<0>(), make_stage<1>(), make_stage<2>(), make_stage<3>();
    if (method.stages > 4) make_stage<4>(), make_stage<5>();
    end_step();
  }

  template <int I>
  void make_stage() {
    if constexpr (I == 0) {
      for (BallBlock &k : blocks) k.right = k.f = k.first, k.y = k.start;
      if (!alone) e.right = e.f = e.first, e.y = e.start;
    } else {
      for (BallBlock &k : blocks) mix<I>(method.a[I], method.c[I], k.stage, k.start, k.y, k.right);
      if (!alone) mix<I>(method.a[I], method.c[I], e.stage, e.start, e.y, e.right);
      if (!method.repeats_first(I)) evaluate<false>(method.alpha[I]);
      for (BallBlock &k : blocks) add_rates(k.f, k.over_step, k.right);
      if (!alone) add_rates(e.f, 1.0 / step, e.right);
    }
    if (varies || meets_defects) {
      for (BallBlock &k : blocks) add_slope(method.d[I], k.slope, k.right);
      if (!alone) add_slope(method.d[I], e.slope, e.right);
    }
    sized(layout, [&]<bool EVEN, int M>() { solve_stage<EVEN, M>(I); });
  }
  template <class S, class T>
  static void add_rates(const S &rates, const T &over_step, S &right) {
    for (std::size_t n = 0; n < right.size(); n++) right[n] = rates[n] + over_step * right[n];
  }
  template <class S>
  static void add_slope(double weight, const S &slope, S &right) {
    for (std::size_t n = 0; n < right.size(); n++) right[n] += weight * slope[n];
  }

  // Solves for a stage; M is the room for unknowns of the bodies, filled up with zeros.
  template <bool EVEN, int M>
  [[gnu::noinline]] void solve_stage(int stage) {
    std::array<double, M> known{}, places{}, speeds{}, right{};
    std::array<Pack, M> share{};
    BodyState &x = e.stage[stage];
    double gain = blocks[0].gain[0];
    for (int k = 0; k < layout.unknowns; k++) known[k] = gain * e.right[layout.coordinate[k]];
    for (BallBlock &k : blocks) eliminate_block<EVEN, M>(k, known.data(), share.data());
    for (int i = 0; i < layout.unknowns; i++) {
      right[i] = e.right[COORDINATES + layout.coordinate[i]] + e.over_inertia[i] * total(share[i]);
      for (int j = 0; j < M; j++) right[i] += e.answer_to_place[i][j] * known[j];
    }
    if (touching.meets()) touching.solve(layout, blocks, gain, right.data());
    for (int i = 0; i < layout.unknowns; i++) {
      if (touching.meets()) speeds[i] = right[i];
      else
        for (int j = 0; j < M; j++) speeds[i] += e.inverse[i][j] * right[j];
      places[i] = known[i] + gain * speeds[i];
      x[layout.coordinate[i]] = places[i], x[COORDINATES + layout.coordinate[i]] = speeds[i];
    }
    for (int n = 0; n < INTEGRALS && M > 0; n++) {
      double sum = e.right[2 * COORDINATES + n];
      for (int j = 0; j < M; j++) sum += e.by_place[MOST_FREE + n][j] * places[j] + e.by_speed[MOST_FREE + n][j] * speeds[j];
      x[2 * COORDINATES + n] = gain * sum;
    }
    double cage[2] = {x[CAGE_ANGLE], x[COORDINATES + CAGE_ANGLE]};
    for (BallBlock &k : blocks) follow_block<EVEN, M>(k, places.data(), speeds.data(), cage, k.stage[stage]);
    if (touching.meets()) touching.add_losses(blocks, gain, stage);
  }

  // States at the end, orientations there, and the errors: root mean squares of the motion of each ball and of the bodies.
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
      Pack weight = broadcast<Pack>(1.0);
      if (bodies.cage == CageKind::pockets)
        weight = walls::weight_of_light(outer_approaches(k.start, e.start), outer_approaches(k.end, e.end), bodies.light);
      // A ball that leaves a raceway moves freely while its contact still loses what it stores.
      k.error = maximum(absolute(s[DISSIPATED]) * (1.0 / chunk.scale[MOTION]), square_root(squares_of(k.start, s, weight, over_scale) * (1.0 / MOTION)));
      if (alone) weigh_contact_changes(k);
      for (int c : {ORBIT_RATE, int(SPIN), SPIN + 1, SPIN + 2}) k.prepare_interpolant(method, c);
      k.after = rotated(k.before, spin_in_frame(k.start), spin_inside(k, broadcast<Pack>(0.5)), spin_in_frame(k.end), k.step);
    }
  }
  static Triple spin_inside(const BallBlock &k, const Pack &share) {
    return {k.inside(share, SPIN), k.inside(share, SPIN + 1), k.inside(share, SPIN + 2) - k.inside(share, ORBIT_RATE)};
  }
  void weigh_contact_changes(BallBlock &k) const {
    Heights late = k.meets_defects ? heights_at(bearing.defects, k.places, k.step) : Heights{};
    Pack first = outer_approach(bearing, k.start), last = outer_approach(bearing, k.end) + late.outer.value;
    if (k.meets_defects) first += heights_at(bearing.defects, k.places, Pack{}).outer.value;
    Pack least = minimum(first, last) + bearing.power * bearing.relaxation_time * minimum(last - first, 0.0) / k.step;
    for (int lane = 0; lane < LANES; lane++)
      if (least[lane] <= 0.0 && k.error[lane] <= 1.0)
        k.error[lane] = std::max(double(k.error[lane]), least_error(chunk, k.step[lane], approaches(k, k.start, lane, 0.0), approaches(k, k.end, lane, 1.0)));
  }

  // Finds which lanes accept their steps, and up to when each may give out: all or none where they step together.
  void judge() {
    double worst = error < HUGE_VAL ? error : HUGE_VAL, share = 1.0;
    for (BallBlock &k : blocks)
      for (int lane = 0; lane < LANES; lane++) {
        if (k.ball[lane] < 0) continue;
        chunk.counts[2] += evaluations - again, chunk.counts[3] += !again;
        worst = std::max(worst, k.error[lane] < HUGE_VAL ? double(k.error[lane]) : HUGE_VAL);
      }
    if (common) next = next_step(step, worst, method.order);
    for (BallBlock &k : blocks)
      for (int lane = 0; lane < LANES; lane++) {
        if (common) k.error[lane] = worst;
        k.share[lane] = k.ball[lane] >= 0 && k.error[lane] <= 1.0 && method.ends_steps_at_contacts ? landing_share(k, lane) : 1.0;
        share = std::min(share, k.share[lane]);
      }
    for (BallBlock &k : blocks)
      for (int lane = 0; lane < LANES; lane++) {
        if (common) k.share[lane] = share;
        double end = k.time[lane] + k.step[lane];
        bool accepted = k.error[lane] <= 1.0 && k.share[lane] >= LANDED && (common || k.ball[lane] >= 0);
        k.until[lane] = !accepted ? -HUGE_VAL : end >= chunk.duration * (1.0 - NEGLIGIBLE) ? HUGE_VAL : end;
      }
  }

  void give_out() {
    for (BallBlock &k : blocks)
      for (bool first = true;; first = false) {
        Pack share{};
        bool found = false, has[LANES];
        for (int lane = 0; lane < LANES; lane++) {
          has[lane] = k.ball[lane] >= 0 && k.cursor[lane] < chunk.instants && chunk.instant[k.cursor[lane]] <= k.until[lane];
          if (has[lane]) share[lane] = (chunk.instant[k.cursor[lane]] - k.time[lane]) / k.step[lane];
          found |= has[lane];
        }
        if (!found) break;
        if (first)
          for (int c = 0; c < COLUMNS; c++) k.prepare_interpolant(method, c);
        BallState there;
        for (int c = 0; c < COLUMNS; c++) there[c] = k.inside(share, c);
        Quaternion turned = rotated(k.before, spin_in_frame(k.start), spin_inside(k, 0.5 * share), spin_in_frame(there), share * k.step);
        for (int lane = 0; lane < LANES; lane++)
          if (has[lane]) chunk.store(k.cursor[lane]++, k.ball[lane], there, turned, lane);
      }
    if (alone) return;
    for (bool first = true; cursor < chunk.instants && chunk.instant[cursor] <= blocks[0].until[0]; cursor++, first = false)
      for (int c = 0; c < BODY_NUMBERS; c++) {
        if (first) e.prepare_interpolant(method, c);
        chunk.body_states[cursor * BODY_NUMBERS + c] = e.inside((chunk.instant[cursor] - time) / step, c);
      }
  }

  void move_on() {
    bool moves = false;
    for (const BallBlock &k : blocks)
      for (double one : k.until) moves |= one >= 0.0;
    again = !moves;
    if (again) return;
    if (bodies.cage == CageKind::pockets) note_closing();
    if (!alone) e.start = e.end;
    for (BallBlock &k : blocks) {
      Mask moved;
      for (int lane = 0; lane < LANES; lane++) {
        moved[lane] = k.until[lane] >= 0.0 ? -1 : 0;
        if (bearing.carried != CarriedLaw::none && moved[lane]) carry_on(bearing, places_of(in_lane(k.end, lane), e.start), lane, k.carried);
      }
      k.time = select(moved, k.time + k.step, k.time);
      for (int c = 0; c < COLUMNS; c++) k.start[c] = select(moved, k.end[c], k.start[c]);
      for (int c = 0; c < 4; c++) k.before[c] = select(moved, k.after[c], k.before[c]);
    }
    if (!touching.active()) return;
    BallBlock &tail = blocks.back();  // no contact holds what spare lanes repeat
    int last = (int(numbers.size()) - 1) % LANES;
    for (int lane = last + 1; lane < LANES; lane++)
      for (int c = 0; c < COLUMNS; c++) tail.start[c][lane] = tail.start[c][last];
  }

  // The next step of a lane; takes its ball out at the chunk's end and the next one in.
  Status propose(BallBlock &k, int lane) {
    int ball = k.ball[lane];
    double proposed = common ? next : next_step(k.step[lane], k.error[lane], method.order);
    if (k.until[lane] < 0.0) {
      chunk.counts[1] += 1;
      bool landed = k.error[lane] <= 1.0;
      k.step[lane] = landed ? k.step[lane] * k.share[lane] : proposed;
      return k.step[lane] < LEAST_STEP && !landed ? chunk.failed(STALLED, k.time[lane], ball) : OK;
    }
    chunk.counts[0] += 1;
    k.step[lane] = std::max(proposed, resume);
    if (k.until[lane] < HUGE_VAL) return OK;
    chunk.step[ball] = std::max(k.wanted[lane], double(k.step[lane]));  // a step cut short by the end counts only if it is longer
    chunk.store(-1, ball, k.start, k.before, lane);
    store_carried(k.carried, lane, chunk.carried + ball * CARRIED);
    auto y = in_lane(k.start, lane);
    if (Status status = check_ball(bearing, y, places_of(y, e.start)); status != OK) return chunk.failed(status, chunk.duration, ball);
    running -= !begin_ball(k, lane);
    return OK;
  }

  // Steps end where a ball meets a wall of its pocket or leaves it; the least step to go on with [s], 0 where uncut.
  void cut_at_walls() {
    double wanted = step, mass = walls::mass_between(bearing, bodies);
    double blur = chunk.scale[ORBIT_RATE] * bearing.ball_mass / bodies.pockets.wall.stiffness;
    walls::Cut cut{step, 0.0};
    for (const BallBlock &k : blocks) {
      PocketGap gap = in_cage(bearing, bodies, k.pocket, ElementInput<false>{k.start, e.start}, [](int, const auto &) {});
      for (int lane = 0; lane < LANES; lane++) {
        if (k.ball[lane] < 0) continue;
        double approach = gap.approach[lane], rate = gap.rate[lane];
        double until = walls::next_bend(bodies.pockets.wall, mass, blur, approach, rate, gap.side[lane] * k.closing[lane]);
        if (until < cut.step) cut = {until, approach < 0.0 ? std::min(wanted, walls::FIRST * ONSET / rate) : wanted};
      }
    }
    if (bodies.guided) cut = walls::cut_at_land(bodies, e.start, land_closing, wanted, cut);
    step = cut.step, resume = cut.resume;
  }

  // Keeps how fast balls come forward in their pockets, and the cage towards its land, at the end of an accepted step.
  void note_closing() {
    const double *growth = e.f.data() + COORDINATES;
    for (BallBlock &k : blocks) {
      k.closing = bodies.pockets.radius * (k.f[ORBIT_RATE] - growth[CAGE_ANGLE]);
      if (!bodies.guided) continue;
      auto [cosine, sine] = cosine_sine_value(k.end[ANGLE]);
      k.closing -= cosine * growth[CAGE_Y] - sine * growth[CAGE_X];
    }
    if (bodies.guided) land_closing = walls::land_closing(bodies, e.end, e.f);
  }

  // Where a ball is in the axes of both rings.
  template <class Y>
  RingPlaces places_of(const Y &y, const BodyState &body) const {
    if (bodies.ring == RingMotion::held) return prescribed_places(bearing, y);
    RingPlaces found{place_in_ring(&body[RING_X], &body[TILT_X], y), RingPlace{y[RADIUS], y[HEIGHT]}};
    if (bodies.ring == RingMotion::housed) {
      double centre[3], level[2] = {};
      for (int i = 0; i < 3; i++) centre[i] = body[HOUSING] * bodies.direction[i];
      found[1] = place_in_ring(centre, level, y);
    }
    return found;
  }
  Pack outer_approaches(const BallState &y, const BodyState &body) const {
    if (bodies.ring != RingMotion::housed) return outer_approach(bearing, y);
    Pack found;
    for (int lane = 0; lane < LANES; lane++) found[lane] = approaches_of(bearing, places_of(in_lane(y, lane), body))[1];
    return found;
  }
  // Approaches of a ball at the place `y`, this share of the step after its start.
  template <class Y>
  Approaches approaches_at(const BallBlock &k, int lane, const Y &y, double share) const {
    Approaches found = approaches_of(bearing, places_of(y, e.start));
    if (!k.meets_defects) return found;
    Heights more = heights_at(bearing.defects, k.places, share * k.step);
    return {found[0] + more.inner.value[lane], found[1] + more.outer.value[lane]};
  }
  Approaches approaches(const BallBlock &k, const BallState &y, int lane, double share) const { return approaches_at(k, lane, in_lane(y, lane), share); }

  // The share of the step after which a contact of the ball in a lane with a raceway has just begun or ended; 1 where none does.
  double landing_share(BallBlock &k, int lane) {
    Approaches before = approaches(k, k.start, lane, 0.0);
    if (!changes_contact(before, approaches(k, k.end, lane, 1.0))) return 1.0;
    for (int c = 0; c < VELOCITY; c++) k.prepare_interpolant(method, c);
    return share_of_change(before, [&](double share) {
      std::array<double, 3> there;
      for (int c = 0; c < 3; c++) there[c] = k.inside(share, c)[lane];
      return approaches_at(k, lane, there, share);
    });
  }
};

// Cuts the ring of balls into rows of neighbours that may touch.
inline std::vector<std::vector<int>> groups_of(const Chunk &chunk) {
  auto touches_before = [&](int k) { return chunk.near[(k + chunk.balls - 1) % chunk.balls] != 0; };
  int first = 0;
  while (first < chunk.balls && touches_before(first)) first++;
  std::vector<std::vector<int>> groups{{first % chunk.balls}};
  for (int k = first + 1; k < first + chunk.balls; k++) {
    if (!touches_before(k % chunk.balls)) groups.emplace_back();
    groups.back().push_back(k % chunk.balls);
  }
  return groups;
}

Status by_rosenbrock(const Chunk &chunk, const RosenbrockMethod &method) {
  std::vector<std::vector<int>> together;
  std::vector<int> apart;
  if (Layout(chunk.bodies).unknowns > 0) {
    together.emplace_back();
    for (int ball = 0; ball < chunk.balls; ball++) together[0].push_back(ball);
  } else
    for (const std::vector<int> &group : groups_of(chunk))
      if (group.size() > 1) together.push_back(group);
      else apart.push_back(group[0]);
  Status status = apart.empty() ? OK : RosenbrockBalls(chunk, method).run(apart, false);
  for (const std::vector<int> &group : together)
    if (status == OK) status = RosenbrockBalls(chunk, method).run(group, true);
  return status;
}

}  // namespace core

using namespace core;

// For tests, of all balls, their tangential velocities in `state`, and the bodies: see `linear_answers`.
CORE_EXPORT void core_linear_answers(
    const double *bearing_numbers, const double *points, const double *body_numbers, const double *load, const double *load_rate,
    const double *drive, std::int64_t balls, const std::uint8_t *near, double *state, const double *border, double gain, std::int64_t sides, const double *right, double *rates, double *answers) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  CoupledBodies bodies = bodies_of(body_numbers, load, load_rate);
  RosenbrockMethod method{};
  BodyState body_state = state_of(bearing, bodies, border);
  double scale[SCALES] = {};
  std::vector<double> orientations(4 * balls), steps(balls, 1.0), carried(CARRIED * balls);
  std::vector<int> numbers(balls);
  for (int ball = 0; ball < balls; ball++) numbers[ball] = ball;
  Chunk chunk{bearing, bodies, drive_of(drive), 1.0, scale, 0, nullptr, nullptr, int(balls), near, state, orientations.data(), steps.data(), carried.data(),
              body_state.data(), nullptr, nullptr, nullptr, nullptr, nullptr};
  RosenbrockBalls(chunk, method).linear_answers(numbers, gain, int(sides), right, rates, answers);
}
