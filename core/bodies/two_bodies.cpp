// Exported functions of two bodies; arrays are C-contiguous doubles in the order of kinds/bodies/motion.py.
#include "../exports.hpp"
#include "two_bodies.hpp"

using namespace core;

namespace {

ShapedBody body_of(const double *&next) {
  ShapedBody body{};
  body.mass = *next++;
  for (double &one : body.inertia) one = *next++;
  body.surface.kind = SurfaceKind(int(*next++));
  for (double &one : body.surface.size) one = *next++;
  body.surface.side = *next++, body.reach = *next++;
  return body;
}

TwoBodies pair_of(const double *next, const double *points) {
  TwoBodies pair{};
  pair.a = body_of(next), pair.b = body_of(next);
  for (double &one : pair.gravity) one = *next++;
  pair.sink = *next++, pair.size = *next++;
  pair.tracking = Tracking(int(*next++)), pair.by_overlap = *next++ != 0.0;
  pair.law.law = PointLaw(int(*next++)), pair.law.power = *next++, pair.law.modulus = *next++, pair.law.given = *next++;
  pair.damping.law = DampingLaw(int(*next++)), pair.damping.number = *next++, pair.damping.relaxation_time = *next++;
  pair.regularisation = *next++;
  pair.friction = patch_friction_of(next, points);
  return pair;
}

using State = Numbers<PAIR_NUMBERS>;

// Writes the channels of a state in their order, but those of the numerics.
void write_outputs(const TwoBodies &pair, const PairState &state, double *out) {
  auto put = [&](const auto &numbers) { out = std::copy(numbers.begin(), numbers.end(), out); };
  double kinetic = 0.0, potential = 0.0;
  for (auto [body, its] : {std::pair{&pair.a, state.a}, std::pair{&pair.b, state.b}}) {
    Real3 spin = body->spin(its, rotation_matrix(its.orientation));
    normalise(its.orientation);
    put(its.position), put(its.orientation), put(its.velocity), put(spin);
    put(body->held() ? Real3{} : its.momentum);
    kinetic += body->kinetic_energy(its, spin), potential -= body->mass * dot(pair.gravity, its.position);
  }
  PairContact at = pair.contact(state);
  *out++ = at.approach, *out++ = at.normal_load;
  put(at.friction);
  *out++ = at.spin_moment, *out++ = at.spin_rate;
  put(at.point), put(at.normal), put(at.slip), put(at.major_axis);
  *out++ = at.patch.semi_major, *out++ = at.patch.semi_minor, *out++ = at.patch.peak_pressure;
  *out++ = at.gap.small, *out++ = at.gap.large, *out++ = at.approach > 0.0;
  *out++ = kinetic, *out++ = potential, *out++ = at.elastic_energy;
  *out++ = state.dissipated_viscous, *out++ = state.dissipated_friction, *out++ = state.held_work, *out++ = state.gross_work;
}

}  // namespace

// Opens the record of a contact in which the bodies are at the start; `counts` (4,) ends with touches.
CORE_EXPORT void core_two_bodies_start(const double *numbers, const double *points, const double *plan, double *state, double *clock,
                                       double *record, std::int64_t *counts) {
  TwoBodies pair = pair_of(numbers, points);
  State before{};
  PairPlan how{plan[0], plan[1]};
  TwoBodiesMotion(pair, how, *reinterpret_cast<State *>(state), *reinterpret_cast<PairClock *>(clock),
                  *reinterpret_cast<ContactRecord *>(record), before,
                  *reinterpret_cast<Counts *>(counts), counts[3])
      .note_start();
}
// Moves on from `clock` until `until` [s]; `states` are those at the `instants` (outputs,) [s], `records` (room,) the contacts that
// have ended, of which there are `completed`. Returns a status.
CORE_EXPORT std::int64_t core_two_bodies_advance(const double *numbers, const double *points, const double *plan, double *state, double *clock,
                                                 double *record, double *before, double until, std::int64_t outputs, const double *instants,
                                                 const volatile std::uint8_t *stop, double *states, std::int64_t room, double *records,
                                                 std::int64_t *completed, std::int64_t *counts) {
  TwoBodies pair = pair_of(numbers, points);
  PairPlan how{plan[0], plan[1]};
  TwoBodiesMotion motion(pair, how, *reinterpret_cast<State *>(state), *reinterpret_cast<PairClock *>(clock),
                         *reinterpret_cast<ContactRecord *>(record), *reinterpret_cast<State *>(before), *reinterpret_cast<Counts *>(counts), counts[3]);
  int count;
  Status status = motion.advance({until, int(outputs), instants, stop}, reinterpret_cast<State *>(states),
                                 reinterpret_cast<ContactRecord *>(records), int(room), count);
  *completed = count;
  return !motion.tracked && (status == STALLED || status == NOT_FINITE) ? UNTRACKED : status;
}
// Outputs (count, width) of states (count, numbers).
CORE_EXPORT void core_two_bodies_outputs(const double *numbers, const double *points, std::int64_t count, const double *states,
                                         std::int64_t width, double *rows) {
  TwoBodies pair = pair_of(numbers, points);
  for (std::int64_t i = 0; i < count; i++) write_outputs(pair, std::bit_cast<PairState>(reinterpret_cast<const State *>(states)[i]), rows + i * width);
}
