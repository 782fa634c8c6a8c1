#include "drivers/linux/event_device.hpp"

#include <fcntl.h>
#include <linux/input.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <string_view>
#include <system_error>
#include <utility>

namespace inbetween {
namespace {

struct KeyBit {
  std::uint16_t code;
  bool forward;
};
constexpr std::array direction_keys{KeyBit{KEY_RIGHT, true},      KeyBit{KEY_LEFT, false},
                                    KeyBit{KEY_KPPLUS, true},     KeyBit{KEY_KPMINUS, false},
                                    KeyBit{BTN_DPAD_RIGHT, true}, KeyBit{BTN_DPAD_LEFT, false}};
// Behind the bits of the keys those of a cross that is an axis.
constexpr unsigned cross_forward = 1U << direction_keys.size();
constexpr unsigned cross_backward = cross_forward << 1U;

constexpr std::string_view up = "\x1b[A", down = "\x1b[B";
struct TypedKey {
  std::uint16_t code;
  std::string_view text;
};
constexpr std::array typed_keys{
    TypedKey{KEY_UP, up},          TypedKey{KEY_DOWN, down},  TypedKey{BTN_DPAD_UP, up},
    TypedKey{BTN_DPAD_DOWN, down}, TypedKey{KEY_ESC, "\x1b"}, TypedKey{KEY_ENTER, "\r"},
    TypedKey{KEY_KPENTER, "\r"},   TypedKey{KEY_SPACE, " "},  TypedKey{KEY_1, "1"},
    TypedKey{KEY_2, "2"},          TypedKey{KEY_3, "3"},      TypedKey{KEY_4, "4"},
    TypedKey{KEY_5, "5"},          TypedKey{KEY_A, "a"},      TypedKey{KEY_I, "i"},
    TypedKey{KEY_N, "n"},          TypedKey{KEY_P, "p"},      TypedKey{KEY_Q, "q"},
    TypedKey{KEY_T, "t"},          TypedKey{KEY_U, "u"}};

constexpr std::int64_t units_of_detent = 120;  // of REL_WHEEL_HI_RES

constexpr unsigned bits_of(bool forward) {
  unsigned bits = forward ? cross_forward : cross_backward;
  for (std::size_t i = 0; i < direction_keys.size(); ++i) {
    if (direction_keys[i].forward == forward) bits |= 1U << i;
  }
  return bits;
}

using KeyStates = std::array<std::uint8_t, KEY_CNT / 8>;

}  // namespace

EventDevice::EventDevice(const std::string& path)
    : path_(path), file_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
  if (file_ < 0) throw std::system_error(errno, std::generic_category(), path);
  int version = 0;
  is_evdev_ = ::ioctl(file_, EVIOCGVERSION, &version) == 0;
  has_alone_ = !is_evdev_;
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

bool EventDevice::has_alone() {
  if (has_alone_ || is_gone()) return true;
  KeyStates state{};
  if (::ioctl(file_, EVIOCGKEY(state.size()), state.data()) >= 0 &&
      std::ranges::any_of(state, [](std::uint8_t byte) { return byte != 0; })) {
    return false;
  }
  if (::ioctl(file_, EVIOCGRAB, 1) != 0 && errno != ENODEV) {
    throw std::system_error(errno, std::generic_category(), path_);
  }
  return has_alone_ = true;
}

void EventDevice::wait() const {
  pollfd device{.fd = file_, .events = POLLIN, .revents = 0};
  ::poll(&device, 1, -1);
}

/// A pipe does not answer: what it holds is what it has told.
void EventDevice::ask_what_is_held() {
  KeyStates state{};
  if (::ioctl(file_, EVIOCGKEY(state.size()), state.data()) < 0) return;
  held_ = 0;
  const auto is_held = [&](std::uint16_t code) { return (state[code / 8U] >> (code % 8U) & 1U) != 0; };
  for (std::size_t i = 0; i < direction_keys.size(); ++i) {
    if (is_held(direction_keys[i].code)) held_ |= 1U << i;
  }
  has_control_ = is_held(KEY_LEFTCTRL) || is_held(KEY_RIGHTCTRL);
  input_absinfo cross{};
  if (::ioctl(file_, EVIOCGABS(ABS_HAT0X), &cross) < 0 || cross.value == 0) return;
  held_ |= cross.value > 0 ? cross_forward : cross_backward;
}

void EventDevice::settle(std::vector<HandEvent>& events) {
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
  if (now != direction_) {
    events.push_back(now > 0 ? HandEvent::forward : now < 0 ? HandEvent::backward : HandEvent::let_go);
  }
  direction_ = now;
}

void EventDevice::take_key(std::uint16_t code, std::int32_t value) {
  for (std::size_t i = 0; i < direction_keys.size(); ++i) {
    if (direction_keys[i].code == code) held_ = value != 0 ? held_ | 1U << i : held_ & ~(1U << i);
  }
  if (code == KEY_LEFTCTRL || code == KEY_RIGHTCTRL) has_control_ = value != 0;
  if (value != 1 || !has_alone_) return;
  if (has_control_) {
    if (code == KEY_C) typed_ += "q";
    return;
  }
  const auto* const typed = std::ranges::find(typed_keys, code, &TypedKey::code);
  if (typed != typed_keys.end()) typed_ += typed->text;
}

void EventDevice::take_report(std::vector<HandEvent>& events) {
  const Turned turned = std::exchange(turned_, {});
  const std::int64_t wheel = turned.is_fine ? turned.fine : turned.wheel * units_of_detent;
  const std::int64_t units = turned.dial * units_of_detent + wheel;
  if (units == 0) return;
  if ((units > 0) != (turned_units_ > 0)) turned_units_ = 0;
  turned_units_ += units;
  const std::int64_t detents = turned_units_ / units_of_detent;
  turned_units_ %= units_of_detent;
  events.insert(events.end(), static_cast<std::size_t>(std::min<std::int64_t>(std::abs(detents), 2)),
                detents > 0 ? HandEvent::detent_forward : HandEvent::detent_backward);
}

/// A wheel of high resolution tells whole detents as well, in the same report: they are not counted twice.
void EventDevice::take(std::uint16_t type, std::uint16_t code, std::int32_t value,
                       std::vector<HandEvent>& events) {
  if (has_lost_) {
    if (type != EV_SYN || code != SYN_REPORT) return;
    has_lost_ = false;
    ask_what_is_held();
    settle(events);
  } else if (type == EV_SYN && code == SYN_DROPPED) {
    has_lost_ = true;
    is_neutral_ = false;
    turned_ = {};
    if (direction_ != 0) events.push_back(HandEvent::let_go);
    direction_ = 0;
  } else if (type == EV_SYN && code == SYN_REPORT) {
    take_report(events);
  } else if (type == EV_KEY) {
    take_key(code, value);
    settle(events);
  } else if (type == EV_ABS && code == ABS_HAT0X) {
    held_ &= ~(cross_forward | cross_backward);
    if (value != 0) held_ |= value > 0 ? cross_forward : cross_backward;
    settle(events);
  } else if (type == EV_ABS && code == ABS_HAT0Y) {
    if (value != 0 && has_alone_) typed_ += value < 0 ? up : down;
  } else if (type == EV_REL) {
    if (code == REL_DIAL) turned_.dial += value;
    if (code == REL_WHEEL) turned_.wheel += value;
    if (code != REL_WHEEL_HI_RES) return;
    turned_.fine += value;
    turned_.is_fine = true;
  }
}

std::vector<HandEvent> EventDevice::events() {
  std::vector<HandEvent> told;
  while (file_ >= 0) {
    std::array<input_event, 64> read;
    const ssize_t count = ::read(file_, read.data(), sizeof(read));
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return told;
    // A device tells whole events only.
    if (count <= 0 || static_cast<std::size_t>(count) % sizeof(input_event) != 0) {
      close();
      held_ = 0;
      settle(told);
      return told;
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(count) / sizeof(input_event); ++i) {
      take(read[i].type, read[i].code, read[i].value, told);
    }
  }
  return told;
}

std::string EventDevice::typed() {
  return std::exchange(typed_, {});
}

}  // namespace inbetween
