#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace inbetween {

/// A device that tells when a key is pressed and when it is let go: a keyboard or a game pad as Linux's evdev
/// shows it (/dev/input/event*), or a pipe that carries the same structures. Right, + and the right of a
/// cross mean forward, left, - and the left of a cross backward; all else is ignored.
///
/// A direction begins from neutral only: while another key is held, or one that was held when the device was
/// opened, or after events were lost, nothing is held until all are let go.
class EventDevice {
 public:
  /// Throws std::system_error with the path where it cannot be opened.
  explicit EventDevice(const std::string& path);
  ~EventDevice();
  EventDevice(const EventDevice&) = delete;
  EventDevice& operator=(const EventDevice&) = delete;

  /// Returns what was held since the last call, in order: 1 forward, -1 backward, 0 nothing. It never waits.
  /// A device that goes away holds nothing.
  std::vector<int> changes();
  [[nodiscard]] bool is_gone() const { return file_ < 0; }

 private:
  void take(std::uint16_t type, std::uint16_t code, std::int32_t value, std::vector<int>& changes);
  void ask_what_is_held();
  void settle(std::vector<int>& changes);
  void close();

  int file_ = -1;
  unsigned held_ = 0;  ///< a bit for each key or axis of it and direction
  bool is_neutral_ = true;
  int direction_ = 0;
};

}  // namespace inbetween
