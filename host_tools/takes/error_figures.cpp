#include "host_tools/takes/error_figures.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween {

void ErrorFigures::add(double error, const FrameTime& at) {
  if (count_ == 0 || std::fabs(error) > std::fabs(worst_)) {
    worst_ = error;
    worst_at_ = at;
  }
  ++count_;
  sum_ += error;
  squares_ += error * error;
}

double ErrorFigures::mean() const {
  return count_ == 0 ? 0 : sum_ / static_cast<double>(count_);
}

double ErrorFigures::rms() const {
  return count_ == 0 ? 0 : std::sqrt(squares_ / static_cast<double>(count_));
}

void MeasuredErrors::add(double error, const FrameTime& at, bool is_at_rest) {
  all_.add(error, at);
  (is_at_rest ? at_rest_ : moving_).add(error, at);
  // Most often it is the last frame or the next; a move that is played backward or again comes to others.
  auto frame = frames_.end();
  if (!frames_.empty() && at.frame <= frames_.back().frame) {
    frame = frames_.back().frame == at.frame
                ? frames_.end() - 1
                : std::ranges::lower_bound(frames_, at.frame, {}, &FrameFigures::frame);
  }
  if (frame == frames_.end() || frame->frame != at.frame) frame = frames_.insert(frame, {at.frame, {}});
  frame->figures.add(error, at);
}

}  // namespace inbetween
