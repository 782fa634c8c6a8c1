#include "inbetween/trajectory/trajectory.hpp"

#include <algorithm>

#include "inbetween/base/processor_clones.hpp"
#include "trajectory/hermite.hpp"

namespace inbetween {
namespace {

template <std::size_t Degree>
INBETWEEN_PROCESSOR_CLONES void write_positions_on(const PieceRows& rows, double u, double seconds,
                                                   double* out) {
  const HermiteWeights weights = position_weights<Degree>(u, seconds);
  for (std::size_t d = 0; d < rows.axes; ++d)
    out[d] = rows.begin[d] + sum_of<known_of(Degree)>(weights, rows, d);
}

/// The weights of the position and of three derivatives.
template <std::size_t Degree>
struct MotionWeights {
  HermiteWeights position, velocity, acceleration, jerk;

  INBETWEEN_PART_OF_CLONES MotionWeights(double u, double seconds)
      : position(position_weights<Degree>(u, seconds)),
        velocity(hermite_weights<Degree, 1>(u, seconds)),
        acceleration(hermite_weights<Degree, 2>(u, seconds)),
        jerk(hermite_weights<Degree, 3>(u, seconds)) {}

  [[nodiscard]] INBETWEEN_PART_OF_CLONES AxisMotion motion(const PieceRows& rows, std::size_t d) const {
    constexpr std::size_t known = known_of(Degree);
    return {rows.begin[d] + sum_of<known>(position, rows, d), sum_of<known>(velocity, rows, d),
            sum_of<known>(acceleration, rows, d), sum_of<known>(jerk, rows, d)};
  }
};

template <std::size_t Degree>
INBETWEEN_PROCESSOR_CLONES void write_motion_on(const PieceRows& rows, double u, double seconds,
                                                AxisMotion* out) {
  const MotionWeights<Degree> weights(u, seconds);
  for (std::size_t d = 0; d < rows.axes; ++d) out[d] = weights.motion(rows, d);
}

/// This keeps a position between the ends of its piece: a polynomial may be beyond them by its rounding.
double clipped(double position, const PieceRows& rows, std::size_t axis) {
  return std::clamp(position, std::min(rows.begin[axis], rows.end[axis]),
                    std::max(rows.begin[axis], rows.end[axis]));
}

Error invalid(const char* what) {
  return {.code = ErrorCode::out_of_range,
          .what = what,
          .remedy = "give pieces that follow each other, with rows of the values"};
}

Status check_pieces(const TrajectoryContents& contents) {
  for (std::size_t i = 0; i < contents.pieces.size(); ++i) {
    const TrajectoryPiece& piece = contents.pieces[i];
    const bool is_last = i + 1 == contents.pieces.size();
    if (!(piece.begin < (is_last ? contents.end : contents.pieces[i + 1].begin)))
      return invalid("a piece of the trajectory does not begin before its end");
    if (piece.degree == 0 || piece.degree == 2 || piece.degree == 4 || piece.degree > 7)
      return invalid("a piece of the trajectory is not of degree 1, 3, 5, 6 or 7");
    const std::size_t size = known_of(piece.degree) * contents.axis_count;
    if (piece.begin_row + size > contents.values.size() || piece.end_row + size > contents.values.size())
      return invalid("a piece of the trajectory has a row outside the values");
  }
  return Done{};
}

}  // namespace

Result<Trajectory> Trajectory::make(const TrajectoryContents& contents, std::span<std::uint32_t> buckets) {
  if (contents.axis_count == 0 || contents.pieces.empty() || buckets.empty()) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "the trajectory has no axis, no piece or no bucket",
                 .remedy = "give it at least one of each"};
  }
  if (const Status valid = check_pieces(contents); !valid) return valid.error();
  Trajectory trajectory;
  trajectory.pieces_ = contents.pieces;
  trajectory.values_ = contents.values;
  trajectory.breaks_ = contents.breaks;
  trajectory.unbounded_ = contents.unbounded;
  trajectory.axis_count_ = contents.axis_count;
  trajectory.begin_ = contents.pieces.front().begin;
  trajectory.end_ = trajectory.end_of_pieces_ = contents.end;
  trajectory.fps_ = contents.fps;
  trajectory.keeps_to_joints_ = contents.keeps_to_joints;
  trajectory.loosened_ = contents.loosened;
  const double frames = frames_between(trajectory.begin_, trajectory.end_);
  trajectory.buckets_per_frame_ = static_cast<double>(buckets.size()) / frames;
  std::size_t piece = 0;
  for (std::size_t b = 0; b < buckets.size(); ++b) {
    const double begin = static_cast<double>(b) / trajectory.buckets_per_frame_;
    // A little before its begin: what is looked up is not behind it, however both are rounded.
    while (piece + 1 < contents.pieces.size() &&
           frames_between(trajectory.begin_, contents.pieces[piece + 1].begin) <= begin * (1 - 1e-12))
      ++piece;
    buckets[b] = static_cast<std::uint32_t>(piece);
  }
  trajectory.buckets_ = buckets;
  return trajectory;
}

Trajectory Trajectory::part(const FrameTime& first, const FrameTime& last) const {
  Trajectory result = *this;
  result.begin_ = first;
  result.end_ = last;
  return result;
}

std::size_t Trajectory::piece_at(const FrameTime& time) const {
  const auto bucket =
      static_cast<std::size_t>(frames_between(pieces_.front().begin, time) * buckets_per_frame_);
  std::size_t piece = buckets_[std::min(bucket, buckets_.size() - 1)];
  // A bucket names a piece that begins before it. Where it ends is rounded, so the one behind the next tells
  // what may lie in it.
  std::size_t end = bucket + 2 < buckets_.size() ? buckets_[bucket + 2] + 1 : pieces_.size();
  while (end - piece > 1) {
    const std::size_t middle = piece + (end - piece) / 2;
    (pieces_[middle].begin <= time ? piece : end) = middle;
  }
  return piece;
}

void Trajectory::positions(const FrameTime& time, std::span<double> out) const {
  FrameTime at = time;
  if (!(begin_ <= at && at < end_)) [[unlikely]]
    at = at < begin_ ? begin_ : end_;
  if (!(at < end_of_pieces_)) [[unlikely]] {
    std::copy_n(&values_[pieces_.back().end_row], axis_count_, out.data());
    return;
  }
  const TrajectoryPiece& piece = pieces_[piece_at(at)];
  const double u = frames_between(piece.begin, at) * piece.inverse_frames;
  const PieceRows rows = rows_of(piece, values_, axis_count_);
  with_degree(piece.degree,
              [&](auto degree) { write_positions_on<degree>(rows, u, piece.seconds, out.data()); });
  if (!keeps_to_joints_) [[likely]]
    return;
  for (std::size_t d = 0; d < axis_count_; ++d) out[d] = clipped(out[d], rows, d);
}

Trajectory::Look Trajectory::look_at(const FrameTime& time) const {
  const bool is_outside = time < begin_ || end_ < time;
  const FrameTime at = is_outside ? (time < begin_ ? begin_ : end_) : time;
  std::size_t index = at < end_of_pieces_ ? piece_at(at) : pieces_.size() - 1;
  if (at == end_ && index > 0 && pieces_[index].begin == at) --index;
  const TrajectoryPiece& piece = pieces_[index];
  const bool is_at_end = at == end_of(index);
  const double u = is_at_end ? 1 : frames_between(piece.begin, at) * piece.inverse_frames;
  return {&piece, u, is_at_end, is_outside};
}

AxisMotion Trajectory::settled(AxisMotion motion, const Look& look, std::size_t axis) const {
  const PieceRows rows = rows_of(*look.piece, values_, axis_count_);
  if (look.is_at_end) motion.position = rows.end[axis];
  if (keeps_to_joints_) motion.position = clipped(motion.position, rows, axis);
  return look.is_outside ? AxisMotion{.position = motion.position} : motion;
}

void Trajectory::motion(const FrameTime& time, std::span<AxisMotion> out) const {
  const Look look = look_at(time);
  const TrajectoryPiece& piece = *look.piece;
  const PieceRows rows = rows_of(piece, values_, axis_count_);
  with_degree(piece.degree,
              [&](auto degree) { write_motion_on<degree>(rows, look.u, piece.seconds, out.data()); });
  for (std::size_t d = 0; d < axis_count_; ++d) out[d] = settled(out[d], look, d);
}

AxisMotion Trajectory::motion_of(std::size_t axis, const FrameTime& time) const {
  const Look look = look_at(time);
  const TrajectoryPiece& piece = *look.piece;
  const PieceRows rows = rows_of(piece, values_, axis_count_);
  AxisMotion motion;
  with_degree(piece.degree,
              [&](auto degree) { motion = MotionWeights<degree>(look.u, piece.seconds).motion(rows, axis); });
  return settled(motion, look, axis);
}

double at_end_of_piece(const Trajectory& trajectory, const TrajectoryPiece& piece, std::size_t axis,
                       std::size_t derivative, bool is_end) {
  const std::size_t axes = trajectory.axis_count();
  const PieceRows rows = rows_of(piece, trajectory.values(), axes);
  if (derivative < known_of(piece.degree)) return (is_end ? rows.end : rows.begin)[derivative * axes + axis];
  double sum = 0;
  with_degree(piece.degree, [&](auto degree) {
    const double u = is_end ? 1 : 0;
    const HermiteWeights w = derivative == 1   ? hermite_weights<degree, 1>(u, piece.seconds)
                             : derivative == 2 ? hermite_weights<degree, 2>(u, piece.seconds)
                                               : hermite_weights<degree, 3>(u, piece.seconds);
    sum = sum_of<known_of(degree)>(w, rows, axis);
  });
  return sum;
}

PiecePolynomial distance_on_piece(const Trajectory& trajectory, const TrajectoryPiece& piece,
                                  std::size_t axis) {
  const PieceRows rows = rows_of(piece, trajectory.values(), trajectory.axis_count());
  PiecePolynomial distance{};
  with_degree(piece.degree, [&](auto degree) {
    distance = position_polynomial<degree>(rows.begin, rows.end, rows.axes, axis, piece.seconds);
  });
  return distance;
}

PiecePolynomial part_of(const PiecePolynomial& whole, double from, double to) {
  PiecePolynomial part = whole;
  // Horner's rule again and again leaves the coefficients about another place (Knuth, The Art of Computer
  // Programming, volume 2, section 4.6.4).
  for (std::size_t i = 0; i + 1 < part.size(); ++i) {
    for (std::size_t k = part.size() - 1; k-- > i;) part[k] += from * part[k + 1];
  }
  double power = 1;
  for (double& c : part) {
    c *= power;
    power *= to - from;
  }
  return part;
}

}  // namespace inbetween
