#include "drivers/linux/line_pipe.hpp"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "drivers/linux/raw_terminal.hpp"

namespace inbetween {
namespace {

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
