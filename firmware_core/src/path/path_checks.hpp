#pragma once

#include <algorithm>
#include <cmath>

#include "inbetween/path/path.hpp"
#include "path/frame_curves.hpp"
#include "path/rounded_corners.hpp"

/// The checks of a path before it is made: the errors of Path::make.

namespace inbetween {

inline Error bad_number(double value, const char* not_finite, const char* too_large) {
  const bool finite = std::isfinite(value);
  return {.code = finite ? ErrorCode::out_of_range : ErrorCode::not_finite,
          .what = finite ? too_large : not_finite,
          .remedy = "use ordinary numbers in the units of the axis"};
}

inline bool usable(double value) {
  return std::fabs(value) <= Precision::largest;  // false for a NaN
}

inline Status check_counts(const PathSpec& spec) {
  const auto axes = static_cast<std::size_t>(std::max<std::int32_t>(spec.axis_count, 0));
  if (axes == 0) {
    return Error{
        .code = ErrorCode::wrong_count, .what = "the path has no axes", .remedy = "name at least one"};
  }
  if (spec.keys.empty() || spec.keys.size() % axes != 0) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = spec.keys.empty() ? "the path has no keys" : "the keys are of unequal length",
                 .remedy = "give at least one key, each with one number per axis",
                 .key = static_cast<std::int32_t>(spec.keys.size() / axes)};
  }
  if (!spec.weights.empty() && spec.weights.size() != axes) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "there are not as many weights as axes",
                 .remedy = "give one weight per axis, or none"};
  }
  if (!spec.lap.empty() && (spec.lap.size() != axes || !spec.closed)) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "a lap is of a closed path, and of every axis",
                 .remedy = "give one per axis, or none"};
  }
  if (!spec.shapes.empty() && spec.shapes.size() != spec.keys.size() / axes) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "there are not as many tensions, continuities and biases as keys",
                 .remedy = "give one set per key, or none"};
  }
  return Done{};
}

inline Status check_numbers(const PathSpec& spec) {
  const auto axes = static_cast<std::size_t>(spec.axis_count);
  for (std::size_t d = 0; d < spec.weights.size(); ++d) {
    const double weight = spec.weights[d];
    if (usable(weight) && weight >= 0) continue;
    Error error = bad_number(weight, "a weight is not a finite number",
                             weight < 0 ? "a weight is negative" : "a weight is too large");
    error.remedy = "use 0 or more: how much one unit of the axis counts as distance";
    error.axis = static_cast<std::int32_t>(d);
    return error;
  }
  for (std::size_t i = 0; i < spec.keys.size() + spec.lap.size(); ++i) {
    const double value = i < spec.keys.size() ? spec.keys[i] : spec.lap[i - spec.keys.size()];
    const double weight = spec.weights.empty() ? 1.0 : spec.weights[i % axes];
    if (usable(value) && usable(value * weight)) continue;
    Error error = bad_number(value, "a coordinate is not a finite number", "a coordinate is too large");
    error.key = static_cast<std::int32_t>(i / axes % (spec.keys.size() / axes));
    error.axis = static_cast<std::int32_t>(i % axes);
    return error;
  }
  for (std::size_t k = 0; k < spec.shapes.size(); ++k) {
    const KeyShape& shape = spec.shapes[k];
    const auto inside = [](double x) { return x >= -1 && x <= 1; };
    if (inside(shape.tension) && inside(shape.continuity) && inside(shape.bias)) continue;
    const bool finite =
        std::isfinite(shape.tension) && std::isfinite(shape.continuity) && std::isfinite(shape.bias);
    return Error{.code = finite ? ErrorCode::out_of_range : ErrorCode::not_finite,
                 .what = "a tension, continuity or bias is outside -1..1",
                 .remedy = "use numbers from -1 to 1; 0, 0, 0 is a Catmull-Rom key",
                 .key = static_cast<std::int32_t>(k)};
  }
  return Done{};
}

inline Status check_key_frames(const PathSpec& spec) {
  const std::span<const std::int32_t> frames = spec.key_frames;
  if (frames.empty()) return Done{};
  const std::size_t keys = spec.keys.size() / static_cast<std::size_t>(spec.axis_count);
  if (keys < 2 || frames.size() != keys + (spec.closed ? 1 : 0)) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "a path over frames needs two keys, and a frame for every key",
                 .remedy = "give every key its frame; a closed path one more, for the return to key 0"};
  }
  for (std::size_t k = 1; k < frames.size(); ++k) {
    // In 64 bits, because any two frames are allowed here.
    const std::int64_t step = static_cast<std::int64_t>(frames[k]) - frames[k - 1];
    if (step > 0 && step <= std::numeric_limits<std::int32_t>::max()) continue;
    return Error{.code = ErrorCode::out_of_range,
                 .what = "this key is not behind the key before it in time",
                 .remedy = "give it a later frame",
                 .key = static_cast<std::int32_t>(k),
                 .frame = frames[k]};
  }
  return Done{};
}

inline Status check_corners(const PathSpec& spec, const PathMemory& memory) {
  if (!RoundedCorners::are_asked(spec)) return Done{};
  const std::size_t keys = spec.keys.size() / static_cast<std::size_t>(spec.axis_count);
  const bool by_frames = !spec.key_frames.empty();
  const std::size_t wanted = by_frames ? spec.overlap_frames.size() : spec.path_tolerances.size();
  const std::size_t others = by_frames ? spec.path_tolerances.size() : spec.overlap_frames.size();
  if (spec.spline != Spline::linear || wanted != keys || others > 0) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "corners are rounded on a linear path, at every key alike",
                 .remedy = "give one overlap per key over frames, otherwise one tolerance per key, or none"};
  }
  for (std::size_t k = 0; k < keys; ++k) {
    const double value = by_frames ? static_cast<double>(spec.overlap_frames[k]) : spec.path_tolerances[k];
    if (usable(value) && value >= 0) continue;
    Error error = bad_number(value, "the tolerance of a corner is not a finite number",
                             value < 0 ? "a corner is rounded by less than 0" : "a tolerance is too large");
    error.key = static_cast<std::int32_t>(k);
    return error;
  }
  for (std::size_t k = 0; k + 1 < spec.key_frames.size(); ++k) {
    if (spec.key_frames[k + 1] - spec.key_frames[k] <= std::numeric_limits<std::int32_t>::max() / 2) continue;
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the action behind this key is too long to count half frames",
                 .remedy = "give it fewer frames",
                 .key = static_cast<std::int32_t>(k)};
  }
  return RoundedCorners(spec, memory).check_actions();
}

/// Whether segments may begin between keys.
inline bool has_knots(const PathSpec& spec) {
  return !spec.key_frames.empty() || RoundedCorners::are_asked(spec);
}

inline std::size_t segment_count_of(const PathSpec& spec, const PathMemory& memory) {
  if (RoundedCorners::are_asked(spec)) return RoundedCorners(spec, memory).segments();
  if (!spec.key_frames.empty()) return FrameCurves(spec, memory).segments();
  const std::size_t keys = spec.keys.size() / static_cast<std::size_t>(spec.axis_count);
  return spec.closed && keys > 1 ? keys : keys - 1;
}

inline Status check_memory(const PathSpec& spec, const PathMemory& memory) {
  const auto axes = static_cast<std::size_t>(spec.axis_count);
  const std::size_t segments = segment_count_of(spec, memory);
  const std::size_t rows = segments + 1;
  if (memory.cubics.size() < rows * axes || memory.weights.size() < axes ||
      (has_knots(spec) && memory.knots.size() < segments)) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the path has more keys and axes than its memory",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(rows * axes)};
  }
  return Done{};
}

}  // namespace inbetween
