#include "inbetween/limits/move.hpp"

#include <algorithm>

namespace inbetween {
namespace {

template <Precise Real>
Status check_rolls(std::span<const RollAxis<Real>> rolls, RollEnd end, const WholeFrames& part,
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

template <Precise Real>
bool is_moving(const Track<Real>& track, RollEnd end) {
  const bool at_start = end == RollEnd::before;
  if (!track.has_profile()) {
    const std::span<const KeyInterval<Real>> intervals = track.key_intervals();
    const KeyInterval<Real>& interval = at_start ? intervals.front() : intervals.back();
    const Path<Real>& path = track.path();
    const bool path_moves =
        std::ranges::any_of(path.segment(at_start ? 0 : path.segment_count()),
                            [](const Cubic<Real>& cubic) { return cubic.c1 != 0 || cubic.c2 != 0; });
    return path_moves && interval.rates(at_start ? Real{0} : Real{1}, track.frame_rate()).first != 0;
  }
  const SpeedProfile<Real>& profile = track.profile();
  return (at_start ? profile.span(0).b0 : profile.span(profile.span_count() - 1).b3) > 0;
}

template <Precise Real>
bool joints_of(std::span<const Track<Real>> tracks, RollEnd end, std::span<AxisMotion<Real>> out) {
  bool moves = false;
  for (const Track<Real>& track : tracks) {
    const auto axes = static_cast<std::size_t>(track.path().axis_count());
    const std::span<AxisMotion<Real>> joints = out.first(axes);
    out = out.subspan(axes);
    track.motion({end == RollEnd::before ? 0 : track.frames(), 0}, joints);
    const bool rests = !is_moving(track, end);
    for (AxisMotion<Real>& joint : joints) {
      if (rests) joint = {.position = joint.position};
      moves = moves || joint.velocity != 0 || joint.acceleration != 0;
    }
  }
  return moves;
}

template <Precise Real>
Result<MoveLength> length_of(std::span<const Track<Real>> tracks) {
  if (tracks.empty())
    return Error{.code = ErrorCode::wrong_count, .what = "a move has no track", .remedy = "give it one"};
  MoveLength whole{.frames = tracks.front().frames(), .fps = tracks.front().frame_rate()};
  for (const Track<Real>& track : tracks) {
    if (track.frames() != whole.frames || track.frame_rate() != whole.fps) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "the tracks of a move differ in frames or frame rate",
                   .remedy = "solve all of them in the same"};
    }
    whole.axes += static_cast<std::size_t>(track.path().axis_count());
  }
  return whole;
}

template <Precise Real>
Result<Move<Real>> Move<Real>::make(std::span<const Track<Real>> tracks, const MoveRolls<Real>& rolls,
                                    const std::optional<WholeFrames>& part) {
  const Result<MoveLength> length = length_of(tracks);
  if (!length) return length.error();
  const MoveLength& whole = *length;
  Move move(whole, rolls, part.value_or(WholeFrames{0, whole.frames}));
  if (move.part_.first < 0 || move.part_.first >= move.part_.last || move.part_.last > whole.frames) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a part of a move is not one of its frames to a later one",
                 .remedy = "give it a first and a later last frame of 0..N",
                 .needed = whole.frames};
  }
  for (const RollEnd end : {RollEnd::before, RollEnd::after}) {
    const std::span<const RollAxis<Real>> of_end = end == RollEnd::before ? rolls.before : rolls.after;
    const Status valid = check_rolls(of_end, end, move.part_, whole.fps, whole.axes);
    if (!valid) return valid.error();
  }
  return move;
}

template bool is_moving(const Track<double>&, RollEnd);
template bool is_moving(const Track<float>&, RollEnd);
template bool joints_of(std::span<const Track<double>>, RollEnd, std::span<AxisMotion<double>>);
template bool joints_of(std::span<const Track<float>>, RollEnd, std::span<AxisMotion<float>>);
template Result<MoveLength> length_of(std::span<const Track<double>>);
template Result<MoveLength> length_of(std::span<const Track<float>>);
template class Move<double>;
template class Move<float>;

}  // namespace inbetween
