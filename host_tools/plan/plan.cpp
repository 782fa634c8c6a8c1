#include "host_tools/plan/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>

#include "host_tools/plan/drawn_curve.hpp"
#include "host_tools/plan/key_positions.hpp"
#include "host_tools/plan/network_track.hpp"
#include "host_tools/plan/table_track.hpp"
#include "host_tools/plan/unmet_lock.hpp"

namespace inbetween {
namespace {

/// Of a loop whose axes follow a closed path in space.
constexpr double loop_rounding = 1e-7;

/// The numbers of a track as the core takes them. Lives until the track is solved.
struct TrackNumbers {
  std::vector<double> keys;
  std::vector<double> weights;
  std::vector<KeyShape> shapes;
  std::vector<KeyLock> locks;
  std::vector<std::int32_t> key_frames;
  std::vector<std::int32_t> overlaps;
  std::vector<double> tolerances;
  std::vector<double> speed;
  TrackSpec spec;

  TrackNumbers(const MoveTrack& track, const MoveFile& move)
      : weights(track.space ? space_weights(*track.space) : track.weights) {
    std::size_t rows = 0;
    for (const MoveKey& key : track.keys) {
      const std::vector<double> row = track.space ? space_row(*track.space, key) : key.at;
      keys.insert(keys.end(), row.begin(), row.end());
      rows = row.size();
      shapes.push_back({key.tension, key.continuity, key.bias});
    }
    spec.path = {.spline = track.spline,
                 .closed = track.closed,
                 .axis_count = static_cast<std::int32_t>(rows),
                 .keys = keys,
                 .lap = track.lap,
                 .weights = weights,
                 .shapes = shapes,
                 .overshoot = track.overshoot};
    if (track.timing == Timing::speed) speed = drawn_curve(track, move.frames);
    spec.control_values = speed;
    spec.ends = ends_of(track);
    spec.ease_corners = track.ease_corners;
    if (track.timing == Timing::frames) {
      take_key_frames(track, move.frames);
    } else {
      take_locks(track);
    }
    take_corners(track);
    spec.frames = move.frames;
    spec.fps = move.fps.rate;
  }

 private:
  /// Straight lines that overlap in time are curves over time, though each of them is linear.
  void take_corners(const MoveTrack& track) {
    if (track.keys.size() < 2) return;
    if (has_overlap(track)) {
      for (const MoveKey& key : track.keys) overlaps.push_back(overlap_of(track, key));
      spec.path.overlap_frames = overlaps;
      spec.kinetic = Kinetic::curves;
    }
    if (has_round(track)) {
      for (const MoveKey& key : track.keys) tolerances.push_back(round_of(track, key));
      // A closed path that is no loop ends at its seam.
      if (!track.periodic) tolerances.front() = 0;
      spec.path.path_tolerances = tolerances;
    }
  }

  void take_locks(const MoveTrack& track) {
    for (std::size_t k = 0; k < track.keys.size(); ++k) {
      const MoveKey& key = track.keys[k];
      if (!key.frame && !key.hold && !key.ease) continue;
      locks.push_back({.key = static_cast<std::int32_t>(k),
                       .frame = key.frame.value_or(-1),
                       .hold = key.hold.value_or(0),
                       .breaks = key.breaks,
                       .ease = key.ease});
    }
    spec.locks = locks;
  }

  void take_key_frames(const MoveTrack& track, std::int32_t frames) {
    for (const MoveKey& key : track.keys) {
      if (key.hold || key.breaks) {
        throw InputError(
            key.place,
            R"(hold and break belong to a speed curve; with timing = "frames" write the key twice, on )"
            "the first and the last frame of the hold");
      }
      if (!key.frame)
        throw InputError(key.place, R"(the key has no frame; timing = "frames" needs one on every key)");
      key_frames.push_back(*key.frame);
    }
    if (track.closed && track.keys.size() > 1) key_frames.push_back(frames);
    spec.key_frames = key_frames;
    const MoveKinetic kinetic = kinetic_of(track);
    spec.pace = kinetic == MoveKinetic::pace;
    spec.kinetic = kinetic == MoveKinetic::curves     ? Kinetic::curves
                   : kinetic == MoveKinetic::monotone ? Kinetic::monotone
                                                      : Kinetic::linear;
    const RestingEnds rest = track.rest.value_or(RestingEnds{});
    spec.rests_at_start = rest.start;
    spec.rests_at_end = rest.end;
    if (spec.pace) take_locks(track);
    for (const MoveKey& key : track.keys) {
      if (!key.ease || spec.pace) continue;
      throw InputError(key.place,
                       R"(ease belongs to a speed curve; remove it, or write kinetic = "pace" (kinetic = )"
                       R"("curves" eases where it turns back by itself))");
    }
  }
};

/// The frame nearest to `frame` at which a curve of so many control values, refined up to the most, has a
/// knot.
std::int32_t nearest_touch_frame(std::int32_t frame, std::int32_t frames, std::size_t control_values) {
  auto f = static_cast<std::int64_t>(std::max<std::size_t>(control_values, 2)) - 1;
  while (2 * f < static_cast<std::int64_t>(max_lock_values)) f *= 2;
  const std::int64_t step =
      std::max<std::int64_t>(frames / std::gcd(static_cast<std::int64_t>(frames), f), 1);
  return static_cast<std::int32_t>((frame + step / 2) / step * step);
}

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

std::string message_of(const SolverError& refused, const MoveTrack& track, std::int32_t frames) {
  const Error& error = refused.error();
  std::string where;
  const std::vector<std::string> names = coordinates_of(track);
  if (error.axis >= 0 && static_cast<std::size_t>(error.axis) < names.size()) {
    where += fmt::format("{}{}: ", track.space ? "" : "axis ",
                         in_quotes(names[static_cast<std::size_t>(error.axis)]));
  }
  if (error.code == ErrorCode::unmeasured && (track.space || track.distance)) {
    return fmt::format(
        "{}key {}: the link stands still after this key while something else moves, and its path in "
        "space is the distance; let it move too, or give what moves a track of its own",
        where, error.key);
  }
  if (error.key >= 0) where += fmt::format("key {}: ", error.key);
  if (error.needed > 0 && has_overlap(track)) {
    return fmt::format("{}{}; an overlap of {} at both of its keys goes in", where, error.what,
                       counted(error.needed, "frame"));
  }
  if (error.frame >= 0) where += fmt::format("frame {}: ", error.frame);
  if (const auto* proven = dynamic_cast<const UnmetLock*>(&refused))
    return fmt::format("{}{}; {}", where, error.what, proven->remedy());
  const bool is_touch = error.code == ErrorCode::no_solution && error.key >= 0 && error.frame >= 0 &&
                        track.timing == Timing::speed && track.keys[static_cast<std::size_t>(error.key)].ease;
  if (is_touch) {
    const std::int32_t nearest = nearest_touch_frame(error.frame, frames, drawn_curve(track, frames).size());
    if (nearest != error.frame) {
      return fmt::format("{}{}; the nearest frame that is possible is {}", where, error.what, nearest);
    }
  }
  return fmt::format("{}{}; {}", where, error.what, error.remedy);
}

/// A track with one key stands there. It has no path of which a distance could be told; and one in space is
/// solved along a path, so that it has the key twice.
void stand_at_one_key(MoveFile& move) {
  for (MoveTrack& track : move.tracks) {
    if (track.keys.size() != 1) continue;
    track.distance.reset();
    if (!track.space) continue;
    track.closed = track.periodic = false;
    MoveKey key = track.keys.front();
    key.hold.reset();
    key.breaks = key.ease = false;
    if (track.timing == Timing::speed) key.frame.reset();
    track.keys.assign(2, key);
    if (key.frame) track.keys.back().frame = move.frames;
  }
}

void refuse_curves_in_space(const MoveTrack& track) {
  if (track.timing == Timing::speed) return;
  const MoveKinetic kinetic = kinetic_of(track);
  if (kinetic == MoveKinetic::linear || kinetic == MoveKinetic::pace) return;
  throw InputError(
      track.space ? track.space->place : track.distance->place,
      R"(with timing = "frames" a path in space is passed with kinetic = "pace" or "linear"; write one )"
      "of the two");
}

/// A loop goes on where it began, and axes that follow may have turned on.
void refuse_open_loop(const MoveTrack& track, const FollowedPath& path) {
  if (!track.periodic) return;
  const std::size_t rows = path.weights.size();
  for (std::size_t d = 0; d < track.axes.size(); ++d) {
    const double begin = path.cubics[d].c0;
    const double end = path.cubics[path.cubics.size() - rows + d].value(1);
    const double lap = track.lap.empty() ? 0 : track.lap[d];
    if (std::fabs(end - begin - lap) <= loop_rounding * (1 + std::fabs(begin))) continue;
    throw InputError(track.place,
                     fmt::format("axis {} ends a loop at {:.6g}, and it began at {:.6g}; a loop that is "
                                 "played round and round must come back",
                                 in_quotes(track.axes[d]), end, begin));
  }
}

/// What is played of a track whose distance is that of a tip.
FollowedPath follow(const MoveTrack& track, const TrackSpec& spec, const RigFile& rig,
                    const Kinematics& kinematics) {
  if (track.space) {
    const SolvedTrack drawn(spec, Solver::closed_form);
    return axes_in_space(track, drawn.track(), kinematics, rig);
  }
  const PathOnHeap drawn(spec.path);
  return tip_of_axes(track, drawn.path(), kinematics, rig);
}

/// The path of a track that the core did not solve from the keys. Refers to what it is made of.
CubicPathSpec path_of_cubics(const MoveTrack& track, std::span<const Cubic> cubics,
                             std::span<const double> weights, std::span<const FrameKnot> knots,
                             bool over_frames = false) {
  return {.spline = track.spline,
          .closed = track.closed && track.keys.size() > 1,
          .axis_count = static_cast<std::int32_t>(track.axes.size()),
          .key_count = static_cast<std::int32_t>(track.keys.size()),
          .cubics = cubics,
          .weights = weights,
          .knots = knots,
          .over_frames = over_frames};
}

CubicPathSpec path_of_cubics(const MoveTrack& track, const FollowedPath& path) {
  return path_of_cubics(track, path.cubics, path.weights, path.knots);
}

/// The axes of a link are solved over time.
SolvedTrack solved_over_time(const MoveTrack& track, const MoveFile& move, const TrackedPath& tracked) {
  TrackSpec spec;
  spec.cubics = path_of_cubics(track, tracked.path);
  spec.key_frames = tracked.key_frames;
  spec.kinetic = Kinetic::linear;
  spec.frames = move.frames;
  spec.fps = move.fps.rate;
  SolvedTrack solved(spec, Solver::closed_form);
  value_or_throw(check_invariants(solved.track(), solved.table()));
  return solved;
}

SolvedTrack solve_track(const MoveTrack& track, const MoveFile& move, const std::optional<RigFile>& rig,
                        const PlanOptions& options, const SolvedTrack* same_keys,
                        std::optional<FollowAccuracy>& accuracy) {
  TrackNumbers numbers(track, move);
  try {
    std::optional<FollowedPath> followed;
    if (is_row_of_points(track)) {
      const TrackedPath tracked = axes_of_points(track, numbers.spec, *options.kinematics, *rig);
      accuracy = tracked.path.accuracy;
      return solved_over_time(track, move, tracked);
    }
    if (track.space || track.distance) {
      refuse_curves_in_space(track);
      followed = follow(track, numbers.spec, *rig, *options.kinematics);
      accuracy = followed->accuracy;
      numbers.spec.cubics = path_of_cubics(track, *followed);
      refuse_open_loop(track, *followed);
    }
    CubicsOverFrames drawn;
    if (track.network || track.table) {
      drawn = track.network ? network_of(track, numbers.spec) : table_path(track);
      numbers.weights.resize(track.axes.size(), 1);  // all 1 where none are given
      numbers.spec.cubics = path_of_cubics(track, drawn.cubics, numbers.weights, drawn.knots, true);
    }
    SolvedTrack solved(numbers.spec, options.solver, {}, same_keys);
    if (same_keys == nullptr) value_or_throw(check_invariants(solved.track(), solved.table()));
    return solved;
  } catch (const SolverError& refused) {
    throw InputError(place_of(refused.error(), track), message_of(refused, track, move.frames));
  }
}

/// The track looks at a link that others move, and is solved behind them.
bool looks_at_link(const MoveTrack& track) {
  return track.space && track.space->aim_node;
}

SolvedTrack solve_looking(const MoveTrack& track, const MoveFile& move, const RigFile& rig,
                          const PlanOptions& options, const std::vector<DrivenCoordinate>& driven,
                          std::optional<FollowAccuracy>& accuracy) {
  const TrackNumbers numbers(track, move);
  try {
    refuse_curves_in_space(track);
    if (track.closed || options.solver == Solver::runge_kutta) {
      throw InputError(
          track.space->aim_place,
          fmt::format("{} moves, and a track that looks at it is solved over time, open and in closed "
                      "form; leave out closed and --solver",
                      in_quotes(*track.space->aim_node)));
    }
    const SolvedTrack drawn(numbers.spec, Solver::closed_form);
    const TrackedPath tracked = axes_looking_at(track, drawn.track(), *options.kinematics, rig, driven);
    accuracy = tracked.path.accuracy;
    return solved_over_time(track, move, tracked);
  } catch (const SolverError& refused) {
    throw InputError(place_of(refused.error(), track), message_of(refused, track, move.frames));
  }
}

}  // namespace

Plan::Plan(MoveFile move, std::optional<RigFile> rig, const PlanOptions& options)
    : Plan(std::move(move), std::move(rig), options, nullptr) {}

Plan::Plan(MoveFile move, const Plan& other)
    : Plan(std::move(move), other.rig_, {.kinematics = other.kinematics_}, &other) {}

Plan::Plan(MoveFile move, std::optional<RigFile> rig, const PlanOptions& options, const Plan* other)
    : move_(std::move(move)),
      part_(played_frames_of(options.frames, move_.frames, {move_.path, 0, 0})),
      names_frames_(options.frames.first || options.frames.last),
      rig_(std::move(rig)),
      kinematics_(options.kinematics) {
  stand_at_one_key(move_);
  list_axes();
  settle_positions(move_, rig_);
  settle_aims(move_, kinematics_.get(), axes_in_move());
  warn_of_mixed_units();
  warn_of_near_keys();
  list_tips();
  if (rig_) check_cues(move_, *rig_);
  solve(options, other);
  put_together();
  refuse_too_many_ticks();
}

double Plan::duration_s() const {
  const FrameRate& fps = move_.fps.rate;
  return static_cast<double>(part_.last - part_.first) * fps.denominator / fps.numerator;
}

void Plan::refuse_too_many_ticks() const {
  if (!rig_) return;
  const std::int32_t frames = played_->last_frame() - played_->first_frame();
  const std::int64_t ticks = last_tick(frames, move_.fps.rate, rig_->rate_hz);
  if (ticks <= max_ticks) return;
  throw InputError(move_.frames_place,
                   fmt::format("the move lasts {:.6g} s, {} ticks at the {} Hz of the rig {}, and {} are "
                               "allowed; lower frames or rate_hz",
                               frames / move_.fps.rate.frames_per_second(), ticks, rig_->rate_hz,
                               in_quotes(rig_->name), max_ticks));
}

std::vector<AxisInMove> Plan::axes_in_move() const {
  std::vector<AxisInMove> axes(axes_.size());
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    axes[a].track = axes_[a].track;
    if (!axes_[a].track) continue;
    const MoveTrack& track = move_.tracks[*axes_[a].track];
    if (!track.space && track.keys.size() == 1) axes[a].held = track.keys.front().at[axes_[a].track_axis];
  }
  return axes;
}

std::vector<DrivenCoordinate> Plan::driven_by(const std::vector<std::optional<SolvedTrack>>& solved) const {
  std::vector<DrivenCoordinate> driven(axes_.size());
  const std::vector<AxisInMove> in_move = axes_in_move();
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    if (in_move[a].held) driven[a].held = *in_move[a].held;
    if (in_move[a].held || !in_move[a].track || !solved[*in_move[a].track]) continue;
    driven[a].track = &solved[*in_move[a].track]->track();
    driven[a].axis = axes_[a].track_axis;
  }
  return driven;
}

void Plan::list_axes() {
  if (rig_) {
    for (const RigAxis& axis : rig_->axes) axes_.push_back({axis.name, axis.unit, std::nullopt, 0, 0});
  }
  std::size_t next = 0;
  for (std::size_t t = 0; t < move_.tracks.size(); ++t) {
    const MoveTrack& track = move_.tracks[t];
    for (std::size_t d = 0; d < track.axes.size(); ++d) {
      const std::string& name = track.axes[d];
      const std::size_t move_axis = next++;
      if (!rig_) {
        axes_.push_back({name, unit_without_rig(track, d), t, d, move_axis});
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
      found->move_axis = move_axis;
    }
  }
}

void Plan::warn_of_mixed_units() {
  if (!rig_) return;
  for (std::size_t t = 0; t < move_.tracks.size(); ++t) {
    const MoveTrack& track = move_.tracks[t];
    // Over time no distance decides anything.
    const bool is_over = is_over_time(track) || has_overlap(track);
    const bool is_said = !track.weights.empty() || track.space || track.distance || is_over;
    if (is_said || track.keys.size() == 1 || !length_unit(t).empty()) continue;
    std::set<std::string_view> units;
    for (const PlanAxis& axis : axes_) {
      if (axis.track == t) units.insert(to_string(*axis.unit));
    }
    const std::string first(*units.begin());
    units.erase(units.begin());
    warnings_.push_back(
        {track.place,
         fmt::format("1 {} count{} as 1 {} of distance along this track; give weights, one per axis, to say "
                     "otherwise",
                     fmt::join(units, " and 1 "), units.size() == 1 ? "s" : "", first)});
  }
}

std::string Plan::distance_in_words(std::size_t index, const NearKeys& pair) const {
  const MoveTrack& track = move_.tracks[index];
  if (track.space) return fmt::format("{:.6g} m", pair.distance);
  std::string unit = track.distance ? "" : length_unit(index);
  std::vector<std::size_t> differing;
  for (std::size_t d = 0; d < track.axes.size(); ++d) {
    if (track.keys[pair.first].at[d] != track.keys[pair.first + 1].at[d]) differing.push_back(d);
  }
  double distance = pair.distance;
  if (differing.size() == 1) {  // then it needs no weight
    const std::size_t d = differing.front();
    distance = std::fabs(track.keys[pair.first + 1].at[d] - track.keys[pair.first].at[d]);
    const auto axis = std::ranges::find_if(
        axes_, [&](const PlanAxis& one) { return one.track == index && one.track_axis == d; });
    unit = axis->unit ? to_string(*axis->unit) : "";
  }
  return fmt::format("{:.6g}{}{}", distance, unit.empty() ? "" : " ", unit);
}

void Plan::warn_of_near_keys() {
  for (std::size_t t = 0; t < move_.tracks.size(); ++t) {
    for (const NearKeys& pair : near_keys(move_.tracks[t])) {
      warnings_.push_back(
          {move_.tracks[t].keys[pair.first + 1].place,
           fmt::format("keys {} and {} are {} apart, {:.0f} times nearer than their neighbours, and the path "
                       "may turn at once between them; remove one, or give both one place",
                       pair.first, pair.first + 1, distance_in_words(t, pair),
                       std::floor(pair.times_nearer))});
    }
  }
}

std::vector<Warning> Plan::keys_outside() const {
  std::vector<Warning> outside;
  for (std::size_t a = 0; rig_ && a < axes_.size(); ++a) {
    const PlanAxis& planned = axes_[a];
    if (!planned.track || move_.tracks[*planned.track].space) continue;
    const RigAxis& axis = rig_->axes[a];
    const double rounding = position_rounding(axis.min, axis.max);
    const MoveTrack& track = move_.tracks[*planned.track];
    if (track.table) {
      const auto row = row_outside(track, planned.track_axis, axis.min - rounding, axis.max + rounding);
      if (!row) continue;
      outside.push_back({track.table->place_of(*row),
                         fmt::format("frame {}: axis {} is at {:.10g} {}, outside {} of the rig {}",
                                     track.table->frames[*row], in_quotes(axis.name),
                                     track.table->at[*row * track.axes.size() + planned.track_axis],
                                     to_string(axis.unit), range_in_words(axis), in_quotes(rig_->name))});
      continue;
    }
    const std::vector<MoveKey>& keys = track.keys;
    const auto key = std::ranges::find_if(keys, [&](const MoveKey& one) {
      const double at = one.at[planned.track_axis];
      return at < axis.min - rounding || at > axis.max + rounding;
    });
    if (key == keys.end()) continue;
    const bool has_place = planned.track_axis < key->at_places.size();
    outside.push_back({has_place ? key->at_places[planned.track_axis] : key->place,
                       fmt::format("key {}: axis {} is at {:.10g} {}, outside {} of the rig {}",
                                   key - keys.begin(), in_quotes(axis.name), key->at[planned.track_axis],
                                   to_string(axis.unit), range_in_words(axis), in_quotes(rig_->name))});
  }
  return outside;
}

void Plan::list_tips() {
  if (!kinematics_) return;
  for (std::size_t i = 0; i < kinematics_->tips().size(); ++i) {
    const Tip& tip = kinematics_->tips()[i];
    const auto unknown = std::ranges::find_if(axes_, [&](const PlanAxis& axis) {
      return !axis.track &&
             kinematics_->tree().moves(static_cast<std::int32_t>(&axis - axes_.data()), tip.link);
    });
    if (unknown == axes_.end()) {
      tips_.push_back(tip);
      continue;
    }
    warnings_.push_back(
        {rig_->kinematics->tips[i].place,
         fmt::format("the path of {} is not shown: it hangs on axis {}, which is in no track; give that "
                     "a track with one key",
                     in_quotes(tip.name), in_quotes(unknown->name))});
  }
}

std::string Plan::length_unit(std::size_t track) const {
  if (looks_at_link(move_.tracks[track]) || is_row_of_points(move_.tracks[track])) return "";
  if (move_.tracks[track].space || move_.tracks[track].distance) return "m";
  const std::vector<double>& weights = move_.tracks[track].weights;
  std::optional<AxisUnit> unit;
  for (const PlanAxis& axis : axes_) {
    if (axis.track != track || (!weights.empty() && weights[axis.track_axis] == 0)) continue;
    if (!axis.unit || (unit && *unit != *axis.unit)) return "";
    unit = axis.unit;
  }
  return unit ? std::string(to_string(*unit)) : "";
}

void Plan::solve(const PlanOptions& options, const Plan* other) {
  accuracies_.resize(move_.tracks.size());
  std::vector<std::optional<SolvedTrack>> solved(move_.tracks.size());
  for (std::size_t t = 0; t < solved.size(); ++t) {
    if (looks_at_link(move_.tracks[t])) continue;
    const SolvedTrack* same_keys = other != nullptr ? &other->tracks_[t] : nullptr;
    solved[t].emplace(solve_track(move_.tracks[t], move_, rig_, options, same_keys, accuracies_[t]));
  }
  const std::vector<DrivenCoordinate> driven = driven_by(solved);
  for (std::size_t t = 0; t < solved.size(); ++t) {
    if (solved[t]) continue;
    solved[t].emplace(solve_looking(move_.tracks[t], move_, *rig_, options, driven, accuracies_[t]));
  }
  for (std::optional<SolvedTrack>& track : solved) tracks_.push_back(std::move(*track));
}

void Plan::put_together() {
  for (const SolvedTrack& solved : tracks_) track_views_.push_back(solved.track());
  if (rig_) {
    std::size_t moving = 0;
    for (const MoveTrack& track : move_.tracks) moving += track.axes.size();
    for (std::size_t d = 0; d < moving; ++d) limits_.push_back(limits_of(rig_->axes[axis_of(d)]));
    const std::span<const Trajectory> fitted =
        is_whole() ? std::span<const Trajectory>() : motion_->trajectories(track_views_);
    rolls_ = plan_rolls(track_views_, fitted, limits_, part_);
  }
  played_ = value_or_throw(Move::make(track_views_, {.before = rolls_.before, .after = rolls_.after}, part_));
}

bool Plan::is_moving(std::size_t track, RollEnd end) const {
  if (move_.tracks[track].keys.size() == 1) return false;
  const std::int32_t frame = end == RollEnd::before ? part_.first : part_.last;
  if (frame == (end == RollEnd::before ? 0 : move_.frames)) {
    return inbetween::is_moving(track_views_[track], end);
  }
  std::vector<AxisMotion> joints(move_.tracks[track].axes.size());
  return joints_of_part(std::span(track_views_).subspan(track, 1),
                        motion_->trajectories(track_views_).subspan(track, 1), part_, end, joints);
}

const PlayedMotion& Plan::motion() const {
  return motion_->of(*played_, track_views_, calibrated_motors());
}

std::vector<CalibratedMotor> Plan::calibrated_motors() const {
  std::vector<CalibratedMotor> motors;
  for (std::size_t d = 0; d < limits_.size(); ++d) {
    const RigAxis& axis = rig_->axes[axis_of(d)];
    if (axis.calibration) motors.push_back({.axis = d, .calibration = &axis.calibration->motor()});
  }
  return motors;
}

const Place& Plan::place_of(std::size_t axis) const {
  const PlanAxis& planned = axes_[axis];
  return move_.tracks[planned.track.value()].axis_places[planned.track_axis];
}

std::size_t Plan::axis_of(std::size_t move_axis) const {
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    if (axes_[a].track && axes_[a].move_axis == move_axis) return a;
  }
  throw std::out_of_range("there is no such axis in the move");
}

}  // namespace inbetween
