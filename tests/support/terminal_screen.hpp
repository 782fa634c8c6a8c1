// A terminal of so many columns and lines in which a program runs, with somebody who types and reads.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/temporary_file.hpp"

namespace inbetween {

/// A pane of tmux on a server of its own. What is waited for is looked at again and again, for a minute at
/// most.
class TerminalScreen {
 public:
  /// The built program with these arguments. Throws std::runtime_error where tmux does not start.
  explicit TerminalScreen(const std::vector<std::string>& arguments, int columns = 80, int lines = 24);
  /// Whatever still runs in it is hung up.
  ~TerminalScreen();
  TerminalScreen(const TerminalScreen&) = delete;
  TerminalScreen& operator=(const TerminalScreen&) = delete;

  /// A character, or the name that tmux has for the key: Space, Enter, Escape, Left, Home.
  void press(const std::string& key);
  void resize(int columns, int lines);
  /// What the screen shows once it shows the text: its lines, without the spaces at their ends. Fails the
  /// test, with the screen, where it never does.
  std::string wait_for(const std::string& text);
  /// The exit status of the program, once it has ended; -1 where it never does.
  int wait_for_exit();
  [[nodiscard]] std::string shown() const;

 private:
  std::string tmux(std::vector<std::string> words) const;

  TemporaryFolder folder_;
};

}  // namespace inbetween
