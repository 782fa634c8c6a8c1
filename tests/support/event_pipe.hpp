// A pipe that speaks as a device of /dev/input does.
#pragma once

#include <fcntl.h>
#include <linux/input.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <system_error>

namespace inbetween {

class EventPipe {
 public:
  /// A named pipe of that path, with a writer from the beginning.
  explicit EventPipe(std::string path) : path_(std::move(path)) {
    if (::mkfifo(path_.c_str(), 0600) == 0) file_ = ::open(path_.c_str(), O_RDWR | O_CLOEXEC);
    if (file_ < 0) throw std::system_error(errno, std::generic_category(), path_);
  }
  ~EventPipe() { unplug(); }
  EventPipe(const EventPipe&) = delete;
  EventPipe& operator=(const EventPipe&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  /// A key: 1 pressed, 0 let go, 2 repeated.
  void key(std::uint16_t code, std::int32_t value) { tell(EV_KEY, code, value); }
  void tell(std::uint16_t type, std::uint16_t code, std::int32_t value) { report({{type, code, value}}); }
  struct Event {
    std::uint16_t type, code;
    std::int32_t value;
  };
  /// Several events and their SYN_REPORT.
  void report(std::initializer_list<Event> events) {
    input_event event{};
    for (const Event& one : events) {
      event.type = one.type;
      event.code = one.code;
      event.value = one.value;
      write(&event, sizeof(event));
    }
    event = {};
    write(&event, sizeof(event));
  }
  void write(const void* bytes, std::size_t size) {
    if (::write(file_, bytes, size) != static_cast<ssize_t>(size)) {
      throw std::system_error(errno, std::generic_category(), path_);
    }
  }
  void unplug() {
    if (file_ >= 0) ::close(file_);
    file_ = -1;
  }

 private:
  std::string path_;
  int file_ = -1;
};

}  // namespace inbetween
