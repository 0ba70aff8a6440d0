// Half a disc against a rigid wall, or two of them, by explicit central differences:
//
//     M a = -integral of P grad N dA + contact,   v(n + 1/2) = v(n - 1/2) + h a(n),   u(n + 1) = u(n) + h v(n + 1/2)
//
// Kinetic energy is v(n - 1/2) M v(n + 1/2) / 2: with it the energy of a linear body is constant to round-off, whatever the
// step, which stability sets and no error estimate.
#include "../door.hpp"
#include "contact.hpp"

using namespace core;
using namespace core::soft_discs;

namespace {

// A disc on the move, (2, nodes): displacement, velocity half a step before, and room for forces.
struct Disc {
  const HalfDisc &body;
  Field displacement, velocity, load;

  Disc(const HalfDisc *body, double *state)
      : body(*body), displacement(state, *body), velocity(state + 2 * body->nodes, *body), load(state + 4 * body->nodes, *body) {}

  Elastic load_elastic() {
    load.clear(body);
    return add_elastic(body, displacement, load);
  }
};

// Along y, of the half disc: twice the kinetic energy, momentum, sum of forces, moment of mass.
struct Moved { double kinetic = 0.0, momentum = 0.0, gained = 0.0, moment = 0.0; };

// One step by the forces on the disc.
Moved advance(Disc &disc, double step) {
  Moved found;
  for (int i = 0; i < disc.body.axis_nodes; i++) disc.load.x[disc.body.axis_node[i]] = 0.0;
  for (int n = 0; n < disc.body.nodes - 1; n++) {
    const double mass = disc.body.mass[n], x = disc.velocity.x[n], y = disc.velocity.y[n];
    const double after_x = x + step * disc.load.x[n] / mass, after_y = y + step * disc.load.y[n] / mass;
    disc.velocity.x[n] = after_x, disc.velocity.y[n] = after_y;
    found.kinetic += mass * (x * after_x + y * after_y);
    found.momentum += 0.5 * mass * (y + after_y);
    found.gained += disc.load.y[n];
    found.moment += mass * (disc.body.height[n] + disc.displacement.y[n]);
    disc.displacement.x[n] += step * after_x, disc.displacement.y[n] += step * after_y;
  }
  return found;
}

double mass_of(const HalfDisc &body) {
  double mass = 0.0;
  for (int n = 0; n < body.nodes - 1; n++) mass += body.mass[n];
  return mass;
}

// Of the whole disc, energies, stretch and det F of both; `balance` is the force less the integral of rho a dA, rounding alone.
struct Row {
  double force, position, velocity, kinetic, elastic, contact, depth, least_stretch, least_det, balance, other_position,
      other_velocity;
};

// Steps through a row of the history; false where an element is turned inside out and the law has no answer to that.
class March {
 public:
  March(Disc &disc, Disc *other, double step)
      : disc(disc), other(other), step(step), mass(mass_of(disc.body)), other_mass(other ? mass_of(other->body) : 0.0) {}

  bool make(Row &row) {
    Elastic elastic = disc.load_elastic();
    Pressed pressed;
    row = {};
    if (other) {
      const Elastic more = other->load_elastic();
      elastic = {elastic.energy + more.energy, std::min(elastic.least_det, more.least_det),
                 std::min(elastic.least_stretch, more.least_stretch)};
      pressed = press_rim(disc.body, disc.displacement, disc.load, other->body, other->displacement, other->load);
      pressed.add(press_rim(other->body, other->displacement, other->load, disc.body, disc.displacement, disc.load));
      const Moved moved = advance(*other, step);
      row.kinetic = moved.kinetic, row.balance = std::fabs(pressed.force - moved.gained);
      row.other_position = moved.moment / other_mass, row.other_velocity = moved.momentum / other_mass;
    } else {
      pressed = press_wall(disc.body, disc.displacement, disc.load);
    }
    const Moved moved = advance(disc, step);
    row.force = 2.0 * pressed.force, row.position = moved.moment / mass, row.velocity = moved.momentum / mass;
    row.kinetic += moved.kinetic, row.elastic = 2.0 * elastic.energy, row.contact = 2.0 * pressed.energy;
    row.depth = pressed.depth, row.least_stretch = elastic.least_stretch, row.least_det = elastic.least_det;
    row.balance = 2.0 * std::max(row.balance, std::fabs(pressed.force - moved.gained));
    return elastic.least_det > 0.0 || Law(disc.body.law) == Law::linear;
  }

 private:
  Disc &disc, *other;
  const double step, mass, other_mass;
};

}  // namespace

// Fills the rows of `history` (rows, 12), the first of them at step number `first`; returns how many, fewer than there are
// where an element is turned inside out in the last of them. `state` (3, 2, nodes) is moved on in place. `other` is null for a
// wall. `shapes` (frames, discs, 2, nodes) takes the displacements at every step divisible by `every`.
CORE_EXPORT std::int64_t core_soft_discs_march(const HalfDisc *body, double *state, const HalfDisc *other, double *other_state,
                                               double step, std::int64_t rows, double *history, std::int64_t frames, double *shapes,
                                               std::int64_t every, std::int64_t first) {
  Disc disc(body, state), second(other ? other : body, other_state);
  March march(disc, other ? &second : nullptr, step);
  const std::int64_t shape = 2 * body->nodes;
  Row *row = reinterpret_cast<Row *>(history);
  for (std::int64_t i = 0; i < rows; i++, row++) {
    const std::int64_t frame = (first + i) / every;
    if ((first + i) % every == 0 && frame < frames) {
      double *to = shapes + frame * shape * (other ? 2 : 1);
      std::copy(disc.displacement.x, disc.displacement.x + shape, to);
      if (other) std::copy(second.displacement.x, second.displacement.x + shape, to + shape);
    }
    if (!march.make(*row)) return i + 1;
  }
  return rows;
}

// Takes the forces of elasticity off `load` (2, nodes); fills the energy, the least det F and the least stretch.
CORE_EXPORT void core_soft_discs_elastic(const HalfDisc *body, double *displacement, double *load, double *found) {
  const Elastic elastic = add_elastic(*body, {displacement, *body}, {load, *body});
  found[0] = elastic.energy, found[1] = elastic.least_det, found[2] = elastic.least_stretch;
}

// The forces that a small displacement (2, nodes) of a linear disc meets, the whole rim being on the wall; of the exponent
// m = 1 the stiffness is k, of others that at a depth of one radius.
CORE_EXPORT void core_soft_discs_stiffness(const HalfDisc *body, double *displacement, double *load_numbers) {
  const HalfDisc &disc = *body;
  const Field moved(displacement, disc), load(load_numbers, disc);
  load.clear(disc);
  add_elastic(disc, moved, load);
  for (int edge = 0; edge < disc.edges; edge++)
    for (int point = 0; point < disc.rim_points; point++) {
      const double *shape = disc.rim_shape + point * disc.side;
      for (auto [from, to] : {std::pair{moved.x, load.x}, std::pair{moved.y, load.y}}) {
        const double depth = disc.on_rim(shape, edge, [&, from = from](std::int64_t n) { return from[n]; });
        const double pushed = disc.stiffness * disc.rim_weight[edge * disc.rim_points + point] * depth;
        for (int a = 0; a < disc.side; a++) to[disc.rim_node[edge * disc.side + a]] -= pushed * shape[a];
      }
    }
}
