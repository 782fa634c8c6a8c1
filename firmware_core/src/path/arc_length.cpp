#include "inbetween/path/arc_length.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "base/lanes.hpp"
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

/// Ways whose distances stand on the stack at a time: 1 KB in double precision, and less on a
/// microcontroller.
constexpr std::size_t ways_per_block = lanes_are_quick ? 128 : 16;

/// Writes the distances of the ways from the start, and returns whether none is before the one in front of
/// it: ways that rise may, rounded, fall by a bit.
template <Precise Real>
bool add_up(Real begin, std::span<const Real> ways, std::span<Real> distances) {
  for (std::size_t i = 0; i < ways.size(); ++i) distances[i] = begin + ways[i];
  // Counted in numbers as wide as Real, of which the compiler makes lanes.
  std::conditional_t<sizeof(Real) == sizeof(std::int64_t), std::int64_t, std::int32_t> falls = 0;
  for (std::size_t i = 1; i < ways.size(); ++i) falls += distances[i] < distances[i - 1] ? 1 : 0;
  return falls == 0;
}

/// ArcPiece::plain_t in lanes, with the bits that each would have alone.
template <class Number>
Number within(const Number& x) {
  const Number zero(0);
  const Number one(1);
  const Number nonnegative = if_less(zero, x, x, zero);
  return if_less(nonnegative, one, nonnegative, one);
}
template <Precise Real, class Number>
Number plain_places(const ArcPiece<Real>& piece, const Number& offset) {
  const std::array<Real, 8>& c = piece.c;
  const Number u = within(piece.inverse_step * offset);
  const Number square = u * u;
  const Number high = (square * square) * ((c[4] + c[5] * u) + square * (c[6] + c[7] * u));
  return within((c[0] + c[1] * u) + (square * (c[2] + c[3] * u) + high));
}

/// Finds the points of ways whose distances rise, from the first to the last before `to`, all on one plain
/// piece, and returns how many they are. Points behind those may be overwritten: four are evaluated at once,
/// and the next ones without waiting for how many of the four are before `to`.
template <class Number, Precise Real>
std::size_t find_points(const ArcPiece<Real>& piece, Real offset, Real to, std::span<const Real> distances,
                        std::span<const Real> ways, std::span<PathPoint<Real>> points) {
  std::size_t done = 0;
  for (; lanes_are_quick && done + lane_count <= ways.size(); done += lane_count) {
    const Number t = plain_places(piece, offset + Number::from(ways.subspan(done)));
    for (std::size_t i = 0; i < lane_count; ++i) points[done + i] = {piece.segment, t[i]};
    if (distances[done + lane_count - 1] < to) continue;
    std::size_t inside = 0;
    for (std::size_t i = 0; i + 1 < lane_count; ++i) inside += distances[done + i] < to ? 1U : 0U;
    return done + inside;
  }
  for (; done < ways.size() && distances[done] < to; ++done)
    points[done] = {piece.segment, piece.plain_t(offset + ways[done])};
  return done;
}

/// Locates a block of ways. `find` gives the piece of a distance, `locate` the point of a way.
template <Precise Real, class Find, class Locate>
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void locate_block(std::span<const ArcPiece<Real>> pieces,
                                                              std::span<const Real> next_begins,
                                                              Real path_end, const TwoSum<Real>& begin,
                                                              const Find& find, const Locate& locate,
                                                              std::span<const Real> ways,
                                                              std::span<PathPoint<Real>> points) {
  std::array<Real, ways_per_block> memory;
  const std::span<const Real> distances = std::span(memory).first(ways.size());
  const bool rises = add_up<Real>(begin.high, ways, memory);
  const bool is_wide = has_wide_registers();
  std::size_t index = pieces.size();
  for (std::size_t i = 0; i < ways.size();) {
    const Real distance = distances[i];
    const bool is_inside = distance > 0 && distance < path_end;  // the ends are exact
    if (is_inside && rises) {
      if (index + 1 < pieces.size() && distance < next_begins[index + 1]) {
        ++index;
      } else {
        index = find(distance);
      }
      const ArcPiece<Real>& piece = pieces[index];
      if (piece.kind == ArcPiece<Real>::Kind::plain) {
        const Real to = std::min(next_begins[index], path_end);
        const Real offset = piece.offset(begin);
        const auto rest = points.subspan(i);
        i += is_wide ? find_points<WideLanes<Real>, Real>(piece, offset, to, distances.subspan(i),
                                                          ways.subspan(i), rest)
                     : find_points<Lanes<Real>, Real>(piece, offset, to, distances.subspan(i),
                                                      ways.subspan(i), rest);
        continue;
      }
    }
    points[i] = locate(ways[i]);
    index = pieces.size();
    ++i;
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
void ArcLength<Real>::locate(const TwoSum<Real>& begin, std::span<const Real> ways,
                             std::span<PathPoint<Real>> points) const {
  for (std::size_t i = 0; i < ways.size(); i += ways_per_block) {
    const std::span<const Real> block = ways.subspan(i, std::min(ways.size() - i, ways_per_block));
    locate_block<Real>(
        pieces_, next_begins_, end_.high, begin, [&](Real distance) { return piece_at(distance); },
        [&](Real way) { return locate(begin, way); }, block, points.subspan(i, block.size()));
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
  using Rule = GaussLegendre<Real>;
  const Real extent = point.t - from;
  Real length = 0;
  for (std::size_t i = 0; i < Rule::node.size(); ++i) {
    length += Rule::weight[i] * speed.at(from + extent * Rule::node[i]);
  }
  sum.add(std::ldexp(length * extent, speed.exponent()));
  return sum;
}

template class ArcLength<double>;
template class ArcLength<float>;

}  // namespace inbetween
