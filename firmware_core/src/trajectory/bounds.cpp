#include "inbetween/trajectory/bounds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "trajectory/bernstein.hpp"

namespace inbetween {
namespace {

constexpr double close_share = 1e-5;
constexpr double close_position = 1e-9;

/// This holds what is proven of some axes: how high they go, how low (with the sign changed), and the
/// magnitudes of three derivatives.
struct GroupBounds {
  Group highest, lowest;
  std::array<Group, 3> peaks;
};

/// 1 in the lanes whose hulls on a piece are beyond what is proven, and 0 in the others.
template <std::size_t Degree>
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void find_beyond(const PieceRows& rows, double seconds,
                                                             std::size_t axis, const GroupBounds& bounds,
                                                             Group& out) {
  using Number = Group;
  const Number yes(1);
  const Number begin = group_of<Number>(rows.begin, rows.axes, axis);
  Number beyond(0);
  visit_derivatives<Degree>(rows, seconds, axis, [&](std::size_t k, const auto& c, std::size_t n) {
    Number highest = c[0];
    Number lowest = c[0];
    for (std::size_t i = 1; i <= n; ++i) {
      highest = greatest(highest, c[i]);
      lowest = least(lowest, c[i]);
    }
    if (k == 0) {
      highest = highest + begin;
      lowest = lowest + begin;
    }
    beyond = if_less(k == 0 ? bounds.highest : bounds.peaks[k - 1], highest, yes, beyond);
    beyond = if_less(k == 0 ? bounds.lowest : bounds.peaks[k - 1], -1 * lowest, yes, beyond);
  });
  out = beyond;
}
/// The same of a row that is passed.
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void find_beyond(const double* row, std::size_t axes,
                                                             std::size_t axis, std::size_t known,
                                                             const GroupBounds& bounds, Group& out) {
  using Number = Group;
  const Number yes(1);
  const Number position = group_of<Number>(row, axes, axis);
  Number beyond = if_less(bounds.highest, position, yes, Number(0));
  beyond = if_less(bounds.lowest, -1 * position, yes, beyond);
  for (std::size_t k = 1; k < known; ++k)
    beyond =
        if_less(bounds.peaks[k - 1], absolute(group_of<Number>(row + k * axes, axes, axis)), yes, beyond);
  out = beyond;
}

/// Raises `bound` to what a polynomial reaches, proven: not below it, and above by `share` of it or `slack`.
class Search {
 public:
  Search(double share, double slack) : share_(share), slack_(slack) {}

  [[nodiscard]] double bound() const { return bound_; }
  [[nodiscard]] double reached() const { return reached_; }
  [[nodiscard]] double frame() const { return frame_; }
  void allow(double slack) { slack_ = slack; }
  /// A value that is reached at u on a piece.
  void reach(double value, double u, const TrajectoryPiece& piece) {
    if (!(value > reached_)) return;
    reached_ = value;
    bound_ = std::max(bound_, value);
    frame_ = frame_of(piece.begin) + u / piece.inverse_frames;
  }

  void take(const Bernstein& whole, const TrajectoryPiece& piece) {
    if (whole.highest() <= bound_) return;
    std::array<Bernstein, max_depth + 1> stack;
    std::size_t count = 0;
    stack[count++] = whole;
    while (count > 0) {
      Bernstein& top = stack[count - 1];
      const double highest = top.highest();
      reach(top.c[0], top.begin, piece);
      reach(top.c[top.degree], top.end, piece);
      const double enough = reached_ + std::max(share_ * std::fabs(reached_), slack_);
      if (highest <= std::max(enough, bound_) || count == stack.size()) {
        bound_ = std::max(bound_, highest);
        --count;
        continue;
      }
      const Bernstein second = top.halve();
      // The half that promises more comes first, so that the other is left out more often.
      stack[count++] = second;
    }
  }

 private:
  double share_;
  double slack_;
  double reached_ = -std::numeric_limits<double>::infinity();
  double bound_ = -std::numeric_limits<double>::infinity();
  double frame_ = 0;
};

class AxisBounds {
 public:
  AxisBounds() = default;
  AxisBounds(const Trajectory& trajectory, std::size_t axis) : trajectory_(&trajectory), axis_(axis) {}

  void reach_row(const double* row, const TrajectoryPiece& piece, double u) {
    const std::size_t axes = trajectory_->axis_count();
    highest_.reach(row[axis_], u, piece);
    lowest_.reach(-row[axis_], u, piece);
    for (std::size_t q = 0; q < peaks_.size() && q + 1 < known_of(piece.degree); ++q)
      peaks_[q].reach(std::fabs(row[(q + 1) * axes + axis_]), u, piece);
  }
  /// Behind the last row.
  void begin_search() {
    const double range = highest_.reached() + lowest_.reached();
    if (range > 0 && std::isfinite(range)) {
      highest_.allow(close_position * range);
      lowest_.allow(close_position * range);
    }
  }

  /// Writes its bounds to lane k of its group.
  void write_to(GroupBounds& group, std::size_t k) const {
    set_lane(group.highest, k, highest_.bound());
    set_lane(group.lowest, k, lowest_.bound());
    for (std::size_t q = 0; q < peaks_.size(); ++q) set_lane(group.peaks[q], k, peaks_[q].bound());
  }
  void take(const PiecePart& part) {
    const TrajectoryPiece& piece = *part.piece;
    const double begin = trajectory_->values()[piece.begin_row + axis_];
    Bernstein polynomial = position_of(*trajectory_, piece, axis_);
    take_position(part.of(polynomial).shifted(begin), piece);
    for (Search& peak : peaks_) {
      polynomial = polynomial.derivative(piece.seconds);
      const Bernstein derivative = part.of(polynomial);
      peak.take(derivative, piece);
      peak.take(derivative.negated(), piece);
    }
  }
  [[nodiscard]] AxisPeaks peaks() const {
    return {.lowest = {-lowest_.bound(), lowest_.frame()},
            .highest = {highest_.bound(), highest_.frame()},
            .velocity = {peaks_[0].bound(), peaks_[0].frame()},
            .acceleration = {peaks_[1].bound(), peaks_[1].frame()},
            .jerk = {peaks_[2].bound(), peaks_[2].frame()}};
  }

 private:
  void take_position(const Bernstein& position, const TrajectoryPiece& piece) {
    if (trajectory_->keeps_to_joints()) {  // what the ends of the piece are not, no moment of it is
      Bernstein ends;
      ends.degree = 1;
      ends.c = {position.c[0], position.c[position.degree]};
      ends.begin = position.begin;
      ends.end = position.end;
      highest_.take(ends, piece);
      return lowest_.take(ends.negated(), piece);
    }
    highest_.take(position, piece);
    lowest_.take(position.negated(), piece);
  }

  const Trajectory* trajectory_ = nullptr;
  std::size_t axis_ = 0;
  Search highest_{0, 0}, lowest_{0, 0};
  std::array<Search, 3> peaks_{Search(close_share, 0), Search(close_share, 0), Search(close_share, 0)};
};

/// The bounds of a group of axes, or of what is left of one. Nearly everything is within what is proven
/// already, which is seen in lanes.
class BoundedGroup {
 public:
  BoundedGroup(const Trajectory& trajectory, std::size_t first, std::size_t count)
      : trajectory_(trajectory), first_(first), count_(count) {
    for (std::size_t k = 0; k < count_; ++k) bounds_[k] = AxisBounds(trajectory, first + k);
    write_lanes();
  }

  /// The rows at both ends of a part say what is reached. What is not beyond that needs no search.
  void reach_rows(const PiecePart& part) {
    const TrajectoryPiece& piece = *part.piece;
    if (part.begin == 0) reach_row(piece.begin_row, piece, 0);
    if (part.end == 1) reach_row(piece.end_row, piece, 1);
  }
  void begin_search() {
    for (std::size_t k = 0; k < count_; ++k) bounds_[k].begin_search();
    write_lanes();
  }
  void take(const PiecePart& part) {
    const TrajectoryPiece& piece = *part.piece;
    Group beyond(0);
    with_degree(piece.degree, [&](auto degree) {
      find_beyond<degree>(rows_of(piece, trajectory_.values(), trajectory_.axis_count()), piece.seconds,
                          first_, lanes_, beyond);
    });
    for (std::size_t k = 0; k < count_; ++k) {
      if (!(lane_of(beyond, k) > 0)) continue;
      bounds_[k].take(part);
      bounds_[k].write_to(lanes_, k);
    }
  }
  [[nodiscard]] AxisPeaks peaks(std::size_t k) const { return bounds_[k].peaks(); }

 private:
  void write_lanes() {
    for (std::size_t k = 0; k < count_; ++k) bounds_[k].write_to(lanes_, k);
  }
  void reach_row(std::uint32_t offset, const TrajectoryPiece& piece, double u) {
    const double* row = &trajectory_.values()[offset];
    Group beyond(0);
    find_beyond(row, trajectory_.axis_count(), first_, known_of(piece.degree), lanes_, beyond);
    for (std::size_t k = 0; k < count_; ++k) {
      if (!(lane_of(beyond, k) > 0)) continue;
      bounds_[k].reach_row(row, piece, u);
      bounds_[k].write_to(lanes_, k);
    }
  }

  const Trajectory& trajectory_;
  std::size_t first_, count_;
  std::array<AxisBounds, group_size> bounds_;
  GroupBounds lanes_{};
};

void bound_group(const Trajectory& trajectory, const FrameTime& from, const FrameTime& to, std::size_t first,
                 std::span<AxisPeaks> out) {
  BoundedGroup group(trajectory, first, out.size());
  for_each_part(trajectory, from, to, [&](const PiecePart& part) { group.reach_rows(part); });
  group.begin_search();
  for_each_part(trajectory, from, to, [&](const PiecePart& part) { group.take(part); });
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = group.peaks(k);
}

}  // namespace

void bound_trajectory(const Trajectory& trajectory, const FrameTime& from, const FrameTime& to,
                      std::span<AxisPeaks> out) {
  for (std::size_t d = 0; d < trajectory.axis_count(); d += group_size)
    bound_group(trajectory, from, to, d, out.subspan(d, std::min(group_size, trajectory.axis_count() - d)));
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const UnboundedSide& side : trajectory.unbounded()) {
    if (side.time < from || to < side.time) continue;
    AxisPeaks& peaks = out[static_cast<std::size_t>(side.axis)];
    const double frame = frame_of(side.time);
    if (side.order <= 1) peaks.velocity.raise(infinity, frame);
    if (side.order <= 2) peaks.acceleration.raise(infinity, frame);
    peaks.jerk.raise(infinity, frame);
  }
}

void bound_trajectory(const Trajectory& trajectory, std::span<AxisPeaks> out) {
  bound_trajectory(trajectory, trajectory.begin(), trajectory.end(), out);
}

void steps_at(const Trajectory& trajectory, const TrajectoryBreak& at, std::span<TrajectoryStep> out) {
  const TrajectoryPiece& before = trajectory.pieces()[at.piece - 1];
  const TrajectoryPiece& behind = trajectory.pieces()[at.piece];
  const auto step = [&](std::size_t axis, std::size_t derivative) {
    for (const TrajectoryPiece* piece : {&before, &behind}) {
      if (!piece->is_exact && derivative >= known_of(piece->degree)) return 0.0;  // it is not known there
    }
    return at_end_of_piece(trajectory, behind, axis, derivative, false) -
           at_end_of_piece(trajectory, before, axis, derivative, true);
  };
  for (std::size_t d = 0; d < trajectory.axis_count(); ++d) out[d] = {step(d, 1), step(d, 2)};
}

}  // namespace inbetween
