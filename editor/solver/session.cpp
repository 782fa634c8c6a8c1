#include "editor/solver/session.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace inbetween::editor {
namespace {

constexpr Error incomplete{
    .code = ErrorCode::wrong_count, .what = "the page's call is incomplete", .remedy = "load the page again"};

std::optional<double> given(double value) {
  return std::isnan(value) ? std::nullopt : std::optional(value);
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
  Reader reader(arguments);
  TrackInput input;
  PathSpec& path = input.path;
  path.spline = static_cast<Spline>(std::clamp(reader.integer(), 0, 3));
  path.closed = reader.integer() != 0;
  path.axis_count = reader.integer();
  const std::int32_t keys = reader.integer();
  path.overshoot = reader.integer() != 0;
  input.ends = reader.integer() != 0 ? CurveEnds::periodic : CurveEnds::natural;
  input.frames = reader.integer();
  input.fps.numerator = reader.integer();
  input.fps.denominator = reader.integer();
  const std::int32_t values = reader.integer();
  const std::int32_t locks = reader.integer();
  const std::int32_t key_frames = reader.integer();
  input.kinetic = static_cast<Kinetic>(std::clamp(reader.integer(), 0, 2));
  path.rests_at_start = reader.integer() != 0;
  path.rests_at_end = reader.integer() != 0;
  const std::int32_t laps = reader.integer();
  const std::int32_t weights = reader.integer();
  const std::int32_t shapes = reader.integer();
  const std::int32_t segments = reader.integer();
  const std::int32_t corners = reader.integer();
  const bool is_sane =
      path.axis_count >= 1 && path.axis_count <= static_cast<std::int32_t>(max_axes) && keys >= 0 &&
      keys <= static_cast<std::int32_t>(max_keys) && locks <= static_cast<std::int32_t>(max_locks) &&
      weights <= static_cast<std::int32_t>(max_axes + max_guides) && weights >= 0 &&
      shapes <= static_cast<std::int32_t>(max_keys) && segments <= static_cast<std::int32_t>(max_segments) &&
      corners >= 0 && corners <= static_cast<std::int32_t>(max_keys);
  if (!is_sane) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the track is larger than this page solves",
                 .remedy = "edit the file as text; the command line plans it"};
  }
  path.keys = reader.numbers(keys * path.axis_count);
  path.lap = reader.numbers(laps);
  path.weights = reader.numbers(weights);
  for (std::int32_t i = 0; i < shapes; ++i) {
    shapes_[static_cast<std::size_t>(i)] = {reader.number(), reader.number(), reader.number()};
  }
  if (shapes > 0) path.shapes = std::span(shapes_).first(static_cast<std::size_t>(shapes));
  input.control_values = reader.numbers(values);
  for (std::int32_t i = 0; i < locks; ++i) {
    KeyLock& lock = locks_[static_cast<std::size_t>(i)];
    lock = {.key = reader.integer(), .frame = reader.integer(), .hold = reader.integer()};
    lock.breaks = reader.integer() != 0;
    lock.ease = reader.integer() != 0;
  }
  if (locks > 0) input.locks = std::span(locks_).first(static_cast<std::size_t>(locks));
  input.key_frames = reader.integers(key_frames);
  // Keys on frames have overlaps, and at a drawn speed keys have tolerances.
  if (key_frames > 0) {
    path.overlap_frames = reader.integers(corners);
  } else {
    path.path_tolerances = reader.numbers(corners);
  }
  if (segments > 0) {
    const auto count = static_cast<std::size_t>(segments);
    for (FrameKnot& knot : std::span(knots_).first(count)) {
      knot = {.key = reader.integer(),
              .part = reader.integer(),
              .parts = reader.integer(),
              .length = reader.integer()};
    }
    const std::size_t rows = count * static_cast<std::size_t>(weights);
    for (Cubic& cubic : std::span(cubics_).first(rows)) {
      cubic = {reader.number(), reader.number(), reader.number(), reader.number()};
    }
    input.cubics = CubicPathSpec{.spline = path.spline,
                                 .closed = path.closed,
                                 .axis_count = path.axis_count,
                                 .key_count = keys,
                                 .cubics = std::span(cubics_).first(rows),
                                 .weights = path.weights,
                                 .knots = std::span(knots_).first(count),
                                 .over_frames = input.kinetic == Kinetic::curves && key_frames > 0};
  }
  if (!reader.is_complete()) return incomplete;
  return slots_[static_cast<std::size_t>(index)].solve(input);
}

Status Session::assemble(const Exchange& arguments) {
  assembled_ = false;
  Reader reader(arguments);
  const std::int32_t count = reader.integer();
  const std::int32_t axes = reader.integer();
  const std::int32_t motors = reader.integer();
  const std::int32_t rate_hz = reader.integer();
  const auto most = static_cast<std::int32_t>(max_move_axes);
  if (count < 1 || count > static_cast<std::int32_t>(max_tracks) || axes < 0 || axes > most || motors < 0 ||
      motors > most) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the move has more tracks or axes than this page solves",
                 .remedy = "edit the file as text; the command line plans it"};
  }
  if (rate_hz < 1) return incomplete;
  track_count_ = 0;
  auto* const tracks = reinterpret_cast<Track*>(tracks_.data());
  for (std::int32_t i = 0; i < count; ++i) {
    const TrackSlot* const slot = solved(i);
    if (slot == nullptr) return incomplete;
    std::construct_at(tracks + track_count_++, slot->track());
  }
  const auto limit_count = static_cast<std::size_t>(axes + motors);
  if (const Status read = read_limits(limit_count, reader); !read) return read;
  const auto motor_count = static_cast<std::size_t>(motors);
  for (std::size_t m = 0; m < motor_count; ++m) {
    if (const Status read = read_motor(m, reader); !read) return read;
  }
  if (!reader.is_complete()) return incomplete;
  const std::span limits(reinterpret_cast<const AxisLimits*>(limits_.data()), limit_count);
  const Status certified =
      certificate_.make(this->tracks(), limits, std::span(motors_).first(motor_count), rate_hz);
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
