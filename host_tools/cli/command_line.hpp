// The command line: `inbetween COMMAND ...`.
#pragma once

namespace inbetween {

/// Parses the arguments and runs the command. Returns the exit status: 0 done, 1 bad input, 2 wrong
/// usage, 3 a limit would be exceeded, 4 stopped by a fault, 5 a shoot that ended with frames missing. Errors
/// go to standard error, one line each.
int run_command_line(int argc, const char* const* argv);

}  // namespace inbetween
