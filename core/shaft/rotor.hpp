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
#pragma once
#include "../bearing/equilibrium.hpp"
#include "../methods/rosenbrock.hpp"

namespace core::shaft {

using equilibria::BALL_MEMORY;
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

// What turns with the shaft: the real part of z exp(i angle).
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

// Both bearings with balls that orbit in their cages as the shaft turns. Equilibria begin at `memory` (N, BALL_MEMORY).
class Bearings {
 public:
  equilibria::System system;

  Bearings(const Rotor &rotor, const Seat *seat_numbers, const std::int64_t *balls, double *memory)
      : rotor(rotor), memory(memory), azimuth(balls[0] + balls[1]) {
    std::copy(seat_numbers, seat_numbers + BEARINGS, seats);
    system.set(seats, BEARINGS, balls);
    system.remember(memory);
  }
  ~Bearings() { system.write_memory(memory); }
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
  double *memory;
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

// What one output of a shaft holds, in the order of its channels (kinds/shaft/motion.py).

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

}  // namespace core::shaft
