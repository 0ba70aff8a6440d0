// Numbers that formulas are templates over: doubles, SIMD lanes, dual numbers; exponential and logarithm of them.
#pragma once
#include <bit>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <utility>

#define CORE_EXPORT \
  extern "C" [[gnu::visibility("default")]]  // plain C functions on C-contiguous arrays: core.Function in bearing_twin
#ifndef CORE_INLINE  // sanitizers take `inline`: what they add to one large function takes minutes to compile
#define CORE_INLINE [[gnu::always_inline]] inline
#endif
#ifdef __AVX512F__
constexpr int LANES = 8;
#else
constexpr int LANES = 4;
#endif

namespace core {

// SIMD lanes: doubles side by side as the compilers' vector type, with the same operations as for one double.

using Pack = double __attribute__((vector_size(8 * LANES)));
using Mask = std::int64_t __attribute__((vector_size(8 * LANES)));

template <class Function>
CORE_INLINE Pack each_lane(const Pack &x, Function function) {
  Pack result;
  for (int lane = 0; lane < LANES; lane++) result[lane] = function(x[lane]);
  return result;
}

CORE_INLINE double lane_sum(const Pack &x) {
  double sum = 0.0;
  for (int lane = 0; lane < LANES; lane++) sum += x[lane];
  return sum;
}

CORE_INLINE double square_root(double x) { return __builtin_sqrt(x); }
CORE_INLINE Pack square_root(const Pack &x) {
  return each_lane(x, [](double x) { return __builtin_sqrt(x); });
}
CORE_INLINE double floor_of(double x) { return __builtin_floor(x); }
CORE_INLINE Pack floor_of(const Pack &x) {
  return each_lane(x, [](double x) { return __builtin_floor(x); });
}
CORE_INLINE double absolute(double x) { return __builtin_fabs(x); }
CORE_INLINE Pack absolute(const Pack &x) {
  return each_lane(x, [](double x) { return __builtin_fabs(x); });
}

CORE_INLINE double select(bool mask, double yes, double no) { return mask ? yes : no; }
CORE_INLINE Pack select(const Mask &mask, const Pack &yes, const Pack &no) { return mask ? yes : no; }

template <class T>
CORE_INLINE T broadcast(double x) {
  return T{} + x;
}

CORE_INLINE double maximum(double x, double y) { return x > y ? x : y; }
CORE_INLINE Pack maximum(const Pack &x, const Pack &y) { return x > y ? x : y; }
CORE_INLINE Pack maximum(const Pack &x, double y) { return maximum(x, broadcast<Pack>(y)); }
CORE_INLINE double minimum(double x, double y) { return x < y ? x : y; }
CORE_INLINE Pack minimum(const Pack &x, const Pack &y) { return x < y ? x : y; }
CORE_INLINE Pack minimum(const Pack &x, double y) { return minimum(x, broadcast<Pack>(y)); }

CORE_INLINE bool any(bool mask) { return mask; }
CORE_INLINE bool any(const Mask &mask) {
  std::int64_t found = 0;
  for (int lane = 0; lane < LANES; lane++) found |= mask[lane];
  return found != 0;
}

// Forward-mode derivatives. Dual<COLUMNS, T> is a number of type T (double or Pack) with its partial derivatives by the
// independent variables whose bits are set in COLUMNS. What cannot depend on a variable does not carry its column: the
// type says so, and it costs nothing. Zero is a zero that the type knows.

struct Zero {};

template <unsigned COLUMNS, class T>
struct Dual {
  T value;
  T slope[std::popcount(COLUMNS)];
};

template <class X>
struct NumberTraits {
  static constexpr unsigned columns = 0;
  static constexpr bool number = std::is_same_v<X, double> || std::is_same_v<X, Pack>;
};
template <unsigned COLUMNS, class T>
struct NumberTraits<Dual<COLUMNS, T>> {
  static constexpr unsigned columns = COLUMNS;
  static constexpr bool number = true;
};
template <class X>
constexpr unsigned columns_of = NumberTraits<std::remove_cvref_t<X>>::columns;
template <class X>
concept Number = NumberTraits<X>::number;
template <class X>
concept IsDual = Number<X> && columns_of<X> != 0;
template <class X>
concept IsZero = std::is_same_v<std::remove_cvref_t<X>, Zero>;
template <class X, class Y>
concept WithDual = Number<X> && Number<Y> && (IsDual<X> || IsDual<Y>);

template <class X>
CORE_INLINE auto value_of(const X &x) {
  if constexpr (IsDual<X>) return x.value;
  else return x;
}
template <class X>
using ValueOf = decltype(value_of(std::declval<const X &>()));

// The partial derivative of x by independent variable C: Zero where the type does not carry it.
template <int C, class X>
CORE_INLINE auto slope_of(const X &x) {
  constexpr unsigned columns = columns_of<X>;
  if constexpr (columns >> C & 1) return x.slope[std::popcount(columns & ((1u << C) - 1))];
  else return Zero{};
}

CORE_INLINE Zero operator+(Zero, Zero) { return {}; }
CORE_INLINE Zero operator-(Zero, Zero) { return {}; }
CORE_INLINE Zero operator-(Zero) { return {}; }
CORE_INLINE Zero operator*(Zero, Zero) { return {}; }
template <Number X>
CORE_INLINE Zero operator*(Zero, const X &) {
  return {};
}
template <Number X>
CORE_INLINE Zero operator*(const X &, Zero) {
  return {};
}
template <Number X>
CORE_INLINE X operator+(Zero, const X &x) {
  return x;
}
template <Number X>
CORE_INLINE X operator+(const X &x, Zero) {
  return x;
}
template <Number X>
CORE_INLINE X operator-(const X &x, Zero) {
  return x;
}
template <Number X>
CORE_INLINE auto operator-(Zero, const X &x) {
  return -x;
}

template <unsigned COLUMNS, int C = 0, int... FOUND>
constexpr auto column_numbers() {
  if constexpr (COLUMNS >> C == 0) return std::integer_sequence<int, FOUND...>{};
  else if constexpr (COLUMNS >> C & 1) return column_numbers<COLUMNS, C + 1, FOUND..., C>();
  else return column_numbers<COLUMNS, C + 1, FOUND...>();
}
template <unsigned COLUMNS, class T, class Function, int... C>
CORE_INLINE Dual<COLUMNS, T> filled_dual(const T &value, Function slope, std::integer_sequence<int, C...>) {
  return { value, {slope.template operator()<C>()...} };
}
// The dual number of this value whose derivative by variable C is slope.operator()<C>().
template <unsigned COLUMNS, class T, class Function>
CORE_INLINE auto dual(const T &value, Function slope) {
  return filled_dual<COLUMNS>(value, slope, column_numbers<COLUMNS>());
}

// The independent variable C at this value.
template <int C, class T>
CORE_INLINE auto variable(const T &value) {
  return Dual<1u << C, T>{value, {broadcast<T>(1.0)}};
}
// A function's value with the given derivative by x, for x of any type.
template <Number X, class T, class Function>
CORE_INLINE auto with_slope(const X &x, const T &value, Function slope) {
  if constexpr (!IsDual<X>) return value;
  else
    return dual<columns_of<X>>(value,
                               [&, factor = slope()]<int C>() __attribute__((always_inline)) { return factor * slope_of<C>(x); });
}
// The same number with room for more columns, so that branches of different types can return one.
template <unsigned COLUMNS, class X>
CORE_INLINE auto widened(const X &x) {
  if constexpr (columns_of<X> == COLUMNS) return x;
  else
    return dual<COLUMNS>(value_of(x), [&]<int C>() __attribute__((always_inline)) {
      auto slope = slope_of<C>(x);
      if constexpr (IsZero<decltype(slope)>) return ValueOf<X>{};
      else return slope;
    });
}

template <class X, class Y>
  requires WithDual<X, Y>
CORE_INLINE auto operator+(const X &x, const Y &y) {
  return dual < columns_of<X> | columns_of < Y >> (value_of(x) + value_of(y), [&]<int C>() __attribute__((always_inline)) {
                                  return slope_of<C>(x) + slope_of<C>(y);
                                });
}
template <class X, class Y>
  requires WithDual<X, Y>
CORE_INLINE auto operator-(const X &x, const Y &y) {
  return dual < columns_of<X> | columns_of < Y >> (value_of(x) - value_of(y), [&]<int C>() __attribute__((always_inline)) {
                                  return slope_of<C>(x) - slope_of<C>(y);
                                });
}
template <IsDual X>
CORE_INLINE auto operator-(const X &x) {
  return dual<columns_of<X>>(-x.value, [&]<int C>() __attribute__((always_inline)) { return -slope_of<C>(x); });
}
template <class X, class Y>
  requires WithDual<X, Y>
CORE_INLINE auto operator*(const X &x, const Y &y) {
  return dual < columns_of<X> | columns_of < Y >> (value_of(x) * value_of(y), [&]<int C>() __attribute__((always_inline)) {
                                  return slope_of<C>(x) * value_of(y) + value_of(x) * slope_of<C>(y);
                                });
}
template <class X, class Y>
  requires WithDual<X, Y>
CORE_INLINE auto operator/(const X &x, const Y &y) {
  auto inverse = 1.0 / value_of(y);
  if constexpr (!IsDual<Y>) return x * inverse;
  else {
    auto quotient = value_of(x) * inverse;
    return dual < columns_of<X> | columns_of < Y >> (quotient, [&]<int C>() __attribute__((always_inline)) {
                                    return (slope_of<C>(x) - quotient * slope_of<C>(y)) * inverse;
                                  });
  }
}
template <IsDual X>
CORE_INLINE auto square_root(const X &x) {
  auto root = square_root(x.value);
  return with_slope(x, root, [&] { return 0.5 / root; });
}
template <IsDual X>
CORE_INLINE auto floor_of(const X &x) {
  return floor_of(x.value);
}
template <IsDual X>
CORE_INLINE auto absolute(const X &x) {
  using T = ValueOf<X>;
  return with_slope(x, absolute(x.value), [&] { return select(x.value >= 0.0, broadcast<T>(1.0), broadcast<T>(-1.0)); });
}
template <IsDual X, class L>
CORE_INLINE auto maximum(const X &x, const L &least) {
  using T = ValueOf<X>;
  return with_slope(x, maximum(x.value, least), [&] { return select(x.value > least, broadcast<T>(1.0), T{}); });
}
template <IsDual X>
CORE_INLINE auto minimum(const X &x, double bound) {
  using T = ValueOf<X>;
  return with_slope(x, minimum(x.value, bound), [&] { return select(x.value < bound, broadcast<T>(1.0), T{}); });
}
// Lane by lane one of two numbers with the same columns.
template <class M, IsDual X>
CORE_INLINE X select(const M &mask, const X &yes, const X &no) {
  return dual<columns_of<X>>(select(mask, yes.value, no.value), [&]<int C>() __attribute__((always_inline)) {
    return select(mask, slope_of<C>(yes), slope_of<C>(no));
  });
}
// The root of a square above zero, and its inverse, which does not wait for the root.
template <Number X>
CORE_INLINE auto root_and_inverse(const X &square) {
  auto root = square_root(value_of(square)), inverse = root * (1.0 / value_of(square));
  return std::pair{with_slope(square, root, [&] { return 0.5 * inverse; }),
                   with_slope(square, inverse, [&] { return -0.5 * inverse * (inverse * inverse); })};
}
// y, whose columns 0, 1, ... are derivatives by the numbers x, with derivatives by what these depend on.
template <class Y, class... X>
CORE_INLINE auto composed(const Y &y, const X &...x) {
  if constexpr (!IsDual<Y>) return y;
  else {
    constexpr unsigned y_columns = columns_of<Y>;
    return [&]<int... N>(std::integer_sequence<int, N...>) __attribute__((always_inline)) {
      constexpr unsigned columns = (0u | ... | (y_columns >> N & 1 ? columns_of<X> : 0u));
      return dual<columns>(
          y.value, [&]<int C>() __attribute__((always_inline)) { return (Zero{} + ... + (slope_of<N>(y) * slope_of<C>(x))); });
    }(std::make_integer_sequence<int, sizeof...(X)>{});
  }
}
// A number that functions know when they are compiled: index<C> is handed over for the template argument C.
template <int C>
using Index = std::integral_constant<int, C>;
template <int C>
constexpr Index<C> index{};

// The independent variable C with DERIVATIVES, else the value.
template <bool DERIVATIVES, int C, class T>
CORE_INLINE auto input(const T &value) {
  if constexpr (DERIVATIVES) return variable<C>(value);
  else return value;
}

// The independent variable C at the value of a number with derivatives; others stay what they are.
template <int C, class X>
CORE_INLINE auto local(const X &x) {
  if constexpr (IsDual<X>) return variable<C>(x.value);
  else return x;
}

// A function of one number, differentiated by that number and by the chain rule by the variables of the number.
template <class Function, Number X>
CORE_INLINE auto chained(Function function, const X &x) {
  return composed(function(local<0>(x)), x);
}

// Calls function(number of the variable, partial derivative) for those that x carries.
template <class X, class Function>
CORE_INLINE void for_each_slope(const X &x, Function function) {
  if constexpr (IsDual<X>)
    [&]<int... C>(std::integer_sequence<int, C...>)
        __attribute__((always_inline)) { (function(C, slope_of<C>(x)), ...); }(column_numbers<columns_of<X>>());
}

// The value in lanes, zero where there is none; then the derivative by an independent variable, zero where x carries none.
template <class X>
CORE_INLINE Pack as_pack(const X &x) {
  if constexpr (IsZero<X>) return Pack{};
  else return value_of(x);
}
template <int C, class X>
CORE_INLINE Pack full_slope(const X &x) {
  return as_pack(slope_of<C>(x));
}

// Exponential and natural logarithm in lanes, without a branch: the first within 3e-10 of its value, for models of no more
// digits; the second within 1e-11, and 1e-15 where slopes are taken.

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
