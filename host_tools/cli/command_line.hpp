// The command line: `inbetween COMMAND ...`.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace inbetween {

/// The arguments of `edit`, and what it does with them: that is not in this room, so that no other command
/// waits for what a web server needs.
struct EditArguments {
  std::string move;
  std::optional<std::string> rig;
  int port = 0;
  bool no_browser = false;
};
using EditCommand = std::function<int(const EditArguments&)>;

/// Parses the arguments and runs the command. Returns the exit status: 0 done, 1 bad input, 2 wrong
/// usage, 3 a limit would be exceeded, 4 stopped by a fault, 5 a shoot that ended with frames missing. Errors
/// go to standard error, one line each.
int run_command_line(int argc, const char* const* argv, const EditCommand& edit);

}  // namespace inbetween
