#include "host_tools/plan/followed_path.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host_tools/joints/tip_deviation.hpp"
#include "host_tools/numerics/hypotenuse.hpp"
#include "host_tools/plan/row_spline.hpp"

namespace inbetween {
namespace {

/// Each segment of the drawn path begins with so many parts, and has twice as many where the bounds are not
/// good enough: fewer cost another round, more are solved for nothing on a path that is nearly straight.
constexpr std::int16_t first_parts = 8;
/// Where a segment would need more, the axes turn at once, and that is refused.
constexpr std::int16_t max_parts = 2048;
/// Below this share of the fastest between two keys, the speed is compared with that share: near a rest any
/// error is a large share of the speed itself. FollowAccuracy::speed_share says so.
constexpr double slow_share = 0.01;

using Row = Follower::Row;

class Construction {
 public:
  Construction(const Path& drawn, bool is_smooth, const Follower& follower, const FollowLayout& layout)
      : drawn_(drawn),
        is_smooth_(is_smooth),
        follower_(follower),
        layout_(layout),
        parts_(static_cast<std::size_t>(drawn.segment_count()), first_parts) {
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      durations_.push_back(duration_of(i));
      if (durations_.back() == 0) parts_[i] = 1;
    }
  }

  /// The path with as many parts as there are now.
  [[nodiscard]] FollowedPath build() {
    solve();
    FollowedPath path;
    path.weights.assign(layout_.axes.size(), 0);
    path.weights.resize(layout_.axes.size() + layout_.guides.size(), 1);
    std::size_t step = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      for (std::int16_t part = 0; part < parts_[i]; ++part, ++step) {
        path.knots.push_back({.key = static_cast<std::int32_t>(i), .part = part, .parts = parts_[i]});
        for (const std::size_t row : layout_.axes) path.cubics.push_back(cubic(i, part, step, row));
        for (const std::size_t row : layout_.guides) path.cubics.push_back(cubic(i, part, step, row));
      }
    }
    return path;
  }

  /// The same rows on one part, in the order of `rows`.
  [[nodiscard]] std::vector<Cubic> stretch(std::size_t segment, std::int16_t part, std::size_t step,
                                           const std::vector<std::size_t>& rows) const {
    std::vector<Cubic> cubics;
    cubics.reserve(rows.size());
    for (const std::size_t row : rows) cubics.push_back(cubic(segment, part, step, row));
    return cubics;
  }

  [[nodiscard]] const std::vector<std::int16_t>& parts() const { return parts_; }
  [[nodiscard]] bool has_length(std::size_t segment) const { return durations_[segment] > 0; }
  [[nodiscard]] bool make_denser(std::size_t segment) {
    if (parts_[segment] >= max_parts) return false;
    parts_[segment] = static_cast<std::int16_t>(2 * parts_[segment]);
    return true;
  }
  /// Returns the row that turns most on a step, among those that follow.
  [[nodiscard]] std::size_t sharpest_row(std::size_t step) const {
    std::size_t most = 0;
    double largest = -1;
    for (std::size_t row = 0; row < followed_.size(); ++row) {
      const Cubic& c = followed_[row][step];
      const double turning = std::fabs(c.c2) + std::fabs(c.c3);
      if (turning > largest) most = row;
      largest = std::max(largest, turning);
    }
    return most;
  }

 private:
  [[nodiscard]] std::size_t drawn_rows() const { return drawn_.weights().size(); }

  /// Of a segment on the parameter on which the path is as smooth as it is; 0 where it stays in one place.
  [[nodiscard]] double duration_of(std::size_t segment) const {
    const auto index = static_cast<std::int32_t>(segment);
    const std::span<const Cubic> here = drawn_.segment(index);
    const std::span<const Cubic> next = drawn_.segment(index + 1);
    const bool is_still =
        std::ranges::all_of(here, [](const Cubic& c) { return c.c1 == 0 && c.c2 == 0 && c.c3 == 0; });
    if (is_still) return 0;
    if (!is_smooth_) return 1;
    double chord = 0;
    for (std::size_t d = 0; d < here.size(); ++d) {
      chord = hypotenuse(chord, drawn_.weights()[d] * (next[d].c0 - here[d].c0));
    }
    return std::sqrt(chord);
  }

  [[nodiscard]] Cubic cubic(std::size_t segment, std::int16_t part, std::size_t step, std::size_t row) const {
    if (row >= drawn_rows()) return followed_[row - drawn_rows()][step];
    const double size = 1.0 / parts_[segment];
    return cut(drawn_.segment(static_cast<std::int32_t>(segment))[row], part * size, size);
  }

  /// Values and slopes of what follows at all places, then the cubics between them.
  void solve() {
    values_.clear();
    slopes_before_.clear();
    slopes_behind_.clear();
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      for (std::int16_t part = 0; part < parts_[i]; ++part) {
        const PathPoint point{static_cast<std::int32_t>(i), static_cast<double>(part) / parts_[i]};
        values_.push_back(follower_.at(point));
        if (part == 0) slopes_behind_.push_back(slope_at(point));
      }
      const PathPoint end{static_cast<std::int32_t>(i), 1};
      // The end is the start of the next segment, seen from this one.
      if (i + 1 == parts_.size()) values_.push_back(follower_.at({static_cast<std::int32_t>(i) + 1, 0}));
      slopes_before_.push_back(has_length(i) && follower_.has_slopes ? end_slope(end) : Row{});
    }
    const std::size_t rows = values_.front().size();
    followed_.assign(rows, {});
    for (std::size_t row = 0; row < rows; ++row) interpolate(row);
  }
  [[nodiscard]] Row slope_at(const PathPoint& point) const {
    return has_length(static_cast<std::size_t>(point.segment)) && follower_.has_slopes
               ? follower_.slope(point)
               : Row{};
  }
  [[nodiscard]] Row end_slope(const PathPoint& end) const {
    static_cast<void>(follower_.at(end));
    return follower_.slope(end);
  }

  /// One row, in runs of segments that go on smoothly. A segment without length stays where it is.
  void interpolate(std::size_t row) {
    std::vector<Cubic>& cubics = followed_[row];
    std::size_t first_step = 0;
    SplineRun run;
    std::size_t run_begin = 0;
    std::vector<std::size_t> places;  // steps of the run
    cubics.resize(values_.size() - 1);
    const auto flush = [&](std::size_t end) {
      if (places.empty()) return;
      finish_run(run, row, run_begin, end);
      const std::vector<Cubic> found = spline_through(run);
      for (std::size_t k = 0; k < places.size(); ++k) cubics[places[k]] = found[k];
      run = {};
      places.clear();
    };
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const auto count = static_cast<std::size_t>(parts_[i]);
      if (!has_length(i)) {
        cubics[first_step] = {values_[first_step][row], 0, 0, 0};
      } else {
        if (places.empty()) run_begin = i;
        for (std::size_t k = 0; k < count; ++k) {
          if (run.values.empty()) run.values.push_back(values_[first_step][row]);
          run.steps.push_back(durations_[i] / static_cast<double>(count));
          run.values.push_back(values_[first_step + k + 1][row]);
          places.push_back(first_step + k);
        }
        last_with_length_ = i;
        if (!is_smooth_) flush(i);
      }
      first_step += count;
    }
    flush(last_with_length_);
  }

  /// The ends of a run that leads from segment `begin` to the end of segment `end`.
  void finish_run(SplineRun& run, std::size_t row, std::size_t begin, std::size_t end) const {
    run.periodic = is_smooth_ && drawn_.closed();
    if (run.periodic) return;
    if (follower_.has_slopes) {
      run.first_slope = slopes_behind_[begin][row] / durations_[begin];
      run.last_slope = slopes_before_[end][row] / durations_[end];
      return;
    }
    const std::size_t n = run.values.size();
    std::array<double, 5> first{};
    std::array<double, 5> last{};
    for (std::size_t k = 0; k < first.size(); ++k) {
      first[k] = run.values[k];
      last[k] = run.values[n - 1 - k];
    }
    run.first_slope = first_slope_of(first, run.steps.front());
    run.last_slope = -first_slope_of(last, run.steps.back());
  }

  const Path& drawn_;
  bool is_smooth_;
  const Follower& follower_;
  const FollowLayout& layout_;
  std::vector<std::int16_t> parts_;
  std::vector<double> durations_;
  std::vector<Row> values_;                         // at every place
  std::vector<Row> slopes_behind_, slopes_before_;  // of every segment, by its t
  std::vector<std::vector<Cubic>> followed_;        // by row, then step
  std::size_t last_with_length_ = 0;
};

struct SegmentBounds {
  FollowAccuracy worst;
  std::int16_t worst_part = 0;
  std::size_t worst_step = 0;
};

/// The worst of all parts of a segment that begins at `step`.
SegmentBounds bounds_of(const Construction& construction, std::size_t segment, std::size_t step,
                        const FollowLayout& layout, const Kinematics& kinematics, std::int32_t link,
                        const std::vector<std::size_t>& coordinates, const FollowTolerance& tolerance) {
  std::vector<TipDeviation> found;
  double fastest = 0;
  for (std::int16_t part = 0; part < construction.parts()[segment]; ++part) {
    const auto at = step + static_cast<std::size_t>(part);
    const auto axes = construction.stretch(segment, part, at, layout.axes);
    const auto position = construction.stretch(segment, part, at, layout.position);
    const auto aim = construction.stretch(segment, part, at, layout.aim);
    found.push_back(tip_deviation(kinematics, link, {axes, coordinates, position, aim}));
    fastest = std::max(fastest, found.back().fastest);
  }
  SegmentBounds bounds;
  double worst = -1;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const double speed = std::max(found[k].slowest, slow_share * fastest);
    const double share = found[k].speed > 0 ? found[k].speed / speed : 0;
    FollowAccuracy& most = bounds.worst;
    most = {.off_m = std::max(most.off_m, found[k].off),
            .speed_share = std::max(most.speed_share, share),
            .aim_rad = std::max(most.aim_rad, found[k].aim)};
    const double excess = std::max(
        {found[k].off / tolerance.off_m, share / tolerance.speed_share, found[k].aim / tolerance.aim_rad});
    if (!(excess > worst)) continue;
    worst = excess;
    bounds.worst_part = static_cast<std::int16_t>(k);
    bounds.worst_step = step + k;
  }
  return bounds;
}

bool is_within(const FollowAccuracy& found, const FollowTolerance& tolerance) {
  return found.off_m <= tolerance.off_m && found.speed_share <= tolerance.speed_share &&
         found.aim_rad <= tolerance.aim_rad;
}

}  // namespace

FollowedPath followed_path(const Path& drawn, bool is_smooth, const Follower& follower,
                           const FollowLayout& layout, const Kinematics& kinematics, std::int32_t link,
                           const std::vector<std::size_t>& coordinates, const FollowTolerance& tolerance,
                           const std::function<void(const FollowObstacle&)>& refuse) {
  Construction construction(drawn, is_smooth, follower, layout);
  for (;;) {
    FollowedPath path = construction.build();
    bool is_done = true;
    std::size_t step = 0;
    const std::vector<std::int16_t> parts = construction.parts();
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const std::size_t first = std::exchange(step, step + static_cast<std::size_t>(parts[i]));
      if (!construction.has_length(i)) continue;
      const SegmentBounds bounds =
          bounds_of(construction, i, first, layout, kinematics, link, coordinates, tolerance);
      FollowAccuracy& all = path.accuracy;
      all = {.off_m = std::max(all.off_m, bounds.worst.off_m),
             .speed_share = std::max(all.speed_share, bounds.worst.speed_share),
             .aim_rad = std::max(all.aim_rad, bounds.worst.aim_rad)};
      if (is_within(bounds.worst, tolerance)) continue;
      is_done = false;
      if (construction.make_denser(i)) continue;
      refuse({{static_cast<std::int32_t>(i), (bounds.worst_part + 0.5) / parts[i]},
              construction.sharpest_row(bounds.worst_step)});
    }
    if (is_done) return path;
  }
}

}  // namespace inbetween
