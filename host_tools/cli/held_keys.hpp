// The keys of a device that tells when they are let go, for a motion loop.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/linux/event_device.hpp"
#include "host_tools/loop/transport_keys.hpp"

namespace inbetween {

/// While a key is held this is told again and again, so that the loop knows that somebody still looks at the
/// device.
class HeldKeys {
 public:
  explicit HeldKeys(const std::string& path) : device_(path) {}
  std::vector<TransportKey> read(std::int64_t now_ns);

 private:
  EventDevice device_;
  bool is_held_ = false;
  std::int64_t told_ns_ = 0;
};

}  // namespace inbetween
