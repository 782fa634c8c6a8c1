#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/quintic.hpp"
#include "inbetween/base/bisection.hpp"
#include "inbetween/base/fixed_vector.hpp"
#include "inbetween/base/precision.hpp"

/// Finds where the motion of a tick crosses the half steps.

namespace inbetween {

/// A position in steps: nearest is floor(x + 1/2), rest is x - nearest, -1/2 <= rest < 1/2 before rounding.
struct StepPosition {
  std::int64_t nearest = 0;
  double rest = 0;
};

/// The nearest step of the exact product; |position * steps_per_unit| < 2^62.
inline StepPosition step_position(double position, double steps_per_unit) {
  const TwoSum steps = two_product(position, steps_per_unit);
  double nearest = std::floor(steps.high);
  const double above = steps.high - nearest;
  const double half = 0.5;
  if (above > half || (above == half && steps.low >= 0)) nearest += 1;
  return {static_cast<std::int64_t>(nearest), (steps.high - nearest) + steps.low};
}

/// A place, speed and acceleration in steps and ticks.
struct StepMotion {
  double x = 0, v = 0, a = 0;
};

/// The quintic over one tick, u from 0 to 1, x in steps from the nearest step at its start.
class StepCrossings {
 public:
  /// `end.x` is from the nearest step at the start, too.
  StepCrossings(const StepMotion& start, const StepMotion& end, std::int32_t end_count);

  /// How many, or -1 if more than fit in 2^24.
  [[nodiscard]] std::int32_t count() const { return count_; }

  /// Calls visit(u, up) for each, in the order of time. `tolerance` of u.
  template <class Visitor>
  void visit(double tolerance, Visitor&& visitor) const {
    double u = 0;
    std::int32_t count = 0;
    for (const Piece& piece : pieces_) {
      const bool up = piece.end_count > count;
      while (count != piece.end_count) {
        const double level = static_cast<double>(up ? count : count - 1) + 0.5;
        u = crossing(level, up, {u, piece.end}, tolerance);
        visitor(u, up);
        count += up ? 1 : -1;
      }
      u = piece.end;
    }
  }

 private:
  static constexpr std::size_t degree = 5;
  using Polynomial = Quintic;
  /// A piece on which the motion does not turn: from the end of the piece before, or 0, to `end`.
  struct Piece {
    double end = 0;
    std::int32_t end_count = 0;
  };

  static double slope(const Polynomial& p, double u) {
    return (((5 * p[5] * u + 4 * p[4]) * u + 3 * p[3]) * u + 2 * p[2]) * u + p[1];
  }
  static Polynomial derivative(const Polynomial& p) {
    return {p[1], 2 * p[2], 3 * p[3], 4 * p[4], 5 * p[5], 0};
  }

  /// Finds where p - level becomes positive, or negative if not `up`, by Newton's method inside a bracket in
  /// which p is monotone. A step that leaves the bracket or does not halve the last but one is a bisection,
  /// so 2 log2(1 / tolerance) turns suffice. If rounding has moved the zero out of the bracket, the result is
  /// the nearer end of the bracket.
  static double zero(const Polynomial& p, double level, bool up, Bracket bracket, double tolerance,
                     double first) {
    double u = first;
    double last_step = bracket.high - bracket.low;
    double step_before = last_step;
    for (int turn = 0; turn < 2 * std::numeric_limits<double>::digits; ++turn) {
      const double over = value_at(p, u) - level;
      if (over == 0) return u;
      ((over > 0) == up ? bracket.high : bracket.low) = u;
      const double tangent = slope(p, u);
      double next = tangent != 0 ? u - over / tangent : bracket.low;
      const bool leaves = !(next > bracket.low && next < bracket.high);
      if (leaves || 2 * std::fabs(next - u) > step_before)
        next = bracket.low + (bracket.high - bracket.low) / 2;
      step_before = last_step;
      last_step = std::fabs(next - u);
      u = next;
      if (last_step <= tolerance || bracket.high - bracket.low <= tolerance) break;
    }
    return u;
  }
  [[nodiscard]] double crossing(double level, bool up, const Bracket& bracket, double tolerance) const {
    const auto is_past = [&](double u) { return up ? value_at(x_, u) >= level : value_at(x_, u) <= level; };
    if (!is_past(bracket.high)) return bracket.high;
    if (is_past(bracket.low)) return bracket.low;
    const double tangent = slope(x_, bracket.low);
    double first = tangent != 0 ? bracket.low + (level - value_at(x_, bracket.low)) / tangent : bracket.low;
    if (!(first > bracket.low && first < bracket.high))
      first = bracket.low + (bracket.high - bracket.low) / 2;
    return zero(x_, level, up, bracket, tolerance, first);
  }

  /// The zeros of p in (0, 1), from those of its derivative, between which it is monotone.
  using Zeros = FixedVector<double, degree>;
  static Zeros zeros_between(const Polynomial& p, const Zeros& turns) {
    Zeros zeros;
    Bracket bracket{0, 0};
    for (std::size_t i = 0; i <= turns.size(); ++i) {
      bracket = {bracket.high, i < turns.size() ? turns[i] : 1.0};
      const bool from_below = value_at(p, bracket.low) < 0;
      if (from_below == (value_at(p, bracket.high) < 0)) continue;
      const double middle = bracket.low + (bracket.high - bracket.low) / 2;
      static_cast<void>(zeros.push_back(
          zero(p, 0, from_below, bracket, 2 * std::numeric_limits<double>::epsilon(), middle)));
    }
    return zeros;
  }
  /// Finds where the motion turns: the zeros of the derivatives, from the fourth down to the first.
  [[nodiscard]] Zeros turns() const {
    std::array<Polynomial, degree - 1> derivatives;
    derivatives[0] = derivative(x_);
    for (std::size_t i = 1; i < derivatives.size(); ++i) derivatives[i] = derivative(derivatives[i - 1]);
    Zeros zeros;
    for (std::size_t i = derivatives.size(); i-- > 0;) zeros = zeros_between(derivatives[i], zeros);
    return zeros;
  }

  void add_piece(double end, std::int32_t end_count) {
    const std::int32_t last = pieces_.empty() ? 0 : pieces_[pieces_.size() - 1].end_count;
    count_ += end_count > last ? end_count - last : last - end_count;
    static_cast<void>(pieces_.push_back({end, end_count}));
  }

  Polynomial x_{};
  FixedVector<Piece, degree> pieces_;
  std::int32_t count_ = 0;
};

inline StepCrossings::StepCrossings(const StepMotion& start, const StepMotion& end, std::int32_t end_count) {
  const double distance = end.x - start.x;
  // The speed lies between the lowest and the highest of its Bernstein coefficients. Their mean is the
  // distance.
  const std::array<double, 4> outer{start.v, start.v + start.a / 4, end.v - end.a / 4, end.v};
  const double middle = 5 * distance - ((outer[0] + outer[1]) + (outer[2] + outer[3]));
  const auto [lowest, highest] = std::minmax_element(outer.begin(), outer.end());
  const double low = std::min(*lowest, middle);
  const double high = std::max(*highest, middle);
  const double max_speed = 1 << 24;
  if (!(low > -max_speed && high < max_speed)) {
    count_ = -1;
    return;
  }
  x_ = joining({start.x, start.v, start.a}, {end.x, end.v, end.a});
  if (low < 0 && high > 0) {
    for (const double turn : turns()) {
      const double x = value_at(x_, turn);
      const double below = std::floor(x);
      add_piece(turn, static_cast<std::int32_t>(below) + (x - below >= 0.5 ? 1 : 0));
    }
  }
  add_piece(1, end_count);
}

}  // namespace inbetween
