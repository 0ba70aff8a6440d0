// Vectors of three numbers, each of a type of its own, and 3 x 3 matrices of packs.
#pragma once
#include <array>
#include "dual.hpp"

namespace core {

template <class X, class Y = X, class Z = X>
struct Vector3 { X x; Y y; Z z; };
template <class X, class Y, class Z> Vector3(X, Y, Z) -> Vector3<X, Y, Z>;

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
CORE_INLINE auto dot(const Vector3<A, B, C> &a, const Vector3<D, E, F> &b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
template <class A, class B, class C, class D, class E, class F>
CORE_INLINE auto cross(const Vector3<A, B, C> &a, const Vector3<D, E, F> &b) {
  return Vector3{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
// The vector turned about z by the angle of this cosine and sine.
template <class C, class S, class X, class Y, class Z>
CORE_INLINE auto about_z(const C &cosine, const S &sine, const Vector3<X, Y, Z> &a) {
  return Vector3{cosine * a.x - sine * a.y, sine * a.x + cosine * a.y, a.z};
}

using Triple = std::array<Pack, 3>;
using Matrix3 = std::array<Triple, 3>;

CORE_INLINE Triple operator+(const Triple &a, const Triple &b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
CORE_INLINE Pack dot(const Triple &a, const Triple &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
CORE_INLINE Triple cross(const Triple &a, const Triple &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
CORE_INLINE Triple operator*(const Matrix3 &m, const Triple &a) { return {dot(m[0], a), dot(m[1], a), dot(m[2], a)}; }
CORE_INLINE Matrix3 operator+(const Matrix3 &a, const Matrix3 &b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
CORE_INLINE Matrix3 operator*(const Matrix3 &a, const Matrix3 &b) {
  Matrix3 product;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) product[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
  return product;
}
// diagonal * I - m
CORE_INLINE Matrix3 shifted_negative(const Pack &diagonal, const Matrix3 &m) {
  Matrix3 result;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) result[i][j] = i == j ? diagonal - m[i][j] : -m[i][j];
  return result;
}
CORE_INLINE Matrix3 inverse_of(const Matrix3 &m) {
  Triple a = cross(m[1], m[2]), b = cross(m[2], m[0]), c = cross(m[0], m[1]);
  Pack over = 1.0 / dot(m[0], a);
  Matrix3 result;
  for (int i = 0; i < 3; i++) result[i] = {over * a[i], over * b[i], over * c[i]};
  return result;
}

}  // namespace core
