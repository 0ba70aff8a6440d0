// What a bearing whose rings are held gives out: one row of all channels an instant (kinds/bearing/outputs.py), filled
// from the balls' states. Contacts are those of the equations of motion themselves.
#pragma once
#include <vector>
#include "ball_ball.hpp"
#include "ball_rates.hpp"

namespace core {

constexpr int OWN_CHANNELS = 19, SUMS = 18;
// Where the numbers of a row stand: those of ball k in own channel i at first[i] + k width[i]; then the first of the
// ring's, of the sums over the balls and of the contacts between neighbours; positions.
struct RowPlaces { int first[OWN_CHANNELS], width[OWN_CHANNELS], ring, shared, neighbours, position, columns; };

struct DriveNow { double angle, speed, acceleration; };

namespace outputs {

constexpr int DRIVE_TORQUE = 16;  // columns after the ring's angle
constexpr int ELASTIC_ENERGY = 13, INNER_TORQUE_Z = 5;  // among the sums

using Vector = Vector3<Pack>;

CORE_INLINE Pack filled(Zero) { return Pack{}; }
CORE_INLINE Pack filled(const Pack &x) { return x; }
template <class X, class Y, class Z>
CORE_INLINE Vector filled(const Vector3<X, Y, Z> &v) { return {filled(v.x), filled(v.y), filled(v.z)}; }

// One contact in the ball's frame, and what it does to ring and ball in bearing_link.
struct Side {
  Pack approach, normal_load, energy, contact_angle, spin_rate, small, large, drilling;
  Vector point, normal, friction, slip, force, torque, reaction;  // in bearing_link; normal in the direction of the load
};

template <bool PATCH, class O, class W>
CORE_INLINE Side side_of(const Bearing &bearing, const Raceway &raceway, double outwards, const O &offset, const W &speed,
                         const Vector &position, const Vector &centre, const Vector &velocity, const Vector &spin,
                         const Pack &cosine, const Pack &sine) {
  auto [at, normal_radial] = contact_place(bearing, raceway, offset, speed);
  auto relative = (velocity + cross(spin, at.arm)) - at.surface_velocity;
  auto spin_rate = dot(spin, at.normal) - speed * at.normal.z;
  auto action = contact_action<PATCH>(bearing, raceway, at, normal_radial, relative, spin_rate);
  Side side;
  Vector normal = filled(at.normal), arm = filled(at.arm), friction = filled(action.friction);
  Pack ball = broadcast<Pack>(1.0 / bearing.ball_radius);
  side.approach = at.approach, side.normal_load = action.normal_load, side.spin_rate = spin_rate;
  side.energy = 1.0 / (bearing.power + 1.0) * at.load * maximum(at.approach, 0.0);
  side.small = 0.5 * (ball - 1.0 / raceway.groove_radius);
  side.large = 0.5 * (ball - normal_radial / (raceway.locus_radius + raceway.groove_radius * normal_radial));
  side.contact_angle = arctangent(Pack((outwards * normal.z + 0.0) / square_root(normal.x * normal.x + normal.y * normal.y)));
  side.drilling = filled(action.drilling);
  auto turned = [&](const Vector &v) __attribute__((always_inline)) { return about_z(cosine, sine, v); };
  Vector drilling = side.drilling * normal;
  side.point = turned(position + arm), side.normal = turned(-1.0 * normal);
  side.friction = turned(friction), side.slip = turned(filled(action.slip));
  side.force = turned(friction - side.normal_load * normal);
  side.torque = turned(cross(arm, friction) + drilling);
  side.reaction = -1.0 * (cross(side.point - centre, side.force) + turned(drilling));
  return side;
}

// The numbers of one ball in the order of the own channels, then its shares in the sums.
struct BallRow {
  Pack own[62], shares[SUMS];
  int next = 0;
  CORE_INLINE void put(const Pack &x) { own[next++] = x; }
  CORE_INLINE void put(const Vector &v) { put(v.x), put(v.y), put(v.z); }
};

template <bool PATCH>
[[gnu::noinline]] inline void fill(const Bearing &bearing, const Pack &ring_speed, const BallState &y,
                                   const Quaternion &own_orientation, BallRow &row) {
  auto [cosine, sine] = cosine_sine_value(y[ANGLE]);
  auto c = cosine, s = sine;
  Vector local{y[RADIUS], Pack{}, y[HEIGHT]}, velocity{y[VELOCITY], y[VELOCITY + 1], y[VELOCITY + 2]};
  Vector spin{y[SPIN], y[SPIN + 1], y[SPIN + 2]};
  const double *o = bearing.offset;
  Vector centre{broadcast<Pack>(o[0]), broadcast<Pack>(o[1]), broadcast<Pack>(o[2])};
  Vector offset = local - about_z(c, -s, centre);
  Side inner = side_of<PATCH>(bearing, bearing.inner, -1.0, offset, ring_speed, local, centre, velocity, spin, c, s);
  Vector3 on_axis{y[RADIUS], Zero{}, y[HEIGHT]};
  Side outer = side_of<PATCH>(bearing, bearing.outer, 1.0, on_axis, Zero{}, local, Vector{}, velocity, spin, c, s);
  Vector position = about_z(c, s, local);
  auto [half_cosine, half_sine] = cosine_sine_value(Pack(0.5 * y[ANGLE]));
  Quaternion orientation = product({Pack{}, Pack{}, half_sine, half_cosine}, own_orientation);

  row.next = 0;
  row.put(y[ANGLE]), row.put(position), row.put(about_z(c, s, velocity));
  for (const Pack &part : orientation) row.put(part);
  row.put(about_z(c, s, spin)), row.put(y[VELOCITY + 1] / y[RADIUS] - y[SPIN + 2]);
  row.put(inner.force + outer.force), row.put(inner.torque + outer.torque);
  for (auto number : {&Side::approach, &Side::normal_load, &Side::contact_angle, &Side::spin_rate, &Side::small, &Side::large})
    row.put(inner.*number), row.put(outer.*number);
  for (auto vector : {&Side::point, &Side::normal, &Side::friction, &Side::slip}) row.put(inner.*vector), row.put(outer.*vector);
  row.put(inner.drilling), row.put(outer.drilling);

  Pack *share = row.shares;
  for (const Vector &v : {-1.0 * inner.force, inner.reaction, -1.0 * outer.force, outer.reaction})
    *share++ = v.x, *share++ = v.y, *share++ = v.z;
  *share++ = 0.5 * (bearing.ball_mass * dot(velocity, velocity) + bearing.ball_inertia * dot(spin, spin));
  *share++ = inner.energy + outer.energy;
  *share++ = -bearing.ball_mass * (bearing.gravity[0] * position.x + bearing.gravity[1] * position.y + bearing.gravity[2] * position.z);
  *share++ = y[DRIVE_WORK], *share++ = y[DISSIPATED], *share++ = y[GROSS_WORK];
}

inline double wrapped_angle_ahead(const double *state, int balls, int k) {
  int j = k + 1 < balls ? k + 1 : 0;
  double angle = state[j * COLUMNS + ANGLE] - state[k * COLUMNS + ANGLE];
  return j == k + 1 ? angle : angle + 2.0 * M_PI;
}

// Approaches of each ball and the next ahead, and the contacts of those that touch.
inline void write_neighbours(const Bearing &bearing, const double *state, int balls, const RowPlaces &places, double *row) {
  double *approach = row + places.neighbours, *load = approach + balls, *point = load + balls;
  std::fill(load, row + places.columns, 0.0);
  for (int k = 0; k < balls; k++) {
    int j = k + 1 < balls ? k + 1 : 0;
    approach[k] = 0.0;
    if (balls < 2 || (balls == 2 && wrapped_angle_ahead(state, balls, k) > M_PI)) continue;
    const double *a = row + places.position + 3 * k, *b = row + places.position + 3 * j;
    double x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2];
    approach[k] = 2.0 * bearing.ball_radius - std::sqrt(x * x + y * y + z * z);
    if (!(approach[k] > 0.0)) continue;
    auto vector = [&](int ball, int column) {
      const double *one = state + ball * COLUMNS + column;
      return Vector3{one[0], one[1], one[2]};
    };
    auto place = [&](int ball) { return Vector3{state[ball * COLUMNS + RADIUS], 0.0, state[ball * COLUMNS + HEIGHT]}; };
    double angle = wrapped_angle_ahead(state, balls, k), c = std::cos(angle), s = std::sin(angle);
    auto contact = pair_contact(bearing, about_z(c, s, place(j)) - place(k),
                                vector(k, VELOCITY) - about_z(c, s, vector(j, VELOCITY)),
                                vector(k, SPIN) + about_z(c, s, vector(j, SPIN)));
    double own = state[k * COLUMNS + ANGLE];
    auto store = [&](const Vector3<double> &local, int block) {
      auto v = about_z(std::cos(own), std::sin(own), local);
      double *to = point + 3 * (balls * block + k);
      to[0] = v.x, to[1] = v.y, to[2] = v.z;
    };
    row[places.shared + ELASTIC_ENERGY] += contact.energy;
    load[k] = contact.normal_load;
    store(place(k) + contact.arm, 0), store(-1.0 * contact.normal, 1), store(contact.friction, 2);
  }
}

// Fills `out` (instants, columns) from states (instants, balls, COLUMNS), orientations (instants, balls, 4) and times.
template <bool PATCH>
void write(const Bearing &bearing, const DriveNow &drive, int instants, int balls, const double *times, const double *states,
           const double *orientations, const RowPlaces &places, double *out) {
  long total = long(instants) * balls;
  BallRow filled_row;
  for (long begin = 0; begin < total; begin += LANES) {
    BallState y;
    Quaternion orientation;
    Pack speed;
    for (int lane = 0; lane < LANES; lane++) {
      long pair = std::min(begin + lane, total - 1);
      for (int c = 0; c < COLUMNS; c++) y[c][lane] = states[pair * COLUMNS + c];
      for (int c = 0; c < 4; c++) orientation[c][lane] = orientations[pair * 4 + c];
      speed[lane] = drive.speed + drive.acceleration * times[pair / balls];
    }
    fill<PATCH>(bearing, speed, y, orientation, filled_row);
    for (int lane = 0; lane < LANES && begin + lane < total; lane++) {
      long instant = (begin + lane) / balls, ball = (begin + lane) % balls;
      double *row = out + instant * places.columns;
      const Pack *number = filled_row.own;
      for (int i = 0; i < OWN_CHANNELS; i++) {
        double *to = row + places.first[i] + ball * places.width[i];
        for (int part = 0; part < places.width[i]; part++) to[part] = (*number++)[lane];
      }
      for (int i = 0; i < SUMS; i++) {
        double &sum = row[places.shared + i];
        sum = (ball > 0 ? sum : -0.0) + filled_row.shares[i][lane];
      }
    }
  }
  for (int instant = 0; instant < instants; instant++) {
    double *row = out + long(instant) * places.columns, *ring = row + places.ring, time = times[instant];
    ring[0] = drive.angle + time * (drive.speed + 0.5 * drive.acceleration * time);
    ring[1] = drive.speed + drive.acceleration * time;
    std::copy(bearing.offset, bearing.offset + 3, ring + 2);
    std::fill(ring + 5, row + places.shared, 0.0);
    ring[DRIVE_TORQUE] = -row[places.shared + INNER_TORQUE_Z];
    write_neighbours(bearing, states + long(instant) * balls * COLUMNS, balls, places, row);
  }
}

}  // namespace outputs
}  // namespace core
