#pragma once

#include <array>
#include <optional>
#include <span>

#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/motion_bounds.hpp"
#include "inbetween/limits/move.hpp"
#include "inbetween/limits/roll.hpp"
#include "inbetween/limits/stop_bounds.hpp"
#include "inbetween/timing/track.hpp"
#include "tests/embedded/target/moves.hpp"

/// A solved move as it is played, in memory of its own: with rolls where it needs them, on a rig whose limits
/// are a little above what it does, and with the bounds of its stops.

namespace inbetween::embedded {

template <Precise Real>
class PlayedMove {
 public:
  /// The track's memory is the caller's.
  Status make(const Track<Real>& track, std::int32_t rate_hz) {
    track_ = track;
    axes_ = static_cast<std::size_t>(track.path().axis_count());
    if (const Status limited = make_limits(); !limited) return limited;
    MoveRolls<Real> rolls;
    for (const RollEnd end : {RollEnd::before, RollEnd::after}) {
      if (const Status rolled = make_rolls(end, rolls); !rolled) return rolled;
    }
    const auto move = inbetween::Move<Real>::make({&*track_, 1}, rolls);
    if (!move) return move.error();
    move_ = *move;
    return make_bounds(rate_hz);
  }
  /// Anew, for a move that has been made.
  Status make_bounds(std::int32_t rate_hz) {
    const StopRequest<Real> request{
        .move = *move_, .limits = limits(), .tick_seconds = Real{1} / static_cast<Real>(rate_hz)};
    const auto bounds = StopBounds<Real>::make(request, stops_.memory(), std::span(stop_peaks_).first(axes_));
    if (!bounds) return bounds.error();
    bounds_ = *bounds;
    return Done{};
  }

  [[nodiscard]] const inbetween::Move<Real>& move() const { return *move_; }
  [[nodiscard]] const StopBounds<Real>& bounds() const { return *bounds_; }
  [[nodiscard]] std::span<const StopCell<Real>> cells() const { return stops_.cells; }
  /// Of the move itself, and of its stops.
  [[nodiscard]] std::span<const PlayedAxis<Real>> played() const { return std::span(played_).first(axes_); }
  [[nodiscard]] std::span<const AxisPeaks<Real>> stop_peaks() const {
    return std::span(stop_peaks_).first(axes_);
  }
  [[nodiscard]] std::span<const AxisLimits<Real>> limits() const { return std::span(limits_).first(axes_); }

 private:
  Status make_limits() {
    constexpr auto room = Real(1.25);
    constexpr auto anywhere = Real(1e4);
    std::array<AxisPeaks<Real>, max_axes> peaks;
    const std::array<MotionTriple<Real>, max_axes> slack{};
    if (const Status bounded = bound_motion<Real>(*track_, slack, {stops_.turns}, peaks); !bounded) {
      return bounded;
    }
    for (std::size_t d = 0; d < axes_; ++d) {
      played_[d] = {.peaks = peaks[d]};
      const auto axis = AxisLimits<Real>::make({.min = -anywhere,
                                                .max = anywhere,
                                                .max_velocity = room * peaks[d].velocity.value,
                                                .max_acceleration = room * peaks[d].acceleration.value,
                                                .max_jerk = room * peaks[d].jerk.value});
      if (!axis) return axis.error();
      limits_[d] = *axis;
    }
    return Done{};
  }
  Status make_rolls(RollEnd end, MoveRolls<Real>& rolls) {
    const bool is_before = end == RollEnd::before;
    const std::span<AxisMotion<Real>> joints = std::span(joints_).first(axes_);
    if (!joints_of<Real>({&*track_, 1}, end, joints)) return Done{};
    RollSpan span{.end = end, .joint_frame = is_before ? 0 : track_->frames(), .fps = track_->frame_rate()};
    const auto frames = roll_frames<Real>({end, span.joint_frame, span.fps, joints, limits()});
    if (!frames) return frames.error();
    span.frames = *frames;
    const std::span<RollAxis<Real>> axes = std::span(is_before ? before_ : after_).first(axes_);
    for (std::size_t d = 0; d < axes_; ++d) {
      const auto roll = RollAxis<Real>::make(span, joints[d]);
      if (!roll) return roll.error();
      axes[d] = *roll;
    }
    (is_before ? rolls.before : rolls.after) = axes;
    return Done{};
  }

  static AxisLimits<Real> no_limits() { return *AxisLimits<Real>::make({0, 1, 1, 1}); }

  std::optional<Track<Real>> track_;
  std::optional<inbetween::Move<Real>> move_;
  std::optional<StopBounds<Real>> bounds_;
  std::size_t axes_ = 0;
  std::array<AxisLimits<Real>, max_axes> limits_{no_limits(), no_limits(), no_limits()};
  std::array<PlayedAxis<Real>, max_axes> played_;
  std::array<AxisPeaks<Real>, max_axes> stop_peaks_;
  std::array<AxisMotion<Real>, max_axes> joints_;
  std::array<RollAxis<Real>, max_axes> before_, after_;
  StopBoundsStorage<Real, 256, max_axes> stops_;
};

}  // namespace inbetween::embedded
