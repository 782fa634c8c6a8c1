#include "host_tools/check/check_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "host_tools/check/planned_stops.hpp"

namespace inbetween {
namespace {

/// A share of a limit that is above 1 by more than the rounding of a motion.
constexpr double clearly_beyond = 1 + 1e-6;

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

/// The most that is used of any limit at the frames of the peaks of another report, `scale` times as late.
double share_at_peaks_of(const CheckReport& other, double scale, const Plan& plan) {
  double share = 0;
  std::vector<AxisMotion<double>> motion;
  const auto look = [&](const Track<double>& track, const PlanAxis& axis, const CheckedPeak& peak,
                        double AxisMotion<double>::*quantity) {
    const double frame = peak.frame * scale;
    if (!peak.limit || !(frame >= 0 && frame < track.frames())) return;
    const auto whole = static_cast<std::int32_t>(frame);
    static_cast<void>(track.motion({whole, frame - whole}, motion));
    share = std::max(share, std::fabs(motion[axis.track_axis].*quantity) / *peak.limit);
  };
  for (std::size_t a = 0; a < plan.axes().size(); ++a) {
    const PlanAxis& axis = plan.axes()[a];
    if (!axis.track) continue;
    const Track<double>& track = plan.tracks()[*axis.track].track();
    motion.resize(static_cast<std::size_t>(track.path().axis_count()));
    const CheckedAxis& checked = other.axes[a];
    look(track, axis, checked.velocity, &AxisMotion<double>::velocity);
    look(track, axis, checked.acceleration, &AxisMotion<double>::acceleration);
    look(track, axis, checked.jerk, &AxisMotion<double>::jerk);
  }
  return share;
}

class FrameSearch {
 public:
  FrameSearch(const Plan& plan, const CheckReport& report,
              const std::function<void(double, std::int32_t)>& progress, const std::function<bool()>& is_over)
      : plan_(plan), report_(report), progress_(progress), is_over_(is_over) {}

  /// What is slower can be stopped wherever what is faster can, but for the rounding of locked frames. So
  /// stops are proven of the answer alone, and of every number that fits where the answer does not keep them.
  SmallestFrames run() {
    const SmallestFrames found = search();
    if (!found.frames || !fitting_plan_ || !PlannedStops(*fitting_plan_).obstacle()) return found;
    proves_stops_ = true;
    return search();
  }

 private:
  SmallestFrames search() {
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

  /// Anything goes once the search was ended: it then tries nothing more.
  bool fits(std::int32_t frames) {
    was_ended_ = was_ended_ || (is_over_ && is_over_());
    if (was_ended_) return true;
    if (progress_) progress_(1 - std::pow(0.9, tried_++), frames);
    if (frames == plan_.move().frames) {
      if (report_.fits()) fitting_plan_.reset();
      return report_.fits();
    }
    try {
      Plan plan(with_frames(plan_.move(), frames), plan_);
      // No proof is needed that a move breaks a limit where one moment of it does.
      const double scale = static_cast<double>(frames) / plan_.move().frames;
      const bool is_last = frames == max_frames;  // whose refusal is told
      if (!is_last && share_at_peaks_of(report_, scale, plan) > clearly_beyond) return false;
      const CheckReport report = proves_stops_ ? check_until_refused(plan) : check_motion(plan);
      if (report.fits()) {
        fitting_plan_ = std::move(plan);
      } else {
        last_refusal_ = report.refusals.front().message;
      }
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
  bool proves_stops_ = false;
  std::optional<Plan> fitting_plan_;  ///< of the last number that fits, unless it is that of the move
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
