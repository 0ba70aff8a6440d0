// Exported functions of an ellipsoid on a plane; arrays are C-contiguous doubles in the order of kinds/bodies/motion.py.
#include "../exports.hpp"
#include "ellipsoid.hpp"

using namespace core;

namespace {

using State = Numbers<ELLIPSOID_NUMBERS>;

Ellipsoid ellipsoid_of(const double *next, const double *points) {
  Ellipsoid body{};
  body.mass = *next++;
  for (double &one : body.inertia) one = *next++;
  for (double &one : body.semi_axes) one = *next++;
  body.gravity = *next++, body.sink = *next++;
  body.law.law = PointLaw(int(*next++)), body.law.power = *next++, body.law.modulus = *next++, body.law.given = *next++;
  body.damping.law = DampingLaw(int(*next++)), body.damping.number = *next++, body.damping.relaxation_time = *next++;
  body.regularisation = *next++;
  body.friction = patch_friction_of(next, points);
  return body;
}

// Writes the channels of a state in their order, but that of the numerics.
void write_outputs(const Ellipsoid &body, EllipsoidState state, double *out) {
  auto put = [&](const auto &numbers) { out = std::copy(numbers.begin(), numbers.end(), out); };
  Ellipsoid::Pose pose = body.pose(state.motion);
  PlaneContact at = body.contact(state, pose);
  Ellipse patch = ellipse(at.gap.small, at.gap.large, body.law.modulus, at.normal_load);
  normalise(state.motion.orientation);
  put(state.motion.position), put(state.motion.orientation), put(state.motion.velocity), put(pose.spin), put(state.motion.momentum);
  *out++ = at.approach, *out++ = at.normal_load;
  put(at.friction);
  *out++ = at.spin_moment;
  put(state.motion.position + at.arm), put(at.slip), put(pose.rotation * at.gap.major_axis());
  *out++ = patch.semi_major, *out++ = patch.semi_minor, *out++ = patch.peak_pressure;
  *out++ = at.approach > 0.0;
  *out++ = body.kinetic_energy(state.motion, pose.spin);
  *out++ = body.mass * body.gravity * (state.motion.position[2] - body.least());
  *out++ = at.spring.energy, *out++ = state.dissipated_viscous, *out++ = state.dissipated_friction;
}

}  // namespace

// Completes a state whose momentum is an angular velocity, with its lowest point `height` [m] above the plane.
CORE_EXPORT void core_ellipsoid_start(const double *numbers, const double *points, double height, double *state) {
  Ellipsoid body = ellipsoid_of(numbers, points);
  auto &place = *reinterpret_cast<State *>(state);
  EllipsoidState start = std::bit_cast<EllipsoidState>(place);
  RealMatrix3 rotation = rotation_matrix(start.motion.orientation);
  Real3 spin = transposed(rotation) * start.motion.momentum;
  for (int i = 0; i < 3; i++) spin[i] *= body.inertia[i];
  start.motion.momentum = rotation * spin;
  start.motion.position[2] = height + body.pose(start.motion).low.extent;
  body.begin_shape(start);
  place = std::bit_cast<State>(start);
}
// Moves on from `clock` until `until` [s]; `states` are those at the `instants` (outputs,) [s], `records` (room,) the contacts that
// have ended, of which there are `completed`; `counts` (4,) ends with touches. Returns a status.
CORE_EXPORT std::int64_t core_ellipsoid_advance(const double *numbers, const double *points, const double *plan, double *state, double *clock,
                                                double *record, double *before, double until, std::int64_t outputs, const double *instants,
                                                const volatile std::uint8_t *stop, double *states, std::int64_t room, double *records,
                                                std::int64_t *completed, std::int64_t *counts) {
  Ellipsoid body = ellipsoid_of(numbers, points);
  EllipsoidMotion motion(body, *reinterpret_cast<const EllipsoidPlan *>(plan), *reinterpret_cast<State *>(state),
                         *reinterpret_cast<EllipsoidClock *>(clock), *reinterpret_cast<ContactRecord *>(record),
                         *reinterpret_cast<State *>(before), *reinterpret_cast<Counts *>(counts), counts[3]);
  int count;
  Status status = motion.advance({until, int(outputs), instants, stop}, reinterpret_cast<State *>(states),
                                 reinterpret_cast<ContactRecord *>(records), int(room), count);
  *completed = count;
  return status;
}
// Outputs (count, width) of states (count, numbers).
CORE_EXPORT void core_ellipsoid_outputs(const double *numbers, const double *points, std::int64_t count, const double *states,
                                        std::int64_t width, double *rows) {
  Ellipsoid body = ellipsoid_of(numbers, points);
  for (std::int64_t i = 0; i < count; i++)
    write_outputs(body, std::bit_cast<EllipsoidState>(reinterpret_cast<const State *>(states)[i]), rows + i * width);
}
// Where an ellipsoid reaches farthest along directions (count, 3), and its gap there (count, 16): extent, point, P, Q, direction of
// the longer axis, excess, gradients of size and shape (see ellipsoid.hpp).
CORE_EXPORT void core_ellipsoid_gaps(const double *semi_axes, std::int64_t count, const double *directions, double *found) {
  Real3 axes{semi_axes[0], semi_axes[1], semi_axes[2]};
  for (std::int64_t i = 0; i < count; i++, directions += 3) {
    Real3 direction{directions[0], directions[1], directions[2]};
    Reach reach = ellipsoid_reach(axes, direction);
    PlaneGap gap = ellipsoid_gap(axes, direction, reach);
    GapSlopes slopes = ellipsoid_slopes(axes, direction, reach);
    auto put = [&](const Real3 &vector) { found = std::copy(vector.begin(), vector.end(), found); };
    *found++ = reach.extent, put(reach.point), *found++ = gap.small, *found++ = gap.large, put(gap.major_axis());
    *found++ = gap.excess, put(slopes.size), put(slopes.shape);
  }
}
