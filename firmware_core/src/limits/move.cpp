#include "inbetween/limits/move.hpp"

#include <algorithm>

namespace inbetween {
namespace {

Status check_rolls(std::span<const RollAxis> rolls, RollEnd end, const WholeFrames& part,
                   const FrameRate& fps, std::size_t axes) {
  if (rolls.empty()) return Done{};
  if (rolls.size() != axes) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "a roll has not as many axes as the move",
                 .remedy = "give it one for each axis of all tracks",
                 .needed = static_cast<std::int64_t>(axes)};
  }
  const std::int32_t joint_frame = end == RollEnd::before ? part.first : part.last;
  for (std::size_t d = 0; d < rolls.size(); ++d) {
    const RollSpan& span = rolls[d].span();
    if (span.end == end && span.joint_frame == joint_frame && span.frames == rolls.front().span().frames &&
        span.fps == fps) {
      continue;
    }
    return Error{
        .code = ErrorCode::out_of_range,
        .what = "a roll does not join the move",
        .remedy =
            "give all axes one number of frames, the frame rate of the move, and the first or last frame "
            "that is played",
        .axis = static_cast<std::int32_t>(d),
        .frame = joint_frame};
  }
  return Done{};
}

}  // namespace

bool is_moving(const Track& track, RollEnd end) {
  const bool at_start = end == RollEnd::before;
  if (!track.has_profile()) {
    const std::span<const KeyInterval> intervals = track.key_intervals();
    const KeyInterval& interval = at_start ? intervals.front() : intervals.back();
    const Path& path = track.path();
    const bool path_moves =
        std::ranges::any_of(path.segment(at_start ? 0 : path.segment_count()),
                            [](const Cubic& cubic) { return cubic.c1 != 0 || cubic.c2 != 0; });
    return path_moves && interval.rates(at_start ? 0.0 : 1.0, track.frame_rate()).first != 0;
  }
  const SpeedProfile& profile = track.profile();
  return (at_start ? profile.span(0).b0 : profile.span(profile.span_count() - 1).b3) > 0;
}

bool joints_of(std::span<const Track> tracks, RollEnd end, std::span<AxisMotion> out) {
  bool moves = false;
  for (const Track& track : tracks) {
    const auto axes = static_cast<std::size_t>(track.path().axis_count());
    const std::span<AxisMotion> joints = out.first(axes);
    out = out.subspan(axes);
    track.motion({end == RollEnd::before ? 0 : track.frames(), 0}, joints);
    const bool rests = !is_moving(track, end);
    for (AxisMotion& joint : joints) {
      if (rests) joint = {.position = joint.position};
      moves = moves || joint.velocity != 0 || joint.acceleration != 0;
    }
  }
  return moves;
}

Result<MoveLength> length_of(std::span<const Track> tracks) {
  if (tracks.empty())
    return Error{.code = ErrorCode::wrong_count, .what = "a move has no track", .remedy = "give it one"};
  MoveLength whole{.frames = tracks.front().frames(), .fps = tracks.front().frame_rate()};
  for (const Track& track : tracks) {
    if (track.frames() != whole.frames || track.frame_rate() != whole.fps) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "the tracks of a move differ in frames or frame rate",
                   .remedy = "solve all of them in the same"};
    }
    whole.axes += static_cast<std::size_t>(track.path().axis_count());
  }
  return whole;
}

Result<Move> Move::make(std::span<const Track> tracks, const MoveRolls& rolls,
                        const std::optional<WholeFrames>& part) {
  const Result<MoveLength> length = length_of(tracks);
  return length ? make(*length, rolls, part) : length.error();
}

Result<Move> Move::make(const MoveLength& whole, const MoveRolls& rolls,
                        const std::optional<WholeFrames>& part) {
  Move move(whole, rolls, part.value_or(WholeFrames{0, whole.frames}));
  if (move.part_.first < 0 || move.part_.first >= move.part_.last || move.part_.last > whole.frames) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a part of a move is not one of its frames to a later one",
                 .remedy = "give it a first and a later last frame of 0..N",
                 .needed = whole.frames};
  }
  for (const RollEnd end : {RollEnd::before, RollEnd::after}) {
    const std::span<const RollAxis> of_end = end == RollEnd::before ? rolls.before : rolls.after;
    const Status valid = check_rolls(of_end, end, move.part_, whole.fps, whole.axes);
    if (!valid) return valid.error();
  }
  return move;
}

}  // namespace inbetween
