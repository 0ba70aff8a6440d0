// Half a disc cut into elements, LANES of them side by side, and the forces of elasticity at its nodes. Lengths are in radii,
// stresses in Young's moduli and densities in that of the first disc, so that times are in r sqrt(rho/E).
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include "elasticity.hpp"

namespace core::soft_discs {

constexpr int MOST_NODES = 25;  // of an element
using LoosePack = double __attribute__((vector_size(8 * LANES), aligned(8)));  // as arrays of Python have them

// As Python hands it over (`HalfDisc` of kinds/soft_discs/solve.py). The last of the `nodes` is none: it takes what lanes
// without an element give. Arrays: `across`, `height`, `mass` (nodes,); `node` (blocks, element_nodes, LANES); `gradient` of
// the shape functions by x and y (blocks, points, element_nodes, 2, LANES); `weight` (blocks, points, LANES), the first `full`
// points for the part with the shear modulus, the others for Lame's first parameter. Of the lower half of the rim, from the
// bottom up: `rim_node` (edges, edge_nodes), `rim_shape` (rim_points, edge_nodes), `rim_weight` (edges, rim_points) and
// the `rim_place` of nodes (edge_nodes,) on [-1, 1]; `axis_node` (axis_nodes,) on x = 0. Pressure is stiffness depth^exponent.
struct HalfDisc {
  std::int64_t nodes, blocks, element_nodes, points, full, edges, edge_nodes, rim_points, axis_nodes, law;
  const double *across, *height, *mass;
  const std::int64_t *node;
  const LoosePack *gradient, *weight;
  const std::int64_t *rim_node;
  const double *rim_shape, *rim_weight, *rim_place;
  const std::int64_t *axis_node;
  double mu, lame, stiffness, exponent;

  double pressure(double depth) const { return stiffness * (exponent == 1.0 ? depth : std::pow(depth, exponent)); }
  // The sum of value(node) over the nodes of an edge of the rim, by their shape functions at a point.
  template <class Function>
  double on_rim(const double *shape, int edge, Function value) const {
    double sum = 0.0;
    for (int a = 0; a < edge_nodes; a++) sum += shape[a] * value(rim_node[edge * edge_nodes + a]);
    return sum;
  }
};

// (2, nodes): x and y of each.
struct Field {
  double *x, *y;
  Field(double *numbers, const HalfDisc &disc) : x(numbers), y(numbers + disc.nodes) {}
  void clear(const HalfDisc &disc) const { std::fill(x, x + 2 * disc.nodes, 0.0); }
};

struct Elastic { double energy, least_det, least_stretch; };

// Takes the forces of elasticity off `load`; returns the energy, least det F and least stretch of the half disc.
template <Law LAW>
Elastic add_elastic(const HalfDisc &disc, const Field &displacement, const Field &load) {
  const Moduli moduli{disc.mu, disc.lame};
  const int size = int(disc.element_nodes), points = int(disc.points);
  Pack moved[2 * MOST_NODES], given[2 * MOST_NODES];
  Found found;
  const LoosePack *gradient = disc.gradient, *weight = disc.weight;
  const std::int64_t *node = disc.node;
  for (int block = 0; block < disc.blocks; block++, node += size * LANES) {
    for (int a = 0; a < size; a++)
      for (int lane = 0; lane < LANES; lane++) {
        moved[2 * a][lane] = displacement.x[node[a * LANES + lane]];
        moved[2 * a + 1][lane] = displacement.y[node[a * LANES + lane]];
      }
    std::fill(given, given + 2 * size, Pack{});
    for (int q = 0; q < points; q++, gradient += 2 * size, weight++) {
      Tensor h{};
      for (int a = 0; a < size; a++) {
        const Pack x = moved[2 * a], y = moved[2 * a + 1], along = gradient[2 * a], across = gradient[2 * a + 1];
        h.xx += x * along, h.xy += x * across, h.yx += y * along, h.yy += y * across;
      }
      const Pack here = *weight;
      const Tensor s = q < disc.full ? shear_stress<LAW>(moduli, h, here, found) : volume_stress<LAW>(moduli, h, here, found);
      for (int a = 0; a < size; a++) {
        const Pack along = gradient[2 * a], across = gradient[2 * a + 1];
        given[2 * a] += s.xx * along + s.xy * across;
        given[2 * a + 1] += s.yx * along + s.yy * across;
      }
    }
    for (int lane = 0; lane < LANES; lane++)
      for (int a = 0; a < size; a++) {
        load.x[node[a * LANES + lane]] -= given[2 * a][lane];
        load.y[node[a * LANES + lane]] -= given[2 * a + 1][lane];
      }
  }
  double energy = 0.0, det = HUGE_VAL, strain = HUGE_VAL;
  for (int lane = 0; lane < LANES; lane++) {
    energy += found.energy[lane];
    det = std::min(det, found.det[lane]), strain = std::min(strain, found.strain[lane]);
  }
  return {energy, det, std::sqrt(std::max(1.0 + 2.0 * strain, 0.0))};
}

inline Elastic add_elastic(const HalfDisc &disc, const Field &displacement, const Field &load) {
  switch (Law(disc.law)) {
    case Law::stvk: return add_elastic<Law::stvk>(disc, displacement, load);
    case Law::neo_hookean: return add_elastic<Law::neo_hookean>(disc, displacement, load);
    case Law::neo_hookean_plane_stress: return add_elastic<Law::neo_hookean_plane_stress>(disc, displacement, load);
    default: return add_elastic<Law::linear>(disc, displacement, load);
  }
}

}  // namespace core::soft_discs
