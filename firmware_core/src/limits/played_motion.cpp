#include "inbetween/limits/played_motion.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween {
namespace {

/// Less than this share of what an axis does on a piece is rounding.
constexpr double rest_share = 1e-12;

double without_rounding(double value, double size) {
  return std::fabs(value) > rest_share * size ? value : 0;
}

/// The ends of a loop are in one place where they are within this share of the position.
constexpr double loop_rounding = 1e-12;

double position_of(const PlayedMotion& motion, std::size_t axis, const FrameTime& time) {
  const Move& move = motion.move();
  const std::span<const RollAxis> rolls = move.rolls_at(time);
  if (!rolls.empty()) return rolls[axis].motion(time).position;
  for (const Trajectory& trajectory : motion.trajectories()) {
    if (axis < trajectory.axis_count()) return trajectory.motion_of(axis, move.within_part(time)).position;
    axis -= trajectory.axis_count();
  }
  return 0;
}

/// The piece that a motion arrives with on a frame, or leaves it with.
std::size_t piece_beside(const Trajectory& trajectory, const FrameTime& at, bool arriving) {
  for (const TrajectoryBreak& one : trajectory.breaks()) {
    if (std::fabs(frames_between(at, one.time)) <= frame_rounding)
      return arriving ? one.piece - 1 : one.piece;
  }
  const std::size_t piece = trajectory.piece_at(at);
  return arriving && piece > 0 && trajectory.pieces()[piece].begin == at ? piece - 1 : piece;
}

/// Of a frame inside the trajectory.
void write_joint(const Trajectory& trajectory, const FrameTime& at, bool arriving,
                 std::span<AxisMotion> out) {
  const std::size_t index = piece_beside(trajectory, at, arriving);
  const TrajectoryPiece& piece = trajectory.pieces()[index];
  const FrameTime end = trajectory.end_of(index);
  trajectory.motion(at, out);
  const bool is_at_end = std::fabs(frames_between(at, arriving ? end : piece.begin)) <= frame_rounding;
  for (std::size_t d = 0; d < out.size(); ++d) {
    const auto value = [&](std::size_t derivative, bool of_end) {
      return at_end_of_piece(trajectory, piece, d, derivative, of_end);
    };
    if (is_at_end) {
      out[d].velocity = value(1, arriving);
      out[d].acceleration = value(2, arriving);
    }
    const double speed = std::max({std::fabs(value(1, false)), std::fabs(value(1, true)),
                                   std::fabs(value(0, true) - value(0, false)) / piece.seconds});
    const double change =
        std::max({std::fabs(value(2, false)), std::fabs(value(2, true)), speed / piece.seconds});
    out[d].velocity = without_rounding(out[d].velocity, speed);
    out[d].acceleration = without_rounding(out[d].acceleration, change);
    out[d].jerk = 0;
  }
}

/// The roll that begins or ends with the motion at `joints`, written to `out`, or the obstacle.
Result<std::optional<RollBreach>> make_roll(const RollRequest& request, std::span<RollAxis> out) {
  const auto frames = roll_frames(request);
  if (!frames && frames.error().code == ErrorCode::no_solution) return roll_obstacle(request);
  if (!frames) return frames.error();
  const RollSpan span{request.end, request.joint_frame, *frames, request.fps};
  for (std::size_t d = 0; d < request.joints.size(); ++d) {
    const auto axis = RollAxis::make(span, request.joints[d]);
    if (!axis) return axis.error();
    out[d] = *axis;
  }
  return std::optional<RollBreach>();
}

Error wrong_length() {
  return {.code = ErrorCode::out_of_range,
          .what = "a trajectory of a move does not last as long as the move",
          .remedy = "fit it to a whole track"};
}

bool lasts(const Trajectory& trajectory, const Move& move, std::int32_t first, std::int32_t last) {
  return trajectory.begin() == FrameTime{first, 0} && trajectory.end() == FrameTime{last, 0} &&
         trajectory.frame_rate() == move.frame_rate();
}

Status check_motor(const PlayedMotor& motor, const Move& move) {
  const auto is_there = [](const Trajectory* one, bool needed) {
    return needed ? one != nullptr && one->axis_count() == 1 : one == nullptr;
  };
  const bool is_complete = motor.axis < move.axis_count() && is_there(motor.whole, true) &&
                           is_there(motor.pre_roll, !move.rolls().before.empty()) &&
                           is_there(motor.post_roll, !move.rolls().after.empty());
  if (!is_complete) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "a motor has not a trajectory for the move and for each of its rolls",
                 .remedy = "fit one to each, and none where there is no roll",
                 .needed = 1};
  }
  const bool is_whole =
      lasts(*motor.whole, move, 0, move.frames()) &&
      (motor.pre_roll == nullptr || lasts(*motor.pre_roll, move, move.first_frame(), move.part().first)) &&
      (motor.post_roll == nullptr || lasts(*motor.post_roll, move, move.part().last, move.last_frame()));
  return is_whole ? Status(Done{}) : Status(wrong_length());
}

}  // namespace

bool joints_of_part(std::span<const Track> tracks, std::span<const Trajectory> trajectories,
                    const WholeFrames& part, RollEnd end, std::span<AxisMotion> out) {
  const bool arriving = end == RollEnd::after;
  const std::int32_t frame = arriving ? part.last : part.first;
  if (frame == (arriving ? tracks.front().frames() : 0)) return joints_of(tracks, end, out);
  bool moves = false;
  for (const Trajectory& trajectory : trajectories) {
    const std::span<AxisMotion> joints = out.first(trajectory.axis_count());
    out = out.subspan(trajectory.axis_count());
    write_joint(trajectory, {frame, 0}, arriving, joints);
    for (const AxisMotion& joint : joints) moves = moves || joint.velocity != 0 || joint.acceleration != 0;
  }
  return moves;
}

Result<JoinedRolls> join_rolls(std::span<const Track> tracks, std::span<const Trajectory> trajectories,
                               std::span<const AxisLimits> limits, const WholeFrames& part,
                               const RollMemory& memory) {
  const Result<MoveLength> length = length_of(tracks);
  if (!length) return length.error();
  const std::size_t axes = length->axes;
  if (limits.size() != axes || memory.joints.size() != axes || memory.before.size() != axes ||
      memory.after.size() != axes) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "there are not as many limits or rolls as axes",
                 .remedy = "give one of each for every axis of all tracks",
                 .needed = static_cast<std::int64_t>(axes)};
  }
  JoinedRolls joined;
  for (const RollEnd end : {RollEnd::before, RollEnd::after}) {
    if (!joints_of_part(tracks, trajectories, part, end, memory.joints)) continue;
    const bool is_before = end == RollEnd::before;
    const std::span<RollAxis> rolls = is_before ? memory.before : memory.after;
    const auto breach = make_roll({.end = end,
                                   .joint_frame = is_before ? part.first : part.last,
                                   .fps = length->fps,
                                   .joints = memory.joints,
                                   .limits = limits},
                                  rolls);
    if (!breach) return breach.error();
    if (*breach) {
      const double position = memory.joints[static_cast<std::size_t>((*breach)->axis)].position;
      joined.obstacles[is_before ? 0 : 1] = {end, **breach, position};
    } else {
      (is_before ? joined.rolls.before : joined.rolls.after) = rolls;
    }
  }
  return joined;
}

Result<PlayedMotion> PlayedMotion::make(const Move& move, std::span<const Trajectory> trajectories,
                                        std::span<const PlayedMotor> motors) {
  std::size_t axes = 0;
  for (const Trajectory& trajectory : trajectories) axes += trajectory.axis_count();
  if (axes != move.axis_count()) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "the trajectories of a move have not as many axes as the move",
                 .remedy = "fit one to each of its tracks",
                 .needed = static_cast<std::int64_t>(move.axis_count())};
  }
  for (const Trajectory& trajectory : trajectories) {
    if (!lasts(trajectory, move, 0, move.frames())) return wrong_length();
  }
  for (const PlayedMotor& motor : motors) {
    const Status checked = check_motor(motor, move);
    if (!checked) return checked.error();
  }
  return PlayedMotion(move, trajectories, motors);
}

void PlayedMotion::positions(const FrameTime& time, std::span<double> out) const {
  const std::span<const RollAxis> rolls = move_.rolls_at(time);
  for (std::size_t d = 0; d < rolls.size(); ++d) out[d] = rolls[d].motion(time).position;
  if (!rolls.empty()) return;
  const FrameTime within = move_.within_part(time);
  for (const Trajectory& trajectory : trajectories_) {
    trajectory.positions(within, out.first(trajectory.axis_count()));
    out = out.subspan(trajectory.axis_count());
  }
}

void PlayedMotion::motion(const FrameTime& time, std::span<AxisMotion> out) const {
  const std::span<const RollAxis> rolls = move_.rolls_at(time);
  for (std::size_t d = 0; d < rolls.size(); ++d) out[d] = rolls[d].motion(time);
  if (!rolls.empty()) return;
  const FrameTime within = move_.within_part(time);
  for (const Trajectory& trajectory : trajectories_) {
    const std::span<AxisMotion> axes = out.first(trajectory.axis_count());
    trajectory.motion(within, axes);
    // A part rests where no roll joins it.
    for (AxisMotion& axis : axes) {
      if (move_.rests_at(time)) axis = {.position = axis.position};
    }
    out = out.subspan(trajectory.axis_count());
  }
}

AxisMotion PlayedMotion::motion_of(const PlayedMotor& motor, const FrameTime& time) const {
  const bool is_rolled = !move_.rolls_at(time).empty();
  if (is_rolled)
    return (time.frame < move_.part().first ? motor.pre_roll : motor.post_roll)->motion_of(0, time);
  const AxisMotion motion = motor.whole->motion_of(0, move_.within_part(time));
  return move_.rests_at(time) ? AxisMotion{.position = motion.position} : motion;
}

Status can_loop(const PlayedMotion& motion) {
  const Move& move = motion.move();
  for (std::size_t d = 0; d < move.axis_count(); ++d) {
    const double first = position_of(motion, d, {move.first_frame(), 0});
    const double last = position_of(motion, d, {move.last_frame(), 0});
    const double size = std::max(std::fabs(first), std::fabs(last));
    if (std::fabs(first - last) <= loop_rounding * size) continue;
    return Error{.code = ErrorCode::no_solution,
                 .what = "a loop would step: the axis rests elsewhere at the end than at the start",
                 .remedy = "end the move where it starts, at rest, or play it to and fro",
                 .axis = static_cast<std::int32_t>(d)};
  }
  return Done{};
}

}  // namespace inbetween
