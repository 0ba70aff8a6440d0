// Outputs of a bearing: rows of all channels (kinds/bearing/outputs.py) from the states of the balls and of ring, cage and shaft,
// with the contacts of the equations of motion.
#include <vector>
#include "elements.hpp"
#include "neighbours.hpp"
#include "numbers.hpp"

namespace core {

constexpr int BALL_CHANNELS = 21, SUMS = 18;  // the last two channels are those of films, of width 0 where there are none
// Layout of a row: the numbers of ball k in its channel i at first[i] + k width[i]; then the first column of the ring, of the sums
// over the balls, of contacts between neighbours, of positions and of forces of the raceways. Rows without contacts, whose
// `neighbours` are negative, start with the ring's numbers and end with the sums.
struct RowLayout {
  int first[BALL_CHANNELS], width[BALL_CHANNELS], ring, shared, neighbours, position, force, columns;
  bool contacts() const { return neighbours >= 0; }
};

namespace outputs {

// Columns after the ring's angle.
enum RingColumn {
  RING_SPEED = 1,
  RING_OFFSET,
  RING_TILT = 5,
  RING_VELOCITY = 7,
  TILT_RATE = 10,
  RING_LOAD = 12,
  RING_LOAD_WORK = 15,
  DRIVE_TORQUE,
  CAGE_TURN,
  CAGE_SPEED,
  CAGE_SLIP,
  POCKET_FORCE
};
// Sums over the balls.
enum Sum { INNER_FORCE, INNER_TORQUE = 3, OUTER_FORCE = 6, OUTER_TORQUE = 9, KINETIC = 12, ELASTIC, POTENTIAL, WORK, LOSS, GROSS };

using Vector = Vector3<Pack>;

// Pose and motion of a ring for the balls in lanes, in bearing_link.
struct RingPose {
  Vector centre, tilt, drift, turning;
  Pack speed, angle;
};

// A contact in bearing_link, the normal in the direction of the load; force and torque on the ball about its centre.
struct Contact {
  Pack approach, normal_load, energy, contact_angle, spin_rate, spin_moment, small, large, film{}, film_ratio{};
  Vector point, normal, friction, slip, force, torque;
};

// The contact of a ball with a raceway of this ring. The contact angle is that against the radial plane, above zero where the inner
// ring is pushed along +z; `outwards` is 1 at the outer ring, -1 at the inner one.
template <bool PATCH>
CORE_INLINE Contact output_contact(const Bearing &bearing, const Raceway &raceway, double outwards, const RingPose &ring,
                                   const Vector &position, const Vector &velocity, const Vector &spin, const Height &height) {
  auto axes = ring_axes(ring.tilt.x, ring.tilt.y);
  auto in_link = [&](const auto &v) __attribute__((always_inline)) { return out_of_ring(axes, as_packs(v)); };
  Vector offset = into_ring(axes, position - ring.centre);
  Vector relative = into_ring(axes, (velocity - ring.drift) - cross(ring.turning, offset));
  auto result =
      raceway_contact<PATCH>(bearing, raceway, nullptr, height, offset, relative, into_ring(axes, spin - ring.turning), ring.speed);
  const auto &geometry = result.geometry;
  const auto &action = result.action;
  Contact contact;
  Vector arm = in_link(geometry.arm);
  contact.normal = -1.0 * in_link(geometry.normal), contact.point = position + arm;
  contact.friction = in_link(action.friction), contact.slip = in_link(action.slip);
  contact.approach = geometry.approach, contact.normal_load = action.normal_load, contact.spin_rate = result.spin;
  contact.energy = elastic_energy(bearing.power, geometry.load, maximum(geometry.approach, 0.0));
  contact.small = broadcast<Pack>(bearing.curvature_across(raceway)),
  contact.large = bearing.curvature_along(raceway, geometry.radial);
  contact.spin_moment = as_pack(action.spin_moment);
  contact.force = contact.normal_load * contact.normal;
  if (const auto &film = result.film; bearing.lubricant.works()) {
    Vector along = in_link(film.resistance * Vector{film.x, film.y, Pack{}});
    contact.friction = contact.friction - along;
    contact.force = contact.force + film.lead * along;  // its pressure, through the ball's centre
    contact.film_ratio = select(geometry.load > 0.0, exponential(film.log_ratio), Pack{});
    contact.film = contact.film_ratio * std::exp(bearing.lubricant.log_roughness);
  }
  contact.force = contact.force + contact.friction;
  contact.torque = cross(arm, contact.friction) - contact.spin_moment * contact.normal;
  Pack in_plane = square_root(contact.normal.x * contact.normal.x + contact.normal.y * contact.normal.y);
  contact.contact_angle =
      each_lane((0.0 - outwards * contact.normal.z) / in_plane, [](double tangent) { return std::atan(tangent); });
  return contact;
}

// Moment of a contact on a ring about its centre, as in `raceway_forces`: about x and y by virtual work of tilts of
// first order, of the ball's position in the ring's axes and the force in those of bearing_link; about z about the
// ring's axis.
CORE_INLINE Vector moment_on_ring(const RingPose &ring, const Vector &position, const Vector &force, const Vector &torque) {
  Vector offset = into_ring(ring_axes(ring.tilt.x, ring.tilt.y), position - ring.centre);
  Vector level = cross(offset, force) + torque;
  Vector turned = cross(offset, force - cross(ring.tilt, force)) + (torque - cross(ring.tilt, torque));
  return {-level.x, -level.y, -turned.z};
}

// The numbers of one ball in the order of its channels, and its shares in the sums.
struct BallRow {
  Pack numbers[66], shares[SUMS];  // the total width of all channels of a ball
  int count = 0;
  CORE_INLINE void put(const Pack &x) { numbers[count++] = x; }
  CORE_INLINE void put(const Vector &v) { put(v.x), put(v.y), put(v.z); }
};

// `first` are lanes of the first ball.
template <bool PATCH>
[[gnu::noinline]] inline void fill(const Bearing &bearing, const RingPose &inner_ring, const RingPose &outer_ring,
                                   const BallState &y, const Quaternion &ball_orientation, const Mask &first, BallRow &row) {
  auto [cosine, sine] = cosine_sine_value(y[ANGLE]);
  Pack c = cosine, s = sine;
  auto in_link = [&](const Vector &v) __attribute__((always_inline)) { return about_z(c, s, v); };
  Vector position = in_link({y[RADIUS], Pack{}, y[HEIGHT]}), velocity = in_link({y[VELOCITY], y[VELOCITY + 1], y[VELOCITY + 2]});
  Vector spin = in_link({y[SPIN], y[SPIN + 1], y[SPIN + 2]});
  Heights heights;
  if (bearing.defects.count) {
    Pack orbit_rate = y[VELOCITY + 1] / y[RADIUS];
    heights = heights_at(bearing.defects,
                         surface_positions(y[ANGLE], orbit_rate, inner_ring.angle, inner_ring.speed, ball_orientation,
                                           {y[SPIN], y[SPIN + 1], y[SPIN + 2] - orbit_rate}, first),
                         Pack{});
  }
  Contact inner = output_contact<PATCH>(bearing, bearing.inner, -1.0, inner_ring, position, velocity, spin, heights.inner);
  Contact outer = output_contact<PATCH>(bearing, bearing.outer, 1.0, outer_ring, position, velocity, spin, heights.outer);
  auto [half_cosine, half_sine] = cosine_sine_value(Pack(0.5 * y[ANGLE]));
  Quaternion orientation = product({Pack{}, Pack{}, half_sine, half_cosine}, ball_orientation);

  row.count = 0;
  row.put(y[ANGLE]), row.put(position), row.put(velocity);
  for (const Pack &part : orientation) row.put(part);
  row.put(spin), row.put(y[VELOCITY + 1] / y[RADIUS] - y[SPIN + 2]);
  row.put(inner.force + outer.force), row.put(inner.torque + outer.torque);
  for (auto number :
       {&Contact::approach, &Contact::normal_load, &Contact::contact_angle, &Contact::spin_rate, &Contact::small, &Contact::large})
    row.put(inner.*number), row.put(outer.*number);
  for (auto vector : {&Contact::point, &Contact::normal, &Contact::friction, &Contact::slip})
    row.put(inner.*vector), row.put(outer.*vector);
  for (auto number : {&Contact::spin_moment, &Contact::film, &Contact::film_ratio}) row.put(inner.*number), row.put(outer.*number);

  Vector on_inner = moment_on_ring(inner_ring, position, inner.force, inner.torque);
  Vector on_outer = -1.0 * (cross(position, outer.force) + outer.torque);  // about the origin
  Pack *share = row.shares;
  for (const Vector &v : {-1.0 * inner.force, on_inner, -1.0 * outer.force, on_outer})
    *share++ = v.x, *share++ = v.y, *share++ = v.z;
  *share++ = 0.5 * (bearing.ball_mass * dot(velocity, velocity) + bearing.ball_inertia * dot(spin, spin));
  *share++ = inner.energy + outer.energy;
  *share++ =
      -bearing.ball_mass * (bearing.gravity[0] * position.x + bearing.gravity[1] * position.y + bearing.gravity[2] * position.z);
  *share++ = y[DRIVE_WORK], *share++ = y[DISSIPATED], *share++ = y[GROSS_WORK];
}

// Approaches of each ball and the next ahead, and the contacts of those that touch.
inline void write_neighbours(const Bearing &bearing, const double *state, int balls, const RowLayout &layout, double *row) {
  neighbours::Row neighbours_row{state, balls};
  double *approach = row + layout.neighbours, *load = approach + balls, *point = load + balls;
  std::fill(load, row + layout.columns, 0.0);
  for (int k = 0; k < balls; k++) {
    int j = k + 1 < balls ? k + 1 : 0;
    approach[k] = 0.0;
    if (balls < 2 || (balls == 2 && neighbours_row.angle_ahead(k) > M_PI)) continue;
    const double *a = row + layout.position + 3 * k, *b = row + layout.position + 3 * j;
    double x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2];
    approach[k] = 2.0 * bearing.ball_radius - std::sqrt(x * x + y * y + z * z);
    if (!(approach[k] > 0.0)) continue;
    auto get = [&](int ball, int column) { return state[ball * COLUMNS + column]; };
    auto contact = std::get<0>(contact_with_next(bearing, k, j, get));
    double angle = state[k * COLUMNS + ANGLE];
    auto store = [&](const Vector3<double> &local, int block) {
      auto v = about_z(std::cos(angle), std::sin(angle), local);
      double *out = point + 3 * (balls * block + k);
      out[0] = v.x, out[1] = v.y, out[2] = v.z;
    };
    row[layout.shared + ELASTIC] += contact.energy;
    load[k] = contact.normal_load;
    store(Vector3{get(k, RADIUS), 0.0, get(k, HEIGHT)} + contact.arm, 0), store(-1.0 * contact.normal, 1),
        store(contact.friction, 2);
  }
}

// Forces of an even cage on its balls, which keep them evenly spaced, from the forces of the raceways and the balls' positions.
inline void write_even_cage(const Bearing &bearing, const CoupledBodies &b, const BodyState &body_state, const double *state,
                            int balls, const RowLayout &layout, double *row) {
  double *force = row + layout.ring + POCKET_FORCE, mass = bearing.ball_mass, torque = 0.0, inertia = b.inertia[CAGE_ANGLE];
  for (int k = 0; k < balls; k++) {
    const double *position = row + layout.position + 3 * k, *force_on_ball = row + layout.force + 3 * k, *y = state + k * COLUMNS;
    double moment = position[0] * (force_on_ball[1] + mass * bearing.gravity[1]) -
                    position[1] * (force_on_ball[0] + mass * bearing.gravity[0]) -
                    2.0 * mass * y[VELOCITY] * body_state[COORDINATES + CAGE_ANGLE] * y[RADIUS];
    force[k] = moment / y[RADIUS];
    torque += moment, inertia += mass * y[RADIUS] * y[RADIUS];
  }
  double growth = mass * torque / inertia;
  for (int k = 0; k < balls; k++) force[k] = state[k * COLUMNS + RADIUS] * growth - force[k];
}

// Forces of the pockets on their balls along the orbit; their energy is added to the elastic energy.
inline void write_pockets(const Bearing &bearing, const CoupledBodies &b, const BodyState &body_state, const double *state,
                          int balls, const RowLayout &layout, double *row) {
  for (int k = 0; k < balls; k++) {
    double pocket = 2.0 * M_PI * k / balls, motion[COLUMNS], moment = 0.0;
    std::copy(state + k * COLUMNS, state + (k + 1) * COLUMNS, motion);
    motion[ORBIT_RATE] /= motion[RADIUS];
    BallState y;
    for (int c = 0; c < COLUMNS; c++) y[c] = broadcast<Pack>(motion[c]);
    ElementInput<false> in{y, body_state};
    auto give = [&]<int ROW>(Index<ROW>, const auto &part) {
      if constexpr (ROW == ORBIT_ROW) moment += as_pack(part)[0];
    };
    PocketGap gap = cage_pocket(bearing, b, broadcast<Pack>(pocket), in, give);
    row[layout.ring + POCKET_FORCE + k] = moment / motion[RADIUS];
    double depth = std::max(double(gap.approach[0]), 0.0);
    row[layout.shared + ELASTIC] += 0.5 * b.pockets.wall.stiffness * depth * depth;
  }
}

// The centre of a guided cage, and the forces of its land on it and on the ring with the land.
inline void write_land(const CoupledBodies &b, const BodyState &start_state, int balls, const RowLayout &layout, double *row) {
  BodyState body_state = start_state;
  body_state[COORDINATES + SHAFT] = row[layout.ring + RING_SPEED];  // also where it is prescribed
  double force[2] = {}, cage_torque = 0.0, inner = b.land.side < 0.0 ? 1.0 : 0.0;
  land_forces(
      b, [&](int c) { return body_state[c]; }, [&](int c) { return body_state[COORDINATES + c]; },
      [&]<int ROW>(Index<ROW>, double part) {
        if constexpr (ROW == CAGE_X || ROW == CAGE_Y) force[ROW - CAGE_X] += part;
        if constexpr (ROW == CAGE_ANGLE) cage_torque += part;
      });
  double *centre = row + layout.ring + POCKET_FORCE + balls, *sum = row + layout.shared;
  auto [x, y] = walls::relative_to_land(b, body_state, 0);
  double distance = std::sqrt(x * x + y * y);
  double lever = b.land.side * b.land.radius - distance, ring_torque = -b.land.side * b.land.radius * cage_torque / lever;
  for (int i = 0; i < 2; i++) {
    centre[i] = body_state[CAGE_X + i], centre[2 + i] = body_state[COORDINATES + CAGE_X + i], centre[4 + i] = force[i];
    sum[INNER_FORCE + i] -= inner * force[i], sum[OUTER_FORCE + i] -= (1.0 - inner) * force[i];
  }
  sum[INNER_TORQUE + 2] += inner * ring_torque, sum[OUTER_TORQUE + 2] += (1.0 - inner) * ring_torque;
  double depth = std::max(distance - b.land.clearance, 0.0);
  sum[ELASTIC] += 0.5 * b.land.wall.stiffness * depth * depth;
}

constexpr double STANDING = 1e-9;  // rad/s, orbit rate of rolling balls below which slip relative to it is undefined

// Ring, cage and shaft, whose shares join the energies; `rolling` is the speed of balls that roll, over the ring's.
inline void write_bodies(const Bearing &bearing, const CoupledBodies &b, const BodyState &body_state, double time, double rolling,
                         const double *state, int balls, const RowLayout &layout, double *row) {
  double *ring = row + layout.ring, *sum = row + layout.shared;
  const double *speed = body_state.data() + COORDINATES, *integral = body_state.data() + 2 * COORDINATES;
  bool driven = b.torque_driven();
  if (b.ring != RingMotion::held) {
    std::copy(body_state.data(), body_state.data() + 5, ring + RING_OFFSET);
    std::copy(speed, speed + 5, ring + RING_VELOCITY);
  }
  for (int c : {RING_X, RING_Y, RING_Z})
    if (b.free[c]) ring[RING_LOAD + c] = b.load[c] + time * b.load_rate[c];
  if (b.unbalance != 0.0) {
    double turn = b.phase + ring[0];
    double pull = b.unbalance * ring[RING_SPEED] * ring[RING_SPEED];
    ring[RING_LOAD] += b.free[RING_X] * pull * std::cos(turn), ring[RING_LOAD + 1] += b.free[RING_Y] * pull * std::sin(turn);
  }
  for (int c = 0; c < SHAFT; c++) {
    if (!b.free[c]) continue;
    double deflection = body_state[c] - b.rest_position[c];
    sum[KINETIC] += 0.5 * b.inertia[c] * speed[c] * speed[c];
    sum[ELASTIC] += 0.5 * b.stiffness[c] * deflection * deflection;
    sum[POTENTIAL] -= b.weight[c] * body_state[c];
  }
  ring[RING_LOAD_WORK] = integral[LOAD_WORK];
  sum[WORK] += integral[LOAD_WORK] + integral[LAND_WORK];
  sum[LOSS] += integral[LOST];
  sum[GROSS] += std::fabs(integral[LOAD_WORK]) + std::fabs(integral[LAND_WORK]);
  if (b.cage != CageKind::none) {
    double rolls = rolling * ring[RING_SPEED];
    ring[CAGE_TURN] = body_state[CAGE_ANGLE], ring[CAGE_SPEED] = speed[CAGE_ANGLE];
    ring[CAGE_SLIP] = std::fabs(rolls) > STANDING ? 1.0 - speed[CAGE_ANGLE] / rolls : 0.0;
    if (layout.contacts() && b.cage == CageKind::even) write_even_cage(bearing, b, body_state, state, balls, layout, row);
    else if (layout.contacts()) write_pockets(bearing, b, body_state, state, balls, layout, row);
    if (b.guided) write_land(b, body_state, balls, layout, row);
    ring[DRIVE_TORQUE] = -sum[INNER_TORQUE + 2];
  }
  if (driven) {
    ring[DRIVE_TORQUE] = b.load[SHAFT] + time * b.load_rate[SHAFT];
    sum[KINETIC] += 0.5 * b.inertia[SHAFT] * speed[SHAFT] * speed[SHAFT];
    sum[WORK] = integral[LOAD_WORK] + integral[TORQUE_WORK];
    sum[GROSS] += std::fabs(integral[TORQUE_WORK]);
  }
}

// Input of rows: states (instants, balls, COLUMNS), orientations (instants, balls, 4), times [s], and where
// there are `bodies`, ring, cage and shaft, their states (instants, BODY_NUMBERS).
struct Source {
  const Bearing &bearing;
  Drive drive;
  int instants, balls;
  const double *times, *states, *orientations;
  const CoupledBodies *bodies;
  const BodyState *body_states;
  double rolling;
};

template <bool PATCH>
void write_balls(const Source &source, const RowLayout &layout, double *out) {
  long total = long(source.instants) * source.balls;
  BallRow row;
  RingPose inner_ring{}, outer_ring{};
  Mask first;
  auto set = [](Vector &v, int lane, double x, double y, double z) { v.x[lane] = x, v.y[lane] = y, v.z[lane] = z; };
  for (long begin = 0; begin < total; begin += LANES) {
    BallState y;
    Quaternion orientation;
    for (int lane = 0; lane < LANES; lane++) {
      long pair = std::min(begin + lane, total - 1), instant = pair / source.balls;
      for (int c = 0; c < COLUMNS; c++) y[c][lane] = source.states[pair * COLUMNS + c];
      for (int c = 0; c < 4; c++) orientation[c][lane] = source.orientations[pair * 4 + c];
      first[lane] = pair % source.balls == 0 ? -1 : 0;
      inner_ring.speed[lane] = source.drive.speed_at(source.times[instant]);
      inner_ring.angle[lane] = source.drive.angle_at(source.times[instant]);
      set(inner_ring.centre, lane, source.bearing.offset[0], source.bearing.offset[1], source.bearing.offset[2]);
      if (!source.bodies) continue;
      const double *position = source.body_states[instant].data(), *speed = position + COORDINATES;
      if (source.bodies->torque_driven()) inner_ring.speed[lane] = speed[SHAFT], inner_ring.angle[lane] = position[SHAFT];
      if (source.bodies->ring == RingMotion::held) continue;
      set(inner_ring.centre, lane, position[RING_X], position[RING_Y], position[RING_Z]);
      set(inner_ring.drift, lane, speed[RING_X], speed[RING_Y], speed[RING_Z]);
      set(inner_ring.tilt, lane, position[TILT_X], position[TILT_Y], 0.0);
      set(inner_ring.turning, lane, speed[TILT_X], speed[TILT_Y], 0.0);
      const double *along = source.bodies->direction, q = position[HOUSING], w = speed[HOUSING];
      set(outer_ring.centre, lane, along[0] * q, along[1] * q, along[2] * q);
      set(outer_ring.drift, lane, along[0] * w, along[1] * w, along[2] * w);
    }
    fill<PATCH>(source.bearing, inner_ring, outer_ring, y, orientation, first, row);
    for (int lane = 0; lane < LANES && begin + lane < total; lane++) {
      long instant = (begin + lane) / source.balls, ball = (begin + lane) % source.balls;
      double *to_row = out + instant * layout.columns;
      const Pack *number = row.numbers;
      for (int i = 0; i < BALL_CHANNELS; i++) {
        double *channel_out = to_row + layout.first[i] + ball * layout.width[i];
        for (int part = 0; part < layout.width[i]; part++) channel_out[part] = (*number++)[lane];
      }
      for (int i = 0; i < SUMS; i++) {
        double &sum = to_row[layout.shared + i];
        sum = (ball > 0 ? sum : -0.0) + row.shares[i][lane];
      }
    }
  }
}

template <bool PATCH>
void write(const Source &source, const RowLayout &layout, double *out) {
  write_balls<PATCH>(source, layout, out);
  for (int instant = 0; instant < source.instants; instant++) {
    double *row = out + long(instant) * layout.columns, *ring = row + layout.ring, time = source.times[instant];
    const double *state = source.states + long(instant) * source.balls * COLUMNS;
    const Drive &drive = source.drive;
    ring[0] = drive.angle_at(time);
    ring[RING_SPEED] = drive.speed_at(time);
    if (source.bodies && source.bodies->torque_driven())
      ring[0] = source.body_states[instant][SHAFT], ring[RING_SPEED] = source.body_states[instant][COORDINATES + SHAFT];
    std::copy(source.bearing.offset, source.bearing.offset + 3, ring + RING_OFFSET);
    std::fill(ring + RING_TILT, row + layout.shared, 0.0);
    ring[DRIVE_TORQUE] = -row[layout.shared + INNER_TORQUE + 2];
    if (layout.contacts()) write_neighbours(source.bearing, state, source.balls, layout, row);
    if (source.bodies)
      write_bodies(source.bearing, *source.bodies, source.body_states[instant], time, source.rolling, state, source.balls, layout,
                   row);
  }
}

}  // namespace outputs

}  // namespace core

using namespace core;

// Fills rows (instants, columns) of all channels. `numbers` are those of RowLayout in their
// order; `body_numbers`, loads and borders are those of `core_integrate`, and `coupled` says whether there are any.
CORE_EXPORT void core_outputs(const double *bearing_numbers, const double *points, const double *drive, std::int64_t instants,
                              std::int64_t balls, const double *times, const double *states, const double *orientations,
                              std::int64_t coupled, const double *body_numbers, const double *load, const double *load_rate,
                              const double *borders, double rolling, const std::int64_t *numbers, double *out) {
  Bearing bearing = bearing_of(bearing_numbers, points);
  RowLayout layout;
  for (int &number : layout.first) number = int(*numbers++);
  for (int &number : layout.width) number = int(*numbers++);
  for (int *number : {&layout.ring, &layout.shared, &layout.neighbours, &layout.position, &layout.force, &layout.columns})
    *number = int(*numbers++);
  CoupledBodies bodies{};
  if (coupled) bodies = bodies_of(body_numbers, load, load_rate);
  std::vector<BodyState> moving;
  for (std::int64_t i = 0; coupled && i < instants; i++) moving.push_back(state_of(bearing, bodies, borders + i * BORDER));
  outputs::Source source{bearing,       drive_of(drive), int(instants), int(balls),
                         times,         states,          orientations,  coupled ? &bodies : nullptr,
                         moving.data(), rolling};
  if (bearing.over_patch()) outputs::write<true>(source, layout, out);
  else outputs::write<false>(source, layout, out);
}

// Sums over the outputs of a bearing for its figures (kinds/bearing/figures.py), output by output, so that they do not
// depend on how outputs are divided into blocks.

namespace {

constexpr int MISSING = -1;  // first column of an absent channel
enum Column {
  LOAD,
  TORQUE,
  RING_TORQUE,
  ROLL,
  SPEED,
  ANGLE,
  POCKET,
  WORK,
  RING_ANGLE,
  LOAD_WORK,
  AT_GREATEST,
  RING = AT_GREATEST + 4,
  OFFSET = RING + 4,
  VELOCITY,
  LAND_FORCE
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
  double *scalars() const { return torque() + balls; }  // drive torque, roll rate, speed
  double *centre() const { return scalars() + 3; }
  double *ring() const { return centre() + 3; }
};
// The greatest so far, in the order of figures.Greatest.
struct Greatest {
  double *numbers;
  int balls;
  double *load() const { return numbers; }
  double *at_greatest() const { return numbers + 2 * balls; }  // (4, 2 balls)
  double *without() const { return numbers + 10 * balls; }
  double *forces() const { return numbers + 12 * balls; }  // of a pocket, of the land
};

void add_centre(const std::int64_t *column, const double *row, const Greatest &greatest, double *centre) {
  if (column[OFFSET] == MISSING) return;
  const double *offset = row + column[OFFSET], *velocity = row + column[VELOCITY], *force = row + column[LAND_FORCE];
  double square = offset[0] * offset[0] + offset[1] * offset[1];
  centre[0] += std::sqrt(square), centre[1] += square;
  centre[2] += offset[0] * velocity[1] - offset[1] * velocity[0];
  double pull = std::sqrt(force[0] * force[0] + force[1] * force[1]);
  greatest.forces()[1] = std::max(greatest.forces()[1], pull);
}

void add(const std::int64_t *column, const double *row, double seconds, bool begins, const Greatest &greatest,
         const Stretch &sums) {
  int balls = sums.balls;
  sums.time() = seconds, sums.count() += 1.0;
  for (int contact = 0; contact < 2 * balls; contact++) {
    double load = row[column[LOAD] + contact];
    sums.load()[contact] += load;
    if (!(load > 0.0)) greatest.without()[contact] += 1.0;
    if (load > greatest.load()[contact]) {
      greatest.load()[contact] = load;
      for (int k = 0; k < 4; k++) greatest.at_greatest()[k * 2 * balls + contact] = row[column[AT_GREATEST + k] + contact];
    }
  }
  double mean = 0.0, *greatest_force = greatest.forces();
  for (int k = 0; k < balls; k++) {
    const double *torque = row + column[TORQUE] + 3 * k;
    sums.torque()[k] += std::sqrt(torque[0] * torque[0] + torque[1] * torque[1] + torque[2] * torque[2]);
    sums.orbit_angle()[k] = row[column[ANGLE] + k];
    mean += row[column[ROLL] + k];
    if (column[POCKET] != MISSING) greatest_force[0] = std::max(greatest_force[0], std::fabs(row[column[POCKET] + k]));
  }
  double *scalar = sums.scalars();
  scalar[0] -= row[column[RING_TORQUE] + 2], scalar[1] += mean / balls, scalar[2] += row[column[SPEED]];
  sums.turned()[0] = row[column[WORK]] - (column[LOAD_WORK] != MISSING ? row[column[LOAD_WORK]] : 0.0);
  sums.turned()[1] = row[column[RING_ANGLE]];
  add_centre(column, row, greatest, sums.centre());
  double *sum = sums.ring(), *least = sum + RING_WIDTH, *highest = least + RING_WIDTH;
  for (int part = 0; part < 4; part++)
    for (int axis = 0; axis < RING_PARTS[part]; axis++, sum++, least++, highest++) {
      double value = column[RING + part] == MISSING ? 0.0 : row[column[RING + part] + axis];
      *sum += value;
      *least = std::min(value, begins ? value : *least);
      *highest = std::max(value, begins ? value : *highest);
    }
}

}  // namespace

// Adds outputs (count, width), of which the first has `before` predecessors in the run, to the greatest values and to the
// stretches (capacity, stretch width), of which `done[1]` are in use and the others are 0. Every `stretch_length` outputs one
// starts. Fills `done` with the numbers of outputs added and of stretches.
CORE_EXPORT void core_sum_outputs(const std::int64_t *columns, const double *numbers, std::int64_t count, std::int64_t width,
                                  const std::int64_t *time_ns, std::int64_t before, std::int64_t stretch_length, std::int64_t balls,
                                  double *greatest, double *stretches, std::int64_t capacity, std::int64_t stretch_width,
                                  std::int64_t *done) {
  std::int64_t &added = done[0], &stretches_filled = done[1];
  for (added = 0; added < count; added++) {
    bool begins = (before + added) % stretch_length == 0;
    if (begins && stretches_filled == capacity) return;
    stretches_filled += begins;
    add(columns, numbers + added * width, 1e-9 * double(time_ns[added]), begins, {greatest, int(balls)},
        {stretches + (stretches_filled - 1) * stretch_width, int(balls)});
  }
}
