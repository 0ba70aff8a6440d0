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
// The state of a run that starts with the linear response to the unbalances is relative to that whirl, Re(u exp(i angle)), so that
// the error of a step is a fraction of the deviation alone. Otherwise, where steps are long against the periods of modes, rates
// would have errors of some per cent, and works errors beyond their size.
//
// The balls orbit as prescribed, so that their cages do work. A bearing with its balls turned with the ring is the same as
// before, so that its energy changes with the balls' azimuth by y F_x - x F_y + theta_y M_x - theta_x M_y.

using equilibria::COORDINATES;
using equilibria::Seat;
using equilibria::Vector5;

// A state: coordinates and their rates relative to the whirl, and works since the start [J]: of loads and unbalances on the
// shaft, of the shaft on its bearings without what they dissipate, that, and of both cages; of the first two without those
// of steady loads, which follow from the position.
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
  Vector5 real, imaginary;
  double along(int i, const Turn &turn) const { return real[i] * turn.cosine - imaginary[i] * turn.sine; }
  double across(int i, const Turn &turn) const { return real[i] * turn.sine + imaginary[i] * turn.cosine; }
  double rate(int i, const Turn &turn) const { return -turn.speed * across(i, turn); }
  double acceleration(int i, const Turn &turn) const {
    return -turn.speed * turn.speed * along(i, turn) - turn.acceleration * across(i, turn);
  }
};

// Doubles alone, in the order in which Python writes them (`Rotor.numbers`). `steady` are the loads when the run starts;
// unbalances act on the shaft by the acceleration of their masses. Of each bearing the azimuth of ball 0 at the
// start and its orbit's speed over the shaft's. Limits of contacts: the approaches of a ball's two over its diameter, the
// contact angle [rad], and the share of the greatest load below which an angle does not count.
struct Rotor {
  double mass, transverse, polar, relaxation_time;
  Vector5 weight, steady;
  Turning whirl, unbalance;
  double first[BEARINGS], ratio[BEARINGS];
  double squeeze_limit, angle_limit, idle;

  double inertia(int i) const { return i < 3 ? mass : transverse; }
};

// A part of the course since `begin` [s]: the shaft had turned by `angle` and turns at constant acceleration. The external
// `load` [N, N m] about the centre of mass, which grows by `growth` a second.
struct CoursePart {
  double begin, angle, speed, acceleration;
  Vector5 load, growth;

  Turn turn_at(double time) const {
    const double passed = time - begin;
    return {angle + (speed + 0.5 * acceleration * passed) * passed, speed + acceleration * passed, acceleration};
  }
  // Loads on the shaft without its weight: external ones and those of the unbalances.
  Vector5 load_at(double time, const Turn &turn, const Rotor &rotor) const {
    Vector5 load_now;
    for (int i = 0; i < COORDINATES; i++)
      load_now[i] = load[i] + (time - begin) * growth[i] - rotor.unbalance.acceleration(i, turn);
    return load_now;
  }
};

// Both bearings with balls that orbit in their cages as the shaft turns.
class Bearings {
 public:
  equilibria::System system;

  Bearings(const Rotor &rotor, const Seat *seat_numbers, const std::int64_t *balls) : rotor(rotor), azimuth(balls[0] + balls[1]) {
    std::copy(seat_numbers, seat_numbers + BEARINGS, seats);
    system.set(seats, BEARINGS, balls);
  }
  Bearings(const Bearings &) = delete;

  // The loads of the bearings on the shaft at `q`.
  void load(const Turn &turn, const Vector5 &q) {
    double *next = azimuth.data();
    for (int b = 0; b < BEARINGS; b++) {
      seats[b].speed = turn.speed;
      const double first = first_azimuth(b, turn);
      const int count = system.rings[b].count;
      for (int k = 0; k < count; k++) *next++ = first + 2.0 * M_PI * k / count;
    }
    system.place_balls(azimuth.data());
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
X linearised(double value, const Vector5 &derivatives, const Coordinates<X> &coordinates) {
  if constexpr (!IsDual<X>) return value;
  else {
    X result{value, {}};
    for (int j = 0; j < COORDINATES; j++)
      for (int c = 0; c < MOVING; c++) result.slope[c] += derivatives[j] * coordinates[j].slope[c];
    return result;
  }
}

// The rates of a state on one part of the course, for `Method`.
class Equations {
 public:
  const CoursePart *part = nullptr;

  Equations(const Rotor &rotor, Bearings &bearings) : rotor(rotor), bearings(bearings) {}

  void rates(double time, const State &state, State &slopes) { evaluate(time, state.data(), slopes); }

  // Exact but for the derivative of the stiffness in the dissipation.
  void rates_and_jacobian(double time, const State &state, State &slopes, Method::Jacobian &jacobian) {
    std::array<Variable, MOVING> moving;
    for (int n = 0; n < MOVING; n++) moving[n] = {state[n], {}}, moving[n].slope[n] = 1.0;
    std::array<Variable, STATE> rates;
    evaluate(time, moving.data(), rates);
    for (int n = 0; n < STATE; n++) {
      slopes[n] = rates[n].value;
      std::copy(rates[n].slope, rates[n].slope + MOVING, jacobian[n].begin());
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
    const double relaxation_time = rotor.relaxation_time;
    Coordinates<X> rate, ahead;
    Vector5 position;
    for (int i = 0; i < COORDINATES; i++) {
      rate[i] = state[RATE + i] + rotor.whirl.rate(i, turn);
      ahead[i] = state[i] + rotor.whirl.along(i, turn) + relaxation_time * rate[i];
      position[i] = value_of(ahead[i]);
    }
    bearings.load(turn, position);
    const equilibria::System &system = bearings.system;
    const Vector5 outer = part->load_at(time, turn, rotor);
    const double spin = rotor.polar * turn.speed;
    X load_power{}, bearing_power{}, dissipation{};
    for (int i = 0; i < COORDINATES; i++) {
      const X load = linearised(system.load[i], system.stiffness[i], ahead);
      X force = outer[i] + rotor.weight[i] - load;
      if (i == 3) force = force - spin * rate[4];
      if (i == 4) force = force + spin * rate[3];
      slopes[i] = state[RATE + i];
      slopes[RATE + i] = force / rotor.inertia(i) - rotor.whirl.acceleration(i, turn);
      load_power = load_power + (outer[i] - rotor.steady[i]) * rate[i];
      bearing_power = bearing_power + (load - (rotor.steady[i] + rotor.weight[i])) * rate[i];
      for (int j = 0; j < COORDINATES; j++)
        dissipation = dissipation + relaxation_time * system.stiffness[i][j] * (rate[i] * rate[j]);
    }
    slopes[LOAD_WORK] = load_power, slopes[BEARING_WORK] = bearing_power - dissipation, slopes[DISSIPATED] = dissipation;
    slopes[CAGE_WORK] = X{};
    for (int b = 0; b < BEARINGS; b++) slopes[CAGE_WORK] = slopes[CAGE_WORK] + rotor.ratio[b] * turn.speed * cage_load(b, ahead);
  }

  // The moment that turns the balls of a bearing about its axis.
  template <class X>
  X cage_load(int bearing, const Coordinates<X> &ahead) const {
    const equilibria::System &system = bearings.system;
    const Coordinates<X> ring = system.ring_coordinates(*system.rings[bearing].seat, ahead);
    Coordinates<X> load;
    for (int i = 0; i < COORDINATES; i++)
      load[i] = linearised(system.ring_load[bearing][i], system.ring_stiffness[bearing][i], ring);
    return ring[1] * load[0] - ring[0] * load[1] + ring[4] * load[3] - ring[3] * load[4];
  }
};

// One output of a shaft, in the order of its channels (kinds/shaft/motion.py).

// A row starts with this, continues with loads (balls, 2) and contact angles (balls, 2) of each bearing, and ends with `Energies`.
struct RowHead {
  Vector5 position, rate;
  double angle, speed, ring_offset[BEARINGS][3], force[BEARINGS][3], moment[BEARINGS][2], orbit[BEARINGS];
  Vector5 load;
};
struct Energies {
  double kinetic, potential, elastic, load_work, bearing_work, cage_work, dissipated, gross_work;
};
constexpr int HEAD = sizeof(RowHead) / sizeof(double);

class Outputs {
 public:
  Outputs(const Rotor &rotor, Bearings &bearings, int balls)
      : rotor(rotor), bearings(bearings), contacts(equilibria::CONTACT_NUMBERS * balls) {}

  // Writes the row of a state with its whirl; returns the greatest approach or contact angle of a ball over its limit.
  double write(const CoursePart &part, double time, const State &state, double gross, double *row) {
    const Turn turn = part.turn_at(time);
    Vector5 ahead;
    RowHead &head = *reinterpret_cast<RowHead *>(row);
    for (int i = 0; i < COORDINATES; i++) {
      head.position[i] = state[i], head.rate[i] = state[RATE + i];
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

  // The work of the shaft on its bearings over the next relaxation time, which contacts already store: negative.
  double not_yet_stored(const State &state) const {
    const equilibria::System &system = bearings.system;
    const double relaxation_time = rotor.relaxation_time;
    double work = 0.0;
    for (int i = 0; i < COORDINATES; i++) {
      work -= relaxation_time * system.load[i] * state[RATE + i];
      for (int j = 0; j < COORDINATES; j++)
        work += 0.5 * relaxation_time * relaxation_time * state[RATE + i] * system.stiffness[i][j] * state[RATE + j];
    }
    return work;
  }

  // Position of the ring, and force and moment on the shaft, in its axes.
  void write_bearing(int b, const Turn &turn, RowHead &head) const {
    const Seat &seat = *bearings.system.rings[b].seat;
    const Vector5 ring = bearings.system.ring_coordinates(seat, head.position), &load = bearings.system.ring_load[b];
    for (int i = 0; i < 2; i++) {
      head.ring_offset[b][i] = ring[i], head.force[b][i] = -load[i];
      head.moment[b][i] = -seat.facing * load[3 + i];
    }
    head.ring_offset[b][2] = seat.facing * (ring[2] - seat.middle), head.force[b][2] = -seat.facing * load[2];
    head.orbit[b] = bearings.first_azimuth(b, turn);
  }

  // Loads and angles of a bearing's balls; adds the energy of their contacts to `elastic`. Returns as `write`.
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

// The motion of the shaft step by step. The last step may reach beyond the requested time and is stored with its dense output, so
// that a run does not depend on how it is divided. Steps end where drive or load change. Outputs have balls of their own and do not
// affect the motion.

constexpr double SHORTEST_REST = 1e-3;  // of a step: no shorter step remains at the end of a part of the course

// Start and end [s] of the last step, the next step [s], and the sum of the absolute works of loads, bearings and damping [J] in all
// steps up to that end and up to that start.
struct Clock {
  double start, time, step, gross, gross_before;
};

// The last step: states at its ends, and its dense output.
struct LastStep {
  State start, end, third, fourth;

  State state(double fraction) const {
    State result;
    for (int n = 0; n < STATE; n++) result[n] = interpolated(fraction, start[n], end[n], third[n], fourth[n]);
    return result;
  }
  bool finite() const {
    double size = 0.0;
    for (const State *part : {&start, &end, &third, &fourth})
      for (double number : *part) size += std::fabs(number);
    return size < HUGE_VAL;
  }
};

// State of a motion, advanced in place.
struct Motion {
  Clock &clock;
  LastStep &last_step;
  std::int64_t *counts;
};  // steps, rejections, evaluations

// The state at `time` [s] of the last step, and the gross work there.
inline std::pair<State, double> state_at(const Clock &clock, const LastStep &last_step, double time) {
  const double lasts = clock.time - clock.start, fraction = lasts > 0.0 ? (time - clock.start) / lasts : 1.0;
  return {last_step.state(fraction), clock.gross_before + fraction * (clock.gross - clock.gross_before)};
}

// Discards the part of the last step beyond `time` [s]; the motion continues from there.
inline void restart(Clock &clock, LastStep &last_step, double time) {
  auto [state, gross] = state_at(clock, last_step, time);
  last_step.start = last_step.end = state;
  clock.start = clock.time = time, clock.gross = clock.gross_before = gross;
}

// Instants [s] of outputs and where their rows go.
struct Instants {
  const double *time;
  int count;
  double *row;
  int width;
};

// Steps are between `shortest` and `longest` [s]; coordinates stay below `furthest`.
struct Bounds {
  double shortest, longest;
  Vector5 furthest;
};

class Integration {
 public:
  Integration(const Rotor &rotor, const CoursePart *course, int parts, const Bounds &bounds, Bearings &moved, Method &method,
              Outputs &outputs, const Motion &motion)
      : rotor(rotor),
        course(course),
        parts(parts),
        bounds(bounds),
        equations(rotor, moved),
        method(method),
        outputs(outputs),
        clock(motion.clock),
        last_step(motion.last_step),
        counts(motion.counts) {}

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
  LastStep &last_step;
  std::int64_t *counts;
  int phase = 0, cursor = 0;

  // The outputs within the last step; TOO_DEEP at the first whose contacts exceed their limits.
  Status write_outputs(const Instants &instants) {
    for (; cursor < instants.count && instants.time[cursor] <= clock.time; cursor++) {
      const double time = instants.time[cursor];
      auto [state, gross] = state_at(clock, last_step, time);
      const Turn turn = course[phase].turn_at(time);
      for (int i = 0; i < COORDINATES; i++) state[i] += rotor.whirl.along(i, turn), state[RATE + i] += rotor.whirl.rate(i, turn);
      if (outputs.write(course[phase], time, state, gross, instants.row + std::int64_t(instants.width) * cursor) > 1.0) {
        clock.time = time;
        return TOO_DEEP;
      }
    }
    return OK;
  }

  Status step(int order) {
    equations.part = &course[phase];
    const double begin = clock.time, planned = std::min(clock.step, bounds.longest);
    const double ends = phase + 1 < parts ? course[phase + 1].begin : HUGE_VAL;
    const bool reaches = begin + (1.0 + SHORTEST_REST) * planned >= ends;
    double step = reaches ? ends - begin : planned, proposed;
    bool rejected = false;
    for (;; step = proposed, rejected = true) {
      const double error = method.step_from(equations, begin, last_step.end, step);
      proposed = next_step(step, error, order);
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
    last_step = {last_step.end, method.after, method.dense_term(0), method.dense_term(1)};
    const bool arrived = reaches && !rejected;
    clock.start = begin, clock.time = arrived ? ends : begin + step;
    clock.step = arrived ? std::max(planned, proposed) : proposed;
    clock.gross_before = clock.gross;
    clock.gross += gross_work();
    return OK;
  }

  // The sum of the absolute works [J] of loads, bearings and damping in the last step.
  double gross_work() const {
    const Turn begin = course[phase].turn_at(clock.start), end = course[phase].turn_at(clock.time);
    double steady = 0.0, weight = 0.0;
    for (int i = 0; i < COORDINATES; i++) {
      const double moved = rotor.whirl.along(i, end) - rotor.whirl.along(i, begin) + last_step.end[i] - last_step.start[i];
      steady += rotor.steady[i] * moved, weight += rotor.weight[i] * moved;
    }
    auto done = [&](StateIndex work) { return last_step.end[work] - last_step.start[work]; };
    return std::fabs(done(LOAD_WORK) + steady) + std::fabs(done(BEARING_WORK) + steady + weight) + std::fabs(done(DISSIPATED));
  }
};

}  // namespace core::shaft

using namespace core;
using namespace core::shaft;

namespace {

template <class Struct>
Struct &as(double *numbers) {
  return *reinterpret_cast<Struct *>(numbers);
}
template <class Struct>
const Struct &as(const double *numbers) {
  return *reinterpret_cast<const Struct *>(numbers);
}

template <class Struct>
constexpr int numbers_in = sizeof(Struct) / sizeof(double);
static_assert(numbers_in<Rotor> == 41 && numbers_in<CoursePart> == 14 && numbers_in<Bounds> == 7 && numbers_in<Clock> == 5 &&
                  numbers_in<LastStep> == 4 * STATE,
              "kinds/shaft in bearing_twin writes so many doubles");

}  // namespace

// Steps from the last step until one reaches `until` [s], and fills `rows` (instants, width) at `times` [s]. `seats` (2,
// SEAT) and `balls` (2,) are of both bearings; `course` (parts, 14) holds the parts from that of the last step; `scales`
// (10,) are errors that count as 1. `clock` (5,), `last_step` (4, 14) and `counts` (3,) are advanced in place.
CORE_EXPORT std::int64_t core_shaft_advance(const double *rotor_numbers, const double *seats, const std::int64_t *balls,
                                            const double *course, std::int64_t parts, const double *method_numbers,
                                            const double *scales, const double *bounds, std::int64_t instants, const double *times,
                                            double until, const volatile std::uint8_t *stop, double *clock, double *last_step,
                                            std::int64_t *counts, double *rows, std::int64_t width) {
  const Rotor &rotor = as<Rotor>(rotor_numbers);
  const RosenbrockMethod method = rosenbrock_of(method_numbers);
  Method::Scales its_scales;
  std::copy(scales, scales + MOVING, its_scales.begin());
  Bearings bearings(rotor, &as<Seat>(seats), balls);
  Method steps(method, its_scales);
  Outputs outputs(rotor, bearings, int(balls[0] + balls[1]));
  Motion motion{as<Clock>(clock), as<LastStep>(last_step), counts};
  Integration integration(rotor, &as<CoursePart>(course), int(parts), as<Bounds>(bounds), bearings, steps, outputs, motion);
  const Status status = integration.run(until, {times, int(instants), rows, int(width)}, method.order, stop);
  return status == OK && !motion.last_step.finite() ? NOT_FINITE : status;
}

// See `restart`.
CORE_EXPORT void core_shaft_restart(double *clock, double *last_step, double time) {
  restart(as<Clock>(clock), as<LastStep>(last_step), time);
}
