#include "host_tools/plan/table_track.hpp"

#include <cstdint>
#include <vector>

namespace inbetween {
namespace {

/// The knot of a rest is a quarter of a step from the end, on a whole quarter of a frame.
constexpr std::int32_t quarters_per_frame_of_rows = 4;

/// Where segments begin, in quarters of a frame, and where the last one ends.
using Quarters = std::vector<std::int32_t>;

class TableCurves {
 public:
  explicit TableCurves(const MoveTrack& track)
      : track_(track), table_(*track.table), axes_(track.axes.size()), rows_(table_.frames.size()) {
    RestingEnds any{false, false};
    for (std::size_t d = 0; d < axes_; ++d) {
      any.start = any.start || rests(d).start;
      any.end = any.end || rests(d).end;
    }
    knots_ = knots_with(any);
  }

  [[nodiscard]] CubicsOverFrames path() const {
    CubicsOverFrames made;
    made.cubics.resize((knots_.size() - 1) * axes_);
    made.knots.reserve(knots_.size() - 1);
    for (std::size_t k = 0; k + 1 < knots_.size(); ++k)
      made.knots.push_back(
          {.key = 0, .part = knots_[k], .parts = knots_.back(), .length = knots_[k + 1] - knots_[k]});
    SplineRun run;
    for (std::size_t k = 0; k + 1 < rows_; ++k) run.steps.push_back(table_.frames[k + 1] - table_.frames[k]);
    run.values.resize(rows_);
    for (std::size_t d = 0; d < axes_; ++d) write_axis(d, run, made.cubics);
    return made;
  }

 private:
  [[nodiscard]] double at(std::size_t row, std::size_t axis) const { return table_.at[row * axes_ + axis]; }
  [[nodiscard]] RestingEnds rests(std::size_t axis) const {
    const RestingEnds as_rows{at(0, axis) == at(1, axis), at(rows_ - 2, axis) == at(rows_ - 1, axis)};
    return track_.rest.value_or(as_rows);
  }
  /// A knot for each row, and one for each end that rests: its quarter of a step is so many quarters of a
  /// frame as the step has frames.
  [[nodiscard]] Quarters knots_with(const RestingEnds& rests) const {
    const std::vector<std::int32_t>& frames = table_.frames;
    Quarters knots;
    knots.reserve(rows_ + 2);
    for (const std::int32_t frame : frames) knots.push_back(quarters_per_frame_of_rows * frame);
    if (rests.start) knots.insert(knots.begin() + 1, frames[1]);
    const std::int32_t before_end = knots.back() - (frames[rows_ - 1] - frames[rows_ - 2]);
    if (rests.end) knots.insert(knots.end() - 1, before_end);
    return knots;
  }
  /// The spline of an axis, cut where another axis alone has the knot of a rest.
  void write_axis(std::size_t d, SplineRun& run, std::vector<Cubic>& cubics) const {
    const RestingEnds resting = rests(d);
    for (std::size_t row = 0; row < rows_; ++row) run.values[row] = at(row, d);
    run.first_end = resting.start ? SplineEnd::rest : SplineEnd::free;
    run.last_end = resting.end ? SplineEnd::rest : SplineEnd::free;
    const std::vector<Cubic> own = spline_through(run);
    const Quarters own_knots = knots_with(resting);
    std::size_t segment = 0;
    for (std::size_t k = 0; k + 1 < knots_.size(); ++k) {
      while (own_knots[segment + 1] <= knots_[k]) ++segment;
      const double length = own_knots[segment + 1] - own_knots[segment];
      const bool is_whole = knots_[k] == own_knots[segment] && knots_[k + 1] == own_knots[segment + 1];
      cubics[k * axes_ + d] = is_whole ? own[segment]
                                       : cut(own[segment], (knots_[k] - own_knots[segment]) / length,
                                             (knots_[k + 1] - knots_[k]) / length);
    }
  }

  const MoveTrack& track_;
  const MoveTable& table_;
  std::size_t axes_;
  std::size_t rows_;
  Quarters knots_;
};

}  // namespace

CubicsOverFrames table_path(const MoveTrack& track) {
  return TableCurves(track).path();
}

std::optional<std::size_t> row_outside(const MoveTrack& track, std::size_t axis, double low, double high) {
  const MoveTable& table = *track.table;
  for (std::size_t row = 0; row < table.frames.size(); ++row) {
    const double at = table.at[row * track.axes.size() + axis];
    if (at < low || at > high) return row;
  }
  return std::nullopt;
}

}  // namespace inbetween
