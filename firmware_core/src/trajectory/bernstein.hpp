#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "base/lanes.hpp"
#include "inbetween/base/processor_clones.hpp"
#include "trajectory/hermite.hpp"

/// Pieces of a trajectory in Bernstein's basis, in which a polynomial lies in the hull of its coefficients:
/// one axis after the other, or axes side by side.

namespace inbetween {

/// A hull shrinks to a quarter of what it is too wide with every halving.
inline constexpr int max_depth = 30;

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
  [[nodiscard]] Bernstein shifted(double by) const {
    Bernstein result = *this;
    for (std::size_t i = 0; i <= degree; ++i) result.c[i] += by;
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
inline Bernstein between_rows(const Trajectory& trajectory, const TrajectoryPiece& piece, std::size_t axis,
                              std::size_t first, std::size_t degree) {
  const std::size_t axes = trajectory.axis_count();
  const double* begin = &trajectory.values()[piece.begin_row + first * axes];
  const double* end = &trajectory.values()[piece.end_row + first * axes];
  Bernstein result;
  result.degree = degree;
  const double distance = end[axis] - begin[axis];
  for (std::size_t i = 0; i < known_of(degree); ++i) {
    // b_i = sum over j of binomial(i, j) (n - j)! / n! h^j f^(j), from either end.
    double left = 0;
    double right = distance;
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
inline Bernstein position_of(const Trajectory& trajectory, const TrajectoryPiece& piece, std::size_t axis) {
  if (piece.degree != 6) return between_rows(trajectory, piece, axis, 0, piece.degree);
  const Bernstein velocity = between_rows(trajectory, piece, axis, 1, 5);
  const double begin = trajectory.values()[piece.begin_row + trajectory.axis_count() + axis];
  Bernstein position;
  position.degree = 6;
  for (std::size_t i = 0; i < 6; ++i)
    position.c[i + 1] = position.c[i] + piece.seconds / 6 * (begin + velocity.c[i]);
  return position;
}

/// Calls visit(k, c, n) with the coefficients, 0 to n, of the position of a group of axes less that at the
/// begin, and of its three derivatives. They are those of position_of() and of Bernstein::derivative(), to
/// the last bit, so that an axis whose hull is within its bounds here has nothing to be searched for.
template <std::size_t Degree, class Visit>
INBETWEEN_PART_OF_CLONES void visit_derivatives(const PieceRows& rows, double seconds, std::size_t axis,
                                                const Visit& visit) {
  using Number = Group;
  constexpr std::size_t first = Degree == 6 ? 1 : 0;
  constexpr std::size_t degree = Degree - first;
  std::array<Number, 4> begin, end;
  for (std::size_t j = first; j < known_of(Degree); ++j) {
    begin[j - first] = group_of<Number>(rows.begin + j * rows.axes, rows.axes, axis);
    end[j - first] = group_of<Number>(rows.end + j * rows.axes, rows.axes, axis);
  }
  std::array<Number, 8> c;
  const Number distance = end[0] - begin[0];
  for (std::size_t i = 0; i < known_of(degree); ++i) {
    Number left(0);
    Number right = distance;
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

inline double frame_of(const FrameTime& time) {
  return static_cast<double>(time.frame) + time.fraction;
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
void for_each_part(const Trajectory& trajectory, const FrameTime& from, const FrameTime& to,
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

}  // namespace inbetween
