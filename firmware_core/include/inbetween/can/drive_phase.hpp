#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

/// The phases of a drive as its host sees them; one table says what leads from one to the next.

namespace inbetween::can {

enum class DrivePhase : std::uint8_t {
  off,          ///< nobody has asked for this drive
  booting,      ///< a sign of life is awaited, after a reset where the protocol has one
  configuring,  ///< it is checked, and set up where the protocol can
  starting,     ///< it has been told to be Operational; its heartbeat and process data are awaited
  idle,         ///< process data flow, no power; its target is where it is
  clearing,     ///< a fault is being reset
  enabling,     ///< on the way to operation enabled; its target is where it is, then held
  following,    ///< takes targets
  stopping,     ///< the drive's own quick stop, and the rest after it
  disabling,    ///< being switched off: until it tells that it has no power, and the axis rests
  disabled,     ///< that is so; the other drives of the rig are waited for
  leaving,      ///< out of Operational, and its watchdogs are taken away: after that it is off
  abandoned,    ///< it did not do so in time: it is told nothing, and its own watchdogs stay on
  refused,      ///< it could not be set up: findings() and refusal() say why
  gone,         ///< it has started anew or left Operational: it must be set up again
};
inline constexpr std::size_t drive_phases = 15;

enum class DriveEvent : std::uint8_t {
  // requests of the caller
  connect,     ///< set the drive up from the beginning
  enable,      ///< switch it on; a fault is reset first
  disable,     ///< switch it off, out of operation by its own ramp, and see that it is
  leave,       ///< it may be let go: every axis of the rig rests without power
  quick_stop,  ///< stop it by its own ramp
  disconnect,  ///< say nothing more to it
  // what happens
  booted,
  configured,
  refused,
  started,
  cleared,         ///< no fault is there
  enabled,         ///< operation enabled, mode and bit 12 as they shall be
  dropped_out,     ///< not operation enabled any more, or something was found on the way there
  stopped_itself,  ///< it is in a quick stop of its own
  timed_out,       ///< the phase has lasted too long
  vanished,        ///< it has started anew or left Operational
  disabled,        ///< it has no power, and its axis rests
  left,            ///< it watches this program no more
};
inline constexpr std::size_t drive_events = 18;

struct DriveStep {
  DrivePhase phase;
  bool is_refused;  ///< a request that is not for this phase
};
/// The whole table. Nothing leads to following but enable, cleared and enabled, in this order.
DriveStep next_phase(DrivePhase phase, DriveEvent event);

/// The phase of a drive, since when it is in it, and when it must have left it. Every phase begins without a
/// deadline, so that none has that of another. O(1).
class PhaseClock {
 public:
  /// False: the phase does not allow the request. `enter` is called where a new phase has begun, and may set
  /// its deadline.
  template <class Enter>
  bool apply(DriveEvent event, std::int64_t now_ns, const Enter& enter) {
    const DriveStep step = next_phase(phase_, event);
    if (step.is_refused) return false;
    if (step.phase == phase_) return true;
    before_ = phase_;
    phase_ = step.phase;
    since_ns_ = now_ns;
    deadline_ns_ = never;
    enter();
    return true;
  }
  void set_deadline(std::int64_t deadline_ns) { deadline_ns_ = deadline_ns; }
  void clear_deadline() { deadline_ns_ = never; }

  [[nodiscard]] DrivePhase phase() const { return phase_; }
  [[nodiscard]] DrivePhase before() const { return before_; }
  [[nodiscard]] std::int64_t since_ns() const { return since_ns_; }
  [[nodiscard]] bool is_late(std::int64_t now_ns) const { return now_ns >= deadline_ns_; }

  /// It is being switched on: a finding ends that.
  [[nodiscard]] bool is_switching_on() const { return phase_ == clearing || phase_ == enabling; }
  /// It has been told to have power.
  [[nodiscard]] bool is_to_have_power() const {
    return phase_ == enabling || phase_ == following || phase_ == stopping;
  }
  /// It has to tell how and where it is.
  [[nodiscard]] bool is_supervised() const {
    return phase_ == idle || phase_ == clearing || is_to_have_power();
  }
  [[nodiscard]] bool is_leaving() const {
    return phase_ == disabling || phase_ == disabled || phase_ == leaving;
  }

 private:
  using enum DrivePhase;
  static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();
  DrivePhase phase_ = off;
  DrivePhase before_ = off;
  std::int64_t since_ns_ = 0;
  std::int64_t deadline_ns_ = never;
};

}  // namespace inbetween::can
