#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/trajectory/fit.hpp"
#include "trajectory/piece_judge.hpp"
#include "trajectory/sampled_rows.hpp"

/// The fit of any motion that can be asked (fit_trajectory says how). A sampler has what TrackSampler has.

namespace inbetween {

/// No piece is shorter, in frames: there the rounding of positions would be a velocity.
inline constexpr double min_frames = 0x1p-36;
/// Nor one from or to a moment at which the velocity of an axis has no bound: it would follow that axis down
/// to where the rounding of the velocity of all others is a jerk.
inline constexpr double min_unbounded_frames = 0x1p-20;
/// Two joints that are nearer may have a line between them.
inline constexpr double line_frames = 0x1p-20;
/// A stretch between two joints that takes more pieces is one whose samples are rounded more than is known
/// here: from then on its tolerances are doubled, and again after as many pieces as that.
inline constexpr std::size_t usual_pieces = 2048;
/// A shorter piece is made from velocities, so that the rounding of positions at its ends is no jerk.
inline constexpr double by_velocity_frames = 0x1p-8;

inline Error no_room(const char* what, std::size_t needed) {
  return {.code = ErrorCode::capacity,
          .what = what,
          .remedy = "give it a larger capacity",
          .needed = static_cast<std::int64_t>(needed)};
}

/// Puts a trajectory together in the caller's memory.
template <class Sampler>
class TrajectoryBuilder {
  using Joint = typename Sampler::Joint;
  using Rows = SampledRows<Sampler>;
  using Judge = PieceJudge<Sampler>;

 public:
  TrajectoryBuilder(const Sampler& sampler, const FitTolerances& tolerances, const TrajectoryMemory& memory)
      : sampler_(sampler),
        memory_(memory),
        axes_(sampler.axis_count()),
        here_(memory.samples.first(axes_)),
        there_(memory.samples.subspan(axes_, axes_)),
        here_row_(memory.numbers.first(row_numbers * axes_)),
        rows_(sampler, there_, memory.numbers.subspan(row_numbers * axes_, Rows::numbers * axes_)),
        judge_(sampler, tolerances, memory.samples.subspan(2 * axes_, axes_),
               memory.numbers.subspan((row_numbers + Rows::numbers) * axes_, Judge::numbers * axes_)),
        seconds_per_frame_(static_cast<double>(sampler.frame_rate().denominator) /
                           static_cast<double>(sampler.frame_rate().numerator)),
        is_cubic_(sampler.is_cubic()) {}

  Result<Trajectory> build() {
    const std::span<const Joint> joints = sampler_.joints();
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
                            memory_.buckets.first(std::min(memory_.buckets.size(), 2 * pieces_)));
  }

 private:
  struct Row {
    std::uint32_t offset = 0;  ///< in the values
    std::uint8_t order = 3;    ///< of its highest derivative
    double speed = 0;          ///< SampledSpeed::speed
  };

  [[nodiscard]] std::size_t numbers_of(std::uint8_t order) const { return (order + std::size_t{1}) * axes_; }
  /// The next piece begins with this row, which goes to the values.
  void begin_with(const SampledSpeed& known, const double* row) {
    row_ = {static_cast<std::uint32_t>(values_), known.order, known.speed};
    const std::size_t needed = numbers_of(known.order);
    if (values_ + needed <= memory_.values.size()) std::copy_n(row, needed, &memory_.values[values_]);
    values_ += needed;
  }
  /// Of a row or of what is known of a moment: its velocities have bounds.
  static bool has_velocities(const auto& known) { return known.order > 0 || known.speed == 0; }
  [[nodiscard]] bool is_full() const {
    return values_ > memory_.values.size() || pieces_ > memory_.pieces.size();
  }

  void note_unbounded(const Joint& joint, const SampledSpeed& known) {
    for (std::size_t d = 0; d < axes_; ++d) {
      const std::uint8_t order = sampler_.unbounded_order(joint, known, d);
      if (order > 0) add(UnboundedSide{joint.time, static_cast<std::int32_t>(d), joint.key, order});
    }
  }

  void arrive_at(const Joint& joint) { note_unbounded(joint, sampler_.arriving(joint, there_)); }
  /// The row with which the motion leaves a joint: that with which it came where both are the same.
  void leave(const Joint& joint) {
    const SampledSpeed known = sampler_.leaving(joint, here_);
    const bool is_first = pieces_ == 0;
    if (is_behind_rest_ && !is_full()) {  // where it rests, it begins: not beside it by a rounding
      for (std::size_t d = 0; d < axes_; ++d) here_[d].position = memory_.values[row_.offset + d];
    }
    is_behind_rest_ = false;
    write_row(here_, here_row_.data());
    judge_.end_at(known);
    judge_.go_on();
    if (is_first || known.order != row_.order || !is_same()) {
      begin_with(known, here_row_.data());
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
    const std::size_t numbers = numbers_of(row_.order);
    return std::ranges::equal(here_row_.first(numbers), memory_.values.subspan(row_.offset, numbers));
  }

  /// A stretch at rest, as one piece with one row at both ends.
  bool rest(const Joint& from, const Joint& to) {
    if (!sampler_.rests_behind(from)) return false;
    TrajectoryPiece piece = piece_between(from.time, to.time, row_.order);
    piece.end_row = piece.begin_row;
    piece.degree = 1;
    piece.is_exact = true;
    add(piece);
    is_behind_rest_ = true;
    return true;
  }
  /// Halves the stretch from one joint to the next: the pieces are the leaves of a binary tree, from left to
  /// right.
  void fill(const Joint& from, const Joint& to) {
    const std::size_t pieces_before = pieces_;
    double loosened = 1;
    rows_.begin(from, to);
    const bool is_bounded = has_velocities(row_) && has_velocities(rows_.end(0, 1).known);
    const double min = is_bounded ? min_frames : min_unbounded_frames;
    std::array<bool, max_trajectory_axes> is_sharp{};
    std::uint64_t index = 0;
    int level = 0;
    while (!is_full()) {
      const SampledRow& last = rows_.end(level, index + 1);
      judge_.end_at(last.known);
      TrajectoryPiece piece =
          piece_between(rows_.time(level, index), rows_.time(level, index + 1), last.known.order);
      const JudgedPiece judged{.piece = &piece,
                               .rows = {&memory_.values[row_.offset], last.values, axes_},
                               .loosened = loosened,
                               .slowest = std::min(row_.speed, last.known.speed),
                               .is_first = index == 0,
                               .is_last = index + 1 == std::uint64_t{1} << level};
      if (level == 0 && is_as_good_as_a_line(judged)) piece.degree = 1;
      if (!is_cubic_ && piece.degree > 1 && !is_near(judged, level, index)) {
        if (piece.inverse_frames * (2 * min) <= 1) {
          index *= 2;
          ++level;
          continue;
        }
        piece.degree = 1;
        note_sharp(judged, is_sharp);
      }
      piece.end_row = static_cast<std::uint32_t>(values_);
      add(piece);
      if (pieces_ - pieces_before >= usual_pieces * static_cast<std::size_t>(loosened)) {
        loosened *= 2;
        loosened_ = std::max(loosened_, loosened);
      }
      begin_with(last.known, last.values);
      judge_.go_on();
      if (judged.is_last) return;
      // On with the second half of the smallest part whose first half is done.
      for (++index; index % 2 == 0; index /= 2) --level;
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
  /// It begins with `row_`, and its end is known so well.
  [[nodiscard]] TrajectoryPiece piece_between(const FrameTime& begin, const FrameTime& end,
                                              std::uint8_t end_order) const {
    const double frames = frames_between(begin, end);
    return {.begin = begin,
            .inverse_frames = 1 / frames,
            .seconds = frames * seconds_per_frame_,
            .begin_row = row_.offset,
            .degree = degree_of(std::min(row_.order, end_order), frames),
            .is_exact = is_cubic_};
  }

  bool is_near(const JudgedPiece& judged, int level, std::uint64_t index) {
    if (judged.piece->degree != 7) return judge_.is_near(judged);
    const SampledRow& middle = rows_.middle(level, index);
    if (middle.known.order < 3) return judge_.is_near(judged);
    const bool near = judge_.is_near(judged, middle);
    if (!near) rows_.keep_middle();
    return near;
  }
  /// Two joints may be so near to each other that the rounding of the velocities would be a jerk between
  /// them.
  bool is_as_good_as_a_line(JudgedPiece judged) {
    if (is_cubic_ || judged.piece->inverse_frames < 1 / line_frames) return false;
    TrajectoryPiece line = *judged.piece;
    line.degree = 1;
    judged.piece = &line;
    return judge_.is_near(judged);
  }
  /// What turns more sharply than the shortest piece can is played as a line, and its acceleration has no
  /// bound.
  void note_sharp(const JudgedPiece& judged, std::span<bool> is_noted) {
    std::array<bool, max_trajectory_axes> is_off{};
    judge_.mark_off(judged, is_off);
    for (std::size_t d = 0; d < axes_; ++d) {
      if (!is_off[d] || is_noted[d]) continue;
      add(UnboundedSide{judged.piece->begin, static_cast<std::int32_t>(d), -1, 2});
      is_noted[d] = true;
    }
  }

  const Sampler& sampler_;
  TrajectoryMemory memory_;
  std::size_t axes_;
  std::span<AxisMotion> here_, there_;
  std::span<double> here_row_;
  Rows rows_;
  Judge judge_;
  double seconds_per_frame_;
  bool is_cubic_;
  bool is_behind_rest_ = false;
  double loosened_ = 1;
  Row row_;
  std::size_t pieces_ = 0, values_ = 0, breaks_ = 0, unbounded_ = 0;
};

template <class Sampler>
[[gnu::always_inline]] inline Result<Trajectory> fit_sampled(const Sampler& sampler,
                                                             const FitTolerances& tolerances,
                                                             const TrajectoryMemory& memory) {
  const std::size_t axes = sampler.axis_count();
  if (memory.buckets.empty() || memory.samples.size() < 3 * axes ||
      memory.numbers.size() < fit_numbers * axes)
    return no_room("the memory of a trajectory has no buckets, samples or numbers", fit_numbers * axes);
  if (axes > max_trajectory_axes) return no_room("the trajectory has more axes than it may", axes);
  return TrajectoryBuilder<Sampler>(sampler, tolerances, memory).build();
}

}  // namespace inbetween
