#pragma once

#include <cmath>
#include <cstdint>

#include "inbetween/base/precision.hpp"

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
/// so that the part keeps its digits late in a long move, in single precision too.
template <Precise Real>
struct FrameTime {
  std::int32_t frame = 0;
  Real fraction = 0;

  friend constexpr bool operator==(const FrameTime&, const FrameTime&) = default;
  friend constexpr bool operator<(const FrameTime& a, const FrameTime& b) {
    return a.frame < b.frame || (a.frame == b.frame && a.fraction < b.fraction);
  }
  friend constexpr bool operator<=(const FrameTime& a, const FrameTime& b) { return !(b < a); }
};

/// `time` moved by so many frames, forward or backward.
template <Precise Real>
FrameTime<Real> moved_by(const FrameTime<Real>& time, Real frames) {
  const Real sum = time.fraction + frames;
  Real whole = std::floor(sum);
  Real fraction = sum - whole;
  if (fraction >= 1) {  // a tiny negative number is rounded up
    fraction = 0;
    whole += 1;
  }
  return {time.frame + static_cast<std::int32_t>(whole), fraction};
}

/// In frames, negative if `to` is before `from`.
template <Precise Real>
constexpr Real frames_between(const FrameTime<Real>& from, const FrameTime<Real>& to) {
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
template <Precise Real>
constexpr FrameTime<Real> frame_time_of_tick(std::int64_t tick, FrameRate fps, std::int32_t rate_hz) {
  const std::int64_t scaled = tick * fps.numerator;
  const std::int64_t unit = static_cast<std::int64_t>(rate_hz) * fps.denominator;
  return {static_cast<std::int32_t>(scaled / unit),
          static_cast<Real>(scaled % unit) / static_cast<Real>(unit)};
}

}  // namespace inbetween
