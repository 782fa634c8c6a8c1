#include "host_tools/check/check_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace inbetween {
namespace {

/// A whole number times frames / whole, rounded to the nearest.
std::int32_t scaled(std::int32_t number, std::int32_t frames, std::int32_t whole) {
  return static_cast<std::int32_t>((2 * static_cast<std::int64_t>(number) * frames + whole) /
                                   (2 * static_cast<std::int64_t>(whole)));
}

/// By how much the time has to grow (or may shrink, below 1) for every peak to be on its limit.
double needed_slowing(const Plan& plan, const CheckReport& report) {
  double slowing = 0;
  const auto take = [&](const CheckedPeak& peak, double power) {
    if (peak.limit) slowing = std::max(slowing, std::pow(peak.share(), 1 / power));
  };
  const auto take_all = [&](const auto& axis) {
    take(axis.velocity, 1);
    take(axis.acceleration, 2);
    take(axis.jerk, 3);
  };
  for (const CheckedAxis& axis : report.axes) take_all(axis);
  for (const CheckedMotor& motor : report.motors) take_all(motor);
  for (const CheckedStep& step : report.steps) {
    const RigAxis& axis = plan.rig()->axes[step.axis];
    if (!axis.max_jerk || !axis.max_acceleration_step) continue;
    take({.value = step.acceleration, .frame = step.frame, .limit = axis.max_acceleration_step}, 2);
  }
  return slowing;
}

class FrameSearch {
 public:
  FrameSearch(const Plan& plan, const CheckReport& report,
              const std::function<void(double, std::int32_t)>& progress, const std::function<bool()>& is_over)
      : plan_(plan), report_(report), progress_(progress), is_over_(is_over) {}

  SmallestFrames run() {
    const double guess = std::ceil(plan_.move().frames * needed_slowing(plan_, report_));
    const auto first = static_cast<std::int32_t>(std::clamp(guess, 1.0, static_cast<double>(max_frames)));
    std::int32_t refused = 0;
    std::int32_t fitting = 0;
    if (fits(first)) {
      fitting = first;
      for (std::int32_t step = 1; fitting > 1; step *= 2) {
        const std::int32_t next = std::max(first - step, 1);
        if (!fits(next)) {
          refused = next;
          break;
        }
        fitting = next;
      }
    } else {
      refused = first;
      for (std::int32_t step = 1; fitting == 0; step *= 2) {
        if (refused == max_frames) return {std::nullopt, too_slow()};
        const std::int32_t next = first > max_frames - step ? max_frames : first + step;
        (fits(next) ? fitting : refused) = next;
      }
    }
    while (fitting - refused > 1) {
      const std::int32_t middle = refused + (fitting - refused) / 2;
      (fits(middle) ? fitting : refused) = middle;
    }
    if (was_ended_) return {std::nullopt, "the search for the frames that would do was ended", true};
    return {fitting, ""};
  }

 private:
  /// Anything goes once the search was ended: it then tries nothing more.
  bool fits(std::int32_t frames) {
    was_ended_ = was_ended_ || (is_over_ && is_over_());
    if (was_ended_) return true;
    if (progress_) progress_(1 - std::pow(0.9, tried_++), frames);
    if (frames == plan_.move().frames) return report_.fits();
    try {
      const CheckReport report = check_until_refused(
          Plan(with_frames(plan_.move(), frames), plan_.rig(), {.kinematics = plan_.kinematics()}));
      if (!report.fits()) last_refusal_ = report.refusals.front().message;
      return report.fits();
    } catch (const InputError& error) {  // two keys on one frame, a lock that cannot be met, too many ticks
      last_refusal_ = error.message();
      return false;
    }
  }
  [[nodiscard]] std::string too_slow() const {
    return fmt::format("it does not fit in {} frames either, and more are not allowed: {}", max_frames,
                       last_refusal_);
  }

  const Plan& plan_;
  const CheckReport& report_;
  const std::function<void(double, std::int32_t)>& progress_;
  const std::function<bool()>& is_over_;
  bool was_ended_ = false;
  int tried_ = 0;
  std::string last_refusal_;
};

}  // namespace

MoveFile with_frames(const MoveFile& move, std::int32_t frames) {
  MoveFile other = move;
  other.frames = frames;
  for (MoveTrack& track : other.tracks) {
    for (MoveKey& key : track.keys) {
      if (key.frame) key.frame = scaled(*key.frame, frames, move.frames);
      if (key.hold) key.hold = std::max(scaled(*key.hold, frames, move.frames), 1);
    }
    for (std::optional<EaseWish>* ease : {&track.ease_in, &track.ease_out}) {
      if (*ease && (*ease)->frames > 0)
        (*ease)->frames = std::max(scaled((*ease)->frames, frames, move.frames), 1);
    }
  }
  for (MoveCue& cue : other.cues) {
    for (std::int32_t& frame : cue.frames) frame = scaled(frame, frames, move.frames);
  }
  return other;
}

SmallestFrames smallest_frames(const Plan& plan, const CheckReport& report,
                               const std::function<void(double share, std::int32_t frames)>& progress,
                               const std::function<bool()>& is_over) {
  for (const CheckRefusal& refusal : report.refusals) {
    if (!refusal.slower_helps) return {std::nullopt, refusal.message};
  }
  return FrameSearch(plan, report, progress, is_over).run();
}

}  // namespace inbetween
