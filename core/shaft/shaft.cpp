// The door to the motion of a shaft on two bearings; arrays are C-contiguous doubles, structs of rotor.hpp and
// integration.hpp in the order of their members.
#include "../bearing/numbers.hpp"
#include "../door.hpp"
#include "integration.hpp"

using namespace core;
using namespace core::shaft;

namespace {

template <class Struct>
Struct &at(double *numbers) { return *reinterpret_cast<Struct *>(numbers); }
template <class Struct>
const Struct &at(const double *numbers) { return *reinterpret_cast<const Struct *>(numbers); }

template <class Struct>
constexpr int numbers_in = sizeof(Struct) / sizeof(double);
static_assert(numbers_in<Rotor> == 41 && numbers_in<CoursePart> == 14 && numbers_in<Bounds> == 7 && numbers_in<Clock> == 5 &&
              numbers_in<KeptStep> == 4 * STATE, "kinds/shaft in bearing_twin writes so many doubles");

}  // namespace

// Steps from the step kept on until one reaches `until` [s], and fills `rows` (instants, width) at `times` [s]. `seats` (2,
// SEAT) and `balls` (2,) are of both bearings; `course` (parts, 14) holds the parts from that of the step kept on; `scales`
// (10,) are errors that count as 1. `moved` and `shown` (N, BALL_MEMORY) are balls in equilibrium, of the motion and of its
// outputs. `clock` (5,), `kept` (4, 14), both memories and `counts` (3,) are moved on in place.
CORE_EXPORT std::int64_t core_shaft_advance(const double *rotor_numbers, const double *seats, const std::int64_t *balls,
                                            const double *course, std::int64_t parts, const double *method_numbers,
                                            const double *scales, const double *bounds, std::int64_t instants, const double *times,
                                            double until, const volatile std::uint8_t *stop, double *clock, double *kept,
                                            double *moved, double *shown, std::int64_t *counts, double *rows, std::int64_t width) {
  const Rotor &rotor = at<Rotor>(rotor_numbers);
  const RosenbrockMethod method = method_of(method_numbers);
  Method::Scales its_scales;
  std::copy(scales, scales + MOVING, its_scales.begin());
  Bearings of_motion(rotor, &at<Seat>(seats), balls, moved), of_outputs(rotor, &at<Seat>(seats), balls, shown);
  Method steps(method, its_scales);
  Outputs outputs(rotor, of_outputs, int(balls[0] + balls[1]));
  Motion motion{at<Clock>(clock), at<KeptStep>(kept), counts};
  Integration integration(rotor, &at<CoursePart>(course), int(parts), at<Bounds>(bounds), of_motion, steps, outputs, motion);
  const Status status = integration.run(until, {times, int(instants), rows, int(width)}, method.order, stop);
  return status == OK && !motion.kept.finite() ? NOT_FINITE : status;
}

// Drops what of the step kept lies beyond `time` [s].
CORE_EXPORT void core_shaft_restart(double *clock, double *kept, double time) {
  restart(at<Clock>(clock), at<KeptStep>(kept), time);
}
