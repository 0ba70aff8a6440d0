// Half a disc against a rigid wall, or two of them, by explicit central differences:
//
//     M a = -integral of P grad N dA + contact,   v(n + 1/2) = v(n - 1/2) + h a(n),   u(n + 1) = u(n) + h v(n + 1/2)
//
// Kinetic energy is v(n - 1/2) M v(n + 1/2) / 2: with it the energy of a linear body is constant to round-off, whatever the
// step, which stability sets and no error estimate.
#include "half_disc.hpp"
#include "../exports.hpp"

namespace core::soft_discs {

// The contact of a half disc with a wall, y = 0, or with another: rims that pass through it are pressed apart.
//
// A point of the rim at a depth d below the wall is pressed up by k d^m per undeformed length. Of two discs each has a frame of
// its own, y away from the other. They overlap by g = -(y + y'(x)) where their rims pass the same x, and the energy is the
// mean of the integrals of k g^(m+1)/(m+1) over both undeformed rims. Forces are its derivatives, so that energy is kept, and
// opposite to each other whatever the meshes. Of equal discs that is the contact with a wall. Breaks: where a rim is no graph
// over x any more, far beyond the contact.

constexpr int ROOT_STEPS = 60;  // at most, for the place on an edge: halving alone takes as many
constexpr double NEAR = 0.01;  // radii: rims may dip below their nodes by less

// The force on the half disc, its energy and its greatest depth.
struct Pressed {
  double force = 0.0, energy = 0.0, depth = 0.0;

  void add(const Pressed &other) { force += other.force, energy += other.energy, depth = std::max(depth, other.depth); }
  // Takes in a point that is pressed by `pushed` at this depth.
  void take(double pushed, double at, double exponent) { add({pushed, pushed * at / (exponent + 1.0), at}); }
};

// Adds the pressure of the wall to `load`.
inline Pressed press_wall(const HalfDisc &disc, const Field &displacement, const Field &load) {
  Pressed found;
  for (int edge = 0; edge < disc.edges; edge++)
    for (int point = 0; point < disc.rim_points; point++) {
      const double *shape = disc.rim_shape + point * disc.side;
      const double height = disc.on_rim(shape, edge, [&](std::int64_t n) { return disc.height[n] + displacement.y[n]; });
      if (!(height < 0.0)) continue;
      const double pushed = disc.pressure(-height) * disc.rim_weight[edge * disc.rim_points + point];
      found.take(pushed, -height, disc.exponent);
      for (int a = 0; a < disc.side; a++) load.y[disc.rim_node[edge * disc.side + a]] += pushed * shape[a];
    }
  return found;
}

// The rim of a disc as a graph over x.
class Rim {
 public:
  double lowest = HUGE_VAL;  // of its nodes
  double shape[MOST_SIDE];  // of the nodes of the edge that was found last, where it passes x

  Rim(const HalfDisc &disc, const Field &moved) : disc(disc), moved(moved) {
    for (int i = 0; i < disc.edges * disc.side; i++) lowest = std::min(lowest, y(disc.rim_node[i]));
  }
  double x(std::int64_t node) const { return disc.across[node] + moved.x[node]; }
  double y(std::int64_t node) const { return disc.height[node] + moved.y[node]; }

  // Finds the edge that passes x, beginning at the one found last; false where the rim ends before.
  bool find(double at) {
    while (edge < disc.edges - 1 && end_of(edge) < at) edge++;
    while (edge > 0 && end_of(edge - 1) > at) edge--;
    return !(end_of(edge) < at);
  }
  const std::int64_t *edge_node() const { return disc.rim_node + edge * disc.side; }

  // Height and slope dy/dx where the edge found passes x, by Newton's method between brackets.
  struct Point { double height, slope; };
  Point at(double wanted) {
    double low = -1.0, high = 1.0, place = 0.0, height = 0.0, steep = 1.0, rise = 0.0;
    for (int i = 0; i < ROOT_STEPS; i++) {
      set_shapes(place);
      const double along = sum(shape, &Rim::x);
      height = sum(shape, &Rim::y), steep = sum(slope, &Rim::x), rise = sum(slope, &Rim::y);
      const double missed = along - wanted, change = steep > 0.0 ? missed / steep : 2.0;
      (missed > 0.0 ? high : low) = place;
      if (std::fabs(change) < 1e-14) break;
      place -= change;
      if (!(low <= place && place <= high)) place = 0.5 * (low + high);
    }
    return {height, rise / steep};
  }

 private:
  const HalfDisc &disc;
  const Field &moved;
  int edge = 0;
  double slope[MOST_SIDE];

  double end_of(int edge) const { return x(disc.rim_node[(edge + 1) * disc.side - 1]); }
  double sum(const double *weight, double (Rim::*value)(std::int64_t) const) const {
    return disc.on_rim(weight, edge, [&](std::int64_t node) { return (this->*value)(node); });
  }
  // Values and slopes of the Lagrange polynomials on the nodes of an edge.
  void set_shapes(double place) {
    const double *nodes = disc.rim_place;
    for (int a = 0; a < disc.side; a++) {
      shape[a] = 1.0, slope[a] = 0.0;
      for (int b = 0; b < disc.side; b++) {
        if (b == a) continue;
        const double scale = 1.0 / (nodes[a] - nodes[b]);
        slope[a] = (slope[a] * (place - nodes[b]) + shape[a]) * scale;
        shape[a] *= (place - nodes[b]) * scale;
      }
    }
  }
};

// Adds what the points of the rim of `disc` give to `load` and, of `other`, to `given`.
inline Pressed press_rim(const HalfDisc &disc, const Field &displacement, const Field &load, const HalfDisc &other,
                         const Field &moved, const Field &given) {
  Pressed found;
  Rim facing(other, moved);
  for (int edge = 0; edge < disc.edges; edge++)
    for (int point = 0; point < disc.rim_points; point++) {
      const double *shape = disc.rim_shape + point * disc.side;
      const std::int64_t *node = disc.rim_node + edge * disc.side;
      const double x = disc.on_rim(shape, edge, [&](std::int64_t n) { return disc.across[n] + displacement.x[n]; });
      const double y = disc.on_rim(shape, edge, [&](std::int64_t n) { return disc.height[n] + displacement.y[n]; });
      if (y + facing.lowest > NEAR || !facing.find(x)) continue;
      const Rim::Point met = facing.at(x);
      const double depth = -(y + met.height);
      if (!(depth > 0.0)) continue;
      const double pushed = 0.5 * disc.pressure(depth) * disc.rim_weight[edge * disc.rim_points + point];
      found.take(pushed, depth, disc.exponent);
      for (int a = 0; a < disc.side; a++) {
        const double share = pushed * shape[a];
        load.x[node[a]] += share * met.slope, load.y[node[a]] += share;
      }
      for (int a = 0; a < other.side; a++) {
        const double share = pushed * facing.shape[a];
        given.x[facing.edge_node()[a]] -= share * met.slope, given.y[facing.edge_node()[a]] += share;
      }
    }
  return found;
}

}  // namespace core::soft_discs

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
