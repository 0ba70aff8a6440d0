// Rest positions of balls between the raceways of a bearing whose rings are held, and their rolling motion.
#include "numbers.hpp"

namespace core::start {

constexpr double REACH = 0.02;  // of the ball radius: half the interval about the middle between the raceways that is searched
constexpr double TOLERANCE = 1e-16;  // m
constexpr int MOST_STEPS = 60;
constexpr double ROUNDING_SPIN = 1e-9, CONTACT_SPIN = 0.03;  // fractions of the surface speed of a ball: negligible slip by spin

// Radial and axial force [N] on a ball by the elastic loads of both contacts and its orbit.
template <Number R, Number Z>
inline auto static_force(const Bearing &bearing, double orbit_rate, const R &radius, double angle, const Z &height) {
  double cosine = std::cos(angle), sine = std::sin(angle);
  Vector3 position{radius, Zero{}, height};
  auto push = [&](const Raceway &raceway, const auto &offset) {
    auto geometry = contact_geometry(bearing, raceway, offset, Zero{});
    return std::pair{-1.0 * (geometry.load * geometry.normal.x), -1.0 * (geometry.load * geometry.normal.z)};
  };
  const double *o = bearing.offset;
  auto inner = push(bearing.inner, position - about_z(cosine, -sine, Vector3{o[0], o[1], o[2]}));
  auto outer = push(bearing.outer, position);
  auto centrifugal = bearing.ball_mass * orbit_rate * orbit_rate * radius;
  return std::pair{inner.first + outer.first + centrifugal, inner.second + outer.second};
}

// Newton's method within a bracket of a decreasing force.
struct Bracket {
  double low, high;
  double next(double force, double slope, double x) {
    (force > 0.0 ? low : high) = x;
    double newton = slope < 0.0 ? x - force / slope : high;
    return low < newton && newton < high ? newton : 0.5 * (low + high);
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
    if (std::fabs(distance - before) <= TOLERANCE) break;
  }
  return distance;
}

struct RestPosition {
  double distance, height;
};

// With clearance a ball rests on the raceway to which the centrifugal force presses it, without orbit in the middle.
inline RestPosition rest_position(const Bearing &bearing, double orbit_rate, double angle) {
  const Raceway &inner = bearing.inner, &outer = bearing.outer;
  double share =
      (inner.groove_radius - bearing.ball_radius) / (inner.groove_radius + outer.groove_radius - 2.0 * bearing.ball_radius);
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
    if (std::fabs(height - before) <= TOLERANCE) break;
    distance = radial_rest(bearing, orbit_rate, angle, nominal, height);
  }
  return {distance, height};
}

using Doubles = Vector3<double>;

struct Slips {
  double slip[6];
  bool pressed;
};

// Slip at both raceways of a ball with this tangential velocity and angular velocity.
inline Slips slips(const Bearing &bearing, double ring_speed, double angle, const RestPosition &rest, const double (&motion)[4]) {
  double cosine = std::cos(angle), sine = std::sin(angle);
  const double *o = bearing.offset;
  Doubles position{rest.distance, 0.0, rest.height}, velocity{0.0, motion[0], 0.0}, spin{motion[1], motion[2], motion[3]};
  Slips result{{}, true};
  double *slip_out = result.slip;
  for (bool inner : {true, false}) {
    Doubles offset = inner ? position - about_z(cosine, -sine, Doubles{o[0], o[1], o[2]}) : position;
    auto geometry = contact_geometry(bearing, inner ? bearing.inner : bearing.outer, offset, inner ? ring_speed : 0.0);
    auto surface = Doubles{geometry.surface_velocity.x, geometry.surface_velocity.y, 0.0};
    auto relative = (velocity + cross(spin, geometry.arm)) - surface;
    auto slip = relative - dot(relative, geometry.normal) * geometry.normal;
    *slip_out++ = slip.x, *slip_out++ = slip.y, *slip_out++ = slip.z;
    result.pressed &= geometry.approach > 0.0;
  }
  return result;
}

// The shortest x that minimises |matrix x - right|; singular values below `share` of the greatest count as zero.
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
// them. Among several motions the one with least spin; spin that changes slip by less than `share` is zero.
inline void rolling(const Bearing &bearing, double ring_speed, double angle, const RestPosition &position, double share,
                    double (&motion)[4]) {
  double unit[4] = {}, matrix[6][4], right[6], scale[4];
  Slips none = slips(bearing, ring_speed, angle, position, unit);
  for (int j = 0; j < 4; j++) {
    scale[j] = j > 0 ? 1.0 / bearing.ball_radius : 1.0;
    unit[j] = 1.0;
    Slips unit_slips = slips(bearing, ring_speed, angle, position, unit);
    unit[j] = 0.0;
    for (int i = 0; i < 6; i++) matrix[i][j] = (unit_slips.slip[i] - none.slip[i]) * scale[j];
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

// Fills the states (balls, COLUMNS) of evenly spaced balls at rest between the raceways, rolling if requested. Balls in contact with
// both raceways roll without spin about their contacts: spin changes slip only as far as an eccentric inner ring misaligns the
// contacts, and takes seconds to decay. False where a ball has no rest position.
inline bool place_balls(const Bearing &bearing, double ring_speed, bool rolls, int balls, double *state) {
  bool pressed = true;
  for (int k = 0; k < balls; k++) {
    double angle = 2.0 * M_PI * k / balls, motion[4] = {};
    RestPosition position = rest_position(bearing, 0.0, angle);
    for (int i = 0; rolls && i < 3; i++) {
      rolling(bearing, ring_speed, angle, position, ROUNDING_SPIN, motion);
      position = rest_position(bearing, motion[0] / position.distance, angle);
    }
    if (!(position.distance < HUGE_VAL)) return false;
    double *ball = state + k * COLUMNS;
    ball[RADIUS] = position.distance, ball[ANGLE] = angle, ball[HEIGHT] = position.height;
    if (rolls) let_roll(bearing, ring_speed, ROUNDING_SPIN, ball);
    pressed &= slips(bearing, ring_speed, angle, position, motion).pressed;
  }
  for (int k = 0; rolls && pressed && k < balls; k++) let_roll(bearing, ring_speed, CONTACT_SPIN, state + k * COLUMNS);
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
