#include "host_tools/loop/transport_keys.hpp"

#include <algorithm>
#include <array>
#include <charconv>

namespace inbetween {
namespace {

constexpr char escape = '\x1b';

struct ByteKey {
  char byte;
  TransportKey key;
};
constexpr std::array<ByteKey, 28> byte_keys{{
    {'1', TransportKey::size_1},       {'2', TransportKey::size_2},
    {'3', TransportKey::size_3},       {'4', TransportKey::size_4},
    {'5', TransportKey::size_5},       {'6', TransportKey::digit_6},
    {'7', TransportKey::digit_7},      {'8', TransportKey::digit_8},
    {'9', TransportKey::digit_9},      {'0', TransportKey::digit_0},
    {'\x7f', TransportKey::erase},     {'\b', TransportKey::erase},
    {'g', TransportKey::go_to_frame},  {'k', TransportKey::go_to_key},
    {' ', TransportKey::pause},        {'r', TransportKey::reverse},
    {'+', TransportKey::faster},       {'-', TransportKey::slower},
    {'a', TransportKey::acknowledge},  {'e', TransportKey::expose},
    {'\r', TransportKey::start},       {'\n', TransportKey::start},
    {'n', TransportKey::teach_next},   {'p', TransportKey::teach_previous},
    {'i', TransportKey::teach_insert}, {'t', TransportKey::teach_replace},
    {'u', TransportKey::teach_undo},   {'q', TransportKey::quit},
}};

std::optional<TransportKey> key_of(char byte) {
  const auto found = std::ranges::find(byte_keys, byte, &ByteKey::byte);
  return found == byte_keys.end() ? std::nullopt : std::optional(found->key);
}

/// A mouse as terminals without SGR report it: three more bytes, which would be keys elsewhere.
constexpr std::string_view old_mouse = "\x1b[M";

/// The length of a control sequence (ECMA-48: parameters, then a letter or ~) or of one of SS3, with which
/// the text begins; 0 where it begins with none.
std::size_t sequence_length(std::string_view bytes) {
  if (bytes.starts_with(old_mouse)) return std::min(bytes.size(), old_mouse.size() + 3);
  if (bytes.size() < 3 || bytes[0] != escape) return 0;
  if (bytes[1] == 'O') return 3;
  if (bytes[1] != '[') return 0;
  std::size_t last = 2;
  while (last < bytes.size() && bytes[last] >= ' ' && bytes[last] <= '?') ++last;
  return last < bytes.size() ? last + 1 : 0;
}

/// The numbers of a control sequence, "1;129:2": what a key is, the modifiers with it, and what became of it.
struct KeyNumbers {
  enum class Event : int { press = 1, repeat, release };

  int code = 1;
  int modifiers = 1;
  Event event = Event::press;

  /// One of Shift, Alt, Ctrl, Super, Hyper, Meta; Caps Lock and Num Lock are none.
  [[nodiscard]] bool has_modifier() const { return ((modifiers - 1) & 0x3F) != 0; }
  [[nodiscard]] bool has_shift() const { return ((modifiers - 1) & 0x3F) == 1; }
  [[nodiscard]] bool has_control() const { return ((modifiers - 1) & 0x3F) == 4; }
};

/// The first number of a text; `otherwise` where it begins with none.
int number_at(std::string_view text, int otherwise) {
  int number = otherwise;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

/// Gives what stands behind the first of these letters; "" where there is none.
std::string_view behind(std::string_view text, char letter) {
  const std::size_t at = text.find(letter);
  return at == std::string_view::npos ? std::string_view() : text.substr(at + 1);
}

KeyNumbers numbers_of(std::string_view text) {
  const std::string_view with = behind(text, ';');
  const std::string_view event = behind(with.substr(0, with.find(';')), ':');
  return {.code = number_at(text, 1),
          .modifiers = number_at(with, 1),
          .event = static_cast<KeyNumbers::Event>(number_at(event, 1))};
}

/// 1 forward, -1 backward, 0 for another key.
int direction_of(const KeyNumbers& key, char letter) {
  constexpr int keypad_minus = 57412, keypad_plus = 57413;
  if (letter == 'u' && key.code == '=' && key.has_shift()) return 1;  // + on many keyboards
  if (key.has_modifier()) return 0;
  if (letter == 'C') return 1;
  if (letter == 'D') return -1;
  if (letter != 'u') return 0;
  if (key.code == '+' || key.code == keypad_plus) return 1;
  return key.code == '-' || key.code == keypad_minus ? -1 : 0;
}

/// A key that is let go may have lost its Shift before.
bool may_have_direction(const KeyNumbers& key, char letter) {
  return direction_of({.code = key.code}, letter) != 0 || (letter == 'u' && key.code == '=');
}

std::optional<TransportKey> key_of_code(const KeyNumbers& key) {
  if (key.has_control()) return key.code == 'c' ? std::optional(TransportKey::quit) : std::nullopt;
  if (key.has_modifier() || key.code <= 0 || key.code > 127) return std::nullopt;
  return key.code == escape ? TransportKey::stop : key_of(static_cast<char>(key.code));
}

/// Takes what stands between the beginning of a control sequence and its last letter, and that letter.
std::optional<TransportKey> key_of_sequence(std::string_view numbers, char letter) {
  if (letter == 'u' && numbers.starts_with('?')) {
    constexpr int event_types = 2;
    const bool tells = (number_at(numbers.substr(1), 0) & event_types) != 0;
    return tells ? std::optional(TransportKey::tells_releases) : std::nullopt;
  }
  // A mouse that reports as xterm does (SGR): buttons 64 and 65 are its wheel.
  if (letter == 'M' && numbers.starts_with("<64;")) return TransportKey::detent_forward;
  if (letter == 'M' && numbers.starts_with("<65;")) return TransportKey::detent_backward;
  const KeyNumbers key = numbers_of(numbers);
  if (key.event == KeyNumbers::Event::release) {
    return may_have_direction(key, letter) ? std::optional(TransportKey::let_go) : std::nullopt;
  }
  if (const int direction = direction_of(key, letter); direction != 0) {
    if (key.event == KeyNumbers::Event::repeat)
      return direction > 0 ? TransportKey::repeat_forward : TransportKey::repeat_backward;
    return direction > 0 ? TransportKey::step_forward : TransportKey::step_backward;
  }
  if (key.event != KeyNumbers::Event::press) return std::nullopt;
  if (letter == 'u') return key_of_code(key);
  if (key.has_modifier()) return std::nullopt;
  if (letter == 'A') return TransportKey::previous_axis;
  if (letter == 'B') return TransportKey::next_axis;
  const bool is_home = letter == 'H' || (letter == '~' && (key.code == 1 || key.code == 7));
  return is_home ? std::optional(TransportKey::home) : std::nullopt;
}

}  // namespace

int direction_of(TransportKey key) {
  switch (key) {
    case TransportKey::step_forward:
    case TransportKey::repeat_forward:
    case TransportKey::hold_forward:
    case TransportKey::detent_forward:
      return 1;
    case TransportKey::step_backward:
    case TransportKey::repeat_backward:
    case TransportKey::hold_backward:
    case TransportKey::detent_backward:
      return -1;
    default:
      return 0;
  }
}

void TransportKeys::feed(std::string_view bytes) {
  while (!bytes.empty()) {
    if (const std::size_t length = sequence_length(bytes); length > 0) {
      const std::optional<TransportKey> key =
          bytes.starts_with(old_mouse) ? std::nullopt
                                       : key_of_sequence(bytes.substr(2, length - 3), bytes[length - 1]);
      if (key) keys_.push_back(*key);
      bytes.remove_prefix(length);
      continue;
    }
    if (bytes[0] == escape) {
      keys_.push_back(TransportKey::stop);
    } else if (const std::optional<TransportKey> key = key_of(bytes[0])) {
      keys_.push_back(*key);
    }
    bytes.remove_prefix(1);
  }
}

std::optional<TransportKey> TransportKeys::next() {
  if (keys_.empty()) return std::nullopt;
  const TransportKey key = keys_.front();
  keys_.pop_front();
  tells_releases_ = tells_releases_ || key == TransportKey::tells_releases;
  return key;
}

const char* name_of(TransportKey key) {
  switch (key) {
    case TransportKey::pause:
      return "space";
    case TransportKey::step_forward:
      return "right";
    case TransportKey::step_backward:
      return "left";
    case TransportKey::home:
      return "Home";
    case TransportKey::reverse:
      return "r";
    case TransportKey::faster:
      return "+";
    case TransportKey::slower:
      return "-";
    case TransportKey::stop:
      return "Esc";
    case TransportKey::acknowledge:
      return "a";
    case TransportKey::start:
      return "Enter";
    case TransportKey::expose:
      return "e";
    case TransportKey::size_1:
      return "1";
    case TransportKey::size_2:
      return "2";
    case TransportKey::size_3:
      return "3";
    case TransportKey::size_4:
      return "4";
    case TransportKey::size_5:
      return "5";
    case TransportKey::digit_0:
      return "0";
    case TransportKey::digit_6:
      return "6";
    case TransportKey::digit_7:
      return "7";
    case TransportKey::digit_8:
      return "8";
    case TransportKey::digit_9:
      return "9";
    case TransportKey::erase:
      return "Backspace";
    case TransportKey::go_to_frame:
      return "g";
    case TransportKey::go_to_key:
      return "k";
    case TransportKey::quit:
      return "q";
    case TransportKey::hold_forward:
    case TransportKey::repeat_forward:
      return "right, held";
    case TransportKey::hold_backward:
    case TransportKey::repeat_backward:
      return "left, held";
    case TransportKey::let_go:
      return "let go";
    case TransportKey::detent_forward:
      return "wheel forward";
    case TransportKey::detent_backward:
      return "wheel backward";
    default:
      return "";
  }
}

}  // namespace inbetween
