// A task that a motion loop does for a while, as its runner sees it.
#pragma once

#include <cstdint>

#include "host_tools/loop/run_snapshot.hpp"
#include "host_tools/loop/transport_keys.hpp"
#include "inbetween/base/result.hpp"

namespace inbetween {

/// Refers to a performance: anything with these functions, none of which allocates. Called by the thread of
/// the loop only.
struct LoopTask {
  void* of = nullptr;
  Status (*begin)(void*) = nullptr;
  void (*press)(void*, TransportKey) = nullptr;
  /// `ticks` have passed since the last, usually 1.
  void (*tick)(void*, std::int32_t ticks, std::int64_t now_ns) = nullptr;
  bool (*is_over)(const void*) = nullptr;
  RunSnapshot (*snapshot)(const void*) = nullptr;
  bool is_preparation = false;  ///< what is typed ahead is for the move that follows
};

template <class Performance>
LoopTask act_of(Performance& performance, bool is_preparation = false) {
  return {.of = &performance,
          .begin = [](void* of) { return static_cast<Performance*>(of)->begin(); },
          .press = [](void* of, TransportKey key) { static_cast<Performance*>(of)->press(key); },
          .tick = [](void* of, std::int32_t ticks,
                     std::int64_t now_ns) { static_cast<Performance*>(of)->tick(ticks, now_ns); },
          .is_over = [](const void* of) { return static_cast<const Performance*>(of)->is_over(); },
          .snapshot = [](const void* of) { return static_cast<const Performance*>(of)->snapshot(); },
          .is_preparation = is_preparation};
}

}  // namespace inbetween
