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

}  // namespace

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

const double* Trajectory::resting_row(const FrameTime<double>& time) const {
  if (!pieces_.empty() && pieces_.front().begin <= time && time < end_) return nullptr;
  const bool is_before = !pieces_.empty() && time < pieces_.front().begin;
  return &values_[pieces_.empty() ? 0 : is_before ? pieces_.front().begin_row : pieces_.back().end_row];
}

void Trajectory::positions(const FrameTime<double>& time, std::span<double> out) const {
  if (const double* row = resting_row(time)) {
    for (std::size_t d = 0; d < axis_count_; ++d) out[d] = row[d];
    return;
  }
  const TrajectoryPiece& piece = pieces_[piece_at(time)];
  const double u = frames_between(piece.begin, time) * piece.inverse_frames;
  with_known(piece.degree, [&](auto known) {
    add_up<known>(position_weights<known>(u, piece.seconds), &values_[piece.begin_row],
                  &values_[piece.end_row], axis_count_, out.data(), 1, true);
  });
}

void Trajectory::motion(const FrameTime<double>& time, std::span<AxisMotion<double>> out) const {
  const double* row = resting_row(time);
  const bool is_end = row != nullptr && !pieces_.empty() && time == end_;
  if (row != nullptr && !is_end) {
    for (std::size_t d = 0; d < axis_count_; ++d) out[d] = {.position = row[d]};
    return;
  }
  const TrajectoryPiece& piece = is_end ? pieces_.back() : pieces_[piece_at(time)];
  const double u = is_end ? 1 : frames_between(piece.begin, time) * piece.inverse_frames;
  const double* begin = &values_[piece.begin_row];
  const double* end = &values_[piece.end_row];
  constexpr std::size_t stride = sizeof(AxisMotion<double>) / sizeof(double);
  with_known(piece.degree, [&](auto known) {
    const double h = piece.seconds;
    AxisMotion<double>* first = out.data();
    add_up<known>(position_weights<known>(u, h), begin, end, axis_count_, &first->position, stride, true);
    add_up<known>(hermite_weights<known, 1>(u, h), begin, end, axis_count_, &first->velocity, stride, false);
    add_up<known>(hermite_weights<known, 2>(u, h), begin, end, axis_count_, &first->acceleration, stride,
                  false);
    add_up<known>(hermite_weights<known, 3>(u, h), begin, end, axis_count_, &first->jerk, stride, false);
  });
  for (std::size_t d = 0; is_end && d < axis_count_; ++d) out[d].position = row[d];
}

}  // namespace inbetween
