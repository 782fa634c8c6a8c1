#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/path/arc_length.hpp"
#include "inbetween/path/path.hpp"
#include "inbetween/timing/frame_time.hpp"
#include "inbetween/timing/speed_profile.hpp"

/// A path travelled at a drawn speed in a given number of frames: what the real-time loop evaluates.

namespace inbetween {

inline constexpr std::int32_t max_frames = 1'000'000;

/// The place along the path and the speed, in weighted axis units and seconds.
template <Precise Real>
struct AlongPath {
  PathPoint<Real> point;
  Real speed = 0;         ///< unit/s
  Real acceleration = 0;  ///< unit/s^2
  Real jerk = 0;          ///< unit/s^3
};

/// One axis at one time, in axis units and seconds.
template <Precise Real>
struct AxisMotion {
  Real position = 0;
  Real velocity = 0;
  Real acceleration = 0;
  Real jerk = 0;
};

/// Derivatives of s in time, per second, second^2, second^3.
template <Precise Real>
struct ParameterRates {
  Real first = 0, second = 0, third = 0;
};

/// A key inside the path that is met on a frame by breaking the move there.
struct BreakKey {
  std::int32_t key = 0;
  std::int32_t frame = 0;
};

/// A stretch of the move between two breaks, where the speed may jump: the drawn curve with a K of its own.
template <Precise Real>
struct Portion {
  std::int32_t begin_frame = 0;
  Real constant = 0;    ///< K_k = L_k / (Phi(end) - Phi(begin))
  TwoSum<Real> offset;  ///< distance = offset + K_k Phi(a)
};

/// How s moves between two keys that have frames and no speed curve.
enum class Kinetic : std::uint8_t {
  linear,    ///< s in proportion to time
  monotone,  ///< s is a monotone spline of time, C1 (Fritsch and Butland 1984)
  curves,    ///< the path is made over the frames: every axis is a curve over time
};

/// One segment of a move timed by frames: t = u (c1 + u (c2 + u c3)), u from 0 to 1 over part `part` of
/// `parts` equal parts of the time between two keys.
template <Precise Real>
struct KeyInterval {
  std::int32_t begin_frame = 0;  ///< of the key before it
  std::int32_t frames = 1;       ///< from key to key
  std::int32_t part = 0;
  std::int32_t parts = 1;
  Real c1 = 1, c2 = 0, c3 = 0;

  /// The frame on which the segment begins, which need not be a whole one.
  [[nodiscard]] Real begin() const {
    return static_cast<Real>(begin_frame) + static_cast<Real>(part * frames) / static_cast<Real>(parts);
  }
  /// How many frames it lasts.
  [[nodiscard]] Real duration() const { return static_cast<Real>(frames) / static_cast<Real>(parts); }
  [[nodiscard]] Real u(const FrameTime<Real>& time) const {
    return (static_cast<Real>((time.frame - begin_frame) * parts - part * frames) +
            time.fraction * static_cast<Real>(parts)) /
           static_cast<Real>(frames);
  }

  /// Derivatives of t in time, at u.
  [[nodiscard]] ParameterRates<Real> rates(Real u, FrameRate fps) const {
    const Real rate = static_cast<Real>(fps.numerator) * static_cast<Real>(parts) /
                      (static_cast<Real>(fps.denominator) * static_cast<Real>(frames));
    return {rate * (c1 + u * (2 * c2 + u * (3 * c3))), rate * rate * (2 * c2 + 6 * u * c3),
            rate * rate * rate * (6 * c3)};
  }
};

/// A place on the speed curve: a = span + t.
template <Precise Real>
struct CurvePlace {
  std::int32_t span = 0;
  Real t = 0;
};

/// The way over one span of the drawn curve: begin + t (c[0] + c[1] t + c[2] t^2 + c[3] t^3), t from 0 to 1.
/// Within so short a span powers of t are as good as Bernstein's polynomials, and half the work.
template <Precise Real>
struct SpanDistance {
  TwoSum<Real> begin;  ///< the distance travelled at its start
  std::array<Real, 4> c{};

  [[nodiscard]] Real way(Real t) const { return t * ((c[0] + c[1] * t) + t * t * (c[2] + c[3] * t)); }
};

/// The memory of a track, owned by the caller. Only what the way of timing needs may be empty otherwise.
template <Precise Real>
struct TrackMemory {
  std::span<SpanDistance<Real>> span_distances = {};  ///< f + 1, for a drawn curve
  std::span<Portion<Real>> portions = {};             ///< breaks + 1
  std::span<KeyInterval<Real>> key_intervals = {};    ///< segments, for a move timed by frames
};

/// L(s) = K Phi(a), a = f frame / N: separable, so nothing is integrated and no K is searched for
/// (Bartels and Hardtke 1989, eq. for ds/da, in closed form). Refers to the memory of its parts.
template <Precise Real>
class Track {
 public:
  /// `frames` is N: the move lasts N / fps seconds and has N + 1 frames, 0..N.
  /// Errors: out_of_range (N not in 1..max_frames, N * f not below 2^31, fps not positive),
  /// no_distance (Phi(f) = 0 on a path with length), capacity. Cost: linear in f.
  static Result<Track> make(const Path<Real>& path, const ArcLength<Real>& arc_length,
                            const SpeedProfile<Real>& profile, std::int32_t frames, FrameRate fps,
                            const TrackMemory<Real>& memory);

  /// The paper's way with keys that have frames: the move is broken in two at each of them, portion k uses
  /// phi on its own interval of a with K_k = L_k / dPhi_k, and the speed jumps (Bartels and Hardtke 1989).
  /// `breaks` are in order of their keys, which lie inside the path, and of their frames.
  /// Errors: those of `make`; out_of_range (order, frames), no_distance (with the key where a portion ends).
  static Result<Track> make_with_breaks(const Path<Real>& path, const ArcLength<Real>& arc_length,
                                        const SpeedProfile<Real>& profile, std::int32_t frames, FrameRate fps,
                                        std::span<const BreakKey> breaks, const TrackMemory<Real>& memory);

  /// No speed curve: every key has its frame (Steketee and Badler 1985), the first 0, the last N; of a
  /// closed path one more, for the return to key 0. monotone: slopes by Fritsch and Butland's harmonic mean,
  /// at the first and last key their three-point formula, limited so that s never falls. curves: `path` was
  /// made over the same frames, and only there.
  /// Errors: wrong_count, out_of_range (first, last, order: with key and frame), capacity.
  static Result<Track> make_with_key_frames(const Path<Real>& path, const ArcLength<Real>& arc_length,
                                            std::span<const std::int32_t> key_frames, Kinetic kinetic,
                                            std::int32_t frames, FrameRate fps,
                                            const TrackMemory<Real>& memory);

  [[nodiscard]] const Path<Real>& path() const { return path_; }
  [[nodiscard]] const ArcLength<Real>& arc_length() const { return arc_length_; }
  /// Whether a drawn curve says how fast; otherwise the frames of the keys do, and profile(), constant()
  /// mean nothing.
  [[nodiscard]] bool has_profile() const { return key_intervals_.empty(); }
  [[nodiscard]] const SpeedProfile<Real>& profile() const { return profile_; }
  /// One for every segment of a move timed by frames, otherwise empty.
  [[nodiscard]] std::span<const KeyInterval<Real>> key_intervals() const { return key_intervals_; }
  /// Empty where one K holds for the whole move.
  [[nodiscard]] std::span<const Portion<Real>> portions() const { return portions_; }
  [[nodiscard]] std::int32_t frames() const { return frames_; }
  [[nodiscard]] FrameRate frame_rate() const { return fps_; }
  /// K = L / Phi(f); 0 for a path without length. With breaks each portion has its own instead.
  [[nodiscard]] Real constant() const { return constant_; }

  /// The place of a time on the drawn curve, a = (frame + fraction) f / N, with an exact integer phase: the
  /// digits of t do not wear off. Domain: 0 <= time <= N.
  [[nodiscard]] CurvePlace<Real> place(const FrameTime<Real>& time) const {
    const std::int32_t f = profile_.span_count();
    const std::int32_t scaled = time.frame * f;
    const std::int32_t span = scaled / frames_;
    CurvePlace<Real> result{
        span, (static_cast<Real>(scaled - span * frames_) + time.fraction * static_cast<Real>(f)) *
                  inverse_frames_};
    if (result.t >= 1 || time.frame >= frames_) [[unlikely]] {  // a fraction of a frame may pass over spans
      const auto whole = static_cast<std::int32_t>(result.t);
      result.span += whole;
      result.t -= static_cast<Real>(whole);
      if (result.span >= f) result = {f - 1, 1};
    }
    return result;
  }
  /// da/dt: spans of the drawn curve a second.
  [[nodiscard]] Real curve_rate() const { return curve_rate_; }

  /// The distance travelled since frame 0 as drawn. O(1). Domain: 0 <= time <= N.
  [[nodiscard]] TwoSum<Real> distance(const FrameTime<Real>& time) const {
    if (is_plain_) [[likely]]
      return distance_at(place(time));
    return special_distance(time);
  }

  /// The point of the path. Before frame 0 the start and after frame N the end, to the last bit.
  /// O(1), no allocation; the same bits on every target of one precision.
  [[nodiscard]] PathPoint<Real> locate(const FrameTime<Real>& time) const {
    // Negative frames are large ones here.
    if (static_cast<std::uint32_t>(time.frame) >= static_cast<std::uint32_t>(frames_)) [[unlikely]]
      return {time.frame < 0 ? 0 : path_.segment_count(), 0};
    if (is_plain_) [[likely]]
      return locate_at(place(time));
    return special_locate(time);
  }

  /// The position of every axis, in axis units: the tick. `out` has axis_count() entries. O(axes).
  void positions(const FrameTime<Real>& time, std::span<Real> out) const {
    const auto axes = static_cast<std::size_t>(path_.axis_count());
    // One question for all that is rare: locate() would ask the first again.
    const bool is_inside = static_cast<std::uint32_t>(time.frame) < static_cast<std::uint32_t>(frames_);
    if (is_inside && needs_nothing_more_) [[likely]] {
      const PathPoint<Real> point = locate_at(place(time));
      return write_values(path_.segment(point.segment), point.t, out.first(axes));
    }
    const PathPoint<Real> point = locate(time);
    write_values(path_.segment(point.segment), point.t, out.first(axes));
    if (path_.overshoots()) return;
    for (std::size_t d = 0; d < axes; ++d) out[d] = path_.kept(out[d], point.segment, d);
  }

  /// locate() at whole frames `first`, `first` + 1, ..., bit for bit, in runs of frames that share a span
  /// of the speed curve and a piece of the path. Domain: 0 <= first, first + points.size() - 1 <= N. Returns
  /// whether the points are known to be in order: rounding may put one before that in front of it.
  bool locate_frames(std::int32_t first, std::span<PathPoint<Real>> points) const;

  /// Point, speed and its derivatives along the path. After frame N and before frame 0: at rest.
  /// 0 for what is beyond the range of Real, which motion() reports, and for the derivatives of the speed of
  /// a move timed by frames where P' = 0.
  [[nodiscard]] AlongPath<Real> along(const FrameTime<Real>& time) const;

  /// Position, velocity, acceleration and jerk of every axis, analytically at (segment, t), not from
  /// the fitted inverse. On a key: the derivatives with which the motion leaves it, of keys in one place the
  /// last; at the end of the path, those with which it arrives. O(axes), no allocation.
  ///
  /// Returns the order of the highest derivative that is that of the motion. Positions always are. 3: all
  /// are. 1: within two roundings of the length from a point where P' = 0 (tension 1, a cusp, a line that
  /// turns back) the velocity is that of one side, the acceleration is that along the path only (across it
  /// there may be no bound), and the jerk is given as 0. 0: a derivative that has no bound, or is beyond the
  /// range of Real, is given as 0; a velocity has none where the weighted path stands still and is passed at
  /// a speed, while an axis of weight 0 moves on.
  std::uint8_t motion(const FrameTime<Real>& time, std::span<AxisMotion<Real>> out) const;
  /// The same of a track with a drawn speed at a place and a pace along the path.
  std::uint8_t motion_at(const AlongPath<Real>& where, std::span<AxisMotion<Real>> out) const;

 private:
  Track(const Path<Real>& path, const ArcLength<Real>& arc_length, const SpeedProfile<Real>& profile,
        std::int32_t frames, FrameRate fps)
      : path_(path),
        arc_length_(arc_length),
        profile_(profile),
        frames_(frames),
        fps_(fps),
        inverse_frames_(1 / static_cast<Real>(frames)),
        curve_rate_(static_cast<Real>(profile.span_count()) * static_cast<Real>(fps.numerator) /
                    (static_cast<Real>(frames) * static_cast<Real>(fps.denominator))),
        needs_nothing_more_(path.overshoots()) {}

  [[nodiscard]] TwoSum<Real> distance_at(const CurvePlace<Real>& place) const {
    const SpanDistance<Real>& span = span_distances_[static_cast<std::size_t>(place.span)];
    TwoSum<Real> sum = span.begin;
    sum.add(span.way(place.t));
    return sum;
  }
  [[nodiscard]] PathPoint<Real> locate_at(const CurvePlace<Real>& place) const {
    const SpanDistance<Real>& span = span_distances_[static_cast<std::size_t>(place.span)];
    return arc_length_.locate(span.begin, span.way(place.t));
  }
  /// along() of a drawn curve and of frames, with infinities where it is beyond the range of Real.
  [[nodiscard]] AlongPath<Real> along_profile(const FrameTime<Real>& time) const;
  [[nodiscard]] AlongPath<Real> along_key_frames(const FrameTime<Real>& time) const;
  [[nodiscard]] Real distance_rounding() const;
  [[gnu::always_inline]] inline std::uint8_t write_motion(const AlongPath<Real>& where,
                                                          std::span<AxisMotion<Real>> axes) const;
  std::uint8_t write_slow(AlongPath<Real> where, std::span<AxisMotion<Real>> axes) const;
  [[nodiscard]] TwoSum<Real> special_distance(const FrameTime<Real>& time) const;
  /// distance() of a drawn curve with breaks.
  [[nodiscard]] TwoSum<Real> broken_distance(const FrameTime<Real>& time) const;
  [[nodiscard]] PathPoint<Real> special_locate(const FrameTime<Real>& time) const;
  [[nodiscard]] PathPoint<Real> key_frame_point(const FrameTime<Real>& time) const;
  [[nodiscard]] const Portion<Real>& portion_at(std::int32_t frame) const;
  [[nodiscard]] std::size_t interval_at(const FrameTime<Real>& time) const;
  [[nodiscard]] ParameterRates<Real> key_frame_rates(const FrameTime<Real>& time) const;
  [[nodiscard]] bool is_outside(const FrameTime<Real>& time) const {
    return time.frame < 0 || time.frame > frames_ || (time.frame == frames_ && time.fraction > 0);
  }

  Path<Real> path_;
  ArcLength<Real> arc_length_;
  SpeedProfile<Real> profile_;
  std::span<const SpanDistance<Real>> span_distances_;
  std::span<const Portion<Real>> portions_;
  std::span<const KeyInterval<Real>> key_intervals_;
  std::int32_t frames_ = 0;
  FrameRate fps_;
  Real inverse_frames_ = 0;
  Real curve_rate_ = 0;
  Real constant_ = 0;
  bool is_plain_ = true;             ///< one drawn curve, no breaks: the way that must be quick
  bool needs_nothing_more_ = false;  ///< plain, and positions need no Path::kept()
};

/// Memory of a track with up to `Keys` keys, `Axes` axes, `Values` control values.
template <Precise Real, std::size_t Keys, std::size_t Axes, std::size_t Values,
          std::size_t Pieces = 24 * Keys>
struct TrackStorage {
  PathStorage<Real, Keys, Axes> path;
  ArcLengthStorage<Real, Keys, Pieces> arc_length;
  SpeedProfileStorage<Real, Values> profile;
  std::array<SpanDistance<Real>, (Values > 1 ? Values : 2)> span_distances;

  [[nodiscard]] TrackMemory<Real> memory() { return {span_distances}; }
};

/// The frame, which need not be a whole one, on which a segment of the path begins; of segment_count the end.
/// Keys in one place have the frame of the first. O(log N) and a bisection in time.
template <Precise Real>
Real frame_of_segment(const Track<Real>& track, std::int32_t segment);

extern template class Track<double>;
extern template class Track<float>;

}  // namespace inbetween
