// Parameters of the equations of motion of a bearing, in SI units.
//
// Frames. `bearing_link` has its origin at the outer ring's centre and z along the axis. The motion of each ball is
// written in the frame that turns with that ball about the axis, with unit vectors (radial, tangential, axial).
#pragma once
#include "../contact/laws.hpp"
#include "../contact/friction.hpp"
#include "../shapes/gaps.hpp"
#include "surface_heights.hpp"

namespace core {

constexpr int POLYNOMIAL_TERMS = 10;
// A polynomial in |n| - 1, n the radial part of a contact's normal, and the least |n| - 1 at which it is evaluated.
struct GroovePolynomial { double term[POLYNOMIAL_TERMS], least; };

// A toroidal groove: the radius of its centre circle and of its meridian [m], the coefficient c [N/m^power] of the
// elastic law c h^power of its contacts, their effective modulus [Pa], and the semi-axes of their ellipse over the root of the
// approach [m^0.5].
struct Raceway {
  double locus_radius, groove_radius, given, modulus;
  GroovePolynomial coefficient, semi_major, semi_minor;
  double film[FILM_NUMBERS][3];  // the numbers of a film, as polynomials of second degree in |n| - 1
};

struct Bearing {
  double ball_radius, ball_mass, ball_inertia;
  double offset[3], tilt[2], gravity[3];  // of the inner ring's centre [m]; its tilt about x and y [rad]; [m/s^2]
  double damping, relaxation_time;  // Hunt and Crossley's [s/m]; of the viscous part in proportion to the stiffness [s]
  double friction_coefficient, regularisation;  // at a point; v_s [m/s]
  double power;  // of the elastic law: 1.5 (Hertz) or 1 (linear spring)
  double pair_coefficient, pair_friction;  // of two balls: c [N/m^1.5] and the coefficient of friction at a point
  Raceway inner, outer;
  PatchFriction patch;
  CarriedLaw carried;
  Lubricant lubricant;
  SurfaceDefects defects;
  bool carries() const { return carried != CarriedLaw::none || lubricant.works(); }  // anything within or between steps
  bool tilted() const { return tilt[0] != 0.0 || tilt[1] != 0.0; }
  // Curvatures of a contact's gap [1/m], across the groove, and along it where its normal has this radial part.
  double curvature_across(const Raceway &raceway) const { return curvature_across_groove(ball_radius, raceway.groove_radius); }
  template <class N>
  CORE_INLINE auto curvature_along(const Raceway &raceway, const N &radial) const {
    return curvature_along_groove(ball_radius, raceway.locus_radius, raceway.groove_radius, radial);
  }
  bool over_patch() const { return patch.model != FrictionModel::point; }
};

// Prescribed rotation of the inner ring: at time t [s] it has speed + acceleration t [rad/s], and from `angle` [rad] on.
struct Drive {
  double speed, acceleration, angle;
  double angle_at(double time) const { return angle + time * (speed + 0.5 * acceleration * time); }
};

// A ball's state: position (axis distance, orbit angle, height), velocity and angular velocity (radial, tangential,
// axial), and the integrals of the drive's power, of the losses, and of the size of the drive's power.
enum Column { RADIUS, ANGLE, HEIGHT, VELOCITY, SPIN = 6, DRIVE_WORK = 9, DISSIPATED, GROSS_WORK, COLUMNS };
constexpr int MOTION = DRIVE_WORK;
using BallState = std::array<Pack, COLUMNS>;

// Calls what is made for friction at a point or over the patch, and for a ring that is level or tilted.
template <class Function>
CORE_INLINE auto for_kind_of(const Bearing &bearing, Function function) {
  if (bearing.over_patch())
    return bearing.tilted() ? function.template operator()<true, true>() : function.template operator()<true, false>();
  return bearing.tilted() ? function.template operator()<false, true>() : function.template operator()<false, false>();
}

// A film where a step began: 1 over load and rolling speed there, its resistance [N] and coefficient of friction, and each
// one's exponent e of load and speed, as 1 + e and 1 - e. It is written where the rates are differentiated.
struct FilmBegin {
  bool known = false;
  Pack over_load{}, over_speed{}, value[2]{}, load[2][2]{}, speed[2][2]{};
};
// States of a law at the contacts of balls in lanes with a raceway, and their films; then with both.
struct CarriedContacts {
  CarriedContact contact[LANES];
  mutable FilmBegin film;
};
struct CarriedBalls {
  CarriedContacts inner, outer;
  void forget_films() const { inner.film.known = outer.film.known = false; }
};

template <Number X>
CORE_INLINE auto along_groove(const GroovePolynomial &polynomial, const X &radial) {
  return chained([&](auto n) __attribute__((always_inline)) {
    const double *t = polynomial.term;
    auto x = maximum(absolute(n) - 1.0, polynomial.least);
    auto x2 = x * x, x4 = x2 * x2;
    auto low = (t[0] + t[1] * x) + (t[2] + t[3] * x) * x2;
    auto high = (t[4] + t[5] * x) + (t[6] + t[7] * x) * x2;
    return low + (high + (t[8] + t[9] * x) * x4) * x4;
  }, radial);
}

}  // namespace core
