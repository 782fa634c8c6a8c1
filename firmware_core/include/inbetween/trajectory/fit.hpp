#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/result.hpp"
#include "inbetween/trajectory/trajectory.hpp"

/// From a motion that can be asked at any time to the trajectory that is played.

namespace inbetween {

inline constexpr std::size_t max_trajectory_axes = 64;

/// How near what is played comes to what is asked, between joints.
struct FitTolerances {
  double position_share = 1.0 / (1 << 30);  ///< of what the axis travels
  double speed_share = 1e-6;                ///< of the drawn speed at that moment
};

/// What a sampler knows of a moment beside the motion itself.
struct SampledSpeed {
  double speed = 0;        ///< along the path, unit/s, as the weights of the axes count
  std::uint8_t order = 3;  ///< the highest derivative that has a value on this side: 0, 1 or 3
};

/// A moment at which the asked motion is not smooth, or may not be.
struct SampledJoint {
  FrameTime<double> time;
  std::int32_t key = -1;  ///< that is passed there
  CurvePlace<double> curve_before, curve_after;
  PathPoint<double> point_before, point_after;
  double constant_before = 0, constant_after = 0;
};

/// The track at a drawn speed as a motion that can be asked on either side of its joints.
class DrawnSampler {
 public:
  /// `joints` is the memory for the joints, in the end in their order: knots of the speed curve, passings of
  /// knots of the path, and places where the path (nearly) stands still. Errors: capacity, with what would
  /// suffice at most.
  static Result<DrawnSampler> make(const Track<double>& track, std::span<SampledJoint> joints);

  [[nodiscard]] std::size_t axis_count() const {
    return static_cast<std::size_t>(track_->path().axis_count());
  }
  [[nodiscard]] FrameRate frame_rate() const { return track_->frame_rate(); }
  [[nodiscard]] std::span<const SampledJoint> joints() const { return joints_; }
  [[nodiscard]] double weight(std::size_t axis) const { return track_->path().weights()[axis]; }
  /// Of the path, weighted.
  [[nodiscard]] double length() const { return track_->arc_length().total(); }
  /// Between joints.
  [[nodiscard]] SampledSpeed sample(const FrameTime<double>& time, std::span<AxisMotion<double>> out) const;
  /// Whether the acceleration of an axis has no bound on that side of a joint at which the path stands still,
  /// if it is passed at a speed.
  [[nodiscard]] bool is_unbounded(const PathPoint<double>& point, std::size_t axis) const;
  /// With what the motion comes to a joint, or leaves it.
  [[nodiscard]] SampledSpeed arriving(const SampledJoint& joint, std::span<AxisMotion<double>> out) const;
  [[nodiscard]] SampledSpeed leaving(const SampledJoint& joint, std::span<AxisMotion<double>> out) const;

 private:
  DrawnSampler(const Track<double>& track, std::span<const SampledJoint> joints)
      : track_(&track), joints_(joints) {}

  const Track<double>* track_;
  std::span<const SampledJoint> joints_;
};

/// The most joints that a track at a drawn speed has.
std::size_t max_joints(const Track<double>& track);

/// The trajectory of a sampled motion. Each stretch between two joints is halved until the Hermite polynomial
/// of its ends is within the tolerances at five places inside.
///
/// Errors: capacity (pieces, values, breaks, unbounded, axes). Cost: about seven samples a piece and as many
/// again for each halving.
Result<Trajectory> fit_trajectory(const DrawnSampler& sampler, const FitTolerances& tolerances,
                                  const TrajectoryMemory& memory);

}  // namespace inbetween
