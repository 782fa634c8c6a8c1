#include "sim/cia402_drive.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sim/cia402_objects.hpp"

namespace inbetween {
namespace {

using can::Cia402State;

constexpr std::uint8_t error_of_profile = 0x21;
constexpr std::uint16_t following_error = 0x8611;

// In the order of Cia402State.
constexpr std::array<std::uint16_t, can::cia402_states> state_bits{0,      0x0040, 0x0021, 0x0023, 0x0027,
                                                                   0x0007, 0x000F, 0x0008, 0};

std::int32_t as_signed(std::uint32_t value) {
  return static_cast<std::int32_t>(value);
}
std::uint32_t as_counts(double value) {
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(value + std::copysign(0.5, value)));
}
constexpr double as_seconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

}  // namespace

SimulatedCia402Drive::SimulatedCia402Drive(const SimulatedCia402Settings& settings, std::int64_t now_ns)
    : SimulatedServo(settings, settings.position, now_ns, settings.boot_delay_ns),
      settings_(settings),
      objects_(settings.objects.value_or(factory_objects(settings.node))),
      defaults_(objects_) {
  for (const DriveTrouble& trouble : settings.troubles) troubles_.add(trouble);
  if (settings.counts_from_power_on) zero_ = motor_.position();
  show();
}

void SimulatedCia402Drive::add_object(can::ObjectAddress address, const ObjectDictionary::Object& object) {
  objects_.add(address, object);
  defaults_.add(address, object);
}
void SimulatedCia402Drive::remove_object(can::ObjectAddress address) {
  objects_.remove(address);
  defaults_.remove(address);
}
void SimulatedCia402Drive::change_access(can::ObjectAddress address, ObjectDictionary::Access access) {
  objects_.change_access(address, access);
  defaults_.change_access(address, access);
}

void SimulatedCia402Drive::advance(std::int64_t now_ns) {
  while (now_ns_ < now_ns) {
    run_motor_quietly(now_ns);
    if (now_ns_ < now_ns) advance_a_step(now_ns);
  }
}

void SimulatedCia402Drive::live(double seconds) {
  if (is_booting_ && now_ns_ >= boot_ns_) boot();
  watch_communication();
  babble();
  step(seconds);
}

/// As far as nothing but the motor moves, without asking in every step whether something is due.
void SimulatedCia402Drive::run_motor_quietly(std::int64_t until_ns) {
  const std::int64_t event_ns = next_event_ns();
  if (event_ns <= now_ns_) return;
  const MotionObjects objects = motion_objects();
  if (objects.homes) return;
  const std::int64_t steps = (std::min(until_ns, event_ns - 1) - now_ns_) / step_ns;
  now_ns_ += step_ns * follow_target(objects, as_seconds(step_ns), steps);
  const std::int64_t rest_ns = until_ns - now_ns_;
  if (!is_following_error_ && rest_ns > 0 && rest_ns < step_ns && until_ns < event_ns) {
    now_ns_ = until_ns;
    follow_target(objects, as_seconds(rest_ns), 1);
  }
  if (is_following_error_) fail(following_error);
}

/// Now where something may happen in any step.
std::int64_t SimulatedCia402Drive::next_event_ns() const {
  if (troubles_.has_any() || is_booting_ || is_enabling_ || !is_in_operation()) return now_ns_;
  std::int64_t next_ns = std::numeric_limits<std::int64_t>::max();
  if (settings_now().heartbeat_period_ns > 0) next_ns = heartbeat_ns_;
  for (const auto& deadline_ns :
       {host_deadline_ns_, guard_deadline_ns_, setpoint_deadline_ns_, sync_deadline_ns_}) {
    if (deadline_ns) next_ns = std::min(next_ns, *deadline_ns);
  }
  return next_ns;
}

SimulatedCia402Drive::MotionObjects SimulatedCia402Drive::motion_objects() const {
  if (!is_in_operation()) return {};
  const Settings& settings = settings_now();
  const bool is_watched = settings.following_window != 0xFFFFFFFF;
  return {.period_s = period_s(),
          .min = settings.min + zero_,
          .max = settings.max + zero_,
          .target = target(),
          .window = is_watched ? settings.following_window : std::numeric_limits<double>::infinity(),
          .window_ms = static_cast<double>(settings.following_ms),
          .homes = is_to_home()};
}

void SimulatedCia402Drive::step(double seconds) {
  motor_.hold(has_trouble(Kind::stick));
  switch (state_) {
    case Cia402State::operation_enabled:
      follow(motion_objects(), seconds);
      if (is_following_error_) fail(following_error);
      break;
    case Cia402State::quick_stop_active:
    case Cia402State::fault_reaction_active:
      slow_down(seconds);
      break;
    default:
      coast(seconds);
  }
  if (is_enabling_ && now_ns_ >= enabled_ns_) enter(Cia402State::operation_enabled);
}

/// A drive without 60C2 goes by 1006, or by the SYNC that it hears.
double SimulatedCia402Drive::period_s() const {
  if (settings_now().interpolation_s > 0) return settings_now().interpolation_s;
  const std::int64_t sync_ns = settings_now().sync_period_ns;
  return std::max(sync_ns > 0 ? static_cast<double>(sync_ns) * 1e-9 : sync_period_s_,
                  static_cast<double>(step_ns) * 1e-9);
}

void SimulatedCia402Drive::follow(const MotionObjects& objects, double seconds) {
  if (!objects.homes && !has_trouble(Kind::ignore_target)) {
    follow_target(objects, seconds, 1);
    return;
  }
  since_sync_s_ += seconds;
  if (objects.homes) {
    home(seconds);
  } else {
    slow_demand_down(seconds);
    from_ = demand_;
  }
  is_following_error_ =
      objects.is_too_far(demand_ - motor_.position(), seconds, beyond_window_s_) && !has_trouble(Kind::blind);
}

/// So many steps, or less if there is a following error after one. Returns how many it were.
std::int64_t SimulatedCia402Drive::follow_target(const MotionObjects& objects, double seconds,
                                                 std::int64_t steps) {
  double target = objects.target.value_or(demand_);
  if (objects.min < objects.max) {
    const double clipped = std::clamp(target, objects.min, objects.max);
    is_limited_ = clipped != target;
    target = clipped;
  }
  const double period = objects.period_s;
  const double from = from_;
  const double velocity = (target - from) / period;
  // Copies stay in registers. A step waits for the one before, and would wait for the memory too.
  SimulatedMotor motor = motor_;
  SimulatedMotor::Demand demand{.position = demand_, .velocity = demand_velocity_};
  double since_sync_s = since_sync_s_;
  double beyond_window_s = beyond_window_s_;
  const std::optional<double> runs_away = troubles_.place(Kind::run_away, now_ns_);
  const bool is_blind = has_trouble(Kind::blind);
  bool is_too_far = false;
  std::int64_t made = 0;
  while (made < steps && !is_too_far) {
    ++made;
    since_sync_s += seconds;
    demand.position = since_sync_s < period ? from + velocity * since_sync_s : target;
    // The last step of a period ends with the next SYNC.
    demand.velocity = since_sync_s < period + seconds / 2 ? velocity : 0;
    runs_away ? motor.follow_speed(*runs_away, seconds) : motor.follow(demand, seconds);
    is_too_far =
        objects.is_too_far(demand.position - motor.position(), seconds, beyond_window_s) && !is_blind;
  }
  motor_ = motor;
  demand_ = demand.position;
  demand_velocity_ = demand.velocity;
  since_sync_s_ = since_sync_s;
  beyond_window_s_ = beyond_window_s;
  is_following_error_ = is_too_far;
  return made;
}

/// At SYNC. It needs the set-point after the one that it goes to, so that it is a period behind; without bit
/// 4 of the controlword it stays where it is.
void SimulatedCia402Drive::take_set_point() {
  if (mode() != interpolated_position) {
    is_interpolating_ = false;
    return;
  }
  const std::int32_t told = as_signed(objects_.value(settings_now().set_point));
  set_point_ = is_interpolating_ ? next_set_point_ : told;
  next_set_point_ = told;
  is_interpolating_ = is_in_operation() && (last_word_ & can::control_interpolate) != 0;
}

std::optional<double> SimulatedCia402Drive::target() const {
  if (mode() != interpolated_position) return as_signed(objects_.value(settings_now().target)) + zero_;
  if (is_interpolating_) return set_point_ + zero_;
  return {};
}

/// By the ramp of 6085, the same for a quick stop, for the reaction to a fault and where targets are ignored.
/// Whether it rests.
bool SimulatedCia402Drive::slow_demand_down(double seconds) {
  constexpr double unsaid_ramp = 500'000;  // counts/s^2, of a drive without 6085
  const std::uint32_t ramp = objects_.value(0x6085);
  const double lost = (ramp > 0 ? ramp : unsaid_ramp) * seconds;
  const bool rests = std::fabs(demand_velocity_) <= lost;
  demand_velocity_ = rests ? 0 : demand_velocity_ - std::copysign(lost, demand_velocity_);
  demand_ += demand_velocity_ * seconds;
  motor_.follow({.position = demand_, .velocity = demand_velocity_}, seconds);
  return rests;
}

/// A motor that runs away obeys no quick stop; a fault takes its power in the end.
void SimulatedCia402Drive::slow_down(double seconds) {
  const std::optional<double> speed = troubles_.place(Kind::run_away, now_ns_);
  if (speed && state_ == Cia402State::quick_stop_active) return motor_.follow_speed(*speed, seconds);
  if (!slow_demand_down(seconds)) return;
  if (state_ == Cia402State::fault_reaction_active) {
    enter(Cia402State::fault);
  } else if (objects_.value(0x605A) < 5) {
    enter(Cia402State::switch_on_disabled);
  }
}

void SimulatedCia402Drive::stop_quickly() {
  if (state_ == Cia402State::operation_enabled) {
    const bool coasts = objects_.value(0x605A) == 0;
    enter(coasts ? Cia402State::switch_on_disabled : Cia402State::quick_stop_active);
  } else if (state_ == Cia402State::ready_to_switch_on || state_ == Cia402State::switched_on) {
    enter(Cia402State::switch_on_disabled);
  }
}

void SimulatedCia402Drive::fail(std::uint16_t code) {
  if (state_ == Cia402State::fault || state_ == Cia402State::fault_reaction_active) return;
  raise_error(code, error_of_profile);
  const bool is_powered = is_in_operation() || state_ == Cia402State::quick_stop_active;
  const bool brakes = is_powered && objects_.value(0x605E) != 0;
  enter(brakes ? Cia402State::fault_reaction_active : Cia402State::fault);
}

void SimulatedCia402Drive::enter(Cia402State state) {
  const bool was_in_operation = is_in_operation();
  const bool slows_down =
      state == Cia402State::quick_stop_active || state == Cia402State::fault_reaction_active;
  is_enabling_ = false;
  is_interpolating_ = false;
  homing_ = Homing::none;
  if (state == Cia402State::operation_enabled) {
    demand_ = from_ = motor_.position();
    demand_velocity_ = 0;
    beyond_window_s_ = 0;
    is_following_error_ = false;
  } else if (slows_down && was_in_operation) {
    demand_ = motor_.position();
    demand_velocity_ = motor_.velocity();
  }
  const bool is_new = state != state_;
  state_ = state;
  if (is_new) record_entered();
}

/// The transitions of the profile, by the bits of the controlword.
void SimulatedCia402Drive::obey_controlword(std::uint16_t word) {
  const bool resets = (word & 0x80) != 0 && (last_word_ & 0x80) == 0;
  const bool starts_homing = (word & ~last_word_ & can::control_start_homing) != 0;
  last_word_ = word;
  if (starts_homing && is_to_home() && is_in_operation()) begin_homing();
  if (state_ == Cia402State::fault_reaction_active) return;
  if (state_ == Cia402State::fault) {
    if (!resets || has_trouble(Kind::emergency)) return;
    is_following_error_ = false;
    raise_error(0, 0);
    enter(Cia402State::switch_on_disabled);
    return;
  }
  const bool switch_on = (word & 0x01) != 0;
  const bool voltage = (word & 0x02) != 0;
  const bool no_quick_stop = (word & 0x04) != 0;
  const bool enable = (word & 0x08) != 0;
  const bool is_on = state_ == Cia402State::switched_on || is_in_operation();
  if (is_on && !enable && has_trouble(Kind::stay_on)) return;
  if (!voltage) {
    enter(Cia402State::switch_on_disabled);
  } else if (!no_quick_stop) {
    stop_quickly();
  } else if (state_ == Cia402State::quick_stop_active) {
    return;  // it is left by disabling the voltage only
  } else if (!switch_on) {
    enter(Cia402State::ready_to_switch_on);
  } else if (!enable) {
    if (state_ != Cia402State::switch_on_disabled) enter(Cia402State::switched_on);
  } else if (state_ == Cia402State::ready_to_switch_on) {
    enter(Cia402State::switched_on);
  } else if (state_ == Cia402State::switched_on && !is_enabling_) {
    is_enabling_ = true;
    enabled_ns_ = now_ns_ + settings_.enable_delay_ns;
  }
}

void SimulatedCia402Drive::react_to_lost_communication() {
  if (state_ == Cia402State::switch_on_disabled) return;
  switch (objects_.value(0x6007)) {
    case 1:
      if (is_in_operation()) {
        enter(objects_.value(0x605E) != 0 ? Cia402State::fault_reaction_active : Cia402State::fault);
      }
      break;
    case 2:
      enter(Cia402State::switch_on_disabled);
      break;
    case 3:
      stop_quickly();
      break;
    default:
      break;
  }
}

std::uint16_t SimulatedCia402Drive::statusword() const {
  if (is_to_home()) {
    return static_cast<std::uint16_t>(state_bits.at(static_cast<std::size_t>(state_)) | 0x0210U |
                                      homing_status());
  }
  const bool takes_targets =
      mode() == cyclic_position || (mode() == interpolated_position && is_interpolating_);
  const bool follows = is_in_operation() && takes_targets && !has_trouble(Kind::ignore_target);
  unsigned word = state_bits.at(static_cast<std::size_t>(state_)) | 0x0210U;
  if (is_limited_ && is_in_operation()) word |= can::status_internal_limit;
  if (follows) word |= can::status_follows_target;
  if (is_following_error_) word |= can::status_following_error;
  return static_cast<std::uint16_t>(word);
}

void SimulatedCia402Drive::show() {
  const bool is_wrong = has_trouble(Kind::wrong_mode);
  const Settings& at = settings_now();
  objects_.set(at.statusword, statusword());
  objects_.set(at.mode_display,
               is_wrong ? static_cast<std::uint32_t>(troubles_.value(Kind::wrong_mode, now_ns_)) : at.mode);
  objects_.set(at.position, as_counts(here()));
  objects_.set(at.velocity, as_counts(motor_.velocity()));
  objects_.set(at.following_error, as_counts(is_in_operation() ? demand_ - motor_.position() : 0));
}

}  // namespace inbetween
