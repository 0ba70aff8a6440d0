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
#pragma once
#include "../math/dual.hpp"

namespace core::soft_discs {

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

}  // namespace core::soft_discs
