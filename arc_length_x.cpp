#include "inbetween/path/arc_length.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "inbetween/base/processor_clones.hpp"
#include "inverse_builder.hpp"

namespace inbetween {
namespace {

/// The sum of the weighted chords: a lower bound of the length that is never 0 for a path that moves
/// from key to key.
template <Precise Real>
Real chord_sum(const Path<Real>& path) {
  Real sum = 0;
  for (std::int32_t i = 0; i < path.segment_count(); ++i) {
    const auto here = path.segment(i);
    const auto next = path.segment(i + 1);
    Real largest = 0;
    for (std::size_t d = 0; d < here.size(); ++d) {
      largest = std::max(largest, path.weights()[d] * std::fabs(next[d].c0 - here[d].c0));
    }
    sum += largest;
  }
  return sum;
}

/// More of them save few comparisons in the look-up, and are filled in vain.
constexpr std::size_t max_buckets_per_piece = 4;

/// bucket b holds the last piece that begins at or before b / buckets of the length. Every piece is put into
/// the first bucket that may hold it, and then every bucket takes over what is before it: no branch to guess.
template <Precise Real>
void fill_buckets(std::span<const Real> next_begins, Real buckets_per_length,
                  std::span<std::int32_t> buckets) {
  std::ranges::fill(buckets, 0);
  for (std::size_t piece = 0; piece + 1 < next_begins.size(); ++piece) {
    // The same rounded product as in the look-up decides, so that no piece is missed by an ulp.
    const Real begin = next_begins[piece] * buckets_per_length;
    auto bucket = static_cast<std::size_t>(static_cast<std::int32_t>(begin));
    bucket += static_cast<Real>(bucket) < begin ? 1 : 0;
    if (bucket < buckets.size()) buckets[bucket] = static_cast<std::int32_t>(piece + 1);
  }
  std::int32_t last = 0;
  for (std::int32_t& bucket : buckets) {
    last = std::max(last, bucket);
    bucket = last;
  }
}

/// Puts in the place of every way its t. Two loops, so that the compiler makes lanes of the one that counts.
template <Precise Real>
INBETWEEN_PROCESSOR_CLONES void find_places(const ArcPiece<Real>& piece, Real offset, std::span<Real> ways) {
  if (piece.kind == ArcPiece<Real>::Kind::plain) {
    const ArcPiece<Real> plain = piece;
    for (Real& way : ways) way = plain.plain_t(offset + way);
  } else {
    for (Real& way : ways) way = piece.t_at(offset + way);
  }
}

Error too_many_pieces(std::size_t needed) {
  return {.code = ErrorCode::capacity,
          .what = "the inverse of arc length has more pieces than its memory",
          .remedy = "give it a larger capacity, or accept a larger delta",
          .needed = static_cast<std::int64_t>(std::max<std::size_t>(needed, 1))};  // a bucket, if no piece
}

}  // namespace

template <Precise Real>
Result<ArcLength<Real>> ArcLength<Real>::make(const Path<Real>& path, const ArcLengthOptions<Real>& options,
                                              const ArcLengthMemory<Real>& memory) {
  if (!(options.delta >= Precision<Real>::smallest_delta && options.delta < Real(0.1))) {
    return Error{.code = ErrorCode::accuracy,
                 .what = "this delta cannot be reached in floating point",
                 .remedy = "use one from 1e-9 (double) or 4e-6 (float) to 0.1; the default is 1e-6 (1e-5)"};
  }
  const auto segments = static_cast<std::size_t>(path.segment_count());
  if (memory.first_pieces.size() < segments + 1 || memory.segment_begins.size() < segments + 1) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the path has more segments than the memory of its arc length",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(segments)};
  }
  const Real chords = chord_sum(path);
  if (chords > 0 && chords < Precision<Real>::smallest_square_root) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the path is too short for this floating-point type",
                 .remedy = "use a smaller unit or larger weights, so that its numbers become larger"};
  }
  InverseBuilder<Real> builder(options, chords, memory);
  for (std::size_t i = 0; i < segments; ++i) {
    memory.first_pieces[i] = static_cast<std::int32_t>(builder.list().count());
    memory.segment_begins[i] = builder.length();
    builder.add_segment(path, static_cast<std::int32_t>(i));
    if (!builder.reachable()) {
      return Error{.code = ErrorCode::accuracy,
                   .what = "the inverse of arc length cannot be as accurate as asked after this key",
                   .remedy = "use a larger delta, or estimated instead of certified acceptance",
                   .key = static_cast<std::int32_t>(i)};
    }
  }
  const std::size_t pieces = builder.list().count();
  memory.first_pieces[segments] = static_cast<std::int32_t>(pieces);
  memory.segment_begins[segments] = builder.length();
  if (!builder.list().complete() || memory.buckets.empty()) return too_many_pieces(pieces);

  ArcLength result;
  result.pieces_ = memory.pieces.first(pieces);
  result.buckets_ =
      memory.buckets.first(std::clamp<std::size_t>(max_buckets_per_piece * pieces, 1, memory.buckets.size()));
  result.first_pieces_ = memory.first_pieces.first(segments + 1);
  result.segment_begins_ = memory.segment_begins.first(segments + 1);
  result.end_ = builder.length();
  result.delta_ = options.delta;
  result.next_begins_ = memory.begins.first(pieces);
  if (pieces > 0) {
    std::shift_left(memory.begins.begin(), memory.begins.begin() + static_cast<std::ptrdiff_t>(pieces), 1);
    memory.begins[pieces - 1] = std::numeric_limits<Real>::infinity();
    result.buckets_per_length_ = static_cast<Real>(result.buckets_.size()) / result.total() *
                                 (1 - 4 * std::numeric_limits<Real>::epsilon());
    fill_buckets(result.next_begins_, result.buckets_per_length_,
                 memory.buckets.first(result.buckets_.size()));
  }
  return result;
}

/// Bisection among the pieces behind `piece` in its bucket.
template <Precise Real>
std::size_t ArcLength<Real>::piece_in_crowd(std::size_t piece, std::size_t bucket, Real distance) const {
  std::size_t low = piece + 1;
  std::size_t high =
      bucket + 1 < buckets_.size() ? static_cast<std::size_t>(buckets_[bucket + 1]) : pieces_.size() - 1;
  while (low < high) {  // it is in [low, high]
    const std::size_t middle = (low + high) / 2;
    if (next_begins_[middle] <= distance) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

template <Precise Real>
void ArcLength<Real>::locate(const TwoSum<Real>& begin, std::span<Real> ways,
                             std::span<PathPoint<Real>> points) const {
  for (std::size_t i = 0; i < ways.size();) {
    const Real first = begin.high + ways[i];
    if (first <= 0 || first >= end_.high) {  // the exact ends
      points[i] = locate(begin, ways[i]);
      ++i;
      continue;
    }
    const std::size_t index = piece_at(first);
    const ArcPiece<Real>& piece = pieces_[index];
    // Ways that rise may, rounded, fall by a bit.
    const Real from = index > 0 ? next_begins_[index - 1] : Real(0);
    const Real to = std::min(next_begins_[index], end_.high);
    std::size_t end = i + 1;
    while (end < ways.size() && begin.high + ways[end] >= from && begin.high + ways[end] < to) ++end;
    const std::span<Real> run = ways.subspan(i, end - i);
    find_places(piece, piece.offset(begin), run);
    for (const Real t : run) points[i++] = {piece.segment, t};
  }
}

template <Precise Real>
TwoSum<Real> ArcLength<Real>::distance(const Path<Real>& path, const PathPoint<Real>& point) const {
  const auto segment = static_cast<std::size_t>(point.segment);
  TwoSum<Real> sum = segment_begins_[std::min(segment, segment_begins_.size() - 1)];
  const SegmentSpeed<Real> speed(path.segment(point.segment), path.weights());
  const bool is_passed_in_no_distance =
      point.segment < segment_count() && first_pieces_[segment] == first_pieces_[segment + 1];
  if (speed.is_still() || is_passed_in_no_distance) return sum;

  // Past the end of an open path the speed is that of the continuation, in one stretch.
  Real from = 0;
  if (point.segment < segment_count()) {
    auto piece = static_cast<std::size_t>(first_pieces_[segment]);
    auto end = static_cast<std::size_t>(first_pieces_[segment + 1]);
    while (end - piece > 1) {  // the piece is in [piece, end)
      const std::size_t middle = (piece + end) / 2;
      (pieces_[middle].c[0] <= point.t ? piece : end) = middle;
    }
    from = pieces_[piece].c[0];
    sum = begin_of(piece);
  }
  using Rule = GaussLegendre6<Real>;
  const Real extent = point.t - from;
  Real length = 0;
  for (std::size_t i = 0; i < Rule::node.size(); ++i) {
    length += Rule::weight[i] * speed.at(from + extent * Rule::node[i]);
  }
  sum.add(std::ldexp(length * extent, speed.exponent()));
  return sum;
}

template class ArcLength<double>;

}  // namespace inbetween
