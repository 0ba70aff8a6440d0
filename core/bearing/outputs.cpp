// The door to outputs: fills rows (instants, columns) of all channels. `place` holds the numbers of RowPlaces in their
// order; `body_numbers`, loads and borders are those of coupled.cpp, and `coupled` says whether there are any.
#include <vector>
#include "../door.hpp"
#include "numbers.hpp"
#include "outputs.hpp"

using namespace core;

CORE_EXPORT void core_outputs(const double *bearing_numbers, const double *points, const double *drive, std::int64_t instants,
                              std::int64_t balls, const double *times, const double *states, const double *orientations,
                              std::int64_t coupled, const double *body_numbers, const double *load, const double *load_rate,
                              const double *borders, double rolling, const std::int64_t *place, double *out) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  RowPlaces places;
  for (int &one : places.first) one = int(*place++);
  for (int &one : places.width) one = int(*place++);
  for (int *one : {&places.ring, &places.shared, &places.neighbours, &places.position, &places.force, &places.columns}) *one = int(*place++);
  CoupledBodies bodies{};
  if (coupled) bodies = bodies_of(body_numbers, load, load_rate, drive);
  std::vector<BodyState> moving;
  for (std::int64_t i = 0; coupled && i < instants; i++) moving.push_back(state_of(bearing, bodies, borders + i * BORDER));
  outputs::Source from{bearing, {drive[0], drive[1], drive[2]}, int(instants), int(balls), times, states, orientations,
                       coupled ? &bodies : nullptr, moving.data(), rolling};
  if (bearing.over_patch()) outputs::write<true>(from, places, out);
  else outputs::write<false>(from, places, out);
}
