#include "host_tools/check/check_frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "host_tools/check/planned_stops.hpp"

namespace inbetween {
namespace {

/// A slowing that is above 1 by more than the rounding of a motion.
constexpr double clearly_beyond = 1 + 1e-6;
/// Where locked frames are rounded anew the peak is elsewhere, and so much higher: moments that are nearer to
/// a limit are not believed.
constexpr double misleading = 1.01;
/// The search follows the guesses so often that a number which was tried gives for the next.
constexpr int max_guesses = 4;

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

/// The slowing that single moments show to be needed: those of the peaks of another report, `scale` times as
/// late. 0 where none of them lies on a track.
double slowing_at_peaks_of(const CheckReport& other, double scale, const Plan& plan) {
  double slowing = 0;
  std::vector<AxisMotion> motion;
  const auto look = [&](const Track& track, const PlanAxis& axis, const CheckedPeak& peak,
                        double AxisMotion::*quantity, double power) {
    const double frame = peak.frame * scale;
    if (!peak.limit || !(frame >= 0 && frame < track.frames())) return;
    const auto whole = static_cast<std::int32_t>(frame);
    static_cast<void>(track.motion({whole, frame - whole}, motion));
    const double share = std::fabs(motion[axis.track_axis].*quantity) / *peak.limit;
    slowing = std::max(slowing, std::pow(share, 1 / power));
  };
  for (std::size_t a = 0; a < plan.axes().size(); ++a) {
    const PlanAxis& axis = plan.axes()[a];
    if (!axis.track) continue;
    const Track& track = plan.tracks()[*axis.track].track();
    motion.resize(static_cast<std::size_t>(track.path().axis_count()));
    const CheckedAxis& checked = other.axes[a];
    look(track, axis, checked.velocity, &AxisMotion::velocity, 1);
    look(track, axis, checked.acceleration, &AxisMotion::acceleration, 2);
    look(track, axis, checked.jerk, &AxisMotion::jerk, 3);
  }
  return slowing;
}

class FrameSearch {
 public:
  FrameSearch(const Plan& plan, const CheckReport& report,
              const std::function<void(double, std::int32_t)>& progress, const std::function<bool()>& is_over)
      : plan_(plan), report_(report), progress_(progress), is_over_(is_over) {}

  /// What is slower can be stopped wherever what is faster can, but for the rounding of locked frames. So
  /// stops are proven of the answer alone, and of every number that fits where the answer does not keep them.
  SmallestFrames run() {
    SmallestFrames found = search();
    if (!found.frames || !fitting_ || !PlannedStops(fitting_->plan, fitting_->bounded).obstacle())
      return found;
    proves_stops_ = true;
    return search();
  }

 private:
  SmallestFrames search() {
    std::int32_t refused = 0;
    std::int32_t fitting = 0;  // none yet
    std::int32_t next = first_guess();
    std::int32_t step = 0;  // none yet
    int guesses = max_guesses;
    proven_ = 0;
    believes_moments_ = !proves_stops_;
    while (fitting == 0 || fitting - refused > 1 || fitting != proven_) {
      const bool is_found = fitting > 0 && fitting - refused == 1;
      const std::int32_t here = is_found ? fitting : next;
      if (is_found) believes_moments_ = false;
      const bool is_guess = here == guess_;  // it is checked, because its bounds make the next guess
      (fits(here, believes_moments_ && proven_ > 0 && !is_guess) ? fitting : refused) = here;
      if (was_ended_) return {std::nullopt, "the search for the frames that would do was ended", true};
      if (refused == fitting) fitting = proven_;  // the moments have misled
      if (refused == max_frames) return {std::nullopt, too_slow()};
      const bool guesses_further = guesses > 0 && guess_ > refused && (fitting == 0 || guess_ < fitting) &&
                                   std::abs(guess_ - here) > 1;
      // A guess that fits and yet is not its own: the rounding of locked frames decides, and no more is
      // guessed.
      if (guesses_further && is_guess && here == fitting) {
        guesses = 0;
        step = max_frames;
      } else if (guesses_further) {
        next = guess_;
        step = 0;
        --guesses;
        continue;
      }
      // Away from a guess in steps that double, the first as long as this number is from its own guess; then
      // to the middle of what is left: at once where this number asks for more than one that fits.
      if (step == 0) step = guess_ > 0 ? std::max(std::abs(guess_ - here), 1) : 1;
      if (here == refused && fitting > 0 && guess_ > fitting) step = max_frames;
      const std::int32_t most = fitting > 0 ? std::max((fitting - refused) / 2, 1) : max_frames - refused;
      next = here == refused ? refused + std::min(step, most) : fitting - std::min(step, most);
      step = std::min(2 * step, max_frames);
    }
    return {fitting, ""};
  }

  [[nodiscard]] std::int32_t first_guess() {
    const double needed = needed_slowing(plan_, report_);
    bounds_over_moments_ = needed / slowing_at_peaks_of(report_, 1, plan_);
    return frames_for(needed, plan_.move().frames);
  }
  [[nodiscard]] static std::int32_t frames_for(double slowing, std::int32_t frames) {
    return static_cast<std::int32_t>(
        std::clamp(std::ceil(frames * slowing), 1.0, static_cast<double>(max_frames)));
  }

  /// Anything goes once the search was ended: it then tries nothing more. With `believes` moments may speak
  /// for a number as well as against it.
  bool fits(std::int32_t frames, bool believes) {
    was_ended_ = was_ended_ || (is_over_ && is_over_());
    if (was_ended_) return true;
    if (progress_) progress_(1 - std::pow(0.9, tried_++), frames);
    guess_ = 0;
    if (frames == plan_.move().frames) {
      guess_ = frames_for(needed_slowing(plan_, report_), frames);
      if (!report_.fits()) return false;
      fitting_.reset();
      proven_ = frames;
      return true;
    }
    try {
      Plan plan(with_frames(plan_.move(), frames), plan_);
      // No proof is needed that a move breaks a limit where one moment of it does.
      const double scale = static_cast<double>(frames) / (nearest_ ? nearest_frames_ : plan_.move().frames);
      const double slowing = slowing_at_peaks_of(nearest_ ? *nearest_ : report_, scale, plan);
      const bool is_last = frames == max_frames;  // whose refusal is told
      if (slowing > clearly_beyond && !is_last) {
        guess_ = frames_for(slowing, frames);
        return false;
      }
      if (believes && slowing > 0 && slowing * bounds_over_moments_ * misleading < 1) return true;
      BoundedMove bounded = bounded_move(plan, 1, BoundedFor::stops);
      nearest_ = proves_stops_ ? check_until_refused(plan, bounded) : check_motion(plan, bounded);
      nearest_frames_ = frames;
      const double needed = needed_slowing(plan, *nearest_);
      guess_ = frames_for(needed, frames);
      bounds_over_moments_ = needed / slowing_at_peaks_of(*nearest_, 1, plan);
      if (nearest_->fits()) {
        fitting_.emplace(Fitting{std::move(plan), std::move(bounded)});
        proven_ = frames;
      } else {
        last_refusal_ = nearest_->refusals.front().message();
      }
      return nearest_->fits();
    } catch (const InputError& error) {  // two keys on one frame, a lock that cannot be met, too many ticks
      last_refusal_ = error.message();
      return false;
    }
  }
  [[nodiscard]] std::string too_slow() const {
    return fmt::format("it does not fit in {} frames either, and more are not allowed: {}", max_frames,
                       last_refusal_);
  }

  /// Stops are proven of it in the end, from the same fit.
  struct Fitting {
    Plan plan;
    BoundedMove bounded;
  };

  const Plan& plan_;
  const CheckReport& report_;
  const std::function<void(double, std::int32_t)>& progress_;
  const std::function<bool()>& is_over_;
  bool proves_stops_ = false;
  /// A check takes three times as long as a plan. Therefore a number below one that is proven to fit is taken
  /// to fit if the last peaks, as moments of its plan, do: its bounds are expected as far above them as
  /// theirs were. Only the answer is checked. If it does not fit, the moments have misled, and no more are
  /// believed.
  bool believes_moments_ = true;
  std::int32_t proven_ = 0;             ///< the last number that was checked as a whole and fits
  std::optional<Fitting> fitting_;      ///< of the last number that fits, unless it is that of the move
  std::optional<CheckReport> nearest_;  ///< of the last number that was checked as a whole
  std::int32_t nearest_frames_ = 0;
  double bounds_over_moments_ = 0;  ///< the slowing that its bounds need, over that of its peaks as moments
  std::int32_t guess_ = 0;          ///< by the peaks of the last number tried; 0 without
  bool was_ended_ = false;
  int tried_ = 0;
  std::string last_refusal_;
};

}  // namespace

std::optional<std::string> why_frames_are_fixed(const MoveFile& move) {
  for (const MoveTrack& track : move.tracks) {
    if (track.network)
      return "the curves of a network are drawn on the frames of the move; draw them on others to try those";
    if (track.table) return "the rows of a table are on the frames of the move; bake others to try those";
  }
  return std::nullopt;
}

MoveFile with_frames(const MoveFile& move, std::int32_t frames) {
  if (const auto why = why_frames_are_fixed(move); why && frames != move.frames)
    throw InputError(move.frames_place, *why);
  MoveFile other = move;
  other.frames = frames;
  for (MoveTrack& track : other.tracks) {
    if (track.overlap) track.overlap = scaled(*track.overlap, frames, move.frames);
    for (MoveKey& key : track.keys) {
      if (key.frame) key.frame = scaled(*key.frame, frames, move.frames);
      if (key.overlap) key.overlap = scaled(*key.overlap, frames, move.frames);
      if (key.hold) key.hold = std::max(scaled(*key.hold, frames, move.frames), 1);
    }
    for (std::optional<EaseRequest>* ease : {&track.ease_in, &track.ease_out}) {
      if (*ease && (*ease)->frames > 0)
        (*ease)->frames = std::max(scaled((*ease)->frames, frames, move.frames), 1);
    }
  }
  for (MoveCue& cue : other.cues) {
    for (std::int32_t& frame : cue.frames) frame = scaled(frame, frames, move.frames);
  }
  return other;
}

std::string in_proportion(const MoveFile& move) {
  bool has_frames = false;
  bool has_holds = false;
  bool has_eases = false;
  for (const MoveTrack& track : move.tracks) {
    for (const MoveKey& key : track.keys) {
      has_frames = has_frames || key.frame.value_or(0) > 0;
      has_holds = has_holds || key.hold.has_value();
    }
    for (const std::optional<EaseRequest>& ease : {track.ease_in, track.ease_out})
      has_eases = has_eases || (ease && ease->frames > 0);
  }
  std::vector<std::string> words;
  if (has_frames || has_holds) {
    words.push_back(fmt::format("the {}{}{} of the keys", has_frames ? "frames" : "",
                                has_frames && has_holds ? " and " : "", has_holds ? "holds" : ""));
  }
  if (has_eases) words.emplace_back("ease_in and ease_out");
  if (std::ranges::any_of(move.tracks, has_overlap)) words.emplace_back("the overlaps");
  const auto has_list = [](const MoveCue& cue) { return !cue.frames.empty(); };
  if (std::ranges::any_of(move.cues, has_list)) words.emplace_back("the frames of the cues");
  return words.empty() ? "" : fmt::format(", with {} in proportion", listed_with_and(words));
}

SmallestFrames smallest_frames(const Plan& plan, const CheckReport& report,
                               const std::function<void(double share, std::int32_t frames)>& progress,
                               const std::function<bool()>& is_over) {
  for (const CheckRefusal& refusal : report.refusals) {
    if (!refusal.slower_helps) return {std::nullopt, refusal.message()};
  }
  if (const auto why = why_frames_are_fixed(plan.move())) return {std::nullopt, *why};
  return FrameSearch(plan, report, progress, is_over).run();
}

}  // namespace inbetween
