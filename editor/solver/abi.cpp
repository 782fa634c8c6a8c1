// The functions that the page calls (editor/page/src/solver.ts is the other side). Arguments and answers are
// in the records and the two arrays of Exchange; a function answers 1, or 0 after an error, which ib_error
// then tells.
#include <algorithm>
#include <optional>

#include "editor/solver/session.hpp"
#include "inbetween/base/hash.hpp"
#include "inbetween/joints/joint_tree.hpp"

namespace inbetween::editor {
namespace {

// They hold one move at a time, and a page has one thread.
Session session;
Exchange exchange;

/// As many links as a URDF file may have.
constexpr std::size_t max_arm_joints = 256;
/// ib_poses reads from the second half of the numbers and writes into the first.
constexpr std::size_t pose_numbers = max_numbers / 2;
JointStorage<max_arm_joints> joint_memory;
std::optional<JointTree> tree;

std::int32_t answer(const Status& status) {
  if (status) return 1;
  exchange.error = status.error();
  return 0;
}

void write_peak(Writer& out, const Peak& peak) {
  out.number(peak.value);
  out.number(peak.frame);
}

MoveReport report(const Certificate& found) {
  MoveReport report{};
  report.first_frame = found.move().first_frame();
  report.last_frame = found.move().last_frame();
  if (!found.has_limits()) return report;
  const std::optional<Breach> first = found.first_breach();
  const Breach breach = first.value_or(Breach{});
  const LongestStop longest = found.stops() ? found.stops()->longest_in_time() : LongestStop{};
  return {.first_frame = found.move().first_frame(),
          .last_frame = found.move().last_frame(),
          .axis_count = static_cast<std::int32_t>(found.peaks().size() - found.motor_count()),
          .motor_count = static_cast<std::int32_t>(found.motor_count()),
          .cell_count = static_cast<std::int32_t>(found.cell_count()),
          .step_count = static_cast<std::int32_t>(found.steps().size()),
          .steps_left_out = static_cast<std::int32_t>(found.steps_left_out()),
          .stops_are_proven = found.stops() ? 1 : 0,
          .breach_kind = first ? static_cast<std::int32_t>(breach.kind) + 1 : 0,
          .breach_axis = breach.axis,
          .breach_quantity = breach.quantity,
          .highest_rate = found.highest_rate(),
          .longest_stop_seconds = longest.length.seconds,
          .longest_stop_frames = longest.length.frames,
          .longest_stop_from_frame = longest.from_frame,
          .breach_value = breach.value,
          .breach_limit = breach.limit,
          .breach_frame = breach.frame};
}

FrameTime time_at(double frame) {
  return moved_by({0, 0}, frame);
}

/// A point of a track at s, which is i at key i: of an open path of n keys up to n - 1.
PathPoint point_at(const Path& path, double s) {
  std::int32_t first = 0;
  std::int32_t count = path.segment_count();
  while (count > 0) {  // the last segment that does not begin behind s
    const std::int32_t half = count / 2;
    const bool is_before = path.parameter({first + half, 1}) <= s;
    if (is_before) first += half + 1;
    count = is_before ? count - half - 1 : half;
  }
  if (first == path.segment_count()) return {first, 0};
  const double begin = path.parameter({first, 0});
  return {first, std::clamp((s - begin) / (path.parameter({first, 1}) - begin), 0.0, 1.0)};
}

}  // namespace
}  // namespace inbetween::editor

// The functions below have C names, which no namespace holds.
using namespace inbetween;
using namespace inbetween::editor;

extern "C" {

double* ib_numbers() {
  return exchange.numbers.data();
}

std::int32_t* ib_integers() {
  return exchange.integers.data();
}

Records* ib_records() {
  return &exchange.records;
}

/// The fields of the records, from 0 on: the name, the distance from the beginning in bytes, and 1 for a
/// double or 0 for an integer of 32 bits.
std::int32_t ib_field_count() {
  return static_cast<std::int32_t>(record_fields.size());
}
const char* ib_field_name(std::int32_t index) {
  return record_fields[static_cast<std::size_t>(index)].name;
}
std::int32_t ib_field_offset(std::int32_t index) {
  return static_cast<std::int32_t>(record_fields[static_cast<std::size_t>(index)].offset);
}
std::int32_t ib_field_is_number(std::int32_t index) {
  return record_fields[static_cast<std::size_t>(index)].is_number ? 1 : 0;
}

/// Writes the error report.
void ib_error() {
  const Error& error = exchange.error;
  exchange.records.error_report = {.code = static_cast<std::int32_t>(error.code),
                                   .key = error.key,
                                   .axis = error.axis,
                                   .control_value = error.control_value,
                                   .frame = error.frame,
                                   .needed = static_cast<std::int32_t>(error.needed)};
}
const char* ib_error_what() {
  return exchange.error.what;
}
const char* ib_error_remedy() {
  return exchange.error.remedy;
}

std::int32_t ib_solve(std::int32_t track) {
  return answer(session.solve_track(track, exchange));
}

std::int32_t ib_assemble() {
  return answer(session.assemble(exchange));
}

/// Writes the track report. Returns 0 if the track is not solved, as the functions below do.
std::int32_t ib_track(std::int32_t index) {
  const TrackSlot* const slot = session.solved(index);
  if (slot == nullptr) return 0;
  const Track& track = slot->track();
  const std::uint64_t hash = hash_of(slot->table().points());
  exchange.records.track_report = {
      .hash_low = static_cast<std::int32_t>(static_cast<std::uint32_t>(hash)),
      .hash_high = static_cast<std::int32_t>(static_cast<std::uint32_t>(hash >> 32U)),
      .frames = track.frames(),
      .segment_count = track.path().segment_count(),
      .key_count = track.path().key_count(),
      .piece_count = track.arc_length().piece_count(),
      .played_value_count = static_cast<std::int32_t>(slot->played_values().size()),
      .length = track.arc_length().total(),
      .constant = track.constant(),
      .total_integral = track.has_profile() ? track.profile().total_integral() : 0};
  return 1;
}

/// Numbers: the control values that are played.
std::int32_t ib_played_values(std::int32_t index) {
  const TrackSlot* const slot = session.solved(index);
  if (slot == nullptr) return 0;
  Writer out(exchange);
  for (const double value : slot->played_values()) out.number(value);
  return static_cast<std::int32_t>(slot->played_values().size());
}

/// Numbers: the position of every axis at `per_segment` equal steps of each segment, and at the end.
std::int32_t ib_path(std::int32_t index, std::int32_t per_segment) {
  const TrackSlot* const slot = session.solved(index);
  if (slot == nullptr || per_segment < 1) return 0;
  const Path& path = slot->track().path();
  Writer out(exchange);
  const auto write = [&](const PathPoint& point) {
    for (std::int32_t d = 0; d < path.axis_count(); ++d) out.number(path.position(point, d));
  };
  for (std::int32_t i = 0; i < path.segment_count(); ++i) {
    for (std::int32_t k = 0; k < per_segment; ++k) {
      write({i, static_cast<double>(k) / static_cast<double>(per_segment)});
    }
  }
  write({path.segment_count(), 0});
  return path.segment_count() * per_segment + 1;
}

/// Numbers: for every frame s, distance, speed, acceleration, then the position of every axis, which is that
/// of the table.
std::int32_t ib_frames(std::int32_t index) {
  const TrackSlot* const slot = session.solved(index);
  if (slot == nullptr) return 0;
  const Track& track = slot->track();
  Writer out(exchange);
  for (std::int32_t frame = 0; frame <= track.frames(); ++frame) {
    const FrameRow row = frame_row(track, slot->table(), frame);
    out.number(track.path().parameter(row.point));
    out.number(row.distance);
    out.number(row.speed);
    out.number(row.acceleration);
    for (std::int32_t d = 0; d < track.path().axis_count(); ++d) {
      out.number(track.path().position(row.point, d));
    }
  }
  return track.frames() + 1;
}

/// Numbers: `samples` pairs of the speed curve phi (0 where a track has none) and of the speed along the
/// path, in equal steps from frame 0 to frame N.
std::int32_t ib_speed(std::int32_t index, std::int32_t samples) {
  const TrackSlot* const slot = session.solved(index);
  if (slot == nullptr || samples < 2) return 0;
  const Track& track = slot->track();
  Writer out(exchange);
  for (std::int32_t i = 0; i < samples; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(samples - 1);
    const double frame = share * track.frames();
    out.number(track.has_profile() ? track.profile().value(share * track.profile().span_count()) : 0);
    out.number(track.along(time_at(frame)).speed);
  }
  return samples;
}

/// Every segment, and the end of the path, has an integer: the key that is passed there, or -1. It has these
/// numbers: the frame, s, and the position of every axis.
std::int32_t ib_key_frames(std::int32_t index) {
  const TrackSlot* const slot = session.solved(index);
  if (slot == nullptr) return 0;
  const Track& track = slot->track();
  Writer out(exchange);
  for (std::int32_t i = 0; i <= track.path().segment_count(); ++i) {
    const std::int32_t key = track.path().key_at(i).value_or(-1);
    out.integer(key);
    out.number(slot->frame_of_key(key, i));
    out.number(track.path().parameter({i, 0}));
    for (std::int32_t d = 0; d < track.path().axis_count(); ++d) out.number(track.path().position({i, 0}, d));
  }
  return track.path().segment_count() + 1;
}

/// Numbers: the position of every axis at s, which is i at key i.
std::int32_t ib_at(std::int32_t index, double s) {
  const TrackSlot* const slot = session.solved(index);
  if (slot == nullptr) return 0;
  const Path& path = slot->track().path();
  const PathPoint point = point_at(path, s);
  Writer out(exchange);
  for (std::int32_t d = 0; d < path.axis_count(); ++d) out.number(path.position(point, d));
  return 1;
}

/// Writes the move report. Motors stand behind the axes wherever one is named. Integers: for each cell the
/// axis and the quantity of its ceiling; for each step track, key, axis. Numbers: for each axis and motor
/// lowest, highest, velocity, acceleration and jerk, each a value and its frame; for each track and cell the
/// rate at which it keeps the limits; for each step frame, velocity and acceleration.
std::int32_t ib_certificate() {
  if (!session.is_assembled()) return 0;
  const Certificate& found = session.certificate();
  exchange.records.move_report = report(found);
  if (!found.has_limits()) return 1;
  Writer out(exchange);
  for (const AxisPeaks& axis : found.peaks()) {
    for (const Peak& peak : {axis.lowest, axis.highest, axis.velocity, axis.acceleration, axis.jerk}) {
      write_peak(out, peak);
    }
  }
  for (std::size_t t = 0; t < found.tracks().size(); ++t) {
    for (const CellCeiling& cell : found.cells(t)) {
      out.number(cell.rate);
      out.integer(cell.axis);
      out.integer(cell.quantity);
    }
  }
  for (const MoveStep& step : found.steps()) {
    out.integer(static_cast<std::int32_t>(step.track));
    out.integer(step.key);
    out.integer(static_cast<std::int32_t>(step.axis));
    out.number(step.frame);
    out.number(step.velocity);
    out.number(step.acceleration);
  }
  return 1;
}

/// Numbers: position, velocity, acceleration and jerk of every axis of the move at `samples` frames from
/// `first` in steps of `step` frames.
std::int32_t ib_motion(double first, double step, std::int32_t samples) {
  if (!session.is_assembled()) return 0;
  const Certificate& certificate = session.certificate();
  std::array<AxisMotion, max_move_axes> motion;
  const std::span<AxisMotion> axes = std::span(motion).first(certificate.move().axis_count());
  Writer out(exchange);
  for (std::int32_t i = 0; i < samples; ++i) {
    certificate.motion(time_at(first + step * i), axes);
    for (const AxisMotion& axis : axes) {
      for (const double number : {axis.position, axis.velocity, axis.acceleration, axis.jerk})
        out.number(number);
    }
  }
  return samples;
}

/// The joints of the rig, of which ib_poses knows from then on. Integers: kind, parent and coordinate of each
/// joint. Numbers of each joint: factor, offset, place and three axes of its origin, its own axis.
std::int32_t ib_joints(std::int32_t joint_count, std::int32_t coordinate_count) {
  std::array<Joint, max_arm_joints> joints;
  if (joint_count < 0 || static_cast<std::size_t>(joint_count) > max_arm_joints) return 0;
  Reader in(exchange);
  const auto vector = [&] {
    const double x = in.number();
    const double y = in.number();
    return Vector3{x, y, in.number()};
  };
  for (Joint& joint : std::span(joints).first(static_cast<std::size_t>(joint_count))) {
    joint.kind = static_cast<JointKind>(std::clamp(in.integer(), 0, 2));
    joint.parent = in.integer();
    joint.coordinate = in.integer();
    joint.factor = in.number();
    joint.offset = in.number();
    joint.origin.position = vector();
    joint.origin.rotation.x = vector();
    joint.origin.rotation.y = vector();
    joint.origin.rotation.z = vector();
    joint.axis = vector();
  }
  const auto made = JointTree::make(std::span(joints).first(static_cast<std::size_t>(joint_count)),
                                    coordinate_count, joint_memory);
  tree = made ? std::optional(*made) : std::nullopt;
  return made ? 1 : answer(made.error());
}

/// Numbers in: the coordinates of `count` moments, one after the other. Numbers out: where each link is then,
/// x y z in metres.
std::int32_t ib_poses(std::int32_t count) {
  if (!tree) return 0;
  const std::size_t coordinates = tree->coordinate_count();
  std::array<double, max_move_axes> at;
  std::array<Pose, max_arm_joints> poses;
  const std::span<Pose> links = std::span(poses).first(tree->joints().size());
  if (count < 0 || coordinates > at.size() ||
      static_cast<std::size_t>(count) * std::max(3 * links.size(), coordinates) > pose_numbers)
    return 0;
  const std::span<const double> in = std::span(exchange.numbers).last(pose_numbers);
  Writer out(exchange);
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    std::ranges::copy(in.subspan(i * coordinates, coordinates), at.begin());
    if (const Status status = tree->poses(std::span(at).first(coordinates), links); !status)
      return answer(status);
    for (const Pose& pose : links) {
      for (const double number : {pose.position.x, pose.position.y, pose.position.z}) out.number(number);
    }
  }
  return 1;
}

}  // extern "C"
