#include "inbetween/timing/frame_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace inbetween {
namespace {

/// Steps at most this share of the length long are judged absolutely, longer ones relatively.
inline constexpr double short_step_share = 1e-6;

bool on_path(const Path& path, const PathPoint& point) {
  const bool at_end = point.segment == path.segment_count() && point.t == 0;
  return at_end ||
         (point.segment >= 0 && point.segment < path.segment_count() && point.t >= 0 && point.t <= 1);
}

Error broken(const char* rule, std::int32_t frame) {
  return {.code = ErrorCode::out_of_range,
          .what = rule,
          .remedy = "this is a defect of the solver; please report it with the move",
          .frame = frame};
}

/// Calls judge(frame, drawn, deviation) for the step that ends on each frame: the distance it should
/// travel, and how far the distance along the path between its points is from that.
template <class Judge>
void compare_steps(const Track& track, std::span<const PathPoint> points, Judge judge) {
  TwoSum travelled_before;
  TwoSum drawn_before;
  for (std::int32_t frame = 0; frame < static_cast<std::int32_t>(points.size()); ++frame) {
    const TwoSum travelled =
        track.arc_length().distance(track.path(), points[static_cast<std::size_t>(frame)]);
    const TwoSum drawn = track.distance({frame, 0});
    if (frame > 0) {
      const double step = drawn.minus(drawn_before);
      judge(frame, step, std::fabs(travelled.minus(travelled_before) - step));
    }
    travelled_before = travelled;
    drawn_before = drawn;
  }
}

/// The distance at a frame of a broken curve is a sum, and rounds as this does: the constant of its portion
/// times the integral over a span. The constant is large where next to nothing of the curve is left behind a
/// break.
double span_distance(const Track& track, std::int32_t frame) {
  const std::span<const Portion> portions = track.portions();
  if (portions.empty()) return 0;
  const auto behind = std::ranges::upper_bound(portions, frame, {}, &Portion::begin_frame);
  const Portion& portion = behind == portions.begin() ? portions.front() : *(behind - 1);
  return portion.constant * track.profile().span(track.place({frame, 0}).span).integral();
}

/// The first step that is further from the drawn one than the table promises.
Status check_speed(const Track& track, const FrameTable& table) {
  const double length = track.arc_length().total();
  const double short_step = static_cast<double>(short_step_share) * length;
  // Points and distances are themselves rounded to a few ulp of the length, and of what they are summed from.
  const auto rounding = [&](std::int32_t frame) {
    const double summed = span_distance(track, frame - 1) + span_distance(track, frame);
    return 16 * std::numeric_limits<double>::epsilon() * (length + summed);
  };
  const double short_step_error = table.provenance().short_step_error * length;
  const double promised = table.provenance().speed_error;
  Status status = Done{};
  compare_steps(track, table.points(), [&](std::int32_t frame, double drawn, double deviation) {
    const bool is_short = drawn <= short_step;
    const double allowed = promised * std::max(drawn, short_step) + (is_short ? short_step_error : 0.0);
    if (!status || deviation <= allowed + rounding(frame)) return;
    status =
        broken(is_short ? "the speed of a short step is not as drawn" : "the speed is not as drawn", frame);
  });
  return status;
}

}  // namespace

Result<FrameTable> closed_form_table(const Track& track, std::span<PathPoint> memory) {
  const std::size_t count = static_cast<std::size_t>(track.frames()) + 1;
  if (memory.size() < count) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the move has more frames than the memory of the table",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(count)};
  }
  const std::span<PathPoint> points = memory.first(count);
  if (!track.locate_frames(0, points)) {
    for (std::size_t i = 1; i < count; ++i) {
      if (!points[i - 1].at_or_before(points[i])) points[i] = points[i - 1];
    }
  }
  return FrameTable(points, {.constant = track.has_profile() ? track.constant() : 0.0,
                             .speed_error = track.arc_length().delta()});
}

FrameRow frame_row(const Track& track, const FrameTable& table, std::int32_t frame) {
  const AlongPath along = track.along({frame, 0});
  const double constant = table.provenance().constant;
  const bool one_constant = track.has_profile() && track.portions().empty() && track.constant() > 0;
  const double scale = one_constant ? constant / track.constant() : 1.0;
  const auto f = static_cast<double>(track.profile().span_count());
  return {.alpha = static_cast<double>(frame) * f / static_cast<double>(track.frames()),
          .point = table.point(frame),
          .distance = track.arc_length().distance(track.path(), table.point(frame)).high,
          .speed = along.speed * scale,
          .acceleration = along.acceleration * scale};
}

SpeedDeviation measure_speed_deviation(const Track& track, std::span<const PathPoint> points) {
  SpeedDeviation worst;
  const double length = track.arc_length().total();
  if (length <= 0) return worst;
  compare_steps(track, points, [&](std::int32_t frame, double drawn, double deviation) {
    const bool is_short = drawn <= static_cast<double>(short_step_share) * length;
    const double measure = deviation / (is_short ? length : drawn);
    double& so_far = is_short ? worst.absolute : worst.relative;
    if (!(measure <= so_far)) {
      so_far = measure;
      (is_short ? worst.absolute_frame : worst.frame) = frame;
    }
  });
  return worst;
}

Status check_invariants(const Track& track, const FrameTable& table) {
  const Path& path = track.path();
  if (table.frames() != track.frames())
    return broken("the table has not one row for every frame", table.frames());
  for (std::int32_t frame = 0; frame <= table.frames(); ++frame) {
    const PathPoint& point = table.point(frame);
    if (!on_path(path, point)) return broken("a point of the table is not on the path", frame);
    if (frame > 0 && !table.point(frame - 1).at_or_before(point)) {
      return broken("s falls: the table goes backwards", frame);
    }
  }
  if (!(table.point(0) == PathPoint{0, 0})) return broken("the table does not begin at the first key", 0);
  if (!(table.point(table.frames()) == PathPoint{path.segment_count(), 0})) {
    return broken("the table does not end at the last key", table.frames());
  }
  return check_speed(track, table);
}

}  // namespace inbetween
