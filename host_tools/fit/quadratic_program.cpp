#include "host_tools/fit/quadratic_program.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace inbetween {
namespace {

/// A row depends on the conditions in force if the part that they leave free is below this share of it.
constexpr double dependent_share = 1e-11;
/// An equation that depends on the others may differ from them by this share of its bound, or of 1.
constexpr double equation_rounding = 1e-9;

/// L with L L^T = matrix, row after row.
std::vector<double> cholesky(std::span<const double> matrix, std::size_t n) {
  std::vector<double> l(matrix.begin(), matrix.end());
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k <= i; ++k) {
      double sum = l[i * n + k];
      for (std::size_t m = 0; m < k; ++m) sum -= l[i * n + m] * l[k * n + m];
      if (i == k && !(sum > 0)) throw std::invalid_argument("the matrix is not positive definite");
      l[i * n + k] = i == k ? std::sqrt(sum) : sum / l[k * n + k];
    }
  }
  return l;
}

/// Four sums side by side, because each waits for its last addition.
double dot(std::span<const double> a, std::span<const double> b) {
  std::array<double, 4> sums{};
  std::size_t i = 0;
  for (; i + 4 <= a.size(); i += 4) {
    for (std::size_t k = 0; k < 4; ++k) sums[k] += a[i + k] * b[i + k];
  }
  for (; i < a.size(); ++i) sums[0] += a[i] * b[i];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

}  // namespace

QuadraticProgram::QuadraticProgram(std::span<const double> gram, std::span<const double> target)
    : n_(target.size()),
      x_(target.begin(), target.end()),
      j_(n_ * n_),
      r_(n_ * n_),
      d_(n_),
      z_(n_),
      dual_(n_) {
  const std::vector<double> l = cholesky(gram, n_);
  // Column c of L^-T is row c of L^-1.
  for (std::size_t c = 0; c < n_; ++c) {
    for (std::size_t i = 0; i <= c; ++i) {
      double sum = i == c ? 1 : 0;
      for (std::size_t m = i; m < c; ++m) sum -= l[c * n_ + m] * j(m, i);
      j(c, i) = sum / l[c * n_ + c];
    }
  }
}

void QuadraticProgram::find_directions(std::span<const double> row) {
  // A row of a local condition is mostly zeros: only its part from `begin` to `end` is multiplied.
  const std::size_t q = in_force_.size();
  std::size_t begin = 0;  // most rows speak of few values
  std::size_t end = n_;
  while (begin < end && row[begin] == 0) ++begin;
  while (end > begin && row[end - 1] == 0) --end;
  const std::span<const double> part = row.subspan(begin, end - begin);
  std::ranges::fill(z_, 0.0);
  for (std::size_t c = 0; c < n_; ++c) {
    const std::span<const double> column = std::span(j_).subspan(c * n_, n_);
    d_[c] = dot(part, column.subspan(begin, part.size()));
    if (c < q) continue;
    for (std::size_t i = 0; i < n_; ++i) z_[i] += d_[c] * column[i];
  }
  for (std::size_t i = q; i-- > 0;) {
    double sum = d_[i];
    for (std::size_t k = i + 1; k < q; ++k) sum -= r(i, k) * dual_[k];
    dual_[i] = sum / r(i, i);
  }
}

/// The condition whose multiplier reaches 0 first, and lowers `step` to that. The count of those in force
/// where none does.
std::size_t QuadraticProgram::first_to_leave(double& step) const {
  std::size_t leaving = in_force_.size();
  for (std::size_t k = 0; k < in_force_.size(); ++k) {
    if (in_force_[k].is_equality || !(dual_[k] > 0)) continue;
    const double until = in_force_[k].multiplier / dual_[k];
    if (until < step) {
      step = until;
      leaving = k;
    }
  }
  return leaving;
}

void QuadraticProgram::rotate_columns(std::size_t left, double cosine, double sine) {
  double* a = &j_[left * n_];
  double* b = &j_[(left + 1) * n_];
  for (std::size_t i = 0; i < n_; ++i) {
    const double before = a[i];
    a[i] = cosine * before + sine * b[i];
    b[i] = cosine * b[i] - sine * before;
  }
}

/// Puts the condition of the directions found last behind those in force.
void QuadraticProgram::enter(bool is_equality, double multiplier) {
  const std::size_t q = in_force_.size();
  for (std::size_t c = n_ - 1; c > q; --c) {
    if (d_[c] == 0) continue;
    const double length = std::hypot(d_[c - 1], d_[c]);
    rotate_columns(c - 1, d_[c - 1] / length, d_[c] / length);
    d_[c - 1] = length;
    d_[c] = 0;
  }
  for (std::size_t i = 0; i <= q; ++i) r(i, q) = d_[i];
  in_force_.push_back({multiplier, is_equality});
}

void QuadraticProgram::leave(std::size_t index) {
  const std::size_t q = in_force_.size() - 1;
  for (std::size_t c = index; c < q; ++c) {
    for (std::size_t i = 0; i <= c + 1; ++i) r(i, c) = r(i, c + 1);
    const double length = std::hypot(r(c, c), r(c + 1, c));
    const double cosine = r(c, c) / length;
    const double sine = r(c + 1, c) / length;
    r(c, c) = length;
    r(c + 1, c) = 0;
    for (std::size_t k = c + 1; k < q; ++k) {
      const double above = r(c, k + 1);
      const double below = r(c + 1, k + 1);
      r(c, k + 1) = cosine * above + sine * below;
      r(c + 1, k + 1) = cosine * below - sine * above;
    }
    rotate_columns(c, cosine, sine);
  }
  in_force_.erase(in_force_.begin() + static_cast<std::ptrdiff_t>(index));
}

bool QuadraticProgram::add_equality(std::span<const double> row, double bound) {
  find_directions(row);
  double all = 0;
  double free = 0;
  const double residual = bound - dot(row, x_);
  for (std::size_t i = 0; i < n_; ++i) {
    all += d_[i] * d_[i];
    if (i >= in_force_.size()) free += d_[i] * d_[i];
  }
  // The equation follows from the earlier ones. It holds already, or it contradicts them.
  if (free <= dependent_share * dependent_share * all) {
    return std::fabs(residual) <= equation_rounding * (1 + std::fabs(bound));
  }
  const double step = residual / free;
  for (std::size_t i = 0; i < n_; ++i) x_[i] += step * z_[i];
  for (std::size_t k = 0; k < in_force_.size(); ++k) in_force_[k].multiplier -= step * dual_[k];
  enter(true, step);
  return true;
}

bool QuadraticProgram::add(std::span<const double> row, double bound) {
  double multiplier = 0;
  for (;;) {
    const double residual = bound - dot(row, x_);
    if (residual <= 0) return true;
    find_directions(row);
    double all = 0;
    double free = 0;
    for (std::size_t i = 0; i < n_; ++i) {
      all += d_[i] * d_[i];
      if (i >= in_force_.size()) free += d_[i] * d_[i];
    }
    const bool is_dependent = free <= dependent_share * dependent_share * all;
    // A dependent row leaves x where it is: only the multipliers move, until a condition leaves.
    const double full = is_dependent ? std::numeric_limits<double>::infinity() : residual / free;
    double step = full;
    const std::size_t leaving = first_to_leave(step);
    if (!std::isfinite(step)) return false;
    if (!is_dependent) {
      for (std::size_t i = 0; i < n_; ++i) x_[i] += step * z_[i];
    }
    multiplier += step;
    for (std::size_t k = 0; k < in_force_.size(); ++k) in_force_[k].multiplier -= step * dual_[k];
    if (leaving == in_force_.size()) {
      enter(false, multiplier);
      return true;
    }
    leave(leaving);
  }
}

}  // namespace inbetween
