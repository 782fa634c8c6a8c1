#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "inbetween/base/result.hpp"
#include "inbetween/can/drive_counters.hpp"
#include "inbetween/can/drive_finding.hpp"
#include "inbetween/can/drive_phase.hpp"
#include "inbetween/can/rest_watch.hpp"
#include "inbetween/can/scale_watch.hpp"
#include "inbetween/can/servo_report.hpp"
#include "inbetween/can/servo_settings.hpp"
#include "inbetween/can/silence_watch.hpp"
#include "inbetween/can/standing_order.hpp"

/// A servo drive that knows positions in turns and no SYNC, as its host sees it: watched, proven to stop
/// alone, switched on, given a target every tick (BusDrive). A protocol says only how orders look and what
/// frames mean (ServoProtocol).

namespace inbetween::can {

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
  static Place place_of(double turns) { return turns; }
  static std::optional<Target> target_of(double turns, double turns_per_s, Place zero) {
    const Target target{.turns = turns + zero, .turns_per_s = turns_per_s};
    if (!std::isfinite(target.turns) || !Protocol::fits(target)) return {};
    return target;
  }

  /// Errors: out_of_range (a limit or time that is not positive).
  static Result<ServoDrive> make(const Protocol& protocol, const ServoSettings& settings) {
    if (!settings.is_sensible()) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "a limit or time of a drive is not positive",
                   .remedy = "give positive limits"};
    }
    return ServoDrive(protocol, settings);
  }

  [[nodiscard]] const Protocol& protocol() const { return protocol_; }

  // BusDrive.
  bool connect(std::int64_t now_ns) { return apply(DriveEvent::connect, now_ns); }
  bool enable(std::int64_t now_ns) { return log_.empty() && apply(DriveEvent::enable, now_ns); }
  /// Its power goes once the axis rests, which it is held for; or after half of disable_timeout_ns.
  bool disable(std::int64_t now_ns) { return apply(DriveEvent::disable, now_ns); }
  /// One that is being switched off already goes on with that.
  bool cut(std::int64_t now_ns) {
    // One that is held until it rests, or brakes by its own watchdog, must not get away meanwhile.
    if (phase() == DrivePhase::disabling) order_.give(ServoOrder::switch_off);
    power_off_ = PowerOff::cut;
    return disable(now_ns);
  }
  bool leave(std::int64_t now_ns) { return apply(DriveEvent::leave, now_ns); }
  bool quick_stop(std::int64_t now_ns) { return apply(DriveEvent::quick_stop, now_ns); }
  void acknowledge() {
    if (phase() == DrivePhase::following && is_lost()) drop_out();
    log_.acknowledge();
  }

  void receive(const Frame& frame, std::int64_t now_ns) {
    if (phase() == off) return;
    const ServoReport report = protocol_.read(frame);
    if (report.is_of_a_host) {
      ++counters_.foreign_frames;
      log_.find(DriveFinding::foreign_sender);
    } else {
      silence_.hear(now_ns);
    }
    if (report.is_bad) log_.take_bad_frame(counters_.bad_frames);
    if (report.place) ++counters_.feedback;
    told_.take(report, now_ns);
    // Silence is what a drive without power is allowed to complain of.
    if (!report.status || report.status->errors == 0 || !clock_.is_to_have_power()) return;
    if (last_errors_ != report.status->errors) ++counters_.emergencies;
    last_errors_ = report.status->errors;
  }
  void tick(std::int64_t now_ns) {
    now_ns_ = now_ns;
    log_.begin_tick();
    log_.forgive();
    if (clock_.is_supervised()) watch_connection(now_ns);
    advance(now_ns);
    watch_deadline(now_ns);
    if (clock_.is_switching_on() && !log_.empty()) apply(DriveEvent::dropped_out, now_ns);
  }
  /// A question, or nothing, where it is not to be fed: among others where it has followed and there is no
  /// target now.
  std::optional<Frame> command(const std::optional<Target>& target) {
    switch (phase()) {
      case following: {
        if (targets_ != Targets::none && !has_ceased_for_good()) {
          targets_ = target ? Targets::given : Targets::ceased;
        }
        const bool has_ceased = targets_ == Targets::ceased;
        if (has_ceased && Protocol::habits.is_asked_apart) return {};
        if (has_ceased) return protocol_.question();
        // One that cannot be told to switch on stands where it was switched on, and need not hurry.
        if (Protocol::habits.needs_place_to_start && targets_ == Targets::none && !target) {
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
        if (told_.status.is_on && !Protocol::habits.needs_place_to_start)
          return commanded({.turns = sent_.turns});
        [[fallthrough]];
      case idle:
        return protocol_.hold(ServoHold::off, told_.place.turns);
      case enabling:
        if (silence_.was_silent()) return protocol_.question();
        return protocol_.hold(ServoHold::switching_on, switching_on_turns());
      case configuring:
        return unfed_since_ns_ ? protocol_.question() : protocol_.hold(ServoHold::watched, told_.place.turns);
      case disabling:
        if (is_held()) return protocol_.hold(ServoHold::stopping, sent_.turns);
        return protocol_.question();
      case booting:
      case DrivePhase::refused:
        return protocol_.question();
      default:
        return {};
    }
  }
  /// At most one order, or a question beside a target. Not after setpoints have ceased: some drives take
  /// every frame for a sign of life.
  std::optional<Frame> service(std::int64_t now_ns) {
    if (const std::optional<ServoOrder> order = order_.next(now_ns)) {
      if (const std::optional<Frame> frame = protocol_.order(*order)) return frame;
    }
    if (is_asked_beside_targets()) return protocol_.question();
    return {};
  }

  [[nodiscard]] DrivePhase phase() const { return clock_.phase(); }
  /// Whether it has told something of itself, and not that it has no power.
  [[nodiscard]] bool may_have_power() const { return told_.status_ns != 0 && !told_.status.is_off; }
  [[nodiscard]] const DriveFindings& findings() const { return log_.all(); }
  [[nodiscard]] const DriveFindings& lasting() const { return log_.lasting(); }
  [[nodiscard]] std::optional<DriveFinding> first_finding() const { return log_.first(); }
  [[nodiscard]] bool is_leaving() const { return clock_.is_leaving(); }
  [[nodiscard]] bool is_commanded() const {
    return phase() == DrivePhase::following && targets_ != Targets::none;
  }
  [[nodiscard]] Place held_place() const {
    return phase() == DrivePhase::following && !is_commanded() ? sent_.turns : told_.place.turns;
  }
  [[nodiscard]] const ServoPlace& place() const { return told_.place; }
  [[nodiscard]] const ServoStatus& status() const { return told_.status; }
  /// The last errors that it told, until they are acknowledged by a new set-up.
  [[nodiscard]] std::uint32_t last_errors() const { return last_errors_; }
  /// What it said of its version.
  [[nodiscard]] std::uint32_t version() const { return told_.version; }
  /// After how long at most it told that its watchdog had expired; 0: not tried yet.
  [[nodiscard]] std::int64_t proven_watchdog_ns() const { return proven_ns_; }
  [[nodiscard]] const DriveCounters& counters() const { return counters_; }

 private:
  using enum DrivePhase;
  /// How its power goes.
  enum class PowerOff : std::uint8_t {
    ordered,  ///< at once, or once it rests where its own watchdog brakes it
    held,     ///< once it rests, for which it is held
    cut,      ///< at once
  };
  /// Since it was to be switched on.
  enum class Targets : std::uint8_t { none, given, ceased };

  ServoDrive(const Protocol& protocol, const ServoSettings& settings)
      : protocol_(protocol),
        settings_(settings),
        log_({.limit = settings.bad_frame_limit, .ticks = settings.bad_frame_ticks}),
        order_(settings.repeat_ns),
        silence_(settings.place_timeout_ns),
        rest_(settings.rest_turns, settings.rest_ns) {}

  bool apply(DriveEvent event, std::int64_t now_ns) {
    return clock_.apply(event, now_ns, [&] { enter(now_ns); });
  }
  void enter(std::int64_t now_ns) {
    order_.begin();
    switch (phase()) {
      case booting:
        clock_.set_deadline(now_ns + settings_.boot_timeout_ns);
        told_.begin();
        last_errors_ = 0;
        power_off_ = PowerOff::ordered;
        order_.give(ServoOrder::say_what_you_are);
        break;
      case configuring:
        unfed_since_ns_.reset();
        order_.give(ServoOrder::clear_errors);
        break;
      case clearing:
        clock_.set_deadline(now_ns + settings_.stop_timeout_ns);
        // One that holds its place after a quick stop keeps its power.
        if (!told_.status.is_on || told_.status.errors != 0) order_.give(ServoOrder::clear_errors);
        if (must_be_off()) order_.give(ServoOrder::switch_off);
        break;
      case enabling:
        clock_.set_deadline(now_ns + settings_.enable_timeout_ns);
        enabling_turns_ = told_.place.turns;
        silence_.begin();
        targets_ = Targets::none;
        if (!told_.status.is_on) order_.give(ServoOrder::take_positions);
        break;
      case idle:
        if (clock_.before() == starting ? !told_.status.is_off : !told_.brakes_alone())
          order_.give(ServoOrder::switch_off);
        break;
      case following:
        if constexpr (Protocol::habits.has_two_scales) scale_.begin();
        break;
      case DrivePhase::refused:
        if (told_.status.is_on) order_.give(ServoOrder::switch_off);  // its watchdog was tried
        break;
      case stopping:
        clock_.set_deadline(now_ns + settings_.stop_timeout_ns);
        rest_.begin();
        if (is_lost()) order_.give(ServoOrder::switch_off);
        break;
      case disabling:
        clock_.set_deadline(now_ns + settings_.disable_timeout_ns);
        rest_.begin();
        if (power_off_ != PowerOff::cut) power_off_ = may_be_held() ? PowerOff::held : PowerOff::ordered;
        if (power_off_ == PowerOff::cut || (power_off_ == PowerOff::ordered && !told_.brakes_alone())) {
          order_.give(ServoOrder::switch_off);
        }
        break;
      default:
        break;
    }
  }
  void refuse(DriveFinding finding, std::int64_t now_ns) {
    log_.find(finding);
    apply(phase() == booting ? DriveEvent::timed_out : DriveEvent::refused, now_ns);
  }
  /// It has told how it is since the phase began, and some ticks after: not from before an order was heard.
  [[nodiscard]] bool has_told_since_order() const { return order_.is_answered(told_.status_ns); }

  [[nodiscard]] bool may_be_commanded() const {
    const bool is_known = !log_.lasting().has(DriveFinding::feedback_missing) &&
                          !log_.lasting().has(DriveFinding::heartbeat_lost) && !silence_.was_silent();
    return !Protocol::habits.starts_by_target || (is_known && told_.status.is_on);
  }
  [[nodiscard]] bool has_ceased_for_good() const {
    return Protocol::habits.restarts_unsaid && targets_ == Targets::ceased;
  }
  /// It may be without power by now, and counts from somewhere else.
  [[nodiscard]] bool is_lost() const { return silence_.was_silent() || has_ceased_for_good(); }
  [[nodiscard]] bool may_have_restarted() const {
    return Protocol::habits.restarts_unsaid || !silence_.was_heard_since(clock_.since_ns());
  }
  /// Before it is switched on again. What it was told last is of the past, unless it holds that after a quick
  /// stop.
  [[nodiscard]] bool must_be_off() const {
    const bool holds = clock_.before() == stopping && !is_lost();
    return Protocol::habits.needs_place_to_start && !holds && !told_.status.is_off;
  }
  /// As it is switched off.
  [[nodiscard]] bool may_be_held() const {
    const bool was_told = clock_.before() == following || clock_.before() == stopping;
    return was_told && told_.status.is_on && told_.status.errors == 0 && !told_.brakes_alone() &&
           may_be_commanded() && !is_lost();
  }
  /// Being switched off, until it rests.
  [[nodiscard]] bool is_held() const {
    return phase() == disabling && power_off_ == PowerOff::held && !order_.stands();
  }
  [[nodiscard]] bool is_asked_beside_targets() const {
    const bool is_told = clock_.is_supervised() || (phase() == configuring && !unfed_since_ns_) || is_held();
    const bool has_ceased = phase() == following && targets_ == Targets::ceased;
    return Protocol::habits.is_asked_apart && is_told && !has_ceased;
  }
  [[nodiscard]] double switching_on_turns() const {
    return Protocol::habits.needs_place_to_start ? enabling_turns_ : told_.place.turns;
  }
  [[nodiscard]] std::optional<Frame> commanded(const ServoTarget& target) {
    return may_be_commanded() ? protocol_.command(target) : protocol_.question();
  }

  void watch_connection(std::int64_t now_ns) {
    if (now_ns - told_.place_ns > settings_.place_timeout_ns) {
      ++counters_.missed;
      log_.find_lasting(DriveFinding::feedback_missing);
    }
    if (now_ns - told_.status_ns > settings_.status_timeout_ns)
      log_.find_lasting(DriveFinding::heartbeat_lost);
    if (Protocol::habits.restarts_unsaid && clock_.is_to_have_power()) watch_silence(now_ns);
  }
  /// Where it counts from, and whether it has power, is not known any more once it may have started anew.
  void watch_silence(std::int64_t now_ns) {
    silence_.look(now_ns);
    const bool is_over = silence_.was_silent() && !silence_.is_silent(now_ns);
    if (is_over && !log_.all().has(DriveFinding::silent_for_a_while)) {
      log_.find(DriveFinding::silent_for_a_while);
      apply(DriveEvent::dropped_out, now_ns);
    }
  }
  /// It is switched off, and asked again from now on.
  void drop_out() {
    told_.place_ns = told_.status_ns = now_ns_;
    apply(DriveEvent::dropped_out, now_ns_);
  }
  void advance(std::int64_t now_ns) {
    switch (phase()) {
      case booting:
        return advance_booting(now_ns);
      case configuring:
        return advance_configuring(now_ns);
      case starting:
        apply(DriveEvent::started, now_ns);
        return;
      case idle:
      case DrivePhase::refused:
        if (told_.status.is_off && has_told_since_order()) order_.withdraw();
        return;
      case clearing:
        if ((!order_.stands() || has_told_since_order()) && told_.status.errors == 0 && !must_be_off()) {
          apply(DriveEvent::cleared, now_ns);
        }
        return;
      case enabling:
        return advance_enabling(now_ns);
      case following:
        return watch_following(now_ns);
      case stopping:
        if (rests(now_ns)) clock_.clear_deadline();
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
  void advance_booting(std::int64_t now_ns) {
    if (told_.is_expected_device == false) return refuse(Protocol::misfit, now_ns);
    if (told_.is_another_device) return refuse(DriveFinding::two_devices, now_ns);
    if (told_.knows_place == false) return refuse(DriveFinding::place_unknown, now_ns);
    if (!told_.is_heard()) return;
    const bool is_known =
        told_.is_expected_device.has_value() ||
        (!protocol_.tells_identity() && now_ns - clock_.since_ns() > settings_.identity_timeout_ns);
    if (!is_known) return;
    if constexpr (requires { protocol_.has_more_to_ask(told_.status.errors); }) {
      if (protocol_.has_more_to_ask(told_.status.errors)) return;
    }
    if (told_.status.is_off) {
      apply(DriveEvent::booted, now_ns);
    } else if ((told_.status.is_on || told_.brakes_alone()) && !order_.is(ServoOrder::switch_off)) {
      order_.give(ServoOrder::switch_off);  // somebody has left it on; one that calibrates is waited for
    }
  }
  /// Well first, then known to stop alone.
  void advance_configuring(std::int64_t now_ns) {
    if (unfed_since_ns_) return prove_watchdog(now_ns);
    if (has_told_since_order() && told_.status.errors == 0) order_.withdraw();
    if (has_told_since_order() && !told_.status.has_missed_host && told_.status.is_watching) {
      unfed_since_ns_ = now_ns;
      order_.withdraw();
      if (protocol_.watch() == ServoWatch::confirmed) order_.give(ServoOrder::set_watchdog);
    } else if (now_ns - clock_.since_ns() > settings_.stop_timeout_ns) {
      last_errors_ = told_.status.errors;
      refuse(DriveFinding::fault_stays, now_ns);
    }
  }
  void prove_watchdog(std::int64_t now_ns) {
    const bool is_tried = protocol_.watch() == ServoWatch::tried;
    const bool is_proven = is_tried ? told_.status.has_missed_host && told_.status_ns > *unfed_since_ns_
                                    : protocol_.watch() == ServoWatch::accepted || told_.has_watchdog == true;
    if (is_proven) {
      proven_ns_ = now_ns - *unfed_since_ns_;
      apply(DriveEvent::configured, now_ns);
    } else if (told_.has_watchdog == false || now_ns - *unfed_since_ns_ > settings_.watchdog_timeout_ns) {
      refuse(is_tried ? DriveFinding::watchdog_unproven : DriveFinding::watchdog_unconfirmed, now_ns);
    }
  }
  void advance_enabling(std::int64_t now_ns) {
    if (told_.status.errors != 0) return log_.find(DriveFinding::drive_fault);
    if (!told_.is_near(enabling_turns_, settings_.hold_tolerance_turns)) {
      return log_.find(DriveFinding::moved_while_enabling);
    }
    if (!told_.status.is_on) {
      const bool was_told = order_.is(ServoOrder::take_positions) && order_.was_sent();
      if (was_told) order_.give(ServoOrder::switch_on);
      return;
    }
    sent_ = waiting_ = {.turns = switching_on_turns()};
    if (log_.empty()) apply(DriveEvent::enabled, now_ns);
  }
  void watch_following(std::int64_t now_ns) {
    if (told_.status.errors != 0 || !told_.status.is_on) {
      // Without an error a new start switches it off, which takes a while, or somebody else has done it.
      log_.find(told_.status.errors != 0 ? DriveFinding::drive_fault
                : may_have_restarted()   ? DriveFinding::unexpected_boot
                                         : DriveFinding::switched_off_by_another);
      apply(DriveEvent::dropped_out, now_ns);
      return;
    }
    if (targets_ == Targets::none && !told_.is_near(sent_.turns, settings_.hold_tolerance_turns)) {
      log_.find(DriveFinding::moved_while_enabling);
    }
    if (!told_.is_near(sent_.turns, settings_.max_following_error_turns))
      log_.find_lasting(DriveFinding::following_error);
    if constexpr (Protocol::habits.has_two_scales) {
      if (targets_ != Targets::none) {
        scale_.look(protocol_.scale_watch(), told_.place.turns, told_.place_ns == now_ns, sent_, now_ns);
      }
      if (scale_.differs()) log_.find_lasting(DriveFinding::scale_differs);
    }
  }
  bool rests(std::int64_t now_ns) {
    rest_.look(told_.place.turns, now_ns);
    return rest_.rests() && told_.place_ns > *rest_.since_ns();
  }
  void advance_disabling(std::int64_t now_ns) {
    const bool is_at_rest = rests(now_ns);
    if (is_at_rest && !order_.stands()) order_.give(ServoOrder::switch_off);
    // One that has never told where it is has never been told to go anywhere.
    const bool has_come_to_rest = is_at_rest || told_.place_ns == 0;
    if (told_.status.is_off && has_told_since_order() && has_come_to_rest) {
      apply(DriveEvent::disabled, now_ns);
      return;
    }
    const bool is_late = now_ns - clock_.since_ns() > settings_.disable_timeout_ns / 2;
    const bool is_last_resort = order_.is(ServoOrder::stop_at_once);
    if (is_late && !told_.status.is_off && !is_last_resort) order_.give(ServoOrder::stop_at_once);
  }
  void watch_deadline(std::int64_t now_ns) {
    if (!clock_.is_late(now_ns)) return;
    if (phase() == clearing) last_errors_ = told_.status.errors;
    phase() == stopping ? log_.find_lasting(DriveFinding::quick_stop_ignored) : log_.find(why_late(now_ns));
    apply(DriveEvent::timed_out, now_ns);
  }
  [[nodiscard]] DriveFinding why_late(std::int64_t now_ns) const {
    const bool tells = now_ns - told_.status_ns <= settings_.status_timeout_ns;
    if (phase() == clearing) return DriveFinding::fault_stays;
    if (phase() == enabling) return DriveFinding::not_enabled;
    if (phase() == disabling && tells && told_.status.is_off) return DriveFinding::moves_while_off;
    if (phase() == disabling) return DriveFinding::not_switched_off;
    // booting
    if (!told_.is_heard()) return told_.status_ns != 0 ? DriveFinding::place_unsaid : DriveFinding::unheard;
    const bool is_known = told_.is_expected_device.has_value() || !protocol_.tells_identity();
    return is_known ? DriveFinding::not_switched_off : Protocol::misfit;
  }
  void accept(const Target& target) {
    const double step = std::fabs(target.turns - waiting_.turns);
    if (targets_ == Targets::none && step > settings_.first_step_turns)
      return log_.find(DriveFinding::moved_while_enabling);
    targets_ = Targets::given;
    if (step > settings_.max_step_turns || std::fabs(target.turns_per_s) > settings_.max_turns_per_s) {
      return log_.find(DriveFinding::setpoint_jump);
    }
    waiting_ = target;
  }

  Protocol protocol_;
  ServoSettings settings_;
  PhaseClock clock_;
  FindingLog log_;
  DriveCounters counters_;
  ServoTold told_;
  std::uint32_t last_errors_ = 0;
  StandingOrder order_;
  SilenceWatch silence_;     ///< in which it may have started anew
  std::int64_t now_ns_ = 0;  ///< of the last tick
  /// Configuring: it is well, and its watchdog is to be proven.
  std::optional<std::int64_t> unfed_since_ns_;
  std::int64_t proven_ns_ = 0;
  Targets targets_ = Targets::none;
  ServoTarget sent_;           ///< the last one
  ServoTarget waiting_;        ///< goes out in the next tick
  double enabling_turns_ = 0;  ///< where it was when it was to be switched on
  RestWatch rest_;
  PowerOff power_off_ = PowerOff::ordered;
  struct NoScaleWatch {};
  [[no_unique_address]] std::conditional_t<Protocol::habits.has_two_scales, ScaleWatch, NoScaleWatch> scale_;
};

}  // namespace inbetween::can
