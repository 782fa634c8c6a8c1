#include <array>

#include "inbetween/can/cia402_setup.hpp"
#include "inbetween/can/pdo.hpp"

namespace inbetween::can {
namespace {

using enum SetupState;

constexpr std::array<std::array<SetupState, setup_events>, setup_states> table{{
    // begin_reading, begin_writing, written, finished, differs
    {reading, writing, idle, done, idle},           // idle
    {reading, writing, reading, done, refused},     // reading
    {reading, writing, verifying, done, refused},   // writing
    {reading, writing, verifying, done, refused},   // verifying
    {reading, writing, done, done, done},           // done
    {reading, writing, refused, refused, refused},  // refused
}};

constexpr bool reads_first(SetupAction action) {
  return action != SetupAction::write && action != SetupAction::watchdog && action != SetupAction::sync_watch;
}
/// The reasons that the client itself gives: no answer, or a senseless one.
constexpr bool is_of_host(std::uint32_t abort_code) {
  return abort_code == abort_timeout || abort_code == abort_unknown_command;
}
constexpr std::uint32_t mask_of(std::uint8_t size) {
  return 0xFFFFFFFFU >> (8U * (4U - size));
}
constexpr std::uint16_t setpoint_timer_index = 0x1400;

}  // namespace

SetupState next_state(SetupState state, SetupEvent event) {
  return table[static_cast<std::size_t>(state)][static_cast<std::size_t>(event)];
}

void SetupRunner::begin(const SetupScript& script) {
  client_.reset();
  refusal_ = {};
  step_ = 0;
  host_timeout_ms_ = 0;
  setpoint_timeout_ms_ = 0;
  begin_step(script);
}

std::optional<Frame> SetupRunner::poll(const SetupScript& script, std::int64_t now_ns) {
  const bool is_working = state_ == reading || state_ == writing || state_ == verifying;
  if (is_working && client_.state() == SdoState::done) answered(script);
  if (is_working && client_.state() == SdoState::failed) has_failed(script, script[step_]);
  return client_.poll(now_ns);
}

void SetupRunner::begin_step(const SetupScript& script) {
  if (step_ == script.size()) {
    state_ = next_state(state_, SetupEvent::finished);
    return;
  }
  const SetupStep& step = script[step_];
  const bool is_needless = step.action == SetupAction::sync_watch && host_timeout_ms_ != 0;
  if (!reads_first(step.action)) return write(step, is_needless ? 0 : step.value);
  state_ = next_state(state_, SetupEvent::begin_reading);
  client_.begin_upload(step.object, step.size);
}

void SetupRunner::next_step(const SetupScript& script) {
  ++step_;
  const bool is_watched = host_timeout_ms_ != 0 || setpoint_timeout_ms_ != 0;
  if (step_ == script.size() && !is_watched) return refuse(script[step_ - 1], DriveFinding::watchdog_unset);
  begin_step(script);
}

void SetupRunner::write(const SetupStep& step, std::uint32_t value) {
  state_ = next_state(state_, SetupEvent::begin_writing);
  written_ = value;
  client_.begin_download(step.object, step.size, value);
}

void SetupRunner::answered(const SetupScript& script) {
  const SetupStep& step = script[step_];
  if (state_ == reading) return has_read(script, step);
  if (state_ == verifying) return has_verified(script, step);
  state_ = next_state(state_, SetupEvent::written);
  client_.begin_upload(step.object, step.size);
}

void SetupRunner::has_read(const SetupScript& script, const SetupStep& step) {
  const std::uint32_t found = client_.value();
  const bool is_equal = (found & step.mask) == step.value;
  switch (step.action) {
    case SetupAction::expect:
      return is_equal ? next_step(script) : refuse(step, step.finding);
    case SetupAction::forbid:
      return is_equal ? refuse(step, step.finding) : next_step(script);
    case SetupAction::switch_off:
      return write(step, found | cob_id_is_invalid);
    case SetupAction::switch_on:
      return write(step, step.value | (found & cob_id_without_rtr));
    case SetupAction::write:
    case SetupAction::watchdog:
    case SetupAction::sync_watch:
      return;  // these do not read first
  }
}

void SetupRunner::has_verified(const SetupScript& script, const SetupStep& step) {
  if (step.action == SetupAction::watchdog) {
    note_watchdog(step);
  } else if (client_.value() != (written_ & mask_of(step.size))) {
    return refuse(step, step.finding);
  }
  next_step(script);
}

void SetupRunner::has_failed(const SetupScript& script, const SetupStep& step) {
  const std::uint32_t code = client_.abort_code();
  const bool is_absent = code == abort_no_object || code == abort_no_sub_index;
  const bool is_no_watchdog = step.action == SetupAction::watchdog && !is_of_host(code);
  if (is_no_watchdog || (step.may_be_absent && is_absent)) return next_step(script);
  refuse(step, DriveFinding::sdo_failed);
  refusal_.abort_code = code;
}

void SetupRunner::refuse(const SetupStep& step, DriveFinding finding) {
  state_ = next_state(state_, SetupEvent::differs);
  refusal_ = {.finding = finding, .object = step.object, .expected = step.value, .found = client_.value()};
}

/// A drive may round a time up; one of more than twice what was asked is as good as none.
void SetupRunner::note_watchdog(const SetupStep& step) {
  const auto asked_ms = static_cast<std::uint16_t>(step.value);
  const auto found_ms = static_cast<std::uint16_t>(client_.value());
  const bool is_same_node = (client_.value() >> 16) == (step.value >> 16);
  if (!is_same_node || found_ms == 0 || found_ms > 2 * asked_ms) return;
  (step.object.index == setpoint_timer_index ? setpoint_timeout_ms_ : host_timeout_ms_) = found_ms;
}

}  // namespace inbetween::can
