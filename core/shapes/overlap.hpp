// The volumetric law over the true overlap of two undeformed bodies, by rays from the contact: fit for a run.
//
// Paper 1, section 4, for contacts that are no ellipse. Each lobe of an overlap has the energy
//     U = f V^2 p^(1/2) / S^(7/4),   f = 0.357469 * 8 pi^(3/4) E* / 15,   load = dU/dh                          (9 before)
// with volume V, area S of its projection along the normal and that projection's perimeter p. The outline is where the surfaces
// cross: on each ray two equations f_A = f_B = 0 for distance and height. All sums around the outline are of smooth periodic
// functions, so that equal weights converge faster than any power; dV/dh = S, and with the gap's gradient g and its second
// derivative g_tt along the outline's tangent dS/dh = sum ds/g, dp/dh = sum g_tt ds/g^2. By a tilt that raises the gap by x these
// are sums over the same terms times x; their ratio dU/d(tilt) / dU/dh is where the load acts, which so conserves energy on a plane.
//
// Breaks: where the outline is no single curve around the contact, or leans so far that no normal is common to it; for patches
// far from an ellipse the law itself is a guess (a flat punch comes out 50 % too stiff).
#pragma once
#include "opposing.hpp"

namespace core {

// Energy [J], load [N], volume [m^3], area [m^2], perimeter [m], half-widths [m] and where the load acts [m] in the tangent axes;
// not `exists` where there is none.
struct Overlap {
  bool exists;
  double energy, load, volume, area, perimeter, half_width_x, half_width_y, centre_x, centre_y;
};

namespace overlap {

constexpr double ENERGY_FACTOR = 0.357469 * 8.0 / 15.0;  // times pi^(3/4)
constexpr double LEAST_COSINE = 0.3;  // tuned: least cosine between a surface's normal at the outline and the contact's
constexpr double CLOSE_STEP = 1e-5;  // of the distance: a Newton step below it leaves an error of its square
constexpr int MIN_RAYS = 12, MAX_RAYS = 768;
constexpr double RAY_TOLERANCE = 1e-5;
constexpr int RADIAL = 6;  // points of a ray, by Gauss: shares of its length and their weights
constexpr double FRACTION[RADIAL] = {0.033765242898423975, 0.16939530676686776, 0.3806904069584015,
                                     0.6193095930415985,   0.8306046932331322,  0.966234757101576};
constexpr double WEIGHT[RADIAL] = {0.08566224618958525, 0.1803807865240693, 0.23395696728634552,
                                   0.23395696728634552, 0.1803807865240693, 0.08566224618958525};

// One body seen from the contact: coordinates (x, y, z) along the tangent axes and the normal.
class Side {
 public:
  Side(const MovingSurface &body, const Real3 &origin, const TangentAxes &axes, const Real3 &normal)
      : surface(body.surface),
        origin(body.from_fixed(origin - body.position)),
        x_axis(body.from_fixed(axes.x)),
        y_axis(body.from_fixed(axes.y)),
        z_axis(body.from_fixed(normal)) {}

  double value, slope_x, slope_y, rise;  // of the function at the last point

  void evaluate(double x, double y, double z) {
    point_level = level(surface, origin + x * x_axis + y * y_axis + z * z_axis);
    value = point_level.value, slope_x = dot(point_level.gradient, x_axis), slope_y = dot(point_level.gradient, y_axis),
    rise = dot(point_level.gradient, z_axis);
  }
  // Height of the surface over (x, y), from a near one, where the bodies overlap by `thick`.
  double height(double x, double y, double z, double thick) {
    for (int i = 0; i < 8; i++) {
      evaluate(x, y, z);
      double change = value / rise;
      z -= change;
      if (std::fabs(change) < CLOSE_STEP * thick) break;
    }
    return z;
  }
  // Second derivative of the surface's height along the unit tangent (x, y).
  double second_derivative(double x, double y) const {
    double slope = -(x * slope_x + y * slope_y) / rise;
    Real3 along = x * x_axis + y * y_axis + slope * z_axis;
    return -dot(along, point_level.hesse * along) / rise;
  }
  bool leans() const { return rise * rise < LEAST_COSINE * LEAST_COSINE * dot(point_level.gradient, point_level.gradient); }

 private:
  const Surface &surface;
  Real3 origin, x_axis, y_axis, z_axis;
  Level point_level;
};

// The area, and the rates of area and perimeter, by the approach and by the tilts about the origin that raise the gap by x and by y.
struct Sums {
  double volume = 0.0, perimeter = 0.0;
  Real3 area{}, area_rate{}, perimeter_rate{};

  void add(double factor, const Sums &other) {
    volume += factor * other.volume, perimeter += factor * other.perimeter;
    area = area + factor * other.area, area_rate = area_rate + factor * other.area_rate;
    perimeter_rate = perimeter_rate + factor * other.perimeter_rate;
  }
};

// Where the surfaces cross on a ray: as a share of its vector, and the height; none where the share is below zero.
struct Edge {
  double fraction, height;
};

class Outline {
 public:
  Outline(Side a, Side b, double approach) : a(a), b(b), approach(approach) {}

  double half_x = 0.0, half_y = 0.0;

  // On the ray (x, y) t by Newton's method from `edge`.
  Edge edge_on(double x, double y, Edge edge) {
    auto [t, z] = edge;
    for (int i = 0; i < 60; i++) {
      a.evaluate(t * x, t * y, z), b.evaluate(t * x, t * y, z);
      double slope_a = x * a.slope_x + y * a.slope_y, slope_b = x * b.slope_x + y * b.slope_y;
      double determinant = slope_a * b.rise - slope_b * a.rise;
      if (!(determinant < 0.0)) {  // the gap must open outward
        t *= 0.5, z *= 0.5;
        continue;
      }
      double step = (b.value * a.rise - a.value * b.rise) / determinant,
             lift = (slope_b * a.value - slope_a * b.value) / determinant;
      double bound = std::min(std::max(step, -0.6 * t), t);
      if (bound != step) lift *= bound / step;
      t += bound, z += lift;
      if (std::fabs(step) < CLOSE_STEP * t) return {t, z};
      if (!(t < 1e9)) break;
    }
    return {-1.0, z};
  }

  // Adds the ray of this angle, whose neighbour ended at `edge`; returns its end.
  Edge add_ray(double angle, Edge edge, Sums &sums) {
    double cosine = std::cos(angle), sine = std::sin(angle), x = half_x * cosine, y = half_y * sine;
    auto [t, z] = edge_on(x, y, edge);
    if (t <= 0.0) return {t, z};
    a.evaluate(t * x, t * y, z), b.evaluate(t * x, t * y, z);
    if (a.leans() || b.leans()) return {-1.0, z};
    double gap_x = a.slope_x / a.rise - b.slope_x / b.rise, gap_y = a.slope_y / a.rise - b.slope_y / b.rise;
    double steep = std::hypot(gap_x, gap_y), over_x = -half_x * sine, over_y = half_y * cosine;  // d(x, y)/d(angle)
    double change = -t * (gap_x * over_x + gap_y * over_y) / (gap_x * x + gap_y * y);
    double arc = std::hypot(t * over_x + change * x, t * over_y + change * y), tangent_x = -gap_y / steep,
           tangent_y = gap_x / steep;
    double sector = t * t * half_x * half_y;
    double bend = b.second_derivative(tangent_x, tangent_y) - a.second_derivative(tangent_x, tangent_y);
    Real3 raised{1.0, t * x, t * y}, moments{0.5, t * x / 3.0, t * y / 3.0};
    sums.perimeter += arc, sums.area = sums.area + sector * moments;
    sums.area_rate = sums.area_rate + arc / steep * raised;
    sums.perimeter_rate = sums.perimeter_rate + arc * bend / (steep * steep) * raised;
    for (int k = 0; k < RADIAL; k++) {
      double fraction = FRACTION[k], square = fraction * fraction, thick = approach * (1.0 - square), point_x = fraction * t * x,
             point_y = fraction * t * y;
      double top = a.height(point_x, point_y, 0.5 * approach + (z - 0.5 * approach) * square, thick);
      double low = b.height(point_x, point_y, -0.5 * approach + (z + 0.5 * approach) * square, thick);
      sums.volume += (top - low) * WEIGHT[k] * fraction * sector;
    }
    return {t, z};
  }

 private:
  Side a, b;
  double approach;
};

}  // namespace overlap

// The overlap of two bodies that press into each other by `approach` h > 0 [m]. `origin` lies between the opposing points,
// `normal` is outward of A there, `axes` complete it; `size` [m] is about the bodies' least radius, `modulus` E* [Pa]. Rays are
// doubled until those in between agree with the others to AGREE: the error of all together is about its square.
inline Overlap overlap_of(const MovingSurface &body_a, const MovingSurface &body_b, const Real3 &origin, const TangentAxes &axes,
                          const Real3 &normal, double approach, double size, double modulus) {
  using namespace overlap;
  Outline outline(Side(body_a, origin, axes, normal), Side(body_b, origin, axes, normal), approach);
  double guess = std::sqrt(approach * size);
  outline.half_x = outline.edge_on(1.0, 0.0, {guess, 0.0}).fraction;
  Edge first = outline.edge_on(0.0, 1.0, {guess, 0.0});
  outline.half_y = first.fraction;
  if (!(outline.half_x > 0.0 && outline.half_y > 0.0)) return {};
  auto add_rays = [&](int rays, double offset, Sums &sums) {
    Edge edge{1.0, first.height};
    for (int ray = 0; ray < rays; ray++) {
      edge = outline.add_ray(0.5 * M_PI + 2.0 * M_PI / rays * (ray + offset), edge, sums);
      if (edge.fraction <= 0.0) return false;
    }
    return true;
  };
  Sums sums;
  int rays = MIN_RAYS;
  if (!add_rays(rays, 0.0, sums)) return {};
  for (double difference = 1.0; difference >= RAY_TOLERANCE && rays < MAX_RAYS; rays *= 2) {
    Sums between;
    if (!add_rays(rays, 0.5, between)) return {};
    difference = std::max(std::fabs(sums.area[0] - between.area[0]) / sums.area[0],
                          std::fabs(sums.perimeter - between.perimeter) / sums.perimeter);
    sums.add(1.0, between);
  }
  Sums s;
  s.add(2.0 * M_PI / rays, sums);
  double energy =
      ENERGY_FACTOR * std::pow(M_PI, 0.75) * modulus * s.volume * s.volume * std::sqrt(s.perimeter) / std::pow(s.area[0], 1.75);
  Real3 growth = 2.0 / s.volume * s.area + 0.5 / s.perimeter * s.perimeter_rate - 1.75 / s.area[0] * s.area_rate;
  return {true,
          energy,
          energy * growth[0],
          s.volume,
          s.area[0],
          s.perimeter,
          outline.half_x,
          outline.half_y,
          growth[1] / growth[0],
          growth[2] / growth[0]};
}

}  // namespace core
