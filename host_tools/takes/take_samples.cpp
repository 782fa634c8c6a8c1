#include "host_tools/takes/take_samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "host_tools/takes/taken_motion.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

[[noreturn]] void refuse_damaged(const Take& take, const std::string& what) {
  throw std::runtime_error(
      fmt::format("inbetween: error: {} of take {}; the take is damaged", what, take.number));
}

/// Whether drives are told setpoints (MotionLoop::sends_setpoints).
bool answers(SupervisorState state) {
  return state == SupervisorState::running || state == SupervisorState::stopping ||
         state == SupervisorState::ready || state == SupervisorState::latched;
}

/// Where the move was told to be, tick after tick.
class Commands {
 public:
  /// The place that this tick commands; nothing where it commands none of the move.
  std::optional<TakeSample> next(const TakeTick& tick) {
    const bool plays = tick.state == SupervisorState::running || tick.state == SupervisorState::stopping;
    std::optional<TakeSample> here;
    if (tick.time) here = TakeSample{.turn = tick.turn, .time = *tick.time};
    if (!answers(tick.state)) {
      last_.reset();
    } else if (plays || (last_ && here)) {
      last_ = here;  // while it plays without a time something else moves the rig
    }
    return last_;
  }

 private:
  std::optional<TakeSample> last_ = {};
};

}  // namespace

TakeSamples::TakeSamples(const Take& take)
    : number_(take.number), rate_hz_(take.rate_hz), frame_rate_(take.frame_rate), axes_(take.axes) {
  const std::unique_ptr<TakenMotion> taken = TakenMotion::read(take.trajectory);
  if (!taken) refuse_damaged(take, "no motion is");
  const std::size_t played = taken->motion().axis_count();
  const auto is_beyond = [&](const TakeAxis& axis) { return axis.move_axis.value_or(0) >= played; };
  if (std::ranges::any_of(axes_, is_beyond)) refuse_damaged(take, "an axis is beyond the motion");
  take_ticks(take, taken->motion());
}

void TakeSamples::take_ticks(const Take& take, const PlayedMotion& motion) {
  samples_.reserve(take.ticks_of_take.size());
  commanded_.reserve(take.ticks_of_take.size() * axes_.size());
  actual_.reserve(commanded_.capacity());
  std::vector<double> played(motion.axis_count());
  Commands commands;
  std::optional<TakeSample> told;
  std::int64_t before = -1;
  for (const TakeTick& tick : take.ticks_of_take) {
    if (told && tick.number == before + 1 && answers(tick.state)) {
      if (tick.actual.size() != axes_.size()) {
        refuse_damaged(take, fmt::format("tick {} has {} of {}", tick.number,
                                         counted(static_cast<std::int64_t>(tick.actual.size()), "position"),
                                         axes_.size()));
      }
      samples_.push_back({.tick = tick.number, .turn = told->turn, .time = told->time});
      motion.positions(told->time, played);
      actual_.insert(actual_.end(), tick.actual.begin(), tick.actual.end());
      for (std::size_t i = 0; i < axes_.size(); ++i)
        commanded_.push_back(axes_[i].move_axis ? played[*axes_[i].move_axis] : actual_[i]);
    }
    told = commands.next(tick);
    before = tick.number;
  }
}

int TakeSamples::direction(std::size_t sample, std::size_t axis) const {
  if (sample == 0) return 0;
  const double to = commanded(sample)[axis];
  const double step = to - commanded(sample - 1)[axis];
  constexpr double share = 0.01;
  constexpr double rounding = 8 * std::numeric_limits<double>::epsilon();
  if (std::fabs(step) <= std::max(share * axes_[axis].resolution, rounding * std::fabs(to))) return 0;
  return step > 0 ? 1 : -1;
}

bool TakeSamples::rests(std::size_t sample, std::size_t axis) const {
  return sample == 0 ? size() < 2 || direction(1, axis) == 0 : direction(sample, axis) == 0;
}

}  // namespace inbetween
