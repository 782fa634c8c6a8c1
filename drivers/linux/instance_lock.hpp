#pragma once

#include <optional>
#include <string>

#include "drivers/refusal.hpp"

namespace inbetween {

/// One program at a time for one thing (a bus): held by a name that the kernel forgets with the process,
/// however it ends. Of a network namespace, as the interfaces are.
class InstanceLock {
 public:
  InstanceLock() = default;
  ~InstanceLock();
  InstanceLock(const InstanceLock&) = delete;
  InstanceLock& operator=(const InstanceLock&) = delete;

  /// `name` of at most 80 bytes, "bus can0"; what people call it may be longer.
  [[nodiscard]] std::optional<Refusal> take(const std::string& name) { return take(name, name); }
  [[nodiscard]] std::optional<Refusal> take(const std::string& name, const std::string& called);

 private:
  int socket_ = -1;
};

}  // namespace inbetween
