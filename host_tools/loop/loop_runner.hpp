// Runs a motion loop, act after act: on a virtual clock, or on the machine's in a thread of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "drivers/linux/monotonic_clock.hpp"
#include "drivers/linux/real_time.hpp"
#include "drivers/linux/telemetry_ring.hpp"
#include "host_tools/loop/loop_task.hpp"
#include "host_tools/loop/run_loop.hpp"
#include "host_tools/loop/tick_sink.hpp"
#include "host_tools/loop/wake_latency.hpp"

namespace inbetween {

/// Whoever sits before the run: what is typed, what is shown. Each may be left out.
struct LoopAudience {
  /// Returns the keys that were typed since the last call (TransportKeys). Without it nobody can type.
  std::function<std::string()> keys = {};
  /// Returns the keys since the last call of a device that tells when it is let go.
  std::function<std::vector<TransportKey>()> device = {};
  /// Whether somebody wants the run to end: it is stopped on the path.
  std::function<bool()> interrupted = {};
  /// Called about ten times a second of real time.
  std::function<void(const RunSnapshot&)> status = {};
  /// Called before the first tick and then about ten times a second of real time, and at the end.
  std::function<void(std::int64_t tick, std::int64_t last)> progress = {};
  /// Asked before the rig goes slowly to where it is wanted. Without it, it does not.
  std::function<bool(const std::string& question)> confirm = {};
  /// Whether nothing may be begun any more, because the rig is not what was read (RigWatch).
  std::function<bool()> rig_has_changed = {};
};

/// How an act ended.
struct ActEnd {
  Status begun = Done{};   ///< why it did not begin
  std::int64_t ticks = 0;  ///< that it had
};

/// Where an axis was last, and how far from its setpoint at most.
struct AxisTrace : AxisPlace {
  double following_error_peak = 0;
};

/// The axes of a loop, tick by tick. Allocates only when it is made.
class LoopTrace {
 public:
  /// Every tick goes to the sinks as well.
  explicit LoopTrace(std::size_t axes, const TickSinks& sinks = {}) : axes_(axes), sinks_(sinks) {}
  /// After a tick of an act, or of none. While setpoints are sent, an axis is as far behind as its actual
  /// position is from them.
  void take(const RunLoop& loop, const LoopTask* act = nullptr);
  /// Gives an act a key.
  void press(LoopTask& act, TransportKey key);
  /// From now on every tick goes there. The loop's thread calls it.
  void record_to(const TickSinks& sinks) { sinks_ = sinks; }
  [[nodiscard]] const std::vector<AxisTrace>& axes() const { return axes_; }
  /// What the act shows, and the axes: the setpoint of each that its drive has answered, one tick old.
  [[nodiscard]] RunSnapshot shown(const LoopTask& act) const;

 private:
  std::vector<AxisTrace> axes_;
  TickSinks sinks_;
  bool commanded_ = false;  ///< in the tick before
};

/// On a clock that has the time that is waited for: as fast as it can be computed.
class FastRunner {
 public:
  FastRunner(RunLoop& loop, std::int32_t rate_hz, const LoopAudience& audience, LoopTrace& trace)
      : loop_(loop), rate_hz_(rate_hz), audience_(audience), trace_(trace) {}

  /// Until it is over. Progress is told where the last tick is known.
  ActEnd run(LoopTask& act, std::optional<std::int64_t> last);
  [[nodiscard]] WakeLatency latency() const { return {}; }
  [[nodiscard]] std::int64_t late_ticks() const { return 0; }

 private:
  RunLoop& loop_;
  std::int32_t rate_hz_;
  const LoopAudience& audience_;
  LoopTrace& trace_;
  MonotonicClock wall_;
  TransportKeys keys_;
  std::int64_t tick_ = 0;
  std::int64_t next_show_ns_ = 0;
};

/// The meaning of a late tick for the rig. One that is late by a second or more, because the program or the
/// machine was suspended, has every rig catch up, a simulated one with its drives too: whatever is played
/// stops (docs/faults.md 36), and nobody who comes back is surprised by what moves.
enum class Lateness {
  time_stands_still,  ///< those after it are as much later, also for the drives, which are simulated
  falls_behind,       ///< those after it are as much later: steps that were not made cannot be made up for
  catches_up,         ///< the loop is told how many ticks have passed (MotionLoop, docs/faults.md 36)
};

/// On the machine's clock, in a thread of its own, which ticks from construction on, between acts as well,
/// until it is destroyed. In that thread nothing is allocated, locked, logged or written; keys come in and
/// snapshots go out through rings, what does not fit is counted.
class TimedRunner {
 public:
  /// With `request` the thread asks for real-time rights first.
  TimedRunner(RunLoop& loop, std::int32_t rate_hz, const LoopAudience& audience, LoopTrace& trace,
              Lateness lateness, const std::optional<RealTimeRequest>& request);
  ~TimedRunner();
  TimedRunner(const TimedRunner&) = delete;
  TimedRunner& operator=(const TimedRunner&) = delete;

  /// The rights that the thread was refused; they are empty without a request.
  [[nodiscard]] const std::vector<RealTimeRight>& rights() const { return rights_; }
  /// Until it is over. Where the audience throws, somebody wants to leave: the act is told so, and what was
  /// thrown is thrown on once the act is over, since the thread uses it until then.
  ActEnd run(LoopTask& act, std::optional<std::int64_t> last);

  // Once no act runs.
  [[nodiscard]] WakeLatency latency() const { return latencies_.summary(); }
  [[nodiscard]] std::int64_t late_ticks() const { return late_ticks_; }

 private:
  void live(const std::optional<RealTimeRequest>& request);
  void loop();
  void tick(std::int32_t ticks, std::int64_t now_ns);
  void attend(std::optional<std::int64_t> last);

  RunLoop& loop_;
  std::int32_t rate_hz_;
  const LoopAudience& audience_;
  LoopTrace& trace_;
  Lateness lateness_;
  std::int64_t next_line_ns_ = 0;
  TransportKeys keys_;
  TelemetryRing<TransportKey, 64> typed_;
  TelemetryRing<RunSnapshot, 64> shown_;
  std::atomic<LoopTask*> next_{nullptr};
  std::atomic<bool> is_over_{false};
  std::atomic<bool> leaves_{false};
  std::atomic<bool> has_rights_{false};
  std::vector<RealTimeRight> rights_;
  // of the loop's thread while an act runs
  LoopTask* act_ = nullptr;
  ActEnd end_;
  WakeLatencyCounter latencies_;
  std::int64_t late_ticks_ = 0;
  std::int64_t until_shown_ = 0;
  std::thread thread_;
};

/// Throws InputError at the rig file of a rig that is to be moved without a right that it needs, with how to
/// get it.
void refuse_unfit_machine(const std::string& rig_path, const std::vector<RealTimeRight>& rights);

}  // namespace inbetween
