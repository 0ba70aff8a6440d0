// SIMD lanes: doubles side by side as the compilers' vector type, with the same operations as for one double.
#pragma once
#include <cmath>
#include <cstdint>

#ifndef CORE_INLINE  // sanitizers take `inline`: what they add to one large function takes minutes to compile
#define CORE_INLINE [[gnu::always_inline]] inline
#endif
#ifdef __AVX512F__
constexpr int LANES = 8;
#else
constexpr int LANES = 4;
#endif

namespace core {

using Pack = double __attribute__((vector_size(8 * LANES)));
using Mask = std::int64_t __attribute__((vector_size(8 * LANES)));

template <class Function>
CORE_INLINE Pack each_lane(const Pack &x, Function function) {
  Pack result;
  for (int lane = 0; lane < LANES; lane++) result[lane] = function(x[lane]);
  return result;
}

CORE_INLINE double square_root(double x) { return __builtin_sqrt(x); }
CORE_INLINE Pack square_root(const Pack &x) { return each_lane(x, [](double one) { return __builtin_sqrt(one); }); }
CORE_INLINE double floor_of(double x) { return __builtin_floor(x); }
CORE_INLINE Pack floor_of(const Pack &x) { return each_lane(x, [](double one) { return __builtin_floor(one); }); }
CORE_INLINE double absolute(double x) { return __builtin_fabs(x); }
CORE_INLINE Pack absolute(const Pack &x) { return each_lane(x, [](double one) { return __builtin_fabs(one); }); }

CORE_INLINE double select(bool which, double yes, double no) { return which ? yes : no; }
CORE_INLINE Pack select(const Mask &which, const Pack &yes, const Pack &no) { return which ? yes : no; }

template <class T>
CORE_INLINE T broadcast(double x) { return T{} + x; }

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

}  // namespace core
