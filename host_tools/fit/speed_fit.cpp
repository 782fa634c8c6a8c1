#include "host_tools/fit/speed_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "host_tools/fit/fitted_track.hpp"
#include "host_tools/fit/lock_reach.hpp"
#include "host_tools/fit/speed_descent.hpp"
#include "host_tools/fit/speed_start.hpp"
#include "host_tools/move_model/speed_rewrite.hpp"

namespace inbetween {
namespace {

/// The margin below every limit at first, as a share of it. It covers what check() adds to the truth and what
/// the samples miss. The margins that count are measured afterwards: a smaller one costs trials, a larger one
/// begins further from the drawn curve.
constexpr double first_margin = 0.006;
/// The margin is larger by this than the excess of check() over the samples that was measured. It triples
/// with each curve that check() refuses, so that a smaller one costs trials.
constexpr double spare_margin = 2e-5;
/// A curve of few values keeps only this margin beyond that excess. A descent exceeds a limit by less, and so
/// check() passes what the descent has reached. SpeedFit.OfFewValuesUsesTheLimitsUpToWhatIsProven wants a
/// curve that is found with hardly any margin.
constexpr double min_spare = 4 * descent_tolerance;
/// The margin of such a curve grows by this where no peak says how much is missing: in max_rounds by twice
/// first_margin.
constexpr double usual_margin = 0.001;
/// The margins are measured and tried again this often. The last of them has spared 3^7 spare_margin, seven
/// times first_margin: what is refused then is refused for something else.
constexpr int max_trials = 8;
/// A curve of more values may have this many times as many, which are two doublings: it has them because of
/// its locks, and the room for a change is between them.
constexpr std::size_t max_growth = 4;
/// Each doubling of the control values gains this share of the gain before, unless the levels show more: of
/// two levels nobody knows yet how the gains fall.
constexpr double usual_gain_ratio = 0.5;
/// The search ends where a geometric series of more doublings would leave more than this share of the excess.
/// It is an estimate, and so a small rest may be none: a smaller share would give up curves that there are, a
/// larger one descends at every level in vain.
constexpr double hopeless_share = 0.2;
/// Nobody knows how many steps a search takes: each is shown as this much less than what was left. So the bar
/// moves with every step and never gets to its end: SpeedFit.ProgressNeverFallsAndEndsBelowOne.
constexpr double share_left_by_step = 0.98;
/// A detour is gone on with unless it is further away by this factor than what was found: so much a smaller
/// margin hardly gains. Of 200 random moves none lost by it, and a fit of 10 000 keys takes a fifth less
/// time.
constexpr double detour_reach = 1.05;
/// A curve with this many values or fewer is cheap enough to be brought nearer by smaller margins: each round
/// is a descent and a proof. SpeedFit.OfFewValuesUsesTheLimitsUpToWhatIsProven has 23 values.
constexpr std::size_t max_values_tried_again = 64;
/// It is brought nearer at most this often. The excess of check() over the truth differs from curve to curve,
/// and so the gains need not fall.
constexpr int max_rounds = 12;
/// It is brought nearer as long as it gains this share of its change. A descent stops at such a gain itself.
constexpr double min_gain_of_round = 1e-4;
/// The curve leans on a limit if it uses this share of the allowance. The margin is measured only there:
/// elsewhere the peak of check() may be another one than that of the samples.
constexpr double leaning_share = 0.97;

/// The peaks in the order of LimitedQuantity.
constexpr std::array<CheckedPeak CheckedAxis::*, 3> peaks_of_axis = {
    &CheckedAxis::velocity, &CheckedAxis::acceleration, &CheckedAxis::jerk};

/// New values less those of the played curve, refined to as many.
std::vector<double> difference_from_played(const FittedTrack& fitted, const std::vector<double>& values) {
  std::vector<double> difference = fitted.solved().control_values();
  while (difference.size() < values.size()) difference = refined(difference, fitted.ends());
  std::ranges::transform(values, difference, difference.begin(), std::minus());
  return difference;
}

/// The search for one track.
class TrackSearch {
 public:
  using Found = std::optional<std::vector<double>>;

  TrackSearch(const FittedTrack& fitted, FitOptions options)
      : fitted_(fitted), options_(std::move(options)) {}

  /// The new values, or none and why.
  Found run() {
    std::vector<double> baseline = fitted_.solved().control_values();
    const bool is_small = baseline.size() <= max_values_tried_again;
    const std::size_t max_values =
        std::min(std::max(max_refined_values, max_growth * baseline.size()), max_control_values);
    std::vector<Level> levels;
    for (int refinements = 0; refinements <= options_.refinements && !options_.ends(); ++refinements) {
      if (refinements > 0) baseline = refined(baseline, fitted_.ends());
      if (refinements > 0 && baseline.size() > max_values) break;
      Level level{.baseline = baseline, .refinements = refinements};
      try {
        if (Found found = from_drawn(level, levels)) return nearer(std::move(found));
      } catch (const std::invalid_argument& error) {  // more values may give the room that is missing
        reason_ = error.what();
        continue;
      }
      if (refinements == 0 && options_.start == FitStart::either) take_detour();
      if (detour_ && !is_small) break;
      levels.push_back(level);
      if (is_hopeless(levels)) break;
    }
    return nearer(detour_ && !is_small ? std::nullopt : from_elsewhere(levels));
  }
  [[nodiscard]] const std::string& reason() const { return reason_; }
  /// Where the search began that found the curve.
  [[nodiscard]] FitStart start() const { return found_from_; }

 private:
  /// The nearest curve that was found and passes.
  struct Best {
    std::vector<double> values;
    double change = 0;
  };
  /// One number of control values.
  struct Level {
    std::vector<double> baseline;
    int refinements = 0;
    std::vector<double> nearest = {};  ///< the curve reached there that exceeds the limits least
    double excess = std::numeric_limits<double>::infinity();
  };
  /// The tools of a search at one level.
  struct Tools {
    CurveFrame frame;
    SpeedDescent descent;
    MotionSamples samples;
  };

  /// The excess falls about as a geometric series does while the values are doubled again and again. Tells
  /// whether the end of this series is above 0.
  [[nodiscard]] static bool is_hopeless(const std::vector<Level>& levels) {
    if (levels.size() < 2) return false;
    const double last = levels.back().excess;
    const double gain = levels[levels.size() - 2].excess - last;
    const double gain_before = levels.size() > 2
                                   ? levels[levels.size() - 3].excess - levels[levels.size() - 2].excess
                                   : std::numeric_limits<double>::infinity();
    const double ratio = std::clamp(gain / gain_before, usual_gain_ratio, 0.95);
    return last - gain * ratio / (1 - ratio) > hopeless_share * last;
  }

  [[nodiscard]] std::vector<double> curved(const Level& level, const CurveFrame& frame) const {
    return curvature_start(fitted_.track(), fitted_.axes(), request(level, frame));
  }
  [[nodiscard]] static StartRequest request(const Level& level, const CurveFrame& frame) {
    return {
        .values = level.baseline, .rests = frame.rests, .refinements = level.refinements, .ends = frame.ends};
  }
  [[nodiscard]] Tools tools(const Level& level) const {
    CurveFrame frame = fitted_.frame_of(level.baseline);
    if (options_.start == FitStart::curvature)
      frame.wanted = SpeedDescent(frame).nearest(curved(level, frame));
    return {frame, SpeedDescent(frame),
            MotionSamples(fitted_.track(), fitted_.axes(), level.refinements, fitted_.end_steps(),
                          fitted_.ends())};
  }

  Found from_drawn(Level& level, const std::vector<Level>& before) {
    Tools with = tools(level);
    if (Found found = from(with.descent.nearest(with.frame.wanted), with, level)) return found;
    const bool follows = !before.empty() && before.back().refinements + 1 == level.refinements;
    if (!follows || before.back().nearest.empty()) return std::nullopt;
    return from(with.descent.nearest(refined(before.back().nearest, fitted_.ends())), with, level);
  }

  /// Searches from a curve that follows the curvature.
  void take_detour() {
    FitOptions options = options_;
    options.start = FitStart::curvature;
    detour_ = std::make_unique<TrackSearch>(fitted_, std::move(options));
    detour_->is_detour_ = true;
    if (!detour_->run()) detour_.reset();
  }
  /// From such a curve towards the drawn one, with as many values.
  [[nodiscard]] Found back_from(const std::vector<double>& curve) {
    if (options_.ends()) return std::nullopt;
    Level level{.baseline = fitted_.solved().control_values()};
    for (; level.baseline.size() < curve.size(); ++level.refinements) {
      level.baseline = refined(level.baseline, fitted_.ends());
    }
    Tools with = tools(level);
    return from(curve, with, level);
  }

  /// The one that was found, or the detour if that is nearer. If none was found, the detour or what is found
  /// from there.
  Found nearer(Found found) {
    found_from_ = options_.start == FitStart::curvature ? FitStart::curvature : FitStart::drawn;
    if (!detour_) return found;
    auto& [best, with] = *detour_->draft_;
    if (found && change_of(best.values) > detour_reach * change_of(*found)) return found;
    const std::vector<double> detour = detour_->nearest_within(std::move(best), with);
    const bool comes_back = !found;
    if (comes_back) found = back_from(detour);
    const bool is_detour = !found || change_of(detour) < change_of(*found);
    if (is_detour || comes_back) found_from_ = FitStart::curvature;
    return is_detour ? detour : std::move(found);
  }
  [[nodiscard]] double change_of(const std::vector<double>& values) const {
    return mean_square(difference_from_played(fitted_, values), fitted_.ends());
  }

  Found from_elsewhere(std::vector<Level>& levels) {
    for (Level& level : levels) {
      if (level.refinements == 0 && levels.size() > 1) continue;
      if (options_.ends()) break;
      Tools with = tools(level);
      if (Found found = from(with.descent.nearest(curved(level, with.frame)), with, level)) return found;
      if (Found found = from(with.descent.nearest(flat_start(request(level, with.frame))), with, level))
        return found;
      break;
    }
    return std::nullopt;
  }

  Found from(const std::vector<double>& start, Tools& with, Level& level) {
    std::vector<Allowance> allowances = allowances_below(first_margin);
    Descent reached = with.descent.run(start, with.samples, allowances, options_.is_over);
    Best best;
    double spare = spare_margin;
    for (int trial = 0; trial < max_trials; ++trial) {
      if (reached.excess.share > first_margin) break;
      const std::optional<CheckReport> report = fitted_.judge(reached.values, reason_);
      if (!report) return std::nullopt;
      if (report->fits()) {
        const bool is_first = best.values.empty();
        const bool gains = is_first || reached.change < 0.998 * best.change;
        if (is_first || reached.change < best.change) best = {reached.values, reached.change};
        if (!gains || options_.ends()) break;
      } else if (best.values.empty()) {
        reason_ = report->refusals.front().message();
      }
      if (!report->fits()) spare *= 3;
      std::vector<Allowance> measured = allowances;
      measure_margins(*report, spare, with.samples, measured);
      if (!report->fits()) add_peaks(*report, ControlCurve(reached.values, fitted_.ends()), with.samples);
      for (std::size_t d = 0; d < allowances.size(); ++d) {
        for (std::size_t q = 0; q < limited_quantities; ++q) {
          // Before a curve has passed, nothing is allowed again that has failed.
          const bool lowers = measured[d][q] < allowances[d][q] || !best.values.empty();
          if (lowers) allowances[d][q] = measured[d][q];
        }
      }
      reached = with.descent.run(reached.values, with.samples, allowances, options_.is_over);
    }
    if (is_detour_ && !best.values.empty())
      return draft_.emplace(std::move(best), std::move(with)).first.values;
    if (!best.values.empty()) return nearest_within(std::move(best), with);
    if (reached.excess.share < level.excess) {
      level.excess = reached.excess.share;
      level.nearest = reached.values;
      if (options_.ends()) return std::nullopt;
      if (const std::optional<CheckReport> report = fitted_.judge(level.nearest, reason_)) {
        if (!report->fits()) reason_ = report->refusals.front().message();
      }
    }
    return std::nullopt;
  }

  /// The nearest of `best` and of curves that begin with hardly any margin. The excess of check() over the
  /// truth differs from curve to curve, and may be 0.
  [[nodiscard]] std::vector<double> nearest_within(Best best, Tools& with) const {
    if (best.values.size() > max_values_tried_again) return best.values;
    std::vector<Allowance> allowances = allowances_below(min_spare);
    std::vector<double> values = best.values;
    for (int round = 0; round < max_rounds && !options_.ends(); ++round) {
      Descent reached = with.descent.run(values, with.samples, allowances, options_.is_over);
      values = std::move(reached.values);
      std::string trouble;
      const std::optional<CheckReport> report = fitted_.judge(values, trouble);
      if (!report) break;
      if (report->fits()) {
        const double gain = 1 - reached.change / best.change;
        if (gain > 0) best = {values, reached.change};
        if (gain < min_gain_of_round) break;
      }
      adjust(*report, with.samples, allowances);
      add_peaks(*report, ControlCurve(values, fitted_.ends()), with.samples);
    }
    return best.values;
  }
  /// One margin below every limit.
  [[nodiscard]] std::vector<Allowance> allowances_below(double margin) const {
    Allowance allowance;
    allowance.fill(1 / (1 + margin));
    return std::vector(fitted_.axes().size(), allowance);
  }
  /// Allows less of the peaks that check() refuses, and of everything where it refuses something else. Where
  /// it refuses nothing, what leans on a limit is allowed what check() leaves of it. `report` and the samples
  /// are of one curve.
  void adjust(const CheckReport& report, const MotionSamples& samples,
              std::vector<Allowance>& allowances) const {
    const std::vector<Allowance> sampled = samples.peaks();
    bool has_peaks = false;
    for (std::size_t d = 0; d < allowances.size(); ++d) {
      const CheckedAxis& axis = report.axes[fitted_.rig_axis(d)];
      for (std::size_t q = 0; q < peaks_of_axis.size(); ++q) {
        const CheckedPeak& peak = axis.*peaks_of_axis[q];
        double& allowance = allowances[d][q];
        const bool leans = report.fits() && sampled[d][q] > leaning_share * allowance;
        if (peak.limit && (peak.is_exceeded() || leans))
          allowance = std::min(allowance / (peak.share() + min_spare), 1 / (1 + min_spare));
        has_peaks = has_peaks || peak.is_exceeded();
      }
    }
    if (report.fits() || has_peaks) return;
    for (Allowance& allowance : allowances) {
      for (double& share : allowance) share /= 1 + usual_margin;
    }
  }

  /// Sets every allowance so that check() stays below the limit. `report` and the samples are of one curve.
  void measure_margins(const CheckReport& report, double spare, const MotionSamples& samples,
                       std::vector<Allowance>& allowances) const {
    const std::vector<Allowance> sampled = samples.peaks();
    for (std::size_t d = 0; d < allowances.size(); ++d) {
      const CheckedAxis& axis = report.axes[fitted_.rig_axis(d)];
      for (std::size_t q = 0; q < peaks_of_axis.size(); ++q) {
        const CheckedPeak& peak = axis.*peaks_of_axis[q];
        if (!peak.limit || !(sampled[d][q] > leaning_share * allowances[d][q])) continue;
        // A peak on a roll says nothing about the samples.
        const bool is_inside = peak.frame >= 0 && peak.frame <= fitted_.frames();
        const double ratio = is_inside ? peak.share() / sampled[d][q] : 1 + first_margin;
        allowances[d][q] = 1 / (std::max(ratio, 1.0) + spare);
      }
      allowances[d][static_cast<std::size_t>(LimitedQuantity::acceleration_step)] = 1 / (1 + spare);
    }
  }

  /// Adds the moments at which check() saw a limit exceeded.
  void add_peaks(const CheckReport& report, const ControlCurve& curve, MotionSamples& samples) const {
    for (std::size_t d = 0; d < fitted_.axes().size(); ++d) {
      for (const auto quantity : peaks_of_axis) {
        const CheckedPeak& peak = report.axes[fitted_.rig_axis(d)].*quantity;
        const bool is_inside = peak.frame >= 0 && peak.frame <= fitted_.frames();
        if (peak.is_exceeded() && is_inside) samples.add_moment(peak.frame, curve);
      }
    }
  }

  const FittedTrack& fitted_;
  FitOptions options_;
  std::string reason_;
  std::unique_ptr<TrackSearch> detour_;  ///< one that has found a curve
  bool is_detour_ = false;
  std::optional<std::pair<Best, Tools>> draft_;  ///< what a detour finds, and how it goes on to the nearest
  FitStart found_from_ = FitStart::drawn;
};

std::string_view limits_in_words(bool by_acceleration) {
  return by_acceleration ? "max_velocity and max_acceleration" : "max_velocity";
}

/// The reason why a search is of no use; empty if it may be of use.
std::string hopeless(const FittedTrack& fitted) {
  const MoveTrack& file = fitted.file();
  if (file.timing == Timing::frames) {
    return "the track has timing = \"frames\" and no speed curve to change; give its keys other frames, or "
           "time it by speed";
  }
  for (const CheckRefusal& refusal : fitted.report().refusals) {
    if (!refusal.slower_helps) return refusal.message();
  }
  for (const KeyLock& lock :
       fitted.solved().key_timing() ? fitted.solved().key_timing()->locks : std::span<const KeyLock>()) {
    if (lock.key == 0 || lock.hold == 0 || file.keys[static_cast<std::size_t>(lock.key)].frame) continue;
    return fmt::format(
        "the hold of key {} has no frame, and where it begins would follow from the new curve; give the key "
        "frame = {}, where it is now",
        lock.key, lock.frame);
  }
  return "";
}

/// Why no speed curve can fit.
std::string in_words(const ShortStretch& stretch, const FittedTrack& fitted) {
  return fmt::format(
      "between key {} on frame {} and key {} on frame {} the path takes at least {} frames, whatever the "
      "speed curve, because of {} of axis {}; give these keys frames further apart, or the move more frames",
      stretch.begin_key, stretch.begin_frame, stretch.end_key, stretch.end_frame,
      told_apart(stretch.needed, stretch.end_frame - stretch.begin_frame, Digits::decimals, 1).first,
      limits_in_words(stretch.by_acceleration), in_quotes(fitted.played().rig()->axes[stretch.axis].name));
}

std::string in_words(const UnreachedLock& lock, const FittedTrack& fitted) {
  return fmt::format(
      "coming from key {} on frame {}, key {} cannot be met on frame {}, whatever the speed curve, because "
      "of the limits of axis {}; make the frames of these keys and of those between them more even, or give "
      "the move more frames",
      lock.begin_key, lock.begin_frame, lock.end_key, lock.end_frame,
      in_quotes(fitted.played().rig()->axes[lock.axis].name));
}

TrackFit described(const FittedTrack& fitted, std::size_t index, std::vector<double> values) {
  const std::vector<double>& played = fitted.solved().control_values();
  int refinements = 0;
  while (((played.size() - 1) << refinements) + 1 < values.size()) ++refinements;
  const std::vector<double> difference = difference_from_played(fitted, values);
  const ControlCurve change(difference, fitted.ends());
  const ControlCurve::Largest largest = change.largest();
  const auto f = static_cast<double>(values.size() - 1);
  TrackFit fit{.track = index, .speed = std::move(values), .refinements = refinements};
  fit.change = std::sqrt(mean_square(difference, fitted.ends()));
  fit.change_share = fit.change / ControlCurve(played, fitted.ends()).mean();
  fit.largest_change = change.at(place_at(largest.a, change.span_count())).value;
  fit.largest_change_at = largest.a;
  fit.largest_change_frame = largest.a * fitted.frames() / f;
  return fit;
}

/// The first reason why the whole move with the new curves does not fit; nothing if it fits.
std::optional<std::string> refusal_of(const Plan& plan, const std::vector<TrackFit>& tracks) {
  MoveFile move = plan.move();
  for (const TrackFit& fit : tracks) replace_curve(move.tracks[fit.track], fit.speed);
  const CheckReport report = check(Plan(std::move(move), plan));
  if (report.fits()) return std::nullopt;
  return report.refusals.front().message();
}

}  // namespace

SpeedFit fit_speed(const Plan& plan, const CheckReport& report, const FitOptions& options) {
  SpeedFit fit;
  fit.fewest = fewest_frames(plan);
  if (report.fits()) {
    fit.found = true;
    return fit;
  }
  const auto give_up = [&](std::string reason) {
    fit.tracks.clear();
    fit.reason = std::move(reason);
    return fit;
  };
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    const MoveTrack& track = plan.move().tracks[t];
    if (track.timing == Timing::frames || plan.tracks()[t].track().has_profile()) continue;
    return give_up(
        fmt::format("{} looks at a link that another track moves, and what it needs follows from both; "
                    "give the move more frames, or draw the curves flatter",
                    in_quotes(track.space->tips.front())));
  }
  const auto count = static_cast<double>(plan.tracks().size());
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    const FittedTrack fitted(plan, report, t);
    if (fitted.report().fits()) continue;
    if (std::string reason = hopeless(fitted); !reason.empty()) return give_up(std::move(reason));
    if (const FewestFrames fewest = fewest_frames(fitted.played()); fewest.frames > fitted.frames()) {
      return give_up(
          fmt::format("the path takes at least {}, whatever the speed curve, because of {} of axis {}; "
                      "give the move more frames",
                      counted(fewest.frames, "frame"), limits_in_words(fewest.by_acceleration),
                      in_quotes(plan.rig()->axes[fewest.axis].name)));
    }
    if (const std::optional<ShortStretch> stretch = shortest_stretch(fitted.played(), 0))
      return give_up(in_words(*stretch, fitted));
    if (const std::optional<UnreachedLock> lock = unreached_lock(fitted.played(), 0))
      return give_up(in_words(*lock, fitted));
    refuse_too_many_values(plan.move(), t, fitted.solved().control_values().size());
    FitOptions of_track = options;
    double left = 1;
    of_track.is_over = [&] {
      left *= share_left_by_step;
      if (options.progress) options.progress((static_cast<double>(t) + 1 - left) / count);
      return options.ends();
    };
    TrackSearch search(fitted, of_track);
    std::optional<std::vector<double>> values = search.run();
    FitStart start = search.start();
    if (!values && !options.ends()) {
      if (const std::optional<Plan> shared_out = with_eases_shared_out(fitted)) {
        const FittedTrack eased(*shared_out, check(*shared_out), 0);
        TrackSearch other(eased, of_track);
        values = other.run();
        start = other.start();
      }
    }
    fit.was_ended = options.ends();
    if (!values && fit.was_ended) {
      return give_up("the search was ended before one was found that keeps every limit");
    }
    if (!values) {
      return give_up("no speed curve was found that keeps every limit; with the nearest one " +
                     search.reason());
    }
    fit.tracks.push_back(described(fitted, t, std::move(*values)));
    fit.tracks.back().start = start;
  }
  if (std::optional<std::string> reason = refusal_of(plan, fit.tracks)) return give_up(std::move(*reason));
  fit.found = true;
  return fit;
}

}  // namespace inbetween
