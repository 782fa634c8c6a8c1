#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/base/setpoint.hpp"
#include "inbetween/path/path.hpp"

/// The map from the position of an axis to that of its motor where no scale describes it: the focus marks of
/// a lens, a jaw on a crank.

namespace inbetween {

/// The axis is at `axis`, in axis units, where its motor is at `motor`, in units of the motor.
struct CalibrationMark {
  double axis = 0;
  double motor = 0;
};

/// A stretch of the curve that begins at `from`: a cubic in (axis - from).
struct CalibrationPiece {
  double from = 0;
  Cubic cubic;
};

/// The motor and its derivatives by the axis; or bounds of their magnitudes.
struct CalibrationSlope {
  double first = 0, second = 0, third = 0;
};

/// The curve T through the marks: the natural interpolating cubic spline (de Boor 2001, ch. IV), straight
/// beyond the first and the last mark. It is C2, so that a motion without steps stays one, and strictly
/// monotone, so that it has an inverse. A spline need not be monotone where its marks are; one that is not is
/// refused. Refers to the caller's memory.
class Calibration {
 public:
  static constexpr std::size_t max_marks = 64;

  /// Of at least two marks, rising by `axis`. `pieces` has one entry more than there are marks. Errors:
  /// wrong_count (marks), capacity (max_marks, pieces), not_finite, out_of_range with key (the axis does not
  /// rise from the mark before, or the motor turns back or stays), no_solution with key (the curve from that
  /// mark to the next turns back, or is next to level). O(marks).
  static Result<Calibration> make(std::span<const CalibrationMark> marks, std::span<CalibrationPiece> pieces);

  /// One more than there are marks: the first and the last are straight. A mark begins the piece of its
  /// number, counted from 1.
  [[nodiscard]] std::span<const CalibrationPiece> pieces() const { return pieces_; }
  /// The number of the piece for a position of the axis; on a mark that of the one behind it. O(log marks).
  [[nodiscard]] std::size_t piece_index(double axis) const;
  /// T(axis). O(log marks).
  [[nodiscard]] double motor_at(double axis) const { return value_at(piece_at(axis), axis); }
  /// T', T'', T'''. On a mark those of the piece behind it. O(log marks).
  [[nodiscard]] CalibrationSlope slope_at(double axis) const;
  /// The axis at which the motor is there, to rounding. O(log marks) and at most 64 steps of Newton's method
  /// in a bracket.
  [[nodiscard]] double axis_at(double motor) const;
  /// The setpoint of the motor for one of the axis, by the chain rule: T' v, and T'' v^2 + T' a.
  [[nodiscard]] Setpoint motor_of(const Setpoint& axis) const;
  /// Suprema of |T'|, |T''| and |T'''| from one position of the axis to another, not below it. O(marks).
  [[nodiscard]] CalibrationSlope bounds(double low, double high) const;

 private:
  explicit Calibration(std::span<const CalibrationPiece> pieces) : pieces_(pieces) {}

  [[nodiscard]] const CalibrationPiece& piece_at(double axis) const { return pieces_[piece_index(axis)]; }
  [[nodiscard]] static double value_at(const CalibrationPiece& piece, double axis) {
    return piece.cubic.value(axis - piece.from);
  }
  [[nodiscard]] bool rises() const { return pieces_.front().cubic.c1 > 0; }

  std::span<const CalibrationPiece> pieces_;
};

/// Velocity, acceleration and jerk of a motor from those of its axis (chain rule); of magnitudes, how hard it
/// moves at most where its axis moves with at most these: T' v, T'' v^2 + T' a, T''' v^3 + 3 T'' v a + T' j.
constexpr std::array<double, 3> motor_motion(const CalibrationSlope& slope,
                                             const std::array<double, 3>& axis) {
  const auto [v, a, j] = axis;
  return {slope.first * v, slope.second * v * v + slope.first * a,
          slope.third * v * v * v + 3 * slope.second * v * a + slope.first * j};
}

}  // namespace inbetween
