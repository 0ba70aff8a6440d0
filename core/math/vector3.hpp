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

// Three numbers of one type and 3 x 3 matrices of their rows; a sum of matrices is that of their rows.
template <class T>
using TripleOf = std::array<T, 3>;
template <class T>
using Matrix3Of = TripleOf<TripleOf<T>>;
using Triple = TripleOf<Pack>;
using Matrix3 = Matrix3Of<Pack>;

template <class T>
CORE_INLINE TripleOf<T> operator+(const TripleOf<T> &a, const TripleOf<T> &b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
template <class T>
CORE_INLINE TripleOf<T> operator-(const TripleOf<T> &a, const TripleOf<T> &b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
template <class T>
CORE_INLINE TripleOf<T> operator*(double factor, const TripleOf<T> &a) { return {factor * a[0], factor * a[1], factor * a[2]}; }
template <class T>
CORE_INLINE T dot(const TripleOf<T> &a, const TripleOf<T> &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
template <class T>
CORE_INLINE TripleOf<T> cross(const TripleOf<T> &a, const TripleOf<T> &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class T>
CORE_INLINE TripleOf<T> operator*(const Matrix3Of<T> &m, const TripleOf<T> &a) { return {dot(m[0], a), dot(m[1], a), dot(m[2], a)}; }
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

// Vectors of fixed or of a body's axes, and matrices that turn one into the other.
using Real3 = TripleOf<double>;
using RealMatrix3 = Matrix3Of<double>;
CORE_INLINE double length_of(const Real3 &a) { return std::sqrt(dot(a, a)); }

}  // namespace core
