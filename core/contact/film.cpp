// The door to films of contacts; arrays are C-contiguous doubles, `lubricant` the numbers of a Lubricant in their order.
#include <cmath>
#include "../door.hpp"
#include "film.hpp"

using namespace core;

namespace {

Lubricant lubricant_of(const double *n) { return {LubricantKind(int(n[0])), n[1], n[2], n[3], n[4], n[5], n[6], n[7]}; }

}  // namespace

// The numbers (count, FILM_NUMBERS) of contacts with these curvatures (count,).
CORE_EXPORT void core_film_numbers(const double *lubricant, std::int64_t count, const double *small, const double *large, double modulus,
                                   double ball_radius, double *out) {
  for (std::int64_t i = 0; i < count; i++) {
    FilmNumbers found = film_numbers(lubricant_of(lubricant), small[i], large[i], modulus, ball_radius);
    out = std::copy(found.begin(), found.end(), out);
  }
}

// Of contacts (count, 6) with numbers (count, FILM_NUMBERS), loads and speeds (count,) above 0: thickness [m], thickness over
// roughness, resistance [N], moments of hysteresis and of differential slip [N m], coefficient of friction.
CORE_EXPORT void core_films(const double *lubricant, std::int64_t count, const double *numbers, const double *load, const double *speed,
                            double *out) {
  const Lubricant oil = lubricant_of(lubricant);
  for (std::int64_t i = 0; i < count; i++, numbers += FILM_NUMBERS, out += 6) {
    double q = std::log(load[i]), u = std::log(speed[i]), ratio = film_thickness(numbers, q, u) - oil.log_roughness;
    double friction = mixed_friction(oil, ratio);
    out[0] = std::exp(ratio + oil.log_roughness), out[1] = std::exp(ratio), out[2] = film_resistance(oil, numbers, q, u, speed[i]);
    out[3] = hysteresis_moment(numbers, q), out[4] = friction * slip_moment(numbers, q), out[5] = friction;
  }
}
