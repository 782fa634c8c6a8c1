#include "inbetween/can/cia402_homing.hpp"

#include <array>

namespace inbetween::can {
namespace {

using Homing = DriveHomingState;

/// A drive may still tell of its homing before. One that says the same for so long after its start means this
/// one: methods 35 and 37 are over within a cycle, and are not seen to run.
constexpr std::int64_t old_answer_ns = 1'000'000'000;
/// What was told before the halt has passed after this time, and every ramp after that.
constexpr std::int64_t halt_known_ns = 100'000'000;
constexpr std::int64_t max_halt_ns = 2'000'000'000;
/// One feedback may be missing, and one step is the new zero.
constexpr std::int32_t max_fast_ticks = 3;

constexpr std::uint16_t homing_bits = status_stands | status_homing_attained | status_homing_error;

struct FailureWords {
  const char* what;
  const char* remedy;
};
// In the order of DriveHomingFailure.
constexpr std::array<FailureWords, drive_homing_failures> failure_words{{
    {"", ""},
    {"the drive tells a homing error (bit 13 of its statusword)",
     "look at its home and limit switches, and whether it can do the method of `home`"},
    {"the drive has not found its home in time",
     "look at its switch, write the method that leads towards it, or raise timeout_s"},
    {"the drive homes faster than it was told to",
     "write how it counts speeds (speed_per_unit), from its manual"},
    {"the drive is home, and tells another position than `at`",
     "if its home offset (607C) counts the other way, write at = 0 and min and max from there; or lower "
     "`slow`"},
}};

}  // namespace

const char* words_of(DriveHomingFailure failure) {
  return failure_words[static_cast<std::size_t>(failure)].what;
}
const char* remedy_of(DriveHomingFailure failure) {
  return failure_words[static_cast<std::size_t>(failure)].remedy;
}

DriveHomingState next_state(DriveHomingState state, DriveHomingEvent event) {
  switch (event) {
    case DriveHomingEvent::start:
      return state == Homing::waiting ? Homing::seeking : state;
    case DriveHomingEvent::attained:
      return state == Homing::seeking ? Homing::done : state;
    case DriveHomingEvent::failed:
      return state == Homing::seeking ? Homing::halting : state;
    case DriveHomingEvent::stop:
      if (state == Homing::waiting) return Homing::ended;
      return state == Homing::seeking ? Homing::halting : state;
    case DriveHomingEvent::stood:
      return state == Homing::halting ? Homing::ended : state;
    case DriveHomingEvent::lost:
      return state == Homing::seeking || state == Homing::halting ? Homing::ended : state;
  }
  return state;
}

bool Cia402Homing::apply(DriveHomingEvent event) {
  const Homing next = next_state(state_, event);
  const bool has_changed = next != state_;
  state_ = next;
  return has_changed;
}

bool Cia402Homing::start(std::int64_t now_ns) {
  if (!apply(DriveHomingEvent::start)) return false;
  since_ns_ = now_ns;
  return true;
}

void Cia402Homing::stop(std::int64_t now_ns) {
  if (apply(DriveHomingEvent::stop)) since_ns_ = now_ns;
}

void Cia402Homing::fail(DriveHomingFailure failure, std::int64_t now_ns) {
  failure_ = failure;
  if (apply(DriveHomingEvent::failed)) since_ns_ = now_ns;
}

bool Cia402Homing::is_too_fast(std::int32_t actual) {
  const std::int64_t step = last_ ? std::int64_t{actual} - *last_ : 0;
  last_ = actual;
  const bool is_far = step > spec_.max_step || -step > spec_.max_step;
  fast_ticks_ = is_far ? fast_ticks_ + 1 : 0;
  return fast_ticks_ >= max_fast_ticks;
}

void Cia402Homing::seek(const DriveFeedback& told, std::int64_t now_ns) {
  const auto bits = static_cast<std::uint16_t>(told.statusword & homing_bits);
  if (!before_) before_ = bits;
  has_answered_ = has_answered_ || bits != *before_ || now_ns - since_ns_ >= old_answer_ns;
  if (is_too_fast(told.actual)) return fail(DriveHomingFailure::too_fast, now_ns);
  if (now_ns - since_ns_ >= spec_.timeout_ns) return fail(DriveHomingFailure::timed_out, now_ns);
  if (!has_answered_) return;
  if ((bits & status_homing_error) != 0) return fail(DriveHomingFailure::error, now_ns);
  if (bits != (status_homing_attained | status_stands)) return;
  const std::int64_t off = std::int64_t{told.actual} - spec_.home;
  if (off > spec_.tolerance || -off > spec_.tolerance) return fail(DriveHomingFailure::elsewhere, now_ns);
  apply(DriveHomingEvent::attained);
}

void Cia402Homing::tick(const DriveFeedback& told, std::int64_t now_ns) {
  if (state_ == Homing::seeking) return seek(told, now_ns);
  if (state_ != Homing::halting) return;
  const std::int64_t halted_ns = now_ns - since_ns_;
  const bool stands = (told.statusword & status_stands) != 0;
  if ((stands && halted_ns >= halt_known_ns) || halted_ns >= max_halt_ns) apply(DriveHomingEvent::stood);
}

std::uint16_t Cia402Homing::control_bits() const {
  switch (state_) {
    case Homing::seeking:
      return control_start_homing;
    case Homing::halting:
      return control_start_homing | control_halt;
    case Homing::ended:
      return control_halt;
    case Homing::waiting:
    case Homing::done:
      break;
  }
  return 0;
}

}  // namespace inbetween::can
