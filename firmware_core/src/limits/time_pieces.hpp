#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/interval.hpp"
#include "inbetween/timing/track.hpp"
#include "path/segment_speed.hpp"

/// A move cut into stretches of time on which it is one smooth function: one segment, one span.

namespace inbetween {

/// A stretch of time on which the speed is one polynomial in x, x from `begin` to `end`. For a drawn curve x
/// runs over a span of it and the speed is that along the path in unit/s; for a move timed by frames x runs
/// from key to key and the speed is that of the parameter, in 1/s.
template <Precise Real>
struct TimePiece {
  Real begin = 0;
  Real end = 1;
  Real first_frame = 0;  ///< at x = 0
  Real frames = 1;       ///< from x = 0 to x = 1
  Real seconds = 1;      ///< the same
  std::array<Real, 4> speed{};
  std::array<Real, 3> change{};  ///< d speed / d time
  std::array<Real, 2> bend{};    ///< d change / d time

  [[nodiscard]] Real frame(Real x) const { return first_frame + x * frames; }
  void differentiate() {
    change = derivative(speed, 1 / seconds);
    bend = derivative(change, 1 / seconds);
  }
};

/// A stretch of the path, seen from its anchor (segment_speed.hpp).
template <Precise Real>
struct PathPiece {
  std::int32_t segment = 0;
  std::int32_t index = 0;  ///< within the segment
  int exponent = 0;        ///< of the scale of its speed
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
    const Real raw = interval.forward ? t - interval.anchor : interval.anchor - t;
    return std::clamp(raw, Real(0), interval.extent);
  }
};

/// A stretch of both: x from `begin` to `end`.
template <Precise Real>
struct Stretch {
  const TimePiece<Real>& time;
  const PathPiece<Real>& path;
  Real begin = 0;
  Real end = 1;
  Real tau_begin = 0;
  Real tau_end = 0;
};

/// Calls visit(Stretch) for the stretches of a track in order of time, from frame 0 to N.
template <Precise Real>
class StretchWalk {
 public:
  explicit StretchWalk(const Track<Real>& track)
      : track_(track),
        frame_seconds_(static_cast<Real>(track.frame_rate().denominator) /
                       static_cast<Real>(track.frame_rate().numerator)) {}

  template <class Visit>
  void run(const Visit& visit) {
    segment_ = -1;
    next_segment();
    if (track_.has_profile()) {
      for (std::int32_t i = 0; i < track_.profile().span_count(); ++i) walk_span(i, visit);
      finish(visit);
      return;
    }
    for (const KeyInterval<Real>& interval : track_.key_intervals()) {
      walk_piece(piece_of(interval), visit);
      next_segment();
    }
  }

  /// Where the motion as asked is at x, as tau of the piece: the fitted inverse, brought nearer by a Newton
  /// step with the full length.
  [[nodiscard]] Real tau_at(const TimePiece<Real>& time, const PathPiece<Real>& path, Real x) const {
    if (!track_.has_profile()) return path.tau({path.segment, parameter(time, x)});
    const TwoSum<Real> distance = distance_at(time, x);
    PathPoint<Real> point = track_.arc_length().locate(distance);
    if (point.segment == path.segment) {
      const Real missing = distance.minus(track_.arc_length().distance(track_.path(), point));
      const Real t = point.t + missing / track_.path().parametric_speed(point);
      if (t > 0 && t < 1) point.t = t;
    }
    return path.tau(point);
  }

 private:
  template <class Visit>
  void walk_span(std::int32_t index, const Visit& visit) {
    const auto f = static_cast<Real>(track_.profile().span_count());
    const SpeedSpan<Real>& span = track_.profile().span(index);
    TimePiece<Real> piece;
    piece.frames = static_cast<Real>(track_.frames()) / f;
    piece.first_frame = static_cast<Real>(index) * static_cast<Real>(track_.frames()) / f;
    piece.seconds = piece.frames * frame_seconds_;
    const std::array<Real, 4> phi{span.b0, 3 * (span.b1 - span.b0),
                                  3 * ((span.b2 - span.b1) - (span.b1 - span.b0)),
                                  (span.b3 - span.b0) - 3 * (span.b2 - span.b1)};
    const std::span<const Portion<Real>> portions = track_.portions();
    for (std::size_t i = 0; i < std::max<std::size_t>(portions.size(), 1); ++i) {
      const Real constant = portions.empty() ? track_.constant() : portions[i].constant;
      piece.begin = 0;
      piece.end = 1;
      if (!portions.empty()) {
        const auto x_of = [&](std::int32_t frame) {
          return (static_cast<Real>(frame) - piece.first_frame) / piece.frames;
        };
        piece.begin = std::max(piece.begin, x_of(portions[i].begin_frame));
        if (i + 1 < portions.size()) piece.end = std::min(piece.end, x_of(portions[i + 1].begin_frame));
      }
      if (!(piece.begin < piece.end)) continue;
      for (std::size_t k = 0; k < phi.size(); ++k) piece.speed[k] = constant / piece.seconds * phi[k];
      piece.differentiate();
      last_time_ = piece;
      walk_piece(piece, visit);
    }
  }

  /// The motion ends at the end of the path, exactly; the distance of the last frame may be a rounding short
  /// of it. What is left of the path is passed in no time.
  template <class Visit>
  void finish(const Visit& visit) {
    const Real x = last_time_.end;
    while (segment_ < track_.path().segment_count()) {
      const Real tau = is_entered_ ? path_.tau_entry() : tau_at(last_time_, path_, x);
      visit(Stretch<Real>{last_time_, path_, x, x, tau, path_.tau_exit()});
      next_path_piece();
    }
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

  template <class Visit>
  void walk_piece(const TimePiece<Real>& time, const Visit& visit) {
    Real begin = time.begin;
    while (begin < time.end && segment_ < track_.path().segment_count()) {
      const bool leaves = has_passed(time, time.end);
      const Real end = leaves ? crossing(time, begin) : time.end;
      if (end > begin) {
        visit(Stretch<Real>{time, path_, begin, end,
                            is_entered_ ? path_.tau_entry() : tau_at(time, path_, begin),
                            leaves ? path_.tau_exit() : tau_at(time, path_, end)});
        is_entered_ = false;
      }
      begin = end;
      if (!leaves || !track_.has_profile()) return;
      next_path_piece();
    }
  }

  /// Whether the motion is behind the path's piece at x.
  [[nodiscard]] bool has_passed(const TimePiece<Real>& time, Real x) const {
    if (!track_.has_profile()) return false;
    return distance_at(time, x).minus(end_distance_) > 0;
  }
  /// The x, to the last bit, at which the piece of the path is left.
  [[nodiscard]] Real crossing(const TimePiece<Real>& time, Real begin) const {
    Real low = begin;
    Real high = time.end;
    for (int i = 0; i < std::numeric_limits<Real>::digits + 8; ++i) {
      const Real middle = low + (high - low) / 2;
      if (middle <= low || middle >= high) break;
      (has_passed(time, middle) ? high : low) = middle;
    }
    return high;
  }

  [[nodiscard]] TwoSum<Real> distance_at(const TimePiece<Real>& time, Real x) const {
    const Real frame = std::clamp(time.frame(x), Real(0), static_cast<Real>(track_.frames()));
    const auto whole = static_cast<std::int32_t>(frame);
    return track_.distance({whole, frame - static_cast<Real>(whole)});
  }
  [[nodiscard]] Real parameter(const TimePiece<Real>& time, Real x) const {
    // The speed is the derivative of t = x (c1 + x (c2 + x c3)).
    const Real t = time.seconds * x * (time.speed[0] + x * (time.speed[1] / 2 + x * time.speed[2] / 3));
    return std::clamp(t, Real(0), Real(1));
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
        is_entered_ = true;
        return;
      }
      const SegmentSpeed<Real> speed(track_.path().segment(segment_), track_.path().weights());
      if (speed.is_still()) continue;
      split_ = split_where_slow(speed);
      path_.exponent = speed.exponent();
      show_piece();
      return;
    }
  }
  void show_piece() {
    is_entered_ = true;
    path_.interval = split_.intervals[static_cast<std::size_t>(path_.index)];
    const bool is_last = path_.index + 1 == static_cast<std::int32_t>(split_.count);
    end_distance_ = is_last ? track_.arc_length().segment_begin(segment_ + 1)
                            : track_.arc_length().distance(track_.path(), {segment_, path_.end_t()});
  }

  const Track<Real>& track_;
  Real frame_seconds_;
  std::int32_t segment_ = -1;
  PathPiece<Real> path_;
  AnchoredIntervals<Real> split_;
  TwoSum<Real> end_distance_;
  TimePiece<Real> last_time_;
  bool is_entered_ = true;  ///< nothing of the piece has been visited
};

}  // namespace inbetween
