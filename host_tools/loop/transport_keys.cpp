#include "host_tools/loop/transport_keys.hpp"

namespace inbetween {
namespace {

constexpr char escape = '\x1b';

std::optional<TransportKey> key_of(char byte) {
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
    case 'q':
      return TransportKey::quit;
    default:
      return std::nullopt;
  }
}

}  // namespace

void TransportKeys::feed(std::string_view bytes) {
  while (!bytes.empty()) {
    const bool is_sequence = bytes.size() >= 3 && bytes[0] == escape && (bytes[1] == '[' || bytes[1] == 'O');
    if (is_sequence) {
      if (bytes[2] == 'A') keys_.push_back(TransportKey::previous_axis);
      if (bytes[2] == 'B') keys_.push_back(TransportKey::next_axis);
      if (bytes[2] == 'C') keys_.push_back(TransportKey::step_forward);
      if (bytes[2] == 'D') keys_.push_back(TransportKey::step_backward);
      bytes.remove_prefix(3);
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
