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

/// Asks the terminal of standard error to tell when a key is repeated and let go, by kitty's keyboard
/// protocol (https://sw.kovidgoyal.net/kitty/keyboard-protocol, its progressive enhancement 2), until this
/// ends. A terminal that can do it answers CSI ? FLAGS u among the keys; others ignore it. The screen with
/// the keys must be there before it is asked, and be left after this: each screen of a terminal has
/// enhancements of its own.
class KeyReleases {
 public:
  KeyReleases() = default;
  ~KeyReleases();
  KeyReleases(const KeyReleases&) = delete;
  KeyReleases& operator=(const KeyReleases&) = delete;

  /// Once, however often it is called; nothing where standard error is no terminal.
  void ask();

 private:
  bool has_asked_ = false;
};

/// Whatever of the standard streams was on a terminal that is lost goes to /dev/null from now on: nobody
/// reads it, and what must still be done does not fail for it.
void release_lost_terminal();

}  // namespace inbetween
