// A program on a CAN interface that knows nothing of the product: the other side in tests.
#pragma once

#include <linux/can.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace inbetween {

class RawBus {
 public:
  /// Everything on the interface, error frames too. Throws std::system_error.
  explicit RawBus(const std::string& interface);
  ~RawBus();
  RawBus(const RawBus&) = delete;
  RawBus& operator=(const RawBus&) = delete;

  /// Throws std::system_error if the kernel refuses.
  void send(std::uint32_t id_and_flags, const std::vector<std::uint8_t>& data);
  /// The next frame, if one comes within five seconds.
  std::optional<can_frame> next();
  /// The next frame, if it is there already.
  std::optional<can_frame> waiting();

 private:
  std::optional<can_frame> read_within(int milliseconds);
  int socket_;
};

/// Runs a shell command and fails the test if that fails.
void shell(const std::string& command);

}  // namespace inbetween
