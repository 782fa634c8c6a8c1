#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>

namespace inbetween {

/// Frames per second as an exact fraction: 24/1, 24000/1001.
struct FrameRate {
  std::int32_t numerator = 24;
  std::int32_t denominator = 1;

  [[nodiscard]] constexpr double frames_per_second() const {
    return static_cast<double>(numerator) / static_cast<double>(denominator);
  }
  friend constexpr bool operator==(const FrameRate&, const FrameRate&) = default;
};

/// Frames `first` to `last`, both included.
struct WholeFrames {
  std::int32_t first = 0;
  std::int32_t last = 0;

  friend constexpr bool operator==(const WholeFrames&, const WholeFrames&) = default;
};

/// A place on the time line of a move: whole frames and a part of a frame in [0, 1). Two numbers,
/// so that the part keeps its digits late in a long move, in single precision too: the tick of a
/// CountTrajectory takes it in floats.
template <std::floating_point Real>
struct BasicFrameTime {
  std::int32_t frame = 0;
  Real fraction = 0;

  friend constexpr bool operator==(const BasicFrameTime&, const BasicFrameTime&) = default;
  friend constexpr bool operator<(const BasicFrameTime& a, const BasicFrameTime& b) {
    return a.frame < b.frame || (a.frame == b.frame && a.fraction < b.fraction);
  }
  friend constexpr bool operator<=(const BasicFrameTime& a, const BasicFrameTime& b) { return !(b < a); }
};
using FrameTime = BasicFrameTime<double>;
using FloatFrameTime = BasicFrameTime<float>;

/// `time` moved by so many frames, forward or backward.
inline FrameTime moved_by(const FrameTime& time, double frames) {
  const double sum = time.fraction + frames;
  double whole = std::floor(sum);
  double fraction = sum - whole;
  if (fraction >= 1) {  // a tiny negative number is rounded up
    fraction = 0;
    whole += 1;
  }
  return {time.frame + static_cast<std::int32_t>(whole), fraction};
}

/// In frames, negative if `to` is before `from`.
template <std::floating_point Real>
constexpr Real frames_between(const BasicFrameTime<Real>& from, const BasicFrameTime<Real>& to) {
  return static_cast<Real>(to.frame - from.frame) + (to.fraction - from.fraction);
}

/// The last tick of a move of `frames` frames at `rate_hz` ticks a second: the first tick at or after
/// the end. Exact.
constexpr std::int64_t last_tick(std::int32_t frames, FrameRate fps, std::int32_t rate_hz) {
  const std::int64_t ticks = static_cast<std::int64_t>(frames) * fps.denominator * rate_hz;
  return (ticks + fps.numerator - 1) / fps.numerator;
}

/// The place of tick k, at k / rate_hz seconds, on the time line. The division is exact in integers,
/// so that tick 10^9 is as precise as tick 1; only the fraction is rounded, once.
/// Domain: k >= 0, k * fps.numerator < 2^63.
template <std::floating_point Real = double>
constexpr BasicFrameTime<Real> frame_time_of_tick(std::int64_t tick, FrameRate fps, std::int32_t rate_hz) {
  const std::int64_t scaled = tick * fps.numerator;
  const std::int64_t unit = static_cast<std::int64_t>(rate_hz) * fps.denominator;
  return {static_cast<std::int32_t>(scaled / unit),
          static_cast<Real>(scaled % unit) / static_cast<Real>(unit)};
}

}  // namespace inbetween
