#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "inbetween/trajectory/bounds.hpp"
#include "trajectory/bernstein.hpp"

namespace inbetween {
namespace {

/// What is found in a cell is close enough within this share: a rate change that is 2 % lower makes a stop
/// that much longer.
constexpr double close_in_cell = 0.02;

/// The velocity, the acceleration and the jerk of some axes on what is left of a piece.
struct GroupDerivatives {
  std::array<std::array<Group, 8>, 3> c;
  std::array<std::size_t, 3> degree{};
};
/// A bound of the magnitude of each.
using GroupMagnitudes = std::array<Group, 3>;

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
inline void raise_in_lanes(const Group& most, const Group& found, const Group& room, Group& one, Group& other,
                           Group& far) {
  using Number = Group;
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
  using Number = Group;
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
INBETWEEN_PART_OF_CLONES void cut_share(GroupDerivatives& rest, double share, std::size_t k, Group& most,
                                        Group& found) {
  std::array<Group, 8>& c = rest.c[k];
  const Group begin = absolute(c[0]);
  most = begin;
  for (std::size_t round = 1; round <= rest.degree[k]; ++round) {
    for (std::size_t i = 0; i + round <= rest.degree[k]; ++i) c[i] = (1 - share) * c[i] + share * c[i + 1];
    most = greatest(most, absolute(c[0]));
  }
  found = greatest(begin, absolute(c[0]));
}
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void drop_share(GroupDerivatives& rest, double share) {
  Group most(0), found(0);
  for (std::size_t k = 0; k < rest.c.size(); ++k) cut_share(rest, share, k, most, found);
}
/// Raises a cell by what is cut off.
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void raise_by_share(GroupDerivatives& rest, double share,
                                                                const GroupMagnitudes& room,
                                                                GroupMagnitudes& cell, GroupMagnitudes& far) {
  for (std::size_t k = 0; k < rest.c.size(); ++k) {
    Group most(0), found(0);
    cut_share(rest, share, k, most, found);
    raise_in_lanes(most, found, room[k], cell[k], cell[k], far[k]);
  }
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

  void run(const FrameTime& from, const FrameTime& to, std::size_t first, std::size_t count) {
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
  void raise(const FrameTime& time, std::size_t axis, std::size_t derivative) {
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
    const Group any = far[0] + far[1] + far[2];
    for (std::size_t k = 0; k < count_; ++k) {
      if (!(lane_of(any, k) > 0)) continue;
      for (std::size_t q = 0; q < 3; ++q) {
        if (!(lane_of(far[q], k) > 0)) continue;
        for (std::size_t cell = first_cell; cell <= last_cell; ++cell) {
          Group& lanes = lanes_[cell - open_][q];
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

void bound_cells(const Trajectory& trajectory, const FrameTime& from, const FrameTime& to,
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

}  // namespace inbetween
