#include "host_tools/fit/fewest_fit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "host_tools/move_model/speed_rewrite.hpp"

namespace inbetween {
namespace {

/// A check looks for another curve by itself where that is quick, because somebody waits for the verdict.
/// SpeedFit.IsTakenForQuickByItsValuesAndByItsKeysAndAxes has 44 values, which are too many.
constexpr std::size_t quick_control_values = 32;
/// Segments and control values, for each axis: what a step of the search has to keep within limits grows with
/// it. Without this bound 64 axes and three segments took 14 s, 16 axes and eight segments 15 s. The same
/// test has 149 segments of two axes, which are too many.
constexpr std::size_t quick_conditions = 200;

std::optional<FewestFit> fit_in(const Plan& plan, std::int32_t frames, const FitOptions& options) {
  FewestFit found{.move = with_frames(plan.move(), frames), .fit = {}};
  try {
    const Plan other(found.move, plan);
    found.fit = fit_speed(other, check(other), options);
  } catch (const InputError&) {  // two keys on one frame, a lock that cannot be met
    return std::nullopt;
  }
  if (!found.fit.found) return std::nullopt;
  return found;
}

}  // namespace

FewestFit fit_in_fewest_frames(const Plan& plan, const CheckReport& report, const SmallestFrames& smallest,
                               const FitOptions& told,
                               const std::function<void(double, std::int32_t)>& progress) {
  FitOptions options = told;
  options.progress = {};
  const std::int32_t asked = plan.move().frames;
  std::int32_t fitting = smallest.frames.value_or(asked);
  FewestFit best{.move = with_frames(plan.move(), fitting), .fit = {}};
  if (smallest.frames) {
    best.fit.found = true;
    best.fit.fewest = fewest_frames(plan);
  } else {
    best.fit = fit_speed(plan, report, options);
    if (!best.fit.found) return best;
  }
  std::int32_t refused =
      why_frames_are_fixed(plan.move()) ? fitting - 1 : std::min(best.fit.fewest.frames, fitting) - 1;
  const double steps = std::log2(std::max(fitting - refused, 2));
  for (int tried = 0; fitting - refused > 1 && !options.ends(); ++tried) {
    const std::int32_t middle = refused + (fitting - refused) / 2;
    if (progress) progress(tried / steps, middle);
    if (std::optional<FewestFit> found = fit_in(plan, middle, options)) {
      best = std::move(*found);
      fitting = middle;
    } else {
      refused = middle;
    }
  }
  best.fit.was_ended = options.ends();
  return best;
}

std::string with_frames_of(std::string_view text, const std::string& file_name, const MoveFile& move) {
  std::vector<NumberAt> numbers{{move.frames_place, move.frames}};
  for (const MoveTrack& track : move.tracks) {
    for (const MoveKey& key : track.keys) {
      if (key.frame) numbers.push_back({key.frame_place, *key.frame});
      if (key.hold) numbers.push_back({key.hold_place, *key.hold});
    }
    for (const std::optional<EaseRequest>& ease : {track.ease_in, track.ease_out}) {
      if (ease) numbers.push_back({ease->place, ease->frames});
    }
  }
  for (const MoveCue& cue : move.cues) {
    for (std::size_t i = 0; i < cue.frame_places.size(); ++i) {
      numbers.push_back({cue.frame_places[i], cue.frames[i]});
    }
  }
  std::string result = with_numbers(text, std::move(numbers));
  static_cast<void>(parse_move(result, file_name));  // pulses that meet now are refused
  return result;
}

bool is_quick_to_fit(const Plan& plan) {
  const std::vector<MoveTrack>& tracks = plan.move().tracks;
  const bool is_drawn =
      std::ranges::any_of(tracks, [](const MoveTrack& track) { return track.timing == Timing::speed; });
  return is_drawn && std::ranges::all_of(plan.tracks(), [](const SolvedTrack& track) {
           const Path& path = track.track().path();
           const std::size_t values = track.control_values().size();
           const std::size_t conditions = (static_cast<std::size_t>(path.segment_count()) + values) *
                                          static_cast<std::size_t>(path.axis_count());
           return values <= quick_control_values && conditions <= quick_conditions;
         });
}

}  // namespace inbetween
