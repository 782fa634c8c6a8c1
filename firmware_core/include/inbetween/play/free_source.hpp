#pragma once

#include <cstdint>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/setpoint.hpp"

/// The source of setpoints for a motion loop without a drawn move.

namespace inbetween {

/// Refers to a motion that is not on a time line: free axes (FreeAxis), or axes that look for their
/// switches (Homing). None of these functions allocates or waits.
struct FreeSource {
  void* of = nullptr;
  /// One tick later: a setpoint for every axis.
  void (*tick)(void*, std::int64_t now_ns, std::span<Setpoint> out) = nullptr;
  /// Every axis slows down.
  void (*stop)(void*) = nullptr;
  /// Every axis is at rest at once, where it is, because its setpoints are no longer sent.
  void (*halt)(void*) = nullptr;
  bool (*is_resting)(const void*) = nullptr;
};

/// Makes a source of any motion that has these functions.
template <class Motion>
FreeSource source_of(Motion& motion) {
  return {.of = &motion,
          .tick = [](void* of, std::int64_t now_ns,
                     std::span<Setpoint> out) { static_cast<Motion*>(of)->tick(now_ns, out); },
          .stop = [](void* of) { static_cast<Motion*>(of)->stop(); },
          .halt = [](void* of) { static_cast<Motion*>(of)->halt(); },
          .is_resting = [](const void* of) { return static_cast<const Motion*>(of)->is_resting(); }};
}

}  // namespace inbetween
