// Waviness and spalls: heights of raceways and balls [m], which add to the approach of a contact. They are functions of
// place: of the orbit angle on the outer raceway, of that less the ring's angle on the inner one, of the angle on the great
// circle across the first ball's axis z on that ball. A spall comes as a table of how far it lets a ball drop (Python makes it from
// length, depth and contact ellipse, `kinds/bearing/defects.py`).
//
// Within a step the places move on evenly from its start. So heights depend on time alone, and their rates come in as
// df/dt; what a slope does along the orbit is not modelled, and its work counts as the drive's.
#pragma once
#include <algorithm>
#include "../math/linear.hpp"

namespace core {

enum class Surface { inner, outer, ball };
constexpr int MAX_DEFECTS = 16, TABLE_PIECES = 128, TABLE_NUMBERS = 2 * (TABLE_PIECES + 1);
constexpr double PIECES_OF_BEND = 4.0, PIECES_OF_WAVE = 16.0;  // steps in which a bend of a spall and a wave pass
constexpr double LEAST_CIRCLE = 0.01;  // square of a circle of latitude over the ball's radius: at poles places would turn at once
constexpr double AT_MIDDLE = 1e-6;  // of a bend: a step that begins no further before the middle of a spall begins there

// A spall of no `order`: its middle [rad], radius of the path [m], half its length with what smooths it, half its width,
// semi-major axis of the contact, length of a bend [m]; values and slopes (times a piece) of the drop, alternating, from the
// middle to the edge. In the middle, where the ball strikes the other edge, the slope jumps: steps end there.
struct Defect {
  Surface on;
  double order, amplitude, phase, middle, radius, half, half_width, semi_major, bend;
  const double *table;
};
struct SurfaceDefects { int count = 0; Defect one[MAX_DEFECTS]; };

// From how many there are and their numbers, as defects.py writes them; tables stay where they are.
inline SurfaceDefects defects_of(const double *numbers) {
  SurfaceDefects found;
  found.count = int(*numbers++);
  for (int i = 0; i < found.count; i++) {
    Defect &d = found.one[i];
    d.on = Surface(int(*numbers++));
    for (double *one : {&d.order, &d.amplitude, &d.phase, &d.middle, &d.radius, &d.half, &d.half_width, &d.semi_major, &d.bend})
      *one = *numbers++;
    d.table = numbers, numbers += TABLE_NUMBERS;
  }
  return found;
}

struct Height { Pack value{}, rate{}; };  // [m], [m/s]
struct Heights { Height inner, outer; };
// Where balls in lanes stand on their surfaces [rad], and how fast these places move; a ball's is that of its outer contact,
// with the sine of its latitude; `first` says which is the first ball.
struct SurfacePositions { Pack inner{}, outer{}, ball{}, latitude{}, inner_rate{}, outer_rate{}, ball_rate{}, latitude_rate{}; Mask first{}; };

inline SurfacePositions surface_positions(const Pack &angle, const Pack &orbit_rate, const Pack &ring_angle, const Pack &ring_speed,
                                    const Quaternion &q, const Triple &spin_in_frame, const Mask &first) {
  Pack across = 2.0 * (q[0] * q[1] - q[2] * q[3]), along = 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]);
  Pack latitude = 2.0 * (q[0] * q[2] + q[1] * q[3]), tilt = 2.0 * (q[1] * q[2] - q[0] * q[3]), level = 1.0 - 2.0 * (q[0] * q[0] + q[1] * q[1]);
  Pack rate = (spin_in_frame[2] * level + spin_in_frame[1] * tilt) / maximum(1.0 - latitude * latitude, LEAST_CIRCLE);
  Pack rise = spin_in_frame[1] * level - spin_in_frame[2] * tilt;
  SurfacePositions at{angle - ring_angle, angle, {}, latitude, orbit_rate - ring_speed, orbit_rate, -rate, rise, first};
  for (int lane = 0; lane < LANES; lane++)
    if (first[lane]) at.ball[lane] = std::atan2(across[lane], along[lane]);
  return at;
}

inline double around(double angle) { return angle - 2.0 * M_PI * std::floor(angle / (2.0 * M_PI) + 0.5); }

// Share of a contact's load on a strip of this half width, its middle moved by `offset` along the semi-major axis, and its slope.
inline std::pair<double, double> share_of_strip(double half_width, double semi_major, double offset) {
  double near = std::clamp((half_width - offset) / semi_major, -1.0, 1.0), far = std::clamp((-half_width - offset) / semi_major, -1.0, 1.0);
  auto below = [](double s) { return 0.75 * (s - s * s * s / 3.0); };
  return {below(near) - below(far), 0.75 * (near * near - far * far) / semi_major};
}

// Height [m] and its rate [m/s] of one defect `later` [s] than a place, which moves on at a rate; the latitude counts on balls.
inline std::pair<double, double> height_of(const Defect &d, double place, double rate, double later, double latitude, double latitude_rate) {
  if (d.order > 0.0) {
    double phase = d.order * (place + rate * later) + d.phase;
    return {d.amplitude * std::cos(phase), -d.amplitude * d.order * rate * std::sin(phase)};
  }
  double from = std::copysign(d.radius, rate) * around(place - d.middle), x = from + d.radius * std::fabs(rate) * later;
  if (!(std::fabs(x) < d.half)) return {0.0, 0.0};
  double across = d.on == Surface::ball ? d.radius : 0.0;
  auto [share, by_offset] = share_of_strip(d.half_width, d.semi_major, across * (latitude + latitude_rate * later));
  double side = from < -AT_MIDDLE * d.bend ? -1.0 : 1.0;  // throughout a step
  double piece = d.half / TABLE_PIECES, u = side * x / piece;
  int i = std::clamp(int(u), 0, TABLE_PIECES - 1);
  const double *t = d.table + 2 * i;
  double s = u - i, low = t[0], high = t[2], begin = t[1], end = t[3], rise = high - low;
  double value = low + s * (begin + s * (3.0 * rise - 2.0 * begin - end + s * (begin + end - 2.0 * rise)));
  double slope = begin + s * (2.0 * (3.0 * rise - 2.0 * begin - end) + 3.0 * s * (begin + end - 2.0 * rise));
  return {-share * value, -share * side * slope * d.radius * std::fabs(rate) / piece - by_offset * across * latitude_rate * value};
}

// Calls function(defect, place, its rate, member of Heights) for each place at which the ball in a lane may meet a defect.
template <class Function>
inline void for_each_place(const SurfaceDefects &defects, const SurfacePositions &at, int lane, Function function) {
  for (int i = 0; i < defects.count; i++) {
    const Defect &d = defects.one[i];
    if (d.on == Surface::inner) function(d, at.inner[lane], at.inner_rate[lane], &Heights::inner);
    if (d.on == Surface::outer) function(d, at.outer[lane], at.outer_rate[lane], &Heights::outer);
    if (d.on != Surface::ball || !at.first[lane]) continue;
    function(d, at.ball[lane], at.ball_rate[lane], &Heights::outer);
    function(d, at.ball[lane] + M_PI, at.ball_rate[lane], &Heights::inner);
  }
}

// Heights `later` [s] than the places.
inline Heights heights_at(const SurfaceDefects &defects, const SurfacePositions &at, const Pack &later) {
  Heights found;
  for (int lane = 0; lane < LANES; lane++)
    for_each_place(defects, at, lane, [&](const Defect &d, double place, double rate, Height Heights::*on) {
      auto [value, change] = height_of(d, place, rate, later[lane], at.latitude[lane], at.latitude_rate[lane]);
      (found.*on).value[lane] += value, (found.*on).rate[lane] += change;
    });
  return found;
}

// The longest step [s] of the ball in a lane that resolves its defects: to the next bend, and a part of one within.
inline double resolving_step(const SurfaceDefects &defects, const SurfacePositions &at, int lane) {
  double longest = HUGE_VAL;
  for_each_place(defects, at, lane, [&](const Defect &d, double place, double rate, Height Heights::*) {
    double speed = std::fabs(rate) + 1e-300;
    if (d.order > 0.0) longest = std::min(longest, 2.0 * M_PI / (PIECES_OF_WAVE * d.order * speed));
    else {
      double x = std::copysign(d.radius, rate) * around(place - d.middle), far = -d.half - x, round = 2.0 * M_PI * d.radius;
      double until = std::max(d.bend / PIECES_OF_BEND, x < d.half ? far : far + round);
      if (x < -AT_MIDDLE * d.bend) until = std::min(until, -x);
      longest = std::min(longest, until / (d.radius * speed));
    }
  });
  return longest;
}

// True if the ball in a lane meets a defect within a step [s].
inline bool meets(const SurfaceDefects &defects, const SurfacePositions &at, int lane, double step) {
  bool found = false;
  for_each_place(defects, at, lane, [&](const Defect &d, double place, double rate, Height Heights::*) {
    double x = std::copysign(d.radius, rate) * around(place - d.middle), end = x + 1.01 * d.radius * std::fabs(rate) * step;
    found |= d.order > 0.0 || (x < d.half && end > -d.half) || end > 2.0 * M_PI * d.radius - d.half;
  });
  return found;
}

}  // namespace core
