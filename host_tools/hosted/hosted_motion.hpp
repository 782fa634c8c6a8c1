// The motions of a rig that a host drives, in the loop's thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/linux/telemetry_ring.hpp"
#include "host_tools/loop/loop_task.hpp"
#include "host_tools/loop/operator_keys.hpp"
#include "host_tools/loop/run_loop.hpp"
#include "host_tools/motions/free_axes.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/rig/level_outputs.hpp"
#include "inbetween/play/free_axis.hpp"

namespace inbetween {

inline constexpr std::size_t max_hosted_axes = 32;

/// An order to the loop's thread. Plain data; a move lives until MotionState::forgotten has come to a later
/// number.
struct MotionOrder {
  enum class Kind : std::uint8_t {
    none,
    limit,           ///< an axis that rests has these limits from now on
    go,              ///< an axis goes to `position`, at `velocity` at most
    stop_axis,       ///< an axis rests as soon as its limits allow
    stop,            ///< everything does, a move on its path
    travel,          ///< along `move`, from `from_frame`, where the rig is, to `frame`, at `rate`
    play,            ///< `move` from its beginning, where the rig is, `delay_ticks` later
    end_repeats,     ///< the move that plays is over at its next end
    forget,          ///< no move is referred to any more; only while nothing moves
    acknowledge,     ///< what stopped the rig: its drives are asked where they are, and held there
    switch_outputs,  ///< to `outputs`
  };
  Kind kind = Kind::none;
  std::uint32_t number = 0;
  std::size_t axis = 0;
  double position = 0;
  double velocity = 0;
  FreeAxisLimits limits = {};
  StagedMove* move = nullptr;
  std::int32_t from_frame = 0;
  std::int32_t frame = 0;
  double rate = 1;
  std::int64_t delay_ticks = 0;
  std::uint32_t outputs = 0;  ///< bit 0 is the first
};

/// The rig after a tick.
struct MotionState {
  std::uint32_t heard = 0;      ///< the number of the last order that was taken
  std::uint32_t forgotten = 0;  ///< of the last `forget` that was done
  std::int64_t now_ns = 0;
  SupervisorState state = SupervisorState::disarmed;
  std::uint32_t moving = 0;   ///< bit 0 is the first axis
  bool plays = false;         ///< a move, or it waits to
  FrameTime time = {};        ///< of its time line
  std::int64_t repeats = 0;   ///< how often the move has come round
  std::uint32_t refused = 0;  ///< the number of the last order that could not be begun; 0: none
  const char* why = "";       ///< a literal
  bool lost_time = false;
  std::array<double, max_hosted_axes> commanded{};
  std::array<DriveState, max_hosted_axes> drives{};
};

/// Allocates only when it is made. Refers to the loop and the outputs.
class HostedMotion final : public LoopTask {
 public:
  /// `limits` are what the loop holds the axes to. `outputs` may be null.
  HostedMotion(RunLoop& loop, std::vector<FreeAxis> axes, std::vector<AxisLimits> limits, double tick_seconds,
               LevelOutputs* outputs = nullptr);

  // From another thread.

  /// False: the loop does not take orders as fast as they come, and nothing is done.
  bool order(const MotionOrder& order) { return orders_.push(order); }
  [[nodiscard]] std::optional<MotionState> take_state() { return states_.pop(); }

  // From the loop's.

  Status begin() override;
  void press(TransportKey key) override { keys_.press(key); }
  void tick(std::int32_t ticks, std::int64_t now_ns) override;
  [[nodiscard]] bool is_over() const override { return keys_.has_left(); }
  [[nodiscard]] RunSnapshot snapshot() const override;
  [[nodiscard]] std::optional<double> frame() const override;
  [[nodiscard]] std::optional<PlayedPlace> played() const override { return played_; }

 private:
  void obey(const MotionOrder& order);
  Status go(const MotionOrder& order);
  Status travel(const MotionOrder& order);
  Status play(const MotionOrder& order);
  Status begin_free();
  Status load(StagedMove& move);
  void stop();
  void tell(std::int64_t now_ns, const LoopTick& tick);
  [[nodiscard]] bool is_running() const { return loop_.state() == SupervisorState::running; }
  [[nodiscard]] bool is_moving() const { return is_running() || loop_.state() == SupervisorState::stopping; }
  [[nodiscard]] FreeSpec free_spec();

  RunLoop& loop_;
  OperatorKeys keys_;
  FreeAxes free_;
  std::vector<FreeAxisLimits> free_limits_;
  std::vector<std::size_t> drive_of_;
  std::vector<AxisLimits> limits_;
  double tick_seconds_;
  LevelOutputs* outputs_;
  std::uint32_t wanted_outputs_ = 0;
  StagedMove* move_ = nullptr;    ///< that the loop has; null: the axes by themselves
  std::int64_t delay_ticks_ = 0;  ///< until the move begins
  std::int64_t repeats_ = 0;
  std::optional<PlayedPlace> played_ = {};
  MotionState told_;
  TelemetryRing<MotionOrder, 256> orders_;
  TelemetryRing<MotionState, 64> states_;
};

}  // namespace inbetween
