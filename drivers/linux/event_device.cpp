#include "drivers/linux/event_device.hpp"

#include <fcntl.h>
#include <linux/input.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <system_error>

namespace inbetween {
namespace {

struct KeyBit {
  std::uint16_t code;
  bool forward;
};
constexpr std::array keys{KeyBit{KEY_RIGHT, true},      KeyBit{KEY_LEFT, false},
                          KeyBit{KEY_KPPLUS, true},     KeyBit{KEY_KPMINUS, false},
                          KeyBit{BTN_DPAD_RIGHT, true}, KeyBit{BTN_DPAD_LEFT, false}};
// Behind the bits of the keys those of a cross that is an axis.
constexpr unsigned cross_forward = 1U << keys.size();
constexpr unsigned cross_backward = cross_forward << 1U;

constexpr unsigned bits_of(bool forward) {
  unsigned bits = forward ? cross_forward : cross_backward;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].forward == forward) bits |= 1U << i;
  }
  return bits;
}

}  // namespace

EventDevice::EventDevice(const std::string& path)
    : file_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
  if (file_ < 0) throw std::system_error(errno, std::generic_category(), path);
  ask_what_is_held();
  is_neutral_ = held_ == 0;
}

EventDevice::~EventDevice() {
  close();
}

void EventDevice::close() {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

/// A pipe does not answer: what it holds is what it has told.
void EventDevice::ask_what_is_held() {
  std::array<std::uint8_t, KEY_CNT / 8> state{};
  if (::ioctl(file_, EVIOCGKEY(state.size()), state.data()) < 0) return;
  held_ = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::uint16_t code = keys[i].code;
    if ((state[code / 8U] >> (code % 8U) & 1U) != 0) held_ |= 1U << i;
  }
  input_absinfo cross{};
  if (::ioctl(file_, EVIOCGABS(ABS_HAT0X), &cross) < 0 || cross.value == 0) return;
  held_ |= cross.value > 0 ? cross_forward : cross_backward;
}

void EventDevice::settle(std::vector<int>& changes) {
  const bool forward = (held_ & bits_of(true)) != 0;
  const bool backward = (held_ & bits_of(false)) != 0;
  int now = 0;
  if (held_ == 0) {
    is_neutral_ = true;
  } else if (direction_ != 0) {
    const bool goes_on = direction_ > 0 ? forward && !backward : backward && !forward;
    now = goes_on ? direction_ : 0;
  } else if (is_neutral_ && forward != backward) {
    now = forward ? 1 : -1;
  }
  if (held_ != 0) is_neutral_ = false;
  if (now != direction_) changes.push_back(now);
  direction_ = now;
}

void EventDevice::take(std::uint16_t type, std::uint16_t code, std::int32_t value,
                       std::vector<int>& changes) {
  if (type == EV_SYN && code == SYN_DROPPED) {
    is_neutral_ = false;
    if (direction_ != 0) changes.push_back(0);
    direction_ = 0;
    ask_what_is_held();
  } else if (type == EV_KEY) {
    for (std::size_t i = 0; i < keys.size(); ++i) {
      if (keys[i].code == code) held_ = value != 0 ? held_ | 1U << i : held_ & ~(1U << i);
    }
  } else if (type == EV_ABS && code == ABS_HAT0X) {
    held_ &= ~(cross_forward | cross_backward);
    if (value != 0) held_ |= value > 0 ? cross_forward : cross_backward;
  } else {
    return;
  }
  settle(changes);
}

std::vector<int> EventDevice::changes() {
  std::vector<int> changes;
  while (file_ >= 0) {
    std::array<input_event, 64> events;
    const ssize_t count = ::read(file_, events.data(), sizeof(events));
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return changes;
    // A device tells whole events only.
    if (count <= 0 || static_cast<std::size_t>(count) % sizeof(input_event) != 0) {
      close();
      held_ = 0;
      settle(changes);
      return changes;
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(count) / sizeof(input_event); ++i) {
      take(events[i].type, events[i].code, events[i].value, changes);
    }
  }
  return changes;
}

}  // namespace inbetween
