// Half a disc against a rigid wall, or two of them, by explicit central differences:
//
//     M a = -integral of P grad N dA + contact,   v(n + 1/2) = v(n - 1/2) + h a(n),   u(n + 1) = u(n) + h v(n + 1/2)
//
// Kinetic energy is v(n - 1/2) M v(n + 1/2) / 2: with it the energy of a linear body is constant to round-off, whatever the
// step, which stability sets and no error estimate.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include "../math/dual.hpp"

namespace core::soft_discs {

// Half a disc cut into elements, LANES of them side by side, and the forces of elasticity at its nodes. Lengths are in radii,
// stresses in Young's moduli and densities in that of the first disc, so that times are in r sqrt(rho/E).

// Stress and energy at one point of LANES elements side by side; lengths in radii, stresses in Young's moduli. The laws, cut
// in two for selective integration, by the displacement gradient H = F - 1:
//
//     St. Venant-Kirchhoff   W = mu E:E + (lambda/2) (tr E)^2,  E = (F^T F - 1)/2
//     neo-Hookean            W = (mu/2) (tr C - 3 - 2 ln J) + (lambda/2) (ln J)^2
//     linear                 W = mu e:e + (lambda/2) (tr e)^2,  e = sym(H)
//
// In plane stress the first and the last take lambda* = 2 lambda mu / (lambda + 2 mu) for lambda; the neo-Hookean disc finds
// its stretch c through the thickness from mu (c^2 - 1) + lambda ln(J c) = 0 and has no second part. Breaks: St.
// Venant-Kirchhoff softens in compression and has no stiffness left at a stretch of 1/sqrt(3).

enum class Law { stvk, neo_hookean, neo_hookean_plane_stress, linear };

struct Moduli { double mu, lame; };  // shear modulus and Lame's first parameter

constexpr int NEWTON_STEPS = 30;  // at most, for the stretch through the thickness
constexpr double LEAST = 1e-12;  // det F in a logarithm; a disc with less has collapsed and is not gone on with

template <class Function>
CORE_INLINE Pack by_lanes(Pack x, Function function) {
  for (int lane = 0; lane < LANES; lane++) x[lane] = function(x[lane]);
  return x;
}

// A displacement gradient, or a first Piola-Kirchhoff stress times the weight of the point.
struct Tensor { Pack xx, xy, yx, yy; };

// The energy, the least det F and the least eigenvalue of Green's strain E so far, by lanes.
struct Found { Pack energy{}, det = broadcast<Pack>(HUGE_VAL), strain = broadcast<Pack>(HUGE_VAL); };

// Green's strain, with all digits where it is small.
struct Strain {
  Pack e11, e22, e12;
  explicit Strain(const Tensor &h)
      : e11(h.xx + 0.5 * (h.xx * h.xx + h.yx * h.yx)), e22(h.yy + 0.5 * (h.xy * h.xy + h.yy * h.yy)),
        e12(0.5 * (h.xy + h.yx + h.xx * h.xy + h.yx * h.yy)) {}
  Pack least_eigenvalue() const {
    Pack difference = e11 - e22;
    return 0.5 * (e11 + e22 - square_root(difference * difference + 4.0 * e12 * e12));
  }
};

CORE_INLINE Pack det_of(const Tensor &h) { return (1.0 + h.xx) * (1.0 + h.yy) - h.xy * h.yx; }

// Logarithm g of the stretch through the thickness in plane stress, ln det F being `grown`: mu (e^2g - 1) + lambda (g +
// grown) is convex and rises with g, so that Newton's method converges from anywhere.
inline double thickening(const Moduli &moduli, double grown) {
  const auto [mu, lame] = moduli;
  double g = -lame * grown / (lame + 2.0 * mu);
  for (int i = 0; i < NEWTON_STEPS; i++) {
    double square = std::exp(2.0 * g), change = (mu * (square - 1.0) + lame * (g + grown)) / (2.0 * mu * square + lame);
    g -= change;
    if (std::fabs(change) < 1e-14) break;
  }
  return g;
}

// The part of the stress with the shear modulus; of a neo-Hookean disc in plane stress, all.
template <Law LAW>
CORE_INLINE Tensor shear_stress(const Moduli &moduli, const Tensor &h, const Pack &weight, Found &found) {
  const Strain strain(h);
  const Pack det = det_of(h);
  // a number that is none changes nothing
  found.det = minimum(det, found.det), found.strain = minimum(strain.least_eigenvalue(), found.strain);
  if constexpr (LAW == Law::stvk) {
    const auto &[e11, e22, e12] = strain;
    const Pack factor = 2.0 * moduli.mu * weight;
    found.energy += 0.5 * factor * (e11 * e11 + e22 * e22 + 2.0 * e12 * e12);
    return {factor * ((1.0 + h.xx) * e11 + h.xy * e12), factor * ((1.0 + h.xx) * e12 + h.xy * e22),
            factor * (h.yx * e11 + (1.0 + h.yy) * e12), factor * (h.yx * e12 + (1.0 + h.yy) * e22)};
  } else if constexpr (LAW == Law::linear) {
    const Pack shear = 0.5 * (h.xy + h.yx), factor = 2.0 * moduli.mu * weight;
    found.energy += 0.5 * factor * (h.xx * h.xx + h.yy * h.yy + 2.0 * shear * shear);
    return {factor * h.xx, factor * shear, factor * shear, factor * h.yy};
  } else {
    const Pack volume = maximum(det, LEAST), factor = moduli.mu * weight;
    Pack grown = by_lanes(volume, [](double one) { return std::log(one); }), square = broadcast<Pack>(1.0);
    if constexpr (LAW == Law::neo_hookean_plane_stress) {
      const Pack thick = by_lanes(grown, [&](double one) { return thickening(moduli, one); });
      grown += thick, square = by_lanes(thick, [](double one) { return std::exp(2.0 * one); });
      found.energy += 0.5 * moduli.lame * weight * grown * grown;
    }
    const Pack share = square / volume;
    found.energy += factor * (strain.e11 + strain.e22 + 0.5 * (square - 1.0) - grown);  // (tr C - 3)/2 - ln J
    return {factor * (1.0 + h.xx - share * (1.0 + h.yy)), factor * (h.xy + share * h.yx),
            factor * (h.yx + share * h.xy), factor * (1.0 + h.yy - share * (1.0 + h.xx))};
  }
}

// The part of the stress with Lame's first parameter.
template <Law LAW>
CORE_INLINE Tensor volume_stress(const Moduli &moduli, const Tensor &h, const Pack &weight, Found &found) {
  if constexpr (LAW == Law::linear) {
    const Pack trace = h.xx + h.yy, share = moduli.lame * weight * trace;
    found.energy += 0.5 * share * trace;
    return {share, Pack{}, Pack{}, share};
  } else if constexpr (LAW == Law::neo_hookean_plane_stress) {
    found.det = minimum(det_of(h), found.det);
    return Tensor{};
  } else {
    const Pack det = det_of(h);
    found.det = minimum(det, found.det);
    if constexpr (LAW == Law::stvk) {
      const Strain strain(h);
      const Pack trace = strain.e11 + strain.e22, share = moduli.lame * weight * trace;
      found.energy += 0.5 * share * trace;
      return {share * (1.0 + h.xx), share * h.xy, share * h.yx, share * (1.0 + h.yy)};
    } else {
      const Pack volume = maximum(det, LEAST), grown = by_lanes(volume, [](double one) { return std::log(one); });
      Pack share = moduli.lame * weight * grown;
      found.energy += 0.5 * share * grown;
      share /= volume;
      return {share * (1.0 + h.yy), -share * h.yx, -share * h.xy, share * (1.0 + h.xx)};
    }
  }
}

constexpr int MOST_SIDE = 5, MOST_POINTS = 2 * MOST_SIDE * MOST_SIDE;  // nodes along an element, Gauss points
using LoosePack = double __attribute__((vector_size(8 * LANES), aligned(8)));  // as arrays of Python have them

// As Python hands it over (`_HalfDisc` of kinds/soft_discs/motion.py). An element has `side` squared nodes and two sets of Gauss
// points: `full` squared for the part with the shear modulus, `reduced` squared for Lame's first parameter; nodes and points
// count along the first direction fastest. The last of the `nodes` is none: it takes what lanes without an element give.
// Arrays: `across`, `height`, `mass` (nodes,); `node` (blocks, side squared, LANES); `value` and `slope` of the Lagrange
// polynomials (full + reduced, side) along a direction; `inverse` of the Jacobian, reference coordinates by place (blocks,
// points, 2, 2, LANES); `weight` (blocks, points, LANES). Of the lower half of the rim, from the bottom up: `rim_node`
// (edges, side), `rim_shape` (rim_points, side), `rim_weight` (edges, rim_points) and the `rim_place` of nodes (side,) on
// [-1, 1]; `axis_node` (axis_nodes,) on x = 0. Pressure is stiffness depth^exponent.
struct HalfDisc {
  std::int64_t nodes, blocks, side, full, reduced, edges, rim_points, axis_nodes, law;
  const double *across, *height, *mass;
  const std::int64_t *node;
  const double *value, *slope;
  const LoosePack *inverse, *weight;
  const std::int64_t *rim_node;
  const double *rim_shape, *rim_weight, *rim_place;
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

struct Elastic { double energy, least_det, least_stretch; };

// Displacements of an element's nodes, or forces on them.
struct NodeValues { Pack x[MOST_SIDE * MOST_SIDE], y[MOST_SIDE * MOST_SIDE]; };

// Sums over nodes factor into one along each direction of an element, with N nodes and POINTS Gauss points along it.
template <int N, int POINTS>
struct Sums {
  const double *value, *slope;  // (POINTS, N)

  // Gradients at all points by reference coordinates.
  void gradients(const NodeValues &moved, Tensor *h) const {
    Pack by_value_x[N], by_value_y[N], by_slope_x[N], by_slope_y[N];
    for (int i = 0; i < POINTS; i++) {
      const double *v = value + i * N, *s = slope + i * N;
      for (int b = 0; b < N; b++) {
        by_value_x[b] = by_value_y[b] = by_slope_x[b] = by_slope_y[b] = Pack{};
        for (int a = 0; a < N; a++) {
          const Pack x = moved.x[b * N + a], y = moved.y[b * N + a];
          by_value_x[b] += v[a] * x, by_slope_x[b] += s[a] * x;
          by_value_y[b] += v[a] * y, by_slope_y[b] += s[a] * y;
        }
      }
      for (int j = 0; j < POINTS; j++) {
        const double *w = value + j * N, *t = slope + j * N;
        Tensor found{};
        for (int b = 0; b < N; b++) {
          found.xx += w[b] * by_slope_x[b], found.xy += t[b] * by_value_x[b];
          found.yx += w[b] * by_slope_y[b], found.yy += t[b] * by_value_y[b];
        }
        h[j * POINTS + i] = found;
      }
    }
  }

  // Adds forces on the nodes by stresses at all points along reference coordinates: the transpose of `gradients`.
  void add_forces(const Tensor *stress, NodeValues &given) const {
    for (int i = 0; i < POINTS; i++) {
      const double *v = value + i * N, *s = slope + i * N;
      for (int b = 0; b < N; b++) {
        Pack by_value_x{}, by_value_y{}, by_slope_x{}, by_slope_y{};
        for (int j = 0; j < POINTS; j++) {
          const double w = value[j * N + b], t = slope[j * N + b];
          const Tensor &one = stress[j * POINTS + i];
          by_slope_x += w * one.xx, by_value_x += t * one.xy;
          by_slope_y += w * one.yx, by_value_y += t * one.yy;
        }
        for (int a = 0; a < N; a++) {
          given.x[b * N + a] += s[a] * by_slope_x + v[a] * by_value_x;
          given.y[b * N + a] += s[a] * by_slope_y + v[a] * by_value_y;
        }
      }
    }
  }
};

// The stresses at all points of the elements of a block, along reference coordinates, from gradients by these.
template <Law LAW>
void set_stresses(const HalfDisc &disc, int block, Tensor *at, Found &found) {
  const Moduli moduli{disc.mu, disc.lame};
  const int full = int(disc.full * disc.full), points = int(disc.points());
  const LoosePack *inverse = disc.inverse + std::int64_t(block) * points * 4, *weight = disc.weight + std::int64_t(block) * points;
  for (int q = 0; q < points; q++, inverse += 4) {
    const Tensor g = at[q];
    const Pack xx = inverse[0], xy = inverse[1], yx = inverse[2], yy = inverse[3], here = weight[q];
    const Tensor h{g.xx * xx + g.xy * yx, g.xx * xy + g.xy * yy, g.yx * xx + g.yy * yx, g.yx * xy + g.yy * yy};
    const Tensor s = q < full ? shear_stress<LAW>(moduli, h, here, found) : volume_stress<LAW>(moduli, h, here, found);
    at[q] = {s.xx * xx + s.xy * xy, s.xx * yx + s.xy * yy, s.yx * xx + s.yy * xy, s.yx * yx + s.yy * yy};
  }
}

inline void set_stresses(const HalfDisc &disc, int block, Tensor *at, Found &found) {
  switch (Law(disc.law)) {
    case Law::stvk: return set_stresses<Law::stvk>(disc, block, at, found);
    case Law::neo_hookean: return set_stresses<Law::neo_hookean>(disc, block, at, found);
    case Law::neo_hookean_plane_stress: return set_stresses<Law::neo_hookean_plane_stress>(disc, block, at, found);
    default: return set_stresses<Law::linear>(disc, block, at, found);
  }
}

// Takes the forces of elasticity off `load`; returns the energy, least det F and least stretch of the half disc.
template <int N, int REDUCED>
Elastic add_elastic(const HalfDisc &disc, const Field &displacement, const Field &load) {
  const Sums<N, N> full{disc.value, disc.slope};
  const Sums<N, REDUCED> reduced{disc.value + N * N, disc.slope + N * N};
  NodeValues moved{}, given;
  Tensor at[MOST_POINTS];
  Found found;
  const std::int64_t *node = disc.node;
  for (int block = 0; block < disc.blocks; block++, node += N * N * LANES) {
    for (int a = 0; a < N * N; a++)
      for (int lane = 0; lane < LANES; lane++) {
        moved.x[a][lane] = displacement.x[node[a * LANES + lane]];
        moved.y[a][lane] = displacement.y[node[a * LANES + lane]];
      }
    full.gradients(moved, at), reduced.gradients(moved, at + N * N);
    set_stresses(disc, block, at, found);
    std::fill(given.x, given.x + N * N, Pack{}), std::fill(given.y, given.y + N * N, Pack{});
    full.add_forces(at, given), reduced.add_forces(at + N * N, given);
    for (int lane = 0; lane < LANES; lane++)
      for (int a = 0; a < N * N; a++) {
        load.x[node[a * LANES + lane]] -= given.x[a][lane];
        load.y[node[a * LANES + lane]] -= given.y[a][lane];
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
  const bool same = disc.reduced == disc.full;
  switch (disc.side) {
    case 2: return same ? add_elastic<2, 2>(disc, displacement, load) : add_elastic<2, 1>(disc, displacement, load);
    case 3: return same ? add_elastic<3, 3>(disc, displacement, load) : add_elastic<3, 2>(disc, displacement, load);
    case 4: return same ? add_elastic<4, 4>(disc, displacement, load) : add_elastic<4, 3>(disc, displacement, load);
    default: return same ? add_elastic<5, 5>(disc, displacement, load) : add_elastic<5, 4>(disc, displacement, load);
  }
}

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
