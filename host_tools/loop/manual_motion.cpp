#include "host_tools/loop/manual_motion.hpp"

#include <algorithm>

namespace inbetween {

Status ManualMotion::begin() {
  if (const Status loaded = loop_.load(spec_); !loaded) return loaded;
  return loop_.begin();
}

void ManualMotion::tick(std::int32_t ticks, std::int64_t now_ns) {
  keys_.note(loop_.tick(ticks, now_ns));
  ++ticks_;
  // It rests where its last setpoint is, which has just been written.
  if (keys_.is_running() && spec_.source.is_resting(spec_.source.of)) static_cast<void>(loop_.finish());
}

RunSnapshot ManualMotion::snapshot() const {
  RunSnapshot snapshot{.state = loop_.state(), .doing = doing_};
  if (last_) {
    snapshot.share =
        std::min(static_cast<double>(ticks_) / static_cast<double>(std::max<std::int64_t>(*last_, 1)), 1.0);
  }
  return snapshot;
}

}  // namespace inbetween
