// Coulomb friction in the contact plane, regularised by a speed v_s [m/s], at the contact point or over its patch.
#pragma once
#include "patch_friction.hpp"

namespace core {

// Resistance f [N s/m] of the force -f * slip at a point, where `square` is slip^2: f = mu N/sqrt(slip^2 + v_s^2). The force
// grows linearly with slip, reaches 71 % of mu N at v_s, and mu N far above it; true sticking creeps.
template <class L, class S>
CORE_INLINE auto point_resistance(const L &limit, const S &square, double regularisation) {
  auto smooth = square + regularisation * regularisation;
  return limit * root_and_inverse(smooth).second;
}

// From its numbers as `contact/friction.py` writes them, and the points of its quadrature (points, 3), x, y and share.
constexpr int FRICTION_NUMBERS = 5;
inline PatchFriction patch_friction_of(const double *numbers, const double *points) {
  return {FrictionModel(int(numbers[0])), numbers[1], numbers[2], numbers[3], int(numbers[4]), points};
}

// Friction on the slipping body along the patch's axes [N], and about the normal [N m].
struct PatchForce { double force_major, force_minor, torque; };

// By a model, for the semi-axes [m] of the patch, slip [m/s] along them and spin [rad/s] about the normal.
inline PatchForce contact_friction(const PatchFriction &friction, double regularisation, double normal_load, double semi_major,
                                   double semi_minor, double slip_major, double slip_minor, double spin) {
  double limit = -friction.coefficient * normal_load;
  if (!(normal_load > 0.0)) return {0.0, 0.0, 0.0};
  if (friction.model == FrictionModel::point) {
    double resistance = point_resistance(limit, slip_major * slip_major + slip_minor * slip_minor + 1e-300, regularisation);
    return {resistance * slip_major, resistance * slip_minor, 0.0};
  }
  auto [along, across, moment] = patch_means(friction, regularisation, semi_major, semi_minor, slip_major, slip_minor, spin);
  return {limit * along, limit * across, limit * moment};
}

}  // namespace core
