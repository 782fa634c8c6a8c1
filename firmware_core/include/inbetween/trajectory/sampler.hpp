#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/result.hpp"
#include "inbetween/timing/track.hpp"

/// A motion that can be asked for any moment, and on either side of the moments at which it may step.

namespace inbetween {

/// The distance along a path is known within so many roundings of its length, and so is a position of itself.
inline constexpr double distance_roundings = 8;

/// This is what a sampler knows of a moment beside the motion itself.
struct SampledSpeed {
  double speed = 0;        ///< along the path, unit/s, as the weights of the axes count
  std::uint8_t order = 3;  ///< the highest derivative that has a value on this side: 0, 1 or 3
  double off = 0;          ///< how far along the path the place may be from where the curve has brought it
  PathPoint point = {};    ///< the place on the path
};

/// A moment at which the asked motion is not smooth, or may not be.
struct SampledJoint {
  FrameTime time;
  std::int32_t key = -1;                           ///< that is passed there: of keys in one place the first
  CurvePlace curve_before, curve_after;            ///< of a drawn curve
  PathPoint point_before, point_after;             ///< of the path
  double constant_before = 0, constant_after = 0;  ///< of a drawn curve
  /// So far along the path the motion may be from what is smooth here: the distance to a turn so near to a
  /// key that no time lies between both, and back.
  double passed_by = 0;
};

struct SampledSegment;  // inside the core

/// A track as a motion that can be asked on either side of its joints. Refers to the track's memory and the
/// caller's.
class TrackSampler {
 public:
  using Joint = SampledJoint;
  using Known = SampledSegment;

  /// `joints` is the memory for the joints, in the end in their order. At a drawn speed: knots of the speed
  /// curve, breaks, passings of knots of the path, and places where the path (nearly) stands still. Timed by
  /// frames: the knots of the path. Of a path without length: both ends. Errors: capacity, with what would
  /// suffice at most (max_joints).
  static Result<TrackSampler> make(const Track& track, std::span<SampledJoint> joints);

  [[nodiscard]] std::size_t axis_count() const {
    return static_cast<std::size_t>(track_->path().axis_count());
  }
  [[nodiscard]] FrameRate frame_rate() const { return track_->frame_rate(); }
  [[nodiscard]] std::span<const SampledJoint> joints() const { return joints_; }
  /// The same motion from one joint to another: what is fitted in stretches takes little memory at a time.
  /// Domain: first < last < joints().size().
  [[nodiscard]] TrackSampler between(std::size_t first, std::size_t last) const {
    return {*track_, joints_.subspan(first, last - first + 1)};
  }
  [[nodiscard]] double weight(std::size_t axis) const { return track_->path().weights()[axis]; }
  /// The length of the path, weighted, in whose rounding a position is known; 0 where none is measured.
  [[nodiscard]] double length() const { return track_->has_profile() ? track_->arc_length().total() : 0; }
  /// Every axis is a cubic in time from joint to joint: its position and velocity at both say all.
  [[nodiscard]] bool is_cubic() const;
  /// Between two joints every axis stays between its positions at both.
  [[nodiscard]] bool keeps_to_joints() const { return !track_->path().overshoots(); }
  /// Nothing moves from this joint to the next.
  [[nodiscard]] bool rests_behind(const SampledJoint& joint) const;

  /// Between joints. At order 0, where an axis has no velocity, it has the one that would make of the
  /// rounding of the distance what that makes of the position.
  [[nodiscard]] SampledSpeed sample(const FrameTime& time, std::span<AxisMotion> out) const;
  /// The same for who asks for many moments on a segment of the path: `known` is what was worked out of it.
  SampledSpeed sample(const FrameTime& time, SampledSegment& known, std::span<AxisMotion> out) const;
  /// These tell with what the motion comes to a joint, and with what it leaves it.
  [[nodiscard]] SampledSpeed arriving(const SampledJoint& joint, std::span<AxisMotion> out) const;
  [[nodiscard]] SampledSpeed leaving(const SampledJoint& joint, std::span<AxisMotion> out) const;
  /// How far from its position at a point every axis is within so much of the distance along the path.
  void write_reach(const PathPoint& point, double offset, std::span<double> out) const;
  /// The lowest derivative of an axis that has no bound beside a joint at which the path stands still, if it
  /// is passed at a drawn speed: 1 velocity, 2 acceleration; 0 where all have one. `known` is what is known
  /// of the side that is meant.
  [[nodiscard]] std::uint8_t unbounded_order(const SampledJoint& joint, const SampledSpeed& known,
                                             std::size_t axis) const;

 private:
  TrackSampler(const Track& track, std::span<const SampledJoint> joints) : track_(&track), joints_(joints) {}

  const Track* track_;
  std::span<const SampledJoint> joints_;
};

/// The most joints that a track has.
std::size_t max_joints(const Track& track);

}  // namespace inbetween
