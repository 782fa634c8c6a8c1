#include "editor/solver/session.hpp"

#include <cmath>
#include <memory>
#include <optional>

namespace inbetween::editor {
namespace {

constexpr Error incomplete{
    .code = ErrorCode::wrong_count, .what = "the page's call is incomplete", .remedy = "load the page again"};

constexpr Error unknown_word{.code = ErrorCode::out_of_range,
                             .what = "the page names a spline or a kinetic that this solver does not know",
                             .remedy = "load the page again"};

std::optional<double> given(double value) {
  return std::isnan(value) ? std::nullopt : std::optional(value);
}

bool is_count(std::int32_t value, std::size_t most) {
  return value >= 0 && static_cast<std::size_t>(value) <= most;
}

/// The memory of a session has room for what a track is read into; that of a slot is looked at where it is
/// solved.
bool has_room_for(const TrackRequest& request) {
  return is_count(request.axis_count, max_axes) && request.axis_count >= 1 &&
         is_count(request.key_count, max_keys) && is_count(request.lock_count, max_locks) &&
         is_count(request.weight_count, max_axes + max_guides) && is_count(request.shape_count, max_keys) &&
         is_count(request.segment_count, max_segments) && is_count(request.corner_count, max_keys);
}

bool has_known_words(const TrackRequest& request) {
  return is_count(request.spline, static_cast<std::size_t>(Spline::linear)) &&
         is_count(request.kinetic, static_cast<std::size_t>(Kinetic::curves));
}

}  // namespace

Status Session::solve_track(std::int32_t index, const Exchange& arguments) {
  assembled_ = false;
  if (index < 0 || static_cast<std::size_t>(index) >= max_tracks) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the move has more tracks than this page solves",
                 .remedy = "edit the file as text; the command line plans it",
                 .needed = index + 1};
  }
  const TrackRequest& request = arguments.records.track_request;
  if (!has_room_for(request)) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the track is larger than this page solves",
                 .remedy = "edit the file as text; the command line plans it"};
  }
  if (!has_known_words(request)) return unknown_word;
  Reader reader(arguments);
  const TrackInput input = read_track(request, reader);
  if (!reader.is_complete()) return incomplete;
  return slots_[static_cast<std::size_t>(index)].solve(input);
}

TrackInput Session::read_track(const TrackRequest& request, Reader& reader) {
  TrackInput input;
  input.ends = request.is_periodic != 0 ? CurveEnds::periodic : CurveEnds::natural;
  input.kinetic = static_cast<Kinetic>(request.kinetic);
  input.frames = request.frames;
  input.fps.numerator = request.fps_numerator;
  input.fps.denominator = request.fps_denominator;
  PathSpec& path = input.path;
  path.spline = static_cast<Spline>(request.spline);
  path.closed = request.is_closed != 0;
  path.overshoot = request.overshoots != 0;
  path.rests_at_start = request.rests_at_start != 0;
  path.rests_at_end = request.rests_at_end != 0;
  path.axis_count = request.axis_count;
  path.keys = reader.numbers(request.key_count * request.axis_count);
  path.lap = reader.numbers(request.lap_count);
  path.weights = reader.numbers(request.weight_count);
  path.shapes = read_shapes(request.shape_count, reader);
  input.control_values = reader.numbers(request.control_value_count);
  input.locks = read_locks(request.lock_count, reader);
  input.key_frames = reader.integers(request.key_frame_count);
  // Keys on frames have overlaps, and at a drawn speed keys have tolerances.
  if (request.key_frame_count > 0) {
    path.overlap_frames = reader.integers(request.corner_count);
  } else {
    path.path_tolerances = reader.numbers(request.corner_count);
  }
  if (request.segment_count > 0) input.cubics = read_cubics(request, input, reader);
  return input;
}

std::span<const KeyShape> Session::read_shapes(std::int32_t count, Reader& reader) {
  if (count <= 0) return {};
  const std::span<KeyShape> shapes = std::span(shapes_).first(static_cast<std::size_t>(count));
  for (KeyShape& shape : shapes) shape = {reader.number(), reader.number(), reader.number()};
  return shapes;
}

std::span<const KeyLock> Session::read_locks(std::int32_t count, Reader& reader) {
  if (count <= 0) return {};
  const std::span<KeyLock> locks = std::span(locks_).first(static_cast<std::size_t>(count));
  for (KeyLock& lock : locks) {
    lock = {.key = reader.integer(), .frame = reader.integer(), .hold = reader.integer()};
    lock.breaks = reader.integer() != 0;
    lock.ease = reader.integer() != 0;
  }
  return locks;
}

CubicPathSpec Session::read_cubics(const TrackRequest& request, const TrackInput& input, Reader& reader) {
  const auto count = static_cast<std::size_t>(request.segment_count);
  const std::span<FrameKnot> knots = std::span(knots_).first(count);
  for (FrameKnot& knot : knots) {
    knot = {.key = reader.integer(),
            .part = reader.integer(),
            .parts = reader.integer(),
            .length = reader.integer()};
  }
  const std::span<Cubic> cubics =
      std::span(cubics_).first(count * static_cast<std::size_t>(request.weight_count));
  for (Cubic& cubic : cubics) cubic = {reader.number(), reader.number(), reader.number(), reader.number()};
  const PathSpec& path = input.path;
  return {.spline = path.spline,
          .closed = path.closed,
          .axis_count = path.axis_count,
          .key_count = request.key_count,
          .cubics = cubics,
          .weights = path.weights,
          .knots = knots,
          .over_frames = input.kinetic == Kinetic::curves && request.key_frame_count > 0};
}

Status Session::assemble(const Exchange& arguments) {
  assembled_ = false;
  const MoveRequest& request = arguments.records.move_request;
  if (!is_count(request.track_count, max_tracks) || request.track_count < 1 ||
      !is_count(request.axis_count, max_move_axes) || !is_count(request.motor_count, max_move_axes)) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the move has more tracks or axes than this page solves",
                 .remedy = "edit the file as text; the command line plans it"};
  }
  if (request.rate_hz < 1) return incomplete;
  track_count_ = 0;
  auto* const tracks = reinterpret_cast<Track*>(tracks_.data());
  for (std::int32_t i = 0; i < request.track_count; ++i) {
    const TrackSlot* const slot = solved(i);
    if (slot == nullptr) return incomplete;
    std::construct_at(tracks + track_count_++, slot->track());
  }
  Reader reader(arguments);
  const auto motor_count = static_cast<std::size_t>(request.motor_count);
  const std::size_t limit_count = static_cast<std::size_t>(request.axis_count) + motor_count;
  if (const Status read = read_limits(limit_count, reader); !read) return read;
  for (std::size_t m = 0; m < motor_count; ++m) {
    if (const Status read = read_motor(m, reader); !read) return read;
  }
  if (!reader.is_complete()) return incomplete;
  const std::span limits(reinterpret_cast<const AxisLimits*>(limits_.data()), limit_count);
  const Status certified =
      certificate_.make(this->tracks(), limits, std::span(motors_).first(motor_count), request.rate_hz);
  assembled_ = certified.has_value();
  return certified;
}

Status Session::read_limits(std::size_t count, Reader& reader) {
  auto* const limits = reinterpret_cast<AxisLimits*>(limits_.data());
  for (std::size_t d = 0; d < count; ++d) {
    AxisLimitsSpec spec{.min = reader.number(),
                        .max = reader.number(),
                        .max_velocity = reader.number(),
                        .max_acceleration = reader.number()};
    spec.max_jerk = given(reader.number());
    spec.max_acceleration_step = given(reader.number());
    spec.stop_acceleration = given(reader.number());
    spec.stop_jerk = given(reader.number());
    const auto made = AxisLimits::make(spec);
    if (!made) {
      Error error = made.error();
      error.axis = static_cast<std::int32_t>(d);
      return error;
    }
    std::construct_at(limits + d, *made);
  }
  return Done{};
}

Status Session::read_motor(std::size_t number, Reader& reader) {
  constexpr std::size_t max_marks = Calibration::max_marks;
  std::array<CalibrationMark, max_marks> marks;
  const std::int32_t axis = reader.integer();
  const std::int32_t count = reader.integer();
  if (axis < 0 || count < 0 || static_cast<std::size_t>(count) > max_marks) return incomplete;
  const std::span<CalibrationMark> of_motor = std::span(marks).first(static_cast<std::size_t>(count));
  for (CalibrationMark& mark : of_motor) mark = {reader.number(), reader.number()};
  const auto curve =
      Calibration::make(of_motor, std::span(curve_pieces_).subspan(number * (max_marks + 1), max_marks + 1));
  if (!curve) return curve.error();
  auto* const curves = reinterpret_cast<Calibration*>(curves_.data());
  motors_[number] = {static_cast<std::size_t>(axis), std::construct_at(curves + number, *curve)};
  return Done{};
}

const TrackSlot* Session::solved(std::int32_t index) const {
  if (index < 0 || static_cast<std::size_t>(index) >= max_tracks) return nullptr;
  const TrackSlot& slot = slots_[static_cast<std::size_t>(index)];
  return slot.is_solved() ? &slot : nullptr;
}

std::span<const Track> Session::tracks() const {
  return {reinterpret_cast<const Track*>(tracks_.data()), track_count_};
}

}  // namespace inbetween::editor
