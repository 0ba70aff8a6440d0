// A yardstick: eight balls of a bearing by the classical Runge-Kutta method in plain C++, side by side.
// The equations are those of kinds/bearing/equations.py with Hertz's law and friction at a point; orientations are left
// out. Numbers come from standard input in the order in which they are read; out go the state and the CPU seconds.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

constexpr int L = 8, C = 12;
struct Raceway { double locus, groove, modulus; };
struct Bearing {
  double radius, mass, inertia, offset[3], gravity[3], damping, relaxation, friction, smooth;
  Raceway inner, outer;
  double numerator[8], denominator[8], widest;
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
  double y = x * x, s = 1 / 6227020800.0 - y * (1 / 1307674368000.0 - y / 355687428096000.0);
  s = 1 / 120.0 - y * (1 / 5040.0 - y * (1 / 362880.0 - y * (1 / 39916800.0 - y * s)));
  s = x - x * y * (1 / 6.0 - y * s);
  double c = 1 / 479001600.0 - y * (1 / 87178291200.0 - y / 20922789888000.0);
  c = 1 / 24.0 - y * (1 / 720.0 - y * (1 / 40320.0 - y * (1 / 3628800.0 - y * c)));
  c = 1 - y * (0.5 - y * c);
  double odd = quarters - 2 * std::floor(0.5 * quarters);
  double sign = 1 - 2 * (std::floor(0.5 * quarters) - 2 * std::floor(0.5 * std::floor(0.5 * quarters)));
  cosine = sign * ((1 - odd) * c - odd * s);
  sine = sign * ((1 - odd) * s + odd * c);
}

static inline void touch(const Bearing &b, const Raceway &w, V centre, double speed, V position, V velocity, V spin,
                         V &force, V &torque, double &power, double &loss) {
  V offset = position - centre;
  double across = std::sqrt(offset.x * offset.x + offset.y * offset.y), radial = across - w.locus;
  double distance = std::sqrt(radial * radial + offset.z * offset.z + 1e-300);
  double out = radial / distance, up = offset.z / distance, plane = out / across;
  double approach = distance + b.radius - w.groove, small = 0.5 * (1 / b.radius - 1 / w.groove);
  double large = 0.5 * (1 / b.radius - out / (w.locus + w.groove * out));
  V normal = {plane * offset.x, plane * offset.y, up}, arm = (b.radius - 0.5 * approach) * normal;
  V point = offset + arm, ring = {-speed * point.y, speed * point.x, 0};
  V relative = velocity + cross(spin, arm) - ring;
  double rate = dot(relative, normal);
  V slip = relative - rate * normal;
  double mean = std::sqrt(small * large), u = (small + large - 2 * mean) / (small + large + 2 * mean);
  u = std::min(u, b.widest);
  double p = b.numerator[7], q = b.denominator[7];
  for (int i = 6; i >= 0; i--) p = b.numerator[i] + u * p, q = b.denominator[i] + u * q;
  double c = w.modulus * p / (q * std::sqrt(mean));
  double depth = std::max(approach, 0.0), root = std::sqrt(depth), elastic = c * depth * root;
  double load = std::max(elastic + (b.damping * elastic + b.relaxation * 1.5 * c * root) * rate, 0.0);
  double resistance = b.friction * load / std::sqrt(dot(slip, slip) + b.smooth * b.smooth);
  V rubbing = -resistance * slip, all = -load * normal + rubbing;
  force = force + all;
  torque = torque + cross(arm, rubbing);
  power = dot(all, ring);
  loss += resistance * dot(slip, slip) + (load - elastic) * rate;
}

static void rates(const Bearing &b, double speed, const double (&y)[C][L], double (&r)[C][L]) {
#pragma GCC ivdep
  for (int k = 0; k < L; k++) {
    double c, s, power, still, loss = 0;
    turn(y[1][k], c, s);
    V position = {y[0][k], 0, y[2][k]}, velocity = {y[3][k], y[4][k], y[5][k]}, spin = {y[6][k], y[7][k], y[8][k]};
    V centre = {c * b.offset[0] + s * b.offset[1], -s * b.offset[0] + c * b.offset[1], b.offset[2]};
    V gravity = {c * b.gravity[0] + s * b.gravity[1], -s * b.gravity[0] + c * b.gravity[1], b.gravity[2]};
    V force = {0, 0, 0}, torque = {0, 0, 0};
    touch(b, b.inner, centre, speed, position, velocity, spin, force, torque, power, loss);
    touch(b, b.outer, {0, 0, 0}, 0, position, velocity, spin, force, torque, still, loss);
    double orbit = velocity.y / position.x;
    r[0][k] = velocity.x, r[1][k] = orbit, r[2][k] = velocity.z;
    r[3][k] = force.x / b.mass + gravity.x + orbit * velocity.y;
    r[4][k] = force.y / b.mass + gravity.y - orbit * velocity.x;
    r[5][k] = force.z / b.mass + gravity.z;
    r[6][k] = torque.x / b.inertia + orbit * spin.y;
    r[7][k] = torque.y / b.inertia - orbit * spin.x;
    r[8][k] = torque.z / b.inertia;
    r[9][k] = power, r[10][k] = loss, r[11][k] = std::fabs(power);
  }
}

int main() {
  double speed, h, steps, y[C][L], t[C][L], k[4][C][L];
  Bearing b;
  bool complete = true;
  auto read = [&](double &to) { complete = complete && std::scanf("%lf", &to) == 1; };
  for (double *to : {&speed, &h, &steps, &b.radius, &b.mass, &b.inertia}) read(*to);
  for (double &to : b.offset) read(to);
  for (double &to : b.gravity) read(to);
  for (double *to : {&b.damping, &b.relaxation, &b.friction, &b.smooth}) read(*to);
  for (Raceway *ring : {&b.inner, &b.outer})
    for (double *to : {&ring->locus, &ring->groove, &ring->modulus}) read(*to);
  for (double &to : b.numerator) read(to);
  for (double &to : b.denominator) read(to);
  read(b.widest);
  for (auto &column : y)
    for (double &to : column) read(to);
  if (!complete) return 2;
  std::clock_t start = std::clock();
  const double a[3] = {0.5 * h, 0.5 * h, h};
  for (int step = 0; step < steps; step++) {
    rates(b, speed, y, k[0]);
    for (int stage = 0; stage < 3; stage++) {
      for (int c = 0; c < C; c++)
        for (int i = 0; i < L; i++) t[c][i] = y[c][i] + a[stage] * k[stage][c][i];
      rates(b, speed, t, k[stage + 1]);
    }
    for (int c = 0; c < C; c++)
      for (int i = 0; i < L; i++) y[c][i] += h / 6 * (k[0][c][i] + 2 * k[1][c][i] + 2 * k[2][c][i] + k[3][c][i]);
  }
  double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
  for (auto &column : y)
    for (double one : column) std::printf("%.17g\n", one);
  std::printf("%.9g\n", seconds);
}
