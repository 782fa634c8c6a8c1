// A rig in use: switched on, moved, switched off.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host_tools/loop/loop_runner.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/loop/run_loop.hpp"
#include "host_tools/loop/run_record.hpp"
#include "host_tools/reference/rig_reference.hpp"
#include "host_tools/rig/fault_script.hpp"

namespace inbetween {

/// The share of its velocity that an axis may have in a loop without the rights of a real-time program
/// (SessionOptions::allow_jitter): faster, a late tick could make it jump.
inline constexpr double jitter_share = 0.1;

/// Thrown instead of what was thrown where, after it, a drive may have power though everything was done to
/// switch it off. what() is a line for each and says what to do.
class PowerLeftError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Which rig is used: that of the machine, or one in this process.
struct SessionOptions {
  bool simulated = false;
  /// Simulated: on a virtual clock, as fast as it can be computed.
  bool fast = false;
  /// A real rig: without the rights of a real-time program.
  bool allow_jitter = false;
  /// The true places of simulated axes, by name. The others stand where the reference knows them, or else as
  /// near to 0 as their limits allow.
  std::map<std::string, double> standing = {};
  /// The faults of simulated drives, for the same rig.
  FaultScript faults = {};
  /// A line a tick goes there (run_record.hpp).
  std::optional<std::string> record = {};
  /// Every tick goes there, which lasts longer.
  TickSink* take = nullptr;
  /// Simulated: a line for each edge on a STEP line goes there (step_log.hpp).
  std::optional<std::string> steps = {};
  /// " --sim --positions FILE": the arguments by which another command has the same rig.
  std::string as_arguments = {};
  LoopAudience audience = {};
};

/// The motion loop of a rig with all that is under it, simulated or real, and what ticks it. Refers to the
/// rig and the reference.
///
/// The order in `use` is: arm, about_to_move of the reference, perform, rest; as often as wanted; disarm,
/// before what was performed goes (DisarmAtEnd). Whatever happens the drives are switched off at the end.
class RigSession {
 public:
  /// Opens the drives and the lines, and ticks from now on, between acts as well unless it is fast. Throws
  /// InputError where something is not there, or the machine is not fit to run in real time; what RunRecord
  /// throws.
  RigSession(const RigFile& rig, RigReference& reference, const SessionOptions& options);
  ~RigSession();
  RigSession(const RigSession&) = delete;
  RigSession& operator=(const RigSession&) = delete;

  /// Does the task and switches off. Returns which drive may have power then (RigDrives::left_on); where the
  /// task throws and one may, throws PowerLeftError.
  std::string use(const std::function<void()>& task);
  /// Whether the drives are on; otherwise trouble() says why they are not. Throws what
  /// RigReference::compare throws.
  bool arm();
  /// The position of every axis as its drive told it, after arm() and after rest().
  [[nodiscard]] const std::vector<double>& positions() const { return positions_; }
  /// Until it is over. With the `last` of its ticks, if that is known, progress is told.
  ActEnd perform(LoopTask& act, std::optional<std::int64_t> last = std::nullopt);
  /// Waits until the axes stand still, and tells the reference where. Says which axis is not where it was
  /// told to be, and what to do; "" if all are, or were stopped.
  std::string rest();
  /// The same, of what the drives have told in the tick in which everything rested.
  void keep(const std::vector<DriveState>& states);
  /// At once, or after a stop if something still moves. Nothing if it is not armed.
  void disarm();
  /// Disarmed, and no tick follows.
  void end();

  /// Says what is wrong with a line or a drive and what to do; "" if nothing is.
  [[nodiscard]] std::string trouble() const;
  [[nodiscard]] const SessionOptions& options() const { return options_; }
  [[nodiscard]] RunLoop& loop() { return loop_; }
  [[nodiscard]] LoopTrace& trace() { return trace_; }
  [[nodiscard]] RigInputs& lines() { return lines_; }
  [[nodiscard]] const RigDrives& drives() const { return drives_; }
  [[nodiscard]] RigHardware& hardware() { return *hardware_; }
  [[nodiscard]] const RigFile& rig() const { return rig_; }
  [[nodiscard]] double tick_seconds() const { return 1.0 / rig_.rate_hz; }
  /// The setpoints of a tick are reached so much later.
  [[nodiscard]] std::int64_t delay_ns() const;

  // After the end.

  [[nodiscard]] const std::vector<AxisTrace>& axes() const { return trace_.axes(); }
  [[nodiscard]] const WakeLatency& latency() const { return latency_; }
  [[nodiscard]] std::int64_t late_ticks() const { return late_ticks_; }
  [[nodiscard]] std::optional<LoopLogEnd> end_record();

 private:
  void start();
  void tell_notes();

  const RigFile& rig_;
  RigReference& reference_;
  SessionOptions options_;
  std::vector<double> positions_;
  std::unique_ptr<RigHardware> hardware_;
  RigInputs lines_;
  RigDrives drives_;
  LoopStorage storage_;
  RunLoop loop_;
  std::unique_ptr<RunRecord> record_;
  LoopTrace trace_;
  WakeLatency latency_;
  std::int64_t late_ticks_ = 0;
  bool is_armed_ = false;
  bool has_told_notes_ = false;
  // One of them, destroyed first.
  std::optional<FastRunner> fast_;
  std::optional<TimedRunner> timed_;
};

/// Switches the rig off at the end of a block: made after what its loop plays, which goes later.
class DisarmAtEnd {
 public:
  explicit DisarmAtEnd(RigSession& session) : session_(session) {}
  ~DisarmAtEnd() { session_.disarm(); }
  DisarmAtEnd(const DisarmAtEnd&) = delete;
  DisarmAtEnd& operator=(const DisarmAtEnd&) = delete;

 private:
  RigSession& session_;
};

/// How the use of a rig ended.
struct SetupEnd {
  bool is_done = false;
  std::string reason = {};             ///< in words; also of what is done
  std::vector<double> positions = {};  ///< where every axis of the rig rests, as far as its drive tells
};

/// RigSession::use for a task that ends like this: it is not done where a drive may have power after it.
SetupEnd end_of(RigSession& session, const std::function<SetupEnd()>& task);

/// Why the session did not do what it was to: what is wrong with the rig, or else `otherwise`.
std::string reason_of(const RigSession& session, const std::string& otherwise);

}  // namespace inbetween
