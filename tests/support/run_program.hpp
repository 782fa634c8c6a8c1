// Runs the built program as its users do, and catches what it says.
#pragma once

#include <string>
#include <vector>

namespace inbetween {

/// Where the program's streams go. An empty path: they are caught.
struct ProgramStreams {
  std::string out_path;
  std::string err_path;
  bool err_on_terminal = false;  ///< standard error is a terminal, 80 columns wide, and is caught there
};

struct ProgramRun {
  int status = 0;        ///< exit status; 128 + n after signal n
  std::string out;       ///< standard output
  std::string err;       ///< standard error
  long max_memory_kb{};  ///< largest resident set
};

/// Runs a command, the path of its program first, with nothing on standard input, and waits for its end.
/// Throws std::system_error where no process can be made; the status is 126 where the program is not there.
ProgramRun run_command(std::vector<std::string> words, const ProgramStreams& streams = {});

/// Runs the built program with these arguments.
ProgramRun run_program(const std::vector<std::string>& arguments, const ProgramStreams& streams = {});

/// All bytes of a file; "" where there is none.
std::string file_contents(const std::string& path);

}  // namespace inbetween
