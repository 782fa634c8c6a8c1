#include "tests/support/sided_derivatives.hpp"

#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace inbetween {
namespace {

double frames_of(const KeyInterval& interval) {
  return static_cast<double>(interval.length) / interval.parts;
}

}  // namespace

Sided rediff(const SolvedTrack& track, std::int32_t axis, double frame, double step) {
  std::array<double, 4> p{};
  std::vector<double> position(static_cast<std::size_t>(track.track().path().axis_count()));
  for (int i = 0; i < 4; ++i) {
    // On the far side of the frame by a quarter of a step, so that no sample is of the other side.
    const double when = frame + step * (i + 0.25);
    const auto whole = static_cast<std::int32_t>(when);
    track.track().positions({whole, when - whole}, position);
    p[static_cast<std::size_t>(i)] = position[static_cast<std::size_t>(axis)];
  }
  // Newton's form of the cubic through them, differentiated at x = -0.25 steps from the first.
  const double d1 = p[1] - p[0];
  const double d2 = (p[2] - 2 * p[1] + p[0]) / 2;
  const double d3 = (p[3] - 3 * p[2] + 3 * p[1] - p[0]) / 6;
  const double x = -0.25;
  const double first = d1 + d2 * (2 * x - 1) + d3 * (3 * x * x - 6 * x + 2);
  const double second = 2 * d2 + d3 * (6 * x - 6);
  const double seconds = step / 24;
  return {first / seconds, second / (seconds * seconds)};
}

double largest(const SolvedTrack& track, std::int32_t axis, double AxisMotion::*quantity) {
  double most = 0;
  std::vector<AxisMotion> motion(static_cast<std::size_t>(track.track().path().axis_count()));
  for (std::int32_t frame = 0; frame < track.track().frames(); ++frame) {
    for (const double fraction : {0.0, 0.25, 0.5, 0.75}) {
      track.track().motion({frame, fraction}, motion);
      most = std::max(most, std::fabs(motion[static_cast<std::size_t>(axis)].*quantity));
    }
  }
  return most;
}

void expect_no_steps(const SolvedTrack& track, std::int32_t axis, double size, bool of_acceleration) {
  const auto intervals = track.track().key_intervals();
  const double velocity = largest(track, axis, &AxisMotion::velocity);
  const double acceleration = largest(track, axis, &AxisMotion::acceleration);
  for (std::size_t i = 1; i < intervals.size(); ++i) {
    const FrameTime begin = intervals[i].begin_time();
    const double frame = begin.frame + begin.fraction;
    const double before = frames_of(intervals[i - 1]) / 4;
    const double behind = frames_of(intervals[i]) / 4;
    const Sided arriving = rediff(track, axis, frame, -before);
    const Sided leaving = rediff(track, axis, frame, behind);
    // What a rounding of the position becomes when it is differentiated.
    const double rounding = 1e-12 * size;
    const double seconds = std::min(before, behind) / 24;
    RC_ASSERT(std::fabs(leaving.velocity - arriving.velocity) <= 1e-9 * velocity + rounding / seconds);
    if (!of_acceleration) continue;
    RC_ASSERT(std::fabs(leaving.acceleration - arriving.acceleration) <=
              1e-9 * acceleration + rounding / (seconds * seconds));
  }
}

}  // namespace inbetween
