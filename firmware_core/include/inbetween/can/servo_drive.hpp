#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/can/drive_counters.hpp"
#include "inbetween/can/drive_finding.hpp"
#include "inbetween/can/drive_phase.hpp"
#include "inbetween/can/scale_watch.hpp"
#include "inbetween/can/servo_report.hpp"

/// A servo drive that knows positions in turns and no SYNC, as its host sees it: watched, proven to stop
/// alone, switched on, given a target every tick (BusDrive). A protocol says only how orders look and what
/// frames mean (ServoProtocol).

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
/// What feeds the drive's watchdog while it follows comes only with a target. Whether that watchdog works is
/// known before the drive is switched on (ServoWatch): it is fed until it tells that it is well, then not,
/// and must tell that its watchdog has expired; or it repeats the time that it is told.
template <ServoProtocol Protocol>
class ServoDrive {
 public:
  using Frame = typename Protocol::Frame;
  using Place = double;  ///< turns
  using Target = ServoTarget;
  static Place place_of(double turns) { return static_cast<Place>(turns); }
  static std::optional<Target> target_of(double turns, double turns_per_s, Place zero) {
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
  /// Its power goes once the axis rests, which it is held for; or after half of disable_timeout_ns.
  bool disable(std::int64_t now_ns) { return apply(DriveEvent::disable, now_ns); }
  bool cut(std::int64_t now_ns) {
    is_cut_ = true;
    return disable(now_ns);
  }
  bool leave(std::int64_t now_ns) { return apply(DriveEvent::leave, now_ns); }
  bool quick_stop(std::int64_t now_ns) { return apply(DriveEvent::quick_stop, now_ns); }
  void acknowledge() {
    if (phase_ == DrivePhase::following && is_lost()) drop_out();
    findings_.clear();
    first_finding_.reset();
    bad_frame_level_ = 0;
  }

  void receive(const Frame& frame, std::int64_t now_ns);
  void tick(std::int64_t now_ns);
  /// A question, or nothing, where it is not to be fed: among others where it has followed and there is no
  /// target now.
  std::optional<Frame> command(const std::optional<Target>& target);
  /// At most one order, or a question beside a target. Not after setpoints have ceased: some drives take
  /// every frame for a sign of life.
  std::optional<Frame> service(std::int64_t now_ns);

  [[nodiscard]] DrivePhase phase() const { return phase_; }
  /// Whether it has told something of itself, and not that it has no power.
  [[nodiscard]] bool may_have_power() const { return status_ns_ != 0 && !status_.is_off; }
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
  /// What it said of its version.
  [[nodiscard]] std::uint32_t version() const { return version_; }
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
  [[nodiscard]] bool is_near(double turns, double tolerance) const {
    return std::fabs(place_.turns - turns) <= tolerance;
  }
  /// It has told how it is since the phase began, and some ticks after: not from before an order was heard.
  [[nodiscard]] bool has_told_since_order() const { return status_ns_ > order_heard_ns_; }

  /// Its own watchdog stops it, and an order to switch off would end that.
  [[nodiscard]] bool brakes_alone() const { return status_.has_missed_host && !status_.is_off; }
  [[nodiscard]] bool may_be_commanded() const {
    const bool is_known = !lasting_.has(DriveFinding::feedback_missing) &&
                          !lasting_.has(DriveFinding::heartbeat_lost) && !was_silent_;
    return !Protocol::habits.starts_by_target || (is_known && status_.is_on);
  }
  /// One that does not tell whether it has power may be without by now.
  [[nodiscard]] bool is_lost() const {
    return was_silent_ || (has_ceased_ && !Protocol::habits.tells_restart);
  }
  /// Before it is switched on again. What it was told last is of the past, unless it holds that.
  [[nodiscard]] bool must_be_off() const {
    return !Protocol::habits.tells_restart && !holds_ && !status_.is_off;
  }
  [[nodiscard]] bool is_asked_beside_targets() const {
    const bool is_told = is_supervised() || (phase_ == configuring && !is_silent_) ||
                         (phase_ == disabling && is_held_ && !order_);
    return Protocol::habits.is_asked_apart && is_told && !(phase_ == following && has_ceased_);
  }
  /// One that can be told only a place, and not to switch on where it is, is told the place before that.
  [[nodiscard]] double switching_on_turns() const {
    return Protocol::habits.tells_restart ? place_.turns : enabling_turns_;
  }
  [[nodiscard]] std::optional<Frame> commanded(const ServoTarget& target) {
    return may_be_commanded() ? protocol_.command(target) : protocol_.question();
  }

  void watch_connection(std::int64_t now_ns);
  void watch_silence(std::int64_t now_ns);
  void drop_out();
  void advance(std::int64_t now_ns);
  void advance_booting(std::int64_t now_ns);
  void advance_configuring(std::int64_t now_ns);
  void prove_watchdog(std::int64_t now_ns);
  void advance_enabling(std::int64_t now_ns);
  void watch_following(std::int64_t now_ns);
  void watch_rest(std::int64_t now_ns);
  void advance_disabling(std::int64_t now_ns);
  void watch_deadline(std::int64_t now_ns);
  void accept(const Target& target);
  std::optional<Frame> next_order(std::int64_t now_ns);

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
  std::uint32_t version_ = 0;
  bool is_alone_ = true;     ///< the same
  bool knows_place_ = true;  ///< as far as it has told
  std::optional<bool> has_watchdog_;
  bool is_silent_ = false;  ///< configuring: it is well, and its watchdog is to be proven
  std::int64_t silent_ns_ = 0;
  std::int64_t heard_ns_ = 0;         ///< when any frame came from it
  std::int64_t silent_until_ns_ = 0;  ///< the end of its last silence
  bool was_silent_ = false;           ///< for so long that it may have started anew
  bool has_ceased_ = false;           ///< following: a target was missing
  std::int64_t now_ns_ = 0;           ///< of the last tick
  bool holds_ = false;                ///< clearing: after a quick stop, of which nothing has been lost
  std::int64_t proven_ns_ = 0;
  bool is_commanded_ = false;  ///< following: a target has been given
  ServoTarget sent_;           ///< the last one
  ServoTarget waiting_;        ///< goes out in the next tick
  double enabling_turns_ = 0;  ///< where it was when it was to be switched on
  double rest_turns_at_ = 0;
  std::int64_t rest_since_ns_ = 0;
  bool is_resting_ = false;
  bool is_cut_ = false;   ///< its power goes at once
  bool is_held_ = false;  ///< disabling: until it rests
  struct NoScaleWatch {};
  [[no_unique_address]] std::conditional_t<Protocol::habits.has_two_scales, ScaleWatch, NoScaleWatch> scale_;
  std::int32_t bad_frame_level_ = 0;
  std::int32_t ticks_to_forgive_;
};

template <ServoProtocol Protocol>
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
      knows_place_ = true;
      is_alone_ = true;
      has_watchdog_.reset();
      last_errors_ = 0;
      is_cut_ = false;
      give(ServoOrder::say_what_you_are);
      break;
    case configuring:
      is_silent_ = false;
      give(ServoOrder::clear_errors);
      break;
    case clearing:
      phase_deadline_ns_ = now_ns + settings_.stop_timeout_ns;
      // One that holds its place after a quick stop keeps its power.
      if (!status_.is_on || status_.errors != 0) give(ServoOrder::clear_errors);
      holds_ = before == stopping && !is_lost();
      if (must_be_off()) give(ServoOrder::switch_off);
      break;
    case enabling:
      phase_deadline_ns_ = now_ns + settings_.enable_timeout_ns;
      enabling_turns_ = place_.turns;
      was_silent_ = has_ceased_ = false;
      if (!status_.is_on) give(ServoOrder::take_positions);
      break;
    case idle:
      if (before == starting ? !status_.is_off : !brakes_alone()) give(ServoOrder::switch_off);
      break;
    case following:
      is_commanded_ = false;
      if constexpr (Protocol::habits.has_two_scales) scale_.begin();
      break;
    case DrivePhase::refused:
      if (status_.is_on) give(ServoOrder::switch_off);  // its watchdog was tried
      break;
    case stopping:
      phase_deadline_ns_ = now_ns + settings_.stop_timeout_ns;
      rest_since_ns_ = 0;
      if (is_lost()) give(ServoOrder::switch_off);
      break;
    case disabling:
      phase_deadline_ns_ = now_ns + settings_.disable_timeout_ns;
      rest_since_ns_ = 0;
      is_resting_ = false;
      is_held_ = (before == following || before == stopping) && !is_cut_ && status_.is_on &&
                 status_.errors == 0 && !brakes_alone() && may_be_commanded() && !is_lost();
      if (is_cut_ || (!is_held_ && !brakes_alone())) give(ServoOrder::switch_off);
      break;
    default:
      break;
  }
}

template <ServoProtocol Protocol>
void ServoDrive<Protocol>::receive(const Frame& frame, std::int64_t now_ns) {
  if (phase_ == off) return;
  const ServoReport report = protocol_.read(frame);
  if (report.is_of_a_host) {
    ++counters_.foreign_frames;
    find(DriveFinding::foreign_sender);
  } else {
    if (now_ns - heard_ns_ > settings_.place_timeout_ns) silent_until_ns_ = now_ns;
    heard_ns_ = now_ns;
  }
  if (report.is_bad) take_bad_frame();
  if (report.is_another_device) is_alone_ = false;
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
  if (report.is_expected_device) {
    is_expected_device_ = report.is_expected_device;
    version_ = report.version;
  }
  if (report.knows_place) knows_place_ = *report.knows_place;
  if (report.has_watchdog) has_watchdog_ = report.has_watchdog;
}

template <ServoProtocol Protocol>
void ServoDrive<Protocol>::tick(std::int64_t now_ns) {
  now_ns_ = now_ns;
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

template <ServoProtocol Protocol>
void ServoDrive<Protocol>::watch_connection(std::int64_t now_ns) {
  if (now_ns - place_ns_ > settings_.place_timeout_ns) {
    ++counters_.missed;
    find_lasting(DriveFinding::feedback_missing);
  }
  if (now_ns - status_ns_ > settings_.status_timeout_ns) find_lasting(DriveFinding::heartbeat_lost);
  const bool may_have_power = phase_ == enabling || phase_ == following || phase_ == stopping;
  if (!Protocol::habits.tells_restart && may_have_power) watch_silence(now_ns);
}

/// It is switched off, and asked again from now on.
template <ServoProtocol Protocol>
void ServoDrive<Protocol>::drop_out() {
  place_ns_ = status_ns_ = now_ns_;
  apply(DriveEvent::dropped_out, now_ns_);
}

/// Where it counts from, and whether it has power, is not known any more once it may have started anew.
template <ServoProtocol Protocol>
void ServoDrive<Protocol>::watch_silence(std::int64_t now_ns) {
  const bool is_silent = now_ns - heard_ns_ > settings_.place_timeout_ns;
  if (is_silent) {
    was_silent_ = true;
  } else if (was_silent_ && !findings_.has(DriveFinding::silent_for_a_while)) {
    find(DriveFinding::silent_for_a_while);
    apply(DriveEvent::dropped_out, now_ns);
  }
}

template <ServoProtocol Protocol>
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
    case DrivePhase::refused:
      if (status_.is_off && has_told_since_order()) order_.reset();
      return;
    case clearing:
      if ((!order_ || has_told_since_order()) && status_.errors == 0 && !must_be_off()) {
        apply(DriveEvent::cleared, now_ns);
      }
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
template <ServoProtocol Protocol>
void ServoDrive<Protocol>::advance_booting(std::int64_t now_ns) {
  if (is_expected_device_ == false) return refuse(Protocol::misfit, now_ns);
  if (!is_alone_) return refuse(DriveFinding::two_devices, now_ns);
  if (!knows_place_) return refuse(DriveFinding::place_unknown, now_ns);
  const bool is_heard = place_ns_ != 0 && status_ns_ != 0;
  if (!is_heard) return;
  const bool is_known = is_expected_device_.has_value() ||
                        (!protocol_.tells_identity() && now_ns - phase_ns_ > settings_.identity_timeout_ns);
  if (!is_known) return;
  if constexpr (requires { protocol_.has_more_to_ask(status_.errors); }) {
    if (protocol_.has_more_to_ask(status_.errors)) return;
  }
  if (status_.is_off) {
    apply(DriveEvent::booted, now_ns);
  } else if ((status_.is_on || brakes_alone()) && order_ != ServoOrder::switch_off) {
    give(ServoOrder::switch_off);  // somebody has left it on; one that calibrates is waited for
  }
}

/// Well first, then known to stop alone.
template <ServoProtocol Protocol>
void ServoDrive<Protocol>::advance_configuring(std::int64_t now_ns) {
  if (is_silent_) return prove_watchdog(now_ns);
  if (has_told_since_order() && status_.errors == 0) order_.reset();
  if (has_told_since_order() && !status_.has_missed_host && status_.is_watching) {
    is_silent_ = true;
    silent_ns_ = now_ns;
    order_.reset();
    if (protocol_.watch() == ServoWatch::confirmed) give(ServoOrder::set_watchdog);
  } else if (now_ns - phase_ns_ > settings_.stop_timeout_ns) {
    last_errors_ = status_.errors;
    refuse(DriveFinding::fault_stays, now_ns);
  }
}

template <ServoProtocol Protocol>
void ServoDrive<Protocol>::prove_watchdog(std::int64_t now_ns) {
  const bool is_tried = protocol_.watch() == ServoWatch::tried;
  const bool is_proven = is_tried ? status_.has_missed_host && status_ns_ > silent_ns_
                                  : protocol_.watch() == ServoWatch::accepted || has_watchdog_ == true;
  if (is_proven) {
    proven_ns_ = now_ns - silent_ns_;
    apply(DriveEvent::configured, now_ns);
  } else if (has_watchdog_ == false || now_ns - silent_ns_ > settings_.watchdog_timeout_ns) {
    refuse(is_tried ? DriveFinding::watchdog_unproven : DriveFinding::watchdog_unconfirmed, now_ns);
  }
}

template <ServoProtocol Protocol>
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
  sent_ = waiting_ = {.turns = switching_on_turns()};
  if (findings_.empty()) apply(DriveEvent::enabled, now_ns);
}

template <ServoProtocol Protocol>
void ServoDrive<Protocol>::watch_following(std::int64_t now_ns) {
  if (status_.errors != 0 || !status_.is_on) {
    // Without an error a new start switches it off, which takes a while, or somebody else has done it.
    const bool was_heard = Protocol::habits.tells_restart && silent_until_ns_ < phase_ns_;
    find(status_.errors != 0 ? DriveFinding::drive_fault
         : was_heard         ? DriveFinding::switched_off_by_another
                             : DriveFinding::unexpected_boot);
    apply(DriveEvent::dropped_out, now_ns);
    return;
  }
  if (!is_commanded_ && !is_near(sent_.turns, settings_.hold_tolerance_turns)) {
    find(DriveFinding::moved_while_enabling);
  }
  if (!is_near(sent_.turns, settings_.max_following_error_turns)) find_lasting(DriveFinding::following_error);
  if constexpr (Protocol::habits.has_two_scales) {
    if (is_commanded_) {
      scale_.look(protocol_.scale_watch(), place_.turns, place_ns_ == now_ns, sent_, now_ns);
    }
    if (scale_.differs()) find_lasting(DriveFinding::scale_differs);
  }
}

template <ServoProtocol Protocol>
void ServoDrive<Protocol>::watch_rest(std::int64_t now_ns) {
  if (rest_since_ns_ == 0 || !is_near(rest_turns_at_, settings_.rest_turns)) {
    rest_turns_at_ = place_.turns;
    rest_since_ns_ = now_ns;
  }
  is_resting_ = now_ns - rest_since_ns_ >= settings_.rest_ns && place_ns_ > rest_since_ns_;
}

template <ServoProtocol Protocol>
void ServoDrive<Protocol>::advance_disabling(std::int64_t now_ns) {
  watch_rest(now_ns);
  if (is_resting_ && !order_) give(ServoOrder::switch_off);
  // One that has never told where it is has never been told to go anywhere.
  const bool rests = is_resting_ || place_ns_ == 0;
  if (status_.is_off && has_told_since_order() && rests) {
    apply(DriveEvent::disabled, now_ns);
    return;
  }
  const bool is_late = now_ns - phase_ns_ > settings_.disable_timeout_ns / 2;
  const bool is_last_resort = order_ == ServoOrder::stop_at_once;
  if (is_late && !status_.is_off && !is_last_resort) give(ServoOrder::stop_at_once);
}

template <ServoProtocol Protocol>
void ServoDrive<Protocol>::watch_deadline(std::int64_t now_ns) {
  if (now_ns < phase_deadline_ns_) return;
  switch (phase_) {
    case booting: {
      const bool is_heard = place_ns_ != 0 && status_ns_ != 0;
      const bool is_known = is_expected_device_.has_value() || !protocol_.tells_identity();
      const bool has_no_place = place_ns_ == 0 && status_ns_ != 0;
      find(has_no_place ? DriveFinding::place_unsaid
           : !is_heard  ? DriveFinding::unheard
           : !is_known  ? Protocol::misfit
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

template <ServoProtocol Protocol>
void ServoDrive<Protocol>::accept(const Target& target) {
  const double step = std::fabs(target.turns - waiting_.turns);
  if (!is_commanded_ && step > settings_.first_step_turns) return find(DriveFinding::moved_while_enabling);
  is_commanded_ = true;
  if (step > settings_.max_step_turns || std::fabs(target.turns_per_s) > settings_.max_turns_per_s) {
    return find(DriveFinding::setpoint_jump);
  }
  waiting_ = target;
}

template <ServoProtocol Protocol>
auto ServoDrive<Protocol>::command(const std::optional<Target>& target) -> std::optional<Frame> {
  switch (phase_) {
    case following: {
      if (!has_ceased_ || Protocol::habits.tells_restart) has_ceased_ = is_commanded_ && !target;
      if (has_ceased_ && Protocol::habits.is_asked_apart) return {};
      if (has_ceased_) return protocol_.question();
      // One that cannot be told to switch on stands where it was switched on, and need not hurry.
      if (!Protocol::habits.tells_restart && !is_commanded_ && !target) {
        return may_be_commanded() ? protocol_.hold(ServoHold::switching_on, sent_.turns)
                                  : protocol_.question();
      }
      const ServoTarget left = sent_;
      sent_ = waiting_;
      if (target) accept(*target);
      return commanded(Protocol::habits.goes_on_by_velocity ? left : sent_);
    }
    case stopping:
      return may_be_commanded() && !is_lost() ? protocol_.hold(ServoHold::stopping, sent_.turns)
                                              : protocol_.question();
    case clearing:
      // Held where it was told to be last.
      if (status_.is_on && Protocol::habits.tells_restart) return commanded({.turns = sent_.turns});
      [[fallthrough]];
    case idle:
      return protocol_.hold(ServoHold::off, place_.turns);
    case enabling:
      if (was_silent_) return protocol_.question();
      return protocol_.hold(ServoHold::switching_on, switching_on_turns());
    case configuring:
      return is_silent_ ? protocol_.question() : protocol_.hold(ServoHold::watched, place_.turns);
    case disabling:
      if (is_held_ && !order_) return protocol_.hold(ServoHold::stopping, sent_.turns);
      return protocol_.question();
    case booting:
    case DrivePhase::refused:
      return protocol_.question();
    default:
      return {};
  }
}

template <ServoProtocol Protocol>
auto ServoDrive<Protocol>::service(std::int64_t now_ns) -> std::optional<Frame> {
  if (const std::optional<Frame> frame = next_order(now_ns)) return frame;
  if (is_asked_beside_targets()) return protocol_.question();
  return {};
}

template <ServoProtocol Protocol>
auto ServoDrive<Protocol>::next_order(std::int64_t now_ns) -> std::optional<Frame> {
  if (!order_ || now_ns < order_due_ns_) return {};
  const bool is_first = order_heard_ns_ == never || order_due_ns_ == 0;
  order_due_ns_ = now_ns + settings_.repeat_ns;
  if (is_first) order_heard_ns_ = now_ns;
  // Asked for again it would leave the loop and come back.
  if (order_ == ServoOrder::switch_on && !is_first) return {};
  return protocol_.order(*order_);
}

}  // namespace inbetween::can
