// The motion of a shaft on two bearings, and its exported functions; arrays are C-contiguous doubles, structs in the order of
// their members.
#include "../bearing/equilibrium.hpp"
#include "../methods/rosenbrock.hpp"
#include "../bearing/numbers.hpp"

namespace core::shaft {

// A rigid shaft on two bearings whose balls are in equilibrium at every instant: its equations of motion.
//
//     m x'' = F,   I_t theta_x'' + I_p w theta_y' = M_x,   I_t theta_y'' - I_p w theta_x' = M_y
//
// x (3,) is the centre of mass, theta_x and theta_y are tilts of first order, w is the speed about the axis, which is
// prescribed. Places of the bearings' rings and their loads: see `equilibria::System`. A viscous contact makes a bearing's
// load that of where the ring would be a relaxation time T later: K (q + T q').
//
// A run that begins with the linear response to the unbalances is counted from that whirl, Re(u exp(i angle)): a state has
// place and rate beside it, so that a step is wrong by a share of the rest alone. Where steps are long against the periods of
// modes, rates would else err by some per cent, and works by more than there is.
//
// The balls orbit as prescribed, so that their cages do work. A bearing with its balls turned with the ring is the same as
// before, so that its energy changes with the balls' azimuth by y F_x - x F_y + theta_y M_x - theta_x M_y.

using equilibria::COORDINATES;
using equilibria::Five;
using equilibria::Seat;

// A state: coordinates and their rates beside the whirl, and works since the start [J]: of loads and unbalances on the
// shaft, of the shaft on its bearings without what they dissipate, that, and of both cages; of the first two without those
// of steady loads, which follow from the place.
enum StateIndex { RATE = COORDINATES, LOAD_WORK = 2 * COORDINATES, BEARING_WORK, DISSIPATED, CAGE_WORK, STATE };
constexpr int MOVING = LOAD_WORK, BEARINGS = 2;

using Method = DenseRosenbrock<STATE, MOVING>;
using State = Method::State;
template <class X>
using Coordinates = std::array<X, COORDINATES>;

// The shaft about its own axis.
struct Turn {
  double angle, speed, acceleration, cosine, sine;
  Turn(double angle, double speed, double acceleration)
      : angle(angle), speed(speed), acceleration(acceleration), cosine(std::cos(angle)), sine(std::sin(angle)) {}
};

// A vector that turns with the shaft: the real part of z exp(i angle).
struct Turning {
  Five real, imaginary;
  double along(int i, const Turn &turn) const { return real[i] * turn.cosine - imaginary[i] * turn.sine; }
  double across(int i, const Turn &turn) const { return real[i] * turn.sine + imaginary[i] * turn.cosine; }
  double rate(int i, const Turn &turn) const { return -turn.speed * across(i, turn); }
  double acceleration(int i, const Turn &turn) const {
    return -turn.speed * turn.speed * along(i, turn) - turn.acceleration * across(i, turn);
  }
};

// Doubles alone, in the order in which Python writes them (`Rotor.numbers`). `steady` are the loads when the run starts;
// unbalances load the shaft as so much mass whose acceleration they resist. Of each bearing the azimuth of ball 0 at the
// start and its orbit's speed over the shaft's. Limits of contacts: the approaches of a ball's two over its diameter, the
// contact angle [rad], and the share of the greatest load below which an angle does not count.
struct Rotor {
  double mass, transverse, polar, relaxation_time;
  Five weight, steady;
  Turning whirl, unbalance;
  double first[BEARINGS], ratio[BEARINGS];
  double squeeze_limit, angle_limit, idle;

  double inertia(int i) const { return i < 3 ? mass : transverse; }
};

// A part of the course since `begin` [s]: the shaft had turned by `angle` and turns with even acceleration. From outside acts
// `load` [N, N m] about the centre of mass, which grows by `growth` a second.
struct CoursePart {
  double begin, angle, speed, acceleration;
  Five load, growth;

  Turn turn_at(double time) const {
    const double passed = time - begin;
    return {angle + (speed + 0.5 * acceleration * passed) * passed, speed + acceleration * passed, acceleration};
  }
  // Loads on the shaft but its weight: those from outside, and of the unbalances.
  Five load_at(double time, const Turn &turn, const Rotor &rotor) const {
    Five found;
    for (int i = 0; i < COORDINATES; i++)
      found[i] = load[i] + (time - begin) * growth[i] - rotor.unbalance.acceleration(i, turn);
    return found;
  }
};

// Both bearings with balls that orbit in their cages as the shaft turns.
class Bearings {
 public:
  equilibria::System system;

  Bearings(const Rotor &rotor, const Seat *seat_numbers, const std::int64_t *balls)
      : rotor(rotor), azimuth(balls[0] + balls[1]) {
    std::copy(seat_numbers, seat_numbers + BEARINGS, seats);
    system.set(seats, BEARINGS, balls);
  }
  Bearings(const Bearings &) = delete;

  // The loads that hold the shaft at `q` against its bearings.
  void load(const Turn &turn, const Five &q) {
    double *next = azimuth.data();
    for (int b = 0; b < BEARINGS; b++) {
      seats[b].speed = turn.speed;
      const double first = first_azimuth(b, turn);
      const int count = system.rings[b].count;
      for (int k = 0; k < count; k++) *next++ = first + 2.0 * M_PI * k / count;
    }
    system.place(azimuth.data());
    system.loads_at(system.q = q);
  }
  double first_azimuth(int bearing, const Turn &turn) const { return rotor.first[bearing] + rotor.ratio[bearing] * turn.angle; }

 private:
  const Rotor &rotor;
  Seat seats[BEARINGS];
  std::vector<double> azimuth;
};

// A function of coordinates with this value and these derivatives by them.
template <class X>
X linearised(double value, const Five &by, const Coordinates<X> &at) {
  if constexpr (!IsDual<X>) return value;
  else {
    X found{value, {}};
    for (int j = 0; j < COORDINATES; j++)
      for (int c = 0; c < MOVING; c++) found.slope[c] += by[j] * at[j].slope[c];
    return found;
  }
}

// The rates of a state on one part of the course, for `Method`.
class Equations {
 public:
  const CoursePart *part = nullptr;

  Equations(const Rotor &rotor, Bearings &bearings) : rotor(rotor), bearings(bearings) {}

  void rates(double time, const State &state, State &slopes) { evaluate(time, state.data(), slopes); }

  // Exact but for what the stiffness itself changes of what is dissipated.
  void rates_and_jacobian(double time, const State &state, State &slopes, Method::Jacobian &jacobian) {
    std::array<Variable, MOVING> moving;
    for (int n = 0; n < MOVING; n++) moving[n] = {state[n], {}}, moving[n].slope[n] = 1.0;
    std::array<Variable, STATE> found;
    evaluate(time, moving.data(), found);
    for (int n = 0; n < STATE; n++) {
      slopes[n] = found[n].value;
      std::copy(found[n].slope, found[n].slope + MOVING, jacobian[n].begin());
    }
  }

 private:
  using Variable = Dual<(1u << MOVING) - 1, double>;
  const Rotor &rotor;
  Bearings &bearings;

  // X: numbers, or dual numbers of the moving ones.
  template <class X>
  void evaluate(double time, const X *state, std::array<X, STATE> &slopes) {
    const Turn turn = part->turn_at(time);
    const double late = rotor.relaxation_time;
    Coordinates<X> rate, ahead;
    Five place;
    for (int i = 0; i < COORDINATES; i++) {
      rate[i] = state[RATE + i] + rotor.whirl.rate(i, turn);
      ahead[i] = state[i] + rotor.whirl.along(i, turn) + late * rate[i];
      place[i] = value_of(ahead[i]);
    }
    bearings.load(turn, place);
    const equilibria::System &system = bearings.system;
    const Five outer = part->load_at(time, turn, rotor);
    const double spin = rotor.polar * turn.speed;
    X given{}, taken{}, viscous{};
    for (int i = 0; i < COORDINATES; i++) {
      const X load = linearised(system.load[i], system.stiffness[i], ahead);
      X force = outer[i] + rotor.weight[i] - load;
      if (i == 3) force = force - spin * rate[4];
      if (i == 4) force = force + spin * rate[3];
      slopes[i] = state[RATE + i];
      slopes[RATE + i] = force / rotor.inertia(i) - rotor.whirl.acceleration(i, turn);
      given = given + (outer[i] - rotor.steady[i]) * rate[i];
      taken = taken + (load - (rotor.steady[i] + rotor.weight[i])) * rate[i];
      for (int j = 0; j < COORDINATES; j++) viscous = viscous + late * system.stiffness[i][j] * (rate[i] * rate[j]);
    }
    slopes[LOAD_WORK] = given, slopes[BEARING_WORK] = taken - viscous, slopes[DISSIPATED] = viscous;
    slopes[CAGE_WORK] = X{};
    for (int b = 0; b < BEARINGS; b++)
      slopes[CAGE_WORK] = slopes[CAGE_WORK] + rotor.ratio[b] * turn.speed * cage_load(b, ahead);
  }

  // The moment that turns the balls of a bearing about its axis.
  template <class X>
  X cage_load(int bearing, const Coordinates<X> &ahead) const {
    const equilibria::System &system = bearings.system;
    const Coordinates<X> ring = system.turned_in(*system.rings[bearing].seat, ahead);
    Coordinates<X> load;
    for (int i = 0; i < COORDINATES; i++)
      load[i] = linearised(system.ring_load[bearing][i], system.ring_stiffness[bearing][i], ring);
    return ring[1] * load[0] - ring[0] * load[1] + ring[4] * load[3] - ring[3] * load[4];
  }
};

// One output of a shaft, in the order of its channels (kinds/shaft/motion.py).

// A row begins with this, goes on with loads (balls, 2) and contact angles (balls, 2) of each bearing, and ends with `Energies`.
struct RowHead {
  Five place, rate;
  double angle, speed, ring_offset[BEARINGS][3], force[BEARINGS][3], moment[BEARINGS][2], orbit[BEARINGS];
  Five load;
};
struct Energies { double kinetic, potential, elastic, load_work, bearing_work, cage_work, dissipated, gross_work; };
constexpr int HEAD = sizeof(RowHead) / sizeof(double);

class Outputs {
 public:
  Outputs(const Rotor &rotor, Bearings &bearings, int balls)
      : rotor(rotor), bearings(bearings), contacts(equilibria::CONTACT_NUMBERS * balls) {}

  // Writes the row of a state with its whirl; returns the greatest approach or contact angle of a ball over its limit.
  double write(const CoursePart &part, double time, const State &state, double gross, double *row) {
    const Turn turn = part.turn_at(time);
    Five ahead;
    RowHead &head = *reinterpret_cast<RowHead *>(row);
    for (int i = 0; i < COORDINATES; i++) {
      head.place[i] = state[i], head.rate[i] = state[RATE + i];
      ahead[i] = state[i] + rotor.relaxation_time * state[RATE + i];
    }
    head.angle = turn.angle, head.speed = turn.speed, head.load = part.load_at(time, turn, rotor);
    bearings.load(turn, ahead);
    bearings.system.write_contacts(contacts.data());
    Energies energies{};
    double steady = 0.0;
    for (int i = 0; i < COORDINATES; i++) {
      steady += rotor.steady[i] * state[i];
      energies.kinetic += 0.5 * rotor.inertia(i) * state[RATE + i] * state[RATE + i];
      energies.potential -= rotor.weight[i] * state[i];
    }
    energies.elastic = not_yet_stored(state);
    double worst = 0.0, *next = row + HEAD;
    const double *of_bearing = contacts.data();
    for (int b = 0; b < BEARINGS; b++) {
      write_bearing(b, turn, head);
      worst = std::max(worst, write_balls(b, of_bearing, next, energies.elastic));
      next += 4 * bearings.system.rings[b].count, of_bearing += equilibria::CONTACT_NUMBERS * bearings.system.rings[b].count;
    }
    energies.load_work = state[LOAD_WORK] + steady;
    energies.bearing_work = state[BEARING_WORK] + steady - energies.potential;
    energies.cage_work = state[CAGE_WORK], energies.dissipated = state[DISSIPATED], energies.gross_work = gross;
    *reinterpret_cast<Energies *>(next) = energies;
    return worst;
  }

 private:
  const Rotor &rotor;
  Bearings &bearings;
  std::vector<double> contacts;

  // The work of the shaft on its bearings over the relaxation time to come, which contacts hold already: less than 0.
  double not_yet_stored(const State &state) const {
    const equilibria::System &system = bearings.system;
    const double late = rotor.relaxation_time;
    double work = 0.0;
    for (int i = 0; i < COORDINATES; i++) {
      work -= late * system.load[i] * state[RATE + i];
      for (int j = 0; j < COORDINATES; j++)
        work += 0.5 * late * late * state[RATE + i] * system.stiffness[i][j] * state[RATE + j];
    }
    return work;
  }

  // Place of the ring, and force and moment on the shaft, in its axes.
  void write_bearing(int b, const Turn &turn, RowHead &head) const {
    const Seat &seat = *bearings.system.rings[b].seat;
    const Five ring = bearings.system.turned_in(seat, head.place), &load = bearings.system.ring_load[b];
    for (int i = 0; i < 2; i++) {
      head.ring_offset[b][i] = ring[i], head.force[b][i] = -load[i];
      head.moment[b][i] = -seat.facing * load[3 + i];
    }
    head.ring_offset[b][2] = seat.facing * (ring[2] - seat.middle), head.force[b][2] = -seat.facing * load[2];
    head.orbit[b] = bearings.first_azimuth(b, turn);
  }

  // Loads and angles of a bearing's balls; adds what their contacts store to `elastic`. Returns as `write`.
  double write_balls(int b, const double *contact, double *out, double &elastic) const {
    const equilibria::Ring &ring = bearings.system.rings[b];
    const int balls = ring.count, each = equilibria::CONTACT_NUMBERS;
    double greatest = 0.0, worst = 0.0;
    for (int k = 0; k < balls; k++) greatest = std::max({greatest, contact[each * k + 2], contact[each * k + 3]});
    for (int k = 0; k < balls; k++, contact += each) {
      const double *approach = contact, *load = contact + 2, *angle = contact + 4;
      if (load[0] > 0.0 && load[1] > 0.0)
        worst = std::max(worst, (approach[0] + approach[1]) / (rotor.squeeze_limit * 2.0 * ring.seat->ball_radius));
      for (int race = 0; race < 2; race++) {
        out[2 * k + race] = load[race];
        out[2 * (balls + k) + race] = load[race] > 0.0 ? angle[race] : 0.0;
        elastic += load[race] * std::max(approach[race], 0.0) / (ring.seat->power + 1.0);
        if (load[race] > rotor.idle * greatest) worst = std::max(worst, std::fabs(angle[race]) / rotor.angle_limit);
      }
    }
    return worst;
  }
};

// The motion of the shaft step by step. A step that reaches beyond what is asked for is kept, with its interpolant, so that a
// run does not depend on how it is cut. Steps end where drive or load change. Outputs have balls of their own: looking at a
// motion does not touch it.

constexpr double NEAR = 1e-3;  // of a step: no shorter one is left before a part of the course ends

// Begin and end [s] of the step kept, the next step [s], and the work of loads, bearings and damping [J], each step's counted
// by its size, up to that end and up to that begin.
struct Clock { double began, time, step, gross, gross_before; };

// The step kept: states at its ends, and its interpolant.
struct KeptStep {
  State start, end, third, fourth;

  State at(double share) const {
    State found;
    for (int n = 0; n < STATE; n++) found[n] = interpolated(share, start[n], end[n], third[n], fourth[n]);
    return found;
  }
  bool finite() const {
    double size = 0.0;
    for (const State *one : {&start, &end, &third, &fourth})
      for (double number : *one) size += std::fabs(number);
    return size < HUGE_VAL;
  }
};

// State of a motion, advanced in place.
struct Motion { Clock &clock; KeptStep &kept; std::int64_t *counts; };  // steps, rejections, evaluations

// The state at `time` [s] of the step kept, and the gross work there.
inline std::pair<State, double> state_at(const Clock &clock, const KeptStep &kept, double time) {
  const double lasts = clock.time - clock.began, share = lasts > 0.0 ? (time - clock.began) / lasts : 1.0;
  return {kept.at(share), clock.gross_before + share * (clock.gross - clock.gross_before)};
}

// Drops what of the step kept lies beyond `time` [s]: the motion goes on from there.
inline void restart(Clock &clock, KeptStep &kept, double time) {
  auto [state, gross] = state_at(clock, kept, time);
  kept.start = kept.end = state;
  clock.began = clock.time = time, clock.gross = clock.gross_before = gross;
}

// Instants [s] of outputs and where their rows go.
struct Instants { const double *time; int count; double *row; int width; };

// Steps are between `shortest` and `longest` [s], and end within `furthest` of the middle.
struct Bounds { double shortest, longest; Five furthest; };

class Integration {
 public:
  Integration(const Rotor &rotor, const CoursePart *course, int parts, const Bounds &bounds, Bearings &moved, Method &method,
              Outputs &outputs, const Motion &motion)
      : rotor(rotor), course(course), parts(parts), bounds(bounds), equations(rotor, moved), method(method), outputs(outputs),
        clock(motion.clock), kept(motion.kept), counts(motion.counts) {}

  // Steps until one reaches `until` [s], and writes the outputs.
  Status run(double until, const Instants &instants, int order, const volatile std::uint8_t *stop) {
    for (;;) {
      if (Status status = write_outputs(instants); status != OK || clock.time >= until) return status;
      if (*stop != 0) return STOPPED;
      if (phase + 1 < parts && clock.time >= course[phase + 1].begin) phase++;
      if (Status status = step(order); status != OK) return status;
    }
  }

 private:
  const Rotor &rotor;
  const CoursePart *course;
  const int parts;
  const Bounds &bounds;
  Equations equations;
  Method &method;
  Outputs &outputs;
  Clock &clock;
  KeptStep &kept;
  std::int64_t *counts;
  int phase = 0, cursor = 0;

  // The outputs that the step kept reaches; TOO_DEEP at the first whose contacts leave their limits.
  Status write_outputs(const Instants &instants) {
    for (; cursor < instants.count && instants.time[cursor] <= clock.time; cursor++) {
      const double time = instants.time[cursor];
      auto [state, gross] = state_at(clock, kept, time);
      const Turn turn = course[phase].turn_at(time);
      for (int i = 0; i < COORDINATES; i++)
        state[i] += rotor.whirl.along(i, turn), state[RATE + i] += rotor.whirl.rate(i, turn);
      if (outputs.write(course[phase], time, state, gross, instants.row + std::int64_t(instants.width) * cursor) > 1.0) {
        clock.time = time;
        return TOO_DEEP;
      }
    }
    return OK;
  }

  Status step(int order) {
    equations.part = &course[phase];
    const double begin = clock.time, wanted = std::min(clock.step, bounds.longest);
    const double ends = phase + 1 < parts ? course[phase + 1].begin : HUGE_VAL;
    const bool reaches = begin + (1.0 + NEAR) * wanted >= ends;
    double step = reaches ? ends - begin : wanted, following;
    bool rejected = false;
    for (;; step = following, rejected = true) {
      const double error = method.step_from(equations, begin, kept.end, step);
      following = next_step(step, error, order);
      counts[2] += method.evaluations();
      if (error <= 1.0) break;
      counts[1]++;
      if (!(step > bounds.shortest)) return STALLED;
    }
    for (int i = 0; i < COORDINATES; i++)
      if (!(std::fabs(method.after[i]) <= bounds.furthest[i])) {
        clock.time = begin + step;
        return TOO_DEEP;
      }
    counts[0]++;
    kept = {kept.end, method.after, method.dense_term(0), method.dense_term(1)};
    const bool arrived = reaches && !rejected;
    clock.began = begin, clock.time = arrived ? ends : begin + step;
    clock.step = arrived ? std::max(wanted, following) : following;
    clock.gross_before = clock.gross;
    clock.gross += works();
    return OK;
  }

  // The works [J] of loads, of bearings and of damping in the step kept, each by its size, added up.
  double works() const {
    const Turn begin = course[phase].turn_at(clock.began), end = course[phase].turn_at(clock.time);
    double steady = 0.0, weight = 0.0;
    for (int i = 0; i < COORDINATES; i++) {
      const double moved = rotor.whirl.along(i, end) - rotor.whirl.along(i, begin) + kept.end[i] - kept.start[i];
      steady += rotor.steady[i] * moved, weight += rotor.weight[i] * moved;
    }
    auto done = [&](StateIndex work) { return kept.end[work] - kept.start[work]; };
    return std::fabs(done(LOAD_WORK) + steady) + std::fabs(done(BEARING_WORK) + steady + weight) + std::fabs(done(DISSIPATED));
  }
};

}  // namespace core::shaft

using namespace core;
using namespace core::shaft;

namespace {

template <class Struct>
Struct &at(double *numbers) { return *reinterpret_cast<Struct *>(numbers); }
template <class Struct>
const Struct &at(const double *numbers) { return *reinterpret_cast<const Struct *>(numbers); }

template <class Struct>
constexpr int numbers_in = sizeof(Struct) / sizeof(double);
static_assert(numbers_in<Rotor> == 41 && numbers_in<CoursePart> == 14 && numbers_in<Bounds> == 7 && numbers_in<Clock> == 5 &&
              numbers_in<KeptStep> == 4 * STATE, "kinds/shaft in bearing_twin writes so many doubles");

}  // namespace

// Steps from the step kept on until one reaches `until` [s], and fills `rows` (instants, width) at `times` [s]. `seats` (2,
// SEAT) and `balls` (2,) are of both bearings; `course` (parts, 14) holds the parts from that of the step kept on; `scales`
// (10,) are errors that count as 1. `clock` (5,), `kept` (4, 14) and `counts` (3,) are moved on in place.
CORE_EXPORT std::int64_t core_shaft_advance(const double *rotor_numbers, const double *seats, const std::int64_t *balls,
                                            const double *course, std::int64_t parts, const double *method_numbers,
                                            const double *scales, const double *bounds, std::int64_t instants, const double *times,
                                            double until, const volatile std::uint8_t *stop, double *clock, double *kept,
                                            std::int64_t *counts, double *rows, std::int64_t width) {
  const Rotor &rotor = at<Rotor>(rotor_numbers);
  const RosenbrockMethod method = rosenbrock_of(method_numbers);
  Method::Scales its_scales;
  std::copy(scales, scales + MOVING, its_scales.begin());
  Bearings bearings(rotor, &at<Seat>(seats), balls);
  Method steps(method, its_scales);
  Outputs outputs(rotor, bearings, int(balls[0] + balls[1]));
  Motion motion{at<Clock>(clock), at<KeptStep>(kept), counts};
  Integration integration(rotor, &at<CoursePart>(course), int(parts), at<Bounds>(bounds), bearings, steps, outputs, motion);
  const Status status = integration.run(until, {times, int(instants), rows, int(width)}, method.order, stop);
  return status == OK && !motion.kept.finite() ? NOT_FINITE : status;
}

// Drops what of the step kept lies beyond `time` [s].
CORE_EXPORT void core_shaft_restart(double *clock, double *kept, double time) {
  restart(at<Clock>(clock), at<KeptStep>(kept), time);
}
