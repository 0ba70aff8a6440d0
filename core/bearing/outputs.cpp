// Exported functions of outputs: fills rows (instants, columns) of all channels. `place` holds the numbers of RowPlaces in their
// order; `body_numbers`, loads and borders are those of coupled.cpp, and `coupled` says whether there are any.
#include <vector>
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

// Sums over the outputs of a bearing for its figures (kinds/bearing/figures.py), output by output, so that they do not
// depend on how a stream of outputs is cut into blocks.

namespace {

constexpr int MISSING = -1;  // the first column of a channel that is not there
enum Column {
  LOAD, TORQUE, RING_TORQUE, ROLL, SPEED, SLIP, ANGLE, POCKET, WORK, RING_ANGLE, LOAD_WORK, AT_GREATEST, RING = AT_GREATEST + 4,
  OFFSET = RING + 4, VELOCITY, LAND_FORCE
};
constexpr int RING_PARTS[4] = {3, 2, 3, 2}, RING_WIDTH = 10;

// One row of sums over a stretch, in the order of figures.StretchSums.
struct Stretch {
  double *row;
  int balls;
  double &time() const { return row[0]; }
  double *orbit_angle() const { return row + 1; }
  double *turned() const { return row + 1 + balls; }
  double &count() const { return turned()[2]; }
  double *load() const { return turned() + 3; }
  double *torque() const { return load() + 2 * balls; }
  double *scalars() const { return torque() + balls; }  // drive torque, roll rate, speed, cage slip
  double *centre() const { return scalars() + 4; }
  double *ring() const { return centre() + 3; }
};
// The greatest so far, in the order of figures.Greatest.
struct Greatest {
  double *numbers;
  int balls;
  double *load() const { return numbers; }
  double *there() const { return numbers + 2 * balls; }  // (4, 2 balls)
  double *without() const { return numbers + 10 * balls; }
  double *off_even() const { return numbers + 12 * balls; }  // then the greatest pocket force and land force
};

void add_centre(const std::int64_t *column, const double *row, const Greatest &greatest, double *centre) {
  if (column[OFFSET] == MISSING) return;
  const double *offset = row + column[OFFSET], *velocity = row + column[VELOCITY], *force = row + column[LAND_FORCE];
  double square = offset[0] * offset[0] + offset[1] * offset[1];
  centre[0] += std::sqrt(square), centre[1] += square;
  centre[2] += offset[0] * velocity[1] - offset[1] * velocity[0];
  double pull = std::sqrt(force[0] * force[0] + force[1] * force[1]);
  greatest.off_even()[2] = std::max(greatest.off_even()[2], pull);
}

void add(const std::int64_t *column, const double *row, double seconds, bool begins, const Greatest &greatest, const Stretch &sums) {
  int balls = sums.balls;
  sums.time() = seconds, sums.count() += 1.0;
  for (int contact = 0; contact < 2 * balls; contact++) {
    double load = row[column[LOAD] + contact];
    sums.load()[contact] += load;
    if (!(load > 0.0)) greatest.without()[contact] += 1.0;
    if (load > greatest.load()[contact]) {
      greatest.load()[contact] = load;
      for (int k = 0; k < 4; k++) greatest.there()[k * 2 * balls + contact] = row[column[AT_GREATEST + k] + contact];
    }
  }
  double mean = 0.0, even = 2.0 * M_PI / balls, *most = greatest.off_even();
  for (int k = 0; k < balls; k++) {
    const double *torque = row + column[TORQUE] + 3 * k, *angle = row + column[ANGLE] + k;
    sums.torque()[k] += std::sqrt(torque[0] * torque[0] + torque[1] * torque[1] + torque[2] * torque[2]);
    sums.orbit_angle()[k] = *angle;
    mean += row[column[ROLL] + k];
    if (k > 0) most[0] = std::max(most[0], std::fabs(angle[0] - angle[-1] - even));
    if (column[POCKET] != MISSING) most[1] = std::max(most[1], std::fabs(row[column[POCKET] + k]));
  }
  double *scalar = sums.scalars();
  scalar[0] -= row[column[RING_TORQUE] + 2], scalar[1] += mean / balls, scalar[2] += row[column[SPEED]];
  scalar[3] += column[SLIP] != MISSING ? row[column[SLIP]] : 0.0;
  sums.turned()[0] = row[column[WORK]] - (column[LOAD_WORK] != MISSING ? row[column[LOAD_WORK]] : 0.0);
  sums.turned()[1] = row[column[RING_ANGLE]];
  add_centre(column, row, greatest, sums.centre());
  double *sum = sums.ring(), *least = sum + RING_WIDTH, *highest = least + RING_WIDTH;
  for (int part = 0; part < 4; part++)
    for (int axis = 0; axis < RING_PARTS[part]; axis++, sum++, least++, highest++) {
      double value = row[column[RING + part] + axis];
      *sum += value;
      *least = std::min(value, begins ? value : *least);
      *highest = std::max(value, begins ? value : *highest);
    }
}

}  // namespace

// Adds outputs (count, width) to the greatest and to the stretches (capacity, stretch width) from row `done[1]` on, which is
// 0; fills `done` with how many outputs were written and the row after the last. Every call begins a stretch.
CORE_EXPORT void core_sum_outputs(const std::int64_t *columns, const double *numbers, std::int64_t count, std::int64_t width,
                                  const std::int64_t *time_ns, std::int64_t first_sequence, std::int64_t stretch_length,
                                  std::int64_t balls, double *greatest, double *stretches, std::int64_t capacity,
                                  std::int64_t stretch_width, std::int64_t *done) {
  std::int64_t stretch = done[1];
  for (std::int64_t n = 0; n < count; n++) {
    bool begins = n == 0 || (first_sequence + n) % stretch_length == 0;
    if (begins && n > 0) stretch++;
    if (stretch == capacity) {
      done[0] = n, done[1] = stretch;
      return;
    }
    add(columns, numbers + n * width, 1e-9 * double(time_ns[n]), begins, {greatest, int(balls)},
        {stretches + stretch * stretch_width, int(balls)});
  }
  done[0] = count, done[1] = stretch + 1;
}
