#include "host_tools/cli/held_keys.hpp"

namespace inbetween {
namespace {

/// Several times before the loop takes silence for a key that is let go (jog_silence_s).
constexpr std::int64_t ns_between_tellings = 30'000'000;

}  // namespace

std::vector<TransportKey> HeldKeys::read(std::int64_t now_ns) {
  std::vector<TransportKey> keys;
  for (const int direction : device_.changes()) {
    is_held_ = direction != 0;
    told_ns_ = now_ns;
    keys.push_back(direction > 0   ? TransportKey::hold_forward
                   : direction < 0 ? TransportKey::hold_backward
                                   : TransportKey::let_go);
  }
  if (is_held_ && now_ns - told_ns_ >= ns_between_tellings) {
    told_ns_ = now_ns;
    keys.push_back(TransportKey::still_held);
  }
  return keys;
}

}  // namespace inbetween
