// A simulated drive homes itself: fast over its switch, slowly back onto its edge, which is its home. It
// reads the direction from where its switch is, and from the method only whether it moves at all.
#include <algorithm>
#include <cmath>

#include "sim/cia402_drive.hpp"

namespace inbetween {

void SimulatedCia402Drive::begin_homing() {
  is_home_ = false;
  has_homing_error_ = false;
  has_been_moved_ = true;
  const std::uint32_t method = objects_.value(0x6098);
  const bool stays = method == 35 || method == 37;
  home_direction_ = settings_.home_switch < motor_.position() ? -1 : 1;
  homing_ = stays ? Homing::found : Homing::fast;
  if (stays) set_zero(motor_.position());
}

void SimulatedCia402Drive::set_zero(double home) {
  zero_ = home - static_cast<std::int32_t>(objects_.value(0x607C));
  is_home_ = true;
}

/// What it wants to move at. The switch closes and opens at the same place.
double SimulatedCia402Drive::homing_velocity() {
  const bool has_bit = (last_word_ & can::control_start_homing) != 0;
  if (!has_bit && homing_ != Homing::found) homing_ = Homing::none;
  has_homing_error_ = has_homing_error_ || (homing_ != Homing::none && has_trouble(Kind::homing_error));
  if (has_homing_error_ || (last_word_ & can::control_halt) != 0) return 0;
  const bool is_behind = (demand_ - settings_.home_switch) * home_direction_ > 0;
  if (homing_ == Homing::fast && is_behind && !has_trouble(Kind::no_home)) homing_ = Homing::back;
  if (homing_ == Homing::back && !is_behind) {
    homing_ = Homing::found;
    set_zero(settings_.home_switch);
  }
  if (homing_ == Homing::fast) return home_direction_ * objects_.value(0x6099, 1);
  return homing_ == Homing::back ? -home_direction_ * objects_.value(0x6099, 2) : 0;
}

void SimulatedCia402Drive::home(double seconds) {
  const double most = objects_.value(0x609A) * seconds;
  demand_velocity_ += std::clamp(homing_velocity() - demand_velocity_, -most, most);
  demand_ += demand_velocity_ * seconds;
  motor_.follow({.position = demand_, .velocity = demand_velocity_}, seconds);
}

unsigned SimulatedCia402Drive::homing_status() const {
  unsigned word = 0;
  if (is_in_operation() && demand_velocity_ == 0) word |= can::status_stands;
  if (is_home_) word |= can::status_homing_attained;
  if (has_homing_error_) word |= can::status_homing_error;
  return word;
}

}  // namespace inbetween
