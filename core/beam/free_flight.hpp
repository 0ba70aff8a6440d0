// Sphere and beam apart: both move in closed form, and the next touch is found without stepping over any.
#pragma once
#include <limits>
#include "pieces.hpp"

namespace core::beam {

struct Approach {
  double value, rate;  // [m], [m/s]
};

// The approach `time` [s] after the start of a piece of free flight.
inline Approach approach_after(const Impact &impact, int piece, double time) {
  SphereMotion start = impact.motion[piece];
  Approach found{impact.sphere.free_position(start, time), start.velocity + impact.sphere.gravity * time};
  for (int n = 0; n < impact.modes.count; n++) {
    Complex rate = impact.modes.rate[n], z = exponential(time * rate) * impact.state(piece)[n];
    found.value -= impact.modes.compliance[n] * z.im;
    found.rate -= impact.modes.shape[n] * (z.re + rate.re * z.im / rate.im);
  }
  return found;
}

// Time [s] until sphere and freely swinging beam touch again, `limit` if not before, infinite if never.
//
// No touch is stepped over: the approach bends at most by  B = g + sum |shape lambda^2 z| / Im lambda, so from a gap it
// stays one until alpha + alpha' t + B t^2 / 2 = 0, and so on from there; gaps that close for less than `shortest` [s]
// are passed.
inline double next_touch(const Impact &impact, int piece, double limit, double shortest) {
  const Sphere &sphere = impact.sphere;
  SphereMotion start = impact.motion[piece];
  double bend = std::fabs(sphere.gravity), reach = 0.0, time = 0.0;
  for (int n = 0; n < impact.modes.count; n++) {
    Complex rate = impact.modes.rate[n], z = impact.state(piece)[n];
    double size = std::fabs(impact.modes.compliance[n]) * std::hypot(z.re, z.im);
    reach += size;
    bend += size * (rate.re * rate.re + rate.im * rate.im);
  }
  for (int look = 0; look < 10'000'000; look++) {
    Approach found = approach_after(impact, piece, time);
    bool leaves = sphere.gravity <= 0.0 && start.velocity + sphere.gravity * time <= 0.0;
    if (leaves && sphere.free_position(start, time) < -reach) return std::numeric_limits<double>::infinity();
    if (time >= limit || !std::isfinite(found.value) || *impact.stop) return limit;
    if (found.value >= 0.0 && found.rate > 0.0 && time > 0.0) return time;
    double depth = std::max(-found.value, 0.0), root = std::sqrt(found.rate * found.rate + 2.0 * bend * depth);
    // (root - rate) / bend without cancellation for a closing gap
    double ahead = found.rate > 0.0 ? 2.0 * depth / (root + found.rate) : (root - found.rate) / bend;
    time += std::max(ahead, shortest);
  }
  return limit;
}

}  // namespace core::beam
