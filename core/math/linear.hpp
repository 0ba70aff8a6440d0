// Vectors, matrices, angles and orientations; small systems of linear equations.
#pragma once
#include <array>
#include <utility>
#include "dual.hpp"

namespace core {

// Vectors of three numbers, each of a type of its own, and 3 x 3 matrices of packs.

template <class X, class Y = X, class Z = X>
struct Vector3 {
  X x;
  Y y;
  Z z;
};
template <class X, class Y, class Z>
Vector3(X, Y, Z) -> Vector3<X, Y, Z>;

template <class A, class B, class C, class D, class E, class F>
CORE_INLINE auto operator+(const Vector3<A, B, C> &a, const Vector3<D, E, F> &b) {
  return Vector3{a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class A, class B, class C, class D, class E, class F>
CORE_INLINE auto operator-(const Vector3<A, B, C> &a, const Vector3<D, E, F> &b) {
  return Vector3{a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class S, class A, class B, class C>
CORE_INLINE auto operator*(const S &factor, const Vector3<A, B, C> &a) {
  return Vector3{factor * a.x, factor * a.y, factor * a.z};
}
template <class A, class B, class C, class D, class E, class F>
CORE_INLINE auto dot(const Vector3<A, B, C> &a, const Vector3<D, E, F> &b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class A, class B, class C, class D, class E, class F>
CORE_INLINE auto cross(const Vector3<A, B, C> &a, const Vector3<D, E, F> &b) {
  return Vector3{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// The vector turned about z by the angle of this cosine and sine.
template <class C, class S, class X, class Y, class Z>
CORE_INLINE auto about_z(const C &cosine, const S &sine, const Vector3<X, Y, Z> &a) {
  return Vector3{cosine * a.x - sine * a.y, sine * a.x + cosine * a.y, a.z};
}

// The independent variables C to C + 2 where numbers have derivatives; a vector differentiated by what x depend on.
template <int C, class X, class Y, class Z>
CORE_INLINE auto local(const Vector3<X, Y, Z> &a) {
  return Vector3{local<C>(a.x), local<C + 1>(a.y), local<C + 2>(a.z)};
}
template <class A, class B, class C, class... X>
CORE_INLINE auto composed(const Vector3<A, B, C> &a, const X &...x) {
  return Vector3{composed(a.x, x...), composed(a.y, x...), composed(a.z, x...)};
}
template <class X, class Y, class Z>
CORE_INLINE Vector3<Pack> as_packs(const Vector3<X, Y, Z> &a) {
  return {as_pack(a.x), as_pack(a.y), as_pack(a.z)};
}

// Three numbers of one type and 3 x 3 matrices of their rows; a sum of matrices is that of their rows.
template <class T>
using TripleOf = std::array<T, 3>;
template <class T>
using Matrix3Of = TripleOf<TripleOf<T>>;
using Triple = TripleOf<Pack>;

template <class T>
CORE_INLINE TripleOf<T> operator+(const TripleOf<T> &a, const TripleOf<T> &b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class T>
CORE_INLINE TripleOf<T> operator-(const TripleOf<T> &a, const TripleOf<T> &b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class T>
CORE_INLINE TripleOf<T> operator*(double factor, const TripleOf<T> &a) {
  return {factor * a[0], factor * a[1], factor * a[2]};
}
template <class T>
CORE_INLINE T dot(const TripleOf<T> &a, const TripleOf<T> &b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class T>
CORE_INLINE TripleOf<T> cross(const TripleOf<T> &a, const TripleOf<T> &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class T>
CORE_INLINE TripleOf<T> operator*(const Matrix3Of<T> &m, const TripleOf<T> &a) {
  return {dot(m[0], a), dot(m[1], a), dot(m[2], a)};
}
template <class T>
CORE_INLINE Matrix3Of<T> operator*(const Matrix3Of<T> &a, const Matrix3Of<T> &b) {
  Matrix3Of<T> product;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) product[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
  return product;
}
template <class T>
CORE_INLINE Matrix3Of<T> transposed(const Matrix3Of<T> &m) {
  return {{{m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]}}};
}
// Vectors of fixed or of a body's axes, and matrices that turn one into the other.
using Real3 = TripleOf<double>;
using RealMatrix3 = Matrix3Of<double>;
CORE_INLINE double length_of(const Real3 &a) { return std::sqrt(dot(a, a)); }

// Angles and orientations: cosine and sine in lanes, unit quaternions (x, y, z, w).

// Cosine and sine of an angle [rad] below a million, within 2e-16 and without a branch: reduced by the nearest quarter
// turn in three parts (Cody and Waite), then Taylor's series to the 17th power, its terms side by side (Estrin).
template <class T>
CORE_INLINE std::pair<T, T> cosine_sine_value(const T &angle) {
  T quarters = floor_of(angle * 0.6366197723675814 + 0.5);
  T x = angle - quarters * 1.5707963267341256;
  x = (x - quarters * 6.077100506303966e-11) - quarters * 2.0222662487959506e-21;
  auto terms = [](double first, double second, const T &y)
                   __attribute__((always_inline)) { return 1.0 / first - y * (1.0 / second); };
  T y = x * x, y2 = y * y, y4 = y2 * y2;
  T s = terms(6.0, 120.0, y) + y2 * terms(5040.0, 362880.0, y);
  s += y4 * (terms(39916800.0, 6227020800.0, y) + y2 * terms(1307674368000.0, 355687428096000.0, y));
  s = x - (x * y) * s;
  T c = terms(2.0, 24.0, y) + y2 * terms(720.0, 40320.0, y);
  c += y4 * (terms(3628800.0, 479001600.0, y) + y2 * terms(87178291200.0, 20922789888000.0, y));
  c = 1.0 - y * c;
  T half = floor_of(0.5 * quarters), odd = quarters - 2.0 * half;
  T sign = 1.0 - 2.0 * (half - 2.0 * floor_of(0.5 * half));
  return {sign * ((1.0 - odd) * c - odd * s), sign * ((1.0 - odd) * s + odd * c)};
}
template <Number X>
CORE_INLINE auto cosine_sine(const X &angle) {
  auto [cosine, sine] = cosine_sine_value(value_of(angle));
  auto c = cosine, s = sine;
  return std::pair{with_slope(angle, c, [&] { return -s; }), with_slope(angle, s, [&] { return c; })};
}

using Quaternion = std::array<Pack, 4>;

CORE_INLINE Quaternion product(const Quaternion &p, const Quaternion &q) {
  return {p[3] * q[0] + p[0] * q[3] + p[1] * q[2] - p[2] * q[1], p[3] * q[1] - p[0] * q[2] + p[1] * q[3] + p[2] * q[0],
          p[3] * q[2] + p[0] * q[1] - p[1] * q[0] + p[2] * q[3], p[3] * q[3] - p[0] * q[0] - p[1] * q[1] - p[2] * q[2]};
}

// The orientation after `step` [s] at an angular velocity [rad/s] in fixed axes that is known at start, middle and end:
// a Magnus step of fourth order. The result has unit norm.
CORE_INLINE Quaternion rotated(const Quaternion &before, const Triple &start, const Triple &middle, const Triple &end,
                               const Pack &step) {
  Triple turn, commutator = cross(end, start);
  for (int i = 0; i < 3; i++)
    turn[i] = step * (1.0 / 6.0) * ((start[i] + end[i]) + 4.0 * middle[i]) + step * step * (1.0 / 12.0) * commutator[i];
  Pack angle = square_root(dot(turn, turn) + 1e-200);  // the small number spares a branch for no rotation at all
  auto [cosine, sine] = cosine_sine_value(Pack(0.5 * angle));
  Pack factor = sine / angle;
  Quaternion after = product({factor * turn[0], factor * turn[1], factor * turn[2], cosine}, before);
  Pack inverse = 1.0 / square_root(after[0] * after[0] + after[1] * after[1] + after[2] * after[2] + after[3] * after[3]);
  for (Pack &part : after) part *= inverse;
  return after;
}

// Small systems of linear equations, by elimination with the greatest pivot of each column.

template <std::size_t N>
using SquareMatrix = std::array<std::array<double, N>, N>;

// Puts the triangular factors of a matrix of this size in its place, the inverse pivots on the diagonal; `at(i, j)` is an entry,
// `pivot` (size,) the row that each row changed places with. False where the matrix is singular or not finite.
template <class Entry>
inline bool factorise_dense(int size, Entry at, int *pivot) {
  bool regular = true;
  for (int k = 0; k < size; k++) {
    pivot[k] = k;
    for (int i = k + 1; i < size; i++)
      if (std::fabs(at(i, k)) > std::fabs(at(pivot[k], k))) pivot[k] = i;
    regular &= std::fabs(at(pivot[k], k)) > 0.0;
    if (pivot[k] != k)
      for (int j = 0; j < size; j++) std::swap(at(pivot[k], j), at(k, j));
    at(k, k) = 1.0 / at(k, k);
    for (int i = k + 1; i < size; i++) {
      if (at(i, k) == 0.0) continue;
      double share = at(i, k) *= at(k, k);
      for (int j = k + 1; j < size; j++) at(i, j) -= share * at(k, j);
    }
  }
  return regular;
}

// Solves for a right-hand side, in place, by the factors of `factorise_dense`.
template <class Entry, class Right>
inline void substitute_dense(int size, Entry entry, const int *pivot, Right &&right) {
  for (int k = 0; k < size; k++)
    if (pivot[k] != k) std::swap(right[k], right[pivot[k]]);
  for (int k = 0; k < size; k++) {
    double x = right[k];
    for (int j = 0; j < k; j++) x -= entry(k, j) * right[j];
    right[k] = x;
  }
  for (int k = size; k-- > 0;) {
    double x = right[k];
    for (int j = k + 1; j < size; j++) x -= entry(k, j) * right[j];
    right[k] = x * entry(k, k);
  }
}

// Solves matrix x = right in place; false where the matrix is singular or not finite.
template <std::size_t N>
bool solve(SquareMatrix<N> &matrix, std::array<double, N> &right) {
  auto entry = [&](int i, int j) -> double & { return matrix[i][j]; };
  int pivot[N];
  if (!factorise_dense(int(N), entry, pivot)) return false;
  substitute_dense(int(N), entry, pivot, right);
  return true;
}

// Inverts the first N rows and columns in lanes, in place, by Gauss and Jordan; without pivots, for heavy diagonals.
template <int N, int M>
[[gnu::noinline]] inline void invert_in_lanes(Pack (&a)[M][M]) {
#pragma GCC unroll 8
  for (int k = 0; k < N; k++) {
    Pack inverse = 1.0 / a[k][k];
    a[k][k] = broadcast<Pack>(1.0);
#pragma GCC unroll 8
    for (int j = 0; j < N; j++) a[k][j] *= inverse;
#pragma GCC unroll 8
    for (int i = 0; i < N; i++) {
      if (i == k) continue;
      Pack factor = a[i][k];
      a[i][k] = Pack{};
#pragma GCC unroll 8
      for (int j = 0; j < N; j++) a[i][j] -= factor * a[k][j];
    }
  }
}
template <int N, int M>
CORE_INLINE void multiply_in_lanes(const Pack (&a)[M][M], const Pack *x, Pack *product) {
  for (int i = 0; i < N; i++) {
    product[i] = a[i][0] * x[0];
    for (int j = 1; j < N; j++) product[i] += a[i][j] * x[j];
  }
}

}  // namespace core
