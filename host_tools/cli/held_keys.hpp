// The keys and the wheel of a device that tells when a key is let go, for a motion loop.
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
  /// Waits until no key of the device is held, and has it alone from then on. Throws std::runtime_error, one
  /// line that begins with the path, where it cannot be opened or another program has it alone.
  explicit HeldKeys(const std::string& path);
  std::vector<TransportKey> read(std::int64_t now_ns);
  /// What its other keys type into a terminal.
  std::string typed() { return device_.typed(); }

 private:
  EventDevice device_;
  bool is_held_ = false;
  bool has_told_gone_ = false;
  std::int64_t told_ns_ = 0;
};

}  // namespace inbetween
