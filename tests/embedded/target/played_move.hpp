#pragma once

#include <array>
#include <optional>
#include <span>

#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/move.hpp"
#include "inbetween/limits/move_bounds.hpp"
#include "inbetween/limits/roll.hpp"
#include "inbetween/limits/stop_bounds.hpp"
#include "inbetween/timing/track.hpp"
#include "tests/embedded/target/moves.hpp"

/// A solved move as it is played, in memory of its own: with rolls where it needs them, on a rig whose limits
/// are a little above what it does, and with the bounds of its stops.

namespace inbetween::embedded {

/// What a move does: its peaks, and its cells on such a rig.
class ProvenMove {
 public:
  static constexpr std::size_t cells = 256;

  /// The peaks without rolls.
  Status bound(const Track& track) {
    track_ = track;
    return bound({}, 0);
  }
  /// With a roll of so many frames at either end, or 0.
  Status bound_in_cells(std::int32_t before, std::int32_t after) {
    MoveRolls rolls;
    if (const Status made = make_roll(RollEnd::before, before, before_, rolls.before); !made) return made;
    if (const Status made = make_roll(RollEnd::after, after, after_, rolls.after); !made) return made;
    return bound(rolls, cells);
  }
  [[nodiscard]] std::span<const AxisPeaks> peaks() const { return bounds_.peaks; }
  [[nodiscard]] const MotionCells& motion() const { return bounds_.cells; }
  [[nodiscard]] std::span<MotionTriple> room() { return storage_.room; }

 private:
  Status bound(const MoveRolls& rolls, std::size_t count) {
    const auto move = inbetween::Move::make(std::span<const Track>(&*track_, 1), rolls);
    if (!move) return move.error();
    bounds_ = storage_.bounds(*move, count);
    return bound_move(*move, {&*track_, 1}, {}, {}, storage_.memory(), bounds_);
  }
  Status make_roll(RollEnd end, std::int32_t frames, std::span<RollAxis> memory,
                   std::span<const RollAxis>& out) {
    if (frames == 0) return Done{};
    const auto axes = static_cast<std::size_t>(track_->path().axis_count());
    std::array<AxisMotion, max_axes> joints;
    joints_of({&*track_, 1}, end, joints);
    const std::int32_t joint_frame = end == RollEnd::before ? 0 : track_->frames();
    for (std::size_t d = 0; d < axes; ++d) {
      const auto roll = RollAxis::make({end, joint_frame, frames, track_->frame_rate()}, joints[d]);
      if (!roll) return roll.error();
      memory[d] = *roll;
    }
    out = memory.first(axes);
    return Done{};
  }

  std::optional<Track> track_;
  std::array<RollAxis, max_axes> before_, after_;
  MoveBoundsStorage<max_axes, 1000, 400, 60, cells> storage_;
  MoveBounds bounds_;
};

class PlayedMove {
 public:
  /// The memory of the track is the caller's.
  Status make(const Track& track, std::int32_t rate_hz) {
    track_ = track;
    rate_hz_ = rate_hz;
    axes_ = static_cast<std::size_t>(track.path().axis_count());
    if (const Status proven = proven_.bound(track); !proven) return proven;
    if (const Status limited = make_limits(); !limited) return limited;
    MoveRolls rolls;
    for (const RollEnd end : {RollEnd::before, RollEnd::after}) {
      if (const Status rolled = make_rolls(end, rolls); !rolled) return rolled;
    }
    const auto move = inbetween::Move::make(std::span<const Track>(&*track_, 1), rolls);
    if (!move) return move.error();
    move_ = *move;
    if (const Status proven = prove(); !proven) return proven;
    return make_bounds();
  }
  /// Anew, for a move that has been made: what it does, in cells.
  Status prove() {
    const auto length = [](std::span<const RollAxis> roll) {
      return roll.empty() ? 0 : roll.front().span().frames;
    };
    write_room(limits(), 1, 1.0 / static_cast<double>(rate_hz_), proven_.room());
    return proven_.bound_in_cells(length(move_->rolls().before), length(move_->rolls().after));
  }
  /// Once, from what was proven.
  Status make_bounds() {
    const StopRequest request{
        .motion = proven_.motion(), .limits = limits(), .tick_seconds = 1.0 / static_cast<double>(rate_hz_)};
    const auto bounds = StopBounds::make(request, stops_, std::span(stop_peaks_).first(axes_));
    if (!bounds) return bounds.error();
    bounds_ = *bounds;
    return Done{};
  }

  [[nodiscard]] const inbetween::Move& move() const { return *move_; }
  void positions(const FrameTime& time, std::span<double> out) const {
    const std::span<const RollAxis> rolls = move_->rolls_at(time);
    for (std::size_t d = 0; d < rolls.size(); ++d) out[d] = rolls[d].motion(time).position;
    if (rolls.empty()) track_->positions(move_->within_part(time), out);
  }
  [[nodiscard]] const StopBounds& bounds() const { return *bounds_; }
  [[nodiscard]] std::span<const StopCell> cells() const { return stops_; }
  [[nodiscard]] std::span<const AxisPeaks> stop_peaks() const { return std::span(stop_peaks_).first(axes_); }
  [[nodiscard]] std::span<const AxisLimits> limits() const { return std::span(limits_).first(axes_); }

 private:
  Status make_limits() {
    constexpr auto room = 1.25;
    constexpr auto anywhere = 1e4;
    for (std::size_t d = 0; d < axes_; ++d) {
      const AxisPeaks& peaks = proven_.peaks()[d];
      const auto above = [&](const Peak& peak) { return room * static_cast<double>(peak.value); };
      const auto axis = AxisLimits::make({.min = -anywhere,
                                          .max = anywhere,
                                          .max_velocity = above(peaks.velocity),
                                          .max_acceleration = above(peaks.acceleration),
                                          .max_jerk = above(peaks.jerk)});
      if (!axis) return axis.error();
      limits_[d] = *axis;
    }
    return Done{};
  }
  Status make_rolls(RollEnd end, MoveRolls& rolls) {
    const bool is_before = end == RollEnd::before;
    const std::span<AxisMotion> joints = std::span(joints_).first(axes_);
    if (!joints_of({&*track_, 1}, end, joints)) return Done{};
    RollSpan span{.end = end, .joint_frame = is_before ? 0 : track_->frames(), .fps = track_->frame_rate()};
    const auto frames = roll_frames({end, span.joint_frame, span.fps, joints, limits()});
    if (!frames) return frames.error();
    span.frames = *frames;
    const std::span<RollAxis> axes = std::span(is_before ? before_ : after_).first(axes_);
    for (std::size_t d = 0; d < axes_; ++d) {
      const auto roll = RollAxis::make(span, joints[d]);
      if (!roll) return roll.error();
      axes[d] = *roll;
    }
    (is_before ? rolls.before : rolls.after) = axes;
    return Done{};
  }

  static AxisLimits no_limits() { return *AxisLimits::make({0, 1, 1, 1}); }

  std::optional<Track> track_;
  std::optional<inbetween::Move> move_;
  std::optional<StopBounds> bounds_;
  std::size_t axes_ = 0;
  std::array<AxisLimits, max_axes> limits_{no_limits(), no_limits(), no_limits()};
  std::array<AxisPeaks, max_axes> stop_peaks_;
  std::array<AxisMotion, max_axes> joints_;
  std::array<RollAxis, max_axes> before_, after_;
  std::array<StopCell, ProvenMove::cells + 1> stops_;
  std::int32_t rate_hz_ = 0;
  ProvenMove proven_;
};

}  // namespace inbetween::embedded
