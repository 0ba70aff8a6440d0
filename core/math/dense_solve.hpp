// Small systems of linear equations, by elimination with the greatest pivot of each column.
#pragma once
#include <array>
#include <cmath>
#include <utility>
#include "dual.hpp"

namespace core {

template <std::size_t N>
using SquareMatrix = std::array<std::array<double, N>, N>;

// Puts the triangular factors of a matrix of this size in its place; `at(i, j)` is an entry, `pivot` (size,) the row that each
// row changed places with. False where the matrix is singular or not finite.
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
    double over = 1.0 / at(k, k);
    for (int i = k + 1; i < size; i++) {
      if (at(i, k) == 0.0) continue;
      double share = at(i, k) *= over;
      for (int j = k + 1; j < size; j++) at(i, j) -= share * at(k, j);
    }
  }
  return regular;
}

// Solves for a right-hand side, in place, by the factors of `factorise_dense`.
template <class Entry, class Right>
inline void substitute_dense(int size, Entry at, const int *pivot, Right &&right) {
  for (int k = 0; k < size; k++)
    if (pivot[k] != k) std::swap(right[k], right[pivot[k]]);
  for (int k = 0; k < size; k++)
    for (int j = 0; j < k; j++) right[k] -= at(k, j) * right[j];
  for (int k = size; k-- > 0;) {
    for (int j = k + 1; j < size; j++) right[k] -= at(k, j) * right[j];
    right[k] /= at(k, k);
  }
}

// Solves matrix x = right in place; false where the matrix is singular or not finite.
template <std::size_t N>
bool solve(SquareMatrix<N> &matrix, std::array<double, N> &right) {
  auto at = [&](int i, int j) -> double & { return matrix[i][j]; };
  int pivot[N];
  if (!factorise_dense(int(N), at, pivot)) return false;
  substitute_dense(int(N), at, pivot, right);
  return true;
}

// Inverts the first N rows and columns in lanes, in place, by Gauss and Jordan; without pivots, for heavy diagonals.
template <int N, int M>
[[gnu::noinline]] inline void invert_in_lanes(Pack (&a)[M][M]) {
#pragma GCC unroll 8
  for (int k = 0; k < N; k++) {
    Pack over = 1.0 / a[k][k];
    a[k][k] = broadcast<Pack>(1.0);
#pragma GCC unroll 8
    for (int j = 0; j < N; j++) a[k][j] *= over;
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
