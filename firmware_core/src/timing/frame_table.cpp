#include "inbetween/timing/frame_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace inbetween {
namespace {

/// Steps at most this share of the length long are judged absolutely, longer ones relatively.
inline constexpr double short_step_share = 1e-6;

template <Precise Real>
bool on_path(const Path<Real>& path, const PathPoint<Real>& point) {
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
template <Precise Real, class Judge>
void compare_steps(const Track<Real>& track, std::span<const PathPoint<Real>> points, Judge judge) {
  TwoSum<Real> travelled_before;
  TwoSum<Real> drawn_before;
  for (std::int32_t frame = 0; frame < static_cast<std::int32_t>(points.size()); ++frame) {
    const TwoSum<Real> travelled =
        track.arc_length().distance(track.path(), points[static_cast<std::size_t>(frame)]);
    const TwoSum<Real> drawn = track.distance({frame, 0});
    if (frame > 0) {
      const Real step = drawn.minus(drawn_before);
      judge(frame, step, std::fabs(travelled.minus(travelled_before) - step));
    }
    travelled_before = travelled;
    drawn_before = drawn;
  }
}

/// The distance at a frame of a broken curve is a sum, and rounds as this does: the constant of its portion
/// times the integral over a span. The constant is large where next to nothing of the curve is left behind a
/// break.
template <Precise Real>
Real span_distance(const Track<Real>& track, std::int32_t frame) {
  const std::span<const Portion<Real>> portions = track.portions();
  if (portions.empty()) return 0;
  const auto behind = std::ranges::upper_bound(portions, frame, {}, &Portion<Real>::begin_frame);
  const Portion<Real>& portion = behind == portions.begin() ? portions.front() : *(behind - 1);
  return portion.constant * track.profile().span(track.place({frame, 0}).span).integral();
}

/// The first step that is further from the drawn one than the table promises.
template <Precise Real>
Status check_speed(const Track<Real>& track, const FrameTable<Real>& table) {
  const Real length = track.arc_length().total();
  const Real short_step = static_cast<Real>(short_step_share) * length;
  // Points and distances are themselves rounded to a few ulp of the length, and of what they are summed from.
  const auto rounding = [&](std::int32_t frame) {
    const Real summed = span_distance(track, frame - 1) + span_distance(track, frame);
    return 16 * std::numeric_limits<Real>::epsilon() * (length + summed);
  };
  const Real short_step_error = table.provenance().short_step_error * length;
  const Real promised = table.provenance().speed_error;
  Status status = Done{};
  compare_steps(track, table.points(), [&](std::int32_t frame, Real drawn, Real deviation) {
    const bool is_short = drawn <= short_step;
    const Real allowed = promised * std::max(drawn, short_step) + (is_short ? short_step_error : Real(0));
    if (!status || deviation <= allowed + rounding(frame)) return;
    status =
        broken(is_short ? "the speed of a short step is not as drawn" : "the speed is not as drawn", frame);
  });
  return status;
}

}  // namespace

template <Precise Real>
Result<FrameTable<Real>> closed_form_table(const Track<Real>& track, std::span<PathPoint<Real>> memory) {
  const std::size_t count = static_cast<std::size_t>(track.frames()) + 1;
  if (memory.size() < count) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the move has more frames than the memory of the table",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(count)};
  }
  const std::span<PathPoint<Real>> points = memory.first(count);
  if (!track.locate_frames(0, points)) {
    for (std::size_t i = 1; i < count; ++i) {
      if (!points[i - 1].at_or_before(points[i])) points[i] = points[i - 1];
    }
  }
  return FrameTable<Real>(points, {.solver = Solver::closed_form,
                                   .constant = track.has_profile() ? track.constant() : Real(0),
                                   .speed_error = track.arc_length().delta()});
}

template <Precise Real>
FrameRow<Real> frame_row(const Track<Real>& track, const FrameTable<Real>& table, std::int32_t frame) {
  const AlongPath<Real> along = track.along({frame, 0});
  const Real constant = table.provenance().constant;
  const bool one_constant = track.has_profile() && track.portions().empty() && track.constant() > 0;
  const Real scale = one_constant ? constant / track.constant() : Real(1);
  const auto f = static_cast<Real>(track.profile().span_count());
  return {.alpha = static_cast<Real>(frame) * f / static_cast<Real>(track.frames()),
          .point = table.point(frame),
          .distance = track.arc_length().distance(track.path(), table.point(frame)).high,
          .speed = along.speed * scale,
          .acceleration = along.acceleration * scale};
}

template <Precise Real>
SpeedDeviation<Real> measure_speed_deviation(const Track<Real>& track,
                                             std::span<const PathPoint<Real>> points) {
  SpeedDeviation<Real> worst;
  const Real length = track.arc_length().total();
  if (length <= 0) return worst;
  compare_steps(track, points, [&](std::int32_t frame, Real drawn, Real deviation) {
    const bool is_short = drawn <= static_cast<Real>(short_step_share) * length;
    const Real measure = deviation / (is_short ? length : drawn);
    Real& so_far = is_short ? worst.absolute : worst.relative;
    if (!(measure <= so_far)) {
      so_far = measure;
      (is_short ? worst.absolute_frame : worst.frame) = frame;
    }
  });
  return worst;
}

template <Precise Real>
Status check_invariants(const Track<Real>& track, const FrameTable<Real>& table) {
  const Path<Real>& path = track.path();
  if (table.frames() != track.frames())
    return broken("the table has not one row for every frame", table.frames());
  for (std::int32_t frame = 0; frame <= table.frames(); ++frame) {
    const PathPoint<Real>& point = table.point(frame);
    if (!on_path(path, point)) return broken("a point of the table is not on the path", frame);
    if (frame > 0 && !table.point(frame - 1).at_or_before(point)) {
      return broken("s falls: the table goes backwards", frame);
    }
  }
  if (!(table.point(0) == PathPoint<Real>{0, 0}))
    return broken("the table does not begin at the first key", 0);
  if (!(table.point(table.frames()) == PathPoint<Real>{path.segment_count(), 0})) {
    return broken("the table does not end at the last key", table.frames());
  }
  return check_speed(track, table);
}

#define INBETWEEN_INSTANTIATE(Real)                                                                    \
  template Result<FrameTable<Real>> closed_form_table(const Track<Real>&, std::span<PathPoint<Real>>); \
  template FrameRow<Real> frame_row(const Track<Real>&, const FrameTable<Real>&, std::int32_t);        \
  template SpeedDeviation<Real> measure_speed_deviation(const Track<Real>&,                            \
                                                        std::span<const PathPoint<Real>>);             \
  template Status check_invariants(const Track<Real>&, const FrameTable<Real>&);
INBETWEEN_INSTANTIATE(double)
INBETWEEN_INSTANTIATE(float)
#undef INBETWEEN_INSTANTIATE

}  // namespace inbetween
