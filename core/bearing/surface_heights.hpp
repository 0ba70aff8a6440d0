// Waviness and spalls: heights of raceways and balls [m], which add to the approach of a contact. They are functions of
// position: of the orbit angle on the outer raceway, of that less the ring's angle on the inner one, of the angle on the great
// circle across the first ball's axis z on that ball. A spall is a table of the drop of a ball (computed in Python from length, depth
// and contact ellipse, `kinds/bearing/defects.py`).
//
// Within a step the positions move at constant rates. So heights depend on time alone, and their rates are part of
// df/dt; the tangential force of a slope is not modelled, and its work counts as the drive's.
#pragma once
#include <algorithm>
#include "../math/linear.hpp"

namespace core {

enum class Surface { inner, outer, ball };
constexpr int MAX_DEFECTS = 16, TABLE_PIECES = 128, TABLE_NUMBERS = 2 * (TABLE_PIECES + 1);
constexpr double STEPS_PER_BEND = 4.0, STEPS_PER_WAVE = 16.0;  // steps that resolve a bend of a spall and a wave
constexpr double LEAST_CIRCLE = 0.01;  // square of a circle of latitude over the ball's radius: at poles rates are infinite
constexpr double AT_MIDDLE = 1e-6;  // of a bend: a step that starts this close to the middle of a spall starts there

// A spall of no `order`: its middle [rad], radius of the path [m], half its smoothed length, half its width,
// semi-major axis of the contact, length of a bend [m]; values and slopes (times a piece) of the drop, alternating, from the
// middle to the edge. In the middle, where the ball hits the other edge, the slope jumps: steps end there.
struct Defect {
  Surface body;
  double order, amplitude, phase, middle, radius, half, half_width, semi_major, bend;
  const double *table;
};
struct SurfaceDefects {
  int count = 0;
  Defect defect[MAX_DEFECTS];
};

// From their count and numbers, as defects.py writes them; tables are not copied.
inline SurfaceDefects defects_of(const double *numbers) {
  SurfaceDefects defects;
  defects.count = int(*numbers++);
  for (int i = 0; i < defects.count; i++) {
    Defect &d = defects.defect[i];
    d.body = Surface(int(*numbers++));
    for (double *number : {&d.order, &d.amplitude, &d.phase, &d.middle, &d.radius, &d.half, &d.half_width, &d.semi_major, &d.bend})
      *number = *numbers++;
    d.table = numbers, numbers += TABLE_NUMBERS;
  }
  return defects;
}

struct Height {
  Pack value{}, rate{};
};  // [m], [m/s]
struct Heights {
  Height inner, outer;
};
// Positions of the balls in lanes on their surfaces [rad] and their rates; that on a ball is of its outer contact, with the sine of
// its latitude; `first` marks the first ball.
struct SurfacePositions {
  Pack inner{}, outer{}, ball{}, latitude{}, inner_rate{}, outer_rate{}, ball_rate{}, latitude_rate{};
  Mask first{};
};

inline SurfacePositions surface_positions(const Pack &angle, const Pack &orbit_rate, const Pack &ring_angle, const Pack &ring_speed,
                                          const Quaternion &q, const Triple &spin_in_frame, const Mask &first) {
  Pack across = 2.0 * (q[0] * q[1] - q[2] * q[3]), along = 1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]);
  Pack latitude = 2.0 * (q[0] * q[2] + q[1] * q[3]), tilt = 2.0 * (q[1] * q[2] - q[0] * q[3]),
       level = 1.0 - 2.0 * (q[0] * q[0] + q[1] * q[1]);
  Pack rate = (spin_in_frame[2] * level + spin_in_frame[1] * tilt) / maximum(1.0 - latitude * latitude, LEAST_CIRCLE);
  Pack rise = spin_in_frame[1] * level - spin_in_frame[2] * tilt;
  SurfacePositions surface{angle - ring_angle, angle, {}, latitude, orbit_rate - ring_speed, orbit_rate, -rate, rise, first};
  for (int lane = 0; lane < LANES; lane++)
    if (first[lane]) surface.ball[lane] = std::atan2(across[lane], along[lane]);
  return surface;
}

inline double wrapped(double angle) { return angle - 2.0 * M_PI * std::floor(angle / (2.0 * M_PI) + 0.5); }

// Fraction of a contact's load on a strip of this half width, whose middle is at `offset` along the semi-major axis, and its slope.
inline std::pair<double, double> share_of_strip(double half_width, double semi_major, double offset) {
  double upper = std::clamp((half_width - offset) / semi_major, -1.0, 1.0),
         lower = std::clamp((-half_width - offset) / semi_major, -1.0, 1.0);
  auto cumulative = [](double s) { return 0.75 * (s - s * s * s / 3.0); };
  return {cumulative(upper) - cumulative(lower), 0.75 * (upper * upper - lower * lower) / semi_major};
}

// Height [m] and its rate [m/s] of one defect, `delay` [s] after a position that moves at a rate; the latitude matters on balls.
inline std::pair<double, double> height_of(const Defect &d, double position, double rate, double delay, double latitude,
                                           double latitude_rate) {
  if (d.order > 0.0) {
    double phase = d.order * (position + rate * delay) + d.phase;
    return {d.amplitude * std::cos(phase), -d.amplitude * d.order * rate * std::sin(phase)};
  }
  double start = std::copysign(d.radius, rate) * wrapped(position - d.middle), x = start + d.radius * std::fabs(rate) * delay;
  if (!(std::fabs(x) < d.half)) return {0.0, 0.0};
  double across = d.body == Surface::ball ? d.radius : 0.0;
  auto [strip_load, by_offset] = share_of_strip(d.half_width, d.semi_major, across * (latitude + latitude_rate * delay));
  double side = start < -AT_MIDDLE * d.bend ? -1.0 : 1.0;  // throughout a step
  double piece = d.half / TABLE_PIECES, u = side * x / piece;
  int i = std::clamp(int(u), 0, TABLE_PIECES - 1);
  const double *t = d.table + 2 * i;
  double s = u - i, low = t[0], high = t[2], begin = t[1], end = t[3], rise = high - low;
  double value = low + s * (begin + s * (3.0 * rise - 2.0 * begin - end + s * (begin + end - 2.0 * rise)));
  double slope = begin + s * (2.0 * (3.0 * rise - 2.0 * begin - end) + 3.0 * s * (begin + end - 2.0 * rise));
  return {-strip_load * value,
          -strip_load * side * slope * d.radius * std::fabs(rate) / piece - by_offset * across * latitude_rate * value};
}

// Calls function(defect, position, its rate, member of Heights) for each point of the ball in a lane that may cross a defect.
template <class Function>
inline void for_each_crossing_point(const SurfaceDefects &defects, const SurfacePositions &surface, int lane, Function function) {
  for (int i = 0; i < defects.count; i++) {
    const Defect &d = defects.defect[i];
    if (d.body == Surface::inner) function(d, surface.inner[lane], surface.inner_rate[lane], &Heights::inner);
    if (d.body == Surface::outer) function(d, surface.outer[lane], surface.outer_rate[lane], &Heights::outer);
    if (d.body != Surface::ball || !surface.first[lane]) continue;
    function(d, surface.ball[lane], surface.ball_rate[lane], &Heights::outer);
    function(d, surface.ball[lane] + M_PI, surface.ball_rate[lane], &Heights::inner);
  }
}

// Heights `delay` [s] after the positions.
inline Heights heights_at(const SurfaceDefects &defects, const SurfacePositions &surface, const Pack &delay) {
  Heights heights;
  for (int lane = 0; lane < LANES; lane++)
    for_each_crossing_point(defects, surface, lane, [&](const Defect &d, double position, double rate, Height Heights::*body) {
      auto [value, height_rate] = height_of(d, position, rate, delay[lane], surface.latitude[lane], surface.latitude_rate[lane]);
      (heights.*body).value[lane] += value, (heights.*body).rate[lane] += height_rate;
    });
  return heights;
}

// The longest step [s] of the ball in a lane that resolves its defects: up to the next bend, and a fraction of one within.
inline double resolving_step(const SurfaceDefects &defects, const SurfacePositions &surface, int lane) {
  double longest = HUGE_VAL;
  for_each_crossing_point(defects, surface, lane, [&](const Defect &d, double position, double rate, Height Heights::*) {
    double speed = std::fabs(rate) + 1e-300;
    if (d.order > 0.0) longest = std::min(longest, 2.0 * M_PI / (STEPS_PER_WAVE * d.order * speed));
    else {
      double x = std::copysign(d.radius, rate) * wrapped(position - d.middle), to_start = -d.half - x,
             circumference = 2.0 * M_PI * d.radius;
      double distance = std::max(d.bend / STEPS_PER_BEND, x < d.half ? to_start : to_start + circumference);
      if (x < -AT_MIDDLE * d.bend) distance = std::min(distance, -x);
      longest = std::min(longest, distance / (d.radius * speed));
    }
  });
  return longest;
}

// True if the ball in a lane crosses a defect within a step [s].
inline bool crosses_defect(const SurfaceDefects &defects, const SurfacePositions &surface, int lane, double step) {
  bool crosses = false;
  for_each_crossing_point(defects, surface, lane, [&](const Defect &d, double position, double rate, Height Heights::*) {
    double x = std::copysign(d.radius, rate) * wrapped(position - d.middle), end = x + 1.01 * d.radius * std::fabs(rate) * step;
    crosses |= d.order > 0.0 || (x < d.half && end > -d.half) || end > 2.0 * M_PI * d.radius - d.half;
  });
  return crosses;
}

}  // namespace core
