// The door to which balls may meet.
#include "../door.hpp"
#include "neighbours.hpp"

using namespace core;

CORE_EXPORT void core_mark_near(double ball_radius, const double *state, std::int64_t balls, double reach, double ahead, std::uint8_t *near) {
  neighbours::mark_near(ball_radius, {state, int(balls)}, reach, ahead, near);
}
CORE_EXPORT std::int64_t core_mark_met(double ball_radius, const double *state, std::int64_t balls, const double *states,
                                       std::int64_t instants, double reach, std::uint8_t *near) {
  return neighbours::mark_met(ball_radius, {state, int(balls)}, states, int(instants), reach, near);
}
CORE_EXPORT double core_time_apart(double ball_radius, const double *state, std::int64_t balls, double reach) {
  return neighbours::time_apart(ball_radius, {state, int(balls)}, reach);
}
