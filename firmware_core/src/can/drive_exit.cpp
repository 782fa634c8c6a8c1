#include "inbetween/can/drive_exit.hpp"

#include <algorithm>
#include <array>

#include "inbetween/can/pdo.hpp"

namespace inbetween::can {
namespace {

using enum ExitState;

constexpr std::array<std::array<ExitState, exit_events>, exit_states> table{{
    // hush, ask, release, all_released, refused
    {silent, asking, releasing, silent, silent},      // silent
    {silent, asking, releasing, asking, failed},      // asking
    {silent, asking, releasing, released, failed},    // releasing
    {silent, asking, releasing, released, released},  // released
    {silent, failed, releasing, failed, failed},      // failed
}};

struct Release {
  ObjectAddress object;
  std::uint8_t size;
};
/// Setpoints (1400:5), SYNC (1006) and the host's heartbeat (1016) may cease after that. The drive's own
/// heartbeat (1017) is the last: a drive that goes on to send to a bus on which nobody listens any more
/// becomes error-passive and reports 8120.
using Releases = std::array<Release, 4>;
constexpr Releases releases{{{{.index = 0x1400, .sub = pdo_sub_event_timer}, 2},
                             {{.index = 0x1006}, 4},
                             {{.index = 0x1016, .sub = 1}, 4},
                             {{.index = 0x1017}, 2}}};
/// A guarded drive watches the host's questions (100D, 100C).
constexpr Releases guarded_releases{{{{.index = 0x1400, .sub = pdo_sub_event_timer}, 2},
                                     {{.index = 0x1006}, 4},
                                     {{.index = 0x100D}, 1},
                                     {{.index = 0x100C}, 2}}};

ObjectAddress object_of(const Release& release, std::uint8_t rpdo) {
  ObjectAddress object = release.object;
  if (object.sub == pdo_sub_event_timer) object.index = static_cast<std::uint16_t>(object.index + rpdo - 1);
  return object;
}

enum Question : std::size_t { statusword, position, controlword_order, questions };

bool is_absent(std::uint32_t abort_code) {
  return abort_code == abort_no_object || abort_code == abort_no_sub_index;
}

}  // namespace

ExitState next_state(ExitState state, ExitEvent event) {
  return table[static_cast<std::size_t>(state)][static_cast<std::size_t>(event)];
}

void DriveExit::release(std::span<const std::uint16_t> absent, std::uint8_t rpdo) {
  rpdo_ = rpdo;
  absent_ = 0;
  const Releases& all = is_guarded_ ? guarded_releases : releases;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool is_absent = std::ranges::find(absent, object_of(all[i], rpdo).index) != absent.end();
    if (is_absent) absent_ |= static_cast<std::uint8_t>(1U << i);
  }
  apply(ExitEvent::release);
}

bool DriveExit::is_absent_here(std::size_t step) const {
  return step < releases.size() && ((absent_ >> step) & 1U) != 0;
}

void DriveExit::apply(ExitEvent event) {
  const ExitState before = state_;
  state_ = next_state(state_, event);
  if (state_ == before) return;
  client_.reset();
  step_ = 0;
  is_begun_ = false;
}

std::optional<DriveFeedback> DriveExit::take_feedback() {
  if (!has_told_) return {};
  has_told_ = false;
  return told_;
}

std::optional<Frame> DriveExit::poll(std::optional<std::uint16_t> controlword, std::int64_t now_ns) {
  const bool has_ended = client_.state() == SdoState::done || client_.state() == SdoState::failed;
  if (is_begun_ && has_ended) has_answered();
  if (!is_begun_ && state_ == asking) begin_question(controlword);
  if (!is_begun_ && state_ == releasing) begin_release();
  return client_.poll(now_ns);
}

/// A drive that does not take its controlword by SDO tells so, and may go off by itself: its state decides.
void DriveExit::has_answered() {
  is_begun_ = false;
  const bool has_failed = client_.state() == SdoState::failed;
  if (state_ == releasing) {
    if (has_failed && !is_absent(client_.abort_code())) return apply(ExitEvent::refused);
    ++step_;
    return;
  }
  const bool must_answer = step_ != controlword_order || client_.abort_code() == abort_timeout;
  if (has_failed && must_answer) return apply(ExitEvent::refused);
  if (step_ == statusword) told_.statusword = static_cast<std::uint16_t>(client_.value());
  if (step_ == position) told_.actual = static_cast<std::int32_t>(client_.value());
  has_told_ = has_told_ || step_ == position;
  step_ = (step_ + 1) % questions;
}

void DriveExit::begin_question(std::optional<std::uint16_t> controlword) {
  if (step_ == controlword_order && !controlword) step_ = statusword;
  is_begun_ = true;
  if (step_ == statusword) {
    client_.begin_upload({.index = 0x6041}, 2);
  } else if (step_ == position) {
    client_.begin_upload({.index = 0x6064}, 4);
  } else {
    client_.begin_download({.index = 0x6040}, 2, *controlword);
  }
}

void DriveExit::begin_release() {
  while (is_absent_here(step_)) ++step_;
  if (step_ == releases.size()) return apply(ExitEvent::all_released);
  is_begun_ = true;
  const Release& release = (is_guarded_ ? guarded_releases : releases)[step_];
  client_.begin_download(object_of(release, rpdo_), release.size, 0);
}

}  // namespace inbetween::can
