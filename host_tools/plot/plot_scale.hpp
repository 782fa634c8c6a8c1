// Ranges, scales and round tick numbers: they lead from values to pixels.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace inbetween {

struct Range {
  double low = 0;
  double high = 0;

  [[nodiscard]] double size() const { return high - low; }
  [[nodiscard]] bool contains(double value) const { return low <= value && value <= high; }
};

/// The lowest and the highest of finite values; 0..0 without values.
[[nodiscard]] Range range_of(std::span<const double> values);

/// `range` made wider by `share` of its size at both ends. A range that is a point, or that is narrower than
/// 1e-12 of its magnitude (rounding, not motion) or than 1e-290, becomes at least one unit wide around its
/// middle.
[[nodiscard]] Range widened(Range range, double share);

/// A linear map: range.low is drawn at `from`, range.high at `to` (pixels; to < from for an axis that points
/// up). The range is not empty.
class Scale {
 public:
  Scale(Range range, double from, double to) : range_(range), from_(from), to_(to) {}

  [[nodiscard]] double operator()(double value) const {
    return from_ + (value - range_.low) / range_.size() * (to_ - from_);
  }
  [[nodiscard]] double pixels_per_unit() const { return (to_ - from_) / range_.size(); }
  [[nodiscard]] const Range& range() const { return range_; }

 private:
  Range range_;
  double from_;
  double to_;
};

/// Every multiple of the finest step 1, 2 or 5 times a power of ten, not finer than `smallest_step`, that
/// gives at most `max_count` numbers inside `range`. Where these are fewer than two, the outer two of the
/// next finer step. The range is finite and not empty; max_count >= 1.
[[nodiscard]] std::vector<double> round_ticks(const Range& range, int max_count, double smallest_step = 0);

/// The numbers of round_ticks() as they stand at an axis: two or more of them in at most 8 characters each.
/// A label L means offset + L * factor; both are told in the title of the axis.
struct TickLabels {
  std::vector<std::string> labels;
  double offset = 0;
  double factor = 1;
};
[[nodiscard]] TickLabels tick_labels(std::span<const double> ticks);

/// "pan (deg)", "pan" without a unit, "pan - 7000000 (1e-3 deg)" where the labels have an offset and a
/// factor.
[[nodiscard]] std::string axis_title(std::string_view name, std::string_view unit, const TickLabels& labels);

/// The smallest of 1, 2, 5, 10, 20, ... that is not below `min_step`.
[[nodiscard]] double round_step(double min_step);

}  // namespace inbetween
