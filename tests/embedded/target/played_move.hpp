#pragma once

#include <array>
#include <optional>
#include <span>

#include "inbetween/limits/limits.hpp"
#include "inbetween/limits/move.hpp"
#include "inbetween/limits/move_bounds.hpp"
#include "inbetween/limits/played_motion.hpp"
#include "inbetween/limits/stop_bounds.hpp"
#include "inbetween/timing/track.hpp"
#include "tests/embedded/target/moves.hpp"

/// A solved move as it is played, in memory of its own: with rolls where it needs them, on a rig whose limits
/// are a little above what it does, and with the bounds of its stops.

namespace inbetween::embedded {

/// It proves what a move does: its peaks, and its cells on such a rig.
class ProvenMove {
 public:
  static constexpr std::size_t cells = 256;

  /// The peaks without rolls.
  Status bound(const Track& track) {
    track_ = track;
    return bound({}, 0);
  }
  /// With its rolls, in cells.
  Status bound_in_cells(const MoveRolls& rolls) { return bound(rolls, cells); }
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
  std::optional<Track> track_;
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
    const auto of_axes = [&](auto& memory) { return std::span(memory).first(axes_); };
    const auto joined = join_rolls({&*track_, 1}, {}, limits(), {0, track_->frames()},
                                   {of_axes(joints_), of_axes(before_), of_axes(after_)});
    if (!joined) return joined.error();
    if (joined->obstacles[0] || joined->obstacles[1]) return no_roll();
    const auto move = inbetween::Move::make(std::span<const Track>(&*track_, 1), joined->rolls);
    if (!move) return move.error();
    move_ = *move;
    if (const Status proven = prove(); !proven) return proven;
    return make_bounds();
  }
  /// Anew, for a move that has been made: what it does, in cells.
  Status prove() {
    write_room(limits(), 1, 1.0 / static_cast<double>(rate_hz_), proven_.room());
    return proven_.bound_in_cells(move_->rolls());
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
  static Error no_roll() {
    return {.code = ErrorCode::no_solution,
            .what = "no roll keeps the limits",
            .remedy = "leave more room above the peaks"};
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
