// Impacts on a line, and their exported functions; arrays are C-contiguous.
#include "../contact/laws.hpp"
#include "../methods/adaptive.hpp"

namespace core {

// Two bodies that collide on a line: mu x'' = -load(x, x'), x = 0 and x' = v at the first contact, until x returns to zero.

// The contact of the two: a line contact where `line.scale` is above zero, else a load c h^power.
struct ImpactContact {
  double coefficient, power;
  LineContact line;
  Damping damping;
  double reduced_mass;

  Elastic<double, double, double> elastic_at(double approach) const {
    return line.scale > 0.0 ? line_elastic(line, approach) : elastic(coefficient, power, approach);
  }
  // Normal load [N] with its viscous part, negative where the bodies would attract each other.
  double pulling_load(double approach, double rate) const {
    auto [load, stiffness, energy] = elastic_at(approach);
    return damping.pulling_load(coefficient, power, load, stiffness, reduced_mass, approach, rate);
  }
  double load(double approach, double rate) const {
    auto [load, stiffness, energy] = elastic_at(approach);
    return damping.load(coefficient, power, load, stiffness, reduced_mass, approach, rate);
  }
};

// Approach [m], its rate [m/s] and the energy dissipated [J]; the same at a time [s] of the collision.
using ImpactState = Numbers<3>;
struct ImpactNode {
  double time;
  ImpactState state;
};

inline void impact_rates(const ImpactContact &contact, const ImpactState &state, Numbers<3> &slopes) {
  double load = contact.load(state[0], state[1]);
  slopes = {state[1], -load / contact.reduced_mass, (load - contact.elastic_at(state[0]).load) * state[1]};
}

// State `step` [s] after another by dop853.
inline ImpactState impact_state_after(const ImpactContact &contact, const ImpactState &state, double step) {
  ImpactState after;
  explicit_step<3>(
      DOP853, [&](const ImpactState &trial, Numbers<3> &slopes) { impact_rates(contact, trial, slopes); },
      ImpactState{1.0, 1.0, 1.0}, state, step, after);
  return after;
}

struct ImpactClock {
  double time, step, written;
};

// The contact integrated from start to separation by error-controlled steps, no shorter than `least` [s].
class Collision : public AdaptiveMotion<Collision, 3, 3, ImpactClock> {
 public:
  Collision(const ImpactContact &contact, const State &scale, double least, State &state, ImpactClock &clock, Counts &counts)
      : AdaptiveMotion(DOP853, state, clock, counts), contact(contact), least(least) {
    scales = scale;
  }
  void rates(const State &numbers, bool, Slopes &slopes) const { impact_rates(contact, numbers, slopes); }
  StepStart start_step() const { return {OK, clock.step, least, true}; }
  StepEnd end_step(double step, bool) {
    auto remaining = [&](const State &numbers) {
      // By steady damping elastic and viscous part cancel before the approach is zero again.
      bool steady = contact.damping.law != DampingLaw::proportional;
      return steady ? contact.pulling_load(std::max(numbers[0], 0.0), numbers[1]) : numbers[0];
    };
    separated = !(remaining(after) > 0.0) && std::isfinite(after[0]);
    return {OK, separated ? end_at_sign_change(remaining, step, 0.0) : step};
  }
  void correct(State &) const {}
  Accepted accept(double, double proposed, bool) {
    state = after, clock.step = proposed;
    return {separated ? SEPARATED : OK, true};
  }
  ImpactNode record() const { return {clock.time, state}; }

 private:
  const ImpactContact &contact;
  double least;
  bool separated = false;
};

enum class FixedStep { rk4, symplectic_euler };  // as in kinds/bodies/parameters.py

// Steps of fixed length through a contact, from half a step before its start to the first node after separation. Returns the number
// of nodes (capacity,) written, negative where bodies do not separate or the load is not finite.
inline std::int64_t integrate_by_fixed_steps(const ImpactContact &contact, FixedStep method, double speed, double step,
                                             std::int64_t capacity, ImpactNode *nodes) {
  auto rates = [&](const ImpactState &at, Numbers<3> &slopes) { impact_rates(contact, at, slopes); };
  ImpactState state{-0.5 * step * speed, speed, 0.0}, after;
  nodes[0] = {-0.5 * step, state};
  for (std::int64_t n = 1; n < capacity; n++) {
    if (method == FixedStep::rk4) {
      explicit_step<3>(RK4, rates, ImpactState{1.0, 1.0, 1.0}, state, step, after);
      state = after;
    } else {
      Numbers<3> slopes;
      rates(state, slopes);
      state[1] += step * slopes[1], state[2] += step * slopes[2], state[0] += step * state[1];
    }
    nodes[n] = {(double(n) - 0.5) * step, state};
    if (!std::isfinite(state[0] + state[1])) return -n;
    if (state[0] <= 0.0 && state[1] < 0.0) return n + 1;
  }
  return -capacity;
}

}  // namespace core

using namespace core;

namespace {

ImpactContact contact_of(const double *numbers) {
  Damping damping{DampingLaw(int(numbers[5])), numbers[6], numbers[7]};
  return {numbers[0], numbers[1], {numbers[2], numbers[3], numbers[4]}, damping, numbers[8]};
}

}  // namespace

// Integrates a contact until `until` [s] with errors of a step below `scales` (3,); the first step is `first` [s], the shortest `least`
// [s]. Nodes (capacity, 4) begin with the start of the contact. Returns a status.
CORE_EXPORT int core_follow_impact(const double *contact_numbers, double speed, const double *scales, double first, double least,
                                   double until, std::int64_t capacity, const volatile std::uint8_t *stop, double *nodes,
                                   std::int64_t *written, std::int64_t *counts) {
  ImpactContact contact = contact_of(contact_numbers);
  ImpactState state{0.0, speed, 0.0};
  ImpactClock clock{0.0, first, 0.0};
  Counts counted{};
  Collision collision(contact, {scales[0], scales[1], scales[2]}, least, state, clock, counted);
  auto *node = reinterpret_cast<ImpactNode *>(nodes);
  node[0] = {0.0, state};
  int completed;
  Status status = collision.advance({until, 0, nullptr, stop}, &state, node + 1, int(capacity) - 1, completed);
  *written = completed + 1;
  counts[0] = counted.steps, counts[1] = counted.rejections, counts[2] = counted.evaluations;
  return status;
}
// Approach and rate (count, 2) at times [s], by a step from the node (number, 4) before each.
CORE_EXPORT void core_impact_states(const double *contact_numbers, std::int64_t number, const double *nodes, std::int64_t count,
                                    const double *times, double *states) {
  ImpactContact contact = contact_of(contact_numbers);
  auto *node = reinterpret_cast<const ImpactNode *>(nodes);
  for (std::int64_t i = 0; i < count; i++) {
    auto after = std::upper_bound(node + 1, node + number - 1, times[i],
                                  [](double time, const ImpactNode &node_after) { return time < node_after.time; });
    ImpactState state = impact_state_after(contact, after[-1].state, times[i] - after[-1].time);
    *states++ = state[0], *states++ = state[1];
  }
}
// See `integrate_by_fixed_steps`.
CORE_EXPORT std::int64_t core_step_impact(const double *contact_numbers, std::int64_t method, double speed, double step,
                                          std::int64_t capacity, double *nodes) {
  return integrate_by_fixed_steps(contact_of(contact_numbers), FixedStep(method), speed, step, capacity,
                                  reinterpret_cast<ImpactNode *>(nodes));
}
// Normal loads [N] and stored energies [J] (2, count) at approaches [m] and their rates [m/s].
CORE_EXPORT void core_impact_loads(const double *contact_numbers, std::int64_t count, const double *approach, const double *rate,
                                   double *out) {
  ImpactContact contact = contact_of(contact_numbers);
  for (std::int64_t i = 0; i < count; i++)
    out[i] = contact.load(approach[i], rate[i]), out[count + i] = contact.elastic_at(approach[i]).energy;
}
