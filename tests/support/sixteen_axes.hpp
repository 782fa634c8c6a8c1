// Sixteen axes at 1 kHz: a rig, a move that goes there and back in ten seconds, and its loop, ticked by hand.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "host_tools/loop/loop_runner.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/loop/run_loop.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/motions/transport.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "host_tools/takes/take.hpp"

namespace inbetween::sixteen_axes {

inline constexpr int axes = 16;
inline constexpr std::int32_t rate_hz = 1000;
inline constexpr std::int32_t fps = 25;
inline constexpr std::int32_t frames = 250;

enum class Drives : std::uint8_t {
  of_every_kind,  ///< with a gantry and a gear with play among them
  ideal,          ///< they are where they were told to be, and cost next to nothing
};

std::string rig_of(Drives drives);
/// Each axis goes a distance of its own.
std::string move();

/// The loop of the rig with ideal drives. It is switched on, and plays the move over and over.
class TickedLoop {
 public:
  TickedLoop();
  TickedLoop(const TickedLoop&) = delete;
  TickedLoop& operator=(const TickedLoop&) = delete;

  /// The next tick, and what `run` does with it behind that.
  void tick(LoopTrace& trace);
  [[nodiscard]] RunLoop& loop() { return loop_; }
  [[nodiscard]] Transport& transport() { return transport_; }
  [[nodiscard]] bool is_running() const { return loop_.state() == SupervisorState::running; }
  /// A take of it before its first tick.
  [[nodiscard]] Take take() const;

 private:
  void start();

  Plan plan_;
  std::unique_ptr<StagedMove> staged_;
  SimulatedHardware hardware_;
  RigInputs lines_;
  RigDrives drives_;
  LoopStorage room_{axes, axes};
  RunLoop loop_;
  Transport transport_;
  std::int64_t ticks_ = 0;
};

}  // namespace inbetween::sixteen_axes
