#include "inbetween/trajectory/trajectory.hpp"

#include <algorithm>

#include "inbetween/base/processor_clones.hpp"
#include "trajectory/hermite.hpp"

namespace inbetween {
namespace {

/// Sums of the numbers of two rows: one order of operations, whatever the lanes.
template <std::size_t Known>
INBETWEEN_PROCESSOR_CLONES void add_up(const HermiteWeights& weights, const double* begin, const double* end,
                                       std::size_t axes, double* out, std::size_t stride, bool is_position) {
  const HermiteWeights w = weights;
  for (std::size_t d = 0; d < axes; ++d) {
    double sum = w.end[0] * (end[d] - begin[d]);
    for (std::size_t j = 1; j < Known; ++j)
      sum += w.begin[j] * begin[j * axes + d] + w.end[j] * end[j * axes + d];
    out[d * stride] = is_position ? begin[d] + sum : sum;
  }
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

Trajectory Trajectory::part(const FrameTime<double>& first, const FrameTime<double>& last) const {
  Trajectory result = *this;
  result.begin_ = first;
  result.end_ = last;
  return result;
}

std::size_t Trajectory::piece_at(const FrameTime<double>& time) const {
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

void Trajectory::positions(const FrameTime<double>& time, std::span<double> out) const {
  write_positions(time, out.data(), 1);
}

void Trajectory::write_positions(const FrameTime<double>& asked, double* out, std::size_t stride) const {
  FrameTime<double> time = asked;
  if (!(begin_ <= time && time < end_)) [[unlikely]]
    time = time < begin_ ? begin_ : end_;
  if (!(time < end_of_pieces_)) [[unlikely]] {
    const double* row = &values_[pieces_.back().end_row];
    for (std::size_t d = 0; d < axis_count_; ++d) out[d * stride] = row[d];
    return;
  }
  const TrajectoryPiece& piece = pieces_[piece_at(time)];
  const double u = frames_between(piece.begin, time) * piece.inverse_frames;
  const double* begin = &values_[piece.begin_row];
  const double* end = &values_[piece.end_row];
  with_degree(piece.degree, [&](auto degree) {
    add_up<known_of(degree)>(position_weights<degree>(u, piece.seconds), begin, end, axis_count_, out, stride,
                             true);
  });
  if (!keeps_to_joints_) [[likely]]
    return;
  for (std::size_t d = 0; d < axis_count_; ++d) {
    double& position = out[d * stride];
    position = std::clamp(position, std::min(begin[d], end[d]), std::max(begin[d], end[d]));
  }
}

void Trajectory::motion(const FrameTime<double>& time, std::span<AxisMotion<double>> out) const {
  constexpr std::size_t stride = sizeof(AxisMotion<double>) / sizeof(double);
  const bool is_end = time == end_;
  if (!is_end && !(begin_ <= time && time < end_)) {
    for (std::size_t d = 0; d < axis_count_; ++d) out[d] = {};
    return write_positions(time, &out.data()->position, stride);
  }
  std::size_t index = time < end_of_pieces_ ? piece_at(time) : pieces_.size() - 1;
  if (is_end && index > 0 && pieces_[index].begin == time) --index;
  const TrajectoryPiece& piece = pieces_[index];
  const double u = time == end_of(index) ? 1 : frames_between(piece.begin, time) * piece.inverse_frames;
  const double* begin = &values_[piece.begin_row];
  const double* end = &values_[piece.end_row];
  with_degree(piece.degree, [&](auto degree) {
    const double h = piece.seconds;
    AxisMotion<double>* first = out.data();
    add_up<known_of(degree)>(hermite_weights<degree, 1>(u, h), begin, end, axis_count_, &first->velocity,
                             stride, false);
    add_up<known_of(degree)>(hermite_weights<degree, 2>(u, h), begin, end, axis_count_, &first->acceleration,
                             stride, false);
    add_up<known_of(degree)>(hermite_weights<degree, 3>(u, h), begin, end, axis_count_, &first->jerk, stride,
                             false);
  });
  write_positions(time, &out.data()->position, stride);
}

double at_end_of_piece(const Trajectory& trajectory, const TrajectoryPiece& piece, std::size_t axis,
                       std::size_t derivative, bool is_end) {
  const std::size_t axes = trajectory.axis_count();
  const double* begin = &trajectory.values()[piece.begin_row];
  const double* end = &trajectory.values()[piece.end_row];
  if (derivative < known_of(piece.degree)) return (is_end ? end : begin)[derivative * axes + axis];
  double sum = 0;
  with_degree(piece.degree, [&](auto degree) {
    const double u = is_end ? 1 : 0;
    const HermiteWeights w = derivative == 1   ? hermite_weights<degree, 1>(u, piece.seconds)
                             : derivative == 2 ? hermite_weights<degree, 2>(u, piece.seconds)
                                               : hermite_weights<degree, 3>(u, piece.seconds);
    sum = w.end[0] * (end[axis] - begin[axis]);
    for (std::size_t j = 1; j < known_of(degree); ++j)
      sum += w.begin[j] * begin[j * axes + axis] + w.end[j] * end[j * axes + axis];
  });
  return sum;
}

}  // namespace inbetween
