#include "host_tools/edit/timed_stream.hpp"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>

namespace inbetween {

bool TimedStream::waits_for(short event, Clock::time_point until) const {
  pollfd waited{.fd = socket_, .events = event, .revents = 0};
  int found = 0;
  do {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    if (left.count() <= 0) return false;
    found = ::poll(&waited, 1, static_cast<int>(std::min(left, patience_.max_silence).count()));
  } while (found < 0 && errno == EINTR);
  return found > 0;
}

bool TimedStream::is_readable() const {
  return waits_for(POLLIN, read_until_);
}

bool TimedStream::is_writable() const {
  if (write_until_ == Clock::time_point{}) write_until_ = Clock::now() + patience_.max_seconds;
  return waits_for(POLLOUT, write_until_);
}

ssize_t TimedStream::read(char* bytes, std::size_t size) {
  return is_readable() ? ::recv(socket_, bytes, size, 0) : -1;
}

ssize_t TimedStream::write(const char* bytes, std::size_t size) {
  return is_writable() ? ::send(socket_, bytes, size, MSG_NOSIGNAL | MSG_DONTWAIT) : -1;
}

// Nobody but this machine can connect, and nothing is told apart by ports.
void TimedStream::get_remote_ip_and_port(std::string& ip, int& port) const {
  ip = "127.0.0.1";
  port = 0;
}
void TimedStream::get_local_ip_and_port(std::string& ip, int& port) const {
  ip = "127.0.0.1";
  port = 0;
}

}  // namespace inbetween
