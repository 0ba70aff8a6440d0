// A yardstick: eight balls of a bearing by the classical Runge-Kutta method or by an implicit-explicit step in plain C++,
// side by side. The equations are those of kinds/bearing/equations.py and imex.py with Hertz's law and friction at a
// point; orientations are left out. Numbers come from standard input in the order in which they are read; out go the
// state and the CPU seconds.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

constexpr int L = 8, C = 12;
struct Raceway { double locus, groove, terms[11]; };
struct Bearing {
  double radius, mass, inertia, offset[3], gravity[3], damping, relaxation, friction, smooth;
  Raceway inner, outer;
};
struct V { double x, y, z; };
static inline V operator+(V a, V b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline V operator-(V a, V b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline V operator*(double f, V a) { return {f * a.x, f * a.y, f * a.z}; }
static inline double dot(V a, V b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline V cross(V a, V b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

static inline void turn(double angle, double &cosine, double &sine) {
  double quarters = std::floor(angle * 0.6366197723675814 + 0.5), x = angle - quarters * 1.5707963267341256;
  x = (x - quarters * 6.077100506303966e-11) - quarters * 2.0222662487959506e-21;
  double y = x * x, s = 1 / 6227020800.0 - y * (1 / 1307674368000.0 - y * (1 / 355687428096000.0));
  s = 1 / 120.0 - y * (1 / 5040.0 - y * (1 / 362880.0 - y * (1 / 39916800.0 - y * s)));
  s = x - x * y * (1 / 6.0 - y * s);
  double c = 1 / 479001600.0 - y * (1 / 87178291200.0 - y * (1 / 20922789888000.0));
  c = 1 / 24.0 - y * (1 / 720.0 - y * (1 / 40320.0 - y * (1 / 3628800.0 - y * c)));
  c = 1 - y * (0.5 - y * c);
  double odd = quarters - 2 * std::floor(0.5 * quarters);
  double sign = 1 - 2 * (std::floor(0.5 * quarters) - 2 * std::floor(0.5 * std::floor(0.5 * quarters)));
  cosine = sign * ((1 - odd) * c - odd * s);
  sine = sign * ((1 - odd) * s + odd * c);
}

struct M { V x, y, z; };
static inline M operator+(M a, M b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static inline M operator-(M a, M b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline M operator*(double f, M a) { return {f * a.x, f * a.y, f * a.z}; }
static inline V operator*(M a, V b) { return {dot(a.x, b), dot(a.y, b), dot(a.z, b)}; }
static inline V row(V a, M b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline M operator*(M a, M b) { return {row(a.x, b), row(a.y, b), row(a.z, b)}; }
static inline M outer(V a, V b) { return {a.x * b, a.y * b, a.z * b}; }
static inline M inverse(M a) {
  V x = cross(a.y, a.z), y = cross(a.z, a.x), z = cross(a.x, a.y);
  double one = 1 / dot(a.x, x);
  return {one * V{x.x, y.x, z.x}, one * V{x.y, y.y, z.y}, one * V{x.z, y.z, z.z}};
}

// What contacts do to a ball, and how that answers to its velocity (v) and spin (s).
struct Answer {
  V force, torque;
  double power, loss;
  M force_v, force_s, torque_v, torque_s;
  V power_v, power_s, loss_v, loss_s;
};

template <bool SLOPES>  // always inlined: called, it would not be taken side by side
__attribute__((always_inline)) static inline Answer touch(const Bearing &b, const Raceway &w, V centre, double speed, V position, V velocity, V spin) {
  V offset = position - centre;
  double across = std::sqrt(offset.x * offset.x + offset.y * offset.y), radial = across - w.locus;
  double distance = std::sqrt(radial * radial + offset.z * offset.z + 1e-300);
  double inverse = 1 / distance, out = radial * inverse, up = offset.z * inverse, plane = out / across;
  double approach = distance + b.radius - w.groove;
  V normal = {plane * offset.x, plane * offset.y, up}, arm = (b.radius - 0.5 * approach) * normal;
  V point = offset + arm, ring = {-speed * point.y, speed * point.x, 0};
  V relative = velocity + cross(spin, arm) - ring;
  double rate = dot(relative, normal);
  V slip = relative - rate * normal;
  const double *t = w.terms;
  double x = std::max(std::fabs(out) - 1, t[10]), x2 = x * x, x4 = x2 * x2;
  double low = t[0] + t[1] * x + (t[2] + t[3] * x) * x2, high = t[4] + t[5] * x + (t[6] + t[7] * x) * x2;
  double c = low + (high + (t[8] + t[9] * x) * x4) * x4;
  double depth = std::max(approach, 0.0), root = std::sqrt(depth), elastic = c * depth * root;
  double viscous = b.damping * elastic + b.relaxation * 1.5 * c * root, full = elastic + viscous * rate;
  double load = std::max(full, 0.0), square = dot(slip, slip) + b.smooth * b.smooth;
  double slow = 1 / std::sqrt(square), over = b.friction * slow, resistance = over * load;
  V rubbing = -resistance * slip, all = -load * normal + rubbing;
  Answer a;
  a.force = all;
  a.torque = cross(arm, rubbing);
  a.power = dot(all, ring);
  a.loss = resistance * dot(slip, slip) + (load - elastic) * rate;
  if (SLOPES) {
    double by_rate = full > 0 ? viscous : 0.0;
    V by = over * by_rate * normal - resistance * slow * slow * slip;
    M even = {{resistance, 0, 0}, {0, resistance, 0}, {0, 0, resistance}};
    M rub = outer(resistance * normal, normal) - outer(slip, by) - even;
    a.force_v = rub - outer(by_rate * normal, normal);
    a.torque_v = {arm.y * rub.z - arm.z * rub.y, arm.z * rub.x - arm.x * rub.z, arm.x * rub.y - arm.y * rub.x};
    a.power_v = row(ring, a.force_v);
    a.loss_v = dot(slip, slip) * by + 2 * resistance * slip + (by_rate * rate + load - elastic) * normal;
    a.force_s = {cross(arm, a.force_v.x), cross(arm, a.force_v.y), cross(arm, a.force_v.z)};
    a.torque_s = {cross(arm, a.torque_v.x), cross(arm, a.torque_v.y), cross(arm, a.torque_v.z)};
    a.power_s = cross(arm, a.power_v);
    a.loss_s = cross(arm, a.loss_v);
  }
  return a;
}

static void rates(const Bearing &b, double speed, const double (&y)[C][L], double (&r)[C][L]) {
#pragma GCC ivdep
  for (int k = 0; k < L; k++) {
    double c, s;
    turn(y[1][k], c, s);
    V position = {y[0][k], 0, y[2][k]}, velocity = {y[3][k], y[4][k], y[5][k]}, spin = {y[6][k], y[7][k], y[8][k]};
    V centre = {c * b.offset[0] + s * b.offset[1], -s * b.offset[0] + c * b.offset[1], b.offset[2]};
    V gravity = {c * b.gravity[0] + s * b.gravity[1], -s * b.gravity[0] + c * b.gravity[1], b.gravity[2]};
    Answer in = touch<false>(b, b.inner, centre, speed, position, velocity, spin);
    Answer on = touch<false>(b, b.outer, {0, 0, 0}, 0, position, velocity, spin);
    V force = in.force + on.force, torque = in.torque + on.torque;
    double orbit = velocity.y / position.x;
    r[0][k] = velocity.x, r[1][k] = orbit, r[2][k] = velocity.z;
    r[3][k] = force.x / b.mass + gravity.x + orbit * velocity.y;
    r[4][k] = force.y / b.mass + gravity.y - orbit * velocity.x;
    r[5][k] = force.z / b.mass + gravity.z;
    r[6][k] = torque.x / b.inertia + orbit * spin.y;
    r[7][k] = torque.y / b.inertia - orbit * spin.x;
    r[8][k] = torque.z / b.inertia;
    r[9][k] = in.power, r[10][k] = in.loss + on.loss, r[11][k] = std::fabs(in.power);
  }
}

// A step that drifts, kicks by (1 - h/2 dF/dv) dv = h F, and drifts.
static void imex_step(const Bearing &b, double speed, double h, double (&y)[C][L]) {
#pragma GCC ivdep
  for (int k = 0; k < L; k++) {
    double c, s, g = 0.5 * h, radius = y[0][k] + g * y[3][k], height = y[2][k] + g * y[5][k];
    double angle = y[1][k] + g * y[4][k] / radius;
    turn(angle, c, s);
    V position = {radius, 0, height}, velocity = {y[3][k], y[4][k], y[5][k]}, spin = {y[6][k], y[7][k], y[8][k]};
    V centre = {c * b.offset[0] + s * b.offset[1], -s * b.offset[0] + c * b.offset[1], b.offset[2]};
    V gravity = {c * b.gravity[0] + s * b.gravity[1], -s * b.gravity[0] + c * b.gravity[1], b.gravity[2]};
    Answer in = touch<true>(b, b.inner, centre, speed, position, velocity, spin);
    Answer on = touch<true>(b, b.outer, {0, 0, 0}, 0, position, velocity, spin);
    double mass = 1 / b.mass, inertia = 1 / b.inertia, bend = 1 / radius, orbit = velocity.y * bend;
    V force = mass * (in.force + on.force) + gravity + V{orbit * velocity.y, -orbit * velocity.x, 0};
    V torque = inertia * (in.torque + on.torque) + V{orbit * spin.y, -orbit * spin.x, 0};
    M vv = mass * (in.force_v + on.force_v), vs = mass * (in.force_s + on.force_s);
    M sv = inertia * (in.torque_v + on.torque_v), ss = inertia * (in.torque_s + on.torque_s);
    vv.x.y += 2 * orbit, vv.y.x -= orbit, vv.y.y -= velocity.x * bend;
    sv.x.y += spin.y * bend, sv.y.y -= spin.x * bend, ss.x.y += orbit, ss.y.x -= orbit;
    M one = {{1 / g, 0, 0}, {0, 1 / g, 0}, {0, 0, 1 / g}};
    M velocities = inverse(one - vv), coupling = velocities * vs, schur = inverse(one - ss - sv * coupling);
    V push = velocities * (2.0 * force), turned = schur * (2.0 * torque + sv * push), pushed = push + coupling * turned;
    double sign = std::copysign(1.0, in.power), answer = 0.5 * (dot(in.power_v, pushed) + dot(in.power_s, turned));
    y[9][k] += h * (in.power + answer);
    y[10][k] += h * (in.loss + on.loss + 0.5 * (dot(in.loss_v + on.loss_v, pushed) + dot(in.loss_s + on.loss_s, turned)));
    y[11][k] += h * (std::fabs(in.power) + sign * answer);
    velocity = velocity + pushed;
    spin = spin + turned;
    y[0][k] = radius + g * velocity.x, y[1][k] = angle + g * velocity.y / radius, y[2][k] = height + g * velocity.z;
    y[3][k] = velocity.x, y[4][k] = velocity.y, y[5][k] = velocity.z;
    y[6][k] = spin.x, y[7][k] = spin.y, y[8][k] = spin.z;
  }
}

static void rk4_step(const Bearing &b, double speed, double h, double (&y)[C][L]) {
  static double t[C][L], k[4][C][L];
  const double a[3] = {0.5 * h, 0.5 * h, h};
  rates(b, speed, y, k[0]);
  for (int stage = 0; stage < 3; stage++) {
    for (int c = 0; c < C; c++)
      for (int i = 0; i < L; i++) t[c][i] = y[c][i] + a[stage] * k[stage][c][i];
    rates(b, speed, t, k[stage + 1]);
  }
  for (int c = 0; c < C; c++)
    for (int i = 0; i < L; i++) y[c][i] += h / 6 * (k[0][c][i] + 2 * k[1][c][i] + 2 * k[2][c][i] + k[3][c][i]);
}

int main(int, char **words) {
  double speed, h, steps, y[C][L];
  Bearing b;
  bool complete = true;
  auto read = [&](double &to) { complete = complete && std::scanf("%lf", &to) == 1; };
  for (double *to : {&speed, &h, &steps, &b.radius, &b.mass, &b.inertia}) read(*to);
  for (double &to : b.offset) read(to);
  for (double &to : b.gravity) read(to);
  for (double *to : {&b.damping, &b.relaxation, &b.friction, &b.smooth}) read(*to);
  for (Raceway *ring : {&b.inner, &b.outer}) {
    for (double *to : {&ring->locus, &ring->groove}) read(*to);
    for (double &to : ring->terms) read(to);
  }
  for (auto &column : y)
    for (double &to : column) read(to);
  if (!complete) return 2;
  std::clock_t start = std::clock();
  auto one_step = words[1][0] == 'i' ? imex_step : rk4_step;
  for (int step = 0; step < steps; step++) one_step(b, speed, h, y);
  double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
  for (auto &column : y)
    for (double one : column) std::printf("%.17g\n", one);
  std::printf("%.9g\n", seconds);
}
