#include "drivers/linux/line_pipe.hpp"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

namespace inbetween {
namespace {

constexpr std::array bauds{std::pair<std::int32_t, speed_t>{9'600, B9600},
                           std::pair<std::int32_t, speed_t>{19'200, B19200},
                           std::pair<std::int32_t, speed_t>{38'400, B38400},
                           std::pair<std::int32_t, speed_t>{57'600, B57600},
                           std::pair<std::int32_t, speed_t>{115'200, B115200},
                           std::pair<std::int32_t, speed_t>{230'400, B230400},
                           std::pair<std::int32_t, speed_t>{460'800, B460800},
                           std::pair<std::int32_t, speed_t>{500'000, B500000},
                           std::pair<std::int32_t, speed_t>{921'600, B921600},
                           std::pair<std::int32_t, speed_t>{1'000'000, B1000000}};

auto baud_of(std::int32_t baud) {
  return std::ranges::find(bauds, baud, &std::pair<std::int32_t, speed_t>::first);
}

bool make_raw(int file, std::int32_t baud) {
  termios settings{};
  const auto known = baud_of(baud);
  if (known == bauds.end() || ::tcgetattr(file, &settings) != 0) return false;
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(HUPCL);  // many boards start anew when the port is closed
  return ::cfsetspeed(&settings, known->second) == 0 && ::tcsetattr(file, TCSANOW, &settings) == 0;
}

Refusal refusal_of_open(const std::string& path, int error) {
  const std::string reason = std::strerror(error);
  if (error == ENXIO) {
    return {.what = "nobody reads " + path, .remedy = "start the program at its other end first"};
  }
  if (error == ENOENT) {
    return {.what = "there is no " + path,
            .remedy =
                "plug the board in and look at the names in /dev/serial/by-id, or make a FIFO with: mkfifo " +
                path};
  }
  return {.what = path + " cannot be opened: " + reason,
          .remedy = "look who may write it with: ls -l " + path + " (serial ports: group dialout)"};
}

}  // namespace

bool is_baud(std::int32_t baud) {
  return baud_of(baud) != bauds.end();
}

std::optional<Refusal> LinePipe::open(const std::string& path, std::int32_t baud) {
  close();
  const int file = ::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (file < 0) return refusal_of_open(path, errno);
  file_ = file;
  is_terminal_ = ::isatty(file) == 1;
  struct stat about {};
  const bool is_known = ::fstat(file, &about) == 0;
  std::optional<Refusal> refusal;
  if (!is_known || (!S_ISFIFO(about.st_mode) && !S_ISCHR(about.st_mode))) {
    refusal = {.what = path + " is neither a FIFO nor a serial port",
               .remedy = "name one, such as /dev/ttyACM0"};
  } else if (is_terminal_ && !make_raw(file, baud)) {
    refusal = {.what = path + " cannot be set to " + std::to_string(baud) + " bit/s: " + std::strerror(errno),
               .remedy = "give a baud that the port has"};
  }
  if (refusal) {
    close();
    return refusal;
  }
  if (S_ISFIFO(about.st_mode)) static_cast<void>(::fcntl(file, F_SETPIPE_SZ, 4096));
  static_cast<void>(std::signal(SIGPIPE, SIG_IGN));
  return std::nullopt;
}

void LinePipe::close() {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

std::size_t LinePipe::waiting() const {
  int bytes = 0;
  const unsigned long question = is_terminal_ ? TIOCOUTQ : FIONREAD;
  if (file_ < 0 || ::ioctl(file_, question, &bytes) != 0 || bytes < 0) return 0;
  return static_cast<std::size_t>(bytes);
}

bool LinePipe::send(std::string_view line) {
  if (file_ < 0) return false;
  const ssize_t sent = ::write(file_, line.data(), line.size());
  const bool is_whole = sent >= 0 && static_cast<std::size_t>(sent) == line.size();
  if (!is_whole) close();
  return is_whole;
}

}  // namespace inbetween
