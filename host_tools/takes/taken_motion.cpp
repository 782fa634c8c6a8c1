#include "host_tools/takes/taken_motion.hpp"

#include <cstddef>
#include <cstdint>

#include "host_tools/takes/byte_text.hpp"

namespace inbetween {
namespace {

constexpr std::uint8_t motion_version = 1;
/// More than any rig has, so that a wrong number asks for no memory.
constexpr std::uint64_t max_motion_axes = 4096;

void write_time(const FrameTime& time, ByteWriter& out) {
  out.whole_signed(time.frame);
  out.number(time.fraction);
}
FrameTime read_time(ByteReader& in) {
  FrameTime time;
  time.frame = static_cast<std::int32_t>(in.whole_signed());
  time.fraction = in.number();
  return time;
}

void write_rolls(std::span<const RollAxis> rolls, ByteWriter& out) {
  out.whole(rolls.empty() ? 0 : static_cast<std::uint64_t>(rolls.front().span().frames));
  for (const RollAxis& roll : rolls) {
    // On the joint a roll has what it was made of, to the last bit.
    const AxisMotion joint = roll.motion({roll.span().joint_frame, 0});
    for (const double number : {joint.position, joint.velocity, joint.acceleration}) out.number(number);
  }
}

/// False where they are no rolls.
bool read_rolls(const MoveLength& whole, RollEnd end, std::int32_t joint_frame, ByteReader& in,
                std::vector<RollAxis>& rolls) {
  const auto frames = static_cast<std::int32_t>(in.whole());
  for (std::size_t axis = 0; frames != 0 && axis < whole.axes; ++axis) {
    AxisMotion joint;
    joint.position = in.number();
    joint.velocity = in.number();
    joint.acceleration = in.number();
    const auto roll =
        RollAxis::make({.end = end, .joint_frame = joint_frame, .frames = frames, .fps = whole.fps}, joint);
    if (!roll) return false;
    rolls.push_back(*roll);
  }
  return true;
}

void write_trajectory(const Trajectory& trajectory, ByteWriter& out) {
  out.whole(trajectory.axis_count());
  out.whole(trajectory.pieces().size());
  out.whole(trajectory.values().size());
  out.whole(trajectory.breaks().size());
  write_time(trajectory.end(), out);
  out.byte(trajectory.keeps_to_joints() ? 1 : 0);
  out.number(trajectory.loosened());
  for (const TrajectoryPiece& piece : trajectory.pieces()) {
    write_time(piece.begin, out);
    out.number(piece.inverse_frames);
    out.number(piece.seconds);
    out.whole(piece.begin_row);
    out.whole(piece.end_row);
    out.byte(piece.degree);
    out.byte(piece.is_exact ? 1 : 0);
  }
  for (const double value : trajectory.values()) out.number(value);
  for (const TrajectoryBreak& at : trajectory.breaks()) {
    write_time(at.time, out);
    out.whole(at.piece);
    out.whole_signed(at.key);
  }
}

TrajectoryPiece read_piece(ByteReader& in) {
  TrajectoryPiece piece;
  piece.begin = read_time(in);
  piece.inverse_frames = in.number();
  piece.seconds = in.number();
  piece.begin_row = static_cast<std::uint32_t>(in.whole());
  piece.end_row = static_cast<std::uint32_t>(in.whole());
  piece.degree = in.byte();
  piece.is_exact = in.byte() != 0;
  return piece;
}

}  // namespace

std::string bytes_of(const PlayedMotion& motion) {
  const Move& move = motion.move();
  ByteWriter out;
  out.byte(motion_version);
  out.whole(static_cast<std::uint64_t>(move.frames()));
  out.whole(static_cast<std::uint64_t>(move.frame_rate().numerator));
  out.whole(static_cast<std::uint64_t>(move.frame_rate().denominator));
  out.whole(move.axis_count());
  out.whole(static_cast<std::uint64_t>(move.part().first));
  out.whole(static_cast<std::uint64_t>(move.part().last));
  write_rolls(move.rolls().before, out);
  write_rolls(move.rolls().after, out);
  out.whole(motion.trajectories().size());
  for (const Trajectory& trajectory : motion.trajectories()) write_trajectory(trajectory, out);
  return std::move(out.text());
}

std::unique_ptr<TakenMotion> TakenMotion::read(std::string_view bytes) {
  ByteReader in(bytes);
  if (in.byte() != motion_version) return nullptr;
  std::unique_ptr<TakenMotion> taken(new TakenMotion);
  MoveLength whole;
  whole.frames = static_cast<std::int32_t>(in.whole());
  whole.fps.numerator = static_cast<std::int32_t>(in.whole());
  whole.fps.denominator = static_cast<std::int32_t>(in.whole());
  whole.axes = static_cast<std::size_t>(in.whole());
  WholeFrames part;
  part.first = static_cast<std::int32_t>(in.whole());
  part.last = static_cast<std::int32_t>(in.whole());
  if (whole.axes > max_motion_axes || !read_rolls(whole, RollEnd::before, part.first, in, taken->before_) ||
      !read_rolls(whole, RollEnd::after, part.last, in, taken->after_))
    return nullptr;
  const std::uint64_t trajectories = in.whole();
  for (std::uint64_t t = 0; t < trajectories; ++t) {
    const std::uint64_t axes = in.whole(), pieces = in.whole(), values = in.whole(), breaks = in.whole();
    const FrameTime end = read_time(in);
    const bool keeps_to_joints = in.byte() != 0;
    const double loosened = in.number();
    // Each takes at least a byte.
    if (axes > max_motion_axes || pieces > in.left() || values > in.left() || breaks > in.left())
      return nullptr;
    Row& row = *taken->rows_.emplace_back(std::make_unique<Row>());
    for (std::uint64_t i = 0; i < pieces; ++i) row.pieces.push_back(read_piece(in));
    for (std::uint64_t i = 0; i < values; ++i) row.values.push_back(in.number());
    for (std::uint64_t i = 0; i < breaks; ++i) {
      TrajectoryBreak at;
      at.time = read_time(in);
      at.piece = static_cast<std::uint32_t>(in.whole());
      at.key = static_cast<std::int32_t>(in.whole_signed());
      row.breaks.push_back(at);
    }
    row.buckets.resize(2 * row.pieces.size() + 2);
    const auto trajectory = Trajectory::make({.axis_count = static_cast<std::size_t>(axes),
                                              .fps = whole.fps,
                                              .end = end,
                                              .pieces = row.pieces,
                                              .values = row.values,
                                              .breaks = row.breaks,
                                              .keeps_to_joints = keeps_to_joints,
                                              .loosened = loosened},
                                             row.buckets);
    if (!trajectory) return nullptr;
    taken->trajectories_.push_back(*trajectory);
  }
  if (in.is_short() || in.left() != 0) return nullptr;
  const auto move = Move::make(whole, {taken->before_, taken->after_}, part);
  if (!move) return nullptr;
  const auto motion = PlayedMotion::make(*move, taken->trajectories_);
  if (!motion) return nullptr;
  taken->motion_ = *motion;
  return taken;
}

}  // namespace inbetween
