// The contact of a half disc with a wall, y = 0, or with another: rims that pass through it are pressed apart.
//
// A point of the rim at a depth d below the wall is pressed up by k d^m per undeformed length. Of two discs each has a frame of
// its own, y away from the other. They overlap by g = -(y + y'(x)) where their rims pass the same x, and the energy is the
// mean of the integrals of k g^(m+1)/(m+1) over both undeformed rims. Forces are its derivatives, so that energy is kept, and
// opposite to each other whatever the meshes. Of equal discs that is the contact with a wall. Breaks: where a rim is no graph
// over x any more, far beyond the contact.
#pragma once
#include "half_disc.hpp"

namespace core::soft_discs {

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
