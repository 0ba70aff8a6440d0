// Half a disc against a rigid wall, or two of them, by explicit central differences:
//
//     M a = -integral of P grad N dA + contact,   v(n + 1/2) = v(n - 1/2) + h a(n),   u(n + 1) = u(n) + h v(n + 1/2)
//
// Kinetic energy is v(n - 1/2) M v(n + 1/2) / 2, by which the energy of a linear body is constant to round-off for any step. The
// step is limited by stability; there is no error estimate.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include "../math/dual.hpp"

namespace core::soft_discs {

// Half a disc meshed by elements, LANES of them per pack, and the elastic forces at its nodes. Lengths are in radii,
// stresses in Young's moduli and densities in that of the first disc, so that times are in r sqrt(rho/E).

// Stress and energy at one point of LANES elements; lengths in radii, stresses in Young's moduli. The laws, split in two for
// selective integration, by the displacement gradient H = F - 1:
//
//     St. Venant-Kirchhoff   W = mu E:E + (lambda/2) (tr E)^2,  E = (F^T F - 1)/2
//     neo-Hookean            W = (mu/2) (tr C - 3 - 2 ln J) + (lambda/2) (ln J)^2
//     linear                 W = mu e:e + (lambda/2) (tr e)^2,  e = sym(H)
//
// In plane stress lambda* = 2 lambda mu / (lambda + 2 mu) replaces lambda in the first and the last; the neo-Hookean disc has a
// stretch c through the thickness with mu (c^2 - 1) + lambda ln(J c) = 0 and no second part. Limits: St. Venant-Kirchhoff softens
// in compression and has no stiffness at a stretch of 1/sqrt(3).

enum class Law { stvk, neo_hookean, neo_hookean_plane_stress, linear };

struct Moduli {
  double mu, lame;
};  // shear modulus and Lame's first parameter

constexpr int NEWTON_STEPS = 30;  // at most, for the stretch through the thickness
constexpr double LEAST_DET = 1e-12;  // of det F in a logarithm; a disc with a smaller one has collapsed and its run ends

// A displacement gradient, or a first Piola-Kirchhoff stress times the weight of the point.
struct Tensor {
  Pack xx, xy, yx, yy;
};

// The energy, the least det F and the least eigenvalue of Green's strain E so far, by lanes.
struct Extremes {
  Pack energy{}, det = broadcast<Pack>(HUGE_VAL), strain = broadcast<Pack>(HUGE_VAL);
};

// Green's strain, without cancellation where it is small.
struct Strain {
  Pack e11, e22, e12;
  explicit Strain(const Tensor &h)
      : e11(h.xx + 0.5 * (h.xx * h.xx + h.yx * h.yx)),
        e22(h.yy + 0.5 * (h.xy * h.xy + h.yy * h.yy)),
        e12(0.5 * (h.xy + h.yx + h.xx * h.xy + h.yx * h.yy)) {}
  Pack least_eigenvalue() const {
    Pack difference = e11 - e22;
    return 0.5 * (e11 + e22 - square_root(difference * difference + 4.0 * e12 * e12));
  }
};

CORE_INLINE Pack det_of(const Tensor &h) { return (1.0 + h.xx) * (1.0 + h.yy) - h.xy * h.yx; }

// Logarithm g of the stretch through the thickness in plane stress, ln det F being `grown`: mu (e^2g - 1) + lambda (g +
// grown) is convex and rises with g, so that Newton's method converges from anywhere.
inline double thickness_log_stretch(const Moduli &moduli, double log_volume) {
  const auto [mu, lame] = moduli;
  double g = -lame * log_volume / (lame + 2.0 * mu);
  for (int i = 0; i < NEWTON_STEPS; i++) {
    double square = std::exp(2.0 * g), change = (mu * (square - 1.0) + lame * (g + log_volume)) / (2.0 * mu * square + lame);
    g -= change;
    if (std::fabs(change) < 1e-14) break;
  }
  return g;
}

// The part of the stress with the shear modulus; for a neo-Hookean disc in plane stress the whole stress.
template <Law LAW>
CORE_INLINE Tensor shear_stress(const Moduli &moduli, const Tensor &h, const Pack &weight, Extremes &extremes) {
  const Strain strain(h);
  const Pack det = det_of(h);
  // NaN does not change the extremes
  extremes.det = minimum(det, extremes.det), extremes.strain = minimum(strain.least_eigenvalue(), extremes.strain);
  if constexpr (LAW == Law::stvk) {
    const auto &[e11, e22, e12] = strain;
    const Pack factor = 2.0 * moduli.mu * weight;
    extremes.energy += 0.5 * factor * (e11 * e11 + e22 * e22 + 2.0 * e12 * e12);
    return {factor * ((1.0 + h.xx) * e11 + h.xy * e12), factor * ((1.0 + h.xx) * e12 + h.xy * e22),
            factor * (h.yx * e11 + (1.0 + h.yy) * e12), factor * (h.yx * e12 + (1.0 + h.yy) * e22)};
  } else if constexpr (LAW == Law::linear) {
    const Pack shear = 0.5 * (h.xy + h.yx), factor = 2.0 * moduli.mu * weight;
    extremes.energy += 0.5 * factor * (h.xx * h.xx + h.yy * h.yy + 2.0 * shear * shear);
    return {factor * h.xx, factor * shear, factor * shear, factor * h.yy};
  } else {
    const Pack volume = maximum(det, LEAST_DET), factor = moduli.mu * weight;
    Pack log_volume = each_lane(volume, [](double x) { return std::log(x); }), square = broadcast<Pack>(1.0);
    if constexpr (LAW == Law::neo_hookean_plane_stress) {
      const Pack thick = each_lane(log_volume, [&](double x) { return thickness_log_stretch(moduli, x); });
      log_volume += thick, square = each_lane(thick, [](double x) { return std::exp(2.0 * x); });
      extremes.energy += 0.5 * moduli.lame * weight * log_volume * log_volume;
    }
    const Pack ratio = square / volume;
    extremes.energy += factor * (strain.e11 + strain.e22 + 0.5 * (square - 1.0) - log_volume);  // (tr C - 3)/2 - ln J
    return {factor * (1.0 + h.xx - ratio * (1.0 + h.yy)), factor * (h.xy + ratio * h.yx), factor * (h.yx + ratio * h.xy),
            factor * (1.0 + h.yy - ratio * (1.0 + h.xx))};
  }
}

// The part of the stress with Lame's first parameter.
template <Law LAW>
CORE_INLINE Tensor volume_stress(const Moduli &moduli, const Tensor &h, const Pack &weight, Extremes &extremes) {
  if constexpr (LAW == Law::linear) {
    const Pack trace = h.xx + h.yy, stress = moduli.lame * weight * trace;
    extremes.energy += 0.5 * stress * trace;
    return {stress, Pack{}, Pack{}, stress};
  } else if constexpr (LAW == Law::neo_hookean_plane_stress) {
    extremes.det = minimum(det_of(h), extremes.det);
    return Tensor{};
  } else {
    const Pack det = det_of(h);
    extremes.det = minimum(det, extremes.det);
    if constexpr (LAW == Law::stvk) {
      const Strain strain(h);
      const Pack trace = strain.e11 + strain.e22, stress = moduli.lame * weight * trace;
      extremes.energy += 0.5 * stress * trace;
      return {stress * (1.0 + h.xx), stress * h.xy, stress * h.yx, stress * (1.0 + h.yy)};
    } else {
      const Pack volume = maximum(det, LEAST_DET), log_volume = each_lane(volume, [](double x) { return std::log(x); });
      Pack stress = moduli.lame * weight * log_volume;
      extremes.energy += 0.5 * stress * log_volume;
      stress /= volume;
      return {stress * (1.0 + h.yy), -stress * h.yx, -stress * h.xy, stress * (1.0 + h.xx)};
    }
  }
}

constexpr int MAX_SIDE = 5, MAX_POINTS = 2 * MAX_SIDE * MAX_SIDE;  // nodes along an element, Gauss points
using LoosePack = double __attribute__((vector_size(8 * LANES), aligned(8)));  // as arrays of Python have them

// In the layout of `_HalfDisc` of kinds/soft_discs/motion.py. An element has `side` squared nodes and two sets of Gauss
// points: `full` squared for the part with the shear modulus, `reduced` squared for Lame's first parameter; nodes and points
// count along the first direction fastest. The last of the `nodes` is a dummy that collects forces of lanes without an element.
// Arrays: `across`, `height`, `mass` (nodes,); `node` (blocks, side squared, LANES); `value` and `slope` of the Lagrange
// polynomials (full + reduced, side) along a direction; `inverse` of the Jacobian, reference coordinates by place (blocks,
// points, 2, 2, LANES); `weight` (blocks, points, LANES). Of the lower half of the rim, from the bottom up: `rim_node`
// (edges, side), `rim_shape` (rim_points, side), `rim_weight` (edges, rim_points) and the `rim_coordinate` of nodes (side,) on
// [-1, 1]; `axis_node` (axis_nodes,) on x = 0. Pressure is stiffness depth^exponent.
struct HalfDisc {
  std::int64_t nodes, blocks, side, full, reduced, edges, rim_points, axis_nodes, law;
  const double *across, *height, *mass;
  const std::int64_t *node;
  const double *value, *slope;
  const LoosePack *inverse, *weight;
  const std::int64_t *rim_node;
  const double *rim_shape, *rim_weight, *rim_coordinate;
  const std::int64_t *axis_node;
  double mu, lame, stiffness, exponent;

  std::int64_t points() const { return full * full + reduced * reduced; }
  double pressure(double depth) const { return stiffness * (exponent == 1.0 ? depth : std::pow(depth, exponent)); }
  // The sum of value(node) over the nodes of an edge of the rim, by their shape functions at a point.
  template <class Function>
  double on_rim(const double *shape, int edge, Function value) const {
    double sum = 0.0;
    for (int a = 0; a < side; a++) sum += shape[a] * value(rim_node[edge * side + a]);
    return sum;
  }
};

// (2, nodes): x and y of each.
struct Field {
  double *x, *y;
  Field(double *numbers, const HalfDisc &disc) : x(numbers), y(numbers + disc.nodes) {}
  void clear(const HalfDisc &disc) const { std::fill(x, x + 2 * disc.nodes, 0.0); }
};

struct Elastic {
  double energy, least_det, least_stretch;
};

// Displacements of an element's nodes, or forces on them.
struct NodeValues {
  Pack x[MAX_SIDE * MAX_SIDE], y[MAX_SIDE * MAX_SIDE];
};

// Sums over nodes factor into one along each direction of an element, with N nodes and POINTS Gauss points along it.
template <int N, int POINTS>
struct Sums {
  const double *value, *slope;  // (POINTS, N)

  // Gradients at all points by reference coordinates.
  void gradients(const NodeValues &displacement, Tensor *h) const {
    Pack by_value_x[N], by_value_y[N], by_slope_x[N], by_slope_y[N];
    for (int i = 0; i < POINTS; i++) {
      const double *v = value + i * N, *s = slope + i * N;
      for (int b = 0; b < N; b++) {
        by_value_x[b] = by_value_y[b] = by_slope_x[b] = by_slope_y[b] = Pack{};
        for (int a = 0; a < N; a++) {
          const Pack x = displacement.x[b * N + a], y = displacement.y[b * N + a];
          by_value_x[b] += v[a] * x, by_slope_x[b] += s[a] * x;
          by_value_y[b] += v[a] * y, by_slope_y[b] += s[a] * y;
        }
      }
      for (int j = 0; j < POINTS; j++) {
        const double *w = value + j * N, *t = slope + j * N;
        Tensor gradient{};
        for (int b = 0; b < N; b++) {
          gradient.xx += w[b] * by_slope_x[b], gradient.xy += t[b] * by_value_x[b];
          gradient.yx += w[b] * by_slope_y[b], gradient.yy += t[b] * by_value_y[b];
        }
        h[j * POINTS + i] = gradient;
      }
    }
  }

  // Adds forces on the nodes by stresses at all points along reference coordinates: the transpose of `gradients`.
  void add_forces(const Tensor *stress, NodeValues &nodal_force) const {
    for (int i = 0; i < POINTS; i++) {
      const double *v = value + i * N, *s = slope + i * N;
      for (int b = 0; b < N; b++) {
        Pack by_value_x{}, by_value_y{}, by_slope_x{}, by_slope_y{};
        for (int j = 0; j < POINTS; j++) {
          const double w = value[j * N + b], t = slope[j * N + b];
          const Tensor &s_point = stress[j * POINTS + i];
          by_slope_x += w * s_point.xx, by_value_x += t * s_point.xy;
          by_slope_y += w * s_point.yx, by_value_y += t * s_point.yy;
        }
        for (int a = 0; a < N; a++) {
          nodal_force.x[b * N + a] += s[a] * by_slope_x + v[a] * by_value_x;
          nodal_force.y[b * N + a] += s[a] * by_slope_y + v[a] * by_value_y;
        }
      }
    }
  }
};

// The stresses at all points of the elements of a block, along reference coordinates, from gradients by these.
template <Law LAW>
void set_stresses(const HalfDisc &disc, int block, Tensor *tensor, Extremes &extremes) {
  const Moduli moduli{disc.mu, disc.lame};
  const int full = int(disc.full * disc.full), points = int(disc.points());
  const LoosePack *inverse = disc.inverse + std::int64_t(block) * points * 4, *weight = disc.weight + std::int64_t(block) * points;
  for (int q = 0; q < points; q++, inverse += 4) {
    const Tensor g = tensor[q];
    const Pack xx = inverse[0], xy = inverse[1], yx = inverse[2], yy = inverse[3], point_weight = weight[q];
    const Tensor h{g.xx * xx + g.xy * yx, g.xx * xy + g.xy * yy, g.yx * xx + g.yy * yx, g.yx * xy + g.yy * yy};
    const Tensor s =
        q < full ? shear_stress<LAW>(moduli, h, point_weight, extremes) : volume_stress<LAW>(moduli, h, point_weight, extremes);
    tensor[q] = {s.xx * xx + s.xy * xy, s.xx * yx + s.xy * yy, s.yx * xx + s.yy * xy, s.yx * yx + s.yy * yy};
  }
}

inline void set_stresses(const HalfDisc &disc, int block, Tensor *tensor, Extremes &extremes) {
  switch (Law(disc.law)) {
    case Law::stvk: return set_stresses<Law::stvk>(disc, block, tensor, extremes);
    case Law::neo_hookean: return set_stresses<Law::neo_hookean>(disc, block, tensor, extremes);
    case Law::neo_hookean_plane_stress: return set_stresses<Law::neo_hookean_plane_stress>(disc, block, tensor, extremes);
    default: return set_stresses<Law::linear>(disc, block, tensor, extremes);
  }
}

// Subtracts the elastic forces from `load`; returns the energy, least det F and least stretch of the half disc.
template <int N, int REDUCED>
Elastic add_elastic(const HalfDisc &disc, const Field &displacement, const Field &load) {
  const Sums<N, N> full{disc.value, disc.slope};
  const Sums<N, REDUCED> reduced{disc.value + N * N, disc.slope + N * N};
  NodeValues displacements{}, forces;
  Tensor tensors[MAX_POINTS];
  Extremes extremes;
  const std::int64_t *node = disc.node;
  for (int block = 0; block < disc.blocks; block++, node += N * N * LANES) {
    for (int a = 0; a < N * N; a++)
      for (int lane = 0; lane < LANES; lane++) {
        displacements.x[a][lane] = displacement.x[node[a * LANES + lane]];
        displacements.y[a][lane] = displacement.y[node[a * LANES + lane]];
      }
    full.gradients(displacements, tensors), reduced.gradients(displacements, tensors + N * N);
    set_stresses(disc, block, tensors, extremes);
    std::fill(forces.x, forces.x + N * N, Pack{}), std::fill(forces.y, forces.y + N * N, Pack{});
    full.add_forces(tensors, forces), reduced.add_forces(tensors + N * N, forces);
    for (int lane = 0; lane < LANES; lane++)
      for (int a = 0; a < N * N; a++) {
        load.x[node[a * LANES + lane]] -= forces.x[a][lane];
        load.y[node[a * LANES + lane]] -= forces.y[a][lane];
      }
  }
  double energy = 0.0, det = HUGE_VAL, strain = HUGE_VAL;
  for (int lane = 0; lane < LANES; lane++) {
    energy += extremes.energy[lane];
    det = std::min(det, extremes.det[lane]), strain = std::min(strain, extremes.strain[lane]);
  }
  return {energy, det, std::sqrt(std::max(1.0 + 2.0 * strain, 0.0))};
}

inline Elastic add_elastic(const HalfDisc &disc, const Field &displacement, const Field &load) {
  const bool same = disc.reduced == disc.full;
  switch (disc.side) {
    case 2: return same ? add_elastic<2, 2>(disc, displacement, load) : add_elastic<2, 1>(disc, displacement, load);
    case 3: return same ? add_elastic<3, 3>(disc, displacement, load) : add_elastic<3, 2>(disc, displacement, load);
    case 4: return same ? add_elastic<4, 4>(disc, displacement, load) : add_elastic<4, 3>(disc, displacement, load);
    default: return same ? add_elastic<5, 5>(disc, displacement, load) : add_elastic<5, 4>(disc, displacement, load);
  }
}

// The contact of a half disc with a wall, y = 0, or with another, by a penalty pressure on overlapping rims.
//
// On a point of the rim at a depth d below the wall acts a pressure k d^m per undeformed length. Each of two discs has its own
// frame, y away from the other. They overlap by g = -(y + y'(x)) at the same x, and the energy is the mean of the integrals of
// k g^(m+1)/(m+1) over both undeformed rims. Forces are its derivatives, so that energy is conserved and forces are opposite for any
// meshes. For equal discs this is the contact with a wall. Limit: the rim must be a graph over x, as it is far beyond the contact.

constexpr int ROOT_STEPS = 60;  // at most, for the position on an edge: as many as bisection alone needs
constexpr double NEAR = 0.01;  // radii: upper bound of the depth of a rim below its nodes

// The force on the half disc, its energy and its greatest depth.
struct ContactSum {
  double force = 0.0, energy = 0.0, depth = 0.0;

  void add(const ContactSum &second) { force += second.force, energy += second.energy, depth = std::max(depth, second.depth); }
  // Adds a point with this force and depth.
  void add_point(double point_force, double depth, double exponent) {
    add({point_force, point_force * depth / (exponent + 1.0), depth});
  }
};

// Adds the pressure of the wall to `load`.
inline ContactSum wall_contact(const HalfDisc &disc, const Field &displacement, const Field &load) {
  ContactSum sum;
  for (int edge = 0; edge < disc.edges; edge++)
    for (int point = 0; point < disc.rim_points; point++) {
      const double *shape = disc.rim_shape + point * disc.side;
      const double height = disc.on_rim(shape, edge, [&](std::int64_t n) { return disc.height[n] + displacement.y[n]; });
      if (!(height < 0.0)) continue;
      const double point_force = disc.pressure(-height) * disc.rim_weight[edge * disc.rim_points + point];
      sum.add_point(point_force, -height, disc.exponent);
      for (int a = 0; a < disc.side; a++) load.y[disc.rim_node[edge * disc.side + a]] += point_force * shape[a];
    }
  return sum;
}

// The rim of a disc as a graph over x.
class Rim {
 public:
  double lowest = HUGE_VAL;  // of its nodes
  double shape[MAX_SIDE];  // shape functions of the nodes of the present edge at x

  Rim(const HalfDisc &disc, const Field &displacement) : disc(disc), displacement(displacement) {
    for (int i = 0; i < disc.edges * disc.side; i++) lowest = std::min(lowest, y(disc.rim_node[i]));
  }
  double x(std::int64_t node) const { return disc.across[node] + displacement.x[node]; }
  double y(std::int64_t node) const { return disc.height[node] + displacement.y[node]; }

  // Finds the edge at x, starting from the present one; false beyond the end of the rim.
  bool find(double target) {
    while (edge < disc.edges - 1 && end_of(edge) < target) edge++;
    while (edge > 0 && end_of(edge - 1) > target) edge--;
    return !(end_of(edge) < target);
  }
  const std::int64_t *edge_node() const { return disc.rim_node + edge * disc.side; }

  // Height and slope dy/dx of the present edge at x, by Newton's method within a bracket.
  struct Point {
    double height, slope;
  };
  Point point_at(double target) {
    double low = -1.0, high = 1.0, coordinate = 0.0, height = 0.0, dx = 1.0, dy = 0.0;
    for (int i = 0; i < ROOT_STEPS; i++) {
      set_shapes(coordinate);
      const double position = sum(shape, &Rim::x);
      height = sum(shape, &Rim::y), dx = sum(slope, &Rim::x), dy = sum(slope, &Rim::y);
      const double distance = position - target, change = dx > 0.0 ? distance / dx : 2.0;
      (distance > 0.0 ? high : low) = coordinate;
      if (std::fabs(change) < 1e-14) break;
      coordinate -= change;
      if (!(low <= coordinate && coordinate <= high)) coordinate = 0.5 * (low + high);
    }
    return {height, dy / dx};
  }

 private:
  const HalfDisc &disc;
  const Field &displacement;
  int edge = 0;
  double slope[MAX_SIDE];

  double end_of(int edge) const { return x(disc.rim_node[(edge + 1) * disc.side - 1]); }
  double sum(const double *weight, double (Rim::*value)(std::int64_t) const) const {
    return disc.on_rim(weight, edge, [&](std::int64_t node) { return (this->*value)(node); });
  }
  // Values and slopes of the Lagrange polynomials on the nodes of an edge.
  void set_shapes(double coordinate) {
    const double *nodes = disc.rim_coordinate;
    for (int a = 0; a < disc.side; a++) {
      shape[a] = 1.0, slope[a] = 0.0;
      for (int b = 0; b < disc.side; b++) {
        if (b == a) continue;
        const double scale = 1.0 / (nodes[a] - nodes[b]);
        slope[a] = (slope[a] * (coordinate - nodes[b]) + shape[a]) * scale;
        shape[a] *= (coordinate - nodes[b]) * scale;
      }
    }
  }
};

// Adds the forces of the points of the rim of `disc` to `load` and, on the `opposite` disc, to `opposite_load`.
inline ContactSum rim_contact(const HalfDisc &disc, const Field &displacement, const Field &load, const HalfDisc &opposite,
                              const Field &opposite_displacement, const Field &opposite_load) {
  ContactSum sum;
  Rim rim(opposite, opposite_displacement);
  for (int edge = 0; edge < disc.edges; edge++)
    for (int point = 0; point < disc.rim_points; point++) {
      const double *shape = disc.rim_shape + point * disc.side;
      const std::int64_t *node = disc.rim_node + edge * disc.side;
      const double x = disc.on_rim(shape, edge, [&](std::int64_t n) { return disc.across[n] + displacement.x[n]; });
      const double y = disc.on_rim(shape, edge, [&](std::int64_t n) { return disc.height[n] + displacement.y[n]; });
      if (y + rim.lowest > NEAR || !rim.find(x)) continue;
      const Rim::Point opposite_point = rim.point_at(x);
      const double depth = -(y + opposite_point.height);
      if (!(depth > 0.0)) continue;
      const double point_force = 0.5 * disc.pressure(depth) * disc.rim_weight[edge * disc.rim_points + point];
      sum.add_point(point_force, depth, disc.exponent);
      for (int a = 0; a < disc.side; a++) {
        const double node_force = point_force * shape[a];
        load.x[node[a]] += node_force * opposite_point.slope, load.y[node[a]] += node_force;
      }
      for (int a = 0; a < opposite.side; a++) {
        const double node_force = point_force * rim.shape[a];
        opposite_load.x[rim.edge_node()[a]] -= node_force * opposite_point.slope, opposite_load.y[rim.edge_node()[a]] += node_force;
      }
    }
  return sum;
}

}  // namespace core::soft_discs

using namespace core;
using namespace core::soft_discs;

namespace {

// A disc in motion, (2, nodes): displacement, velocity half a step before, and forces.
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
struct StepSums {
  double kinetic = 0.0, momentum = 0.0, gained = 0.0, moment = 0.0;
};

// One step by the forces on the disc.
StepSums advance(Disc &disc, double step) {
  StepSums sums;
  for (int i = 0; i < disc.body.axis_nodes; i++) disc.load.x[disc.body.axis_node[i]] = 0.0;
  for (int n = 0; n < disc.body.nodes - 1; n++) {
    const double mass = disc.body.mass[n], x = disc.velocity.x[n], y = disc.velocity.y[n];
    const double after_x = x + step * disc.load.x[n] / mass, after_y = y + step * disc.load.y[n] / mass;
    disc.velocity.x[n] = after_x, disc.velocity.y[n] = after_y;
    sums.kinetic += mass * (x * after_x + y * after_y);
    sums.momentum += 0.5 * mass * (y + after_y);
    sums.gained += disc.load.y[n];
    sums.moment += mass * (disc.body.height[n] + disc.displacement.y[n]);
    disc.displacement.x[n] += step * after_x, disc.displacement.y[n] += step * after_y;
  }
  return sums;
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

// One step and its row of the history; false where an element is inverted, for which the law is not defined.
class History {
 public:
  History(Disc &disc, Disc *opposite, double step)
      : disc(disc),
        opposite(opposite),
        step(step),
        mass(mass_of(disc.body)),
        opposite_mass(opposite ? mass_of(opposite->body) : 0.0) {}

  bool make(Row &row) {
    Elastic elastic = disc.load_elastic();
    ContactSum contact;
    row = {};
    if (opposite) {
      const Elastic second = opposite->load_elastic();
      elastic = {elastic.energy + second.energy, std::min(elastic.least_det, second.least_det),
                 std::min(elastic.least_stretch, second.least_stretch)};
      contact = rim_contact(disc.body, disc.displacement, disc.load, opposite->body, opposite->displacement, opposite->load);
      contact.add(rim_contact(opposite->body, opposite->displacement, opposite->load, disc.body, disc.displacement, disc.load));
      const StepSums sums = advance(*opposite, step);
      row.kinetic = sums.kinetic, row.balance = std::fabs(contact.force - sums.gained);
      row.other_position = sums.moment / opposite_mass, row.other_velocity = sums.momentum / opposite_mass;
    } else {
      contact = wall_contact(disc.body, disc.displacement, disc.load);
    }
    const StepSums sums = advance(disc, step);
    row.force = 2.0 * contact.force, row.position = sums.moment / mass, row.velocity = sums.momentum / mass;
    row.kinetic += sums.kinetic, row.elastic = 2.0 * elastic.energy, row.contact = 2.0 * contact.energy;
    row.depth = contact.depth, row.least_stretch = elastic.least_stretch, row.least_det = elastic.least_det;
    row.balance = 2.0 * std::max(row.balance, std::fabs(contact.force - sums.gained));
    return elastic.least_det > 0.0 || Law(disc.body.law) == Law::linear;
  }

 private:
  Disc &disc, *opposite;
  const double step, mass, opposite_mass;
};

}  // namespace

// Fills the rows of `history` (rows, 12), the first of them at step number `first`; returns their number, less than `rows` where an
// element is inverted in the last one. `state` (3, 2, nodes) is advanced in place. `opposite` is null for a wall. `shapes` (frames,
// discs, 2, nodes) are the displacements at steps divisible by `interval`.
CORE_EXPORT std::int64_t core_soft_discs_march(const HalfDisc *body, double *state, const HalfDisc *opposite,
                                               double *opposite_state, double step, std::int64_t rows, double *history,
                                               std::int64_t frames, double *shapes, std::int64_t interval, std::int64_t first) {
  Disc disc(body, state), second(opposite ? opposite : body, opposite_state);
  History march(disc, opposite ? &second : nullptr, step);
  const std::int64_t shape = 2 * body->nodes;
  Row *row = reinterpret_cast<Row *>(history);
  for (std::int64_t i = 0; i < rows; i++, row++) {
    const std::int64_t frame = (first + i) / interval;
    if ((first + i) % interval == 0 && frame < frames) {
      double *out = shapes + frame * shape * (opposite ? 2 : 1);
      std::copy(disc.displacement.x, disc.displacement.x + shape, out);
      if (opposite) std::copy(second.displacement.x, second.displacement.x + shape, out + shape);
    }
    if (!march.make(*row)) return i + 1;
  }
  return rows;
}

// Subtracts the elastic forces from `load` (2, nodes); fills the energy, the least det F and the least stretch.
CORE_EXPORT void core_soft_discs_elastic(const HalfDisc *body, double *displacement, double *load, double *out) {
  const Elastic elastic = add_elastic(*body, {displacement, *body}, {load, *body});
  out[0] = elastic.energy, out[1] = elastic.least_det, out[2] = elastic.least_stretch;
}

// The forces against a small displacement (2, nodes) of a linear disc whose whole rim is in contact with the wall; for the exponent
// m = 1 the stiffness is k, for others that at a depth of one radius.
CORE_EXPORT void core_soft_discs_stiffness(const HalfDisc *body, double *displacement, double *load_numbers) {
  const HalfDisc &disc = *body;
  const Field field(displacement, disc), load(load_numbers, disc);
  load.clear(disc);
  add_elastic(disc, field, load);
  for (int edge = 0; edge < disc.edges; edge++)
    for (int point = 0; point < disc.rim_points; point++) {
      const double *shape = disc.rim_shape + point * disc.side;
      for (auto [values, forces] : {std::pair{field.x, load.x}, std::pair{field.y, load.y}}) {
        const double depth = disc.on_rim(shape, edge, [&, values = values](std::int64_t n) { return values[n]; });
        const double point_force = disc.stiffness * disc.rim_weight[edge * disc.rim_points + point] * depth;
        for (int a = 0; a < disc.side; a++) forces[disc.rim_node[edge * disc.side + a]] -= point_force * shape[a];
      }
    }
}
