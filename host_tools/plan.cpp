#include "host_tools/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

namespace inbetween {
namespace {

/// The numbers of a track as the core takes them. Lives until the track is solved.
struct TrackNumbers {
  std::vector<double> keys;
  std::vector<KeyShape<double>> shapes;
  TrackSpec<double> spec;

  TrackNumbers(const MoveTrack& track, const MoveFile& move) {
    for (const MoveKey& key : track.keys) {
      keys.insert(keys.end(), key.at.begin(), key.at.end());
      shapes.push_back({key.tension, key.continuity, key.bias});
    }
    spec.path = {.spline = track.spline,
                 .closed = track.closed,
                 .axis_count = static_cast<std::int32_t>(track.axes.size()),
                 .keys = keys,
                 .weights = track.weights,
                 .shapes = shapes};
    spec.control_values = track.speed;
    spec.frames = move.frames;
    spec.fps = move.fps.rate;
  }
};

/// The place in the file that an error of the core speaks of.
const Place& place_of(const Error& error, const MoveTrack& track) {
  const auto within = [](std::int32_t index, std::size_t size) {
    return index >= 0 && static_cast<std::size_t>(index) < size;
  };
  if (within(error.key, track.keys.size())) {
    const MoveKey& key = track.keys[static_cast<std::size_t>(error.key)];
    if (within(error.axis, key.at_places.size())) return key.at_places[static_cast<std::size_t>(error.axis)];
    return key.place;
  }
  if (within(error.control_value, track.speed_places.size())) {
    return track.speed_places[static_cast<std::size_t>(error.control_value)];
  }
  if (error.code == ErrorCode::no_distance) return track.speed_place;
  if (within(error.axis, track.weight_places.size())) {
    return track.weight_places[static_cast<std::size_t>(error.axis)];
  }
  return track.place;
}

std::string message_of(const Error& error, const MoveTrack& track) {
  std::string where;
  if (error.axis >= 0 && static_cast<std::size_t>(error.axis) < track.axes.size()) {
    where += fmt::format("axis {}: ", in_quotes(track.axes[static_cast<std::size_t>(error.axis)]));
  }
  if (error.key >= 0) where += fmt::format("key {}: ", error.key);
  if (error.frame >= 0) where += fmt::format("frame {}: ", error.frame);
  return fmt::format("{}{}; {}", where, error.what, error.remedy);
}

/// What design.md describes and this version does not do yet is refused, not ignored.
void refuse_what_is_not_solved_yet(const MoveTrack& track) {
  if (track.timing == Timing::frames) {
    throw InputError(track.place, R"(timing = "frames" is not solved by this version; draw a speed curve)");
  }
  for (const MoveKey& key : track.keys) {
    if (key.frame || key.hold) {
      throw InputError(key.place, "frame and hold are not solved by this version; remove them");
    }
  }
}

SolvedTrack<double> solve_track(const MoveTrack& track, const MoveFile& move, const PlanOptions& options) {
  refuse_what_is_not_solved_yet(track);
  const TrackNumbers numbers(track, move);
  try {
    SolvedTrack<double> solved(numbers.spec, options.solver);
    const Status valid = check_invariants(solved.track(), solved.table());
    if (!valid) throw SolverError(valid.error());
    return solved;
  } catch (const SolverError& refused) {
    throw InputError(place_of(refused.error(), track), message_of(refused.error(), track));
  }
}

}  // namespace

Plan::Plan(MoveFile move, std::optional<RigFile> rig, const PlanOptions& options)
    : move_(std::move(move)), rig_(std::move(rig)) {
  list_axes();
  warn_of_mixed_units();
  solve(options);
}

double Plan::duration_s() const {
  const FrameRate& fps = move_.fps.rate;
  return static_cast<double>(move_.frames) * fps.denominator / fps.numerator;
}

void Plan::list_axes() {
  if (rig_) {
    for (const RigAxis& axis : rig_->axes) axes_.push_back({axis.name, axis.unit, std::nullopt, 0});
  }
  for (std::size_t t = 0; t < move_.tracks.size(); ++t) {
    const MoveTrack& track = move_.tracks[t];
    for (std::size_t d = 0; d < track.axes.size(); ++d) {
      const std::string& name = track.axes[d];
      if (!rig_) {
        axes_.push_back({name, std::nullopt, t, d});
        continue;
      }
      const auto found = std::ranges::find(axes_, name, &PlanAxis::name);
      if (found == axes_.end()) {
        std::vector<std::string> known;
        for (const RigAxis& axis : rig_->axes) known.push_back(axis.name);
        throw InputError(track.axis_places[d],
                         fmt::format("the rig {} has no axis {}; it has {}", in_quotes(rig_->name),
                                     in_quotes(name), fmt::join(known, ", ")));
      }
      found->track = t;
      found->track_axis = d;
    }
  }
}

void Plan::warn_of_mixed_units() {
  if (!rig_) return;
  for (std::size_t t = 0; t < move_.tracks.size(); ++t) {
    const MoveTrack& track = move_.tracks[t];
    if (!track.weights.empty() || !length_unit(t).empty()) continue;
    std::set<std::string_view> units;
    for (const PlanAxis& axis : axes_) {
      if (axis.track == t) units.insert(to_string(*axis.unit));
    }
    const std::string_view first = *units.begin();
    const std::string_view second = *std::next(units.begin());
    warnings_.push_back(
        {track.place, fmt::format("1 {} counts as 1 {} of distance along this track; give weights, "
                                  "one per axis, to say otherwise",
                                  second, first)});
  }
}

std::string Plan::length_unit(std::size_t track) const {
  const std::vector<double>& weights = move_.tracks[track].weights;
  std::optional<AxisUnit> unit;
  for (const PlanAxis& axis : axes_) {
    if (axis.track != track || (!weights.empty() && weights[axis.track_axis] == 0)) continue;
    if (!axis.unit || (unit && *unit != *axis.unit)) return "";
    unit = axis.unit;
  }
  return unit ? std::string(to_string(*unit)) : "";
}

void Plan::solve(const PlanOptions& options) {
  for (const MoveTrack& track : move_.tracks) tracks_.push_back(solve_track(track, move_, options));
}

void Plan::motion(const FrameTime<double>& time, std::vector<AxisMotion<double>>& out) const {
  out.assign(axes_.size(), {});
  std::vector<std::vector<AxisMotion<double>>> by_track(tracks_.size());
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    by_track[t].resize(move_.tracks[t].axes.size());
    tracks_[t].track().motion(time, by_track[t]);
  }
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    if (axes_[a].track) out[a] = by_track[*axes_[a].track][axes_[a].track_axis];
  }
}

}  // namespace inbetween
