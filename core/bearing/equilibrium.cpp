// Exported functions of equilibria of rings and shafts; arrays are C-contiguous. `seats` (count, SEAT_NUMBERS) are `Seat`s,
// `balls` (count,) their numbers of balls, whose arrays are concatenated: `azimuth` [rad] (N,), `positions`
// (N, 2), `contacts` (N, CONTACT_NUMBERS); see equilibrium.hpp.
#include "equilibrium.hpp"

using namespace core;
using namespace core::equilibria;

namespace {

static_assert(sizeof(Seat) == 41 * sizeof(double), "Setting.numbers in bearing_twin writes a Seat as so many doubles");

const Seat *seats_in(const double *numbers) { return reinterpret_cast<const Seat *>(numbers); }
Vector5 five(const double *numbers) { return {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4]}; }
FreeMask free_mask(const std::int64_t *free) { return {free[0] != 0, free[1] != 0, free[2] != 0, free[3] != 0, free[4] != 0}; }
void write(const Vector5 &five, double *out) { std::copy(five.begin(), five.end(), out); }
void write(const Matrix5 &matrix, double *out) {
  for (const Vector5 &row : matrix) write(row, out), out += COORDINATES;
}

void write_heights(const SurfaceDefects &defects, double azimuth, double ring_angle, int ball, double *out) {
  Quaternion start{Pack{}, Pack{}, broadcast<Pack>(-std::sin(0.5 * azimuth)), broadcast<Pack>(std::cos(0.5 * azimuth))};
  Mask first = ball == 0 ? ~Mask{} : Mask{};
  Heights surface_heights = heights_at(
      defects, surface_positions(broadcast<Pack>(azimuth), Pack{}, broadcast<Pack>(ring_angle), Pack{}, start, Triple{}, first),
      Pack{});
  out[0] = surface_heights.inner.value[0], out[1] = surface_heights.outer.value[0];
}

// The mean orbit speed, weighted by load on the inner ring, of balls in one cage.
double shared_orbit(const double *contacts, int balls) {
  double weight = 0.0, total = 0.0, sum = 0.0;
  for (int k = 0; k < balls; k++, contacts += CONTACT_NUMBERS)
    weight += contacts[2], total += contacts[2] * contacts[12], sum += contacts[12];
  return weight > 0.0 ? total / weight : sum / balls;
}

}  // namespace

// Independent equilibria: of `free` (5,) coordinates the loads `requested` (cases, 5) are prescribed, of the others
// `held` (cases, 5). `heights` (cases, N, 2) are those of the raceways under the balls. Stops between two cases.
CORE_EXPORT void core_equilibria(std::int64_t cases, std::int64_t count, const std::int64_t *balls, const double *seats,
                                 const double *azimuth, const double *heights, const std::int64_t *free, const double *requested,
                                 const double *held, const volatile std::uint8_t *stop, double *q, double *load, double *stiffness,
                                 double *positions, double *contacts, double *imbalance, std::int64_t *status) {
  System system;
  std::int64_t all = 0;
  for (int i = 0; i < count; i++) all += balls[i];
  for (std::int64_t k = 0; k < cases; k++, seats += count * (sizeof(Seat) / sizeof(double)), azimuth += all, heights += 2 * all) {
    system.set(seats_in(seats), int(count), balls);
    system.place_balls(azimuth, heights);
    status[k] =
        *stop ? STOPPED : system.solve_in_parts(free_mask(free), five(requested + COORDINATES * k), five(held + COORDINATES * k));
    imbalance[k] = system.imbalance;
    write(system.q, q + COORDINATES * k);
    write(system.load, load + COORDINATES * k);
    write(system.stiffness, stiffness + COORDINATES * COORDINATES * k);
    system.write_positions(positions + 2 * all * k);
    system.write_contacts(contacts + CONTACT_NUMBERS * all * k);
  }
}

// Heights (N, 2) [m] of the inner and the outer raceway under balls at these azimuths, the ring turned by an angle [rad]: as
// in `core_equilibria`; a ball's own are those of its start. `defect_numbers` are those of a bearing.
CORE_EXPORT void core_surface_heights(const double *defect_numbers, std::int64_t balls, const double *azimuth, double ring_angle,
                                      double *heights) {
  SurfaceDefects defects = defects_of(defect_numbers);
  for (int k = 0; k < balls; k++) write_heights(defects, azimuth[k], ring_angle, k, heights + 2 * k);
}

// A run of equilibria: a ring of which the coordinates that are not `free` are `held` (instants, 5), turned by `turn` [rad]
// and at `speed` [rad/s], `step` [s] after the instant before. The balls orbit by the cage's share `cage[1]` of the turn
// from the instant before on, where `cage[0]` [rad] was the azimuth of ball 0, and turn about themselves as at the instant;
// `attitude` (N, 4) are their orientations in the frame that goes round with each. Returns the status of the last instant,
// whose number is in `instant`: FOUND for all.
CORE_EXPORT std::int64_t core_equilibrium_run(const double *seat_numbers, const double *defect_numbers, double ring_angle,
                                              std::int64_t balls, std::int64_t instants, const double *step, const double *turn,
                                              const double *speed, const double *held, const std::int64_t *free,
                                              const double *requested, const volatile std::uint8_t *stop, double *cage, double *q,
                                              double *attitude, double *azimuths, double *orbits, double *coordinates,
                                              double *loads, double *positions, double *attitudes, double *contacts,
                                              std::int64_t *instant) {
  Seat seat = *seats_in(seat_numbers);
  System system;
  const FreeMask mask = free_mask(free);
  const Vector5 load = five(requested);
  std::vector<double> azimuth(balls), heights(2 * balls);
  SurfaceDefects defects = defects_of(defect_numbers);
  system.set(&seat, 1, &balls);
  system.q = five(q);
  for (std::int64_t &t = *instant = 0; t < instants; t++, contacts += CONTACT_NUMBERS * balls) {
    if (*stop) return STOPPED;
    seat.speed = speed[t];
    cage[0] += cage[1] * turn[t];
    for (int k = 0; k < balls; k++) azimuth[k] = cage[0] + 2.0 * M_PI * k / double(balls);
    ring_angle += turn[t];
    for (int k = 0; k < balls; k++) write_heights(defects, azimuth[k], ring_angle, k, &heights[2 * k]);
    system.place_balls(azimuth.data(), heights.data());
    const Vector5 held_now = five(held + COORDINATES * t);
    for (int i = 0; i < COORDINATES; i++)
      if (!mask[i]) system.q[i] = held_now[i];
    Status status = system.solve_from_present(mask, load);
    if (status != CONVERGED) status = system.solve_in_parts(mask, load, held_now);
    if (status != CONVERGED) return status;
    system.write_contacts(contacts);
    cage[1] = seat.speed != 0.0 ? shared_orbit(contacts, int(balls)) / seat.speed : 0.5 * (1.0 - seat.gamma());
    azimuths[t] = cage[0], orbits[t] = cage[1] * seat.speed;
    write(system.q, coordinates + COORDINATES * t);
    write(system.load, loads + COORDINATES * t);
    write(system.q, q);
    system.write_positions(positions + 2 * balls * t);
    for (int k = 0; k < balls; k++) {
      const double *contact = contacts + CONTACT_NUMBERS * k;
      const std::int64_t row = balls * t + k;
      Triple spin{broadcast<Pack>(contact[14]), Pack{}, broadcast<Pack>(-contact[13])};
      Quaternion attitude_in_frame,
          orbit_rotation{Pack{}, Pack{}, broadcast<Pack>(std::sin(0.5 * azimuth[k])), broadcast<Pack>(std::cos(0.5 * azimuth[k]))};
      for (int i = 0; i < 4; i++) attitude_in_frame[i] = broadcast<Pack>(attitude[4 * k + i]);
      attitude_in_frame = rotated(attitude_in_frame, spin, spin, spin, broadcast<Pack>(step[t]));
      const Quaternion fixed = product(orbit_rotation, attitude_in_frame);
      for (int i = 0; i < 4; i++) attitude[4 * k + i] = attitude_in_frame[i][0], attitudes[4 * row + i] = fixed[i][0];
    }
  }
  return CONVERGED;
}
