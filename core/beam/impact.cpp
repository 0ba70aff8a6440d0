// Exported functions of a sphere on a beam; arrays are C-contiguous doubles, complex numbers two of them.
#include "../exports.hpp"
#include "contact_force.hpp"
#include "modes.hpp"

using namespace core;
using namespace core::beam;

// What all functions are given: `count` modes, their `rate` (count, 2) and `shape` (count,); `numbers`: modal mass, tail,
// mass, Hertz's coefficient and gravity of the sphere, time to reach; arrays of `room` pieces as in Impact.
#define IMPACT_ARGUMENTS                                                                                  \
  std::int64_t count, const double *rate, const double *shape, const double *numbers,                     \
      const volatile std::uint8_t *stop, std::int64_t room, double *start, double *length, double *force, \
      double *states, double *motion, double *work
#define IMPACT impact_of(count, rate, shape, numbers, stop, room, start, length, force, states, motion, work)

namespace {

Impact impact_of(IMPACT_ARGUMENTS) {
  Modes modes(int(count), reinterpret_cast<const Complex *>(rate), shape, numbers[0], numbers[1]);
  return {modes, {numbers[2], numbers[3], numbers[4]}, numbers[5], stop, int(room), start, length,
          reinterpret_cast<Force *>(force), reinterpret_cast<Complex *>(states), reinterpret_cast<SphereMotion *>(motion), work};
}

}  // namespace

// One contact by steps of `shortest` to `longest` [s], or by Volterra's equation (`by_volterra`) in steps of `longest`, from
// the piece `reached[0]`, whose start, states and motion are set; `reached` becomes the next piece. Returns the status.
CORE_EXPORT std::int64_t core_beam_contact(IMPACT_ARGUMENTS, std::int64_t by_volterra, double shortest, double longest,
                                           std::int64_t *reached) {
  Impact impact = IMPACT;
  int piece = int(*reached);
  Status status = by_volterra ? Volterra(impact, longest).contact(piece)
                              : Collocation(impact, shortest, longest).contact(piece);
  *reached = piece;
  return status;
}

// Closes the pieces from `first` to before `end`, whose lengths and forces are set.
CORE_EXPORT void core_beam_move(IMPACT_ARGUMENTS, std::int64_t first, std::int64_t end) {
  Impact impact = IMPACT;
  ModeSteps steps;
  for (int piece = int(first); piece < end && !*stop; piece++) {
    steps.set(impact.modes, impact.length[piece]);
    impact.close(piece, impact.length[piece], impact.force[piece], steps);
  }
}

// Time [s] from the start of a piece without a force to the next touch.
CORE_EXPORT double core_beam_next_touch(IMPACT_ARGUMENTS, std::int64_t piece, double limit, double shortest) {
  return next_touch(IMPACT, int(piece), limit, shortest);
}

// States of all modes (instants, count, 2), and force [N], position [m] and velocity [m/s] of the sphere (instants, 3) at
// increasing `times` [s] within the pieces.
CORE_EXPORT void core_beam_response(IMPACT_ARGUMENTS, std::int64_t instants, const double *times, double *state, double *sphere) {
  Impact impact = IMPACT;
  Complex *moved = reinterpret_cast<Complex *>(state);
  int piece = 0;
  for (int i = 0; i < instants && !*stop; i++, moved += count, sphere += 3) {
    while (piece + 1 < room && times[i] >= impact.start[piece + 1]) piece++;
    double span = times[i] - impact.start[piece], share = span / impact.length[piece];
    Force given = impact.force[piece], begun = given.beginning(share);
    propagate(impact.modes, span, begun, impact.state(piece), moved);
    SphereMotion now = impact.sphere.moved(impact.motion[piece], span, begun);
    sphere[0] = given.at(share), sphere[1] = now.position, sphere[2] = now.velocity;
  }
}
