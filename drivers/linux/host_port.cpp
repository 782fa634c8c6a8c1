#include "drivers/linux/host_port.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>

#include "drivers/linux/raw_terminal.hpp"

namespace inbetween {
namespace {

constexpr std::string_view pty_mark = "pty:";
constexpr std::string_view tcp_mark = "tcp:127.0.0.1:";
constexpr std::int64_t ns_between_tries = 1'000'000'000;
constexpr std::string_view taken_words = "inbetween: another host has this rig\r\n";

short events_of(int file) {
  pollfd watched{.fd = file, .events = POLLIN, .revents = 0};
  return ::poll(&watched, 1, 0) > 0 ? watched.revents : short{0};
}

bool has_any(short events, int mask) {
  return (events & mask) != 0;
}

bool is_link(const std::string& path) {
  struct stat about {};
  return ::lstat(path.c_str(), &about) == 0 && S_ISLNK(about.st_mode);
}

Refusal not_opened(const std::string& name, const std::string& remedy) {
  return {.what = name + " cannot be opened: " + std::strerror(errno), .remedy = remedy};
}

}  // namespace

std::optional<Refusal> HostPort::open(const std::string& path, std::int32_t baud) {
  close();
  name_ = path;
  baud_ = baud;
  const std::string_view text = path;
  if (text.starts_with(pty_mark)) {
    kind_ = Kind::pty;
    path_ = path.substr(pty_mark.size());
    return open_pty();
  }
  if (text.starts_with(tcp_mark)) {
    kind_ = Kind::tcp;
    return open_tcp(text.substr(tcp_mark.size()));
  }
  kind_ = Kind::serial;
  path_ = path;
  return open_serial();
}

void HostPort::close() {
  unlink();
  if (file_ >= 0) ::close(file_);
  if (listening_ >= 0) ::close(listening_);
  file_ = listening_ = -1;
  has_host_ = is_lost_ = false;
}

std::optional<Refusal> HostPort::open_serial() {
  file_ = ::open(path_.c_str(), O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (file_ < 0) {
    const bool is_missing = errno == ENOENT;
    return not_opened(path_, is_missing ? "plug the cable in and look at the names in /dev/serial/by-id"
                                        : "look who may use it with: ls -l " + path_ + " (group dialout)");
  }
  // Locked, the port cannot be opened by another program of this machine, which would read what the host
  // says.
  static_cast<void>(::ioctl(file_, TIOCEXCL));
  if (make_raw(file_, baud_)) return std::nullopt;
  const std::string reason = std::strerror(errno);
  close();
  return Refusal{.what = path_ + " cannot be set to " + std::to_string(baud_) + " bit/s: " + reason,
                 .remedy = "name a serial port, or pty:NAME"};
}

std::optional<Refusal> HostPort::open_pty() {
  struct stat about {};
  if (path_.empty() || (::lstat(path_.c_str(), &about) == 0 && !S_ISLNK(about.st_mode))) {
    return Refusal{.what = path_.empty() ? "pty: names nothing" : path_ + " is there and is no link",
                   .remedy = "name a link that may be made, such as pty:/tmp/rig"};
  }
  file_ = ::posix_openpt(O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  std::array<char, 128> far_end{};
  const bool is_made = file_ >= 0 && ::grantpt(file_) == 0 && ::unlockpt(file_) == 0 &&
                       ::ptsname_r(file_, far_end.data(), far_end.size()) == 0;
  if (is_made) far_end_ = far_end.data();
  if (is_made && make_new() && link()) return std::nullopt;
  Refusal refusal = not_opened(path_, "name a link in a folder where you may write");
  close();
  return refusal;
}

std::optional<Refusal> HostPort::open_tcp(std::string_view port) {
  std::uint16_t number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  if (error != std::errc() || end != port.data() + port.size()) {
    return Refusal{.what = name_ + " has no port number", .remedy = "write tcp:127.0.0.1:10001, say"};
  }
  listening_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int on = 1;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(number);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  const auto as_any = [&] { return std::bit_cast<sockaddr*>(&address); };
  const bool is_made = listening_ >= 0 &&
                       ::setsockopt(listening_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0 &&
                       ::bind(listening_, as_any(), size) == 0 && ::listen(listening_, 4) == 0 &&
                       ::getsockname(listening_, as_any(), &size) == 0;
  if (is_made) {
    name_ = std::string(tcp_mark) + std::to_string(ntohs(address.sin_port));
    return std::nullopt;
  }
  Refusal refusal = not_opened(name_, "choose another port");
  close();
  return refusal;
}

/// The far end as a new host shall find it: raw, and without what was meant for the last one. Once it was
/// open, the near end tells that nobody has it.
bool HostPort::make_new() {
  const int far_end = ::open(far_end_.c_str(), O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (far_end < 0) return false;
  const bool is_raw = make_raw(far_end, baud_) && ::tcflush(far_end, TCIOFLUSH) == 0;
  return ::close(far_end) == 0 && is_raw;
}

bool HostPort::link() {
  if (is_link(path_)) static_cast<void>(::unlink(path_.c_str()));
  has_link_ = ::symlink(far_end_.c_str(), path_.c_str()) == 0;
  return has_link_;
}

void HostPort::unlink() {
  if (has_link_ && is_link(path_)) static_cast<void>(::unlink(path_.c_str()));
  has_link_ = false;
}

PortChange HostPort::look(std::int64_t now_ns) {
  switch (kind_) {
    case Kind::serial:
      return look_at_serial(now_ns);
    case Kind::pty:
      return look_at_pty();
    case Kind::tcp:
      return look_at_tcp();
  }
  return PortChange::none;
}

void HostPort::lose() {
  has_host_ = is_lost_ = false;
}

PortChange HostPort::look_at_serial(std::int64_t now_ns) {
  if (has_host_) {
    if (!is_lost_ && !has_any(events_of(file_), POLLHUP | POLLERR | POLLNVAL)) return PortChange::none;
    lose();
    ::close(file_);
    file_ = -1;
    tried_ns_ = now_ns;
    return PortChange::went;
  }
  if (file_ < 0) {
    if (now_ns - tried_ns_ < ns_between_tries) return PortChange::none;
    tried_ns_ = now_ns;
    if (open_serial()) return PortChange::none;
  }
  has_host_ = true;
  return PortChange::came;
}

PortChange HostPort::look_at_pty() {
  const short events = events_of(file_);
  const bool is_open = !has_any(events, POLLHUP) || has_any(events, POLLIN);
  if (is_open == has_host_) return PortChange::none;
  if (is_open) {
    has_host_ = true;
    unlink();
    return PortChange::came;
  }
  lose();
  static_cast<void>(make_new());
  static_cast<void>(link());
  return PortChange::went;
}

PortChange HostPort::look_at_tcp() {
  if (has_host_ && is_lost_) {
    lose();
    ::close(file_);
    file_ = -1;
    return PortChange::went;
  }
  const int host = ::accept4(listening_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (host < 0) return PortChange::none;
  if (has_host_) {
    static_cast<void>(::send(host, taken_words.data(), taken_words.size(), MSG_NOSIGNAL));
    ::close(host);
    return PortChange::refused;
  }
  const int on = 1;
  static_cast<void>(::setsockopt(host, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on));
  file_ = host;
  has_host_ = true;
  return PortChange::came;
}

std::size_t HostPort::read(std::span<std::uint8_t> into) {
  if (!has_host_ || is_lost_) return 0;
  const ssize_t count = ::read(file_, into.data(), into.size());
  if (count > 0) return static_cast<std::size_t>(count);
  const bool is_quiet = count < 0 && (errno == EAGAIN || errno == EINTR);
  // A pseudo-terminal tells by itself when its host has gone.
  if (!is_quiet && kind_ != Kind::pty) is_lost_ = true;
  return 0;
}

std::size_t HostPort::write(std::span<const std::uint8_t> bytes) {
  if (!has_host_ || is_lost_ || bytes.empty()) return 0;
  const ssize_t count = kind_ == Kind::tcp ? ::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL)
                                           : ::write(file_, bytes.data(), bytes.size());
  if (count >= 0) return static_cast<std::size_t>(count);
  if (errno != EAGAIN && errno != EINTR && kind_ != Kind::pty) is_lost_ = true;
  return 0;
}

}  // namespace inbetween
