// Errors at many moments in a few figures.
#pragma once

#include <cstdint>
#include <vector>

#include "inbetween/timing/frame_time.hpp"

namespace inbetween {

class ErrorFigures {
 public:
  void add(double error, const FrameTime& at);

  [[nodiscard]] std::int64_t count() const { return count_; }
  /// The error of the largest magnitude, with its sign, and the first place that had it; 0 without any.
  [[nodiscard]] double worst() const { return worst_; }
  [[nodiscard]] const FrameTime& worst_at() const { return worst_at_; }
  [[nodiscard]] double mean() const;
  /// The root of the mean square.
  [[nodiscard]] double rms() const;

 private:
  std::int64_t count_ = 0;
  double worst_ = 0;
  FrameTime worst_at_ = {};
  double sum_ = 0;
  double squares_ = 0;
};

/// A frame has the moments from itself until before the next frame.
struct FrameFigures {
  std::int32_t frame = 0;
  ErrorFigures figures;
};

/// The figures of one measure: all of them, while it rests and while it moves, and of every frame.
class MeasuredErrors {
 public:
  void add(double error, const FrameTime& at, bool is_at_rest);

  [[nodiscard]] const ErrorFigures& all() const { return all_; }
  [[nodiscard]] const ErrorFigures& at_rest() const { return at_rest_; }
  [[nodiscard]] const ErrorFigures& moving() const { return moving_; }
  /// In the order of the frames; those without a moment are not there.
  [[nodiscard]] const std::vector<FrameFigures>& frames() const { return frames_; }

 private:
  ErrorFigures all_, at_rest_, moving_;
  std::vector<FrameFigures> frames_;
};

/// A place on the time line in frames: 96.24.
inline double in_frames(const FrameTime& time) {
  return time.frame + time.fraction;
}

}  // namespace inbetween
