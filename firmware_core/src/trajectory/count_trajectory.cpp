#include "inbetween/trajectory/count_trajectory.hpp"

#include <algorithm>

#include "trajectory/hermite.hpp"

namespace inbetween {
namespace {

/// The terms of a polynomial add up to this at most, in counts: a float knows a 2^24th of it.
constexpr double max_terms = 131072;
/// The two highest powers of a septic are left out where this is the most they would change, in counts.
constexpr double max_dropped = 0.01;
constexpr int max_piece_halvings = 16;
/// Positions are at most this, so that base and offset fit 32 bits together.
constexpr double max_position = 2147483647.0 - max_terms;

/// A part of a piece.
struct Stretch {
  std::size_t piece = 0;
  FrameTime begin;
  double from = 0, to = 1;  ///< in u of the piece
};

FloatFrameTime in_float(const FrameTime& time) {
  const auto fraction = static_cast<float>(time.fraction);
  return fraction < 1 ? FloatFrameTime{time.frame, fraction} : FloatFrameTime{time.frame + 1, 0};
}

double terms_of(const PiecePolynomial& c) {
  double sum = 0;
  for (std::size_t i = 1; i < c.size(); ++i) sum += std::fabs(c[i]);
  return sum;
}

/// Chebyshev's polynomials of degree 7 and 6 on [0, 1], which are nowhere there above 1.
constexpr PiecePolynomial chebyshev_7{-1, 98, -1568, 9408, -26880, 39424, -28672, 8192};
constexpr PiecePolynomial chebyshev_6{1, -72, 840, -3584, 6912, -6144, 2048, 0};

/// The quintic that is nearest to a septic for a tick, which saves a sixth of its instructions; and how far
/// it may be from it (economization; Lanczos, Applied Analysis, 1956, section 7-6).
struct Economized {
  PiecePolynomial c{};
  double dropped = 0;

  explicit Economized(const PiecePolynomial& septic) : c(septic) {
    drop(7, chebyshev_7);
    drop(6, chebyshev_6);
  }

 private:
  void drop(std::size_t degree, const PiecePolynomial& chebyshev) {
    const double share = c[degree] / chebyshev[degree];
    for (std::size_t i = 0; i < degree; ++i) c[i] -= share * chebyshev[i];
    c[degree] = 0;
    dropped += std::fabs(share);
  }
};

Error not_playable(const char* what, std::size_t axis) {
  return {.code = ErrorCode::out_of_range,
          .what = what,
          .remedy = "give fewer counts per unit",
          .axis = static_cast<std::int32_t>(axis)};
}

/// How often a piece is halved until its terms are small in every axis.
Result<int> halvings_of(const Trajectory& trajectory, const TrajectoryPiece& piece,
                        std::span<const double> counts_per_unit) {
  int halvings = 0;
  for (std::size_t axis = 0; axis < trajectory.axis_count(); ++axis) {
    const double scale = std::fabs(counts_per_unit[axis]);
    const double begin = trajectory.values()[piece.begin_row + axis] * scale;
    const PiecePolynomial whole = distance_on_piece(trajectory, piece, axis);
    if (!(std::fabs(begin) + terms_of(whole) * scale <= max_position))
      return not_playable("a position does not fit 32 bits of counts", axis);
    const auto is_small = [&] {
      const int parts = 1 << halvings;
      for (int part = 0; part < parts; ++part) {
        const double from = static_cast<double>(part) / parts;
        const Economized halved(part_of(whole, from, from + 1.0 / parts));
        if (terms_of(halved.c) * scale > max_terms || halved.dropped * scale > max_dropped) return false;
      }
      return true;
    };
    while (!is_small()) {
      if (++halvings > max_piece_halvings) return not_playable("an axis goes too fast in counts", axis);
    }
  }
  return halvings;
}

/// Calls `take` with every stretch from the trajectory's begin to its end.
template <class Take>
Status for_each_stretch(const Trajectory& trajectory, std::span<const double> counts_per_unit,
                        const Take& take) {
  if (counts_per_unit.size() != trajectory.axis_count()) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "counts_per_unit has not one number per axis",
                 .remedy = "give one number per axis"};
  }
  for (std::size_t axis = 0; axis < counts_per_unit.size(); ++axis) {
    if (!std::isfinite(counts_per_unit[axis]) || counts_per_unit[axis] == 0)
      return not_playable("counts_per_unit is 0 or no number", axis);
  }
  const std::size_t first = trajectory.piece_at(trajectory.begin());
  for (std::size_t i = first; i < trajectory.pieces().size(); ++i) {
    const TrajectoryPiece& piece = trajectory.pieces()[i];
    if (trajectory.end() <= piece.begin) break;
    const Result<int> halvings = halvings_of(trajectory, piece, counts_per_unit);
    if (!halvings) return halvings.error();
    const bool is_whole = trajectory.begin() <= piece.begin && trajectory.end_of(i) <= trajectory.end();
    const auto u_of = [&](const FrameTime& time) {
      return frames_between(piece.begin, time) * piece.inverse_frames;
    };
    const double begin = is_whole ? 0 : std::max(0.0, u_of(trajectory.begin()));
    const double end = is_whole ? 1 : std::min(1.0, u_of(trajectory.end()));
    const int parts = 1 << *halvings;
    for (int part = 0; part < parts; ++part) {
      const double from = begin + (end - begin) * part / parts;
      const double to = begin + (end - begin) * (part + 1) / parts;
      const FrameTime time = from == 0 ? piece.begin : moved_by(piece.begin, from / piece.inverse_frames);
      if (const Status taken = take(Stretch{i, time, from, to}); !taken) return taken;
    }
  }
  return Done{};
}

Error too_small(const Trajectory& trajectory, std::span<const double> counts_per_unit) {
  const Result<std::size_t> needed = CountTrajectory::piece_count(trajectory, counts_per_unit);
  return {.code = ErrorCode::capacity,
          .what = "the trajectory has more pieces in counts than there is room for",
          .remedy = "give more pieces, and a polynomial for each of them and each axis",
          .needed = needed ? static_cast<std::int64_t>(*needed) : -1};
}

CountPolynomial in_counts(const PiecePolynomial& septic, double begin, double counts_per_unit) {
  const PiecePolynomial c = Economized(septic).c;
  const double exact = (begin + c[0]) * counts_per_unit;
  const double base = std::floor(exact + 0.5);
  CountPolynomial result;
  result.rounded_base = static_cast<std::uint32_t>(static_cast<std::int32_t>(base)) -
                        std::bit_cast<std::uint32_t>(CountPolynomial::rounder);
  result.c[0] = static_cast<float>(exact - base);
  for (std::size_t i = 1; i < result.c.size(); ++i) result.c[i] = static_cast<float>(c[i] * counts_per_unit);
  return result;
}

}  // namespace

Result<std::size_t> CountTrajectory::piece_count(const Trajectory& trajectory,
                                                 std::span<const double> counts_per_unit) {
  std::size_t count = 1;
  const Status counted = for_each_stretch(trajectory, counts_per_unit, [&](const Stretch&) -> Status {
    ++count;
    return Done{};
  });
  if (!counted) return counted.error();
  return count;
}

Result<CountTrajectory> CountTrajectory::make(const Trajectory& trajectory,
                                              std::span<const double> counts_per_unit,
                                              const CountTrajectoryMemory& memory) {
  const std::size_t axes = trajectory.axis_count();
  std::size_t count = 0;
  const auto is_full = [&] {
    return count >= memory.pieces.size() || (count + 1) * axes > memory.polynomials.size();
  };
  const auto take = [&](const Stretch& stretch) -> Status {
    const TrajectoryPiece& piece = trajectory.pieces()[stretch.piece];
    if (is_full()) return too_small(trajectory, counts_per_unit);
    memory.pieces[count].begin = in_float(stretch.begin);
    for (std::size_t axis = 0; axis < axes; ++axis) {
      const PiecePolynomial c = part_of(distance_on_piece(trajectory, piece, axis), stretch.from, stretch.to);
      memory.polynomials[count * axes + axis] =
          in_counts(c, trajectory.values()[piece.begin_row + axis], counts_per_unit[axis]);
    }
    ++count;
    return Done{};
  };
  if (const Status made = for_each_stretch(trajectory, counts_per_unit, take); !made) return made.error();
  if (is_full()) return too_small(trajectory, counts_per_unit);
  memory.pieces[count] = {.begin = in_float(trajectory.end()), .inverse_frames = 0};
  // The last position is read from where it is written, and not computed.
  const TrajectoryPiece& last = trajectory.pieces().back();
  const bool is_whole = trajectory.end() == trajectory.end_of(trajectory.pieces().size() - 1);
  for (std::size_t axis = 0; axis < axes; ++axis) {
    PiecePolynomial rest{};
    double position = trajectory.values()[last.end_row + axis];
    if (!is_whole) {
      const TrajectoryPiece& piece = trajectory.pieces()[trajectory.piece_at(trajectory.end())];
      const double u = frames_between(piece.begin, trajectory.end()) * piece.inverse_frames;
      rest[0] = part_of(distance_on_piece(trajectory, piece, axis), u, 1)[0];
      position = trajectory.values()[piece.begin_row + axis];
    }
    memory.polynomials[count * axes + axis] = in_counts(rest, position, counts_per_unit[axis]);
  }
  ++count;
  // One that is shorter than a float tells is never the last that has begun, so nobody looks at it.
  for (std::size_t i = 0; i + 1 < count; ++i) {
    CountTrajectoryPiece& piece = memory.pieces[i];
    piece.inverse_frames = 1 / frames_between(piece.begin, memory.pieces[i + 1].begin);
  }
  CountTrajectory result;
  result.pieces_ = memory.pieces.first(count);
  result.polynomials_ = memory.polynomials.data();
  result.current_ = memory.pieces.data();
  result.current_polynomials_ = result.polynomials_;
  result.axis_count_ = axes;
  return result;
}

float CountTrajectory::find(const FloatFrameTime& time) {
  const auto is_in = [&](std::size_t i) {
    return pieces_[i].begin <= time && (i + 1 == pieces_.size() || time < pieces_[i + 1].begin);
  };
  auto index = static_cast<std::size_t>(current_ - pieces_.data()) + 1;
  if (index == pieces_.size() || !is_in(index)) {
    std::size_t end = pieces_.size();
    for (index = 0; end - index > 1;) {
      const std::size_t middle = index + (end - index) / 2;
      (pieces_[middle].begin <= time ? index : end) = middle;
    }
  }
  current_ = &pieces_[index];
  current_polynomials_ = polynomials_ + index * axis_count_;
  return time < current_->begin ? 0 : frames_between(current_->begin, time) * current_->inverse_frames;
}

}  // namespace inbetween
