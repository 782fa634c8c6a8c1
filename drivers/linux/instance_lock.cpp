#include "drivers/linux/instance_lock.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>

namespace inbetween {

InstanceLock::~InstanceLock() {
  if (socket_ >= 0) close(socket_);
}

std::optional<Refusal> InstanceLock::take(const std::string& name, const std::string& called) {
  // An abstract address: it begins with a zero byte and has no file.
  const std::string address = std::string(1, '\0') + "inbetween " + name;
  sockaddr_un where{};
  where.sun_family = AF_UNIX;
  if (address.size() > sizeof where.sun_path) {
    return Refusal{.what = "the name of " + called + " is too long for a lock",
                   .remedy = "use a shorter one"};
  }
  std::copy(address.begin(), address.end(), where.sun_path);
  socket_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address.size());
  if (socket_ >= 0 && bind(socket_, reinterpret_cast<const sockaddr*>(&where), size) == 0)
    return std::nullopt;
  if (errno == EADDRINUSE) {
    return Refusal{.what = "another inbetween uses " + called, .remedy = "end it first"};
  }
  return Refusal{.what = called + " cannot be locked: " + std::strerror(errno),
                 .remedy = "look at the system's limits"};
}

}  // namespace inbetween
