#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/refusal.hpp"

namespace inbetween {

/// Lines of text to a FIFO, a serial port or a pseudo-terminal, for a real-time loop: after `open` nothing
/// waits and nothing is allocated, whether somebody reads or not.
class LinePipe {
 public:
  LinePipe() = default;
  ~LinePipe() { close(); }
  LinePipe(const LinePipe&) = delete;
  LinePipe& operator=(const LinePipe&) = delete;

  /// Refused are what is not there, a FIFO that nobody reads, and what is neither FIFO nor character device.
  /// A serial port becomes raw, with `baud` bit/s. From now on a reader that leaves is a failed write for
  /// this process, and no signal. A FIFO holds a page only, so that few lines can be old.
  [[nodiscard]] std::optional<Refusal> open(const std::string& path, std::int32_t baud);
  void close();

  /// Whether it is a serial port or a pseudo-terminal.
  [[nodiscard]] bool is_terminal() const { return is_terminal_; }
  /// The bytes that nobody has read yet, or that have not been put on the wire; 0 where nobody can tell.
  [[nodiscard]] std::size_t waiting() const;
  /// Sends all of it or, as far as the device can do that, nothing. False: not all of it has gone, and then
  /// it is closed: nobody knows what is in the middle of a line.
  bool send(std::string_view line);
  [[nodiscard]] bool is_open() const { return file_ >= 0; }

 private:
  int file_ = -1;
  bool is_terminal_ = false;
};

}  // namespace inbetween
