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
double chord_sum(const Path& path) {
  double sum = 0;
  for (std::int32_t i = 0; i < path.segment_count(); ++i) {
    const auto here = path.segment(i);
    const auto next = path.segment(i + 1);
    double largest = 0;
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
void fill_buckets(std::span<const double> next_begins, double buckets_per_length,
                  std::span<std::int32_t> buckets) {
  std::ranges::fill(buckets, 0);
  for (std::size_t piece = 0; piece + 1 < next_begins.size(); ++piece) {
    // The same rounded product as in the look-up decides, so that no piece is missed by an ulp.
    const double begin = next_begins[piece] * buckets_per_length;
    auto bucket = static_cast<std::size_t>(static_cast<std::int32_t>(begin));
    bucket += static_cast<double>(bucket) < begin ? 1 : 0;
    if (bucket < buckets.size()) buckets[bucket] = static_cast<std::int32_t>(piece + 1);
  }
  std::int32_t last = 0;
  for (std::int32_t& bucket : buckets) {
    last = std::max(last, bucket);
    bucket = last;
  }
}

/// Whether no length is before the one in front of it. Their distances from the start are not either, then:
/// rounding keeps the order.
bool rise(std::span<const double> lengths) {
  // Counted in numbers as wide as a double, of which the compiler makes lanes.
  std::int64_t falls = 0;
  for (std::size_t i = 1; i < lengths.size(); ++i) falls += lengths[i] < lengths[i - 1] ? 1 : 0;
  return falls == 0;
}

template <class Number>
Number within(const Number& x) {
  const Number zero(0);
  const Number one(1);
  const Number nonnegative = if_less(zero, x, x, zero);
  return if_less(nonnegative, one, nonnegative, one);
}
/// A plain piece in lanes: what ArcPiece::plain_t gives for each, to the bit.
template <class Number>
struct PlainPiece {
  Number inverse_step;
  std::array<Number, 8> c;

  explicit PlainPiece(const ArcPiece& piece) : inverse_step(piece.inverse_step) {
    for (std::size_t k = 0; k < c.size(); ++k) c[k] = Number(piece.c[k]);
  }
  [[nodiscard]] Number plain_t(const Number& offset) const {
    return within(septic(c, within(inverse_step * offset)));
  }
};

/// Lengths from a place of the path, which rise.
struct RisingLengths {
  double begin;
  std::span<const double> lengths;

  [[nodiscard]] std::size_t size() const { return lengths.size(); }
  [[nodiscard]] bool is_before(std::size_t i, double distance) const { return begin + lengths[i] < distance; }
};

/// Points found one after the other, and whether they are in order.
struct Found {
  std::size_t count = 0;
  bool in_order = true;
};

/// Finds the points of lengths, from the first to the last before `to`, all on one plain piece. Points behind
/// those may be overwritten: four are evaluated at once, and the next ones without waiting for how many of
/// the four are before `to`.
template <class Number>
Found find_points(const ArcPiece& piece, double offset, double to, const RisingLengths& rising,
                  std::span<PathPoint> points) {
  std::size_t done = 0;
  double last = 0;
  bool in_order = true;
  if constexpr (lanes_are_quick) {
    const PlainPiece<Number> own(piece);
    Number fallen(0);
    while (done + lane_count <= rising.size()) {
      const Number t = own.plain_t(offset + Number::from(rising.lengths.subspan(done)));
      fallen = if_less(t, shifted(last, t), Number(1), fallen);
      last = t[lane_count - 1];
      for (std::size_t i = 0; i < lane_count; ++i) points[done + i] = {piece.segment, t[i]};
      done += lane_count;
      if (!rising.is_before(done - 1, to)) break;
    }
    for (std::size_t i = 0; i < lane_count; ++i) in_order = in_order && fallen[i] == 0;
    while (done > 0 && !rising.is_before(done - 1, to)) --done;
  }
  for (; done < rising.size() && rising.is_before(done, to); ++done) {
    const double t = piece.plain_t(offset + rising.lengths[done]);
    in_order = in_order && t >= last;
    last = t;
    points[done] = {piece.segment, t};
  }
  return {done, in_order};
}

/// Locates lengths. `find` gives the piece of a distance, `locate` the point of a length. Returns whether the
/// points are in order.
template <class Find, class Locate>
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES bool locate_lengths(std::span<const ArcPiece> pieces,
                                                                std::span<const double> next_begins,
                                                                double path_end, const TwoSum& begin,
                                                                const Find& find, const Locate& locate,
                                                                std::span<const double> lengths,
                                                                std::span<PathPoint> points) {
  const bool rises = rise(lengths);
  const bool is_wide = has_wide_registers();
  std::size_t index = pieces.size();
  bool in_order = true;
  for (std::size_t i = 0; i < lengths.size();) {
    const double distance = begin.high + lengths[i];
    const bool is_inside = distance > 0 && distance < path_end;  // the ends are exact
    Found found;
    if (is_inside && rises) {
      if (index + 1 < pieces.size() && distance < next_begins[index + 1]) {
        ++index;
      } else {
        index = find(distance);
      }
      const ArcPiece& piece = pieces[index];
      if (piece.kind == ArcPiece::Kind::plain) {
        const double to = std::min(next_begins[index], path_end);
        const double offset = piece.offset(begin);
        const RisingLengths rest{begin.high, lengths.subspan(i)};
        found = is_wide ? find_points<WideLanes>(piece, offset, to, rest, points.subspan(i))
                        : find_points<Lanes<register_bytes>>(piece, offset, to, rest, points.subspan(i));
      }
    }
    if (found.count == 0) {
      points[i] = locate(lengths[i]);
      index = pieces.size();
      found.count = 1;
    }
    in_order = in_order && found.in_order && (i == 0 || points[i - 1].at_or_before(points[i]));
    i += found.count;
  }
  return in_order;
}

template <std::size_t Count>
[[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void write_speeds(const SegmentSpeed& speed,
                                                              const std::array<double, Count>& t,
                                                              std::array<double, Count>& out) {
  out = speed.at(t);
}

Error too_many_pieces(std::size_t needed) {
  return {.code = ErrorCode::capacity,
          .what = "the inverse of arc length has more pieces than its memory",
          .remedy = "give it a larger capacity, or accept a larger delta",
          .needed = static_cast<std::int64_t>(std::max<std::size_t>(needed, 1))};  // a bucket, if no piece
}

}  // namespace

Result<ArcLength> ArcLength::make(const Path& path, const ArcLengthOptions& options,
                                  const ArcLengthMemory& memory) {
  if (!(options.delta >= Precision::smallest_delta && options.delta < 0.1)) {
    return Error{.code = ErrorCode::accuracy,
                 .what = "this delta cannot be reached in floating point",
                 .remedy = "use one from 1e-9 to 0.1; the default is 1e-6"};
  }
  const auto segments = static_cast<std::size_t>(path.segment_count());
  if (memory.first_pieces.size() < segments + 1 || memory.segment_begins.size() < segments + 1) {
    return Error{.code = ErrorCode::capacity,
                 .what = "the path has more segments than the memory of its arc length",
                 .remedy = "give it a larger capacity",
                 .needed = static_cast<std::int64_t>(segments)};
  }
  const double chords = chord_sum(path);
  if (chords > 0 && chords < Precision::smallest_square_root) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the path is too short for this floating-point type",
                 .remedy = "use a smaller unit or larger weights, so that its numbers become larger"};
  }
  InverseBuilder builder(options, chords, memory);
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
    memory.begins[pieces - 1] = std::numeric_limits<double>::infinity();
    result.buckets_per_length_ = static_cast<double>(result.buckets_.size()) / result.total() *
                                 (1 - 4 * std::numeric_limits<double>::epsilon());
    fill_buckets(result.next_begins_, result.buckets_per_length_,
                 memory.buckets.first(result.buckets_.size()));
  }
  return result;
}

/// Bisection among the pieces behind `piece` in its bucket.
std::size_t ArcLength::piece_in_crowd(std::size_t piece, std::size_t bucket, double distance) const {
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

bool ArcLength::locate(const TwoSum& begin, std::span<const double> lengths,
                       std::span<PathPoint> points) const {
  return locate_lengths(
      pieces_, next_begins_, end_.high, begin, [&](double distance) { return piece_at(distance); },
      [&](double length) { return locate(begin, length); }, lengths, points);
}

TwoSum ArcLength::distance(const Path& path, const PathPoint& point) const {
  return distance(SegmentSpeed(path.segment(point.segment), path.weights()), point).distance;
}

DistanceAndSpeed ArcLength::distance(const SegmentSpeed& speed, const PathPoint& point) const {
  const auto segment = static_cast<std::size_t>(point.segment);
  TwoSum sum = segment_begins_[std::min(segment, segment_begins_.size() - 1)];
  const bool is_passed_in_no_distance =
      point.segment < segment_count() && first_pieces_[segment] == first_pieces_[segment + 1];
  if (speed.is_still() || is_passed_in_no_distance) return {sum, 0};

  // Past the end of an open path the speed is that of the continuation, in one stretch.
  double from = 0;
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
  const double extent = point.t - from;
  using Rule = GaussLegendre;
  constexpr std::size_t nodes = Rule::node.size();
  std::array<double, nodes + 1> t;  // and the point itself, in a lane that would do nothing
  for (std::size_t i = 0; i < nodes; ++i) t[i] = from + extent * Rule::node[i];
  t[nodes] = point.t;
  std::array<double, nodes + 1> speeds;
  write_speeds(speed, t, speeds);
  double mean = 0;
  for (std::size_t i = 0; i < nodes; ++i) mean += Rule::weight[i] * speeds[i];
  sum.add(speed.unit() * (mean * extent));
  return {sum, speed.unit() * speeds[nodes]};
}

}  // namespace inbetween
