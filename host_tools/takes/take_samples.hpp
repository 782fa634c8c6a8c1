// From the ticks of a take to where its axes were told to be and where they were.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host_tools/takes/take.hpp"
#include "inbetween/limits/played_motion.hpp"

namespace inbetween {

/// A tick at which the drives answered a setpoint of the move.
struct TakeSample {
  std::int64_t tick = 0;  ///< of the answer
  std::int64_t turn = 0;
  FrameTime time = {};  ///< of the setpoint on the time line
};

/// At the beginning of a tick a drive answers the setpoint of the tick before (LoopTrace::take). So the
/// actual positions of tick k belong to the place of the playhead at tick k - 1, and a tick behind lost ones
/// belongs to none. Only ticks at which the move was played, or was held where the playhead had stopped, are
/// samples: not those of a rig that is not told anything, and not those before the first start.
///
/// Commanded is what PlayedMotion::positions() says of that place, bit for bit what was sent. An axis in no
/// track is held by the rig: it is told to stay where it was at the first sample.
class TakeSamples {
 public:
  /// Of its own trajectory, so that it does not matter which version solves the move today. Throws
  /// std::runtime_error, one line, where the take is damaged. O(ticks * axes).
  explicit TakeSamples(const Take& take);

  [[nodiscard]] std::int64_t number() const { return number_; }
  [[nodiscard]] std::int32_t rate_hz() const { return rate_hz_; }
  [[nodiscard]] FrameRate frame_rate() const { return frame_rate_; }
  [[nodiscard]] const std::vector<TakeAxis>& axes() const { return axes_; }
  [[nodiscard]] std::size_t size() const { return samples_.size(); }
  [[nodiscard]] const TakeSample& operator[](std::size_t sample) const { return samples_[sample]; }
  /// Of every axis of the rig, in its unit.
  [[nodiscard]] std::span<const double> commanded(std::size_t sample) const {
    return row_of(commanded_, sample);
  }
  [[nodiscard]] std::span<const double> actual(std::size_t sample) const { return row_of(actual_, sample); }
  /// The setpoint is that of the sample before, or of the next for the first: they differ by no more than a
  /// hundredth of TakeAxis::resolution or by rounding.
  [[nodiscard]] bool rests(std::size_t sample, std::size_t axis) const;
  /// From the setpoint before it to that of the sample: -1, 0 (it rests, or is the first) or 1.
  [[nodiscard]] int direction(std::size_t sample, std::size_t axis) const;

 private:
  [[nodiscard]] std::span<const double> row_of(const std::vector<double>& rows, std::size_t sample) const {
    return std::span(rows).subspan(sample * axes_.size(), axes_.size());
  }
  void take_ticks(const Take& take, const PlayedMotion& motion);

  std::int64_t number_;
  std::int32_t rate_hz_;
  FrameRate frame_rate_;
  std::vector<TakeAxis> axes_;
  std::vector<TakeSample> samples_;
  std::vector<double> commanded_;  // a row of axes per sample
  std::vector<double> actual_;
};

}  // namespace inbetween
