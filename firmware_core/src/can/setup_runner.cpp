#include <algorithm>
#include <array>
#include <limits>

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
  return action < SetupAction::write_at_once;
}
constexpr std::uint32_t mask_of(std::uint8_t size) {
  return 0xFFFFFFFFU >> (8U * (4U - size));
}
/// Drives count in units of their own, in which a value becomes a whole number: within two percent it is the
/// same one.
constexpr bool is_near(std::uint32_t found, std::uint32_t value) {
  const std::uint64_t off = found > value ? found - value : value - found;
  return 50 * off <= value;
}

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
  drive_heartbeat_ms_ = 0;
  fault_may_coast_ = false;
  range_begin_ = 0;
  place_.reset();
  error_code_ = 0;
  kept_pdos_ = 0;
  cob_id_ = {};
  absent_.clear();
  has_period_ = true;
  has_no_other_target_ = true;
  begin_step(script);
}

std::optional<Frame> SetupRunner::poll(const SetupScript& script, std::int64_t now_ns) {
  const bool is_working = state_ == reading || state_ == writing || state_ == verifying;
  if (is_working && client_.state() == SdoState::done) answered(script);
  if (is_working && client_.state() == SdoState::failed) has_failed(script, script[step_]);
  return client_.poll(now_ns);
}

bool SetupRunner::is_left_out(const SetupScript& script) {
  const SetupStep& step = script[step_];
  if (step.action != SetupAction::compare) return step.unless_so && is_so_;
  const bool is_first = step_ == 0 || script[step_ - 1].action != SetupAction::compare;
  if (is_first) is_so_ = true;
  return !is_so_;
}

void SetupRunner::begin_step(const SetupScript& script) {
  for (;; ++step_) {
    while (step_ != script.size() && is_left_out(script)) ++step_;
    if (step_ == script.size()) {
      state_ = next_state(state_, SetupEvent::finished);
      return;
    }
    const SetupStep& step = script[step_];
    found_.reset();
    abort_code_ = 0;
    if (!reads_first(step.action)) return write(step);
    state_ = next_state(state_, SetupEvent::begin_reading);
    const bool is_known = step.object == cob_id_.object && cob_id_.object.index != 0;
    if (!is_known) {
      client_.begin_upload(step.object, step.size);
      return;
    }
    found_ = cob_id_.value;
    if (!has_read(step)) return;
  }
}

void SetupRunner::note_cob_id(const SetupStep& step) {
  const unsigned group = step.object.index & 0xFE00U;
  const bool is_cob_id = (group == 0x1400 || group == 0x1800) && step.object.sub == pdo_sub_cob_id;
  if (is_cob_id) cob_id_ = {.object = step.object, .value = *found_};
}

void SetupRunner::next_step(const SetupScript& script) {
  ++step_;
  begin_step(script);
}

/// What a step is to write, once it has read what it had to know.
std::uint32_t SetupRunner::value_for(const SetupStep& step) const {
  switch (step.action) {
    case SetupAction::switch_off:
      return found_.value_or(0) | cob_id_is_invalid;
    case SetupAction::switch_on:
      return step.value | (found_.value_or(0) & cob_id_without_rtr);
    case SetupAction::sync_watch: {
      // A drive that has no 60C2 has nothing else that tells it how long a tick is.
      const bool is_needless = host_timeout_ms_ != 0 && has_period_;
      return is_needless ? 0 : step.value;
    }
    case SetupAction::limit:
    case SetupAction::try_limit:
      return limit_for(step);
    default:
      return step.value;
  }
}

/// Limits that the axis stands outside of reach to where it stands, and to its window: whatever it is told
/// while it is held there, and on its way in, is legal.
std::uint32_t SetupRunner::limit_for(const SetupStep& step) const {
  const std::int64_t limit = static_cast<std::int32_t>(step.value);
  if (!place_) return step.value;
  const std::int64_t window = step.mask;
  const std::int64_t reached = step.object.sub == 1
                                   ? std::max<std::int64_t>(std::min(limit, *place_ - window),
                                                            std::numeric_limits<std::int32_t>::min())
                                   : std::min<std::int64_t>(std::max(limit, *place_ + window),
                                                            std::numeric_limits<std::int32_t>::max());
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(reached));
}

void SetupRunner::write(const SetupStep& step) {
  state_ = next_state(state_, SetupEvent::begin_writing);
  written_ = value_for(step);
  client_.begin_download(step.object, step.size, written_);
}

void SetupRunner::read_back(const SetupStep& step) {
  state_ = next_state(state_, SetupEvent::written);
  client_.begin_upload(step.object, step.size);
}

void SetupRunner::answered(const SetupScript& script) {
  const SetupStep& step = script[step_];
  if (state_ == writing) return read_back(step);
  found_ = client_.value();
  note_cob_id(step);
  if (state_ == reading) {
    if (has_read(step)) next_step(script);
    return;
  }
  if (is_right(step)) return next_step(script);
  if (!step.may_stay) return refuse(step, step.finding);
  kept_pdos_ |= bit_of(step.object.index);
  next_step(script);
}

/// Whether a step has ended with what was read; if not, it is refused, or writes.
bool SetupRunner::has_read(const SetupStep& step) {
  const bool is_equal = (*found_ & step.mask) == step.value;
  bool has_ended = true;
  switch (step.action) {
    case SetupAction::expect:
      has_ended = is_equal;
      break;
    case SetupAction::expect_no_range:
      has_ended = is_no_range(step);
      break;
    case SetupAction::forbid:
      has_ended = !is_equal;
      break;
    case SetupAction::look:
      has_no_other_target_ = has_no_other_target_ && *found_ == 0;
      break;
    case SetupAction::note_error:
      if (error_code_ == 0) error_code_ = static_cast<std::uint16_t>(*found_);
      break;
    case SetupAction::note_place:
      place_ = static_cast<std::int32_t>(*found_);
      break;
    case SetupAction::compare:
      is_so_ = is_equal;
      break;
    default:
      has_ended = *found_ == (value_for(step) & mask_of(step.size));
      if (!has_ended) write(step);
      return has_ended;
  }
  if (!has_ended) refuse(step, step.finding);
  return has_ended;
}

/// Whether the drive has the right value in an object, after it was written or has refused that.
bool SetupRunner::is_right(const SetupStep& step) {
  switch (step.action) {
    case SetupAction::write_near:
      return is_near(*found_, step.value);
    case SetupAction::sync_watch:
      return *found_ == step.value || *found_ == 0;
    case SetupAction::write_code:
      return is_right_code(step);
    case SetupAction::try_write:
    case SetupAction::try_limit:
      return true;
    case SetupAction::watchdog:
      return note_watchdog(step) ||
             (step.object.index & 0xFFFCU) == 0x1400;  // the heartbeat of the host is watched, too
    default:
      return *found_ == (written_ & mask_of(step.size));
  }
}

/// The begin may be either; the end must go with it: a range from 0 to the last count has an edge at 0.
bool SetupRunner::is_no_range(const SetupStep& step) {
  if (*found_ != step.value && *found_ != 0) return false;
  if (step.object.sub == 1) {
    range_begin_ = *found_;
    return true;
  }
  return (*found_ == 0) == (range_begin_ == 0);
}

bool SetupRunner::is_right_code(const SetupStep& step) const {
  constexpr std::uint32_t fault = 1;
  if (step.object.index == host_loss_index && *found_ == fault && fault_may_coast_) return false;
  return *found_ < 32 && ((step.mask >> *found_) & 1) != 0;
}

bool SetupRunner::can_do_without(const SetupStep& step) const {
  // Without an exponent the period is in milliseconds.
  const bool has_period_without_exponent =
      step.object == interpolation_exponent && abort_code_ == abort_no_sub_index && has_period_;
  constexpr std::uint32_t milliseconds = 0xFD;
  return step.may_be_absent && (!has_period_without_exponent || step.value == milliseconds);
}

void SetupRunner::has_failed(const SetupScript& script, const SetupStep& step) {
  abort_code_ = client_.abort_code();
  const bool is_silent = client_.has_given_up() && abort_code_ == abort_timeout;
  if (is_silent) return refuse(step, DriveFinding::sdo_silent);
  if (step.action == SetupAction::compare) {
    is_so_ = false;
    return next_step(script);
  }
  if (step.action == SetupAction::note_error) return next_step(script);
  const bool is_there = abort_code_ != abort_no_object && abort_code_ != abort_no_sub_index;
  if (step.action == SetupAction::look) {
    if (is_there) has_no_other_target_ = false;
    return next_step(script);
  }
  const bool has_none = !is_there;
  if (has_none && can_do_without(step)) return is_absent(script, step);
  if (has_none && step.finding == DriveFinding::watchdog_unset) return refuse(step, step.finding);
  if (has_none && step.object.index == host_loss_index) return refuse(step, DriveFinding::host_loss_unsaid);
  if (has_none && step.object.index == window_index) return refuse(step, DriveFinding::window_unsaid);
  const bool is_refused = !has_none && !client_.has_given_up();
  const bool can_write = step.action >= SetupAction::write;
  const bool needs_old = step.action == SetupAction::switch_off || step.action == SetupAction::switch_on;
  if (state_ == reading && is_refused && can_write && !needs_old) return write(step);
  // A drive may refuse to be written and have what is wanted: set by somebody, or so from the factory.
  if (state_ == writing && is_refused) return read_back(step);
  const bool is_hidden = abort_code_ == abort_write_only || abort_code_ == abort_unsupported_access;
  if (state_ == verifying && is_hidden && step.may_be_hidden) return next_step(script);
  refuse(step, DriveFinding::sdo_failed);
}

void SetupRunner::is_absent(const SetupScript& script, const SetupStep& step) {
  const bool may_coast = (step.mask & 1) != 0;
  if (step.object.index == fault_reaction_index) fault_may_coast_ = !may_coast;
  if (step.object == interpolation_time) has_period_ = false;
  if (step.object == heartbeat_consumer && setpoint_timeout_ms_ == 0) return refuse(step, step.finding);
  const bool is_noted = !absent_.empty() && absent_[absent_.size() - 1] == step.object.index;
  // There is room for every index of a script.
  if (!is_noted) static_cast<void>(absent_.push_back(step.object.index));
  next_step(script);
}

void SetupRunner::refuse(const SetupStep& step, DriveFinding finding) {
  const bool has_refused_value = abort_code_ != 0 && finding == DriveFinding::read_back_differs;
  refusal_ = {.finding = has_refused_value ? DriveFinding::sdo_failed : finding,
              .object = step.object,
              .expected = state_ == reading ? step.value : written_,
              .found = found_,
              .abort_code = abort_code_};
  state_ = next_state(state_, SetupEvent::differs);
}

/// A drive may round a time up; one of more than twice what was asked is as good as none.
bool SetupRunner::note_watchdog(const SetupStep& step) {
  if (step.object == life_factor) return note_life_time(step);
  const auto asked_ms = static_cast<std::uint16_t>(step.value);
  const auto found_ms = static_cast<std::uint16_t>(*found_);
  const bool is_same_node = (*found_ >> 16) == (step.value >> 16);
  if (!is_same_node || found_ms == 0 || found_ms > 2 * asked_ms) return false;
  if (step.object == heartbeat_consumer) {
    host_timeout_ms_ = found_ms;
  } else if (step.object == heartbeat_producer || step.object == guard_time) {
    drive_heartbeat_ms_ = found_ms;
  } else {
    setpoint_timeout_ms_ = found_ms;
  }
  return true;
}

/// The life time of a guarded drive is in two objects, of which it may round the first.
bool SetupRunner::note_life_time(const SetupStep& step) {
  const std::uint32_t life_ms = *found_ * drive_heartbeat_ms_;
  if (*found_ != step.value || life_ms > 0xFFFF) return false;
  host_timeout_ms_ = static_cast<std::uint16_t>(life_ms);
  return true;
}

}  // namespace inbetween::can
