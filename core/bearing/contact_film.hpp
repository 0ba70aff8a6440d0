// The lubricant's film in the contact of a ball with a raceway: what it, hysteresis and differential slip resist rolling
// with, and its coefficient of friction (`core/contact/film.hpp`).
//
// The film drags both surfaces by F against their motion, and its pressure, whose centre lies ahead of the contact's, pushes
// the ball by 2 F R_x/r and the ring by 2 F R_x/R the other way, through their centres, without moment or loss (R_x is the
// radius of the gap along rolling; R that of the race, below zero for the outer one). These four add up to nothing, and so do
// their moments: what the ring gets is what the ball gets, reversed. With t along the groove, in the direction in which both
// surfaces move against the contact at their mean speed u, the ball gets the force (2 R_x/r - 1) F t and about its centre
// the torque -F arm x t, and 2 F u is lost, where R_x/r is the contact point's distance from the axis over the ball's. A moment M about the ball's axis is taken as F = M/(2 r).
#pragma once
#include "../math/vector3.hpp"
#include "model.hpp"

namespace core {

constexpr double LIGHT = 1e-6;  // N: resistance sets in smoothly with the load  # tuned: far below what a ball weighs
constexpr double SLOW = 1e-4;  // m/s: and with the speed  # tuned: far below any that is looked at

// F [N] and its slope by the load, the coefficient of friction, and where a step begins the logarithm of thickness over
// roughness; u [m/s], the x and y of t, 2 R_x/r, and -arm x t [m].
struct ContactFilm { Pack resistance, by_load, friction, log_ratio, speed, x, y, lead; Vector3<Pack> turning; };

template <class X>
struct FilmValues { X resistance, friction, log_ratio; };

inline std::array<Pack, FILM_NUMBERS> film_numbers_at(const Raceway &raceway, const Pack &radial) {
  std::array<Pack, FILM_NUMBERS> found;
  Pack x = absolute(radial) - 1.0;
  for (int i = 0; i < FILM_NUMBERS; i++) found[i] = raceway.film[i][0] + x * (raceway.film[i][1] + x * raceway.film[i][2]);
  return found;
}

// Resistance at a load [N] and a speed [m/s] of any sign, coefficient of friction and logarithm of thickness over roughness, where
// the normal has this radial part; slopes by that, which are next to nothing, are left out.
template <class Q, class U>
[[gnu::noinline]] inline FilmValues<decltype(Q{} * U{})> film_values(const Bearing &bearing, const Raceway &raceway, const Pack &radial, const Q &load,
                                                            const U &speed) {
  const Lubricant &lubricant = bearing.lubricant;
  auto numbers = film_numbers_at(raceway, radial);
  auto [size, over_size] = root_and_inverse(speed * speed + SLOW * SLOW);
  auto pressed = load + LIGHT;
  auto log_load = logarithm(pressed);
  auto log_speed = logarithm(size);
  auto log_ratio = film_thickness(numbers, log_load, log_speed) - lubricant.log_roughness;
  auto friction = mixed_friction(lubricant, log_ratio);
  auto moments = hysteresis_moment(numbers, log_load) + friction * slip_moment(numbers, log_load);
  auto resistance = film_resistance(lubricant, numbers, log_load, log_speed, size) + 0.5 / bearing.ball_radius * moments;
  return {(load / pressed) * (speed * over_size) * resistance, friction, log_ratio};
}

// Fills what holds within the step.
[[gnu::noinline]] inline void begin_film(const FilmValues<Dual<3, Pack>> &found, const Pack &load, const Pack &speed, FilmBegin &begin) {
  auto inverse = [](const Pack &x) { return select(absolute(x) > 1e-12, 1.0 / x, Pack{}); };
  begin.over_load = inverse(load), begin.over_speed = inverse(speed), begin.known = true;
  int i = 0;
  for (const auto *one : {&found.resistance, &found.friction}) {
    Pack over = inverse(one->value), by_load = one->slope[0] * load * over, by_speed = one->slope[1] * speed * over;
    begin.value[i] = one->value;
    begin.load[i][0] = 1.0 + by_load, begin.load[i][1] = 1.0 - by_load;
    begin.speed[i][0] = 1.0 + by_speed, begin.speed[i][1] = 1.0 - by_speed, i++;
  }
}
// Within the step: a power x^e by (2 + (1 + e) p)/(2 + (1 - e) p), p = x - 1, which has its value and two derivatives.
CORE_INLINE FilmValues<Pack> film_within(const FilmBegin &begin, const Pack &load, const Pack &speed) {
  constexpr double MOST = 8.0;  // times the load or the speed, where a power grows on no more
  Pack p = minimum(load * begin.over_load, MOST) - 1.0, w = minimum(maximum(speed * begin.over_speed, 0.0), MOST) - 1.0;
  Pack over[2], under[2];
  for (int i = 0; i < 2; i++) {
    over[i] = begin.value[i] * ((2.0 + begin.load[i][0] * p) * (2.0 + begin.speed[i][0] * w));
    under[i] = (2.0 + begin.load[i][1] * p) * (2.0 + begin.speed[i][1] * w);
  }
  Pack inverse = 1.0 / (under[0] * under[1]);
  return {select(load > 0.0, over[0] * (under[1] * inverse), Pack{}), over[1] * (under[0] * inverse), Pack{}};
}

// `velocity` of the ball's centre against the ring's. Of slopes that of F by the load alone is taken, for it is the only stiff
// one. Where derivatives are wanted, values and slopes go into `begin`, for what is evaluated within the step.
template <bool DERIVATIVES, class P, class N, class R, class V>
CORE_INLINE ContactFilm contact_film(const Bearing &bearing, const Raceway &raceway, const P &at, const N &normal_radial,
                                     const R &relative, const V &velocity, FilmBegin *begin) {
  auto pack = [](const auto &x) __attribute__((always_inline)) {
    if constexpr (IsZero<decltype(x)>) return Pack{};
    else return Pack(value_of(x));
  };
  ContactFilm film;
  Pack over = 1.0 / pack(at.axis_distance), load = pack(at.load);
  film.x = -over * pack(at.offset.y), film.y = over * pack(at.offset.x);
  Pack arm_x = pack(at.arm.x), arm_y = pack(at.arm.y), arm_z = pack(at.arm.z);
  film.turning = {arm_z * film.y, -arm_z * film.x, arm_y * film.x - arm_x * film.y};
  film.lead = 2.0 - 2.0 * over * film.turning.z;  // twice the contact point's distance from the axis over that of the ball
  auto along = [&](const auto &v) __attribute__((always_inline)) { return film.x * pack(v.x) + film.y * pack(v.y); };
  film.speed = 0.5 * along(relative) + along(at.surface_velocity) - 0.5 * film.lead * along(velocity);
  auto take = [&](const FilmValues<Pack> &found) {
    film.resistance = found.resistance, film.friction = found.friction, film.log_ratio = found.log_ratio;
  };
  film.by_load = Pack{};
  if constexpr (DERIVATIVES) {
    auto found = film_values(bearing, raceway, pack(normal_radial), variable<0>(load), variable<1>(film.speed));
    if (begin) begin_film(found, load, film.speed, *begin);
    take({found.resistance.value, found.friction.value, found.log_ratio.value}), film.by_load = found.resistance.slope[0];
  } else if (begin && begin->known) take(film_within(*begin, load, film.speed));
  else take(film_values(bearing, raceway, pack(normal_radial), load, film.speed));
  return film;
}

}  // namespace core
