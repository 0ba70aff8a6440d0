// The door to impacts on a line; arrays are C-contiguous, contacts and nodes those of impact.hpp.
#include "../door.hpp"
#include "impact.hpp"

using namespace core;

namespace {

ImpactContact contact_of(const double *numbers) {
  Damping damping{DampingLaw(int(numbers[5])), numbers[6], numbers[7]};
  return {numbers[0], numbers[1], {numbers[2], numbers[3], numbers[4]}, damping, numbers[8]};
}

}  // namespace

// Follows a contact until `until` [s] with errors of a step below `scales` (3,); the first step is of `first` [s], none shorter
// than `least` [s]. Nodes (room, 4) begin with the touch. Returns a status.
CORE_EXPORT int core_follow_impact(const double *contact_numbers, double speed, const double *scales, double first, double least,
                                   double until, std::int64_t room, const volatile std::uint8_t *stop, double *nodes,
                                   std::int64_t *written, std::int64_t *counts) {
  ImpactContact contact = contact_of(contact_numbers);
  ImpactState state{0.0, speed, 0.0};
  ImpactClock clock{0.0, first, 0.0};
  Counts counted{};
  Collision collision(contact, {scales[0], scales[1], scales[2]}, least, state, clock, counted);
  auto *node = reinterpret_cast<ImpactNode *>(nodes);
  node[0] = {0.0, state};
  int found;
  Status status = collision.advance({until, 0, nullptr, stop}, &state, node + 1, int(room) - 1, found);
  *written = found + 1;
  counts[0] = counted.steps, counts[1] = counted.rejections, counts[2] = counted.evaluations;
  return status;
}
// Approach and rate (count, 2) at times [s], by a step from the node (number, 4) before each.
CORE_EXPORT void core_impact_states(const double *contact_numbers, std::int64_t number, const double *nodes, std::int64_t count,
                                    const double *times, double *states) {
  ImpactContact contact = contact_of(contact_numbers);
  auto *node = reinterpret_cast<const ImpactNode *>(nodes);
  for (std::int64_t i = 0; i < count; i++) {
    auto after = std::upper_bound(node + 1, node + number - 1, times[i], [](double time, const ImpactNode &one) { return time < one.time; });
    ImpactState state = impact_state_after(contact, after[-1].state, times[i] - after[-1].time);
    *states++ = state[0], *states++ = state[1];
  }
}
// See `follow_by_fixed_steps`.
CORE_EXPORT std::int64_t core_step_impact(const double *contact_numbers, std::int64_t method, double speed, double step, std::int64_t room,
                                          double *nodes) {
  return follow_by_fixed_steps(contact_of(contact_numbers), FixedStep(method), speed, step, room, reinterpret_cast<ImpactNode *>(nodes));
}
// Normal loads [N] and stored energies [J] (2, count) at approaches [m] and their rates [m/s].
CORE_EXPORT void core_impact_loads(const double *contact_numbers, std::int64_t count, const double *approach, const double *rate,
                                   double *found) {
  ImpactContact contact = contact_of(contact_numbers);
  for (std::int64_t i = 0; i < count; i++)
    found[i] = contact.load(approach[i], rate[i]), found[count + i] = contact.elastic_at(approach[i]).energy;
}
