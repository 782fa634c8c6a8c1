#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "inbetween/timing/integral_row.hpp"
#include "inbetween/timing/key_timing.hpp"

/// The quadratic program of the locked keys.

namespace inbetween {

/// Newton's method on a piecewise quadratic function ends in as many steps as pieces are met.
inline constexpr int max_iterations = 200;
/// The doublings of a step, far enough for any multiplier that a curve from 0 to 100 can need.
inline constexpr int max_doublings = 40;
/// Every third step halves the interval that is searched.
inline constexpr int max_secants = 60;

/// x nearest to v with rows * x = targets and 0 <= x <= ceiling. Of a periodic curve v_0..v_f-1 are free, and
/// v_f is v_0.
template <Precise Real>
class NearestCurve {
 public:
  NearestCurve(const KeyTimingMemory<Real>& memory, std::int32_t f, CurveEnds ends,
               std::span<const KeyLock> locks, std::int32_t frames)
      : memory_(memory),
        locks_(locks),
        frames_(frames),
        f_(f),
        ends_(ends),
        count_(static_cast<std::size_t>(f) + (ends == CurveEnds::periodic ? 0 : 1)),
        rows_(locks.size() - 1),
        lambda_(memory.multipliers.first(rows_)),
        residual_(memory.multipliers.subspan(rows_, rows_)),
        direction_(memory.multipliers.subspan(2 * rows_, rows_)),
        trial_(memory.multipliers.subspan(3 * rows_, rows_)) {}

  [[nodiscard]] IntegralRow<Real> row(std::size_t r) const {
    return {a(locks_[r]), a(locks_[r + 1]), f_, ends_};
  }
  /// The place of a lock on the curve.
  [[nodiscard]] Real a(const KeyLock& lock) const {
    return lock.knot >= 0 ? static_cast<Real>(lock.knot) : a_of_frame(lock.frame);
  }
  [[nodiscard]] Real a_of_frame(std::int32_t frame) const {
    return static_cast<Real>(frame) * static_cast<Real>(f_) / static_cast<Real>(frames_);
  }

  /// The index of a row that stays unmet, or -1.
  std::int32_t solve() {
    std::ranges::fill(lambda_, Real(0));
    Real total = 0;
    for (std::size_t r = 0; r < rows_; ++r) total += memory_.targets[r];
    const Real tolerance = 64 * std::numeric_limits<Real>::epsilon() * total;
    const Real largest_cost = cost_bound();
    static_cast<void>(evaluate(lambda_));
    for (int i = 0; i < max_iterations && worst_residual() > tolerance; ++i) {
      newton_direction();
      if (!climb(largest_cost)) break;
    }
    return worst_residual() <= tolerance ? -1 : worst_row();
  }

 private:
  /// x(lambda) into `adjusted`, the residual, and the value of the dual function.
  Real evaluate(std::span<const Real> lambda) {
    const std::span<Real> x = memory_.adjusted.first(count_);
    std::ranges::copy(memory_.drawn.first(count_), x.begin());
    for (std::size_t r = 0; r < rows_; ++r) {
      const IntegralRow<Real> weights = row(r);
      for (std::int32_t i = weights.first(); i <= weights.last(); ++i) {
        const std::size_t index = weights.index(i);
        x[index] += lambda[r] * memory_.mobility[index] * weights.weight(i);
      }
    }
    Real dual = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = std::clamp(x[i], Real(0), memory_.ceiling[i]);
      const Real change = x[i] - memory_.drawn[i];
      if (memory_.mobility[i] > 0) dual += change * change / (2 * memory_.mobility[i]);
    }
    if (ends_ == CurveEnds::periodic) memory_.adjusted[count_] = x.front();
    for (std::size_t r = 0; r < rows_; ++r) {
      residual_[r] = row(r).integral(x) - memory_.targets[r];
      dual -= lambda[r] * residual_[r];
    }
    return dual;
  }
  /// No curve changes the drawn one by more than this, which is why no dual value is larger if there is a
  /// curve (weak duality).
  [[nodiscard]] Real cost_bound() const {
    Real bound = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (!(memory_.mobility[i] > 0)) continue;
      const Real change = std::max(memory_.drawn[i], memory_.ceiling[i] - memory_.drawn[i]);
      bound += change * change / (2 * memory_.mobility[i]);
    }
    return bound * (1 + 16 * std::numeric_limits<Real>::epsilon()) + std::numeric_limits<Real>::min();
  }

  /// How fast the dual rises along the direction, at the multipliers evaluated last.
  [[nodiscard]] Real slope() const {
    Real sum = 0;
    for (std::size_t r = 0; r < rows_; ++r) sum -= residual_[r] * direction_[r];
    return sum;
  }
  Real evaluate_at(Real step) {
    for (std::size_t r = 0; r < rows_; ++r) trial_[r] = lambda_[r] + step * direction_[r];
    return evaluate(trial_);
  }

  /// Goes on along the direction until the dual rises no more; its slope falls there, piece by piece linear.
  /// Where few values are free a Newton step is far from there, which is why the zero of the slope is
  /// searched for. False if there is no curve.
  bool climb(Real largest_cost) {
    const Real unmet = worst_residual();
    const Real first_slope = slope();
    if (!(first_slope > 0)) return false;  // rounding: nothing is gained any more
    Real low = 0;
    Real low_slope = first_slope;
    Real high = 1;
    if (evaluate_at(high) > largest_cost) return false;
    Real high_slope = slope();
    for (int i = 0; i < max_doublings && high_slope > first_slope / 2; ++i) {
      low = high;
      low_slope = high_slope;
      high *= 4;
      if (evaluate_at(high) > largest_cost) return false;
      high_slope = slope();
    }
    Real step = high;
    Real step_slope = high_slope;
    for (int i = 0; i < max_secants; ++i) {
      if (std::fabs(step_slope) <= first_slope / 16 || worst_residual() <= unmet / 16) break;
      const Real secant = low + (high - low) * (low_slope / (low_slope - high_slope));
      const Real middle = low + (high - low) / 2;
      step = i % 3 == 2 || !(secant > low && secant < high) ? middle : secant;
      static_cast<void>(evaluate_at(step));
      step_slope = slope();
      (step_slope > 0 ? low : high) = step;
      (step_slope > 0 ? low_slope : high_slope) = step_slope;
    }
    std::ranges::copy(trial_, lambda_.begin());
    return true;
  }

  [[nodiscard]] Real worst_residual() const {
    Real worst = 0;
    for (const Real r : residual_) {
      if (!(std::fabs(r) <= worst)) worst = std::fabs(r);
    }
    return worst;
  }
  [[nodiscard]] std::int32_t worst_row() const {
    const auto worst =
        std::ranges::max_element(residual_, {}, [](Real residual) { return std::fabs(residual); });
    return static_cast<std::int32_t>(worst - residual_.begin());
  }

  /// The first row that shares a control value with row r. Rows are in the order of time, so the matrix is a
  /// band; the last rows of a periodic curve also meet its first ones.
  [[nodiscard]] std::size_t first_beside(std::size_t r) const {
    const IntegralRow<Real> here = row(r);
    if (here.wraps()) return 0;
    std::size_t first = r;
    while (first > 0 && row(first - 1).last() >= here.first()) --first;
    return first;
  }
  /// The sum over the free values of what two rows have in common.
  [[nodiscard]] Real product(const IntegralRow<Real>& one, const IntegralRow<Real>& other) const {
    Real sum = 0;
    for (std::int32_t i = one.first(); i <= one.last(); ++i) {
      const std::size_t index = one.index(i);
      const Real x = memory_.adjusted[index];
      const bool is_free = x > 0 && x < memory_.ceiling[index];
      if (is_free) sum += memory_.mobility[index] * one.weight(i) * other.weight(i);
    }
    return sum;
  }

  /// Solves (A_free A_free^T) direction = -residual by Cholesky's method. No entry of the factor lies before
  /// the first of its row in the matrix (George and Liu 1981, Computer Solution of Large Sparse Positive
  /// Definite Systems, ch. 4), so that the work is linear in the number of locks.
  void newton_direction() {
    const std::size_t n = rows_;
    const std::span<Real> m = memory_.matrix.first(n * n);
    for (std::size_t r = 0; r < n; ++r) {
      const IntegralRow<Real> here = row(r);
      const std::size_t first = first_beside(r);
      std::fill_n(m.begin() + static_cast<std::ptrdiff_t>(r * n), r, Real(0));
      for (std::size_t c = first; c <= r; ++c) m[r * n + c] = product(here, row(c));
      // Where too few values are free the matrix is singular; the shift keeps the direction an ascent.
      m[r * n + r] += Real(1e-12) + 16 * std::numeric_limits<Real>::epsilon() * m[r * n + r];
      direction_[r] = -residual_[r];
      for (std::size_t c = first; c <= r; ++c) {
        Real sum = m[r * n + c];
        for (std::size_t k = first; k < c; ++k) sum -= m[r * n + k] * m[c * n + k];
        m[r * n + c] = r == c ? std::sqrt(std::max(sum, Real(1e-14))) : sum / m[c * n + c];
      }
      for (std::size_t k = first; k < r; ++k) direction_[r] -= m[r * n + k] * direction_[k];
      direction_[r] /= m[r * n + r];
    }
    for (std::size_t r = n; r-- > 0;) {
      direction_[r] /= m[r * n + r];
      for (std::size_t k = first_beside(r); k < r; ++k) direction_[k] -= m[r * n + k] * direction_[r];
    }
  }

  KeyTimingMemory<Real> memory_;
  std::span<const KeyLock> locks_;
  std::int32_t frames_;
  std::int32_t f_;
  CurveEnds ends_;
  std::size_t count_;
  std::size_t rows_;
  std::span<Real> lambda_, residual_, direction_, trial_;
};

}  // namespace inbetween
