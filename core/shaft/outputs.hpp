// What one output of a shaft holds, in the order of its channels (kinds/shaft/motion.py).
#pragma once
#include "rotor.hpp"

namespace core::shaft {

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
