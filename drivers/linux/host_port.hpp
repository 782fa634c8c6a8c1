#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "drivers/refusal.hpp"

namespace inbetween {

/// Who is at the other end of a port.
enum class PortChange : std::uint8_t {
  none,
  came,     ///< a host: bytes may be read and written
  went,     ///< it has closed the port, or was unplugged
  refused,  ///< a second one, which was told so and has been cut off
};

/// The end of a port at which one other program, the host, may be at a time. After `open` nothing waits and
/// nothing is allocated.
///
/// A path names a serial port: the host is there while the port can be read. `pty:NAME` makes a
/// pseudo-terminal, and NAME a symbolic link to it, which is gone while a host has it open: a second finds no
/// port. `tcp:127.0.0.1:PORT` listens on this machine alone, for tests; 0 is any free port.
class HostPort {
 public:
  HostPort() = default;
  ~HostPort() { close(); }
  HostPort(const HostPort&) = delete;
  HostPort& operator=(const HostPort&) = delete;

  /// Refused are what is not there, a NAME that is something else than a link, a speed that the port has not.
  [[nodiscard]] std::optional<Refusal> open(const std::string& path, std::int32_t baud);
  void close();

  /// Each call tells one thing that has changed. A serial port that is gone is opened again as soon as it is
  /// back, a try a second at most.
  PortChange look(std::int64_t now_ns);
  [[nodiscard]] bool has_host() const { return has_host_; }
  /// How many bytes were read or written, 0 where it is not possible now.
  std::size_t read(std::span<std::uint8_t> into);
  std::size_t write(std::span<const std::uint8_t> bytes);

  /// This is the name that was given; of TCP it has the port that it got.
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  enum class Kind : std::uint8_t { serial, pty, tcp };

  std::optional<Refusal> open_serial();
  std::optional<Refusal> open_pty();
  std::optional<Refusal> open_tcp(std::string_view port);
  PortChange look_at_serial(std::int64_t now_ns);
  PortChange look_at_pty();
  PortChange look_at_tcp();
  bool make_new();
  bool link();
  void unlink();
  void lose();

  std::string name_;
  std::string path_;     ///< of the serial port or the link
  std::string far_end_;  ///< of the pseudo-terminal
  std::int32_t baud_ = 0;
  Kind kind_ = Kind::serial;
  int file_ = -1;       ///< that is read and written; of TCP the host's
  int listening_ = -1;  ///< of TCP
  bool has_host_ = false;
  bool has_link_ = false;
  bool is_lost_ = false;  ///< reading or writing has shown it
  std::int64_t tried_ns_ = 0;
};

}  // namespace inbetween
