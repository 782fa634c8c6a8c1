// The acts before a move and after it: drives are switched on, arrive, and are switched off.
#pragma once

#include <cstdint>
#include <vector>

#include "host_tools/loop/run_loop.hpp"
#include "host_tools/loop/run_snapshot.hpp"
#include "host_tools/loop/transport_keys.hpp"

namespace inbetween {

/// Switches the drives on. Over when they are, or cannot be, or somebody has left.
class Arming {
 public:
  explicit Arming(RunLoop& loop);
  Status begin();
  void press(TransportKey key);
  void tick(std::int32_t ticks, std::int64_t now_ns);
  [[nodiscard]] bool is_over() const { return loop_.state() != SupervisorState::enabling; }
  [[nodiscard]] RunSnapshot snapshot() const { return {.state = loop_.state()}; }
  /// The positions of the axes as their drives told them, once it is over.
  [[nodiscard]] const std::vector<double>& positions() const { return positions_; }

 private:
  RunLoop& loop_;
  std::vector<double> positions_;
};

/// Waits until the axes stand still, a second at most: drives follow their last setpoint with a lag.
class Arriving {
 public:
  Arriving(RunLoop& loop, std::int32_t rate_hz);
  Status begin() { return Done{}; }
  void press(TransportKey) {}
  void tick(std::int32_t ticks, std::int64_t now_ns);
  [[nodiscard]] bool is_over() const { return still_ticks_ >= 8 || ticks_left_ <= 0; }
  [[nodiscard]] RunSnapshot snapshot() const { return {.state = loop_.state()}; }

 private:
  RunLoop& loop_;
  std::int64_t ticks_left_;
  std::int32_t still_ticks_ = 0;
  std::vector<double> positions_;
};

/// Switches the drives off, and waits until each has told that it is; what moves is stopped first. Bounded by
/// that stop and by the drives' own times (DrivePort).
class Disarming {
 public:
  explicit Disarming(RunLoop& loop) : loop_(loop) {}
  Status begin();
  void press(TransportKey) {}
  void tick(std::int32_t ticks, std::int64_t now_ns);
  [[nodiscard]] bool is_over() const { return is_over_; }
  [[nodiscard]] RunSnapshot snapshot() const { return {.state = loop_.state()}; }

 private:
  RunLoop& loop_;
  bool is_over_ = false;
};

}  // namespace inbetween
