#include "drivers/linux/key_terminal.hpp"

#include <unistd.h>

#include <array>
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

std::string KeyTerminal::read() {
  std::array<char, 64> bytes;
  const ssize_t count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
  return count > 0 ? std::string(bytes.data(), static_cast<std::size_t>(count)) : std::string();
}

}  // namespace inbetween
