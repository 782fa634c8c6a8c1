#include "inbetween/trajectory/fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "trajectory/hermite.hpp"

namespace inbetween {
namespace {

/// Where a piece is compared with what is asked: the middle, and beside the places where the derivative of
/// the error of a septic is largest.
constexpr std::array<double, 5> compared_at{0.12, 0.3, 0.5, 0.7, 0.88};
/// No piece is shorter, in frames: there the rounding of positions would be a velocity.
constexpr double min_frames = 0x1p-36;
/// Differences below so many roundings mean nothing.
constexpr double roundings = 8;

Error no_room(const char* what, std::size_t needed) {
  return {.code = ErrorCode::capacity,
          .what = what,
          .remedy = "give it a larger capacity",
          .needed = static_cast<std::int64_t>(needed)};
}

}  // namespace

/// Puts a trajectory together in the caller's memory.
class TrajectoryBuilder {
 public:
  TrajectoryBuilder(const DrawnSampler& sampler, const FitTolerances& tolerances,
                    const TrajectoryMemory& memory)
      : sampler_(sampler),
        tolerances_(tolerances),
        memory_(memory),
        axes_(sampler.axis_count()),
        here_(memory.samples.first(axes_)),
        there_(memory.samples.subspan(axes_, axes_)),
        between_(memory.samples.subspan(2 * axes_, axes_)),
        seconds_per_frame_(static_cast<double>(sampler.frame_rate().denominator) /
                           static_cast<double>(sampler.frame_rate().numerator)) {}

  Result<Trajectory> build() {
    const std::span<const SampledJoint> joints = sampler_.joints();
    measure_travel();
    for (std::size_t i = 0; i < joints.size(); ++i) {
      if (i > 0) arrive_at(joints[i]);
      if (i + 1 < joints.size()) leave(joints[i]);
      if (i + 1 < joints.size()) fill(joints[i], joints[i + 1]);
    }
    if (pieces_ > memory_.pieces.size())
      return no_room("the trajectory has more pieces than its memory", pieces_);
    if (values_ > memory_.values.size())
      return no_room("the trajectory has more values than its memory", values_);
    if (breaks_ > memory_.breaks.size())
      return no_room("the trajectory has more breaks than its memory", breaks_);
    if (unbounded_ > memory_.unbounded.size())
      return no_room("the trajectory has more unbounded sides than its memory", unbounded_);
    return finished(joints);
  }

 private:
  struct Row {
    std::uint32_t offset = 0;  ///< in the values
    std::uint8_t order = 3;    ///< of its highest derivative
  };

  /// How far each axis goes, by its joints and the middles between them: what the tolerance is a share of.
  void measure_travel() {
    const std::span<const SampledJoint> joints = sampler_.joints();
    static_cast<void>(sampler_.leaving(joints.front(), here_));
    // here_ keeps the lowest in `position` and the highest in `velocity` until the fit begins.
    for (AxisMotion<double>& axis : here_) axis.velocity = axis.position;
    const auto take = [&] {
      for (std::size_t d = 0; d < axes_; ++d) {
        here_[d].position = std::min(here_[d].position, between_[d].position);
        here_[d].velocity = std::max(here_[d].velocity, between_[d].position);
      }
    };
    for (std::size_t i = 1; i < joints.size(); ++i) {
      const double frames = frames_between(joints[i - 1].time, joints[i].time);
      static_cast<void>(sampler_.sample(moved_by(joints[i - 1].time, frames / 2), between_));
      take();
      static_cast<void>(sampler_.arriving(joints[i], between_));
      take();
    }
    for (std::size_t d = 0; d < axes_; ++d)
      max_off_[d] = tolerances_.position_share * (here_[d].velocity - here_[d].position);
  }
  Row stored(std::span<const AxisMotion<double>> row, const SampledSpeed& known) {
    const Row result{static_cast<std::uint32_t>(values_), known.order};
    const std::size_t needed = (known.order + std::size_t{1}) * axes_;
    if (values_ + needed <= memory_.values.size()) {
      double* out = &memory_.values[values_];
      for (std::size_t d = 0; d < axes_; ++d) {
        out[d] = row[d].position;
        if (known.order >= 1) out[axes_ + d] = row[d].velocity;
        if (known.order >= 3) {
          out[2 * axes_ + d] = row[d].acceleration;
          out[3 * axes_ + d] = row[d].jerk;
        }
      }
    }
    values_ += needed;
    return result;
  }
  [[nodiscard]] bool is_full() const {
    return values_ > memory_.values.size() || pieces_ > memory_.pieces.size();
  }

  void note_unbounded(const SampledJoint& joint, const PathPoint<double>& point, const SampledSpeed& known) {
    // At rest what comes to a standstill has bounds.
    if (known.order >= 3 || known.speed == 0) return;
    for (std::size_t d = 0; d < axes_; ++d) {
      if (known.order == 1 && !sampler_.is_unbounded(point, d)) continue;
      if (unbounded_ < memory_.unbounded.size()) {
        memory_.unbounded[unbounded_] = {joint.time, static_cast<std::int32_t>(d), joint.key,
                                         static_cast<std::uint8_t>(known.order + 1)};
      }
      ++unbounded_;
    }
  }

  void arrive_at(const SampledJoint& joint) {
    note_unbounded(joint, joint.point_before, sampler_.arriving(joint, there_));
  }
  /// The row with which the motion leaves a joint: that with which it came where both are the same.
  void leave(const SampledJoint& joint) {
    const SampledSpeed known = sampler_.leaving(joint, here_);
    const bool is_first = pieces_ == 0;
    if (!is_first && known.order == row_.order && is_same()) return;
    row_ = stored(here_, known);
    note_unbounded(joint, joint.point_after, known);
    if (is_first) return;
    if (breaks_ < memory_.breaks.size())
      memory_.breaks[breaks_] = {joint.time, static_cast<std::uint32_t>(pieces_), joint.key};
    ++breaks_;
  }
  [[nodiscard]] bool is_same() const {
    if (is_full()) return false;
    const double* last = &memory_.values[row_.offset];
    for (std::size_t d = 0; d < axes_; ++d) {
      if (last[d] != here_[d].position || last[axes_ + d] != here_[d].velocity) return false;
      if (row_.order < 3) continue;
      if (last[2 * axes_ + d] != here_[d].acceleration || last[3 * axes_ + d] != here_[d].jerk) return false;
    }
    return true;
  }

  /// Halves the stretch from one joint to the next: the pieces are those of a binary tree, from left to
  /// right.
  void fill(const SampledJoint& from, const SampledJoint& to) {
    const double frames = frames_between(from.time, to.time);
    std::uint64_t index = 0;
    int level = 0;
    while (!is_full()) {
      const double share = std::ldexp(1.0, -level);
      const FrameTime<double> begin =
          index == 0 ? from.time : moved_by(from.time, frames * share * static_cast<double>(index));
      const bool is_last = index + 1 == std::uint64_t{1} << level;
      const FrameTime<double> end =
          is_last ? to.time : moved_by(from.time, frames * share * static_cast<double>(index + 1));
      const SampledSpeed known = is_last ? sampler_.arriving(to, there_) : sampler_.sample(end, there_);
      const std::size_t values_before = values_;
      const Row end_row = stored(there_, known);
      if (is_full()) return;
      const TrajectoryPiece piece = piece_between(begin, end, row_, end_row);
      if (frames * share >= 2 * min_frames && !is_near(piece)) {
        values_ = values_before;
        index *= 2;
        ++level;
        continue;
      }
      if (pieces_ < memory_.pieces.size()) memory_.pieces[pieces_] = piece;
      ++pieces_;
      row_ = end_row;
      if (is_last) return;
      for (++index; index % 2 == 0; index /= 2) --level;
    }
    ++pieces_;  // so that a memory that is too small is told
  }
  [[nodiscard]] TrajectoryPiece piece_between(const FrameTime<double>& begin, const FrameTime<double>& end,
                                              const Row& first, const Row& last) const {
    const double frames = frames_between(begin, end);
    return {.begin = begin,
            .inverse_frames = 1 / frames,
            .seconds = frames * seconds_per_frame_,
            .begin_row = first.offset,
            .end_row = last.offset,
            .degree = static_cast<std::uint8_t>(2 * std::min(first.order, last.order) + 1)};
  }

  /// Whether a piece is within the tolerances.
  [[nodiscard]] bool is_near(const TrajectoryPiece& piece) {
    const double frames = 1 / piece.inverse_frames;
    for (const double u : compared_at) {
      const SampledSpeed asked = sampler_.sample(moved_by(piece.begin, u * frames), between_);
      bool near = true;
      with_known(piece.degree, [&](auto known) {
        const HermiteWeights at = position_weights<known>(u, piece.seconds);
        const HermiteWeights rate = hermite_weights<known, 1>(u, piece.seconds);
        for (std::size_t d = 0; d < axes_ && near; ++d) {
          const double position = memory_.values[piece.begin_row + d] + sum<known>(at, piece, d);
          const double velocity = sum<known>(rate, piece, d);
          const double weight = sampler_.weight(d);
          const double most =
              tolerances_.speed_share * (weight > 0 ? asked.speed / weight : std::fabs(between_[d].velocity));
          const double noise = noise_of(between_[d], asked.speed);
          near = std::fabs(position - between_[d].position) <= max_off_[d] + noise &&
                 std::fabs(velocity - between_[d].velocity) <= most + noise / piece.seconds;
        }
      });
      if (!near) return false;
    }
    return true;
  }
  /// What rounding leaves open of a position: of the number itself, and of the distance along the path.
  [[nodiscard]] double noise_of(const AxisMotion<double>& axis, double speed) const {
    const double along = speed > 0 ? std::fabs(axis.velocity) / speed * sampler_.length() : 0;
    return roundings * std::numeric_limits<double>::epsilon() * (std::fabs(axis.position) + along);
  }
  template <std::size_t Known>
  [[nodiscard]] double sum(const HermiteWeights& w, const TrajectoryPiece& piece, std::size_t d) const {
    const double* begin = &memory_.values[piece.begin_row];
    const double* end = &memory_.values[piece.end_row];
    double sum = w.end[0] * (end[d] - begin[d]);
    for (std::size_t j = 1; j < Known; ++j)
      sum += w.begin[j] * begin[j * axes_ + d] + w.end[j] * end[j * axes_ + d];
    return sum;
  }

  Trajectory finished(std::span<const SampledJoint> joints) {
    Trajectory trajectory;
    trajectory.axis_count_ = axes_;
    trajectory.end_ = joints.back().time;
    trajectory.fps_ = sampler_.frame_rate();
    trajectory.pieces_ = memory_.pieces.first(pieces_);
    trajectory.values_ = memory_.values.first(values_);
    trajectory.breaks_ = memory_.breaks.first(breaks_);
    trajectory.unbounded_ = memory_.unbounded.first(unbounded_);
    const double frames = frames_between(joints.front().time, joints.back().time);
    trajectory.buckets_per_frame_ = static_cast<double>(memory_.buckets.size()) / frames;
    std::size_t piece = 0;
    for (std::size_t b = 0; b < memory_.buckets.size(); ++b) {
      const double begin = static_cast<double>(b) / trajectory.buckets_per_frame_;
      // A little before its begin: what is looked up is not behind it, however both are rounded.
      while (piece + 1 < pieces_ &&
             frames_between(joints.front().time, memory_.pieces[piece + 1].begin) <= begin * (1 - 1e-12))
        ++piece;
      memory_.buckets[b] = static_cast<std::uint32_t>(piece);
    }
    trajectory.buckets_ = memory_.buckets;
    return trajectory;
  }

  const DrawnSampler& sampler_;
  FitTolerances tolerances_;
  TrajectoryMemory memory_;
  std::size_t axes_;
  std::span<AxisMotion<double>> here_, there_, between_;
  double seconds_per_frame_;
  std::array<double, max_trajectory_axes> max_off_{};  ///< of the position of each axis
  Row row_;
  std::size_t pieces_ = 0, values_ = 0, breaks_ = 0, unbounded_ = 0;
};

Result<Trajectory> fit_trajectory(const DrawnSampler& sampler, const FitTolerances& tolerances,
                                  const TrajectoryMemory& memory) {
  if (memory.buckets.empty() || memory.samples.size() < 3 * sampler.axis_count())
    return no_room("the memory of a trajectory has no buckets or samples", 3 * sampler.axis_count());
  if (sampler.axis_count() > max_trajectory_axes)
    return no_room("the trajectory has more axes than it may", sampler.axis_count());
  return TrajectoryBuilder(sampler, tolerances, memory).build();
}

}  // namespace inbetween
