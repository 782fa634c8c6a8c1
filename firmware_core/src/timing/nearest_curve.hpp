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
class NearestCurve {
 public:
  NearestCurve(const KeyTimingMemory& memory, std::int32_t f, CurveEnds ends, std::span<const KeyLock> locks,
               std::int32_t frames)
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

  [[nodiscard]] IntegralRow row(std::size_t r) const { return {a(locks_[r]), a(locks_[r + 1]), f_, ends_}; }
  /// The place of a lock on the curve.
  [[nodiscard]] double a(const KeyLock& lock) const {
    return lock.knot >= 0 ? static_cast<double>(lock.knot) : a_of_frame(lock.frame);
  }
  [[nodiscard]] double a_of_frame(std::int32_t frame) const {
    return static_cast<double>(frame) * static_cast<double>(f_) / static_cast<double>(frames_);
  }

  /// The index of a row that stays unmet, or -1.
  std::int32_t solve() {
    std::ranges::fill(lambda_, 0.0);
    double total = 0;
    for (std::size_t r = 0; r < rows_; ++r) total += memory_.targets[r];
    const double tolerance = 64 * std::numeric_limits<double>::epsilon() * total;
    const double largest_cost = cost_bound();
    if (is_met_as_drawn(tolerance)) return -1;
    if (const std::int32_t without_room = list_rows(); without_room >= 0) return without_room;
    if (const std::int32_t too_far = row_beyond_all_curves(tolerance); too_far >= 0) return too_far;
    static_cast<void>(evaluate(lambda_));
    for (int i = 0; i < max_iterations && worst_residual() > tolerance; ++i) {
      newton_direction();
      if (!climb(largest_cost)) break;
    }
    return worst_residual() <= tolerance ? -1 : worst_row();
  }

 private:
  /// Whether the drawn curve is the answer already; it is then in `adjusted`.
  bool is_met_as_drawn(double tolerance) {
    const std::span<double> x = memory_.adjusted.first(count_);
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = std::clamp(memory_.drawn[i], 0.0, memory_.ceiling[i]);
    }
    if (ends_ == CurveEnds::periodic) memory_.adjusted[count_] = x.front();
    for (std::size_t r = 0; r < rows_; ++r) {
      if (!(std::fabs(row(r).integral(x) - memory_.targets[r]) <= tolerance)) return false;
    }
    return true;
  }

  /// x(lambda) into `adjusted`, the residual, and the value of the dual function.
  double evaluate(std::span<const double> lambda) {
    const std::span<double> x = memory_.adjusted.first(count_);
    std::ranges::copy(memory_.drawn.first(count_), x.begin());
    for (std::size_t r = 0; r < rows_; ++r) {
      for_each_value(r,
                     [&](std::size_t i, double weight) { x[i] += lambda[r] * memory_.mobility[i] * weight; });
    }
    double dual = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = std::clamp(x[i], 0.0, memory_.ceiling[i]);
      const double change = x[i] - memory_.drawn[i];
      if (memory_.mobility[i] > 0) dual += change * change / (2 * memory_.mobility[i]);
    }
    if (ends_ == CurveEnds::periodic) memory_.adjusted[count_] = x.front();
    for (std::size_t r = 0; r < rows_; ++r) {
      double integral = 0;
      for_each_value(r, [&](std::size_t i, double weight) { integral += weight * x[i]; });
      residual_[r] = integral - memory_.targets[r];
      dual -= lambda[r] * residual_[r];
    }
    return dual;
  }
  /// No curve changes the drawn one by more than this, which is why no dual value is larger if there is a
  /// curve (weak duality).
  [[nodiscard]] double cost_bound() const {
    double bound = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (!(memory_.mobility[i] > 0)) continue;
      const double change = std::max(memory_.drawn[i], memory_.ceiling[i] - memory_.drawn[i]);
      bound += change * change / (2 * memory_.mobility[i]);
    }
    return bound * (1 + 16 * std::numeric_limits<double>::epsilon()) + std::numeric_limits<double>::min();
  }

  /// How fast the dual rises along the direction, at the multipliers evaluated last.
  [[nodiscard]] double slope() const {
    double sum = 0;
    for (std::size_t r = 0; r < rows_; ++r) sum -= residual_[r] * direction_[r];
    return sum;
  }
  double evaluate_at(double step) {
    for (std::size_t r = 0; r < rows_; ++r) trial_[r] = lambda_[r] + step * direction_[r];
    return evaluate(trial_);
  }

  /// Goes on along the direction until the dual rises no more; its slope falls there, piece by piece linear.
  /// Where few values are free a Newton step is far from there, which is why the zero of the slope is
  /// searched for. False if there is no curve.
  bool climb(double largest_cost) {
    const double unmet = worst_residual();
    const double first_slope = slope();
    if (!(first_slope > 0)) return false;  // rounding: nothing is gained any more
    double low = 0;
    double low_slope = first_slope;
    double high = 1;
    if (evaluate_at(high) > largest_cost) return false;
    double high_slope = slope();
    for (int i = 0; i < max_doublings && high_slope > first_slope / 2; ++i) {
      low = high;
      low_slope = high_slope;
      high *= 4;
      if (evaluate_at(high) > largest_cost) return false;
      high_slope = slope();
    }
    double step_slope = high_slope;
    for (int i = 0; i < max_secants; ++i) {
      if (std::fabs(step_slope) <= first_slope / 16 || worst_residual() <= unmet / 16) break;
      const double secant = low + (high - low) * (low_slope / (low_slope - high_slope));
      const double middle = low + (high - low) / 2;
      const double step = i % 3 == 2 || !(secant > low && secant < high) ? middle : secant;
      static_cast<void>(evaluate_at(step));
      step_slope = slope();
      (step_slope > 0 ? low : high) = step;
      (step_slope > 0 ? low_slope : high_slope) = step_slope;
    }
    std::ranges::copy(trial_, lambda_.begin());
    return true;
  }

  [[nodiscard]] double worst_residual() const {
    double worst = 0;
    for (const double r : residual_) {
      if (!(std::fabs(r) <= worst)) worst = std::fabs(r);
    }
    return worst;
  }
  [[nodiscard]] std::int32_t worst_row() const {
    const auto worst =
        std::ranges::max_element(residual_, {}, [](double residual) { return std::fabs(residual); });
    return static_cast<std::int32_t>(worst - residual_.begin());
  }

  /// The weights of every row, and which rows share control values: rows are in the order of time, so the
  /// matrix is a band; the last rows of a periodic curve also meet its first ones. Returns a row that follows
  /// from those before it, for which there is no room, or -1.
  std::int32_t list_rows() {
    std::size_t weights = 0;
    std::size_t entries = 0;
    for (std::size_t r = 0; r < rows_; ++r) {
      const IntegralRow integral = row(r);
      LockRow& here = memory_.rows[r];
      here = {.first = integral.first(),
              .count = std::max<std::int32_t>(integral.last() - integral.first() + 1, 0),
              .weights = static_cast<std::int32_t>(weights),
              .entries = static_cast<std::int32_t>(entries)};
      here.beside = static_cast<std::int32_t>(integral.wraps() ? 0 : first_beside(r));
      // Nothing moves where nothing is covered (stop_between_equal_keys).
      if (!(memory_.targets[r] > 0)) here.beside = static_cast<std::int32_t>(r);
      weights += static_cast<std::size_t>(here.count);
      entries += r - static_cast<std::size_t>(here.beside) + 1;
      if (weights > memory_.weights.size() || entries > memory_.matrix.size()) {
        return static_cast<std::int32_t>(r);
      }
      for (std::int32_t k = 0; k < here.count; ++k) {
        const std::int32_t at = here.weights + k;
        memory_.weights[static_cast<std::size_t>(at)] = integral.weight(here.first + k);
      }
    }
    return -1;
  }
  /// A row that not even the largest values meet, or -1: a proof that costs nothing.
  [[nodiscard]] std::int32_t row_beyond_all_curves(double tolerance) const {
    for (std::size_t r = 0; r < rows_; ++r) {
      double most = 0;
      for_each_value(r, [&](std::size_t i, double weight) {
        const double largest = memory_.mobility[i] > 0 ? memory_.ceiling[i] : memory_.drawn[i];
        most += std::max(weight, 0.0) * largest;
      });
      if (most < memory_.targets[r] - tolerance) return static_cast<std::int32_t>(r);
    }
    return -1;
  }

  [[nodiscard]] std::size_t first_beside(std::size_t r) const {
    const auto end = [&](std::size_t other) { return memory_.rows[other].first + memory_.rows[other].count; };
    std::size_t first = r;
    while (first > 0 && end(first - 1) > memory_.rows[r].first) --first;
    return first;
  }

  /// visit(index, weight) for every control value of a row.
  template <class Visit>
  void for_each_value(std::size_t r, const Visit& visit) const {
    const LockRow& here = memory_.rows[r];
    for (std::int32_t k = 0; k < here.count; ++k) {
      const std::int32_t at = here.weights + k;
      visit(index(here.first + k), memory_.weights[static_cast<std::size_t>(at)]);
    }
  }
  [[nodiscard]] std::size_t index(std::int32_t i) const {
    return static_cast<std::size_t>(ends_ == CurveEnds::periodic ? (i + 2 * f_) % f_ : i);
  }
  /// The weight of a control value in a row, 0 where it is not in it.
  [[nodiscard]] double weight(const LockRow& row, std::int32_t i) const {
    std::int32_t k = i - row.first;
    if (ends_ == CurveEnds::periodic) k = (k % f_ + f_) % f_;
    const std::int32_t at = row.weights + k;
    return k >= 0 && k < row.count ? memory_.weights[static_cast<std::size_t>(at)] : 0.0;
  }

  /// The sum over the free values of what two rows have in common, of which `other` is not behind.
  [[nodiscard]] double product(const LockRow& one, const LockRow& other) const {
    const bool shares_end = ends_ == CurveEnds::periodic || &one == &other;
    const std::int32_t end = one.first + one.count;
    const std::int32_t last = shares_end ? end : std::min(end, other.first + other.count);
    double sum = 0;
    for (std::int32_t i = one.first; i < last; ++i) {
      const std::size_t here = index(i);
      const double x = memory_.adjusted[here];
      const bool is_free = x > 0 && x < memory_.ceiling[here];
      if (is_free) sum += memory_.mobility[here] * weight(one, i) * weight(other, i);
    }
    return sum;
  }

  /// Solves (A_free A_free^T) direction = -residual by Cholesky's method. No entry of the factor lies before
  /// the first of its row in the matrix, and no other has a place in memory (George and Liu 1981, Computer
  /// Solution of Large Sparse Positive Definite Systems, ch. 4): the work is linear in the number of locks.
  void newton_direction() {
    const std::size_t n = rows_;
    const auto beside = [&](std::size_t r) { return static_cast<std::size_t>(memory_.rows[r].beside); };
    const auto entry = [&](std::size_t r, std::size_t c) -> double& {
      return memory_.matrix[static_cast<std::size_t>(memory_.rows[r].entries) + c - beside(r)];
    };
    for (std::size_t r = 0; r < n; ++r) {
      const std::size_t first = beside(r);
      for (std::size_t c = first; c <= r; ++c) entry(r, c) = product(memory_.rows[r], memory_.rows[c]);
      // Where too few values are free the matrix is singular; the shift keeps the direction an ascent.
      entry(r, r) += 1e-12 + 16 * std::numeric_limits<double>::epsilon() * entry(r, r);
      direction_[r] = -residual_[r];
      for (std::size_t c = first; c <= r; ++c) {
        double sum = entry(r, c);
        for (std::size_t k = std::max(first, beside(c)); k < c; ++k) sum -= entry(r, k) * entry(c, k);
        entry(r, c) = r == c ? std::sqrt(std::max(sum, 1e-14)) : sum / entry(c, c);
      }
      for (std::size_t k = first; k < r; ++k) direction_[r] -= entry(r, k) * direction_[k];
      direction_[r] /= entry(r, r);
    }
    for (std::size_t r = n; r-- > 0;) {
      direction_[r] /= entry(r, r);
      for (std::size_t k = beside(r); k < r; ++k) direction_[k] -= entry(r, k) * direction_[r];
    }
  }

  const KeyTimingMemory& memory_;
  std::span<const KeyLock> locks_;
  std::int32_t frames_;
  std::int32_t f_;
  CurveEnds ends_;
  std::size_t count_;
  std::size_t rows_;
  std::span<double> lambda_, residual_, direction_, trial_;
};

}  // namespace inbetween
