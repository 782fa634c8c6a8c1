#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/timing/frame_time.hpp"
#include "inbetween/timing/track.hpp"

/// A motion as polynomials in time: for each axis a row of pieces that share their ends.

namespace inbetween {

/// One stretch of time of all axes: the polynomial that has the values of two rows at its ends (Hermite).
/// With u = (time - begin) / length, u = 1 belongs to the next piece, so that every joint is exact.
struct TrajectoryPiece {
  FrameTime begin;
  double inverse_frames = 0;    ///< 1 / length in frames
  double seconds = 0;           ///< length
  std::uint32_t begin_row = 0;  ///< where its values begin in Trajectory::values()
  std::uint32_t end_row = 0;
  /// 1, 3, 5 or 7: of each row its first (degree + 1) / 2 numbers an axis count. 6, for a very short piece:
  /// its velocity has those of both ends with their first two derivatives, and the position at its begin is
  /// added.
  std::uint8_t degree = 7;
  bool is_exact = false;  ///< it is what was asked, also in the derivatives that its rows do not have
};

/// A joint at which derivatives may step.
struct TrajectoryBreak {
  FrameTime time;
  std::uint32_t piece = 0;  ///< the one that begins there
  std::int32_t key = -1;    ///< that is passed there; -1 where none is
};

/// A derivative of the asked motion without a bound, which no polynomial has.
struct UnboundedSide {
  FrameTime time;
  std::int32_t axis = 0;
  std::int32_t key = -1;   ///< that is passed there; -1 between keys
  std::uint8_t order = 2;  ///< this derivative and those above: 1 velocity, 2 acceleration
};

/// A fit works in so many numbers for each axis: ten rows of four, and six that it knows of the axis.
inline constexpr std::size_t fit_numbers = 46;

/// The memory of a trajectory, owned by the caller. Sizes: see fit_trajectory.
struct TrajectoryMemory {
  std::span<TrajectoryPiece> pieces;
  std::span<double> values;
  std::span<std::uint32_t> buckets;  ///< any number >= 1; about as many as pieces make looking up quick, and
                                     ///< twice as many are used
  std::span<TrajectoryBreak> breaks;
  std::span<UnboundedSide> unbounded;
  std::span<AxisMotion> samples;  ///< 3 for each axis, while it is made
  std::span<double> numbers;      ///< fit_numbers for each axis, while it is made
};

/// A trajectory whose pieces are known.
struct TrajectoryContents {
  std::size_t axis_count = 0;
  FrameRate fps;
  FrameTime end;
  std::span<const TrajectoryPiece> pieces;  ///< at least one, in their order
  std::span<const double> values;
  std::span<const TrajectoryBreak> breaks = {};
  std::span<const UnboundedSide> unbounded = {};
  /// On a piece every axis stays between its positions at both ends, however its polynomial is rounded.
  bool keeps_to_joints = false;
  double loosened = 1;  ///< Trajectory::loosened
};

/// What plays. A small value that refers to the caller's memory.
///
/// A row holds, for all axes, positions, then velocities, accelerations and jerks, in axis units and seconds.
/// Before its begin the first position and from its end on the last one, at rest.
class Trajectory {
 public:
  /// This makes a trajectory of pieces that are known. `buckets`: see TrajectoryMemory. Errors: wrong_count
  /// (no axis, piece or bucket), out_of_range (pieces that do not follow each other, rows outside the values,
  /// a degree that is not 1, 3, 5, 6 or 7). O(pieces + buckets).
  static Result<Trajectory> make(const TrajectoryContents& contents, std::span<std::uint32_t> buckets);

  [[nodiscard]] std::size_t axis_count() const { return axis_count_; }
  /// All that it refers to: of a part those of the whole.
  [[nodiscard]] std::span<const TrajectoryPiece> pieces() const { return pieces_; }
  [[nodiscard]] std::span<const double> values() const { return values_; }
  [[nodiscard]] std::span<const TrajectoryBreak> breaks() const { return breaks_; }
  [[nodiscard]] std::span<const UnboundedSide> unbounded() const { return unbounded_; }
  [[nodiscard]] const FrameTime& begin() const { return begin_; }
  [[nodiscard]] const FrameTime& end() const { return end_; }
  [[nodiscard]] FrameRate frame_rate() const { return fps_; }
  [[nodiscard]] bool keeps_to_joints() const { return keeps_to_joints_; }
  /// How many times the tolerances of the fit what plays may be from what was asked: 1, but where the samples
  /// were rounded so much that no piece came nearer.
  [[nodiscard]] double loosened() const { return loosened_; }
  [[nodiscard]] FrameTime end_of(std::size_t piece) const {
    return piece + 1 < pieces_.size() ? pieces_[piece + 1].begin : end_of_pieces_;
  }

  /// The same motion on some of its frames alone, to the last bit; outside them it rests.
  /// Domain: begin() <= first < last <= end().
  [[nodiscard]] Trajectory part(const FrameTime& first, const FrameTime& last) const;

  /// The position of every axis: the tick. `out` has axis_count() entries. O(axes), no allocation, the same
  /// bits on every target.
  void positions(const FrameTime& time, std::span<double> out) const;
  /// Position and three derivatives of every axis. On a joint those with which the motion leaves it; at the
  /// end those with which it arrives. O(axes).
  void motion(const FrameTime& time, std::span<AxisMotion> out) const;
  /// The same of one axis, to the last bit. O(1).
  [[nodiscard]] AxisMotion motion_of(std::size_t axis, const FrameTime& time) const;
  /// The piece that a time from begin() to before end() lies in.
  [[nodiscard]] std::size_t piece_at(const FrameTime& time) const;

 private:
  Trajectory() = default;
  struct Look {
    const TrajectoryPiece* piece;
    double u;
    bool is_at_end;   ///< of the piece
    bool is_outside;  ///< before the begin or behind the end
  };
  [[nodiscard]] Look look_at(const FrameTime& time) const;
  [[nodiscard]] AxisMotion settled(AxisMotion motion, const Look& look, std::size_t axis) const;

  std::span<const TrajectoryPiece> pieces_;
  std::span<const double> values_;
  std::span<const std::uint32_t> buckets_;
  std::span<const TrajectoryBreak> breaks_;
  std::span<const UnboundedSide> unbounded_;
  std::size_t axis_count_ = 0;
  FrameTime begin_, end_;
  FrameTime end_of_pieces_;
  FrameRate fps_;
  double buckets_per_frame_ = 0;
  bool keeps_to_joints_ = false;
  double loosened_ = 1;
};

/// The value of an axis' derivative 0..3 at the begin or the end of a piece, one-sided. O(1).
double at_end_of_piece(const Trajectory& trajectory, const TrajectoryPiece& piece, std::size_t axis,
                       std::size_t derivative, bool is_end);

/// c[0] + c[1] u + ... + c[7] u^7.
using PiecePolynomial = std::array<double, 8>;
/// The distance of an axis since the begin of a piece, as a polynomial in the u of the piece: c[0] is 0.
/// Powers above the degree of the piece are 0. O(1).
PiecePolynomial distance_on_piece(const Trajectory& trajectory, const TrajectoryPiece& piece,
                                  std::size_t axis);
/// The same polynomial between two places of its u, in a parameter that goes from 0 to 1 between them. O(1).
PiecePolynomial part_of(const PiecePolynomial& whole, double from, double to);

}  // namespace inbetween
