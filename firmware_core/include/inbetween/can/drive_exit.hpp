#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/cia402.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/can/sdo_client.hpp"

/// The words of the host to a drive by SDO at the end: where no process data flow it asks for the state and
/// orders power off, and when the drive is off it takes the drive's watchdogs away.

namespace inbetween::can {

enum class ExitState : std::uint8_t {
  silent,     ///< nothing is said
  asking,     ///< statusword (6041), position (6064) and controlword (6040), over and over
  releasing,  ///< the watchdogs of release_steps() get 0, one after the other
  released,   ///< all of them have it, or are not in this drive
  failed,     ///< the drive did not answer, or refused
};
inline constexpr std::size_t exit_states = 5;

enum class ExitEvent : std::uint8_t {
  hush,          ///< nothing more is to be said
  ask,           ///< process data do not flow
  release,       ///< the drive is off
  all_released,  ///< the last watchdog has been answered for
  refused,       ///< the drive did not answer, or refused what must not be refused
};
inline constexpr std::size_t exit_events = 5;

/// The whole table.
ExitState next_state(ExitState state, ExitEvent event);

/// One request at a time, each bounded by the timeout of an SDO transfer. O(1), no allocation.
class DriveExit {
 public:
  constexpr DriveExit(NodeId node, std::int64_t sdo_timeout_ns, bool is_guarded)
      : client_(node, sdo_timeout_ns), is_guarded_(is_guarded) {}

  void hush() { apply(ExitEvent::hush); }
  /// Goes on if it is asking already.
  void ask() { apply(ExitEvent::ask); }
  /// Nothing is written that the drive does not have, by the index of the object. `rpdo` carried its targets.
  void release(std::span<const std::uint16_t> absent, std::uint8_t rpdo);

  /// At most one frame. `controlword` is what the drive is ordered while it is asked; nothing is ordered
  /// without: then another frame does that.
  std::optional<Frame> poll(std::optional<std::uint16_t> controlword, std::int64_t now_ns);
  /// An SDO answer of the drive. False: not what was waited for.
  bool receive(const Frame& frame) { return client_.receive(frame); }
  /// The answers of the drive, each once. The mode of operation is not asked for.
  std::optional<DriveFeedback> take_feedback();

  [[nodiscard]] ExitState state() const { return state_; }

 private:
  void apply(ExitEvent event);
  void has_answered();
  void begin_question(std::optional<std::uint16_t> controlword);
  void begin_release();

  SdoClient client_;
  [[nodiscard]] bool is_absent_here(std::size_t step) const;
  bool is_guarded_;
  std::uint8_t rpdo_ = 1;
  std::uint8_t absent_ = 0;  ///< a bit for each watchdog
  ExitState state_ = ExitState::silent;
  std::size_t step_ = 0;
  bool is_begun_ = false;  ///< the transfer of this step
  DriveFeedback told_;
  bool has_told_ = false;
};

}  // namespace inbetween::can
