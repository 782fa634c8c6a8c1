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

  /// What has been typed since the last call; never waits.
  std::string read();

 private:
  termios before_{};
};

}  // namespace inbetween
