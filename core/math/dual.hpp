// Forward-mode derivatives. Dual<COLUMNS, T> is a number of type T (double or Pack) with its partial derivatives by the
// independent variables whose bits are set in COLUMNS. What cannot depend on a variable does not carry its column: the
// type says so, and it costs nothing. Zero is a zero that the type knows.
#pragma once
#include <bit>
#include <type_traits>
#include <utility>
#include "pack.hpp"

namespace core {

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
template <Number X> CORE_INLINE Zero operator*(Zero, const X &) { return {}; }
template <Number X> CORE_INLINE Zero operator*(const X &, Zero) { return {}; }
template <Number X> CORE_INLINE X operator+(Zero, const X &x) { return x; }
template <Number X> CORE_INLINE X operator+(const X &x, Zero) { return x; }
template <Number X> CORE_INLINE X operator-(const X &x, Zero) { return x; }
template <Number X> CORE_INLINE auto operator-(Zero, const X &x) { return -x; }

template <unsigned COLUMNS, int C = 0, int... FOUND>
constexpr auto column_numbers() {
  if constexpr (COLUMNS >> C == 0) return std::integer_sequence<int, FOUND...>{};
  else if constexpr (COLUMNS >> C & 1) return column_numbers<COLUMNS, C + 1, FOUND..., C>();
  else return column_numbers<COLUMNS, C + 1, FOUND...>();
}
template <unsigned COLUMNS, class T, class Function, int... C>
CORE_INLINE Dual<COLUMNS, T> filled_dual(const T &value, Function slope, std::integer_sequence<int, C...>) {
  return {value, {slope.template operator()<C>()...}};
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
  else return dual<columns_of<X>>(value, [&, factor = slope()]<int C>() __attribute__((always_inline)) {
    return factor * slope_of<C>(x);
  });
}
// The same number with room for more columns, so that branches of different types can return one.
template <unsigned COLUMNS, class X>
CORE_INLINE auto widened(const X &x) {
  if constexpr (columns_of<X> == COLUMNS) return x;
  else return dual<COLUMNS>(value_of(x), [&]<int C>() __attribute__((always_inline)) {
    auto slope = slope_of<C>(x);
    if constexpr (IsZero<decltype(slope)>) return ValueOf<X>{};
    else return slope;
  });
}

template <class X, class Y> requires WithDual<X, Y>
CORE_INLINE auto operator+(const X &x, const Y &y) {
  return dual<columns_of<X> | columns_of<Y>>(value_of(x) + value_of(y), [&]<int C>() __attribute__((always_inline)) {
    return slope_of<C>(x) + slope_of<C>(y);
  });
}
template <class X, class Y> requires WithDual<X, Y>
CORE_INLINE auto operator-(const X &x, const Y &y) {
  return dual<columns_of<X> | columns_of<Y>>(value_of(x) - value_of(y), [&]<int C>() __attribute__((always_inline)) {
    return slope_of<C>(x) - slope_of<C>(y);
  });
}
template <IsDual X>
CORE_INLINE auto operator-(const X &x) {
  return dual<columns_of<X>>(-x.value, [&]<int C>() __attribute__((always_inline)) { return -slope_of<C>(x); });
}
template <class X, class Y> requires WithDual<X, Y>
CORE_INLINE auto operator*(const X &x, const Y &y) {
  return dual<columns_of<X> | columns_of<Y>>(value_of(x) * value_of(y), [&]<int C>() __attribute__((always_inline)) {
    return slope_of<C>(x) * value_of(y) + value_of(x) * slope_of<C>(y);
  });
}
template <class X, class Y> requires WithDual<X, Y>
CORE_INLINE auto operator/(const X &x, const Y &y) {
  auto inverse = 1.0 / value_of(y);
  if constexpr (!IsDual<Y>) return x * inverse;
  else {
    auto quotient = value_of(x) * inverse;
    return dual<columns_of<X> | columns_of<Y>>(quotient, [&]<int C>() __attribute__((always_inline)) {
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
CORE_INLINE auto floor_of(const X &x) { return floor_of(x.value); }
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
CORE_INLINE auto minimum(const X &x, double most) {
  using T = ValueOf<X>;
  return with_slope(x, minimum(x.value, most), [&] { return select(x.value < most, broadcast<T>(1.0), T{}); });
}
// Lane by lane one of two numbers with the same columns.
template <class M, IsDual X>
CORE_INLINE X select(const M &which, const X &yes, const X &no) {
  return dual<columns_of<X>>(select(which, yes.value, no.value), [&]<int C>() __attribute__((always_inline)) {
    return select(which, slope_of<C>(yes), slope_of<C>(no));
  });
}
// The root of a square above zero, and its inverse, which does not wait for the root.
template <Number X>
CORE_INLINE auto root_and_inverse(const X &square) {
  auto root = square_root(value_of(square)), inverse = root * (1.0 / value_of(square));
  return std::pair{with_slope(square, root, [&] { return 0.5 * inverse; }),
                   with_slope(square, inverse, [&] { return -0.5 * inverse * (inverse * inverse); })};
}
// A function of one number, differentiated by that number and then by what the number depends on.
template <class Function, Number X>
CORE_INLINE auto chained(Function function, const X &x) {
  if constexpr (!IsDual<X>) return function(x);
  else {
    auto found = function(variable<0>(x.value));
    return with_slope(x, found.value, [&] { return found.slope[0]; });
  }
}

// y, whose columns 0, 1, ... are derivatives by the numbers x, with derivatives by what these depend on.
template <class Y, class... X>
CORE_INLINE auto composed(const Y &y, const X &...x) {
  if constexpr (!IsDual<Y>) return y;
  else {
    constexpr unsigned own = columns_of<Y>;
    return [&]<int... N>(std::integer_sequence<int, N...>) __attribute__((always_inline)) {
      constexpr unsigned columns = (0u | ... | (own >> N & 1 ? columns_of<X> : 0u));
      return dual<columns>(y.value, [&]<int C>() __attribute__((always_inline)) {
        return (Zero{} + ... + (slope_of<N>(y) * slope_of<C>(x)));
      });
    }(std::make_integer_sequence<int, sizeof...(X)>{});
  }
}
// The independent variable C where derivatives are wanted, else the value.
template <bool DERIVATIVES, int C, class T>
CORE_INLINE auto input(const T &value) {
  if constexpr (DERIVATIVES) return variable<C>(value);
  else return value;
}

// The derivative by the independent variables, of which x carries some at most: zero where it carries none.
template <int C, class X>
CORE_INLINE auto full_slope(const X &x) {
  auto slope = slope_of<C>(x);
  if constexpr (IsZero<decltype(slope)>) return Pack{};
  else return slope;
}

}  // namespace core
