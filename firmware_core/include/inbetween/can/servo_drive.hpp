#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/can/drive_counters.hpp"
#include "inbetween/can/drive_finding.hpp"
#include "inbetween/can/drive_phase.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/can/servo_report.hpp"

/// A servo drive that knows positions in turns and no SYNC, as its host sees it: watched, proven to stop
/// alone, switched on, given a target every tick (BusDrive). A protocol says only how orders look and what
/// frames mean.

namespace inbetween::can {

/// Times in nanoseconds, positions in turns.
struct ServoSettings {
  /// The furthest that a target may be from the last one, and the fastest that one may be meant to go. A
  /// target beyond is not sent.
  double max_step_turns = 0;
  double max_turns_per_s = 0;
  /// The furthest that the axis may be from its held target from when it is switched on until its first
  /// target, and that the first target may be from the held one.
  double hold_tolerance_turns = 0;
  double first_step_turns = 0;
  /// The furthest that the axis may be from its target: the drive does not watch that itself.
  double max_following_error_turns = 0;
  /// The axis rests where it has not been further than this from one place for rest_ns.
  double rest_turns = 0;
  std::int64_t rest_ns = 50'000'000;
  std::int64_t place_timeout_ns = 50'000'000;    ///< of what it tells of its position
  std::int64_t status_timeout_ns = 350'000'000;  ///< of what it tells of itself
  std::int64_t boot_timeout_ns = 5'000'000'000;
  std::int64_t identity_timeout_ns = 300'000'000;  ///< for its answer what it is
  /// Until it must have told that its watchdog has expired.
  std::int64_t watchdog_timeout_ns = 1'000'000'000;
  std::int64_t enable_timeout_ns = 5'000'000'000;
  std::int64_t stop_timeout_ns = 1'000'000'000;
  std::int64_t disable_timeout_ns = 2'000'000'000;
  std::int64_t repeat_ns = 100'000'000;  ///< an order that is not obeyed is given again
  /// Bad frames that are still no finding; one is forgiven in every `bad_frame_ticks`.
  std::int32_t bad_frame_limit = 8;
  std::int32_t bad_frame_ticks = 250;
};

/// In a tick: tick(), command() of the target of the next tick, service(). A target is held for a tick and
/// sent then, so that it acts when a drive with SYNC would begin to go there. Nothing waits; every call is
/// O(1).
///
/// Only a frame of command() feeds the drive's watchdog while it follows, and it comes only with a target.
/// Whether that watchdog works is tried out before the drive is switched on: it is fed until it tells that it
/// is well, then not, and must tell that its watchdog has expired.
template <class Protocol>
class ServoDrive {
 public:
  using Place = double;  ///< turns
  using Target = ServoTarget;
  template <Precise Real>
  static Place place_of(Real turns) {
    return static_cast<Place>(turns);
  }
  template <Precise Real>
  static std::optional<Target> target_of(Real turns, Real turns_per_s, Place zero) {
    const Target target{.turns = static_cast<Place>(turns) + zero,
                        .turns_per_s = static_cast<double>(turns_per_s)};
    if (!std::isfinite(target.turns) || !Protocol::fits(target)) return {};
    return target;
  }

  /// Errors: out_of_range (a limit or time that is not positive).
  static Result<ServoDrive> make(const Protocol& protocol, const ServoSettings& settings) {
    const ServoSettings& s = settings;
    const bool is_sensible = s.max_step_turns > 0 && s.max_turns_per_s > 0 && s.hold_tolerance_turns > 0 &&
                             s.first_step_turns > 0 && s.max_following_error_turns > 0 && s.rest_turns > 0 &&
                             s.rest_ns > 0 && s.place_timeout_ns > 0 && s.status_timeout_ns > 0 &&
                             s.boot_timeout_ns > 0 && s.identity_timeout_ns > 0 &&
                             s.watchdog_timeout_ns > 0 && s.enable_timeout_ns > 0 && s.stop_timeout_ns > 0 &&
                             s.disable_timeout_ns > s.rest_ns && s.repeat_ns > 0 && s.bad_frame_limit >= 0 &&
                             s.bad_frame_ticks > 0;
    if (!is_sensible) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "a limit or time of a drive is not positive",
                   .remedy = "give positive limits"};
    }
    return ServoDrive(protocol, settings);
  }

  [[nodiscard]] const Protocol& protocol() const { return protocol_; }

  // BusDrive.
  bool connect(std::int64_t now_ns) { return apply(DriveEvent::connect, now_ns); }
  bool enable(std::int64_t now_ns) { return findings_.empty() && apply(DriveEvent::enable, now_ns); }
  bool disable(std::int64_t now_ns) { return apply(DriveEvent::disable, now_ns); }
  bool leave(std::int64_t now_ns) { return apply(DriveEvent::leave, now_ns); }
  bool quick_stop(std::int64_t now_ns) { return apply(DriveEvent::quick_stop, now_ns); }
  void acknowledge() {
    findings_.clear();
    first_finding_.reset();
    bad_frame_level_ = 0;
  }

  void receive(const Frame& frame, std::int64_t now_ns);
  void tick(std::int64_t now_ns);
  /// Nothing where it is not to be fed: among others where it has followed and there is no target now.
  std::optional<Frame> command(const std::optional<Target>& target);
  /// At most one order. Not after setpoints have ceased: some drives take every frame for a sign of life.
  std::optional<Frame> service(std::int64_t now_ns);

  [[nodiscard]] DrivePhase phase() const { return phase_; }
  [[nodiscard]] const DriveFindings& findings() const { return findings_; }
  [[nodiscard]] const DriveFindings& lasting() const { return lasting_; }
  [[nodiscard]] std::optional<DriveFinding> first_finding() const { return first_finding_; }
  [[nodiscard]] bool is_leaving() const {
    return phase_ == DrivePhase::disabling || phase_ == DrivePhase::disabled || phase_ == DrivePhase::leaving;
  }
  [[nodiscard]] bool is_commanded() const { return phase_ == DrivePhase::following && is_commanded_; }
  [[nodiscard]] Place held_place() const {
    return phase_ == DrivePhase::following && !is_commanded_ ? sent_.turns : place_.turns;
  }
  [[nodiscard]] const ServoPlace& place() const { return place_; }
  [[nodiscard]] const ServoStatus& status() const { return status_; }
  /// The last errors that it told, until they are acknowledged by a new set-up.
  [[nodiscard]] std::uint32_t last_errors() const { return last_errors_; }
  /// After how long at most it told that its watchdog had expired; 0: not tried yet.
  [[nodiscard]] std::int64_t proven_watchdog_ns() const { return proven_ns_; }
  [[nodiscard]] const DriveCounters& counters() const { return counters_; }

 private:
  using enum DrivePhase;
  static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

  ServoDrive(const Protocol& protocol, const ServoSettings& settings)
      : protocol_(protocol), settings_(settings), ticks_to_forgive_(settings.bad_frame_ticks) {}

  bool apply(DriveEvent event, std::int64_t now_ns) {
    const DriveStep step = next_phase(phase_, event);
    if (step.is_refused) return false;
    if (step.phase != phase_) enter(step.phase, now_ns);
    return true;
  }
  void enter(DrivePhase phase, std::int64_t now_ns);
  void find(DriveFinding finding) {
    findings_.add(finding);
    if (!first_finding_) first_finding_ = finding;
  }
  void find_lasting(DriveFinding finding) {
    lasting_.add(finding);
    find(finding);
  }
  void refuse(DriveFinding finding, std::int64_t now_ns) {
    find(finding);
    apply(phase_ == booting ? DriveEvent::timed_out : DriveEvent::refused, now_ns);
  }
  void take_bad_frame() {
    ++counters_.bad_frames;
    if (++bad_frame_level_ > settings_.bad_frame_limit) find(DriveFinding::bad_frames);
  }
  /// Given at once, and again until it is obeyed: the next one takes its place.
  void give(ServoOrder order) {
    order_ = order;
    order_due_ns_ = 0;
  }

  [[nodiscard]] bool is_supervised() const {
    return phase_ == idle || phase_ == clearing || phase_ == enabling || phase_ == following ||
           phase_ == stopping;
  }
  [[nodiscard]] bool is_fed() const { return is_supervised() || (phase_ == configuring && !is_silent_); }
  [[nodiscard]] bool is_near(double turns, double tolerance) const {
    return std::fabs(place_.turns - turns) <= tolerance;
  }
  /// It has told how it is since the phase began, and some ticks after: not from before an order was heard.
  [[nodiscard]] bool has_told_since_order() const { return status_ns_ > order_heard_ns_; }

  void watch_connection(std::int64_t now_ns);
  void advance(std::int64_t now_ns);
  void advance_booting(std::int64_t now_ns);
  void advance_configuring(std::int64_t now_ns);
  void advance_enabling(std::int64_t now_ns);
  void watch_following(std::int64_t now_ns);
  void watch_rest(std::int64_t now_ns);
  void advance_disabling(std::int64_t now_ns);
  void watch_deadline(std::int64_t now_ns);
  void accept(const Target& target);

  Protocol protocol_;
  ServoSettings settings_;
  DrivePhase phase_ = off;
  DriveFindings findings_;
  DriveFindings lasting_;
  std::optional<DriveFinding> first_finding_;
  DriveCounters counters_;
  ServoPlace place_;
  ServoStatus status_;
  std::uint32_t last_errors_ = 0;
  std::int64_t place_ns_ = 0;   ///< when it told them
  std::int64_t status_ns_ = 0;  ///< 0: not since it was connected
  std::int64_t phase_ns_ = 0;   ///< since when it is in its phase
  std::int64_t phase_deadline_ns_ = never;
  std::optional<ServoOrder> order_;
  std::int64_t order_due_ns_ = 0;
  std::int64_t order_heard_ns_ = never;  ///< a status after this knows of the order
  std::optional<bool> is_expected_device_;
  bool is_silent_ = false;  ///< configuring: its watchdog is tried
  std::int64_t silent_ns_ = 0;
  std::int64_t proven_ns_ = 0;
  bool is_commanded_ = false;  ///< following: a target has been given
  ServoTarget sent_;           ///< the last one
  ServoTarget waiting_;        ///< goes out in the next tick
  double enabling_turns_ = 0;  ///< where it was when it was to be switched on
  double rest_turns_at_ = 0;
  std::int64_t rest_since_ns_ = 0;
  bool is_resting_ = false;
  std::int32_t bad_frame_level_ = 0;
  std::int32_t ticks_to_forgive_;
};

template <class Protocol>
void ServoDrive<Protocol>::enter(DrivePhase phase, std::int64_t now_ns) {
  const DrivePhase before = phase_;
  phase_ = phase;
  phase_ns_ = now_ns;
  phase_deadline_ns_ = never;
  order_.reset();
  order_heard_ns_ = never;
  switch (phase) {
    case booting:
      phase_deadline_ns_ = now_ns + settings_.boot_timeout_ns;
      place_ns_ = status_ns_ = 0;
      is_expected_device_.reset();
      last_errors_ = 0;
      give(ServoOrder::say_what_you_are);
      break;
    case configuring:
      is_silent_ = false;
      give(ServoOrder::clear_errors);
      break;
    case clearing:
      phase_deadline_ns_ = now_ns + settings_.stop_timeout_ns;
      give(ServoOrder::clear_errors);
      break;
    case enabling:
      phase_deadline_ns_ = now_ns + settings_.enable_timeout_ns;
      enabling_turns_ = place_.turns;
      if (!status_.is_on) give(ServoOrder::take_positions);
      break;
    case idle:
      if (before != starting) give(ServoOrder::switch_off);
      break;
    case following:
      is_commanded_ = false;
      break;
    case stopping:
      phase_deadline_ns_ = now_ns + settings_.stop_timeout_ns;
      rest_since_ns_ = 0;
      break;
    case disabling:
      phase_deadline_ns_ = now_ns + settings_.disable_timeout_ns;
      rest_since_ns_ = 0;
      give(ServoOrder::switch_off);
      break;
    default:
      break;
  }
}

template <class Protocol>
void ServoDrive<Protocol>::receive(const Frame& frame, std::int64_t now_ns) {
  if (phase_ == off) return;
  const ServoReport report = protocol_.read(frame);
  if (report.is_of_a_host) {
    ++counters_.foreign_frames;
    find(DriveFinding::foreign_sender);
  }
  if (report.is_bad) take_bad_frame();
  if (report.place) {
    ++counters_.feedback;
    place_ = *report.place;
    place_ns_ = now_ns;
  }
  if (report.status) {
    status_ = *report.status;
    status_ns_ = now_ns;
    // Silence is what a drive without power is allowed to complain of.
    const bool is_of_interest = is_supervised() && phase_ != idle && phase_ != clearing;
    if (status_.errors != 0 && is_of_interest) {
      if (last_errors_ != status_.errors) ++counters_.emergencies;
      last_errors_ = status_.errors;
    }
  }
  if (report.is_expected_device) is_expected_device_ = report.is_expected_device;
}

template <class Protocol>
void ServoDrive<Protocol>::tick(std::int64_t now_ns) {
  lasting_.clear();
  if (--ticks_to_forgive_ <= 0) {
    ticks_to_forgive_ = settings_.bad_frame_ticks;
    bad_frame_level_ = std::max<std::int32_t>(bad_frame_level_ - 1, 0);
  }
  if (is_supervised()) watch_connection(now_ns);
  advance(now_ns);
  watch_deadline(now_ns);
  const bool is_on_its_way = phase_ == clearing || phase_ == enabling;
  if (is_on_its_way && !findings_.empty()) apply(DriveEvent::dropped_out, now_ns);
}

template <class Protocol>
void ServoDrive<Protocol>::watch_connection(std::int64_t now_ns) {
  if (now_ns - place_ns_ > settings_.place_timeout_ns) {
    ++counters_.missed;
    find_lasting(DriveFinding::feedback_missing);
  }
  if (now_ns - status_ns_ > settings_.status_timeout_ns) find_lasting(DriveFinding::heartbeat_lost);
}

template <class Protocol>
void ServoDrive<Protocol>::advance(std::int64_t now_ns) {
  switch (phase_) {
    case booting:
      return advance_booting(now_ns);
    case configuring:
      return advance_configuring(now_ns);
    case starting:
      apply(DriveEvent::started, now_ns);
      return;
    case idle:
      if (status_.is_off && has_told_since_order()) order_.reset();
      return;
    case clearing:
      if (has_told_since_order() && status_.errors == 0) apply(DriveEvent::cleared, now_ns);
      return;
    case enabling:
      return advance_enabling(now_ns);
    case following:
      return watch_following(now_ns);
    case stopping:
      watch_rest(now_ns);
      if (is_resting_) phase_deadline_ns_ = never;
      return;
    case disabling:
      return advance_disabling(now_ns);
    case leaving:
      apply(DriveEvent::left, now_ns);  // it keeps its watchdog, and without power that does nothing
      return;
    default:
      return;
  }
}

/// Known, off, and heard of: then the drive may be tried.
template <class Protocol>
void ServoDrive<Protocol>::advance_booting(std::int64_t now_ns) {
  if (is_expected_device_ == false) return refuse(DriveFinding::wrong_firmware, now_ns);
  const bool is_heard = place_ns_ != 0 && status_ns_ != 0;
  if (!is_heard) return;
  const bool is_known = is_expected_device_.has_value() ||
                        (!protocol_.tells_identity() && now_ns - phase_ns_ > settings_.identity_timeout_ns);
  if (!is_known) return;
  if (status_.is_off) {
    apply(DriveEvent::booted, now_ns);
  } else if (status_.is_on && order_ != ServoOrder::switch_off) {
    give(ServoOrder::switch_off);  // somebody has left it on; one that calibrates is waited for
  }
}

template <class Protocol>
void ServoDrive<Protocol>::advance_configuring(std::int64_t now_ns) {
  if (!is_silent_) {
    if (has_told_since_order() && !status_.has_missed_host) {
      is_silent_ = true;
      silent_ns_ = now_ns;
      order_.reset();
    } else if (now_ns - phase_ns_ > settings_.stop_timeout_ns) {
      refuse(DriveFinding::fault_stays, now_ns);
    }
    return;
  }
  if (status_.has_missed_host && status_ns_ > silent_ns_) {
    proven_ns_ = now_ns - silent_ns_;
    apply(DriveEvent::configured, now_ns);
  } else if (now_ns - silent_ns_ > settings_.watchdog_timeout_ns) {
    refuse(DriveFinding::watchdog_unproven, now_ns);
  }
}

template <class Protocol>
void ServoDrive<Protocol>::advance_enabling(std::int64_t now_ns) {
  if (status_.errors != 0) return find(DriveFinding::drive_fault);
  if (!is_near(enabling_turns_, settings_.hold_tolerance_turns)) {
    return find(DriveFinding::moved_while_enabling);
  }
  if (!status_.is_on) {
    const bool was_told = order_ == ServoOrder::take_positions && order_heard_ns_ != never;
    if (was_told) give(ServoOrder::switch_on);
    return;
  }
  sent_ = waiting_ = {.turns = place_.turns};
  if (findings_.empty()) apply(DriveEvent::enabled, now_ns);
}

template <class Protocol>
void ServoDrive<Protocol>::watch_following(std::int64_t now_ns) {
  if (status_.errors != 0 || !status_.is_on) {
    // Without an error nothing but a new start switches it off.
    find(status_.errors != 0 ? DriveFinding::drive_fault : DriveFinding::unexpected_boot);
    apply(DriveEvent::dropped_out, now_ns);
    return;
  }
  if (!is_commanded_ && !is_near(sent_.turns, settings_.hold_tolerance_turns)) {
    find(DriveFinding::moved_while_enabling);
  }
  if (!is_near(sent_.turns, settings_.max_following_error_turns)) find_lasting(DriveFinding::following_error);
}

template <class Protocol>
void ServoDrive<Protocol>::watch_rest(std::int64_t now_ns) {
  if (rest_since_ns_ == 0 || !is_near(rest_turns_at_, settings_.rest_turns)) {
    rest_turns_at_ = place_.turns;
    rest_since_ns_ = now_ns;
  }
  is_resting_ = now_ns - rest_since_ns_ >= settings_.rest_ns && place_ns_ > rest_since_ns_;
}

template <class Protocol>
void ServoDrive<Protocol>::advance_disabling(std::int64_t now_ns) {
  watch_rest(now_ns);
  if (status_.is_off && has_told_since_order() && is_resting_) {
    apply(DriveEvent::disabled, now_ns);
    return;
  }
  const bool is_late = now_ns - phase_ns_ > settings_.disable_timeout_ns / 2;
  const bool is_last_resort = order_ == ServoOrder::stop_at_once;
  if (is_late && !status_.is_off && !is_last_resort) give(ServoOrder::stop_at_once);
}

template <class Protocol>
void ServoDrive<Protocol>::watch_deadline(std::int64_t now_ns) {
  if (now_ns < phase_deadline_ns_) return;
  switch (phase_) {
    case booting: {
      const bool is_heard = place_ns_ != 0 && status_ns_ != 0;
      const bool is_known = is_expected_device_.has_value() || !protocol_.tells_identity();
      find(!is_heard   ? DriveFinding::unheard
           : !is_known ? DriveFinding::wrong_firmware
                       : DriveFinding::not_switched_off);
      break;
    }
    case clearing:
      last_errors_ = status_.errors;
      find(DriveFinding::fault_stays);
      break;
    case enabling:
      find(DriveFinding::not_enabled);
      break;
    case stopping:
      find_lasting(DriveFinding::quick_stop_ignored);
      break;
    case disabling: {
      const bool tells = now_ns - status_ns_ <= settings_.status_timeout_ns;
      find(tells && status_.is_off ? DriveFinding::moves_while_off : DriveFinding::not_switched_off);
      break;
    }
    default:
      break;
  }
  apply(DriveEvent::timed_out, now_ns);
}

template <class Protocol>
void ServoDrive<Protocol>::accept(const Target& target) {
  const double step = std::fabs(target.turns - waiting_.turns);
  if (!is_commanded_ && step > settings_.first_step_turns) return find(DriveFinding::moved_while_enabling);
  is_commanded_ = true;
  if (step > settings_.max_step_turns || std::fabs(target.turns_per_s) > settings_.max_turns_per_s) {
    return find(DriveFinding::setpoint_jump);
  }
  waiting_ = target;
}

template <class Protocol>
std::optional<Frame> ServoDrive<Protocol>::command(const std::optional<Target>& target) {
  if (!is_fed()) return {};
  if (phase_ == following) {
    if (is_commanded_ && !target) return {};
    sent_ = waiting_;
    if (target) accept(*target);
    return protocol_.command(sent_);
  }
  // Held where it was told to be last; without power, where it is.
  const bool is_held = phase_ == stopping || (phase_ == clearing && status_.is_on);
  return protocol_.command({.turns = is_held ? sent_.turns : place_.turns});
}

template <class Protocol>
std::optional<Frame> ServoDrive<Protocol>::service(std::int64_t now_ns) {
  if (!order_ || now_ns < order_due_ns_) return {};
  const bool is_first = order_heard_ns_ == never || order_due_ns_ == 0;
  order_due_ns_ = now_ns + settings_.repeat_ns;
  if (is_first) order_heard_ns_ = now_ns;
  // Asked for again it would leave the loop and come back.
  if (order_ == ServoOrder::switch_on && !is_first) return {};
  return protocol_.order(*order_);
}

}  // namespace inbetween::can
