// A rig that is set up: switched on, moved without a drawn move, switched off.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/loop/rig_loop.hpp"
#include "host_tools/reference/rig_reference.hpp"

namespace inbetween {

struct SessionOptions {
  bool simulated = false;
  /// Simulated: on a virtual clock, as fast as it can be computed.
  bool fast = false;
  /// A real rig: without the rights of a real-time program.
  bool allow_jitter = false;
  /// Where simulated axes really stand, by name. The others stand where the reference knows them, or else as
  /// near to 0 as their limits allow.
  std::map<std::string, double> standing = {};
  LoopAudience audience = {};
};

/// The motion loop of a rig that is set up. Refers to the rig and the reference.
///
/// The order is: arm, about_to_move of the reference, perform, rest; as often as wanted; disarm, before what
/// was performed goes (DisarmAtEnd). Whatever happens the drives are switched off at the end.
class RigSession {
 public:
  /// Opens the drives and the lines. Throws InputError where something is not there, or the machine is not
  /// fit to run in real time.
  RigSession(const RigFile& rig, RigReference& reference, const SessionOptions& options);
  ~RigSession();
  RigSession(const RigSession&) = delete;
  RigSession& operator=(const RigSession&) = delete;

  /// Whether the drives are on; otherwise trouble() says why they are not.
  bool arm();
  /// Where every axis stands as its drive tells, after arm() and after rest().
  [[nodiscard]] const std::vector<double>& positions() const { return positions_; }
  /// Until it is over.
  ActEnd perform(const LoopTask& act, std::optional<std::int64_t> last = std::nullopt);
  /// Waits until the axes stand still, and tells the reference where.
  void rest();
  /// The same, of what the drives have told in the tick in which everything rested.
  void keep(const std::vector<DriveState<double>>& states);
  /// At once, or after a stop if something still moves. Nothing if it is not armed.
  void disarm();

  /// What is wrong and what to do; "" for nothing.
  [[nodiscard]] std::string trouble() const { return rig_loop_->trouble(); }
  [[nodiscard]] RunLoop& loop() { return rig_loop_->loop(); }
  [[nodiscard]] RigInputs& lines() { return rig_loop_->lines(); }
  [[nodiscard]] double tick_seconds() const { return rig_loop_->tick_seconds(); }
  [[nodiscard]] const RigFile& rig() const { return rig_loop_->rig(); }
  /// The setpoints of a tick are reached so much later.
  [[nodiscard]] std::int64_t delay_ns() const { return rig_loop_->delay_ns(); }

 private:
  RigReference& reference_;
  std::unique_ptr<RigLoop> rig_loop_;
  std::vector<double> positions_;
  bool is_armed_ = false;
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

/// Why the session did not do what it was to: what is wrong with the rig, or else `otherwise`.
std::string reason_of(const RigSession& session, const std::string& otherwise);

}  // namespace inbetween
