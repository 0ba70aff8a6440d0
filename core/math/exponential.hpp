// Exponential and natural logarithm in lanes, within 4e-16 of the argument's size and without a branch.
#pragma once
#include <bit>
#include "dual.hpp"

namespace core {

CORE_INLINE std::int64_t bits_of(double x) { return std::bit_cast<std::int64_t>(x); }
CORE_INLINE Mask bits_of(const Pack &x) { return reinterpret_cast<Mask>(x); }
CORE_INLINE double with_bits(std::int64_t bits) { return std::bit_cast<double>(bits); }
CORE_INLINE Pack with_bits(const Mask &bits) { return reinterpret_cast<Pack>(bits); }

// exp(x), of x beyond 700 that of 700: x = n ln 2 + y with ln 2 in two parts (Cody and Waite), Taylor's series to the 12th power.
template <class T>
CORE_INLINE T exponential_value(const T &any) {
  constexpr double SHIFT = 6755399441055744.0;  // 1.5 2^52: a whole number added to it stands in the lowest bits
  T x = minimum(maximum(any, broadcast<T>(-700.0)), broadcast<T>(700.0));
  T n = floor_of(x * 1.4426950408889634 + 0.5);
  T y = (x - n * 0.6931471803691238) - n * 1.9082149292705877e-10, y2 = y * y, y4 = y2 * y2;
  T low = (1.0 + y) + y2 * (0.5 + y * (1.0 / 6.0)), middle = (1.0 / 24.0 + y * (1.0 / 120.0)) + y2 * (1.0 / 720.0 + y * (1.0 / 5040.0));
  T high = (1.0 / 40320.0 + y * (1.0 / 362880.0)) + y2 * (1.0 / 3628800.0 + y * (1.0 / 39916800.0)) + y4 * (1.0 / 479001600.0);
  auto power = (bits_of(T(n + SHIFT)) << 52) + (std::int64_t(1023) << 52);
  return (low + y4 * (middle + y4 * high)) * with_bits(power);
}
// ln(x) for normal x above 0: x = 2^n m with m within the root of 2 of 1, then the series of the inverse hyperbolic tangent.
template <class T>
CORE_INLINE T logarithm_value(const T &x) {
  constexpr std::int64_t MANTISSA = (std::int64_t(1) << 52) - 1, ONE = std::int64_t(1023) << 52, WHOLE = std::int64_t(1075) << 52;
  auto bits = bits_of(x);
  T m = with_bits((bits & MANTISSA) | ONE), n = with_bits(((bits >> 52) & 2047) | WHOLE) - (4503599627370496.0 + 1023.0);
  auto large = m > 1.4142135623730951;
  m = select(large, T(0.5 * m), m), n = select(large, T(n + 1.0), n);
  T s = (m - 1.0) / (m + 1.0), z = s * s, z2 = z * z;
  T low = (1.0 + z * (1.0 / 3.0)) + z2 * (0.2 + z * (1.0 / 7.0)), high = (1.0 / 9.0 + z * (1.0 / 11.0)) + z2 * (1.0 / 13.0 + z * (1.0 / 15.0));
  return n * 0.6931471805599453 + 2.0 * s * (low + z2 * z2 * (high + z2 * z2 * (1.0 / 17.0)));
}
template <Number X>
CORE_INLINE auto exponential(const X &x) {
  auto value = exponential_value(value_of(x));
  return with_slope(x, value, [&] { return value; });
}
template <Number X>
CORE_INLINE auto logarithm(const X &x) {
  return with_slope(x, logarithm_value(value_of(x)), [&] { return 1.0 / value_of(x); });
}

}  // namespace core
