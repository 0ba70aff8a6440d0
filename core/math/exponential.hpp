// Exponential and natural logarithm in lanes, without a branch: the first within 3e-10 of its value, for models of no more
// digits; the second within 1e-11, and 1e-15 where slopes are taken.
#pragma once
#include <bit>
#include "dual.hpp"

namespace core {

using Bits = std::uint64_t __attribute__((vector_size(8 * LANES)));
CORE_INLINE std::uint64_t bits_of(double x) { return std::bit_cast<std::uint64_t>(x); }
CORE_INLINE Bits bits_of(const Pack &x) { return reinterpret_cast<Bits>(x); }
CORE_INLINE double with_bits(std::uint64_t bits) { return std::bit_cast<double>(bits); }
CORE_INLINE Pack with_bits(const Bits &bits) { return reinterpret_cast<Pack>(bits); }

// exp(x), of x beyond 700 that of 700: x = n ln 2 + y, Taylor's series of exp(y) to the 8th power.
template <class T>
CORE_INLINE T exponential_value(const T &any) {
  constexpr double SHIFT = 6755399441055744.0;  // 1.5 2^52: a whole number added to it stands in the lowest bits
  T x = minimum(maximum(any, broadcast<T>(-700.0)), broadcast<T>(700.0));
  T shifted = x * 1.4426950408889634 + SHIFT;
  T y = x - (shifted - SHIFT) * 0.6931471805599453, y2 = y * y;
  T high = (1.0 / 24.0 + y * (1.0 / 120.0)) + y2 * ((1.0 / 720.0 + y * (1.0 / 5040.0)) + y2 * (1.0 / 40320.0));
  T value = ((1.0 + y) + y2 * (0.5 + y * (1.0 / 6.0))) + (y2 * y2) * high;
  return with_bits(bits_of(value) + (bits_of(shifted) << 52));
}
// ln(x) for normal x above 0: x = 2^n m with m within the root of 2 of 1, then the series of the inverse hyperbolic tangent.
template <class T>
CORE_INLINE T logarithm_value(const T &x) {
  constexpr std::uint64_t ROOT = 0x3fe6a09e667f3bcd, ONE = 0x3ff0000000000000, WHOLE = 0x4330000000000000;  // of 1/2; 1; 2^52
  auto bits = bits_of(x) + (ONE - ROOT);  // so that the exponent steps where m does
  T n = with_bits((bits >> 52) | WHOLE) - (4503599627370496.0 + 1023.0);
  T m = with_bits((bits & ((std::uint64_t(1) << 52) - 1)) + ROOT), s = (m - 1.0) / (m + 1.0), z = s * s;
  T series = (1.0 + z * (1.0 / 3.0)) + (z * z) * ((0.2 + z * (1.0 / 7.0)) + (z * z) * (1.0 / 9.0 + z * (1.0 / 11.0)));
  return n * 0.6931471805599453 + 2.0 * s * series;
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
