// The record of a contact from touch to parting.
#pragma once
#include "../math/vector3.hpp"
#include "../methods/events.hpp"

namespace core {

// Times [s]; the greatest load [N] with approach, curvatures, coefficient, semi-axes [m] and pressure [Pa] there; speeds [m/s];
// impulses [N s], in a contact that goes on those at its begin; greatest approach [m]; loads at ends of steps.
struct ContactRecord {
  double ended, began, peak_load, peak_approach, peak_small, peak_large, peak_coefficient, peak_major, peak_minor, peak_pressure;
  double speed_in, speed_out, impulse;
  Real3 friction_impulse;
  double deepest;
  Trail trail;

  // Takes a load if it is the greatest so far.
  template <class Contact>
  void keep_peak(const Contact &at) {
    if (!(at.normal_load > peak_load)) return;
    peak_load = at.normal_load, peak_approach = at.approach, peak_small = at.gap.small, peak_large = at.gap.large;
    peak_coefficient = at.coefficient, peak_major = at.patch.semi_major, peak_minor = at.patch.semi_minor;
    peak_pressure = at.patch.peak_pressure;
  }
};

}  // namespace core
