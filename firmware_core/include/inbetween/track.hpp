#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/arc_length.hpp"
#include "inbetween/frame_time.hpp"
#include "inbetween/path.hpp"
#include "inbetween/precision.hpp"
#include "inbetween/result.hpp"
#include "inbetween/speed_profile.hpp"

/// A path travelled at a drawn speed in a given number of frames: what the real-time loop evaluates.

namespace inbetween {

inline constexpr std::int32_t most_frames = 1'000'000;

/// Where along the path and how fast, in weighted axis units and seconds.
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

/// Whether the derivatives that `Track::motion` returns are those of the motion.
enum class Derivatives : std::uint8_t {
  exact,      ///< yes
  one_sided,  ///< at a point where P' = 0: position and velocity are exact, the acceleration is that
              ///< along the path only (across it there may be no bound), the jerk is given as 0
};

template <Precise Real>
struct TrackMemory {
  std::span<TwoSum<Real>> span_distances;  ///< f + 1
};

/// L(s) = K Phi(a), a = f frame / N: separable, so nothing is integrated and no K is searched for
/// (Bartels and Hardtke 1989, eq. for ds/da, in closed form). Refers to the memory of its parts.
template <Precise Real>
class Track {
 public:
  /// `frames` is N: the move lasts N / fps seconds and has N + 1 frames, 0..N.
  /// Errors: out_of_range (N not in 1..most_frames, N * f not below 2^31, fps not positive),
  /// no_distance (Phi(f) = 0 on a path with length), capacity. Cost: linear in f.
  static Result<Track> make(const Path<Real>& path, const ArcLength<Real>& arc_length,
                            const SpeedProfile<Real>& profile, std::int32_t frames, FrameRate fps,
                            const TrackMemory<Real>& memory);

  [[nodiscard]] const Path<Real>& path() const { return path_; }
  [[nodiscard]] const ArcLength<Real>& arc_length() const { return arc_length_; }
  [[nodiscard]] const SpeedProfile<Real>& profile() const { return profile_; }
  [[nodiscard]] std::int32_t frames() const { return frames_; }
  [[nodiscard]] FrameRate frame_rate() const { return fps_; }
  /// K = L / Phi(f); 0 for a path without length.
  [[nodiscard]] Real constant() const { return constant_; }

  /// The distance travelled since frame 0 by the drawn curve. O(1). Domain: 0 <= time <= N.
  [[nodiscard]] TwoSum<Real> distance(const FrameTime<Real>& time) const { return distance_at(place(time)); }

  /// The point of the path. Before frame 0 the start and after frame N the end, to the last bit.
  /// O(1), no allocation; the same bits on every target of one precision.
  [[nodiscard]] PathPoint<Real> locate(const FrameTime<Real>& time) const {
    if (time.frame >= frames_) return {path_.segment_count(), 0};
    if (time.frame < 0) return {0, 0};
    return arc_length_.locate(distance_at(place(time)));
  }

  /// The position of every axis, in axis units: the tick. `out` has axis_count() entries. O(axes).
  void positions(const FrameTime<Real>& time, std::span<Real> out) const {
    const PathPoint<Real> point = locate(time);
    const std::span<const Cubic<Real>> cubics = path_.segment(point.segment);
    for (std::size_t d = 0; d < cubics.size(); ++d) out[d] = cubics[d].value(point.t);
  }

  /// Point, speed and its derivatives along the path. After frame N and before frame 0: at rest.
  [[nodiscard]] AlongPath<Real> along(const FrameTime<Real>& time) const;

  /// Position, velocity, acceleration and jerk of every axis, analytically at (segment, t), not from
  /// the fitted inverse. On a key: the derivatives with which the motion leaves it; at the end of the
  /// path, those with which it arrives. O(axes), no allocation.
  Derivatives motion(const FrameTime<Real>& time, std::span<AxisMotion<Real>> out) const;

 private:
  Track(const Path<Real>& path, const ArcLength<Real>& arc_length, const SpeedProfile<Real>& profile)
      : path_(path), arc_length_(arc_length), profile_(profile) {}

  /// A place on the speed curve: a = span + t.
  struct CurvePlace {
    std::int32_t span = 0;
    Real t = 0;
  };
  /// a = (frame + fraction) f / N with an exact integer phase: the digits of t do not wear off.
  [[nodiscard]] CurvePlace place(const FrameTime<Real>& time) const {
    const std::int32_t f = profile_.span_count();
    const std::int32_t scaled = time.frame * f;
    CurvePlace result{scaled / frames_,
                      (static_cast<Real>(scaled % frames_) + time.fraction * static_cast<Real>(f)) /
                          static_cast<Real>(frames_)};
    if (result.t >= 1) {  // f > N: a fraction of a frame may pass over spans
      const auto whole = static_cast<std::int32_t>(result.t);
      result.span += whole;
      result.t -= static_cast<Real>(whole);
    }
    if (result.span >= f) result = {f - 1, 1};
    return result;
  }
  [[nodiscard]] TwoSum<Real> distance_at(const CurvePlace& place) const {
    TwoSum<Real> sum = span_distances_[static_cast<std::size_t>(place.span)];
    sum.add(constant_ * profile_.span(place.span).integral(place.t));
    return sum;
  }

  Path<Real> path_;
  ArcLength<Real> arc_length_;
  SpeedProfile<Real> profile_;
  std::span<const TwoSum<Real>> span_distances_;
  std::int32_t frames_ = 0;
  FrameRate fps_;
  Real constant_ = 0;
};

/// Memory of a track with up to `Keys` keys, `Axes` axes, `Values` control values.
template <Precise Real, std::size_t Keys, std::size_t Axes, std::size_t Values,
          std::size_t Pieces = 24 * Keys>
struct TrackStorage {
  PathStorage<Real, Keys, Axes> path;
  ArcLengthStorage<Real, Keys, Pieces> arc_length;
  SpeedProfileStorage<Real, Values> profile;
  std::array<TwoSum<Real>, (Values > 1 ? Values : 2)> span_distances;

  [[nodiscard]] TrackMemory<Real> memory() { return {span_distances}; }
};

extern template class Track<double>;
extern template class Track<float>;

}  // namespace inbetween
