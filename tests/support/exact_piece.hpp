// The polynomials of a trajectory, evaluated by definition in extended precision.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "inbetween/trajectory/trajectory.hpp"

namespace inbetween {

/// Position less that of the begin, velocity, acceleration and jerk of an axis on a piece, at u: the
/// coefficients of the polynomial come from the equations that the rows are, by elimination in long double.
inline std::array<long double, 4> exact_piece(const Trajectory& trajectory, const TrajectoryPiece& piece,
                                              std::size_t axis, long double u) {
  const std::size_t n = piece.degree + 1U;
  const bool is_by_velocity = piece.degree == 6;  // it does not have the position of its end
  const std::size_t known = piece.degree / 2U + 1;
  const std::size_t axes = trajectory.axis_count();
  const long double h = piece.seconds;
  std::vector<std::vector<long double>> rows;
  const auto falling = [](std::size_t i, std::size_t k) {  // i (i - 1) ... (i - k + 1)
    long double product = 1;
    for (std::size_t m = 0; m < k; ++m) product *= i >= m ? static_cast<long double>(i - m) : 0;
    return product;
  };
  for (const bool is_end : {false, true}) {
    const std::size_t offset = is_end ? piece.end_row : piece.begin_row;
    long double scale = 1;
    for (std::size_t k = 0; k < known; ++k, scale *= h) {
      if (is_by_velocity && is_end && k == 0) continue;
      std::vector<long double> row(n + 1);
      for (std::size_t i = k; i < n; ++i) row[i] = is_end || i == k ? falling(i, k) : 0;
      row[n] = scale * trajectory.values()[offset + k * axes + axis];
      if (k == 0) row[n] -= trajectory.values()[piece.begin_row + axis];
      rows.push_back(row);
    }
  }
  for (std::size_t i = 0; i < n; ++i) {  // Gauss and Jordan, the largest pivot first
    std::size_t best = i;
    for (std::size_t r = i; r < n; ++r) {
      if (std::fabs(rows[r][i]) > std::fabs(rows[best][i])) best = r;
    }
    std::swap(rows[i], rows[best]);
    for (std::size_t r = 0; r < n; ++r) {
      if (r == i) continue;
      const long double factor = rows[r][i] / rows[i][i];
      for (std::size_t c = i; c <= n; ++c) rows[r][c] -= factor * rows[i][c];
    }
  }
  std::array<long double, 4> motion{};
  long double scale = 1;
  for (std::size_t k = 0; k < motion.size(); ++k, scale /= h) {
    for (std::size_t i = k; i < n; ++i)
      motion[k] +=
          scale * falling(i, k) * rows[i][n] / rows[i][i] * std::pow(u, static_cast<long double>(i - k));
  }
  return motion;
}

}  // namespace inbetween
