#include "inbetween/trajectory/bounds.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "base/lanes.hpp"
#include "inbetween/base/processor_clones.hpp"
#include "trajectory/hermite.hpp"

namespace inbetween {
namespace {

constexpr double close_share = 1e-5;
constexpr double close_position = 1e-9;
/// The same of what is found in a cell: a rate change that is 2 % lower makes a stop that much longer.
constexpr double close_in_cell = 0.02;
/// A hull shrinks to a quarter of what it is too wide with every halving.
constexpr int max_depth = 30;

/// Bernstein coefficients over a stretch of u.
struct Bernstein {
  std::array<double, 8> c{};
  std::size_t degree = 0;
  double begin = 0, end = 1;

  [[nodiscard]] double highest() const {
    double most = c[0];
    for (std::size_t i = 1; i <= degree; ++i) most = std::max(most, c[i]);
    return most;
  }
  [[nodiscard]] Bernstein derivative(double seconds) const {
    Bernstein result;
    result.degree = degree == 0 ? 0 : degree - 1;
    const double factor = static_cast<double>(degree) / seconds;
    for (std::size_t i = 0; i < degree; ++i) result.c[i] = factor * (c[i + 1] - c[i]);
    return result;
  }
  [[nodiscard]] Bernstein negated() const {
    Bernstein result = *this;
    for (double& one : result.c) one = -one;
    return result;
  }
  /// This becomes what lies between two places of it (de Casteljau at either).
  void cut(double from, double to) {
    for (std::size_t round = 1; round <= degree; ++round) {
      for (std::size_t i = degree; i >= round; --i) c[i] = (1 - to) * c[i - 1] + to * c[i];
    }
    const double share = from / to;
    for (std::size_t round = 1; round <= degree; ++round) {
      for (std::size_t i = 0; i + round <= degree; ++i) c[i] = (1 - share) * c[i] + share * c[i + 1];
    }
    begin = from;
    end = to;
  }
  /// This becomes the first half, and the second is returned.
  Bernstein halve() {
    Bernstein second = *this;
    for (std::size_t round = 1; round <= degree; ++round) {
      for (std::size_t i = degree; i >= round; --i) c[i] = (c[i - 1] + c[i]) / 2;
      second.c[degree - round] = c[degree];
    }
    // What is left in c[i] is the i-th coefficient of the first half.
    second.begin = end = begin + (end - begin) / 2;
    return second;
  }
};

/// The polynomial with the numbers of two rows from number `first` on: its values, and as many derivatives as
/// its degree takes, less the value at its begin.
Bernstein between_rows(const Trajectory& trajectory, const TrajectoryPiece& piece, std::size_t axis,
                       std::size_t first, std::size_t degree) {
  const std::size_t axes = trajectory.axis_count();
  const double* begin = &trajectory.values()[piece.begin_row + first * axes];
  const double* end = &trajectory.values()[piece.end_row + first * axes];
  Bernstein result;
  result.degree = degree;
  const double way = end[axis] - begin[axis];
  for (std::size_t i = 0; i < known_of(degree); ++i) {
    // b_i = sum over j of binomial(i, j) (n - j)! / n! h^j f^(j), from either end.
    double left = 0;
    double right = way;
    double factor = 1;  // binomial(i, j) (n - j)! / n! h^j
    for (std::size_t j = 1; j <= i; ++j) {
      factor *= static_cast<double>(i - j + 1) / static_cast<double>(j) * piece.seconds /
                static_cast<double>(degree + 1 - j);
      left += factor * begin[j * axes + axis];
      right += (j % 2 == 1 ? -factor : factor) * end[j * axes + axis];
    }
    result.c[i] = left;
    result.c[degree - i] = right;
  }
  return result;
}

/// The position of an axis on a piece less the one at its begin.
Bernstein position_of(const Trajectory& trajectory, const TrajectoryPiece& piece, std::size_t axis) {
  if (piece.degree != 6) return between_rows(trajectory, piece, axis, 0, piece.degree);
  const Bernstein velocity = between_rows(trajectory, piece, axis, 1, 5);
  const double begin = trajectory.values()[piece.begin_row + trajectory.axis_count() + axis];
  Bernstein position;
  position.degree = 6;
  for (std::size_t i = 0; i < 6; ++i)
    position.c[i + 1] = position.c[i] + piece.seconds / 6 * (begin + velocity.c[i]);
  return position;
}

/// What is proven of some axes: how high and how low they go (its opposite), and three derivatives.
struct GroupBounds {
  Group<double> highest, lowest;
  std::array<Group<double>, 3> peaks;
};

/// The velocity, the acceleration and the jerk of some axes on what is left of a piece.
struct GroupDerivatives {
  std::array<std::array<Group<double>, 8>, 3> c;
  std::array<std::size_t, 3> degree{};
};
/// A bound of the magnitude of each.
using GroupMagnitudes = std::array<Group<double>, 3>;

/// Calls visit(k, c, n) with the coefficients, 0 to n, of the position of a group of axes less that at the
/// begin, and of its three derivatives. They are those of position_of() and of Bernstein::derivative(), to
/// the last bit, so that an axis whose hull is within its bounds here has nothing to be searched for.
template <std::size_t Degree, class Visit>
INBETWEEN_PART_OF_CLONES void visit_derivatives(const PieceRows& rows, double seconds, std::size_t axis,
                                                const Visit& visit) {
  using Number = Group<double>;
  constexpr std::size_t first = Degree == 6 ? 1 : 0;
  constexpr std::size_t degree = Degree - first;
  std::array<Number, 4> begin, end;
  for (std::size_t j = first; j < known_of(Degree); ++j) {
    begin[j - first] = group_of<Number>(rows.begin + j * rows.axes, rows.axes, axis);
    end[j - first] = group_of<Number>(rows.end + j * rows.axes, rows.axes, axis);
  }
  std::array<Number, 8> c;
  const Number way = end[0] - begin[0];
  for (std::size_t i = 0; i < known_of(degree); ++i) {
    Number left(0);
    Number right = way;
    double factor = 1;
    for (std::size_t j = 1; j <= i; ++j) {
      factor *= static_cast<double>(i - j + 1) / static_cast<double>(j) * seconds /
                static_cast<double>(degree + 1 - j);
      left = left + factor * begin[j];
      right = right + (j % 2 == 1 ? -factor : factor) * end[j];
    }
    c[i] = left;
    c[degree - i] = right;
  }
  if constexpr (Degree == 6) {
    std::array<Number, 8> position;
    position[0] = Number(0);
    for (std::size_t i = 0; i < 6; ++i) position[i + 1] = position[i] + seconds / 6 * (begin[0] + c[i]);
    c = position;
  }
  std::size_t n = Degree;
  visit(0, c, n);
  for (std::size_t k = 1; k <= 3; ++k) {
    const double factor = static_cast<double>(n) / seconds;
    for (std::size_t i = 0; i < n; ++i) c[i] = factor * (c[i + 1] - c[i]);
    if (n == 0) c[0] = Number(0);
    n -= n > 0 ? 1 : 0;
    visit(k, c, n);
  }
}

/// 1 in the lanes whose hulls on a piece are beyond what is proven, and 0 in the others.
template <std::size_t Degree>
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void find_beyond(const PieceRows& rows, double seconds,
                                                             std::size_t axis, const GroupBounds& bounds,
                                                             Group<double>& out) {
  using Number = Group<double>;
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
                                                             const GroupBounds& bounds, Group<double>& out) {
  using Number = Group<double>;
  const Number yes(1);
  const Number position = group_of<Number>(row, axes, axis);
  Number beyond = if_less(bounds.highest, position, yes, Number(0));
  beyond = if_less(bounds.lowest, -1 * position, yes, beyond);
  for (std::size_t k = 1; k < known; ++k)
    beyond =
        if_less(bounds.peaks[k - 1], absolute(group_of<Number>(row + k * axes, axes, axis)), yes, beyond);
  out = beyond;
}

template <std::size_t Degree>
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void write_derivatives(const PieceRows& rows, double seconds,
                                                                   std::size_t axis, GroupDerivatives& out) {
  visit_derivatives<Degree>(rows, seconds, axis, [&](std::size_t k, const auto& c, std::size_t n) {
    if (k == 0) return;
    out.c[k - 1] = c;
    out.degree[k - 1] = n;
  });
}

/// Raises the suprema of two cells (or of one, twice) by what `most` may be, where that is near enough to
/// what is `found`. The other lanes get a 1 in `far`.
inline void raise_in_lanes(const Group<double>& most, const Group<double>& found, const Group<double>& room,
                           Group<double>& one, Group<double>& other, Group<double>& far) {
  using Number = Group<double>;
  const Number zero(0);
  const Number enough = found + greatest(close_in_cell * found, room);
  const Number is_more = if_less(least(one, other), most, Number(1), zero);
  far = if_less(enough, most, is_more, zero);
  one = if_less(zero, far, one, greatest(one, most));
  other = if_less(zero, far, other, greatest(other, most));
}

/// Raises them by a whole piece.
template <std::size_t Degree>
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void raise_by_piece(const PieceRows& rows, double seconds,
                                                                std::size_t axis, const GroupMagnitudes& room,
                                                                GroupMagnitudes& one, GroupMagnitudes& other,
                                                                GroupMagnitudes& far) {
  using Number = Group<double>;
  visit_derivatives<Degree>(rows, seconds, axis, [&](std::size_t k, const auto& c, std::size_t n) {
    if (k == 0) return;
    Number most = absolute(c[0]);
    for (std::size_t i = 1; i <= n; ++i) most = greatest(most, absolute(c[i]));
    Number found(0);  // where the rows do not say it
    if (k < known_of(Degree)) {
      found = greatest(absolute(group_of<Number>(rows.begin + k * rows.axes, rows.axes, axis)),
                       absolute(group_of<Number>(rows.end + k * rows.axes, rows.axes, axis)));
    }
    raise_in_lanes(most, found, room[k - 1], one[k - 1], other[k - 1], far[k - 1]);
  });
}

/// Cuts a share off the begin of what is left (de Casteljau). `most` is its hull, `found` what it has at its
/// ends: what is left begins where it has ended.
INBETWEEN_PART_OF_CLONES void cut_share(GroupDerivatives& rest, double share, std::size_t k,
                                        Group<double>& most, Group<double>& found) {
  std::array<Group<double>, 8>& c = rest.c[k];
  const Group<double> begin = absolute(c[0]);
  most = begin;
  for (std::size_t round = 1; round <= rest.degree[k]; ++round) {
    for (std::size_t i = 0; i + round <= rest.degree[k]; ++i) c[i] = (1 - share) * c[i] + share * c[i + 1];
    most = greatest(most, absolute(c[0]));
  }
  found = greatest(begin, absolute(c[0]));
}
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void drop_share(GroupDerivatives& rest, double share) {
  Group<double> most(0), found(0);
  for (std::size_t k = 0; k < rest.c.size(); ++k) cut_share(rest, share, k, most, found);
}
/// Raises a cell by what is cut off.
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void raise_by_share(GroupDerivatives& rest, double share,
                                                                const GroupMagnitudes& room,
                                                                GroupMagnitudes& cell, GroupMagnitudes& far) {
  for (std::size_t k = 0; k < rest.c.size(); ++k) {
    Group<double> most(0), found(0);
    cut_share(rest, share, k, most, found);
    raise_in_lanes(most, found, room[k], cell[k], cell[k], far[k]);
  }
}

double frame_of(const FrameTime<double>& time) {
  return static_cast<double>(time.frame) + time.fraction;
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

Bernstein shifted(Bernstein polynomial, double by) {
  for (std::size_t i = 0; i <= polynomial.degree; ++i) polynomial.c[i] += by;
  return polynomial;
}

/// This is what lies of a piece between two times.
struct PiecePart {
  const TrajectoryPiece* piece;
  double begin = 0, end = 1;  ///< u

  /// Of a derivative of the whole piece: one of the part would be a difference of nearly equal numbers where
  /// it is short.
  [[nodiscard]] Bernstein of(Bernstein whole) const {
    if (begin > 0 || end < 1) whole.cut(begin, end);
    return whole;
  }
};

/// Calls `work` with every piece, or part of one, from one time to another.
template <class Work>
void for_each_part(const Trajectory& trajectory, const FrameTime<double>& from, const FrameTime<double>& to,
                   const Work& work) {
  const std::span<const TrajectoryPiece> pieces = trajectory.pieces();
  for (std::size_t i = from < trajectory.end_of(pieces.size() - 1) ? trajectory.piece_at(from)
                                                                   : pieces.size();
       i < pieces.size() && pieces[i].begin < to; ++i) {
    PiecePart part{&pieces[i]};
    if (pieces[i].begin < from) part.begin = frames_between(pieces[i].begin, from) * pieces[i].inverse_frames;
    if (to < trajectory.end_of(i)) part.end = frames_between(pieces[i].begin, to) * pieces[i].inverse_frames;
    work(part);
  }
}

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

  /// As lane k of the bounds of its group.
  void write_to(GroupBounds& group, std::size_t k) const {
    set_lane(group.highest, k, highest_.bound());
    set_lane(group.lowest, k, lowest_.bound());
    for (std::size_t q = 0; q < peaks_.size(); ++q) set_lane(group.peaks[q], k, peaks_[q].bound());
  }
  void take(const PiecePart& part) {
    const TrajectoryPiece& piece = *part.piece;
    const double begin = trajectory_->values()[piece.begin_row + axis_];
    Bernstein polynomial = position_of(*trajectory_, piece, axis_);
    take_position(shifted(part.of(polynomial), begin), piece);
    for (Search& peak : peaks_) {
      polynomial = polynomial.derivative(piece.seconds);
      const Bernstein derivative = part.of(polynomial);
      peak.take(derivative, piece);
      peak.take(derivative.negated(), piece);
    }
  }
  [[nodiscard]] AxisPeaks<double> peaks() const {
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
    Group<double> beyond(0);
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
  [[nodiscard]] AxisPeaks<double> peaks(std::size_t k) const { return bounds_[k].peaks(); }

 private:
  void write_lanes() {
    for (std::size_t k = 0; k < count_; ++k) bounds_[k].write_to(lanes_, k);
  }
  void reach_row(std::uint32_t offset, const TrajectoryPiece& piece, double u) {
    const double* row = &trajectory_.values()[offset];
    Group<double> beyond(0);
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

void bound_group(const Trajectory& trajectory, const FrameTime<double>& from, const FrameTime<double>& to,
                 std::size_t first, std::span<AxisPeaks<double>> out) {
  BoundedGroup group(trajectory, first, out.size());
  for_each_part(trajectory, from, to, [&](const PiecePart& part) { group.reach_rows(part); });
  group.begin_search();
  for_each_part(trajectory, from, to, [&](const PiecePart& part) { group.take(part); });
  for (std::size_t k = 0; k < out.size(); ++k) out[k] = group.peaks(k);
}

/// This raises the suprema of a group of axes in cells.
class GroupCells {
 public:
  GroupCells(const Trajectory& trajectory, const CellLine& line, std::span<const MotionTriple> room,
             std::span<MotionTriple> out, std::size_t stride)
      : trajectory_(trajectory),
        line_(line),
        cell_frames_(static_cast<double>(line.last_frame - line.first_frame) /
                     static_cast<double>(line.cells)),
        room_(room),
        out_(out),
        stride_(stride) {}

  void run(const FrameTime<double>& from, const FrameTime<double>& to, std::size_t first, std::size_t count) {
    first_ = first;
    count_ = count;
    for (std::size_t k = 0; k < count; ++k) {
      for (std::size_t q = 0; q < 3; ++q) set_lane(room_lanes_[q], k, room_[first + k][q]);
    }
    open_ = cell_at(frame_of(from));
    lanes_ = {};
    for_each_part(trajectory_, from, to, [&](const PiecePart& part) {
      const Cells cells = cells_of(part);
      const bool is_whole = part.begin == 0 && part.end == 1;
      with_degree(part.piece->degree, [&](auto degree) {
        if (is_whole && cells.last - cells.first <= 1) {
          take_whole<degree>(part, cells);
        } else {
          take_cell_by_cell<degree>(part, cells);
        }
      });
    });
    close(0);
    close(1);
  }
  void raise(const FrameTime<double>& time, std::size_t axis, std::size_t derivative) {
    const std::size_t cell = cell_at(frame_of(time));
    for (std::size_t q = derivative; q < 3; ++q) at(cell, axis, q) = std::numeric_limits<double>::infinity();
  }

 private:
  struct Cells {
    std::size_t first = 0, last = 0;
  };
  [[nodiscard]] PieceRows rows(const TrajectoryPiece& piece) const {
    return rows_of(piece, trajectory_.values(), trajectory_.axis_count());
  }
  double& at(std::size_t cell, std::size_t axis, std::size_t q) { return out_[cell * stride_ + axis][q]; }
  [[nodiscard]] std::size_t cell_at(double frame) const {
    const double cell = (frame - line_.first_frame) / cell_frames_;
    return cell > 0 ? std::min(static_cast<std::size_t>(cell), line_.cells - 1) : 0;
  }
  [[nodiscard]] Cells cells_of(const PiecePart& part) const {
    const double begin = frame_of(part.piece->begin);
    return {cell_at(begin + part.begin / part.piece->inverse_frames),
            cell_at(begin + part.end / part.piece->inverse_frames)};
  }
  [[nodiscard]] double border(const PiecePart& part, std::size_t cell) const {
    const double frame = line_.first_frame + cell_frames_ * static_cast<double>(cell);
    const double u = (frame - frame_of(part.piece->begin)) * part.piece->inverse_frames;
    return std::clamp(u, part.begin, part.end);
  }

  /// Time goes on: two neighbouring cells are open in lanes, and pieces need no others.
  void open(std::size_t cell) {
    if (cell == open_) return;
    close(0);
    if (cell == open_ + 1) {
      lanes_[0] = lanes_[1];
    } else {
      close(1);
      lanes_[0] = {};
    }
    lanes_[1] = {};
    open_ = cell;
  }
  void close(std::size_t i) {
    if (open_ + i >= line_.cells) return;
    for (std::size_t k = 0; k < count_; ++k) {
      for (std::size_t q = 0; q < 3; ++q) {
        double& supremum = at(open_ + i, first_ + k, q);
        supremum = std::max(supremum, lane_of(lanes_[i][q], k));
      }
    }
  }

  /// A piece of up to two cells counts as a whole in both.
  template <std::size_t Degree>
  void take_whole(const PiecePart& part, const Cells& cells) {
    open(cells.first);
    const TrajectoryPiece& piece = *part.piece;
    GroupMagnitudes far;
    raise_by_piece<Degree>(rows(piece), piece.seconds, first_, room_lanes_, lanes_[0],
                           lanes_[cells.last - cells.first], far);
    search_far(part, cells, cells.first, cells.last, far);
  }
  template <std::size_t Degree>
  void take_cell_by_cell(const PiecePart& part, const Cells& cells) {
    GroupDerivatives rest;
    write_derivatives<Degree>(rows(*part.piece), part.piece->seconds, first_, rest);
    if (part.begin > 0) drop_share(rest, part.begin);
    double begin = part.begin;
    for (std::size_t cell = cells.first; cell <= cells.last; ++cell) {
      const double end = cell < cells.last ? border(part, cell + 1) : part.end;
      if (!(begin < end)) continue;
      open(cell);
      GroupMagnitudes far;
      raise_by_share(rest, (end - begin) / (1 - begin), room_lanes_, lanes_[0], far);
      begin = end;
      search_far(part, cells, cell, cell, far);
    }
  }
  void search_far(const PiecePart& part, const Cells& cells, std::size_t first_cell, std::size_t last_cell,
                  const GroupMagnitudes& far) {
    const Group<double> any = far[0] + far[1] + far[2];
    for (std::size_t k = 0; k < count_; ++k) {
      if (!(lane_of(any, k) > 0)) continue;
      for (std::size_t q = 0; q < 3; ++q) {
        if (!(lane_of(far[q], k) > 0)) continue;
        for (std::size_t cell = first_cell; cell <= last_cell; ++cell) {
          Group<double>& lanes = lanes_[cell - open_][q];
          double supremum = lane_of(lanes, k);
          search_part(part, cells, cell, first_ + k, q, supremum);
          set_lane(lanes, k, supremum);
        }
      }
    }
  }
  void search_part(const PiecePart& whole, const Cells& cells, std::size_t cell, std::size_t axis,
                   std::size_t q, double& supremum) {
    Bernstein polynomial = position_of(trajectory_, *whole.piece, axis);
    for (std::size_t k = 0; k <= q; ++k) polynomial = polynomial.derivative(whole.piece->seconds);
    PiecePart part = whole;
    if (cell > cells.first) part.begin = border(whole, cell);
    if (cell < cells.last) part.end = border(whole, cell + 1);
    if (part.begin < part.end) search(part.of(polynomial), room_[axis][q], supremum);
  }
  static void search(const Bernstein& whole, double room, double& supremum) {
    std::array<Bernstein, max_depth + 1> stack;
    std::size_t count = 0;
    stack[count++] = whole;
    double reached = 0;
    while (count > 0) {
      Bernstein& top = stack[count - 1];
      reached = std::max({reached, std::fabs(top.c[0]), std::fabs(top.c[top.degree])});
      const double highest = std::max(top.highest(), top.negated().highest());
      const double enough = reached + std::max(close_in_cell * reached, room);
      if (highest <= std::max(enough, supremum) || count == stack.size()) {
        supremum = std::max(supremum, highest);
        --count;
        continue;
      }
      const Bernstein second = top.halve();
      stack[count++] = second;
    }
  }

  const Trajectory& trajectory_;
  CellLine line_;
  double cell_frames_;
  std::span<const MotionTriple> room_;
  std::span<MotionTriple> out_;
  std::size_t stride_;
  std::size_t first_ = 0, count_ = 0;  ///< axes
  GroupMagnitudes room_lanes_{};
  std::array<GroupMagnitudes, 2> lanes_{};  ///< of the cell open_ and the next
  std::size_t open_ = 0;
};

}  // namespace

void bound_cells(const Trajectory& trajectory, const FrameTime<double>& from, const FrameTime<double>& to,
                 const CellLine& line, std::span<const MotionTriple> room, std::span<MotionTriple> out,
                 std::size_t stride) {
  GroupCells cells(trajectory, line, room, out, stride);
  const std::size_t axes = trajectory.axis_count();
  for (std::size_t d = 0; d < axes; d += group_size) cells.run(from, to, d, std::min(group_size, axes - d));
  for (const UnboundedSide& side : trajectory.unbounded()) {
    if (side.time < from || to < side.time) continue;
    cells.raise(side.time, static_cast<std::size_t>(side.axis), side.order - std::size_t{1});
  }
}

void bound_trajectory(const Trajectory& trajectory, const FrameTime<double>& from,
                      const FrameTime<double>& to, std::span<AxisPeaks<double>> out) {
  for (std::size_t d = 0; d < trajectory.axis_count(); d += group_size)
    bound_group(trajectory, from, to, d, out.subspan(d, std::min(group_size, trajectory.axis_count() - d)));
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const UnboundedSide& side : trajectory.unbounded()) {
    if (side.time < from || to < side.time) continue;
    AxisPeaks<double>& peaks = out[static_cast<std::size_t>(side.axis)];
    const double frame = frame_of(side.time);
    if (side.order <= 1) peaks.velocity.raise(infinity, frame);
    if (side.order <= 2) peaks.acceleration.raise(infinity, frame);
    peaks.jerk.raise(infinity, frame);
  }
}

void bound_trajectory(const Trajectory& trajectory, std::span<AxisPeaks<double>> out) {
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
