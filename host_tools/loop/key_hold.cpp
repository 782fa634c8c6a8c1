#include "host_tools/loop/key_hold.hpp"

#include "inbetween/loop/tick_time.hpp"

namespace inbetween {
namespace {

constexpr std::int64_t of_seconds(double seconds) {
  return static_cast<std::int64_t>(seconds * ns_per_s);
}

/// Repeats that show that a key is held.
constexpr int repeats_of_hold = 2;
/// So many keys may come at once, as on a line that gathers what it carries, beyond one per min_key_repeat_s.
constexpr int keys_at_once = 4;

}  // namespace

bool KeyHold::is_silent(std::int64_t now_ns) const {
  return !last_ns_ || now_ns - *last_ns_ >= of_seconds(key_silence_s);
}

void KeyHold::begin(int direction, std::int64_t now_ns) {
  direction_ = direction;
  first_ns_ = now_ns;
  last_ns_ = now_ns;
  keys_ = 1;
  repeats_ = 0;
  is_refused_ = false;
}

void KeyHold::refuse() {
  is_refused_ = true;
  repeats_ = 0;
  press_ = 0;
}

void KeyHold::count(int direction, std::int64_t now_ns) {
  const std::int64_t gap = now_ns - *last_ns_;
  last_ns_ = now_ns;
  ++keys_;
  const std::int64_t possible = keys_at_once + (now_ns - first_ns_) / of_seconds(min_key_repeat_s);
  if (direction != direction_ || keys_ > possible) return refuse();
  const bool is_at_rate = gap >= of_seconds(min_key_repeat_s) && gap <= of_seconds(max_key_repeat_s);
  if (is_at_rate && !is_refused_ && repeats_ < repeats_of_hold) ++repeats_;
}

void KeyHold::press(int direction, std::int64_t now_ns) {
  if (!tells_releases_ && !is_silent(now_ns)) {
    press_ = 0;  // it was a repeat, and so was the one before
    return count(direction, now_ns);
  }
  begin(direction, now_ns);
  press_ = direction;
  pressed_ns_ = now_ns;
}

void KeyHold::repeat(int direction, std::int64_t now_ns) {
  if (!tells_releases_) return press(direction, now_ns);
  if (is_refused_ || keys_ == 0) return;
  const bool is_first = keys_ == 1;  // after the delay of the keyboard
  if (direction != direction_ || (!is_first && is_silent(now_ns))) return refuse();
  if (is_first) first_ns_ = now_ns;
  count(direction, now_ns);
}

void KeyHold::release() {
  keys_ = 0;
  repeats_ = 0;
}

void KeyHold::hold(int direction, std::int64_t now_ns) {
  begin(direction, now_ns);
  repeats_ = repeats_of_hold;
}

void KeyHold::hear(std::int64_t now_ns) {
  if (repeats_ == repeats_of_hold) last_ns_ = now_ns;
}

void KeyHold::forget() {
  if (last_ns_) refuse();
}

int KeyHold::take_press(std::int64_t now_ns) {
  if (press_ == 0 || (!tells_releases_ && !is_silent(now_ns))) return 0;
  const int direction = press_;
  press_ = 0;
  return direction;
}

int KeyHold::held(std::int64_t now_ns) {
  if (repeats_ < repeats_of_hold) return 0;
  if (!is_silent(now_ns)) return direction_;
  refuse();
  return 0;
}

}  // namespace inbetween
