// Linear equations whose matrix has a narrow band.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace inbetween {

/// A square matrix with entries at most `band` off the diagonal. Memory: 3 band + 1 numbers a row, because
/// the exchange of rows widens the band upwards.
class BandMatrix {
 public:
  BandMatrix(std::size_t size, std::size_t band)
      : size_(size), band_(band), entries_(size * (3 * band + 1)), exchanged_(size) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  void add(std::size_t row, std::size_t column, double value) { at(row, column) += value; }

  /// right -= matrix * by. Before factor().
  void subtract_product(const std::vector<double>& by, std::vector<double>& right) const {
    for (std::size_t i = 0; i < size_; ++i) {
      const std::size_t last = std::min(size_ - 1, i + band_);
      for (std::size_t j = i > band_ ? i - band_ : 0; j <= last; ++j) right[i] -= at(i, j) * by[j];
    }
  }
  /// Gaussian elimination with exchange of rows; once, before solve(). A matrix that is singular gives
  /// numbers that are not finite.
  void factor() {
    for (std::size_t k = 0; k < size_; ++k) {
      const std::size_t last_row = std::min(size_ - 1, k + band_);
      const std::size_t last_column = std::min(size_ - 1, k + 2 * band_);
      std::size_t pivot = k;
      for (std::size_t i = k + 1; i <= last_row; ++i) {
        if (std::abs(at(i, k)) > std::abs(at(pivot, k))) pivot = i;
      }
      exchanged_[k] = pivot;
      if (pivot != k) {
        for (std::size_t j = k; j <= last_column; ++j) std::swap(at(k, j), at(pivot, j));
      }
      for (std::size_t i = k + 1; i <= last_row; ++i) {
        const double factor = at(i, k) / at(k, k);
        at(i, k) = factor;
        if (factor == 0) continue;
        for (std::size_t j = k + 1; j <= last_column; ++j) at(i, j) -= factor * at(k, j);
      }
    }
  }
  /// In place.
  void solve(std::vector<double>& right) const {
    for (std::size_t k = 0; k < size_; ++k) {
      std::swap(right[k], right[exchanged_[k]]);
      const std::size_t last_row = std::min(size_ - 1, k + band_);
      for (std::size_t i = k + 1; i <= last_row; ++i) right[i] -= at(i, k) * right[k];
    }
    for (std::size_t k = size_; k-- > 0;) {
      const std::size_t last_column = std::min(size_ - 1, k + 2 * band_);
      for (std::size_t j = k + 1; j <= last_column; ++j) right[k] -= at(k, j) * right[j];
      right[k] /= at(k, k);
    }
  }

 private:
  [[nodiscard]] std::size_t index(std::size_t row, std::size_t column) const {
    return row * (3 * band_ + 1) + column + band_ - row;
  }
  [[nodiscard]] double& at(std::size_t row, std::size_t column) { return entries_[index(row, column)]; }
  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return entries_[index(row, column)]; }

  std::size_t size_;
  std::size_t band_;
  std::vector<double> entries_;
  std::vector<std::size_t> exchanged_;
};

}  // namespace inbetween
