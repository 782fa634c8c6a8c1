#include "host_tools/plan/solved_track.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host_tools/plan/smoothest_pace.hpp"
#include "host_tools/plan/unmet_lock.hpp"

namespace inbetween {
namespace {

/// At the default delta a segment takes about 17 pieces; where more are needed the core tells how many.
constexpr std::size_t usual_pieces_per_segment = 24;
/// So many segments are the rows of a table, which are near to each other.
constexpr std::size_t many_segments = 20'000;
/// Each of those takes 10 pieces (TableTrack.AHundredThousandRowsAreReadOneByOneAndProven has as many), and
/// room for 24 would be 150 MB more for 100 000 rows.
constexpr std::size_t usual_pieces_of_many = 12;
/// A path over frames has so many beside a rest, and one with rounded corners.
constexpr std::size_t max_segments_between_keys = 5;

/// Whether the frames of the keys are the knots of the path.
bool is_path_over_frames(const TrackSpec& spec) {
  return !spec.key_frames.empty() && !spec.pace && spec.kinetic == Kinetic::curves;
}

}  // namespace

SolverError::SolverError(const Error& error)
    : std::runtime_error(fmt::format("{}: {}", error.what, error.remedy)), error_(error) {}

PathOnHeap::PathOnHeap(const PathSpec& spec)
    : weights_(static_cast<std::size_t>(std::max(spec.axis_count, 1))),
      cubics_((spec.keys.size() / weights_.size() + 1) * weights_.size()),
      path_(value_or_throw(Path::make(spec, {cubics_, weights_}))) {}

MeasuredPath::MeasuredPath(const TrackSpec& spec)
    : path_(make_path(spec)), arc_length_(make_arc_length(spec.arc_length)) {}

SolvedTrack::SolvedTrack(const TrackSpec& spec, Solver solver, const OdeOptions& ode,
                         const SolvedTrack* same_keys) {
  if (same_keys != nullptr && !spec.cubics && !is_path_over_frames(spec)) {
    measured_ = same_keys->measured_;
    waypoints_ = same_keys->waypoints_;
  } else {
    measured_ = std::make_shared<const MeasuredPath>(spec);
  }
  track_ = make_track(spec);
  points_.resize(static_cast<std::size_t>(spec.frames) + 1);
  if (solver == Solver::closed_form) {
    table_ = value_or_throw(closed_form_table(*track_, points_));
  } else {
    integrated_ = value_or_throw(runge_kutta_table(*track_, ode, points_));
    table_ = integrated_->table;
  }
}

Track SolvedTrack::make_track(const TrackSpec& spec) {
  const Path& path = measured_->path();
  const ArcLength& arc_length = measured_->arc_length();
  if (!spec.key_frames.empty()) {
    key_intervals_.resize(static_cast<std::size_t>(path.segment_count()));
    const Track track = value_or_throw(Track::make_with_key_frames(
        path, arc_length, spec.key_frames, spec.pace ? Kinetic::linear : spec.kinetic, spec.frames, spec.fps,
        {.key_intervals = key_intervals_}));
    if (!spec.pace) return track;
  }
  control_values_.assign(spec.control_values.begin(), spec.control_values.end());
  if (control_values_.size() == 1) control_values_.push_back(control_values_.front());
  if (spec.pace) {
    find_waypoints(spec);
    apply_pace(spec);
  } else if (!spec.locks.empty() || spec.ease_corners) {
    find_waypoints(spec);
    apply_locks(spec);
  }
  const SpeedProfile profile = make_profile(control_values_, spec.ends);
  span_distances_.resize(control_values_.size() + 1);
  portions_.resize(breaks_.size() + 1);
  return value_or_throw(Track::make_with_breaks(path, arc_length, profile, spec.frames, spec.fps, breaks_,
                                                {.span_distances = span_distances_, .portions = portions_}));
}

void SolvedTrack::find_waypoints(const TrackSpec& spec) {
  if (control_values_.empty()) control_values_ = {1.0, 1.0};
  // The profile's own checks come first, so that a bad control value is named as such.
  const SpeedProfile profile = make_profile(control_values_, spec.ends);
  span_distances_.resize(control_values_.size() + 1);
  const Track track = value_or_throw(Track::make(measured_->path(), measured_->arc_length(), profile,
                                                 spec.frames, spec.fps, {.span_distances = span_distances_}));
  if (waypoints_.empty()) waypoints_ = waypoints_of(track);
}

void SolvedTrack::apply_pace(const TrackSpec& spec) {
  PaceSpec pace{.key_distances = {},
                .key_frames = spec.key_frames,
                .rests_at_start = spec.rests_at_start,
                .rests_at_end = spec.rests_at_end};
  std::vector<double> distances;
  std::vector<std::int32_t> touches;
  double length = 0;
  for (const Waypoint& place : waypoints_) {
    if (!place.is_key) continue;
    length = place.distance;
    distances.push_back(length);
    const bool is_asked = std::ranges::any_of(
        spec.locks, [&](const KeyLock& lock) { return lock.ease && lock.key == place.key; });
    const bool is_inside = place.key > 0 && place.key < waypoints_.back().key;
    if (is_asked || (spec.ease_corners && place.is_corner && is_inside)) touches.push_back(place.key);
  }
  if (!(length > 0)) return;
  pace.key_distances = distances;
  pace.touches = touches;
  const std::vector<double> values = smoothest_pace(pace);
  control_values_.assign(values.begin(), values.end());
}

namespace {

/// Whether the next request is to rest, or to touch 0, in the place of the first waypoint.
bool rests_behind(std::span<const Waypoint> waypoints, std::span<const KeyLock> requests) {
  if (requests.empty() || !(requests.front().ease || requests.front().hold > 0)) return false;
  const auto is_elsewhere = [&](const Waypoint& place) { return place.distance != waypoints[0].distance; };
  const auto here = std::ranges::find_if(waypoints, is_elsewhere);
  return std::any_of(waypoints.begin(), here, [&](const Waypoint& place) {
    return place.is_key && place.key == requests.front().key;
  });
}

/// The requests about keys, in the numbers of the waypoints, and a touch at every corner that has no request.
/// The seam of a periodic curve is its first waypoint.
std::vector<KeyLock> locks_on(std::span<const Waypoint> waypoints, std::span<const KeyLock> requests,
                              bool ease_corners, CurveEnds ends) {
  std::vector<KeyLock> locks;
  auto next = requests.begin();
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const Waypoint& place = waypoints[i];
    const bool may_ease = (i > 0 || ends == CurveEnds::periodic) && i + 1 < waypoints.size();
    const bool eases = ease_corners && place.is_corner && may_ease;
    bool has_request = false;
    // The requests are in the order of the keys.
    if (place.is_key) next = std::ranges::lower_bound(next, requests.end(), place.key, {}, &KeyLock::key);
    for (; place.is_key && next != requests.end() && next->key == place.key; ++next) {
      const KeyLock& request = *next;
      locks.push_back(request);
      locks.back().key = static_cast<std::int32_t>(i);
      if (eases && request.hold == 0 && !request.breaks) locks.back().ease = true;
      has_request = true;
    }
    // A key written twice is one place, at which the speed touches 0 once.
    const bool is_eased_already =
        !locks.empty() && (locks.back().ease || locks.back().hold > 0) &&
        waypoints[static_cast<std::size_t>(locks.back().key)].distance == place.distance;
    if (eases && !has_request && !is_eased_already &&
        !rests_behind(waypoints.subspan(i), {next, requests.end()})) {
      locks.push_back({.key = static_cast<std::int32_t>(i), .ease = true});
    }
  }
  for (const KeyLock& request : requests) {  // of no key: refused by its number
    if (request.key < 0 || request.key > waypoints.back().key) locks.push_back(request);
  }
  return locks;
}

}  // namespace

void SolvedTrack::apply_locks(const TrackSpec& spec) {
  const std::vector<KeyLock> requests = locks_on(waypoints_, spec.locks, spec.ease_corners, spec.ends);
  if (requests.empty()) return;
  std::vector<double> distances;
  for (const Waypoint& place : waypoints_) distances.push_back(static_cast<double>(place.distance));
  const std::size_t count = requests.size();
  std::vector<double> adjusted(max_lock_values);
  std::vector<double> drawn(max_lock_values);
  std::vector<double> mobility(max_lock_values);
  std::vector<double> ceiling(max_lock_values);
  std::vector<double> targets(count + 1);
  std::vector<double> multipliers(4 * (count + 1));
  std::vector<LockRow> rows(count + 1);
  std::vector<double> weights(lock_weight_count(count, max_lock_values));
  std::vector<double> matrix(lock_entry_count(count));
  completed_locks_.resize(count + 2);
  const Result<KeyTiming> adjusting = adjust_to_locks(
      {.control_values = control_values_,
       .key_distances = distances,
       .locks = requests,
       .frames = spec.frames,
       .ends = spec.ends},
      {adjusted, drawn, mobility, ceiling, completed_locks_, targets, multipliers, rows, weights, matrix});
  if (!adjusting) {
    Error error = adjusting.error();
    if (error.code == ErrorCode::no_solution) {
      const auto last = static_cast<std::int32_t>(waypoints_.size()) - 1;
      const auto end = std::ranges::find(completed_locks_, last, &KeyLock::key) + 1;
      if (const auto proven = proven_unmet({.locks = {completed_locks_.begin(), end},
                                            .waypoints = waypoints_,
                                            .control_values = control_values_,
                                            .ends = spec.ends,
                                            .frames = spec.frames}))
        throw UnmetLock(*proven);
    }
    const auto place = static_cast<std::size_t>(error.key);
    if (error.key >= 0 && place < waypoints_.size()) error.key = waypoints_[place].key;
    throw SolverError(error);
  }
  KeyTiming timing = *adjusting;
  control_values_.assign(timing.control_values.begin(), timing.control_values.end());
  timing.control_values = control_values_;
  key_timing_ = timing;
  for (KeyLock& lock : completed_locks_) {
    const auto place = static_cast<std::size_t>(lock.key);
    if (place >= waypoints_.size()) continue;  // memory beyond the locks that there are
    const bool inside = lock.key > 0 && place + 1 < waypoints_.size();
    lock.key = waypoints_[place].is_key ? waypoints_[place].key : -1;
    if (lock.breaks && inside) breaks_.push_back({waypoints_[place].segment, lock.frame});
  }
}

Path MeasuredPath::make_path(const TrackSpec& spec) {
  if (spec.cubics) {
    cubics_.resize(spec.cubics->cubics.size() + spec.cubics->weights.size());
    weights_.resize(spec.cubics->weights.size());
    knots_.resize(spec.cubics->knots.size());
    return value_or_throw(Path::make_of_cubics(*spec.cubics, {cubics_, weights_, knots_}));
  }
  PathSpec path = spec.path;
  const auto axes = static_cast<std::size_t>(std::max(path.axis_count, 1));
  std::size_t rows = path.keys.size() / axes + 1;
  if (is_path_over_frames(spec)) {
    path.key_frames = spec.key_frames;
    path.rests_at_start = spec.rests_at_start;
    path.rests_at_end = spec.rests_at_end;
  }
  if (!path.key_frames.empty() || !path.path_tolerances.empty()) {
    rows *= max_segments_between_keys;
    knots_.resize(rows);
  }
  cubics_.resize(rows * axes);
  weights_.resize(axes);
  return value_or_throw(Path::make(path, {cubics_, weights_, knots_}));
}

ArcLength MeasuredPath::make_arc_length(const ArcLengthOptions& options) {
  const auto segments = static_cast<std::size_t>(path_->segment_count());
  first_pieces_.resize(segments + 1);
  segment_begins_.resize(segments + 1);
  const std::size_t usual = segments > many_segments ? usual_pieces_of_many : usual_pieces_per_segment;
  std::size_t pieces = usual * std::max<std::size_t>(segments, 1);
  for (;;) {
    pieces_.resize(pieces);
    begins_.resize(pieces);
    buckets_.resize(4 * pieces);
    const Result<ArcLength> result =
        ArcLength::make(*path_, options, {pieces_, begins_, buckets_, first_pieces_, segment_begins_});
    const bool too_small = !result && result.error().code == ErrorCode::capacity;
    if (!too_small) return value_or_throw(result);
    pieces = static_cast<std::size_t>(result.error().needed);
  }
}

SpeedProfile SolvedTrack::make_profile(std::span<const double> control_values, CurveEnds ends) {
  spans_.resize(control_values.size() + 1);
  integrals_.resize(control_values.size() + 2);
  return value_or_throw(SpeedProfile::make(control_values, {spans_, integrals_}, ends));
}

}  // namespace inbetween
