#include "host_tools/plan/unmet_lock.hpp"

#include <fmt/format.h>

#include <cstddef>

#include "inbetween/timing/integral_row.hpp"

namespace inbetween {
namespace {

/// A mean that is above 100 by less than this share may be so by rounding.
constexpr double mean_rounding = 1e-6;
/// The advice leaves this share of room: a curve that is lowered by exactly what is missing would need a mean
/// of exactly 100.
constexpr double advised_room = 0.01;

/// The stretch from one lock to the next, and the mean that the curve needs while it is passed.
struct LockedStretch {
  KeyLock begin, end;
  double mean = 0;
};

LockedStretch fastest_stretch(const UnmetLocks& unmet) {
  const auto f = static_cast<std::int32_t>(unmet.control_values.size()) - 1;
  const auto distance = [&](const KeyLock& lock) {
    return unmet.waypoints[static_cast<std::size_t>(lock.key)].distance;
  };
  const auto a_of = [&](std::int32_t frame) {
    return static_cast<double>(frame) * static_cast<double>(f) / static_cast<double>(unmet.frames);
  };
  LockedStretch fastest;
  for (std::size_t i = 0; i + 1 < unmet.locks.size();) {
    std::size_t end = i + 1;
    while (end + 1 < unmet.locks.size() && !unmet.locks[end].breaks) ++end;
    const IntegralRow row(a_of(unmet.locks[i].frame), a_of(unmet.locks[end].frame), f, unmet.ends);
    const double area = row.integral(unmet.control_values);
    const double length = distance(unmet.locks[end]) - distance(unmet.locks[i]);
    for (; i < end; ++i) {
      const KeyLock& one = unmet.locks[i];
      const KeyLock& next = unmet.locks[i + 1];
      if (!(length > 0) || one.ease || next.ease) continue;  // an eased key is met beside its frame
      const double spans = a_of(next.frame) - a_of(one.frame + one.hold);
      const double mean = (distance(next) - distance(one)) / length * area / spans;
      if (mean > fastest.mean) fastest = {one, next, mean};
    }
  }
  return fastest;
}

}  // namespace

std::optional<UnmetLock> proven_unmet(const UnmetLocks& unmet) {
  const LockedStretch stretch = fastest_stretch(unmet);
  const double times = stretch.mean / largest_control_value;
  if (!(times > 1 + mean_rounding)) return std::nullopt;
  const auto key_of = [&](const KeyLock& lock) {
    return unmet.waypoints[static_cast<std::size_t>(lock.key)].key;
  };
  // That the last key is met on the last frame is nobody's request.
  const bool ends_at_end = static_cast<std::size_t>(stretch.end.key) + 1 == unmet.waypoints.size();
  const KeyLock& blamed = ends_at_end ? stretch.begin : stretch.end;
  return UnmetLock(
      {.code = ErrorCode::no_solution,
       .what = "no speed curve from 0 to 100 meets this key on its frame",
       .key = key_of(blamed),
       .frame = blamed.frame},
      fmt::format("between key {} on frame {} and key {} on frame {} it would have to be {:.4g} on average; "
                  "move the frame, or draw the curve as a whole {:.3g} times lower",
                  key_of(stretch.begin), stretch.begin.frame + stretch.begin.hold, key_of(stretch.end),
                  stretch.end.frame, stretch.mean, (1 + advised_room) * times));
}

}  // namespace inbetween
