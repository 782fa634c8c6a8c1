#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "inbetween/base/processor_clones.hpp"
#include "inbetween/path/arc_length.hpp"
#include "piece_fit.hpp"
#include "segment_speed.hpp"

/// The pieces of the inverse of arc length, fitted segment by segment as long as each may be.

namespace inbetween {

/// Takes pieces in order of t and keeps counting when the memory is full, so that the error can say
/// what would have sufficed.
class PieceList {
 public:
  explicit PieceList(const ArcLengthMemory& memory) : memory_(memory) {}

  /// The place of the next piece, to be filled; none where the memory is full.
  [[nodiscard]] ArcPiece* add(double begin) {
    const std::size_t index = count_++;
    if (!fits(index)) return nullptr;
    memory_.begins[index] = begin;
    return &memory_.pieces[index];
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] bool complete() const { return count_ == 0 || fits(count_ - 1); }

  /// Turns round the pieces from `first` on, which were added from an anchor backwards.
  void reverse_from(std::size_t first) {
    if (!complete()) return;
    std::ranges::reverse(memory_.pieces.subspan(first, count_ - first));
    std::ranges::reverse(memory_.begins.subspan(first, count_ - first));
  }
  [[nodiscard]] std::span<ArcPiece> pieces_from(std::size_t first) {
    return complete() ? memory_.pieces.subspan(first, count_ - first) : std::span<ArcPiece>{};
  }
  [[nodiscard]] double& begin(std::size_t index) { return memory_.begins[index]; }

 private:
  [[nodiscard]] bool fits(std::size_t index) const {
    return index < memory_.pieces.size() && index < memory_.begins.size();
  }
  ArcLengthMemory memory_;
  std::size_t count_ = 0;
};

/// x^(1/7) to 1 % for x in [1, 2^21] and its value at the nearer end outside: enough for a step size, from
/// multiplications alone and so the same on every target.
inline double rough_seventh_root(double x) {
  double root = 1;
  for (int i = 0; i < 20 && x >= 2; ++i) {
    x /= 2;
    root *= 1.104089514;
  }
  return root * (0.8995 + 0.1041 * std::clamp(x, 1.0, 2.0));
}

/// Rounding alone may show this residual of a piece: its speed at two places, and the sum of both.
/// Without it pieces would be divided for nothing where delta is small.
inline constexpr double residual_rounding = 48 * std::numeric_limits<double>::epsilon();

/// A segment this much shorter than the path is passed in no distance: it is below the last bit of a
/// length that is carried in two numbers.
inline constexpr double unresolved_share =
    std::numeric_limits<double>::epsilon() * std::numeric_limits<double>::epsilon();

/// The result of a batch of stretches: the errors of its pieces over what is allowed.
struct BatchErrors {
  double first = 0;
  double last = 0;
  double worst = 0;
};

/// The lengths of stretches in tau, outward from the anchor: as long as the last errors allow.
class Stride {
 public:
  explicit Stride(double extent) : extent_(extent), length_(extent / 20) {}

  [[nodiscard]] bool at_end() const { return begin_ >= extent_; }
  /// Sets the ends of the next stretches, all of one length, and returns how many they are; the ends of more
  /// are the last end again. Near the end what is left is divided evenly, so that no sliver remains.
  template <std::size_t bytes>
  [[nodiscard]] std::size_t divide(Lanes<bytes>& ends) const {
    constexpr auto lanes = static_cast<double>(lane_count);
    const double rest = extent_ - begin_;
    double length = std::max(length_, min_length());
    std::size_t count = lane_count;
    const bool is_last = rest <= lanes * length;
    if (is_last) {
      count = 1;
      while (static_cast<double>(count) * length < rest) ++count;
      length = rest / static_cast<double>(count);
    } else if (rest < (lanes + 2) * length) {
      length = rest / (lanes + 2);
    }
    constexpr std::array<double, lane_count> steps{1, 2, 3, 4};
    ends = begin_ + length * Lanes<bytes>::from(steps);
    if (is_last) {
      for (std::size_t i = count - 1; i < lane_count; ++i) ends.set(i, extent_);
    }
    return count;
  }
  /// Whether the stretch to `end` can be made shorter.
  [[nodiscard]] bool is_divisible(double end) const { return end - begin_ > 2 * min_length(); }
  /// Goes on behind the first `done` stretches, of which the next one was refused. The error grows with the
  /// seventh power of the length (septic Hermite interpolation); half of what is allowed is aimed at.
  template <std::size_t bytes>
  void shorten(const Lanes<bytes>& ends, std::size_t done, double error) {
    const double length = ends[0] - begin_;
    // Not finite: the derivatives at an end are useless, and much shorter is the only remedy.
    length_ = std::isfinite(error) ? length / rough_seventh_root(error / 0.5) : length / 8;
    if (done > 0) begin_ = ends[done - 1];
  }
  /// Goes on behind the last stretch, with lengths chosen by comparisons: the processor guesses them and
  /// begins with the next batch before the errors of this one are known. The steps were found by measurement
  /// (pieces and time over random paths); hard_cases_test holds the number of pieces.
  template <std::size_t bytes>
  void advance(const Lanes<bytes>& ends, const BatchErrors& errors) {
    length_ = (ends[0] - begin_) * factor(errors);
    begin_ = ends[lane_count - 1];
  }

 private:
  static double factor(const BatchErrors& errors) {
    const double last = errors.last;
    const bool rises = last >= errors.worst && last > 2 * errors.first;  // and will go on rising
    if (last < 0.003) return rises ? 1.4 : 2.0;
    if (last < 0.02) return rises ? 1.2 : 1.6;
    if (last < 0.06) return rises ? 1.05 : 1.36;
    if (last < 0.13) return rises ? 1.0 : 1.2;
    if (last < 0.25) return rises ? 0.95 : 1.08;
    if (rises) return last < 0.5 ? 0.87 : 0.8;
    return last < 0.65 ? 1.0 : 0.92;
  }
  /// So short that the piece is below the negligible share for every curve that floating point can tell
  /// from a cusp, and long enough that `end` is behind `begin`.
  [[nodiscard]] double min_length() const {
    return std::max(extent_ * 1e-18, begin_ * (4 * std::numeric_limits<double>::epsilon()));
  }

  double extent_;
  double length_;
  double begin_ = 0;
};

/// Fits the pieces of one segment after another.
class InverseBuilder {
 public:
  InverseBuilder(const ArcLengthOptions& options, double shortest_total, const ArcLengthMemory& memory)
      : options_(options),
        shortest_total_(shortest_total),
        per_estimate_(4 / (2 * options.delta)),
        negligible_(shortest_total * Precision::negligible_share),
        list_(memory) {}

  void add_segment(const Path& path, std::int32_t segment) {
    const SegmentSpeed speed(path.segment(segment), path.weights());
    if (!(speed.largest() > shortest_total_ * unresolved_share)) return;
    segment_ = segment;
    scale_ = std::ldexp(1.0, speed.exponent());
    inverse_scale_ = 1 / scale_;
    const AnchoredIntervals split = split_where_slow(speed);
    for (std::size_t i = 0; i < split.count; ++i) add_interval(split.intervals[i]);
  }

  [[nodiscard]] const TwoSum& length() const { return length_; }
  [[nodiscard]] const PieceList& list() const { return list_; }
  /// Every piece so far is as accurate as asked, or too short to matter.
  [[nodiscard]] bool reachable() const { return reachable_; }

 private:
  /// Flat, so that the lanes stay in registers from one step to the next.
  [[gnu::flatten]] INBETWEEN_PROCESSOR_CLONES void add_interval(const AnchoredInterval& interval) {
    if (wide_register_bytes == register_bytes || has_wide_registers()) {
      add_batches<wide_register_bytes>(interval);
    } else {
      add_batches<register_bytes>(interval);
    }
  }

  template <std::size_t bytes>
  void add_batches(const AnchoredInterval& interval) {
    const std::size_t first = list_.count();
    const TwoSum begin = length_;
    if (!interval.forward) length_ = {};  // distances from the anchor, until `turn_round`
    const TwoSum anchor = length_;
    const PieceFitter fitter(interval);
    PieceBatch<bytes> batch;
    batch.near = fitter.at_anchor();
    Stride stride(interval.extent);
    while (!stride.at_end()) {
      const std::size_t count = stride.divide(batch.row.tau);
      fitter.fit(length_.minus(anchor) * inverse_scale_, batch);
      BatchErrors errors;
      const std::size_t done = count_accepted(fitter, count, batch, errors);
      for (std::size_t i = 0; i < done; ++i) add_piece(interval, batch, i, anchor);
      if (done == 0 && !stride.is_divisible(batch.row.tau[0])) {
        reachable_ = false;
        return;
      }
      if (done < count) {
        stride.shorten(batch.row.tau, done, errors.last);
      } else {
        stride.advance(batch.row.tau, errors);
      }
      if (done > 0) batch.near = batch.far_end(done - 1);
    }
    if (!interval.forward) turn_round(first, begin);
  }

  /// The residual of a piece over what is allowed, estimated; what share of it counts, and their product.
  template <class Number>
  struct Judgement {
    Number share, estimate, error;
  };
  template <class Number>
  [[nodiscard]] Judgement<Number> judge(const Number& length, const std::array<Number, 2>& residual) const {
    // A relative error of the speed over a piece moves its inside by less than that share of its length.
    const Number share = least(Number(1), (options_.delta * scale_ / negligible_) * length);
    const Number estimate = per_estimate_ * (residual_bound(residual) - residual_rounding);
    return {share, estimate, share * estimate};
  }

  /// How many pieces of a batch are accepted, the first of them, and their errors over what is allowed with
  /// that of the one behind them.
  template <std::size_t bytes>
  std::size_t count_accepted(const PieceFitter& fitter, std::size_t count, PieceBatch<bytes>& batch,
                             BatchErrors& errors) const {
    [[maybe_unused]] Judgement<Lanes<bytes>> all;
    if constexpr (lanes_are_quick) all = judge(batch.row.length, batch.row.residual);
    for (std::size_t i = 0; i < count; ++i) {
      Judgement<double> one;
      if constexpr (lanes_are_quick) {
        one = {all.share[i], all.estimate[i], all.error[i]};
      } else {
        one = judge(batch.row.length[i], {batch.row.residual[0][i], batch.row.residual[1][i]});
      }
      errors.last = one.error;
      if (options_.acceptance == Acceptance::certified && one.estimate <= 1) {
        errors.last = one.share * (fitter.certified_residual(batch, i) / (2 * options_.delta));
      }
      if (!(errors.last <= 1)) {
        if (!is_negligible(batch.row.length[i])) return i;
        errors.last = 0;
        straighten(fitter.interval(), batch, i);
      }
      if (i == 0) errors.first = errors.last;
      errors.worst = std::max(errors.worst, errors.last);
    }
    return count;
  }
  [[nodiscard]] bool is_negligible(double length) const { return length * scale_ <= negligible_; }
  /// A piece whose derivatives are useless is so short that a straight line does.
  template <std::size_t bytes>
  static void straighten(const AnchoredInterval& interval, PieceBatch<bytes>& batch, std::size_t index) {
    const double near = batch.near_end(index).tau;
    const double far = batch.row.tau[index];
    const std::array<double, 8> c{interval.t(interval.forward ? near : far), far - near};
    for (std::size_t i = 0; i < c.size(); ++i) batch.row.c[i].set(index, c[i]);
  }

  template <std::size_t bytes>
  void add_piece(const AnchoredInterval& interval, const PieceBatch<bytes>& batch, std::size_t index,
                 const TwoSum& anchor) {
    const TwoSum near = length_;
    length_.add(batch.row.length[index] * scale_);
    length_.renormalize();
    const TwoSum& begin = interval.forward ? near : length_;
    ArcPiece* const place = list_.add(begin.high);
    if (place == nullptr) return;
    ArcPiece& piece = *place;
    for (std::size_t k = 0; k < piece.c.size(); ++k) piece.c[k] = batch.row.c[k][index];
    piece.segment = segment_;
    using Kind = typename ArcPiece::Kind;
    if (interval.stands_still) {
      const double step = batch.row.step[index];
      piece.kind = interval.forward ? Kind::root_after : Kind::root_before;
      piece.inverse_step = 1 / (step * std::sqrt(scale_));
      piece.shift = (interval.forward ? batch.near_end(index).y : batch.row.y[index]) / step;
      piece.origin = anchor.high;
    } else {
      piece.kind = Kind::plain;
      piece.inverse_step = batch.row.step[index] > 0 ? batch.row.inverse_step[index] * inverse_scale_ : 0.0;
      piece.origin = begin.high;
      piece.shift = begin.low;
    }
  }

  /// The pieces from `first` on were added outward from an anchor that lies behind them: their
  /// distances are turned into those from the start of the path, and their order into that of t.
  void turn_round(std::size_t first, const TwoSum& begin) {
    const TwoSum outward = length_;
    length_ = begin;
    length_.add(outward.high);
    length_.low += outward.low;
    length_.renormalize();
    list_.reverse_from(first);
    std::size_t index = first;
    for (ArcPiece& piece : list_.pieces_from(first)) {
      const bool plain = piece.kind == ArcPiece::Kind::plain;
      TwoSum from_start = length_;
      from_start.add(-list_.begin(index));
      if (plain) from_start.low -= piece.shift;
      from_start.renormalize();
      list_.begin(index++) = from_start.high;
      piece.origin = plain ? from_start.high : length_.high;
      if (plain) piece.shift = from_start.low;
    }
  }

  ArcLengthOptions options_;
  double shortest_total_;
  double per_estimate_;
  double negligible_;
  PieceList list_;
  TwoSum length_;
  bool reachable_ = true;
  std::int32_t segment_ = 0;
  double scale_ = 1;
  double inverse_scale_ = 1;
};

}  // namespace inbetween
