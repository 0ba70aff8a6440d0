// Small systems of linear equations, by elimination with the greatest pivot of each column.
#pragma once
#include <array>
#include <cmath>
#include <utility>

namespace core {

template <std::size_t N>
using SquareMatrix = std::array<std::array<double, N>, N>;

// Solves matrix x = right in place; false where the matrix is singular or not finite.
template <std::size_t N>
bool solve(SquareMatrix<N> &matrix, std::array<double, N> &right) {
  for (std::size_t k = 0; k < N; k++) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < N; i++)
      if (std::fabs(matrix[i][k]) > std::fabs(matrix[pivot][k])) pivot = i;
    if (!(std::fabs(matrix[pivot][k]) > 0.0)) return false;
    if (pivot != k) std::swap(matrix[pivot], matrix[k]), std::swap(right[pivot], right[k]);
    for (std::size_t i = k + 1; i < N; i++) {
      double share = matrix[i][k] / matrix[k][k];
      if (share == 0.0) continue;
      for (std::size_t j = k + 1; j < N; j++) matrix[i][j] -= share * matrix[k][j];
      right[i] -= share * right[k];
    }
  }
  for (std::size_t k = N; k-- > 0;) {
    for (std::size_t j = k + 1; j < N; j++) right[k] -= matrix[k][j] * right[j];
    right[k] /= matrix[k][k];
  }
  return true;
}

}  // namespace core
