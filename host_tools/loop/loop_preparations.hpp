// The acts before a move and after it: drives are switched on, arrive, and are switched off.
#pragma once

#include <cstdint>
#include <vector>

#include "host_tools/loop/loop_task.hpp"
#include "host_tools/loop/run_loop.hpp"

namespace inbetween {

/// Refers to the loop.
class Preparation : public LoopTask {
 public:
  explicit Preparation(RunLoop& loop) : loop_(loop) {}
  [[nodiscard]] RunSnapshot snapshot() const final { return {.state = loop_.state()}; }
  [[nodiscard]] bool is_preparation() const final { return true; }

 protected:
  RunLoop& loop_;
};

/// Switches the drives on. Over when they are, or cannot be, or somebody has left.
class Arming final : public Preparation {
 public:
  explicit Arming(RunLoop& loop);
  Status begin() override;
  void press(TransportKey key) override;
  void tick(std::int32_t ticks, std::int64_t now_ns) override;
  [[nodiscard]] bool is_over() const override { return loop_.state() != SupervisorState::enabling; }
  /// The positions of the axes as their drives told them, once it is over.
  [[nodiscard]] const std::vector<double>& positions() const { return positions_; }

 private:
  std::vector<double> positions_;
};

/// Waits until the axes stand still where they were told to be, a second at most: drives follow their last
/// setpoint with a lag. One that was stopped alone is not waited for.
class Arriving final : public Preparation {
 public:
  Arriving(RunLoop& loop, std::int32_t rate_hz);
  void tick(std::int32_t ticks, std::int64_t now_ns) override;
  [[nodiscard]] bool is_over() const override { return still_ticks_ >= 8 || ticks_left_ <= 0; }

 private:
  std::int64_t ticks_left_;
  std::int32_t still_ticks_ = 0;
  std::vector<double> positions_;
};

/// Switches the drives off, and waits until each has told that it is; what moves is stopped first. Bounded by
/// that stop and by the drives' own times (DrivePort).
class Disarming final : public Preparation {
 public:
  using Preparation::Preparation;
  Status begin() override;
  void tick(std::int32_t ticks, std::int64_t now_ns) override;
  [[nodiscard]] bool is_over() const override { return is_over_; }

 private:
  bool is_over_ = false;
};

}  // namespace inbetween
