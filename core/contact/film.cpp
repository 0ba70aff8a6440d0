// The door to films of contacts; arrays are C-contiguous doubles, `lubricant` the numbers of a Lubricant in their order.
#include <cmath>
#include "../door.hpp"
#include "film.hpp"

using namespace core;

namespace {

Lubricant lubricant_of(const double *numbers) {
  return {LubricantKind(int(numbers[0])), numbers[1], numbers[2], numbers[3], numbers[4], numbers[5], numbers[6], numbers[7]};
}

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
    double q = std::log(load[i]), u = std::log(speed[i]), thickness = film_thickness(numbers, q, u);
    double ratio = thickness / oil.roughness, friction = mixed_friction(oil, std::log(ratio));
    out[0] = thickness, out[1] = ratio, out[2] = film_resistance(oil, numbers, q, u, speed[i]);
    out[3] = hysteresis_moment(numbers, q), out[4] = friction * slip_moment(numbers, q), out[5] = friction;
  }
}
