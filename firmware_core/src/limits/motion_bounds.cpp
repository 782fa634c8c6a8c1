#include "inbetween/limits/motion_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "branch_and_bound.hpp"
#include "inbetween/base/bisection.hpp"
#include "motion_enclosure.hpp"
#include "time_pieces.hpp"

namespace inbetween {
namespace {

/// A proven bound may be this much above the largest value found: half of what is promised.
template <Precise Real>
inline constexpr Real closeness = Real(0.005);
constexpr HalvingLimits stretch_halvings{.max = 44, .before_rounding = 10};
/// Samples of a stretch before any of it is proven: a peak found early saves work on all that is lower.
constexpr int samples_per_stretch = 6;

constexpr std::size_t quantities = motion_quantities;
template <Precise Real>
using Triple = MotionTriple<Real>;

template <Precise Real>
class MotionBounds {
 public:
  MotionBounds(const Track<Real>& track, std::span<const MotionTriple<Real>> slack,
               std::span<AxisTurn<Real>> turns, std::span<AxisPeaks<Real>> out, const WholeFrames& part)
      : track_(track),
        part_(part),
        axes_(static_cast<std::size_t>(track.path().axis_count())),
        slack_(slack),
        out_(out.first(axes_)),
        walk_(track, part),
        enclosure_(track, turns) {}

  void run() {
    for (std::size_t d = 0; d < axes_; ++d) bound_position(d);
    walk_.run([this](const Stretch<Real>& stretch) { sample(stretch); });
    walk_.run([this](const Stretch<Real>& stretch) { prove(stretch); });
    for (std::size_t d = 0; d < axes_; ++d) {
      const auto peaks = peaks_of(out_[d]);
      for (std::size_t i = 0; i < quantities; ++i) {
        peaks[i]->value = std::max(peaks[i]->value, best_[d][i]) * (1 + bound_rounding<Real>);
      }
    }
  }

  // The rules of branch_and_bound.

  std::uint64_t take(std::size_t group, std::uint64_t open, const MotionRange<Group<Real>>& range,
                     Real frame) {
    std::uint64_t far = 0;
    for (std::size_t k = 0; k < group_size; ++k) {
      if ((open >> k & 1) == 0) continue;
      const std::size_t d = group * group_size + k;
      raise(d, lane_of<Real>(range.here, k), frame);
      const Triple<Real> bounds = lane_of<Real>(range.bound, k);
      bool is_close = true;
      for (std::size_t i = 0; i < quantities; ++i) is_close = is_close && bounds[i] <= allowed(d, i);
      if (is_close) {
        accept(d, bounds, frame);
      } else {
        far |= std::uint64_t{1} << k;
      }
    }
    return far;
  }

  void raise(std::size_t d, const Triple<Real>& values, Real frame) {
    const auto peaks = peaks_of(out_[d]);
    for (std::size_t i = 0; i < quantities; ++i) {
      const Real value = std::fabs(values[i]);
      if (!(value > best_[d][i]) || !std::isfinite(value)) continue;
      best_[d][i] = value;
      if (std::isfinite(peaks[i]->value)) peaks[i]->frame = frame;
    }
  }

  /// A value without a bound needs no proof of another.
  [[nodiscard]] Real allowed(std::size_t d, std::size_t quantity) const {
    const std::array<Real, quantities> values{out_[d].velocity.value, out_[d].acceleration.value,
                                              out_[d].jerk.value};
    if (values[quantity] > std::numeric_limits<Real>::max()) return values[quantity];
    return slack_[d][quantity] / 2 + best_[d][quantity] * (1 + closeness<Real>);
  }
  void accept(std::size_t d, const Triple<Real>& bounds, Real frame) {
    const auto peaks = peaks_of(out_[d]);
    for (std::size_t i = 0; i < quantities; ++i) {
      if (!(bounds[i] > peaks[i]->value)) continue;
      peaks[i]->value = bounds[i];
      if (!(bounds[i] <= allowed(d, i))) peaks[i]->frame = frame;
    }
  }

 private:
  static std::array<Peak<Real>*, quantities> peaks_of(AxisPeaks<Real>& axis) {
    return {&axis.velocity, &axis.acceleration, &axis.jerk};
  }

  // --- position

  void bound_position(std::size_t d) {
    AxisPeaks<Real>& axis = out_[d];
    axis = {};
    const Path<Real>& path = track_.path();
    const PathPoint<Real> start = part_.first > 0 ? track_.locate({part_.first, 0}) : PathPoint<Real>{};
    const PathPoint<Real> end = track_.locate({part_.last, 0});
    PathPoint<Real> lowest = start;
    PathPoint<Real> highest = start;
    const auto position = [&](const PathPoint<Real>& point) {
      return path.position(point, static_cast<std::int32_t>(d));
    };
    axis.lowest.value = axis.highest.value = position(start);
    const auto take = [&](Real value, const PathPoint<Real>& point) {
      if (value < axis.lowest.value) {
        axis.lowest.value = value;
        lowest = point;
      }
      if (value > axis.highest.value) {
        axis.highest.value = value;
        highest = point;
      }
    };
    for (std::int32_t i = start.segment; i <= std::min<std::int32_t>(end.segment, path.segment_count() - 1);
         ++i) {
      const Cubic<Real>& cubic = path.segment(i)[d];
      const Real first = i == start.segment ? start.t : Real(0);
      const Real last = i == end.segment ? end.t : Real(1);
      for (const Real t : turning_points(cubic)) {
        if (t > first && t < last) take(position({i, t}), {i, t});
      }
      if (i < end.segment) take(path.segment(i + 1)[d].c0, {i + 1, 0});
    }
    take(position(end), end);
    axis.lowest.frame = frame_of(lowest);
    axis.highest.frame = frame_of(highest);
  }
  /// The zeros of the derivative; those outside (0, 1) do not matter.
  static std::array<Real, 2> turning_points(const Cubic<Real>& cubic) {
    const Real a = 3 * cubic.c3;
    const Real b = 2 * cubic.c2;
    const Real discriminant = b * b - 4 * a * cubic.c1;
    if (discriminant < 0) return {-1, -1};
    const Real r = -(b + std::copysign(std::sqrt(discriminant), b)) / 2;
    return {a != 0 ? r / a : Real(-1), r != 0 ? cubic.c1 / r : Real(-1)};
  }
  /// The frame on which the move reaches a point of the path.
  [[nodiscard]] Real frame_of(const PathPoint<Real>& point) const {
    const auto is_before = [&](Real frame) {
      const auto whole = static_cast<std::int32_t>(frame);
      const PathPoint<Real> here = track_.locate({whole, frame - static_cast<Real>(whole)});
      return here.segment < point.segment || (here.segment == point.segment && here.t < point.t);
    };
    const auto last = static_cast<Real>(part_.last);
    return bisected<Real>({static_cast<Real>(part_.first), last}, std::numeric_limits<Real>::digits,
                          is_before)
        .high;
  }

  // --- the largest values found

  void sample(const Stretch<Real>& stretch) {
    enclosure_.show(stretch.path);
    take_reversal(stretch);
    for (int i = 0; i <= samples_per_stretch; ++i) {
      const Real x = stretch.from + static_cast<Real>(i) / samples_per_stretch * (stretch.to - stretch.from);
      const MotionSurroundings<Real> point = enclosure_.at(stretch, x, walk_.tau_at(stretch, x));
      const Real frame = stretch.time.frame(x);
      enclosure_.middles(point, [&](std::size_t group, const GroupTriple<Real>& here) {
        for (std::size_t d = group * group_size; d < std::min((group + 1) * group_size, axes_); ++d) {
          raise(d, lane_of<Real>(here, d % group_size), frame);
        }
      });
    }
  }
  void take_reversal(const Stretch<Real>& stretch) {
    if (stretch.from > 0 || !enclosure_.turns_back(stretch)) return;
    for (std::size_t d = 0; d < axes_; ++d) {
      if (!enclosure_.steps_where_it_turns_back(d)) continue;
      const Real unbounded = std::numeric_limits<Real>::infinity();
      out_[d].acceleration = {unbounded, stretch.time.frame(0)};
      out_[d].jerk = {unbounded, stretch.time.frame(0)};
    }
  }

  // --- the proof

  void prove(const Stretch<Real>& stretch) {
    enclosure_.show(stretch.path);
    const MotionBox<Real> whole{
        .begin = stretch.from, .end = stretch.to, .tau_begin = stretch.tau_from, .tau_end = stretch.tau_to};
    branch_and_bound<stretch_halvings>(enclosure_, walk_, stretch, whole, axes_, *this);
  }

  const Track<Real>& track_;
  WholeFrames part_;
  std::size_t axes_;
  std::span<const MotionTriple<Real>> slack_;
  std::span<AxisPeaks<Real>> out_;
  StretchWalk<Real> walk_;
  MotionEnclosure<Real> enclosure_;
  std::array<Triple<Real>, max_bounded_axes> best_{};
};

}  // namespace

template <Precise Real>
Status bound_motion(const Track<Real>& track, std::span<const MotionTriple<Real>> slack,
                    const MotionBoundsMemory<Real>& memory, std::span<AxisPeaks<Real>> out,
                    const std::optional<WholeFrames>& part) {
  const auto axes = static_cast<std::size_t>(track.path().axis_count());
  if (axes > max_bounded_axes || memory.turns.size() < axes || slack.size() < axes || out.size() < axes) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the track has more axes than the memory of its bounds",
                 .remedy = "give it a larger capacity; 64 axes at most",
                 .needed = static_cast<std::int64_t>(axes)};
  }
  MotionBounds<Real>(track, slack, memory.turns, out, part.value_or(WholeFrames{0, track.frames()})).run();
  return Done{};
}

template Status bound_motion(const Track<double>&, std::span<const MotionTriple<double>>,
                             const MotionBoundsMemory<double>&, std::span<AxisPeaks<double>>,
                             const std::optional<WholeFrames>&);
template Status bound_motion(const Track<float>&, std::span<const MotionTriple<float>>,
                             const MotionBoundsMemory<float>&, std::span<AxisPeaks<float>>,
                             const std::optional<WholeFrames>&);

}  // namespace inbetween
