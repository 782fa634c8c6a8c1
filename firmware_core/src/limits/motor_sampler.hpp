#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "inbetween/limits/motor_trajectory.hpp"
#include "inbetween/trajectory/sampler.hpp"

/// A motor behind a calibration as a motion that can be asked on either side of its joints.

namespace inbetween {

class MotorSampler {
 public:
  using Joint = MotorJoint;
  struct Known {};

  MotorSampler(const MotorSource& source, std::span<const MotorJoint> joints)
      : axes_(source.trajectory), axis_(source.axis), calibration_(source.calibration), joints_(joints) {}

  [[nodiscard]] static std::size_t axis_count() { return 1; }
  [[nodiscard]] FrameRate frame_rate() const { return axes_->frame_rate(); }
  [[nodiscard]] std::span<const MotorJoint> joints() const { return joints_; }
  /// Nobody draws a path for a motor, so its tolerance is that of an axis beside a path.
  [[nodiscard]] static double weight(std::size_t) { return 0; }
  [[nodiscard]] static double length() { return 0; }
  [[nodiscard]] static bool is_cubic() { return false; }
  [[nodiscard]] bool keeps_to_joints() const { return axes_->keeps_to_joints(); }
  [[nodiscard]] bool rests_behind(const MotorJoint& joint) const {
    const TrajectoryPiece& piece = axes_->pieces()[joint.piece_after];
    return piece.degree == 1 && piece.begin_row == piece.end_row;
  }

  SampledSpeed sample(const FrameTime& time, Known&, std::span<AxisMotion> out) const {
    return sample(time, out);
  }
  SampledSpeed sample(const FrameTime& time, std::span<AxisMotion> out) const {
    const AxisMotion axis = axes_->motion_of(axis_, time);
    const CalibrationSlope slope = calibration_->slope_at(axis.position);
    out[0] = motor_of(axis, calibration_->motor_at(axis.position), slope);
    return known_of(out[0], slope.first * axis.position);
  }
  SampledSpeed arriving(const MotorJoint& joint, std::span<AxisMotion> out) const {
    return at_joint(joint, axis_at(joint, joint.piece_before, true), joint.curve_before, out[0]);
  }
  SampledSpeed leaving(const MotorJoint& joint, std::span<AxisMotion> out) const {
    return at_joint(joint, axis_at(joint, joint.piece_after, false), joint.curve_after, out[0]);
  }
  static void write_reach(const PathPoint&, double offset, std::span<double> out) {
    std::ranges::fill(out, offset);
  }
  [[nodiscard]] static std::uint8_t unbounded_order(const MotorJoint& joint, const SampledSpeed&,
                                                    std::size_t) {
    return joint.unbounded;
  }

 private:
  static AxisMotion motor_of(const AxisMotion& axis, double position, const CalibrationSlope& slope) {
    const auto [velocity, acceleration, jerk] =
        motor_motion(slope, {axis.velocity, axis.acceleration, axis.jerk});
    return {position, velocity, acceleration, jerk};
  }
  /// An axis far from 0 is known within its rounding, and so is its motor where the curve is as steep as
  /// this: `place` is its slope times the position.
  static SampledSpeed known_of(const AxisMotion& motor, double place) {
    constexpr double rounding = distance_roundings * std::numeric_limits<double>::epsilon();
    return {.speed = std::fabs(motor.velocity), .off = rounding * std::fabs(place)};
  }
  /// The curve has two continuous derivatives: of the two pieces at a mark one says all but the third, so
  /// that neither side is beside the other by a rounding.
  SampledSpeed at_joint(const MotorJoint& joint, const AxisMotion& axis, std::uint8_t curve,
                        AxisMotion& out) const {
    const std::span<const CalibrationPiece> pieces = calibration_->pieces();
    const CalibrationPiece& piece = pieces[joint.curve_before];
    const double t = axis.position - piece.from;
    const CalibrationSlope slope{piece.cubic.derivative(t), piece.cubic.second(t),
                                 pieces[curve].cubic.third()};
    out = motor_of(axis, piece.cubic.value(t), slope);
    return known_of(out, slope.first * axis.position);
  }
  [[nodiscard]] AxisMotion axis_at(const MotorJoint& joint, std::uint32_t piece, bool is_end) const {
    const TrajectoryPiece& of = axes_->pieces()[piece];
    if (joint.time != (is_end ? axes_->end_of(piece) : of.begin)) return axes_->motion_of(axis_, joint.time);
    const auto value = [&](std::size_t k) { return at_end_of_piece(*axes_, of, axis_, k, is_end); };
    return {value(0), value(1), value(2), value(3)};
  }

  const Trajectory* axes_;
  std::size_t axis_;
  const Calibration* calibration_;
  std::span<const MotorJoint> joints_;
};

}  // namespace inbetween
