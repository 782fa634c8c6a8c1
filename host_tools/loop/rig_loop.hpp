// The motion loop of a rig with all that is under it, simulated or real, and the runner that ticks it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/loop/loop_runner.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/loop/run_loop.hpp"
#include "host_tools/loop/run_record.hpp"

namespace inbetween {

/// Refers to the rig. The order is: open, start, perform as often as wanted, end.
class RigLoop {
 public:
  /// Drives and lines in this process, with the axes at `positions`, in the order of the rig. It ticks with
  /// the machine's clock, or `is_fast`, on a virtual one, as fast as it can be computed.
  static std::unique_ptr<RigLoop> simulated(const RigFile& rig, const std::vector<double>& positions,
                                            bool is_fast);
  /// Takes the lines and drives of the machine, and ticks with its clock. Throws InputError at the place of
  /// what is not there.
  static std::unique_ptr<RigLoop> on_rig(const RigFile& rig, bool in_real_time);
  RigLoop(const RigLoop&) = delete;
  RigLoop& operator=(const RigLoop&) = delete;

  /// Ticks from now on, between acts as well unless it is fast; every tick goes to `record` too, if there is
  /// one. Throws InputError where the rig is to be moved in real time and the machine is not fit for that:
  /// --allow-jitter is what one may do `otherwise`.
  void start(const LoopAudience& audience, const char* otherwise, RunRecord* record = nullptr);
  /// Until it is over. With the `last` of its ticks, if that is known, progress is told.
  ActEnd perform(const LoopTask& act, std::optional<std::int64_t> last = std::nullopt);
  /// No tick follows, and what was performed may go. Nothing where it has not started.
  void end();

  [[nodiscard]] RunLoop& loop() { return loop_; }
  [[nodiscard]] const RunLoop& loop() const { return loop_; }
  [[nodiscard]] RigInputs& lines() { return *lines_; }
  [[nodiscard]] RigDrives& drives() { return *drives_; }
  [[nodiscard]] const RigDrives& drives() const { return *drives_; }
  [[nodiscard]] const RigFile& rig() const { return rig_; }
  [[nodiscard]] bool is_simulated() const { return is_simulated_; }
  [[nodiscard]] double tick_seconds() const { return 1.0 / rig_.rate_hz; }
  /// The setpoints of a tick are reached so much later.
  [[nodiscard]] std::int64_t delay_ns() const;
  /// What is wrong with a line or a drive and what to do; "" for nothing. Not for the loop's thread.
  [[nodiscard]] std::string trouble() const;

  // After the end.

  [[nodiscard]] const std::vector<AxisTrace>& axes() const { return trace_->axes(); }
  [[nodiscard]] const WakeLatency& latency() const { return latency_; }
  [[nodiscard]] std::int64_t late_ticks() const { return late_ticks_; }

 private:
  RigLoop(const RigFile& rig, std::unique_ptr<RigInputs> lines, std::unique_ptr<RigDrives> drives);

  const RigFile& rig_;
  std::unique_ptr<RigInputs> lines_;
  std::unique_ptr<RigDrives> drives_;
  LoopStorage room_;
  RunLoop loop_;
  bool is_simulated_ = true;
  bool is_fast_ = false;
  bool in_real_time_ = false;
  LoopAudience audience_;
  std::optional<LoopTrace> trace_;
  WakeLatency latency_;
  std::int64_t late_ticks_ = 0;
  // One of them, destroyed first.
  std::optional<FastRunner> fast_;
  std::optional<TimedRunner> timed_;
};

}  // namespace inbetween
