#include "tests/support/recorded_play.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace inbetween {

RecordedPlay::RecordedPlay(const Plan& plan, const StopBounds& bounds, double tick_s)
    : plan_(plan), bounds_(bounds), tick_s_(tick_s), sizes_(plan.played().axis_count()) {
  for (std::int32_t frame = plan.played().first_frame(); frame <= plan.played().last_frame(); ++frame) {
    std::vector<double> at(sizes_.size());
    plan.motion().positions({frame, 0}, at);
    for (std::size_t d = 0; d < at.size(); ++d) sizes_[d] = std::max(sizes_[d], std::fabs(at[d]));
  }
}

void RecordedPlay::complain(const std::string& words, const Playhead& playhead) {
  if (!complaint_.empty()) return;
  complaint_ = fmt::format("{}, at frame {} + {}, rate {}, rate change {}; a tick before: {}", words,
                           playhead.time().frame, playhead.time().fraction, playhead.rate(),
                           playhead.rate_change(), before_);
}

void RecordedPlay::take(const Playhead& playhead) {
  std::rotate(positions_.begin(), positions_.end() - 1, positions_.end());
  std::rotate(frames_.begin(), frames_.end() - 1, frames_.end());
  frames_.front() = playhead.time().frame + playhead.time().fraction;
  std::vector<double>& now = positions_.front();
  now.resize(sizes_.size());
  plan_.motion().positions(playhead.time(), now);
  count_ = std::min(count_ + 1, 4);
  const StopBound bound = bounds_.at(playhead.time());
  if (std::fabs(playhead.rate()) > bounds_.rate() * (1 + 1e-12)) complain("too fast", playhead);
  if (std::fabs(playhead.rate_change()) > bound.rate_change * (1 + 1e-6)) {
    complain(fmt::format("rate change above its bound {}", bound.rate_change), playhead);
  }
  for (std::size_t d = 0; d < now.size(); ++d) compare(d, playhead);
  before_ = fmt::format("frame {} + {}, rate {}, state {}", playhead.time().frame, playhead.time().fraction,
                        playhead.rate(), static_cast<int>(playhead.state()));
}

bool RecordedPlay::is_across_step() const {
  const auto ends = std::minmax_element(frames_.begin(), frames_.end());
  const double first = *ends.first, last = *ends.second;
  return std::any_of(steps_.begin(), steps_.end(), [&](double step) {
    const double rounding = 1e-9 * (1 + std::fabs(step));
    return first - rounding <= step && step <= last + rounding;
  });
}

void RecordedPlay::compare(std::size_t axis, const Playhead& playhead) {
  const auto at = [&](std::size_t ticks_ago) { return positions_[ticks_ago][axis]; };
  const AxisLimits& limits = plan_.limits()[axis];
  // A position is known to a few roundings of its size and, through the fitted inverse, to a share of a step.
  const double rounding = 64 * std::numeric_limits<double>::epsilon() * sizes_[axis];
  if (count_ >= 3) {
    const double acceleration = std::fabs(at(0) - 2 * at(1) + at(2)) / (tick_s_ * tick_s_);
    const double noise = rounding / (tick_s_ * tick_s_) + 2e-6 * limits.max_velocity() / tick_s_;
    acceleration_share_ = std::max(acceleration_share_, (acceleration - noise) / limits.stop_acceleration());
    if (acceleration > limits.stop_acceleration() * (1 + 1e-6) + noise) {
      complain(fmt::format("acceleration of axis {} is {}, {} is allowed", axis, acceleration,
                           limits.stop_acceleration()),
               playhead);
    }
  }
  if (count_ >= 4 && limits.stop_jerk()) {
    const double cube = tick_s_ * tick_s_ * tick_s_;
    const double jerk = std::fabs(at(0) - 3 * at(1) + 3 * at(2) - at(3)) / cube;
    const double noise = rounding / cube + 4e-6 * limits.max_velocity() / (tick_s_ * tick_s_);
    if (is_across_step()) {
      if (jerk > *limits.stop_jerk() + noise) ++excused_;
      return;
    }
    jerk_share_ = std::max(jerk_share_, (jerk - noise) / *limits.stop_jerk());
    if (jerk > *limits.stop_jerk() * (1 + 1e-6) + noise) {
      complain(fmt::format("jerk of axis {} is {}, {} is allowed", axis, jerk, *limits.stop_jerk()),
               playhead);
    }
  }
}

}  // namespace inbetween
