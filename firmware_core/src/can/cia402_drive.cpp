#include "inbetween/can/cia402_drive.hpp"

#include <algorithm>

namespace inbetween::can {
namespace {

using enum DrivePhase;

/// How far `a` is from `b`; counts may be at opposite ends of their range.
std::int64_t distance(std::int32_t a, std::int32_t b) {
  const std::int64_t off = std::int64_t{a} - b;
  return off < 0 ? -off : off;
}

Cia402Goal goal_of(DrivePhase phase) {
  switch (phase) {
    case clearing:
      return Cia402Goal::reset_fault;
    case enabling:
    case following:
      return Cia402Goal::on;
    case stopping:
      return Cia402Goal::quick_stop;
    default:
      return Cia402Goal::off;
  }
}

}  // namespace

Result<Cia402Drive> Cia402Drive::make(const Cia402Settings& settings) {
  const std::int64_t heartbeat_ns = settings.setup.drive_heartbeat_ms * std::int64_t{1'000'000};
  const bool is_sensible =
      settings.max_step_counts > 0 && settings.hold_tolerance_counts >= 0 &&
      settings.first_step_counts >= 1 && settings.max_following_error_counts > 0 &&
      settings.missing_limit > 0 && settings.stop_timeout_ns > 0 && settings.bad_frame_limit >= 0 &&
      settings.bad_frame_ticks > 0 && settings.boot_timeout_ns > 0 && settings.sdo_timeout_ns > 0 &&
      settings.enable_timeout_ns > 0 && settings.disable_timeout_ns > settings.rest_ns &&
      settings.rest_ns >= 0 && settings.rest_counts >= 0 && settings.ignore_grace_ns >= 0 &&
      settings.homing.has_value() == settings.setup.homing.has_value() &&
      settings.heartbeat_timeout_ns >= 2 * heartbeat_ns;
  if (!is_sensible) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a limit or time of a drive is not positive, or its heartbeat is missed after one",
                 .remedy = "give positive limits, and two heartbeats or more before it counts as lost"};
  }
  Result<Cia402Drive> drive = Cia402Drive(settings);
  if (const Status written = write_setup_script(settings.setup, drive->script_); !written)
    return written.error();
  return drive;
}

Cia402Drive::Cia402Drive(const Cia402Settings& settings)
    : settings_(settings),
      runner_(settings.setup.node, settings.sdo_timeout_ns),
      exit_(settings.setup.node, settings.sdo_timeout_ns, settings.setup.is_guarded),
      heartbeat_({.timeout_ns = settings.heartbeat_timeout_ns, .boot_timeout_ns = settings.boot_timeout_ns}),
      log_({.limit = settings.bad_frame_limit, .ticks = settings.bad_frame_ticks}),
      rest_(settings.rest_counts, settings.rest_ns) {
  if (settings.homing) homing_.emplace(*settings.homing);
}

void Cia402Drive::acknowledge() {
  log_.acknowledge();
  emergency_ns_.reset();
}

void Cia402Drive::enter(std::int64_t now_ns) {
  if (homing_) homing_->lose();
  order_.reset();
  is_seeded_ = false;
  switch (phase()) {
    case booting:
      clock_.set_deadline(now_ns + settings_.boot_timeout_ns);
      order_ = settings_.reset;
      has_tried_all_rpdos_ = false;
      use_rpdo(1);
      heartbeat_.stop();
      feedback_ = {};
      has_feedback_ = false;
      has_written_ = false;
      was_sent_back_ = false;
      has_booted_again_ = false;
      emergency_ns_.reset();
      has_lost_touch_ = false;
      is_cut_ = false;
      break;
    case configuring:
      strays_ = 0;
      runner_.begin(script_);
      break;
    case starting:
      clock_.set_deadline(now_ns + settings_.boot_timeout_ns);
      order_ = NmtCommand::start;
      watch_heartbeat(now_ns);
      host_heartbeat_sent_ = false;
      missed_in_row_ = 0;
      awaited_ = 0;
      break;
    case clearing:
    case stopping:
      clock_.set_deadline(now_ns + settings_.stop_timeout_ns);
      break;
    case enabling:
      clock_.set_deadline(now_ns + settings_.enable_timeout_ns);
      modeless_ns_.reset();
      enabled_ns_.reset();
      if (homing_) homing_.emplace(*settings_.homing);
      break;
    case following:
      followed_ns_ = now_ns;
      unlimited_ns_ = now_ns;
      is_commanded_ = false;
      break;
    case disabling:
      clock_.set_deadline(now_ns + settings_.disable_timeout_ns);
      rest_.begin();
      exit_.hush();
      break;
    case leaving:
      enter_leaving(now_ns);
      break;
    case gone:
      has_lost_touch_ = true;
      break;
    default:
      break;
  }
}

/// A drive may send heartbeats less often than it was told to; three of them are waited for.
void Cia402Drive::watch_heartbeat(std::int64_t now_ns) {
  constexpr std::int64_t three_heartbeats_ns_per_ms = 3'000'000;
  const std::int64_t rounded_ns = runner_.drive_heartbeat_ms() * three_heartbeats_ns_per_ms;
  heartbeat_ = HeartbeatConsumer({.timeout_ns = std::max(settings_.heartbeat_timeout_ns, rounded_ns),
                                  .boot_timeout_ns = settings_.boot_timeout_ns});
  heartbeat_.start(now_ns);
}

std::optional<Frame> Cia402Drive::note_host_heartbeat() {
  host_heartbeat_sent_ = true;
  const bool is_asked = settings_.setup.is_guarded && needs_sync();
  if (!is_asked) return {};
  guard_questions_ = std::min<std::int32_t>(guard_questions_ + 1, 2);
  return guard_request_frame(node());
}

void Cia402Drive::note_foreign_frame() {
  ++counters_.foreign_frames;
  log_.find(DriveFinding::foreign_sender);
}

bool Cia402Drive::has_process_data() const {
  return phase() == starting || phase() == disabling || phase() == disabled || clock_.is_supervised();
}

void Cia402Drive::tick(std::int64_t now_ns) {
  log_.begin_tick();
  if (has_process_data()) count_ticks();
  if (clock_.is_supervised()) watch_connection(now_ns);
  judge_emergency(now_ns);
  advance(now_ns);
  watch_deadline(now_ns);
  if (clock_.is_switching_on() && !log_.empty()) apply(DriveEvent::dropped_out, now_ns);
}

void Cia402Drive::count_ticks() {
  log_.forgive();
  if (is_fresh_) missed_in_row_ = 0;
  if (!is_fresh_ && phase() != starting) {
    if (clock_.is_supervised()) ++counters_.missed;
    missed_in_row_ = std::min(missed_in_row_ + 1, settings_.missing_limit);
  }
  // An answer still awaited after a tick with feedback was lost; after one without, it may come late.
  awaited_ = (is_fresh_ ? 0 : std::min<std::int32_t>(awaited_, 1)) + 1;
  is_fresh_ = false;
}

void Cia402Drive::watch_connection(std::int64_t now_ns) {
  if (missed_in_row_ >= settings_.missing_limit) log_.find_lasting(DriveFinding::feedback_missing);
  if (heartbeat_.poll(now_ns) == HeartbeatState::lost) log_.find_lasting(DriveFinding::heartbeat_lost);
  if (heard_ != NmtState::operational) {
    log_.find(DriveFinding::left_operational);
    apply(DriveEvent::vanished, now_ns);
  }
}

void Cia402Drive::advance(std::int64_t now_ns) {
  switch (phase()) {
    case configuring:
      return advance_configuring(now_ns);
    case starting:
      return advance_starting(now_ns);
    case clearing:
      return advance_clearing(now_ns);
    case enabling:
      return advance_enabling(now_ns);
    case following:
      return watch_following(now_ns);
    case stopping:
      if (is_faulty(state())) log_.find(DriveFinding::drive_fault);
      if (state() != Cia402State::operation_enabled) clock_.clear_deadline();
      return;
    case disabling:
      return advance_disabling(now_ns);
    case leaving:
      return advance_leaving(now_ns);
    default:
      return;
  }
}

/// A node may start by itself after its boot-up, and then it refuses to have its process data changed.
bool Cia402Drive::may_have_been_operational() const {
  return runner_.refusal().abort_code == abort_device_state ||
         (runner_.refusal().abort_code != 0 && heard_ == NmtState::operational);
}

void Cia402Drive::advance_configuring(std::int64_t now_ns) {
  if (runner_.state() == SetupState::done) apply(DriveEvent::configured, now_ns);
  if (runner_.state() != SetupState::refused) return;
  if (may_have_been_operational() && !was_sent_back_) {
    was_sent_back_ = true;
    order_ = NmtCommand::enter_pre_operational;
    runner_.begin(script_);
    return;
  }
  if (tries_another_rpdo()) return;
  log_.find(runner_.refusal().finding);
  apply(DriveEvent::refused, now_ns);
}

void Cia402Drive::use_rpdo(std::uint8_t number) {
  if (number == rpdo()) return;
  change_rpdo(script_, node(), rpdo(), number);
  settings_.setup.rpdo = number;
}

/// Some drives have the controlword and the target in an RPDO of their own choice, and no room in the first.
bool Cia402Drive::tries_another_rpdo() {
  constexpr std::uint8_t last = 4;
  const std::uint16_t object = runner_.refusal().object.index;
  const auto number = static_cast<std::uint16_t>(rpdo() - 1);
  const bool is_of_rpdo = object == 0x1400 + number || object == 0x1600 + number;
  if (!is_of_rpdo || has_tried_all_rpdos_) return false;
  has_tried_all_rpdos_ = rpdo() == last;
  use_rpdo(static_cast<std::uint8_t>(has_tried_all_rpdos_ ? 1 : rpdo() + 1));
  runner_.begin(script_);
  return true;
}

void Cia402Drive::advance_starting(std::int64_t now_ns) {
  const bool is_alive = heartbeat_.poll(now_ns) == HeartbeatState::alive;
  const bool is_operational = is_alive && heard_ == NmtState::operational;
  if (is_operational && has_feedback_ && host_heartbeat_sent_) apply(DriveEvent::started, now_ns);
}

void Cia402Drive::advance_clearing(std::int64_t now_ns) {
  // It is the rise of the bit that resets a fault. Some drives need a second one.
  constexpr std::int64_t half_edge_ns = 100'000'000;
  resets_now_ = (now_ns - clock_.since_ns()) / half_edge_ns % 2 == 0;
  const Cia402State at = state();
  const bool is_clear =
      !is_faulty(at) && at != Cia402State::not_ready && at != Cia402State::unknown && missed_in_row_ == 0;
  if (is_clear) apply(DriveEvent::cleared, now_ns);
}

bool Cia402Drive::holds_its_place() const {
  return distance(feedback_.actual, target_) <= settings_.hold_tolerance_counts;
}

Status Cia402Drive::set_position_limits(const CountRange& limits) {
  if (phase() != off) {
    return Error{
        .code = ErrorCode::wrong_state, .what = "the drive is in use", .remedy = "switch it off first"};
  }
  Cia402Setup setup = settings_.setup;
  setup.position_limits = limits;
  if (const Status written = write_setup_script(setup, script_); !written) {
    static_cast<void>(write_setup_script(settings_.setup, script_));
    return written;
  }
  settings_.setup = setup;
  return Done{};
}

/// A drive would take an axis that stands outside the limits which it was told back in by itself.
bool Cia402Drive::is_within_limits() const {
  const std::optional<CountRange>& limits = settings_.setup.position_limits;
  if (!limits || !runner_.place()) return true;
  const std::int64_t window = settings_.setup.place_window_counts;
  const std::int64_t place = *runner_.place();
  return target_ >= std::min<std::int64_t>(limits->min, place - window) &&
         target_ <= std::max<std::int64_t>(limits->max, place + window);
}

/// It is in the right mode; or it shows none, for so long that it may do that until it is enabled.
bool Cia402Drive::may_be_enabled(std::int64_t now_ns) {
  if (is_in_mode()) return true;
  if (feedback_.mode != 0 || !runner_.has_no_other_target()) {
    modeless_ns_.reset();
    return false;
  }
  if (!modeless_ns_) modeless_ns_ = now_ns;
  return now_ns - *modeless_ns_ >= settings_.mode_wait_ns;
}

void Cia402Drive::advance_enabling(std::int64_t now_ns) {
  const Cia402State at = state();
  if (is_faulty(at)) return log_.find(DriveFinding::drive_fault);
  const bool is_enabled = at == Cia402State::operation_enabled;
  const bool is_powered = is_enabled || at == Cia402State::switched_on;
  if (is_enabled && !enabled_ns_) enabled_ns_ = now_ns;
  const bool has_time_left = is_enabled && now_ns - *enabled_ns_ <= settings_.ignore_grace_ns;
  if (is_enabled && is_seeded_ && !is_in_mode() && (feedback_.mode != 0 || !has_time_left)) {
    log_.find(DriveFinding::mode_not_shown);
    apply(DriveEvent::quick_stop, now_ns);
    return;
  }
  const bool can_hold = is_powered && may_be_enabled(now_ns);
  if (can_hold && !is_seeded_) target_ = feedback_.actual;
  if (can_hold && !is_within_limits()) return log_.find(DriveFinding::moved_outside);
  is_seeded_ = can_hold;
  // In homing the bit says that the drive is home.
  const bool is_following =
      is_enabled && is_in_mode() && (homing_.has_value() || status_has(status_follows_target));
  if (!is_seeded_ || !is_following) return;
  if (!holds_its_place()) return log_.find(DriveFinding::moved_while_enabling);
  if (log_.empty()) apply(DriveEvent::enabled, now_ns);
}

void Cia402Drive::watch_following(std::int64_t now_ns) {
  const Cia402State at = state();
  if (at != Cia402State::operation_enabled) {
    log_.find(is_faulty(at) ? DriveFinding::drive_fault : DriveFinding::left_operation);
    const bool stops_itself = at == Cia402State::quick_stop_active;
    apply(stops_itself ? DriveEvent::stopped_itself : DriveEvent::dropped_out, now_ns);
    return;
  }
  if (!is_in_mode()) {
    log_.find_lasting(DriveFinding::wrong_mode);  // and the other bits mean something else
    if (homing_) apply(DriveEvent::quick_stop, now_ns);
    return;
  }
  if (!is_commanded_ && !holds_its_place()) log_.find(DriveFinding::moved_while_enabling);
  if (homing_) return homing_->tick(feedback_, now_ns);  // whose bits 11 to 13 mean other things, too
  if (status_has(status_follows_target)) followed_ns_ = now_ns;
  if (now_ns - followed_ns_ > settings_.ignore_grace_ns) log_.find_lasting(DriveFinding::target_ignored);
  // In interpolated position the profile says nothing of this bit; and some drives say nothing at all.
  const bool tells_error = !interpolates() && status_has(status_following_error);
  const bool is_too_far =
      is_commanded_ && distance(feedback_.actual, target_) > settings_.max_following_error_counts;
  if (tells_error || is_too_far) log_.find_lasting(DriveFinding::following_error);
  if (!status_has(status_internal_limit)) unlimited_ns_ = now_ns;
  if (now_ns - unlimited_ns_ > settings_.ignore_grace_ns) log_.find_lasting(DriveFinding::internal_limit);
}

void Cia402Drive::watch_deadline(std::int64_t now_ns) {
  if (!clock_.is_late(now_ns)) return;
  if (phase() == disabling) {
    give_up_disabling(now_ns);
  } else if (phase() == stopping) {
    log_.find_lasting(DriveFinding::quick_stop_ignored);
  } else {
    log_.find(why_late());
  }
  apply(DriveEvent::timed_out, now_ns);
}

DriveFinding Cia402Drive::why_late() const {
  const bool is_enabled = state() == Cia402State::operation_enabled;
  const bool is_powered = is_enabled || state() == Cia402State::switched_on;
  switch (phase()) {
    case booting:
      return DriveFinding::never_booted;
    case starting:
      return heartbeat_.state() == HeartbeatState::never_came ? DriveFinding::first_heartbeat_missing
                                                              : DriveFinding::not_operational;
    case clearing:
      return DriveFinding::fault_stays;
    case enabling:
      if (is_powered && !is_in_mode()) return DriveFinding::mode_not_shown;
      return is_enabled ? DriveFinding::follow_bit_missing : DriveFinding::not_enabled;
    default:  // leaving
      return DriveFinding::watchdog_stays;
  }
}

std::uint16_t Cia402Drive::controlword() const {
  if (goes_off()) return disabling_controlword();
  // Not enabled, or not any more, before it is in the right mode and its target is held.
  const bool waits_for_mode = phase() == enabling && !is_seeded_;
  const bool waits_for_edge = phase() == clearing && !resets_now_;
  const std::uint16_t word = controlword_for(waits_for_edge ? Cia402Goal::off : goal_of(phase()), state());
  if (waits_for_mode && word == control_enable_operation) return control_switch_on;
  // From where it is held, once it is in operation: the drive begins to interpolate by the rise of this bit.
  const bool is_on =
      (phase() == enabling || phase() == following) && state() == Cia402State::operation_enabled;
  if (!is_on || !is_in_mode()) return word;
  if (homing_) return word | homing_->control_bits();
  return interpolates() ? word | control_interpolate : word;
}

void Cia402Drive::choose_target(std::optional<std::int32_t> target) {
  if (phase() == enabling && is_seeded_) return;
  if (phase() != following) {
    target_ = feedback_.actual;
    return;
  }
  if (!target) return;
  if (homing_) {  // a drive that left its mode would have nowhere to go
    is_commanded_ = true;
    target_ = feedback_.actual;
    return;
  }
  const std::int64_t step = distance(*target, target_);
  if (!is_commanded_ && step > settings_.first_step_counts)
    return log_.find(DriveFinding::moved_while_enabling);
  is_commanded_ = true;
  if (step > settings_.max_step_counts) return log_.find(DriveFinding::setpoint_jump);
  target_ = *target;
}

std::optional<Frame> Cia402Drive::command(std::optional<std::int32_t> target) {
  if (!clock_.is_supervised() && !(goes_off() && hears_commands())) return {};
  if (phase() == following && is_commanded_ && !target) return {};
  choose_target(target);
  return command_frame(node(), {.controlword = controlword(), .target = target_}, rpdo());
}

bool Cia402Drive::wants_service() const {
  return order_.has_value() || phase() == configuring || phase() == disabling || phase() == leaving;
}

std::optional<Frame> Cia402Drive::service(std::int64_t now_ns) {
  if (order_) {
    const NmtOrder order{.command = *order_, .node = node().value()};
    order_.reset();
    return nmt_frame(order);
  }
  if (phase() == configuring) {
    const std::optional<Frame> frame = runner_.poll(script_, now_ns);
    has_written_ = has_written_ || runner_.state() == SetupState::writing;
    return frame;
  }
  if (phase() == disabling) {
    const auto word = hears_commands() ? std::optional<std::uint16_t>{} : disabling_controlword();
    return exit_.poll(word, now_ns);
  }
  if (phase() == leaving) return exit_.poll({}, now_ns);
  return {};
}

}  // namespace inbetween::can
