#include "host_tools/loop/transport_keys.hpp"

namespace inbetween {
namespace {

constexpr char escape = '\x1b';

std::optional<TransportKey> key_of(char byte) {
  if (byte >= '1' && byte <= '5') {
    return static_cast<TransportKey>(static_cast<int>(TransportKey::size_1) + (byte - '1'));
  }
  switch (byte) {
    case ' ':
      return TransportKey::pause;
    case 'r':
      return TransportKey::reverse;
    case '+':
      return TransportKey::faster;
    case '-':
      return TransportKey::slower;
    case 'a':
      return TransportKey::acknowledge;
    case '\r':
    case '\n':
      return TransportKey::start;
    case 'e':
      return TransportKey::expose;
    case 'n':
      return TransportKey::teach_next;
    case 'p':
      return TransportKey::teach_previous;
    case 'i':
      return TransportKey::teach_insert;
    case 't':
      return TransportKey::teach_replace;
    case 'u':
      return TransportKey::teach_undo;
    case 'q':
      return TransportKey::quit;
    default:
      return std::nullopt;
  }
}

/// The length of a control sequence (ECMA-48: parameters, then a letter or ~) or of one of SS3, with which
/// the text begins; 0 where it begins with none.
std::size_t sequence_length(std::string_view bytes) {
  if (bytes.size() < 3 || bytes[0] != escape) return 0;
  if (bytes[1] == 'O') return 3;
  if (bytes[1] != '[') return 0;
  std::size_t last = 2;
  while (last < bytes.size() && bytes[last] >= ' ' && bytes[last] <= '?') ++last;
  return last < bytes.size() ? last + 1 : 0;
}

std::optional<TransportKey> key_of_sequence(std::string_view end) {
  if (end == "A") return TransportKey::previous_axis;
  if (end == "B") return TransportKey::next_axis;
  if (end == "C") return TransportKey::step_forward;
  if (end == "D") return TransportKey::step_backward;
  if (end == "H" || end == "1~" || end == "7~") return TransportKey::home;
  return std::nullopt;
}

}  // namespace

void TransportKeys::feed(std::string_view bytes) {
  while (!bytes.empty()) {
    if (const std::size_t length = sequence_length(bytes); length > 0) {
      if (const std::optional<TransportKey> key = key_of_sequence(bytes.substr(2, length - 2))) {
        keys_.push_back(*key);
      }
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
  return key;
}

}  // namespace inbetween
