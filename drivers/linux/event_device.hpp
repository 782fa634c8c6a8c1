#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace inbetween {

/// What somebody did at a device.
enum class HandEvent : std::uint8_t {
  forward,  ///< is held from now on
  backward,
  let_go,  ///< nothing is held any more that means a direction
  detent_forward,
  detent_backward,
};

/// A device that tells when a key is pressed and when it is let go, and each detent of a wheel: a keyboard, a
/// game pad or a jog wheel as Linux's evdev shows it (/dev/input/event*), or a pipe that carries the same
/// structures. Right, + of the keypad and the right of a cross mean forward, left, - and the left of a cross
/// backward.
///
/// A direction begins from neutral only: while another key is held, or one that was held when the device was
/// opened, or after events were lost, nothing is held until all are let go. A wheel has 120 of the units of
/// REL_WHEEL_HI_RES in a detent; units of the other direction begin a new one.
///
/// Linux's structures are read as they are and not through libevdev, which takes no pipe: so another program
/// or a test may be the device.
class EventDevice {
 public:
  /// Throws std::system_error with the path where it cannot be opened.
  explicit EventDevice(const std::string& path);
  ~EventDevice();
  EventDevice(const EventDevice&) = delete;
  EventDevice& operator=(const EventDevice&) = delete;

  /// Whether nobody else hears the device: what is pressed on it is not typed into a terminal as well. Asks
  /// for that, once no key is held: whoever heard one pressed would never hear it let go. A pipe has one
  /// reader anyway. Throws std::system_error with the path where another program has asked before.
  bool has_alone();
  /// Until the device tells something.
  void wait() const;

  /// Returns what was done since the last call, in order. Of several detents in one report two are told, so
  /// that whoever counts knows that there were more than one. It never waits. A device that goes away holds
  /// nothing.
  std::vector<HandEvent> events();
  /// Returns what the other keys would have typed into a terminal since the last call: digits, letters,
  /// Enter, Esc, space, up and down, by their places on a US keyboard; q for Ctrl-C. Nothing while somebody
  /// else hears them as well.
  std::string typed();
  [[nodiscard]] bool is_gone() const { return file_ < 0; }

 private:
  void take(std::uint16_t type, std::uint16_t code, std::int32_t value, std::vector<HandEvent>& events);
  void take_key(std::uint16_t code, std::int32_t value);
  void take_report(std::vector<HandEvent>& events);
  void ask_what_is_held();
  void settle(std::vector<HandEvent>& events);
  void close();

  std::string path_;
  int file_ = -1;
  bool is_evdev_ = false;
  bool has_alone_ = false;
  bool has_lost_ = false;  ///< events, and the next report does not count either
  unsigned held_ = 0;      ///< a bit for each key or axis of it and direction
  bool is_neutral_ = true;
  int direction_ = 0;
  /// Of the report that has begun.
  struct Turned {
    std::int64_t dial = 0, wheel = 0, fine = 0;
    bool is_fine = false;
  } turned_;
  std::int64_t turned_units_ = 0;  ///< less than a detent
  bool has_control_ = false;       ///< a Ctrl key is held
  std::string typed_;
};

}  // namespace inbetween
