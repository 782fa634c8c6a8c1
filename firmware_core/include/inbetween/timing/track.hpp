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
struct AlongPath {
  PathPoint point;
  double speed = 0;         ///< unit/s
  double acceleration = 0;  ///< unit/s^2
  double jerk = 0;          ///< unit/s^3
};

/// One axis at one time, in axis units and seconds.
struct AxisMotion {
  double position = 0;
  double velocity = 0;
  double acceleration = 0;
  double jerk = 0;
};

/// Derivatives of s in time, per second, second^2, second^3.
struct ParameterRates {
  double first = 0, second = 0, third = 0;
};

/// A key inside the path that is met on a frame by breaking the move there.
struct BreakKey {
  std::int32_t key = 0;
  std::int32_t frame = 0;
};

/// A stretch of the move between two breaks, where the speed may jump: the drawn curve with a K of its own.
struct Portion {
  std::int32_t begin_frame = 0;
  double constant = 0;  ///< K_k = L_k / (Phi(end) - Phi(begin))
  TwoSum offset;        ///< distance = offset + K_k Phi(a)
};

/// How s moves between two keys that have frames and no speed curve.
enum class Kinetic : std::uint8_t {
  linear,    ///< s in proportion to time
  monotone,  ///< s is a monotone spline of time, C1 (Fritsch and Butland 1984)
  curves,    ///< the path is made over the frames: every axis is a curve over time
};

/// One segment of a move timed by frames: t = u (c1 + u (c2 + u c3)), u from 0 to 1 over its time. That is
/// exact: whole numbers of equal parts of a frame.
struct KeyInterval {
  std::int32_t begin_frame = 0;  ///< of the key before it
  std::int32_t parts = 1;        ///< of a frame
  std::int32_t begin = 0;        ///< so many parts behind begin_frame
  std::int32_t length = 1;       ///< so many parts
  double c1 = 1, c2 = 0, c3 = 0;

  /// The frame on which the segment begins, which need not be a whole one.
  [[nodiscard]] FrameTime begin_time() const {
    return {begin_frame + begin / parts, static_cast<double>(begin % parts) / static_cast<double>(parts)};
  }
  [[nodiscard]] double u(const FrameTime& time) const {
    return (static_cast<double>((time.frame - begin_frame) * parts - begin) +
            time.fraction * static_cast<double>(parts)) /
           static_cast<double>(length);
  }

  /// Derivatives of t in time, at u.
  [[nodiscard]] ParameterRates rates(double u, FrameRate fps) const {
    const double rate = static_cast<double>(fps.numerator) * static_cast<double>(parts) /
                        (static_cast<double>(fps.denominator) * static_cast<double>(length));
    return {rate * (c1 + u * (2 * c2 + u * (3 * c3))), rate * rate * (2 * c2 + 6 * u * c3),
            rate * rate * rate * (6 * c3)};
  }
};

/// A place on the speed curve: a = span + t.
struct CurvePlace {
  std::int32_t span = 0;
  double t = 0;
};

/// The length over one span of the drawn curve: begin + t (c[0] + c[1] t + c[2] t^2 + c[3] t^3), t from 0
/// to 1. Within so short a span powers of t are as good as Bernstein's polynomials, and half the work.
struct SpanDistance {
  TwoSum begin;  ///< the distance travelled at its start
  std::array<double, 4> c{};

  [[nodiscard]] double length(double t) const { return t * ((c[0] + c[1] * t) + t * t * (c[2] + c[3] * t)); }
};

/// The memory of a track, owned by the caller. Only what the kind of timing needs may be empty otherwise.
struct TrackMemory {
  std::span<SpanDistance> span_distances = {};  ///< f + 1, for a drawn curve
  std::span<Portion> portions = {};             ///< breaks + 1
  std::span<KeyInterval> key_intervals = {};    ///< segments, for a move timed by frames
};

/// L(s) = K Phi(a), a = f frame / N: separable, so nothing is integrated and no K is searched for
/// (Bartels and Hardtke 1989, eq. for ds/da, in closed form). Refers to the memory of its parts.
class Track {
 public:
  /// `frames` is N: the move lasts N / fps seconds and has N + 1 frames, 0..N.
  /// Errors: out_of_range (N not in 1..max_frames, N * f not below 2^31, fps not positive),
  /// no_distance (Phi(f) = 0 on a path with length), capacity. Cost: linear in f.
  static Result<Track> make(const Path& path, const ArcLength& arc_length, const SpeedProfile& profile,
                            std::int32_t frames, FrameRate fps, const TrackMemory& memory);

  /// The paper's method with keys that have frames: the move is broken in two at each of them, portion k uses
  /// phi on its own interval of a with K_k = L_k / dPhi_k, and the speed jumps (Bartels and Hardtke 1989).
  /// `breaks` are in order of their keys, which lie inside the path, and of their frames.
  /// Errors: those of `make`; out_of_range (order, frames), no_distance (with the key where a portion ends).
  static Result<Track> make_with_breaks(const Path& path, const ArcLength& arc_length,
                                        const SpeedProfile& profile, std::int32_t frames, FrameRate fps,
                                        std::span<const BreakKey> breaks, const TrackMemory& memory);

  /// No speed curve: every key has its frame (Steketee and Badler 1985), the first 0, the last N; of a
  /// closed path one more, for the return to key 0. monotone: slopes by Fritsch and Butland's harmonic mean,
  /// at the first and last key their three-point formula, limited so that s never falls. curves: `path` was
  /// made over the same frames, and only there.
  /// Errors: wrong_count, out_of_range (first, last, order: with key and frame), capacity.
  static Result<Track> make_with_key_frames(const Path& path, const ArcLength& arc_length,
                                            std::span<const std::int32_t> key_frames, Kinetic kinetic,
                                            std::int32_t frames, FrameRate fps, const TrackMemory& memory);

  [[nodiscard]] const Path& path() const { return path_; }
  [[nodiscard]] const ArcLength& arc_length() const { return arc_length_; }
  /// Whether a drawn curve says how fast; otherwise the frames of the keys do, and profile(), constant()
  /// mean nothing.
  [[nodiscard]] bool has_profile() const { return key_intervals_.empty(); }
  [[nodiscard]] const SpeedProfile& profile() const { return profile_; }
  /// One for every segment of a move timed by frames, otherwise empty.
  [[nodiscard]] std::span<const KeyInterval> key_intervals() const { return key_intervals_; }
  /// Empty where one K holds for the whole move.
  [[nodiscard]] std::span<const Portion> portions() const { return portions_; }
  [[nodiscard]] std::int32_t frames() const { return frames_; }
  [[nodiscard]] FrameRate frame_rate() const { return fps_; }
  /// K = L / Phi(f); 0 for a path without length. With breaks each portion has its own instead.
  [[nodiscard]] double constant() const { return constant_; }

  /// The place of a time on the drawn curve, a = (frame + fraction) f / N, with an exact integer phase: the
  /// digits of t do not wear off. Domain: 0 <= time <= N.
  [[nodiscard]] CurvePlace place(const FrameTime& time) const {
    const std::int32_t f = profile_.span_count();
    const std::int32_t scaled = time.frame * f;
    const std::int32_t span = scaled / frames_;
    CurvePlace result{
        span, (static_cast<double>(scaled - span * frames_) + time.fraction * static_cast<double>(f)) *
                  inverse_frames_};
    if (result.t >= 1 || time.frame >= frames_) [[unlikely]] {  // a fraction of a frame may pass over spans
      const auto whole = static_cast<std::int32_t>(result.t);
      result.span += whole;
      result.t -= static_cast<double>(whole);
      if (result.span >= f) result = {f - 1, 1};
    }
    return result;
  }
  /// da/dt: spans of the drawn curve a second.
  [[nodiscard]] double curve_rate() const { return curve_rate_; }

  /// The distance travelled since frame 0 as drawn. O(1). Domain: 0 <= time <= N.
  [[nodiscard]] TwoSum distance(const FrameTime& time) const {
    if (is_plain_) [[likely]]
      return distance_at(place(time));
    return special_distance(time);
  }

  /// The point of the path. Before frame 0 the start and after frame N the end, to the last bit.
  /// O(1), no allocation; the same bits on every target of one precision.
  [[nodiscard]] PathPoint locate(const FrameTime& time) const {
    // Negative frames are large ones here.
    if (static_cast<std::uint32_t>(time.frame) >= static_cast<std::uint32_t>(frames_)) [[unlikely]]
      return {time.frame < 0 ? 0 : path_.segment_count(), 0};
    if (is_plain_) [[likely]]
      return locate_at(place(time));
    return special_locate(time);
  }

  /// The position of every axis, in axis units: the tick. `out` has axis_count() entries. O(axes).
  void positions(const FrameTime& time, std::span<double> out) const {
    const auto axes = static_cast<std::size_t>(path_.axis_count());
    // One question for all that is rare: locate() would ask the first again.
    const bool is_inside = static_cast<std::uint32_t>(time.frame) < static_cast<std::uint32_t>(frames_);
    if (is_inside && needs_nothing_more_) [[likely]] {
      const PathPoint point = locate_at(place(time));
      return write_values(path_.segment(point.segment), point.t, out.first(axes));
    }
    const PathPoint point = locate(time);
    write_values(path_.segment(point.segment), point.t, out.first(axes));
    if (path_.overshoots()) return;
    for (std::size_t d = 0; d < axes; ++d) out[d] = path_.kept(out[d], point.segment, d);
  }

  /// locate() at whole frames `first`, `first` + 1, ..., bit for bit, in runs of frames that share a span
  /// of the speed curve and a piece of the arc length. Domain: 0 <= first, first + points.size() - 1 <= N.
  /// Returns whether the points are known to be in order: rounding may put one before that in front of it.
  bool locate_frames(std::int32_t first, std::span<PathPoint> points) const;

  /// Point, speed and its derivatives along the path. After frame N and before frame 0: at rest.
  /// 0 for what is beyond the range of double, which motion() reports, and for the derivatives of the speed
  /// of a move timed by frames where P' = 0.
  [[nodiscard]] AlongPath along(const FrameTime& time) const;

  /// Position, velocity, acceleration and jerk of every axis, analytically at (segment, t), not from
  /// the fitted inverse. On a key: the derivatives with which the motion leaves it, of keys in one place the
  /// last; at the end of the path, those with which it arrives. O(axes), no allocation.
  ///
  /// Returns the order of the highest derivative that is that of the motion. Positions always are. 3: all
  /// are. 1: within two roundings of the length from a point where P' = 0 (tension 1, a cusp, a line that
  /// turns back) the velocity is that of one side, the acceleration is that along the path only (across it
  /// there may be no bound), and the jerk is given as 0. 0: a derivative that has no bound, or is beyond the
  /// range of double, is given as 0; a velocity has none where the weighted path stands still and is passed
  /// at a speed, while an axis of weight 0 moves on.
  std::uint8_t motion(const FrameTime& time, std::span<AxisMotion> out) const;
  /// The same of a track with a drawn speed at a place and a pace along the path.
  std::uint8_t motion_at(const AlongPath& where, std::span<AxisMotion> out) const;

 private:
  Track(const Path& path, const ArcLength& arc_length, const SpeedProfile& profile, std::int32_t frames,
        FrameRate fps)
      : path_(path),
        arc_length_(arc_length),
        profile_(profile),
        frames_(frames),
        fps_(fps),
        inverse_frames_(1 / static_cast<double>(frames)),
        curve_rate_(static_cast<double>(profile.span_count()) * static_cast<double>(fps.numerator) /
                    (static_cast<double>(frames) * static_cast<double>(fps.denominator))),
        needs_nothing_more_(path.overshoots()) {}

  [[nodiscard]] TwoSum distance_at(const CurvePlace& place) const {
    const SpanDistance& span = span_distances_[static_cast<std::size_t>(place.span)];
    TwoSum sum = span.begin;
    sum.add(span.length(place.t));
    return sum;
  }
  [[nodiscard]] PathPoint locate_at(const CurvePlace& place) const {
    const SpanDistance& span = span_distances_[static_cast<std::size_t>(place.span)];
    return arc_length_.locate(span.begin, span.length(place.t));
  }
  /// along() of a drawn curve and of frames, with infinities where it is beyond the range of double.
  [[nodiscard]] AlongPath along_profile(const FrameTime& time) const;
  [[nodiscard]] AlongPath along_key_frames(const FrameTime& time) const;
  [[nodiscard]] double distance_rounding() const;
  [[gnu::always_inline]] inline std::uint8_t write_motion(const AlongPath& where,
                                                          std::span<AxisMotion> axes) const;
  std::uint8_t write_slow(AlongPath where, std::span<AxisMotion> axes) const;
  [[nodiscard]] TwoSum special_distance(const FrameTime& time) const;
  /// distance() of a drawn curve with breaks.
  [[nodiscard]] TwoSum broken_distance(const FrameTime& time) const;
  [[nodiscard]] PathPoint special_locate(const FrameTime& time) const;
  [[nodiscard]] PathPoint key_frame_point(const FrameTime& time) const;
  [[nodiscard]] const Portion& portion_at(std::int32_t frame) const;
  [[nodiscard]] std::size_t interval_at(const FrameTime& time) const;
  [[nodiscard]] ParameterRates key_frame_rates(const FrameTime& time) const;
  [[nodiscard]] bool is_outside(const FrameTime& time) const {
    return time.frame < 0 || time.frame > frames_ || (time.frame == frames_ && time.fraction > 0);
  }

  Path path_;
  ArcLength arc_length_;
  SpeedProfile profile_;
  std::span<const SpanDistance> span_distances_;
  std::span<const Portion> portions_;
  std::span<const KeyInterval> key_intervals_;
  std::int32_t frames_ = 0;
  FrameRate fps_;
  double inverse_frames_ = 0;
  double curve_rate_ = 0;
  double constant_ = 0;
  bool is_plain_ = true;             ///< one drawn curve, no breaks: the case that must be quick
  bool needs_nothing_more_ = false;  ///< plain, and positions need no Path::kept()
};

/// Memory of a track with up to `Keys` keys, `Axes` axes, `Values` control values.
template <std::size_t Keys, std::size_t Axes, std::size_t Values, std::size_t Pieces = 24 * Keys>
struct TrackStorage {
  PathStorage<Keys, Axes> path;
  ArcLengthStorage<Keys, Pieces> arc_length;
  SpeedProfileStorage<Values> profile;
  std::array<SpanDistance, (Values > 1 ? Values : 2)> span_distances;

  [[nodiscard]] TrackMemory memory() { return {span_distances}; }
};

/// The frame, which need not be a whole one, on which a segment of the path begins; of segment_count the end.
/// Keys in one place have the frame of the first. O(log N) and a bisection in time.
double frame_of_segment(const Track& track, std::int32_t segment);

}  // namespace inbetween
