#include "inbetween/trajectory/fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "trajectory/drawn_sampler.hpp"
#include "trajectory/hermite.hpp"

namespace inbetween {
namespace {

/// Where a piece is compared with what is asked: where the derivative of the error of a septic,
/// u^4 (1 - u)^4, is largest, and nearer to its ends, where the speed may be that of a rest.
constexpr std::array<double, 4> compared_at{0.31, 0.69, 0.88, 0.12};
/// No piece is shorter, in frames: there the rounding of positions would be a velocity.
constexpr double min_frames = 0x1p-36;
/// Nor one from or to a moment at which the velocity of an axis has no bound: it would follow that axis down
/// to where the rounding of the velocity of all others is a jerk.
constexpr double min_unbounded_frames = 0x1p-20;
/// Two joints that are nearer may have a line between them.
constexpr double line_frames = 0x1p-20;
/// A stretch between two joints that takes more pieces is one whose samples are rounded more than is known
/// here: from then on its tolerances are doubled, and again after as many pieces as that.
constexpr std::size_t usual_pieces = 2048;
/// A shorter piece is made from velocities, so that the rounding of positions at its ends is no jerk.
constexpr double by_velocity_frames = 0x1p-8;
constexpr double min_speed_share = 1e-6;
/// Between the places at which a piece is compared it may be further off: in the middle 1.9 times, beside the
/// others its velocity.
constexpr double margin = 0.4;
/// Where the first two looks find less than this share, the other two are for the ends of a stretch.
constexpr double sure_share = 0.25;
/// A piece twice as long is off 2^7 times as far: it is only tried where this share of the tolerances is
/// enough.
constexpr double easy_share = 1.0 / 64;

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
  TrajectoryBuilder(const TrackSampler& sampler, const FitTolerances& tolerances,
                    const TrajectoryMemory& memory)
      : sampler_(sampler),
        tolerances_(tolerances),
        memory_(memory),
        axes_(sampler.axis_count()),
        here_(memory.samples.first(axes_)),
        there_(memory.samples.subspan(axes_, axes_)),
        between_(memory.samples.subspan(2 * axes_, axes_)),
        travel_(memory.numbers.first(axes_)),
        min_speeds_(memory.numbers.subspan(axes_, axes_)),
        inverse_weights_(memory.numbers.subspan(2 * axes_, axes_)),
        off_at_begin_(memory.numbers.subspan(3 * axes_, axes_)),
        off_at_end_(memory.numbers.subspan(4 * axes_, axes_)),
        seconds_per_frame_(static_cast<double>(sampler.frame_rate().denominator) /
                           static_cast<double>(sampler.frame_rate().numerator)),
        is_cubic_(sampler.is_cubic()) {}

  Result<Trajectory> build() {
    const std::span<const SampledJoint> joints = sampler_.joints();
    if (tolerances_.travel.empty()) {
      measure_travel(sampler_, there_, travel_);
    } else {
      std::copy_n(tolerances_.travel.begin(), axes_, travel_.begin());
    }
    for (std::size_t d = 0; d < axes_; ++d) {
      min_speeds_[d] = min_speed_share * travel_[d] / seconds_per_frame_;
      inverse_weights_[d] = sampler_.weight(d) > 0 ? 1 / sampler_.weight(d) : 0;
    }
    whole_seconds_ = seconds_per_frame_ * frames_between(joints.front().time, joints.back().time);
    for (std::size_t i = 0; i < joints.size(); ++i) {
      if (i > 0) arrive_at(joints[i]);
      if (i + 1 < joints.size()) leave(joints[i]);
      if (i + 1 < joints.size() && !rest(joints[i], joints[i + 1])) fill(joints[i], joints[i + 1]);
    }
    if (pieces_ > memory_.pieces.size())
      return no_room("the trajectory has more pieces than its memory", pieces_);
    if (values_ > memory_.values.size())
      return no_room("the trajectory has more values than its memory", values_);
    if (breaks_ > memory_.breaks.size())
      return no_room("the trajectory has more breaks than its memory", breaks_);
    if (unbounded_ > memory_.unbounded.size())
      return no_room("the trajectory has more unbounded sides than its memory", unbounded_);
    return Trajectory::make({.axis_count = axes_,
                             .fps = sampler_.frame_rate(),
                             .end = joints.back().time,
                             .pieces = memory_.pieces.first(pieces_),
                             .values = memory_.values.first(values_),
                             .breaks = memory_.breaks.first(breaks_),
                             .unbounded = memory_.unbounded.first(unbounded_),
                             .keeps_to_joints = sampler_.keeps_to_joints(),
                             .loosened = loosened_},
                            memory_.buckets);
  }

 private:
  struct Row {
    std::uint32_t offset = 0;    ///< in the values
    std::uint8_t order = 3;      ///< of its highest derivative
    bool is_off = false;         ///< SampledSpeed::off is not 0: off_at_begin_ or off_at_end_
    bool has_velocities = true;  ///< with bounds
  };

  Row stored(std::span<const AxisMotion<double>> row, const SampledSpeed& known) {
    const Row result{static_cast<std::uint32_t>(values_), known.order, known.off > 0, has_velocities(known)};
    if (known.off > 0) sampler_.write_reach(known.point, known.off, off_at_end_);
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
  /// The next piece begins with this row.
  void take(const Row& row) {
    row_ = row;
    if (row.is_off) std::ranges::copy(off_at_end_, off_at_begin_.begin());
  }
  static bool has_velocities(const SampledSpeed& known) { return known.order > 0 || known.speed == 0; }
  [[nodiscard]] bool is_full() const {
    return values_ > memory_.values.size() || pieces_ > memory_.pieces.size();
  }

  void note_unbounded(const SampledJoint& joint, const SampledSpeed& known) {
    // At rest what comes to a standstill has bounds.
    if (known.order >= 3 || known.speed == 0) return;
    for (std::size_t d = 0; d < axes_; ++d) {
      // Where the path stands still, an axis that does not count along it may have a way to go.
      const bool is_velocity = known.order == 0 && !(sampler_.weight(d) > 0);
      if (!is_velocity && !sampler_.is_unbounded(known.point, d)) continue;
      add(UnboundedSide{joint.time, static_cast<std::int32_t>(d), joint.key,
                        static_cast<std::uint8_t>(is_velocity ? 1 : 2)});
    }
  }

  void arrive_at(const SampledJoint& joint) { note_unbounded(joint, sampler_.arriving(joint, there_)); }
  /// The row with which the motion leaves a joint: that with which it came where both are the same.
  void leave(const SampledJoint& joint) {
    const SampledSpeed known = sampler_.leaving(joint, here_);
    const bool is_first = pieces_ == 0;
    if (is_behind_rest_ && !is_full()) {  // where it rests, it begins: not beside it by a rounding
      for (std::size_t d = 0; d < axes_; ++d) here_[d].position = memory_.values[row_.offset + d];
    }
    is_behind_rest_ = false;
    if (is_first || known.order != row_.order || !is_same()) {
      take(stored(here_, known));
      note_unbounded(joint, known);
    } else if (!is_cubic_ || !acceleration_steps()) {
      return;
    }
    if (is_first) return;
    if (breaks_ < memory_.breaks.size())
      memory_.breaks[breaks_] = {joint.time, static_cast<std::uint32_t>(pieces_), joint.key};
    ++breaks_;
  }
  /// Cubics that share position and velocity may still step in their accelerations.
  [[nodiscard]] bool acceleration_steps() const {
    for (std::size_t d = 0; d < axes_; ++d) {
      if (there_[d].acceleration != here_[d].acceleration) return true;
    }
    return false;
  }
  [[nodiscard]] bool is_same() const {
    if (is_full()) return false;
    const double* last = &memory_.values[row_.offset];
    for (std::size_t d = 0; d < axes_; ++d) {
      if (last[d] != here_[d].position) return false;
      if (row_.order >= 1 && last[axes_ + d] != here_[d].velocity) return false;
      if (row_.order < 3) continue;
      if (last[2 * axes_ + d] != here_[d].acceleration || last[3 * axes_ + d] != here_[d].jerk) return false;
    }
    return true;
  }

  /// A stretch at rest, as one piece with one row at both ends.
  bool rest(const SampledJoint& from, const SampledJoint& to) {
    if (!sampler_.rests_behind(from)) return false;
    TrajectoryPiece piece = piece_between(from.time, to.time, row_, row_);
    piece.degree = 1;
    piece.is_exact = true;
    add(piece);
    is_behind_rest_ = true;
    return true;
  }
  /// Halves the stretch from one joint to the next: the pieces are those of a binary tree, from left to
  /// right.
  void fill(const SampledJoint& from, const SampledJoint& to) {
    const std::size_t pieces_before = pieces_;
    double loosened = 1;
    const double frames = frames_between(from.time, to.time);
    const bool is_bounded = row_.has_velocities && has_velocities(sampler_.arriving(to, there_));
    const double min = is_bounded ? min_frames : min_unbounded_frames;
    std::array<bool, max_trajectory_axes> is_sharp{};
    std::uint64_t index = 0;
    int level = 0;
    while (!is_full()) {
      const double share = std::ldexp(1.0, -level);
      const FrameTime<double> begin =
          index == 0 ? from.time : moved_by(from.time, frames * share * static_cast<double>(index));
      const bool is_last = index + 1 == std::uint64_t{1} << level;
      const FrameTime<double> end =
          is_last ? to.time : moved_by(from.time, frames * share * static_cast<double>(index + 1));
      const SampledSpeed known =
          is_last ? sampler_.arriving(to, there_) : sampler_.sample(end, known_, there_);
      const std::size_t values_before = values_;
      const Row end_row = stored(there_, known);
      if (is_full()) return;
      TrajectoryPiece piece = piece_between(begin, end, row_, end_row);
      if (level == 0 && is_as_good_as_a_line(piece, end_row)) piece.degree = 1;
      if (!is_cubic_ && !is_near(piece, end_row, loosened, index == 0 || is_last)) {
        if (frames * share >= 2 * min) {
          values_ = values_before;
          index *= 2;
          ++level;
          continue;
        }
        piece.degree = 1;
        note_sharp(piece, end_row, loosened, is_sharp);
      }
      add(piece);
      if (pieces_ - pieces_before >= usual_pieces * static_cast<std::size_t>(loosened)) {
        loosened *= 2;
        loosened_ = std::max(loosened_, loosened);
      }
      take(end_row);
      if (is_last) return;
      ++index;
      if (is_easy_ && index % 2 == 0) {
        index /= 2;
        --level;
      }
    }
    ++pieces_;  // so that a memory that is too small is told
  }
  static std::uint8_t degree_of(std::uint8_t order, double frames) {
    if (order == 3 && frames < by_velocity_frames) return 6;
    return static_cast<std::uint8_t>(2 * order + 1);
  }
  void add(const UnboundedSide& side) {
    if (unbounded_ < memory_.unbounded.size()) memory_.unbounded[unbounded_] = side;
    ++unbounded_;
  }
  void add(const TrajectoryPiece& piece) {
    if (pieces_ < memory_.pieces.size()) memory_.pieces[pieces_] = piece;
    ++pieces_;
  }
  [[nodiscard]] TrajectoryPiece piece_between(const FrameTime<double>& begin, const FrameTime<double>& end,
                                              const Row& first, const Row& last) const {
    const double frames = frames_between(begin, end);
    return {.begin = begin,
            .inverse_frames = 1 / frames,
            .seconds = frames * seconds_per_frame_,
            .begin_row = first.offset,
            .end_row = last.offset,
            .degree = degree_of(std::min(first.order, last.order), frames),
            .is_exact = is_cubic_};
  }

  /// Two joints may be so near to each other that the rounding of the velocities would be a jerk between
  /// them.
  [[nodiscard]] bool is_as_good_as_a_line(TrajectoryPiece piece, const Row& end_row) {
    if (is_cubic_ || piece.inverse_frames < 1 / line_frames) return false;
    piece.degree = 1;
    return is_near(piece, end_row, 1, true);
  }
  /// Whether a piece is within the tolerances in all axes: `row_` is its first row.
  [[nodiscard]] bool is_near(const TrajectoryPiece& piece, const Row& end_row, double loosened,
                             bool touches_joint) {
    return compare(piece, end_row, loosened, touches_joint, [](std::size_t) { return false; });
  }
  /// What turns more sharply than the shortest piece can is played as a line, and its acceleration has no
  /// bound.
  void note_sharp(const TrajectoryPiece& piece, const Row& end_row, double loosened,
                  std::span<bool> is_noted) {
    compare(piece, end_row, loosened, true, [&](std::size_t axis) {
      if (!is_noted[axis]) add(UnboundedSide{piece.begin, static_cast<std::int32_t>(axis), -1, 2});
      return is_noted[axis] = true;
    });
  }
  /// Goes on after an axis that is off if `off` says so. Returns whether none was.
  template <class Off>
  bool compare(const TrajectoryPiece& piece, const Row& end_row, double loosened, bool touches_joint,
               const Off& off) {
    const double frames = 1 / piece.inverse_frames;
    const double per_second = 1 / piece.seconds;
    const double share = margin * loosened;
    bool near = true;
    bool goes_on = true;
    is_easy_ = true;
    bool is_sure = !touches_joint;
    for (const double u : compared_at) {
      if (is_sure && u == compared_at[2]) break;
      const SampledSpeed asked = sampler_.sample(moved_by(piece.begin, u * frames), known_, between_);
      with_degree(piece.degree, [&](auto degree) {
        const HermiteWeights at = position_weights<degree>(u, piece.seconds);
        const HermiteWeights rate = hermite_weights<degree, 1>(u, piece.seconds);
        const PieceRows rows = rows_of(piece, memory_.values, axes_);
        const double per_speed = asked.speed > std::numeric_limits<double>::min() ? 1 / asked.speed : 0;
        for (std::size_t d = 0; d < axes_ && goes_on; ++d) {
          const double position = rows.begin[d] + sum_of<known_of(degree)>(at, rows, d);
          const double velocity = sum_of<known_of(degree)>(rate, rows, d);
          const double near_by = share * tolerances_.position_share * travel_[d];
          const double near_speed = share * tolerances_.speed_share * counted_speed(d, asked.speed);
          const double noise = noise_of(d, per_speed, end_row);
          const double off_by = std::fabs(position - between_[d].position) - noise;
          const double off_speed =
              asked.order == 0 ? 0 : std::fabs(velocity - between_[d].velocity) - noise * per_second;
          is_sure = is_sure && off_by <= sure_share * near_by && off_speed <= sure_share * near_speed;
          is_easy_ = is_easy_ && off_by <= easy_share * near_by && off_speed <= easy_share * near_speed;
          if (off_by <= near_by && off_speed <= near_speed) continue;
          near = false;
          goes_on = off(d);
        }
      });
      if (!goes_on) break;
    }
    return near;
  }
  /// What the tolerance of an axis' velocity is a share of: the drawn speed; of an axis that does not count
  /// along the path its own velocity, and its share of the way, so that it may stand still. A way of less
  /// than a millionth in a frame is as good as a rest.
  [[nodiscard]] double counted_speed(std::size_t d, double speed) const {
    const double min_speed = min_speeds_[d];
    if (const double inverse = inverse_weights_[d]; inverse > 0) return std::max(speed * inverse, min_speed);
    const double length = sampler_.length();
    const double rate = length > 0 ? speed / length : 1 / whole_seconds_;
    return std::max(std::fabs(between_[d].velocity) + travel_[d] * rate, min_speed);
  }
  /// What rounding leaves open of a position: of the number itself, of the distance along the path, and at
  /// rest at either end of how near the curve comes to that place. No piece is so short that this were a
  /// speed.
  [[nodiscard]] double noise_of(std::size_t d, double per_speed, const Row& end_row) const {
    constexpr double rounding = distance_roundings * std::numeric_limits<double>::epsilon();
    const AxisMotion<double>& axis = between_[d];
    const double share = std::fabs(axis.velocity) * per_speed;
    return rounding * (std::fabs(axis.position) + share * sampler_.length()) +
           (row_.is_off ? off_at_begin_[d] : 0) + (end_row.is_off ? off_at_end_[d] : 0);
  }

  const TrackSampler& sampler_;
  FitTolerances tolerances_;
  TrajectoryMemory memory_;
  std::size_t axes_;
  std::span<AxisMotion<double>> here_, there_, between_;
  std::span<double> travel_, min_speeds_, inverse_weights_, off_at_begin_, off_at_end_;
  double seconds_per_frame_;
  bool is_cubic_;
  bool is_behind_rest_ = false;
  bool is_easy_ = false;  ///< what was compared last is far within the tolerances
  double loosened_ = 1;
  double whole_seconds_ = 0;
  Row row_;
  SampledSegment known_;
  std::size_t pieces_ = 0, values_ = 0, breaks_ = 0, unbounded_ = 0;
};

void measure_travel(const TrackSampler& sampler, std::span<AxisMotion<double>> samples,
                    std::span<double> out) {
  const std::span<const SampledJoint> joints = sampler.joints();
  std::array<double, max_trajectory_axes> lowest{}, highest{};
  lowest.fill(std::numeric_limits<double>::infinity());
  highest.fill(-std::numeric_limits<double>::infinity());
  const auto take = [&](const SampledSpeed&) {
    for (std::size_t d = 0; d < out.size(); ++d) {
      lowest[d] = std::min(lowest[d], samples[d].position);
      highest[d] = std::max(highest[d], samples[d].position);
    }
  };
  take(sampler.leaving(joints.front(), samples));
  for (std::size_t i = 1; i < joints.size(); ++i) {
    const double frames = frames_between(joints[i - 1].time, joints[i].time);
    take(sampler.sample(moved_by(joints[i - 1].time, frames / 2), samples));
    take(sampler.arriving(joints[i], samples));
  }
  for (std::size_t d = 0; d < out.size(); ++d) out[d] = highest[d] - lowest[d];
}

Result<Trajectory> fit_trajectory(const TrackSampler& sampler, const FitTolerances& tolerances,
                                  const TrajectoryMemory& memory) {
  const std::size_t axes = sampler.axis_count();
  if (memory.buckets.empty() || memory.samples.size() < 3 * axes || memory.numbers.size() < 5 * axes)
    return no_room("the memory of a trajectory has no buckets, samples or numbers", 5 * axes);
  if (axes > max_trajectory_axes) return no_room("the trajectory has more axes than it may", axes);
  return TrajectoryBuilder(sampler, tolerances, memory).build();
}

}  // namespace inbetween
