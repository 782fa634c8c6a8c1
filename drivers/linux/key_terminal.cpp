#include "drivers/linux/key_terminal.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>

namespace inbetween {

bool KeyTerminal::is_there() {
  return isatty(STDIN_FILENO) != 0;
}

KeyTerminal::KeyTerminal() {
  tcgetattr(STDIN_FILENO, &before_);
  termios keys = before_;
  keys.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  keys.c_cc[VMIN] = 0;
  keys.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &keys);
}

KeyTerminal::~KeyTerminal() {
  tcsetattr(STDIN_FILENO, TCSANOW, &before_);
}

// A read takes as much as a terminal keeps (N_TTY_BUF_SIZE): no control sequence comes in two pieces.
std::string KeyTerminal::read() {
  std::array<char, 4096> bytes;
  const ssize_t count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
  return count > 0 ? std::string(bytes.data(), static_cast<std::size_t>(count)) : std::string();
}

void release_lost_terminal() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    termios settings{};
    // A terminal that was hung up refuses everything with EIO; a file or a pipe says ENOTTY.
    if (tcgetattr(stream, &settings) == 0 || errno != EIO) continue;
    const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    if (nowhere < 0) continue;
    ::dup2(nowhere, stream);
    ::close(nowhere);
  }
}

}  // namespace inbetween
