#pragma once

#include <termios.h>

#include <string>

namespace inbetween {

/// Standard input key by key, without echo, for as long as this lives. Ctrl-C still interrupts.
class KeyTerminal {
 public:
  /// Whether standard input is a terminal.
  static bool is_there();
  KeyTerminal();
  ~KeyTerminal();
  KeyTerminal(const KeyTerminal&) = delete;
  KeyTerminal& operator=(const KeyTerminal&) = delete;

  /// Returns what was typed since the last call; never waits.
  std::string read();

 private:
  termios before_{};
};

/// Whatever of the standard streams was on a terminal that is lost goes to /dev/null from now on: nobody
/// reads it, and what must still be done does not fail for it.
void release_lost_terminal();

}  // namespace inbetween
