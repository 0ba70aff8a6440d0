// Where balls rest between the raceways of a bearing whose rings are held, and the motion with which they roll there.
#include "numbers.hpp"

namespace core::start {

constexpr double REACH = 0.02;  // of the ball radius: rest is looked for so far around the middle between the raceways
constexpr double EXACT = 1e-16;  // m, of a rest
constexpr int MOST_STEPS = 60;
constexpr double ROUNDING_SPIN = 1e-9, DRILLING_SPIN = 0.03;  // of a ball's surface speed: spin that changes slip by less

// Radial and axial force [N] on a ball by the elastic loads of both contacts and its orbit.
template <Number R, Number Z>
inline auto static_force(const Bearing &bearing, double orbit_rate, const R &radius, double angle, const Z &height) {
  double cosine = std::cos(angle), sine = std::sin(angle);
  Vector3 position{radius, Zero{}, height};
  auto push = [&](const Raceway &raceway, const auto &offset) {
    auto at = contact_geometry(bearing, raceway, offset, Zero{});
    return std::pair{-1.0 * (at.load * at.normal.x), -1.0 * (at.load * at.normal.z)};
  };
  const double *o = bearing.offset;
  auto inner = push(bearing.inner, position - about_z(cosine, -sine, Vector3{o[0], o[1], o[2]}));
  auto outer = push(bearing.outer, position);
  auto centrifugal = bearing.ball_mass * orbit_rate * orbit_rate * radius;
  return std::pair{inner.first + outer.first + centrifugal, inner.second + outer.second};
}

// Newton's method within a bracket of a force that falls.
struct Bracket {
  double low, high;
  double next(double force, double slope, double at) {
    (force > 0.0 ? low : high) = at;
    double wanted = slope < 0.0 ? at - force / slope : high;
    return low < wanted && wanted < high ? wanted : 0.5 * (low + high);
  }
};

// Axis distance [m] without radial force at this height; not a number where there is none near the nominal one.
inline double radial_rest(const Bearing &bearing, double orbit_rate, double angle, double nominal, double height) {
  double reach = REACH * bearing.ball_radius, distance = nominal;
  Bracket bracket{nominal - reach, nominal + reach};
  auto radial = [&](double r) { return static_force(bearing, orbit_rate, r, angle, height).first; };
  if (!(radial(bracket.low) >= 0.0 && 0.0 >= radial(bracket.high))) return NAN;
  for (int i = 0; i < MOST_STEPS; i++) {
    auto force = static_force(bearing, orbit_rate, variable<0>(distance), angle, height).first;
    double before = distance;
    if (force.value != 0.0) distance = bracket.next(force.value, force.slope[0], distance);
    if (std::fabs(distance - before) <= EXACT) break;
  }
  return distance;
}

struct Rest { double distance, height; };

// With clearance a ball rests on the raceway that its orbit presses it to, in the middle where nothing does.
inline Rest rest(const Bearing &bearing, double orbit_rate, double angle) {
  const Raceway &inner = bearing.inner, &outer = bearing.outer;
  double share = (inner.groove_radius - bearing.ball_radius) / (inner.groove_radius + outer.groove_radius - 2.0 * bearing.ball_radius);
  double nominal = inner.locus_radius + (outer.locus_radius - inner.locus_radius) * share;
  nominal += 0.5 * (std::cos(angle) * bearing.offset[0] + std::sin(angle) * bearing.offset[1]);
  double offset = bearing.offset[2], height = 0.5 * offset;
  Bracket bracket{std::fmin(0.0, offset), std::fmax(0.0, offset)};
  double distance = radial_rest(bearing, orbit_rate, angle, nominal, height);
  for (int i = 0; i < MOST_STEPS; i++) {
    if (bracket.low == bracket.high || !(distance < HUGE_VAL)) break;
    auto [radial, axial] = static_force(bearing, orbit_rate, variable<0>(distance), angle, variable<1>(height));
    double before = height;
    if (axial.value != 0.0) {  // along the heights at which nothing pushes radially
      double slope = axial.slope[1] - axial.slope[0] * radial.slope[1] / radial.slope[0];
      height = bracket.next(axial.value, slope, height);
    }
    if (std::fabs(height - before) <= EXACT) break;
    distance = radial_rest(bearing, orbit_rate, angle, nominal, height);
  }
  return {distance, height};
}

using Doubles = Vector3<double>;

struct Slips { double slip[6]; bool pressed; };

// Slip at both raceways of a ball with this tangential velocity and angular velocity.
inline Slips slips(const Bearing &bearing, double ring_speed, double angle, const Rest &place, const double (&motion)[4]) {
  double cosine = std::cos(angle), sine = std::sin(angle);
  const double *o = bearing.offset;
  Doubles position{place.distance, 0.0, place.height}, velocity{0.0, motion[0], 0.0}, spin{motion[1], motion[2], motion[3]};
  Slips found{{}, true};
  double *to = found.slip;
  for (bool inner : {true, false}) {
    Doubles offset = inner ? position - about_z(cosine, -sine, Doubles{o[0], o[1], o[2]}) : position;
    auto at = contact_geometry(bearing, inner ? bearing.inner : bearing.outer, offset, inner ? ring_speed : 0.0);
    auto surface = Doubles{at.surface_velocity.x, at.surface_velocity.y, 0.0};
    auto relative = (velocity + cross(spin, at.arm)) - surface;
    auto slip = relative - dot(relative, at.normal) * at.normal;
    *to++ = slip.x, *to++ = slip.y, *to++ = slip.z;
    found.pressed &= at.approach > 0.0;
  }
  return found;
}

// The shortest x that makes |matrix x - right| least; singular values below `share` of the greatest count as zero.
// One-sided Jacobi (Golub and Van Loan, Matrix Computations, 4th ed., section 8.6.3).
inline void least_squares(double (&matrix)[6][4], const double (&right)[6], double share, double (&x)[4]) {
  double turned[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}, square[4] = {}, greatest = 0.0;
  auto rotate = [](auto &table, int p, int q, double cosine, double sine) {
    for (auto &row : table) {
      double first = row[p], second = row[q];
      row[p] = cosine * first - sine * second, row[q] = sine * first + cosine * second;
    }
  };
  for (int sweep = 0, settled = 0; sweep < 30 && !settled; sweep++) {
    settled = 1;
    for (int p = 0; p < 3; p++)
      for (int q = p + 1; q < 4; q++) {
        double alpha = 0.0, beta = 0.0, gamma = 0.0;
        for (auto &row : matrix) alpha += row[p] * row[p], beta += row[q] * row[q], gamma += row[p] * row[q];
        if (gamma * gamma <= 1e-32 * alpha * beta) continue;
        settled = 0;
        double zeta = (beta - alpha) / (2.0 * gamma);
        double tangent = std::copysign(1.0, zeta) / (std::fabs(zeta) + std::sqrt(1.0 + zeta * zeta));
        double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent);
        rotate(matrix, p, q, cosine, cosine * tangent), rotate(turned, p, q, cosine, cosine * tangent);
      }
  }
  for (int p = 0; p < 4; p++) {
    x[p] = 0.0;
    for (auto &row : matrix) square[p] += row[p] * row[p];
    greatest = std::fmax(greatest, square[p]);
  }
  for (int p = 0; p < 4; p++) {
    if (!(square[p] > share * share * greatest)) continue;
    double along = 0.0;
    for (int i = 0; i < 6; i++) along += matrix[i][p] * right[i];
    for (int i = 0; i < 4; i++) x[i] += turned[i][p] * along / square[p];
  }
}

// Tangential velocity and angular velocity of a ball that slips on neither raceway, by least squares: slip is linear in
// them. Among several motions the one with least spin; spin that changes slip by less than `share` is left out.
inline void rolling(const Bearing &bearing, double ring_speed, double angle, const Rest &place, double share, double (&motion)[4]) {
  double unit[4] = {}, matrix[6][4], right[6], scale[4];
  Slips none = slips(bearing, ring_speed, angle, place, unit);
  for (int j = 0; j < 4; j++) {
    scale[j] = j > 0 ? 1.0 / bearing.ball_radius : 1.0;
    unit[j] = 1.0;
    Slips one = slips(bearing, ring_speed, angle, place, unit);
    unit[j] = 0.0;
    for (int i = 0; i < 6; i++) matrix[i][j] = (one.slip[i] - none.slip[i]) * scale[j];
  }
  for (int i = 0; i < 6; i++) right[i] = -none.slip[i];
  least_squares(matrix, right, share, motion);
  for (int j = 0; j < 4; j++) motion[j] *= scale[j];
}

inline void let_roll(const Bearing &bearing, double ring_speed, double share, double *ball) {
  double motion[4];
  rolling(bearing, ring_speed, ball[ANGLE], {ball[RADIUS], ball[HEIGHT]}, share, motion);
  ball[VELOCITY + 1] = motion[0];
  for (int i = 0; i < 3; i++) ball[SPIN + i] = motion[1 + i];
}

// Fills the states (balls, COLUMNS) of evenly spaced balls that rest between the raceways, and roll there if they are to.
// Balls that both raceways press roll without spin about their contacts: it changes slip only by as much as an inner
// ring off the axis puts the contacts off one line, and takes seconds to settle. False where a ball has no rest.
inline bool place_balls(const Bearing &bearing, double ring_speed, bool rolls, int balls, double *state) {
  bool pressed = true;
  for (int k = 0; k < balls; k++) {
    double angle = 2.0 * M_PI * k / balls, motion[4] = {};
    Rest place = rest(bearing, 0.0, angle);
    for (int i = 0; rolls && i < 3; i++) {
      rolling(bearing, ring_speed, angle, place, ROUNDING_SPIN, motion);
      place = rest(bearing, motion[0] / place.distance, angle);
    }
    if (!(place.distance < HUGE_VAL)) return false;
    double *ball = state + k * COLUMNS;
    ball[RADIUS] = place.distance, ball[ANGLE] = angle, ball[HEIGHT] = place.height;
    if (rolls) let_roll(bearing, ring_speed, ROUNDING_SPIN, ball);
    pressed &= slips(bearing, ring_speed, angle, place, motion).pressed;
  }
  for (int k = 0; rolls && pressed && k < balls; k++) let_roll(bearing, ring_speed, DRILLING_SPIN, state + k * COLUMNS);
  return true;
}

}  // namespace core::start

using namespace core;

// States (balls, COLUMNS) of evenly spaced balls at rest between the raceways, rolling there if they are to; 0 where one
// has no rest.
CORE_EXPORT std::int64_t core_place_balls(const double *bearing_numbers, const double *points, double ring_speed,
                                          std::int64_t rolls, std::int64_t balls, double *state) {
  return start::place_balls(bearing_of(bearing_numbers, points), ring_speed, rolls != 0, int(balls), state);
}
