#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "base/interval.hpp"
#include "inbetween/base/bisection.hpp"
#include "inbetween/timing/track.hpp"
#include "length_from_anchor.hpp"
#include "path/segment_speed.hpp"
#include "timing/lock_share.hpp"

/// A move cut into stretches of time on which it is one smooth function: one segment, one span.

namespace inbetween {

/// A stretch of time on which the speed is one polynomial in x >= 0. For a drawn curve x is measured in spans
/// of it, forward or backward in time (then `frames` and `seconds` are below 0), and the speed is that along
/// the path in unit/s; for a move timed by frames x runs from key to key and the speed is that of the
/// parameter, in 1/s.
template <Precise Real>
struct TimePiece {
  Real first_frame = 0;  ///< at x = 0
  Real frames = 1;       ///< from x = 0 to x = 1
  Real seconds = 1;      ///< the same
  std::array<Real, 4> speed{};
  std::array<Real, 3> change{};         ///< d speed / d time
  std::array<Real, 2> second_change{};  ///< d change / d time

  [[nodiscard]] Real frame(Real x) const { return first_frame + x * frames; }
  void differentiate() {
    change = derivative(speed, 1 / seconds);
    second_change = derivative(change, 1 / seconds);
  }
  /// The integral of the speed over the time from 0 to x.
  [[nodiscard]] Real distance(Real x) const {
    return std::fabs(seconds) * x * (speed[0] + x * (speed[1] / 2 + x * (speed[2] / 3 + x * (speed[3] / 4))));
  }
};

/// A stretch of the path, seen from its anchor (segment_speed.hpp).
template <Precise Real>
struct PathPiece {
  std::int32_t segment = 0;
  std::int32_t index = 0;  ///< within the segment
  Real scale = 1;          ///< of its speed: a power of two
  AnchoredInterval<Real> interval;

  [[nodiscard]] Real end_t() const {
    return interval.forward ? interval.anchor + interval.extent : interval.anchor;
  }
  /// tau where the piece is entered and where it is left.
  [[nodiscard]] Real tau_entry() const { return interval.forward ? Real(0) : interval.extent; }
  [[nodiscard]] Real tau_exit() const { return interval.forward ? interval.extent : Real(0); }
  /// tau of a point, within the piece.
  [[nodiscard]] Real tau(const PathPoint<Real>& point) const {
    const Real t = point.segment == segment ? point.t : Real(point.segment < segment ? 0 : 1);
    return std::clamp(interval.tau(t), Real(0), interval.extent);
  }
  /// |P'| at a tau, in the units of the path.
  [[nodiscard]] Real speed(Real tau) const {
    return scale * std::sqrt(std::max(interval.speed_squared.value(tau), Real(0)));
  }
  /// The length between two tau that are no further apart than a piece of the inverse of arc length.
  [[nodiscard]] Real length(Real from, Real to) const {
    return mean_of([this](Real tau) { return speed(tau); }, from, to - from) * std::fabs(to - from);
  }
};

/// A stretch of both, seen from that of its ends at which the place is known best: x from 0 to `end`, the
/// path from `tau_begin` to `tau_end`. Where the path is slowest at that end, tau is known to so many digits
/// of itself (is_anchored).
template <Precise Real>
struct Stretch {
  const TimePiece<Real>& time;
  const PathPiece<Real>& path;
  Real end = 1;
  Real tau_begin = 0;
  Real tau_end = 0;
  TwoSum<Real> distance = {};  ///< at x = 0
  bool is_anchored = false;
  /// The part of it on the frames that are asked for, from `from` to `to`.
  Real from = 0, to = 0;
  Real tau_from = 0, tau_to = 0;

  /// The best place to divide a part of it: what happens beside an anchor may last very short.
  [[nodiscard]] Real divide(Real low, Real high) const {
    return is_anchored && low <= 0 ? high / 16 : low + (high - low) / 2;
  }
};

/// Calls visit(Stretch) for the stretches of a track in order of time that have a part on the frames
/// `frames`. What does not move is left out.
///
/// A key that lies on the first or the last of these frames within what a lock promises is met there: the
/// way beside it that belongs to the other side of the key is left out.
///
/// A key or a place inside a segment where the path stands still is met at rest where the curve comes to rest
/// at it, and a portion ends at its key, though the distances are a rounding or a lock's tolerance apart:
/// otherwise the motion would pass the key at next to no speed instead, and a path that turns there would
/// need an acceleration without bound.
template <Precise Real>
class StretchWalk {
 public:
  StretchWalk(const Track<Real>& track, const WholeFrames& frames)
      : track_(track),
        frames_(frames),
        frame_seconds_(static_cast<Real>(track.frame_rate().denominator) /
                       static_cast<Real>(track.frame_rate().numerator)) {}

  template <class Visit>
  void run(const Visit& visit) {
    segment_ = -1;
    lag_ = 0;
    next_segment();
    if (track_.has_profile()) {
      for (std::int32_t i = 0; i < track_.profile().span_count(); ++i) walk_span(i, visit);
      return;
    }
    for (const KeyInterval<Real>& interval : track_.key_intervals()) {
      const TimePiece<Real> time = piece_of(interval);
      visit_part(Stretch<Real>{time, path_, Real(1), Real(0), Real(1)}, visit);
      next_segment();
    }
  }

  /// The tau of the piece at which the motion is at x.
  [[nodiscard]] Real tau_at(const Stretch<Real>& stretch, Real x) const {
    const PathPiece<Real>& path = stretch.path;
    if (!track_.has_profile()) return std::clamp(stretch.time.distance(x), Real(0), Real(1));
    if (x <= 0) return stretch.tau_begin;
    if (x >= stretch.end) return stretch.tau_end;
    const Real passed = stretch.time.distance(x);
    TwoSum<Real> distance = stretch.distance;
    distance.add(stretch.time.seconds > 0 ? passed : -passed);
    if (stretch.is_anchored && passed < near_share * track_.arc_length().total()) {
      const LengthFromAnchor<Real> length(path.interval);
      return length.inverse(passed / path.scale, path.tau(track_.arc_length().locate(distance)));
    }
    return tau_of(path, distance);
  }

 private:
  /// Nearer than this share of the length to a place where the path is slow, the sum of the lengths from its
  /// start has too few digits.
  static constexpr Real near_share = Real(1e-4);

  /// A span of the drawn curve, or the part of it that belongs to one portion.
  struct CurvePart {
    const SpeedSpan<Real>& span;
    Real begin = 0, end = 1;
    Real first_frame = 0;
    Real frames = 1;
    Real seconds = 1;
    Real constant = 0;
    bool ends_at_key = false;            ///< if it ends near one
    TwoSum<Real> travelled_before = {};  ///< by the curve, at `begin`
    TwoSum<Real> distance_before = {};   ///< the same of the motion
    Real stretch = 1;                    ///< distances of the motion over those of the curve

    [[nodiscard]] Real frame(Real x) const { return first_frame + x * frames; }
    /// As seen from x, forward or backward in time. Where the curve is 0 at either end of the span, the
    /// coefficients are 0 to the last bit.
    [[nodiscard]] TimePiece<Real> seen_from(Real x, bool forward) const {
      const bool from_begin = x <= Real(0.5);
      const auto [b0, b1, b2, b3] = from_begin ? span : SpeedSpan<Real>{span.b3, span.b2, span.b1, span.b0};
      std::array<Real, 4> c{b0, 3 * (b1 - b0), 3 * ((b2 - b1) - (b1 - b0)), (b3 - b0) - 3 * (b2 - b1)};
      const Real shift = from_begin ? x : 1 - x;
      for (std::size_t i = 0; shift > 0 && i < 3; ++i) {
        for (std::size_t j = 3; j-- > i;) c[j] += shift * c[j + 1];
      }
      TimePiece<Real> piece;
      piece.first_frame = frame(x);
      piece.frames = forward ? frames : -frames;
      piece.seconds = forward ? seconds : -seconds;
      for (std::size_t k = 0; k < c.size(); ++k) {
        const bool turned = forward != from_begin && k % 2 == 1;
        piece.speed[k] = constant / seconds * (turned ? -c[k] : c[k]);
      }
      piece.differentiate();
      return piece;
    }
    [[nodiscard]] bool begins_at_rest() const { return span.b0 == 0 && begin == 0; }
    [[nodiscard]] bool ends_at_rest() const { return span.b3 == 0 && end == 1; }
    [[nodiscard]] bool moves() const { return span.b0 > 0 || span.b1 > 0 || span.b2 > 0 || span.b3 > 0; }
  };

  template <class Visit>
  void walk_span(std::int32_t index, const Visit& visit) {
    const std::int32_t f = track_.profile().span_count();
    const SpeedSpan<Real>& span = track_.profile().span(index);
    CurvePart part{.span = span};
    part.frames = static_cast<Real>(track_.frames()) / static_cast<Real>(f);
    part.first_frame = static_cast<Real>(index) * static_cast<Real>(track_.frames()) / static_cast<Real>(f);
    part.seconds = part.frames * frame_seconds_;
    const std::span<const Portion<Real>> portions = track_.portions();
    for (std::size_t i = 0; i < std::max<std::size_t>(portions.size(), 1); ++i) {
      part.constant = portions.empty() ? track_.constant() : portions[i].constant;
      part.begin = 0;
      part.end = 1;
      part.ends_at_key = span.b3 == 0 || index + 1 == f;
      const auto x_of = [&](std::int32_t frame) {
        return (static_cast<Real>(frame) - part.first_frame) / part.frames;
      };
      if (!portions.empty()) part.begin = std::max(part.begin, x_of(portions[i].begin_frame));
      if (i + 1 < portions.size()) {
        const Real end = x_of(portions[i + 1].begin_frame);
        part.ends_at_key = part.ends_at_key || end <= 1;
        part.end = std::min(part.end, end);
      }
      if (part.begin < part.end && part.moves()) walk_part(part, index + 1 == f && part.end >= 1, visit);
    }
  }

  template <class Visit>
  void walk_part(CurvePart& part, bool is_last, const Visit& visit) {
    part.travelled_before = distance_of_curve(part, part.begin);
    part.distance_before = part.travelled_before;
    part.distance_before.add(lag_);
    part.stretch = 1;
    if (part.begins_at_rest()) skip_to_standstill(part);
    const std::int32_t met = part.ends_at_key ? key_met_at_end(part, is_last) : 0;
    const Real margin = lock_share<Real> * track_.arc_length().total();
    Real begin = part.begin;
    while (segment_ < track_.path().segment_count()) {
      const bool is_last_piece = path_.index + 1 == static_cast<std::int32_t>(split_.count);
      const Real missing = end_distance_.minus(distance_at(part, part.end));
      const bool rests_before_key =
          met == segment_ + 1 && part.ends_at_rest() && ends_at_standstill(path_.interval);
      const bool rests_inside = (met == 0 || rests_before_key) && part.ends_at_key && !is_last_piece &&
                                std::fabs(missing) <= margin;
      const bool leaves = segment_ < met || rests_inside || missing < 0;
      const bool is_met = rests_inside || (segment_ + 1 == met && is_last_piece);
      const Real end = is_met || !leaves ? part.end : crossing(part, begin);
      if (end > begin) {
        visit_between(part, begin, end, leaves, visit);
      } else if (leaves) {
        visit_in_no_time(part, visit);
      }
      if (!leaves) return;
      if (rests_inside && met == 0) lag_ += missing;
      begin = end;
      do next_path_piece();
      while (rests_inside && segment_ + 1 == met);
      if (rests_inside) return;
    }
  }

  /// A rest is at the place beside its key where the path stands still, if both are one to a lock.
  void skip_to_standstill(CurvePart& part) {
    const Real margin = lock_share<Real> * track_.arc_length().total();
    if (segment_ >= track_.path().segment_count() || !is_entered_) return;
    for (auto index = static_cast<std::size_t>(path_.index); index + 1 < split_.count; ++index) {
      const AnchoredInterval<Real>& interval = split_.intervals[index];
      const Real end = interval.forward ? interval.anchor + interval.extent : interval.anchor;
      const Real way = track_.arc_length().distance(track_.path(), {segment_, end}).minus(begin_distance_);
      if (!(way <= margin)) return;
      if (!ends_at_standstill(interval)) continue;
      part.distance_before.add(way);
      lag_ += way;
      while (static_cast<std::size_t>(path_.index) <= index) next_path_piece();
      return;
    }
  }
  [[nodiscard]] static bool ends_at_standstill(const AnchoredInterval<Real>& interval) {
    return interval.stands_still && !interval.forward;
  }

  /// The key that is met at the end of a part, 0 for none; the part is stretched so that it is met exactly.
  std::int32_t key_met_at_end(CurvePart& part, bool is_last) {
    const Real margin = lock_share<Real> * track_.arc_length().total();
    const auto before = [&](std::int32_t key) {
      return track_.arc_length().segment_begin(key).minus(distance_of_curve(part, part.end));
    };
    const std::int32_t last = track_.path().segment_count();
    std::int32_t key = is_last ? last : segment_ + 1;
    while (key < last && before(key) < -margin) ++key;
    if (key > last || (!is_last && before(key) > margin)) return 0;
    const TwoSum<Real> end = distance_of_curve(part, part.end);
    const TwoSum<Real>& asked = track_.arc_length().segment_begin(key);
    const Real stretch = asked.minus(part.distance_before) / end.minus(part.travelled_before);
    if (stretch > Real(0.5) && stretch < 2) part.stretch = stretch;  // not of a part that hardly moves
    lag_ = asked.minus(end);
    return key;
  }

  /// From its end if it leaves the piece there and did not enter it at its beginning, or is slower there.
  template <class Visit>
  void visit_between(const CurvePart& part, Real begin, Real end, bool leaves, const Visit& visit) {
    const bool backward = leaves && (!is_entered_ || !path_.interval.forward);
    const TimePiece<Real> time = part.seen_from(backward ? end : begin, !backward);
    const auto tau = [&](bool is_border, Real at_border, Real x) {
      return is_border ? at_border : tau_of(path_, distance_at(part, x));
    };
    const Real entry = tau(is_entered_, path_.tau_entry(), begin);
    const Real exit = tau(leaves, path_.tau_exit(), end);
    const Real from = backward ? exit : entry;
    const bool from_border = backward ? leaves : is_entered_;
    const TwoSum<Real> distance = backward      ? end_distance_
                                  : is_entered_ ? begin_distance_
                                                : distance_at(part, begin);
    visit_part(
        Stretch<Real>{time, path_, end - begin, from, backward ? entry : exit, distance,
                      from_border && from <= 0 && path_.interval.speed_squared.q[0] < slow_share<Real>},
        visit);
    is_entered_ = false;
  }

  /// The motion ends at the end of the path, exactly; the distance of the last frame may be a rounding short
  /// of it.
  template <class Visit>
  void visit_in_no_time(const CurvePart& part, const Visit& visit) {
    const TimePiece<Real> time = part.seen_from(part.end, false);
    if (time.speed[0] == 0) return;
    const Real entry = is_entered_ ? path_.tau_entry() : tau_of(path_, distance_at(part, part.end));
    visit_part(Stretch<Real>{time, path_, Real(0), path_.tau_exit(), entry, end_distance_}, visit);
  }

  /// Visits a stretch if it has a part on the frames that are asked for.
  template <class Visit>
  void visit_part(Stretch<Real> stretch, const Visit& visit) const {
    stretch.to = stretch.end;
    if (frames_.first > 0) cut(stretch, frames_.first, true);
    if (frames_.last < track_.frames()) cut(stretch, frames_.last, false);
    const bool is_behind = stretch.end == 0 && frames_.last < track_.frames();
    if (is_behind || (stretch.end > 0 && stretch.to <= stretch.from) || is_beside_key(stretch)) return;
    stretch.tau_from = stretch.from > 0 ? tau_at(stretch, stretch.from) : stretch.tau_begin;
    stretch.tau_to = stretch.to < stretch.end ? tau_at(stretch, stretch.to) : stretch.tau_end;
    visit(stretch);
  }
  /// The x of a frame, which may be outside.
  [[nodiscard]] static Real x_of(const Stretch<Real>& stretch, std::int32_t frame) {
    return (static_cast<Real>(frame) - stretch.time.first_frame) / stretch.time.frames;
  }
  /// Keeps of a part what is later than a frame, or what is earlier.
  static void cut(Stretch<Real>& stretch, std::int32_t frame, bool keeps_later) {
    const Real x = std::clamp(x_of(stretch, frame), Real(0), stretch.end);
    if (keeps_later == (stretch.time.frames > 0)) {
      stretch.from = std::max(stretch.from, x);
    } else {
      stretch.to = std::min(stretch.to, x);
    }
  }
  /// A part between a key and the frame of a cut that is no longer than what a lock may be off by: they are
  /// one.
  [[nodiscard]] bool is_beside_key(const Stretch<Real>& stretch) const {
    if (!track_.has_profile()) return false;
    const auto is_at = [&](std::int32_t frame) {
      const Real x = x_of(stretch, frame);
      const Real outside = std::fabs((x - std::clamp(x, Real(0), stretch.end)) * stretch.time.frames);
      return outside <= lock_share<Real> * static_cast<Real>(track_.frames());
    };
    const bool is_at_cut = (frames_.first > 0 && is_at(frames_.first)) ||
                           (frames_.last < track_.frames() && is_at(frames_.last));
    if (!is_at_cut) return false;
    const Real way = stretch.time.distance(stretch.to) - stretch.time.distance(stretch.from);
    return way <= lock_share<Real> * track_.arc_length().total();
  }

  [[nodiscard]] TimePiece<Real> piece_of(const KeyInterval<Real>& interval) const {
    TimePiece<Real> piece;
    piece.frames = interval.duration();
    piece.first_frame = interval.begin();
    piece.seconds = piece.frames * frame_seconds_;
    piece.speed = {interval.c1 / piece.seconds, 2 * interval.c2 / piece.seconds,
                   3 * interval.c3 / piece.seconds, 0};
    piece.differentiate();
    return piece;
  }

  /// The x, to the last bit, at which the piece of the path is left.
  [[nodiscard]] Real crossing(const CurvePart& part, Real begin) const {
    constexpr int halvings = std::numeric_limits<Real>::digits + 8;
    const auto beyond = [&](Real x) { return distance_at(part, x).minus(end_distance_); };
    const auto is_before = [](Real way) { return !(way > 0); };
    if (!track_.portions().empty()) {
      // Sums that are much larger than the way have a rounding that is, too.
      const auto is_before_at = [&](Real x) { return is_before(beyond(x)); };
      return bisected<Real>({begin, part.end}, halvings, is_before_at).high;
    }
    const auto slope = [&](Real x) { return part.constant * part.stretch * part.span.value(x); };
    const Real rounding = distance_rounding<Real> * part.constant * part.span.integral();
    return bisected_near_zero<Real>({begin, part.end}, halvings, rounding, beyond, slope, is_before).high;
  }

  [[nodiscard]] TwoSum<Real> distance_of_curve(const CurvePart& part, Real x) const {
    const Real frame = std::clamp(part.frame(x), Real(0), static_cast<Real>(track_.frames()));
    const auto whole = static_cast<std::int32_t>(frame);
    return track_.distance({whole, frame - static_cast<Real>(whole)});
  }
  [[nodiscard]] TwoSum<Real> distance_at(const CurvePart& part, Real x) const {
    TwoSum<Real> distance = part.distance_before;
    distance.add(distance_of_curve(part, x).minus(part.travelled_before) * part.stretch);
    return distance;
  }
  /// The fitted inverse, brought nearer by a Newton step with the full length.
  [[nodiscard]] Real tau_of(const PathPiece<Real>& path, const TwoSum<Real>& distance) const {
    const ArcLength<Real>& arc_length = track_.arc_length();
    const std::optional<std::size_t> index = arc_length.piece_of(distance);
    if (!index || arc_length.pieces()[*index].segment != path.segment) {
      return path.tau(arc_length.locate(distance));
    }
    const ArcPiece<Real>& piece = arc_length.pieces()[*index];
    const Real t = piece.t_at(piece.offset(distance));
    const Real length = path.length(path.interval.tau(piece.c[0]), path.interval.tau(t));
    const Real missing = distance.minus(arc_length.begin_of(*index)) - length;
    const Real nearer = t + missing / path.speed(path.interval.tau(t));
    return path.tau({path.segment, nearer > 0 && nearer < 1 ? nearer : t});
  }

  void next_path_piece() {
    if (++path_.index < static_cast<std::int32_t>(split_.count)) {
      show_piece();
    } else {
      next_segment();
    }
  }
  /// The next segment that has a length. Timed by frames every segment is one piece.
  void next_segment() {
    while (++segment_ < track_.path().segment_count()) {
      path_.segment = segment_;
      path_.index = 0;
      if (!track_.has_profile()) {
        path_.interval = {};
        return;
      }
      const SegmentSpeed<Real> speed(track_.path().segment(segment_), track_.path().weights());
      if (speed.is_still()) continue;
      split_ = split_where_slow(speed);
      path_.scale = std::ldexp(Real(1), speed.exponent());
      end_distance_ = track_.arc_length().segment_begin(segment_);
      show_piece();
      return;
    }
  }
  void show_piece() {
    is_entered_ = true;
    begin_distance_ = end_distance_;
    path_.interval = split_.intervals[static_cast<std::size_t>(path_.index)];
    const bool is_last = path_.index + 1 == static_cast<std::int32_t>(split_.count);
    end_distance_ = is_last ? track_.arc_length().segment_begin(segment_ + 1)
                            : track_.arc_length().distance(track_.path(), {segment_, path_.end_t()});
  }

  const Track<Real>& track_;
  WholeFrames frames_;
  Real frame_seconds_;
  std::int32_t segment_ = -1;
  PathPiece<Real> path_;
  AnchoredIntervals<Real> split_;
  TwoSum<Real> begin_distance_;
  TwoSum<Real> end_distance_;
  Real lag_ = 0;            ///< by how much the key that was met last is further than the curve came
  bool is_entered_ = true;  ///< nothing of the piece has been visited
};

}  // namespace inbetween
