#include "host_tools/cli/held_keys.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <stdexcept>
#include <system_error>

namespace inbetween {
namespace {

/// Several times before the loop takes silence for a key that is let go (jog_silence_s).
constexpr std::int64_t ns_between_tellings = 30'000'000;

const char* remedy_for(int error) {
  if (error == EBUSY) return "another program has it for itself; end that";
  if (error == EACCES) return "be root, or a member of the group input";
  return "name one of /dev/input/by-id";
}

[[noreturn]] void refuse(const std::string& path, const std::error_code& error) {
  throw std::runtime_error(fmt::format("{}: error: the device cannot be used: {}; {}", path, error.message(),
                                       remedy_for(error.value())));
}

EventDevice opened(const std::string& path) try {
  return EventDevice(path);
} catch (const std::system_error& error) {
  refuse(path, error.code());
}

TransportKey key_of(HandEvent event) {
  switch (event) {
    case HandEvent::forward:
      return TransportKey::hold_forward;
    case HandEvent::backward:
      return TransportKey::hold_backward;
    case HandEvent::detent_forward:
      return TransportKey::detent_forward;
    case HandEvent::detent_backward:
      return TransportKey::detent_backward;
    case HandEvent::let_go:
      break;
  }
  return TransportKey::let_go;
}

}  // namespace

HeldKeys::HeldKeys(const std::string& path) : device_(opened(path)) {
  try {
    if (device_.has_alone()) return;
    fmt::print(stderr, "let go of all keys of {}\n", path);
    while (!device_.has_alone()) {
      device_.wait();
      static_cast<void>(device_.events());
    }
  } catch (const std::system_error& error) {
    refuse(path, error.code());
  }
}

std::vector<TransportKey> HeldKeys::read(std::int64_t now_ns) {
  std::vector<TransportKey> keys;
  for (const HandEvent event : device_.events()) {
    keys.push_back(key_of(event));
    if (event == HandEvent::detent_forward || event == HandEvent::detent_backward) continue;
    is_held_ = event != HandEvent::let_go;
    told_ns_ = now_ns;
  }
  if (is_held_ && now_ns - told_ns_ >= ns_between_tellings) {
    told_ns_ = now_ns;
    keys.push_back(TransportKey::still_held);
  }
  if (device_.is_gone() && !has_told_gone_) {
    has_told_gone_ = true;
    keys.push_back(TransportKey::device_gone);
  }
  return keys;
}

}  // namespace inbetween
