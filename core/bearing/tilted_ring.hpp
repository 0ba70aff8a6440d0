// A ring whose tilt is taken to first order: a point at p of it goes to p + theta x p.
#pragma once
#include "../math/vector3.hpp"

namespace core {

// The axes of a tilted ring, as rows in the frame in which its tilt is x, y: the inverse of 1 + tilt x.
template <class X, class Y, class Z>
struct RingAxes { X x; Y y; Z z; };
template <class X, class Y, class Z> RingAxes(X, Y, Z) -> RingAxes<X, Y, Z>;
template <class X, class Y>
CORE_INLINE auto ring_axes(const X &x, const Y &y) {
  auto xx = x * x, yy = y * y;
  auto share = 1.0 / (1.0 + (xx + yy));
  auto xy = share * (x * y), sx = share * x, sy = share * y;
  return RingAxes{Vector3{share * (1.0 + xx), xy, -sy}, Vector3{xy, share * (1.0 + yy), sx}, Vector3{sy, -sx, share}};
}
template <class A, class V>
CORE_INLINE auto into_ring(const A &axes, const V &v) { return Vector3{dot(axes.x, v), dot(axes.y, v), dot(axes.z, v)}; }
template <class A, class V>
CORE_INLINE auto out_of_ring(const A &axes, const V &v) { return (v.x * axes.x + v.y * axes.y) + v.z * axes.z; }

}  // namespace core
