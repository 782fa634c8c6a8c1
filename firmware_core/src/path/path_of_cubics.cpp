#include <algorithm>
#include <cmath>
#include <limits>

#include "inbetween/path/path.hpp"

namespace inbetween {
namespace {

/// Two cubics may be apart by this share of their coefficients at a knot. It covers the rounding of whoever
/// computed them, and is no more than a table is known to.
constexpr double max_gap = 1e-9;

/// The rows of a path of cubics, while it is checked.
class GivenRows {
 public:
  explicit GivenRows(const CubicPathSpec& spec)
      : spec_(spec), rows_(spec.weights.size()), segments_(rows_ > 0 ? spec.cubics.size() / rows_ : 0) {}

  [[nodiscard]] std::size_t segments() const { return segments_; }

  [[nodiscard]] Status check_counts() const {
    const auto axes = static_cast<std::size_t>(std::max<std::int32_t>(spec_.axis_count, 0));
    if (axes > 0 && rows_ >= axes && rows_ <= axes + max_guides && segments_ > 0 &&
        spec_.cubics.size() == segments_ * rows_ && spec_.knots.size() == segments_) {
      return Done{};
    }
    return Error{.code = ErrorCode::wrong_count,
                 .what = "the numbers of axes, guides, cubics and knots do not go together",
                 .remedy =
                     "give a weight for each axis and up to 3 guides, and a cubic of each and a knot for "
                     "each segment"};
  }

  /// The path between two keys has all its parts, in order.
  [[nodiscard]] Status check_knots() const {
    FrameKnot expected;
    for (const FrameKnot& knot : spec_.knots) {
      const bool begins = knot.part == 0;
      const bool follows = begins ? expected.part == 0 && knot.parts > 0 : knot.parts == expected.parts;
      const bool is_within = knot.length > 0 && knot.length <= knot.parts - knot.part;
      if (knot.key != expected.key || knot.part != expected.part || !follows || !is_within)
        return wrong_knot(knot.key);
      expected = knot;
      expected.part += knot.length;
      if (expected.part == knot.parts) expected = {.key = knot.key + 1};
    }
    const std::int32_t last = spec_.closed ? spec_.key_count : spec_.key_count - 1;
    if (expected.part != 0 || expected.key != last) return wrong_knot(expected.key);
    return Done{};
  }

  [[nodiscard]] Status check_numbers() const {
    for (std::size_t row = 0; row < rows_; ++row) {
      if (spec_.weights[row] >= 0 && spec_.weights[row] <= Precision::largest) continue;
      return wrong_number(spec_.weights[row], -1, row);
    }
    for (std::size_t i = 0; i < spec_.cubics.size(); ++i) {
      const Cubic& c = spec_.cubics[i];
      for (const double part : {c.c0, c.c1, c.c2, c.c3}) {
        if (std::fabs(part) <= Precision::largest) continue;
        return wrong_number(part, spec_.knots[i / rows_].key, i % rows_);
      }
    }
    return Done{};
  }

  [[nodiscard]] Status check_joined() const {
    for (std::size_t i = 0; i + rows_ < spec_.cubics.size(); ++i) {
      const Cubic& c = spec_.cubics[i];
      const double size = std::fabs(c.c0) + std::fabs(c.c1) + std::fabs(c.c2) + std::fabs(c.c3);
      if (std::fabs(spec_.cubics[i + rows_].c0 - c.value(1)) <= max_gap * size) continue;
      return Error{.code = ErrorCode::no_solution,
                   .what = "a segment does not begin where the one before it ends",
                   .remedy = "give cubics that join",
                   .key = spec_.knots[i / rows_].key,
                   .axis = static_cast<std::int32_t>(i % rows_)};
    }
    return Done{};
  }

  [[nodiscard]] Status check_measured() const {
    for (std::size_t segment = 0; segment < segments_; ++segment) {
      const std::span<const Cubic> cubics = spec_.cubics.subspan(segment * rows_, rows_);
      std::int32_t moving_axis = -1;
      bool measured = false;
      for (std::size_t row = 0; row < rows_; ++row) {
        if (cubics[row].c1 == 0 && cubics[row].c2 == 0 && cubics[row].c3 == 0) continue;
        if (spec_.weights[row] > 0) measured = true;
        if (moving_axis < 0) moving_axis = static_cast<std::int32_t>(row);
      }
      if (measured || moving_axis < 0) continue;
      return Error{.code = ErrorCode::unmeasured,
                   .what = "an axis moves after this key where what the distance is measured on stands still",
                   .remedy = "let that move too, or measure the axes",
                   .key = spec_.knots[segment].key,
                   .axis = moving_axis};
    }
    return Done{};
  }

 private:
  static Error wrong_knot(std::int32_t key) {
    return {.code = ErrorCode::out_of_range,
            .what = "a knot is not the next part of the path between two keys",
            .remedy = "give all parts between two keys, in order",
            .key = key};
  }
  static Error wrong_number(double number, std::int32_t key, std::size_t row) {
    const bool finite = std::isfinite(number);
    return {.code = finite ? ErrorCode::out_of_range : ErrorCode::not_finite,
            .what = finite ? "a number of the path is too large, or a weight negative"
                           : "a number of the path is not finite",
            .remedy = "use ordinary numbers in the units of the axis",
            .key = key,
            .axis = static_cast<std::int32_t>(row)};
  }

  const CubicPathSpec& spec_;
  std::size_t rows_;
  std::size_t segments_;
};

}  // namespace

Result<Path> Path::make_of_cubics(const CubicPathSpec& spec, const PathMemory& memory) {
  const GivenRows given(spec);
  if (const Status counts = given.check_counts(); !counts) return counts.error();
  if (const Status knots = given.check_knots(); !knots) return knots.error();
  if (const Status numbers = given.check_numbers(); !numbers) return numbers.error();
  if (const Status joined = given.check_joined(); !joined) return joined.error();
  if (const Status measured = given.check_measured(); !measured) return measured.error();
  const std::size_t rows = spec.weights.size();
  const std::size_t needed = spec.cubics.size() + rows;
  if (memory.cubics.size() < needed || memory.weights.size() < rows ||
      memory.knots.size() < given.segments()) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the path has more segments than its memory",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(needed)};
  }
  std::ranges::copy(spec.cubics, memory.cubics.begin());
  std::ranges::copy(spec.weights, memory.weights.begin());
  std::ranges::copy(spec.knots, memory.knots.begin());
  for (std::size_t row = 0; row < rows; ++row) {
    const Cubic& c = spec.cubics[spec.cubics.size() - rows + row];
    memory.cubics[spec.cubics.size() + row] = {c.value(1), c.derivative(1), c.c2 + 3 * c.c3, c.c3};
  }
  Path path;
  path.axis_count_ = spec.axis_count;
  path.key_count_ = spec.key_count;
  path.segment_count_ = static_cast<std::int32_t>(given.segments());
  path.cubics_ = memory.cubics.first(needed);
  path.weights_ = memory.weights.first(rows);
  path.knots_ = memory.knots.first(given.segments());
  path.spline_ = spec.spline;
  path.closed_ = spec.closed;
  path.over_frames_ = spec.over_frames;
  return path;
}

}  // namespace inbetween
