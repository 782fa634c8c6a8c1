#include "editor/solver/track_slot.hpp"

#include <algorithm>

namespace inbetween::editor {
namespace {

Error too_large(const char* what, std::size_t needed) {
  return {.code = ErrorCode::capacity,
          .what = what,
          .remedy = "edit the file as text; the command line plans it",
          .needed = static_cast<std::int64_t>(needed)};
}

/// As many numbers as the memory of a slot has room for; the core itself refuses the rest.
Status fits(const TrackInput& input) {
  const auto axes = static_cast<std::size_t>(std::max(input.path.axis_count, 1));
  if (axes > max_axes) return too_large("the track has more axes than this page solves", axes);
  const std::size_t keys = input.path.keys.size() / axes;
  if (keys > max_keys) return too_large("the track has more keys than this page solves", keys);
  if (input.locks.size() > max_locks) {
    return too_large("the track has more locked keys than this page solves", input.locks.size());
  }
  if (input.frames > 0 && static_cast<std::size_t>(input.frames) > max_table_frames) {
    return too_large("the move has more frames than this page solves",
                     static_cast<std::size_t>(input.frames));
  }
  return Done{};
}

}  // namespace

Status TrackSlot::solve(const TrackInput& input) {
  track_.reset();
  table_.reset();
  played_ = {};
  timing_.reset();
  break_count_ = 0;
  if (const Status fitting = fits(input); !fitting) return fitting;
  const auto path = make_path(input);
  if (!path) return path.error();
  const auto arc_length = ArcLength::make(*path, {}, arc_length_.memory());
  if (!arc_length) return arc_length.error();
  const auto track = make_track(input, *path, *arc_length);
  if (!track) return track.error();
  const auto table = closed_form_table(*track, points_);
  if (!table) return table.error();
  track_ = *track;
  table_ = *table;
  return Done{};
}

Result<Path> TrackSlot::make_path(const TrackInput& input) {
  const PathMemory memory{cubics_, weights_, knots_};
  if (input.cubics) return Path::make_of_cubics(*input.cubics, memory);
  PathSpec path = input.path;
  if (!input.key_frames.empty() && input.kinetic == Kinetic::curves) path.key_frames = input.key_frames;
  return Path::make(path, memory);
}

Result<Track> TrackSlot::make_track(const TrackInput& input, const Path& path, const ArcLength& arc_length) {
  if (!input.key_frames.empty()) {
    return Track::make_with_key_frames(path, arc_length, input.key_frames, input.kinetic, input.frames,
                                       input.fps, {.key_intervals = key_intervals_});
  }
  if (input.control_values.size() > max_values) {
    return too_large("the speed curve has more control values than this page solves",
                     input.control_values.size());
  }
  std::ranges::copy(input.control_values, values_.begin());
  std::size_t count = input.control_values.size();
  if (count == 1) values_[count++] = values_[0];
  played_ = std::span(values_).first(count);
  if (!input.locks.empty()) {
    if (const Status adjusted = adjust(input, path, arc_length); !adjusted) return adjusted.error();
  }
  const auto profile = SpeedProfile::make(played_, profile_.memory(), input.ends);
  if (!profile) return profile.error();
  return Track::make_with_breaks(path, arc_length, *profile, input.frames, input.fps,
                                 std::span(breaks_).first(break_count_),
                                 {.span_distances = span_distances_, .portions = portions_});
}

Status TrackSlot::adjust(const TrackInput& input, const Path& path, const ArcLength& arc_length) {
  // The profile's own checks come first, so that a bad control value is named as such.
  if (const auto drawn = SpeedProfile::make(played_, profile_.memory(), input.ends); !drawn) {
    return drawn.error();
  }
  std::size_t count = 0;
  for (std::int32_t i = 0; i <= path.segment_count(); ++i) {
    if (path.key_at(i)) distances_[count++] = arc_length.segment_begin(i).high;
  }
  const auto timing = adjust_to_locks({.control_values = played_,
                                       .key_distances = std::span(distances_).first(count),
                                       .locks = input.locks,
                                       .frames = input.frames,
                                       .ends = input.ends},
                                      key_timing_.memory());
  if (!timing) return timing.error();
  played_ = timing->control_values;
  timing_ = *timing;
  std::int32_t segment = 0;
  for (const KeyLock& lock : timing->locks) {  // in the order of the keys
    const bool is_inside = lock.key > 0 && static_cast<std::size_t>(lock.key) + 1 < count;
    if (!lock.breaks || !is_inside) continue;
    while (path.key_at(segment) != lock.key) ++segment;
    breaks_[break_count_++] = {segment, lock.frame};
  }
  return Done{};
}

double TrackSlot::frame_of_key(std::int32_t key, std::int32_t segment) const {
  if (timing_) {
    const auto lock = std::ranges::find(timing_->locks, key, &KeyLock::key);
    const bool is_inside = key > 0 && segment < track_->path().segment_count();
    if (lock != timing_->locks.end() && is_inside) return timing_->frame_of(*lock, track_->frames());
  }
  return frame_of_segment(*track_, segment);
}

}  // namespace inbetween::editor
