// How a drive is switched off and let go. It must have no power and its axis must rest before its watchdogs
// are taken away: until then they are what stops the motor if this program dies.
#include "inbetween/can/cia402_drive.hpp"

namespace inbetween::can {

using enum DrivePhase;

/// It obeys the controlword in its process data.
bool Cia402Drive::hears_commands() const {
  return heard_ == NmtState::operational && has_feedback_;
}

/// On a bus of many drives the order to leave waits for its turn. Until it is sent the drive misses its
/// setpoints, and would take silence for a fault.
bool Cia402Drive::goes_off() const {
  return phase() == disabling || phase() == disabled || (phase() == leaving && order_.has_value());
}

/// A fault that only says that this program was silent for a while. It is reset while the drive switches off,
/// once the host is heard again; a fault of the drive itself stays for whoever looks at it.
bool Cia402Drive::has_lost_touch_by_fault() const {
  return has_lost_touch_ && state() == Cia402State::fault && is_of_communication(last_emergency_.code);
}

bool Cia402Drive::has_no_power() const {
  switch (state()) {
    case Cia402State::not_ready:
    case Cia402State::switch_on_disabled:
      return true;
    case Cia402State::fault:
      return !has_lost_touch_by_fault();
    default:
      return false;
  }
}

/// A quick stop is not cut short: without voltage the axis would coast.
std::uint16_t Cia402Drive::disabling_controlword() const {
  if (is_cut_ && !is_faulty(state())) return control_disable_voltage;
  if (state() == Cia402State::quick_stop_active && !rest_.rests()) return control_quick_stop;
  return controlword_for(has_lost_touch_by_fault() ? Cia402Goal::reset_fault : Cia402Goal::off, state());
}

void Cia402Drive::advance_disabling(std::int64_t now_ns) {
  const bool has_missed = missed_in_row_ > 0;
  if (hears_commands() && missed_in_row_ < settings_.missing_limit) {
    exit_.hush();
    if (!has_missed) rest_.look(feedback_.actual, now_ns);
  } else {
    exit_.ask();
  }
  if (const std::optional<DriveFeedback> told = exit_.take_feedback()) {
    feedback_.statusword = told->statusword;
    // A drive that has started anew counts from another place.
    if (!log_.all().has(DriveFinding::unexpected_boot)) feedback_.actual = told->actual;
    rest_.look(told->actual, now_ns);
  }
  if (exit_.state() == ExitState::failed) {
    clock_.set_deadline(now_ns);
  } else if (rest_.rests() && has_no_power()) {
    apply(DriveEvent::disabled, now_ns);
  }
}

void Cia402Drive::give_up_disabling(std::int64_t now_ns) {
  const bool tells = exit_.state() != ExitState::failed && rest_.since_ns().has_value();
  if (tells && rest_.rests() && state() == Cia402State::fault) {
    log_.find(DriveFinding::fault_stays);
    apply(DriveEvent::disabled, now_ns);
    return;
  }
  log_.find(tells && has_no_power() ? DriveFinding::moves_while_off : DriveFinding::not_switched_off);
}

void Cia402Drive::enter_leaving(std::int64_t now_ns) {
  order_ = has_lost_touch_ ? settings_.reset : NmtCommand::enter_pre_operational;
  clock_.set_deadline(now_ns + settings_.boot_timeout_ns);
  has_lost_touch_ ? exit_.hush() : exit_.release(runner_.absent().span(), rpdo());
}

/// A drive that does not give its watchdogs away is set back to what it watched at power-on.
void Cia402Drive::advance_leaving(std::int64_t now_ns) {
  if (order_ || has_lost_touch_) return;
  if (exit_.state() == ExitState::released) apply(DriveEvent::left, now_ns);
  if (exit_.state() != ExitState::failed) return;
  has_lost_touch_ = true;
  enter_leaving(now_ns);
}

}  // namespace inbetween::can
