#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/cia402.hpp"
#include "inbetween/can/cia402_setup.hpp"
#include "inbetween/can/drive_counters.hpp"
#include "inbetween/can/drive_exit.hpp"
#include "inbetween/can/drive_finding.hpp"
#include "inbetween/can/drive_phase.hpp"
#include "inbetween/can/emergency.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/can/heartbeat.hpp"
#include "inbetween/can/rest_watch.hpp"

/// One CiA 402 drive as the host sees it: set up, switched on, given a target every tick, watched.

namespace inbetween::can {

/// How a drive is set up and watched. Times in nanoseconds.
struct Cia402Settings {
  Cia402Setup setup;
  /// There if the setup has a homing: what this host makes of it.
  std::optional<DriveHomingSpec> homing = {};
  /// The furthest that a target may be from the last one, in counts: 1.2 times what max_velocity covers in a
  /// tick. A larger step is not sent.
  std::int32_t max_step_counts = 0;
  /// The furthest that the axis may be from its held target from when it is switched on until its first
  /// target.
  std::int32_t hold_tolerance_counts = 100;
  /// The furthest that the first target may be from the held one: what the axis covers from rest in a tick,
  /// at least a count. A first target that is further is not sent.
  std::int32_t first_step_counts = 100;
  /// The furthest that the axis may be from its target, whatever the drive makes of that.
  std::int32_t max_following_error_counts = std::numeric_limits<std::int32_t>::max();
  /// Ticks in a row without feedback that are a finding; one may always come late.
  std::int32_t missing_limit = 3;
  /// Bad frames that are still no finding; one is forgiven in every `bad_frame_ticks`.
  std::int32_t bad_frame_limit = 8;
  std::int32_t bad_frame_ticks = 250;
  std::int64_t boot_timeout_ns = 5'000'000'000;
  std::int64_t sdo_timeout_ns = 500'000'000;
  std::int64_t enable_timeout_ns = 5'000'000'000;  ///< for brake and commutation
  std::int64_t stop_timeout_ns = 1'000'000'000;    ///< until it answers a quick stop, or its fault is reset
  /// How it is told to start anew. A drive that is reset as a whole may forget where it is.
  NmtCommand reset = NmtCommand::reset_communication;
  /// How long the drive may take for its ramp, its brake and its power stage while it switches off.
  std::int64_t disable_timeout_ns = 2'000'000'000;
  /// The axis rests where it has not been further than this, in counts, from one place for rest_ns.
  std::int32_t rest_counts = 10;
  std::int64_t rest_ns = 50'000'000;
  /// Some drives clear bit 12, or set bit 11, for a moment; and bit 7 a moment after the emergency that
  /// warns.
  std::int64_t ignore_grace_ns = 20'000'000;
  /// Some drives show no mode, 0, until they are enabled. One that does so for this long is enabled first,
  /// and stopped where it does not show the right mode within ignore_grace_ns.
  std::int64_t mode_wait_ns = 200'000'000;
  std::int64_t heartbeat_timeout_ns = 150'000'000;
};

/// The order in a tick k, with tick() of every drive first (Cia402Bus does it for a bus):
/// SYNC; command(target of tick k + 1) of every drive; service() of one drive.
/// Frames that arrive between ticks go to receive(). Nothing here waits, allocates or asks for the time;
/// every call is O(1).
class Cia402Drive {
 public:
  using Place = std::int64_t;   ///< counts
  using Target = std::int32_t;  ///< counts
  /// To the nearest count.
  static Place place_of(double counts) { return static_cast<Place>(std::floor(counts + 0.5)); }
  /// BusDrive. The velocity is the drive's own to find.
  static std::optional<Target> target_of(double counts, double /*counts_per_s*/, Place zero) {
    const double count = std::floor(counts + 0.5) + static_cast<double>(zero);
    constexpr auto max_count = static_cast<double>(std::numeric_limits<Target>::max() - 128);
    if (!(std::fabs(count) <= max_count)) return {};
    return static_cast<Target>(count);
  }

  /// Errors: those of write_setup_script; out_of_range (a limit or time that is not positive, a heartbeat
  /// timeout of less than two periods).
  static Result<Cia402Drive> make(const Cia402Settings& settings);

  [[nodiscard]] NodeId node() const { return settings_.setup.node; }
  /// The limits of positions that it will be told in its next set-up. Errors: those of write_setup_script;
  /// wrong_state (it is in use). Then nothing changes.
  Status set_position_limits(const CountRange& limits);
  [[nodiscard]] Cia402Mode mode() const { return settings_.setup.mode; }
  /// Which RPDO carries its targets: the first that can be mapped so.
  [[nodiscard]] std::uint8_t rpdo() const { return settings_.setup.rpdo; }
  [[nodiscard]] NodeId host() const { return settings_.setup.host; }
  [[nodiscard]] std::uint8_t sync_overflow() const { return settings_.setup.sync_overflow; }
  /// How long the drive is to believe that the host lives.
  [[nodiscard]] std::int64_t host_timeout_ns() const {
    return settings_.setup.host_timeout_ms * std::int64_t{1'000'000};
  }

  // The caller requests these. They return false where the phase does not allow it.
  bool connect(std::int64_t now_ns) { return apply(DriveEvent::connect, now_ns); }
  /// Also refused while there are findings: acknowledge them first.
  bool enable(std::int64_t now_ns) { return log_.empty() && apply(DriveEvent::enable, now_ns); }
  /// Leads to DrivePhase::disabled, or to abandoned within disable_timeout_ns and a transfer of SDO. A drive
  /// to which nothing has been written is left as it is.
  bool disable(std::int64_t now_ns) {
    return apply(has_written_ ? DriveEvent::disable : DriveEvent::disconnect, now_ns);
  }
  /// Takes the power away at once, whether the axis rests or not.
  bool cut(std::int64_t now_ns) {
    is_cut_ = true;
    return disable(now_ns);
  }
  /// Only a disabled drive takes this. It then is off, or is abandoned within two boot_timeout_ns.
  bool leave(std::int64_t now_ns) { return apply(DriveEvent::leave, now_ns); }
  bool quick_stop(std::int64_t now_ns) { return apply(DriveEvent::quick_stop, now_ns); }
  bool disconnect(std::int64_t now_ns) { return apply(DriveEvent::disconnect, now_ns); }
  /// Somebody has seen the findings. Those whose cause lasts come back with the next tick.
  void acknowledge();

  /// Takes a CANopen frame of this node.
  void receive(const Frame& frame, std::int64_t now_ns);
  /// Somebody else has sent what only the host sends.
  void note_foreign_frame();
  /// The host's heartbeat has been sent: from the first one on the drive watches it. A guarded drive watches
  /// the question that is to be sent with it, from when it is set up until it is let go.
  std::optional<Frame> note_host_heartbeat();

  /// Once a tick, before anything is sent: what was missed, what was found, which phase follows.
  void tick(std::int64_t now_ns);
  /// Whether the drive sends process data when it hears SYNC.
  [[nodiscard]] bool has_process_data() const;
  /// Whether SYNC must go on for it: a drive that is about to leave may still watch it.
  [[nodiscard]] bool needs_sync() const { return has_process_data() || phase() == DrivePhase::leaving; }
  /// Whether it needs the host's heartbeat. A drive that was abandoned shall miss it.
  [[nodiscard]] bool is_in_use() const {
    return phase() != DrivePhase::off && phase() != DrivePhase::abandoned;
  }
  /// Whether it is being switched off, and has to be ticked on.
  [[nodiscard]] bool is_leaving() const { return clock_.is_leaving(); }
  /// The frame of this tick, if there is one. `target`, in counts, is used while following. Once a target
  /// has been given, none is sent without: setpoints have ceased, and the drive's own watchdog stops the
  /// motor.
  std::optional<Frame> command(std::optional<std::int32_t> target);
  /// Whether it follows targets that have been given.
  [[nodiscard]] bool is_commanded() const { return phase() == DrivePhase::following && is_commanded_; }
  /// Whether service() has something to send.
  [[nodiscard]] bool wants_service() const;
  /// At most one frame of NMT or SDO.
  std::optional<Frame> service(std::int64_t now_ns);

  /// Its homing by itself, to be started while it is following; null for a drive that takes targets.
  [[nodiscard]] Cia402Homing* homing() { return homing_ ? &*homing_ : nullptr; }

  [[nodiscard]] DrivePhase phase() const { return clock_.phase(); }
  /// Whether it has told something of itself, and not that it has no power.
  [[nodiscard]] bool may_have_power() const { return has_feedback_ && !has_no_power(); }
  [[nodiscard]] const DriveFindings& findings() const { return log_.all(); }
  /// Those of the last tick whose cause is still there.
  [[nodiscard]] const DriveFindings& lasting() const { return log_.lasting(); }
  /// Tells which came first of those that nobody has acknowledged.
  [[nodiscard]] std::optional<DriveFinding> first_finding() const { return log_.first(); }
  [[nodiscard]] const SetupRefusal& refusal() const { return runner_.refusal(); }
  /// The last that had a code: that an error is gone does not say which it was.
  [[nodiscard]] const Emergency& last_emergency() const { return last_emergency_; }
  [[nodiscard]] const DriveCounters& counters() const { return counters_; }
  [[nodiscard]] HeartbeatState heartbeat() const { return heartbeat_.state(); }
  /// The watchdogs of the drive, as read back.
  [[nodiscard]] const SetupRunner& setup() const { return runner_; }
  /// The last feedback of the drive; all 0 before the first.
  [[nodiscard]] const DriveFeedback& feedback() const { return feedback_; }
  [[nodiscard]] Cia402State state() const { return state_of(feedback_.statusword); }
  /// BusDrive.
  [[nodiscard]] Place held_place() const {
    return phase() == DrivePhase::following && !is_commanded_ ? target_ : feedback_.actual;
  }
  /// The target that was sent last, in counts.
  [[nodiscard]] std::int32_t target() const { return target_; }

 private:
  explicit Cia402Drive(const Cia402Settings& settings);
  bool apply(DriveEvent event, std::int64_t now_ns) {
    return clock_.apply(event, now_ns, [&] { enter(now_ns); });
  }
  void enter(std::int64_t now_ns);
  void take_heartbeat(const Frame& frame, std::int64_t now_ns);
  [[nodiscard]] std::optional<NmtState> heard_in(const Frame& frame);
  void take_emergency(const Frame& frame, std::int64_t now_ns);
  void take_feedback(const Frame& frame, std::int64_t now_ns);
  void judge_emergency(std::int64_t now_ns);
  bool may_be_enabled(std::int64_t now_ns);
  void take_boot_up(std::int64_t now_ns);
  void watch_heartbeat(std::int64_t now_ns);
  void count_ticks();
  void watch_connection(std::int64_t now_ns);
  void advance(std::int64_t now_ns);
  void advance_configuring(std::int64_t now_ns);
  [[nodiscard]] bool tries_another_rpdo();
  void use_rpdo(std::uint8_t number);
  [[nodiscard]] bool may_have_been_operational() const;
  void advance_starting(std::int64_t now_ns);
  void advance_clearing(std::int64_t now_ns);
  void advance_enabling(std::int64_t now_ns);
  void watch_following(std::int64_t now_ns);
  void watch_deadline(std::int64_t now_ns);
  [[nodiscard]] DriveFinding why_late() const;
  // switching off
  void enter_leaving(std::int64_t now_ns);
  void advance_disabling(std::int64_t now_ns);
  void advance_leaving(std::int64_t now_ns);
  void give_up_disabling(std::int64_t now_ns);
  [[nodiscard]] bool hears_commands() const;
  [[nodiscard]] bool has_no_power() const;
  [[nodiscard]] bool goes_off() const;
  [[nodiscard]] bool has_lost_touch_by_fault() const;
  [[nodiscard]] std::uint16_t disabling_controlword() const;
  [[nodiscard]] bool is_in_mode() const { return feedback_.mode == settings_.setup.mode_of_operation(); }
  [[nodiscard]] bool interpolates() const {
    return !homing_ && settings_.setup.mode == Cia402Mode::interpolated_position;
  }
  [[nodiscard]] bool status_has(std::uint16_t bit) const { return (feedback_.statusword & bit) != 0; }
  [[nodiscard]] bool holds_its_place() const;
  [[nodiscard]] bool is_within_limits() const;
  [[nodiscard]] std::uint16_t controlword() const;
  void choose_target(std::optional<std::int32_t> target);

  Cia402Settings settings_;
  SetupScript script_;
  SetupRunner runner_;
  DriveExit exit_;
  HeartbeatConsumer heartbeat_;
  std::optional<Cia402Homing> homing_;
  PhaseClock clock_;
  FindingLog log_;
  RestWatch rest_;  ///< disabling
  DriveCounters counters_;
  Emergency last_emergency_;
  DriveFeedback feedback_;
  std::optional<NmtCommand> order_;  ///< to be sent by service()
  NmtState heard_ = NmtState::boot_up;
  bool guard_toggle_ = false;         ///< of the next answer of a guarded drive
  std::int32_t guard_questions_ = 0;  ///< since the last answer that counted; two or more say the same
  std::int64_t followed_ns_ = 0;      ///< when bit 12 was seen last
  std::int64_t unlimited_ns_ = 0;     ///< and when bit 11 was clear
  std::optional<std::int64_t>
      emergency_ns_;  ///< when one came of which it is not known whether it only warns
  std::int32_t target_ = 0;
  std::int32_t awaited_ = 0;  ///< feedback that SYNC has asked for, at most the present and one late
  std::int32_t missed_in_row_ = 0;
  std::optional<std::int64_t> modeless_ns_;  ///< enabling: since when it has power and shows mode 0
  std::optional<std::int64_t> enabled_ns_;   ///< enabling: since when it is in operation
  bool has_feedback_ = false;                ///< in this phase or one before, since it was started
  bool is_fresh_ = false;                    ///< feedback has come since the last tick
  bool host_heartbeat_sent_ = false;
  bool has_tried_all_rpdos_ = false;  ///< and tells why the first one cannot be used
  std::uint8_t strays_ = 0;           ///< configuring: answers that nobody had asked for
  bool resets_now_ = false;           ///< clearing: the bit that resets a fault is set
  bool is_seeded_ = false;            ///< enabling: the target is held
  bool is_commanded_ = false;         ///< following: a target has been given
  bool has_written_ = false;          ///< its set-up has begun to write, since it was connected
  bool has_booted_again_ = false;     ///< since its reset was sent: the first boot-up was of its power-on
  bool was_sent_back_ = false;  ///< to pre-operational, since it was connected: it had started by itself
  /// It has left Operational by itself, or reported a fault of communication, since it was connected. When it
  /// leaves, its communication starts anew, which forgets such a fault.
  bool has_lost_touch_ = false;
  bool is_cut_ = false;  ///< its power goes at once
};

}  // namespace inbetween::can
