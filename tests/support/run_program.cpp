#include "tests/support/run_program.hpp"

#include <fcntl.h>
#include <pty.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "tests/support/places.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace {

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// The two ends of a terminal.
struct Terminal {
  int ours = -1;
  int theirs = -1;

  Terminal() {
    winsize size{};
    size.ws_row = 25;
    size.ws_col = 80;
    if (::openpty(&ours, &theirs, nullptr, nullptr, &size) != 0) fail("openpty");
  }
  ~Terminal() {
    ::close(ours);
    if (theirs >= 0) ::close(theirs);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// What was written until the last writer closed it.
  std::string read_all() {
    ::close(theirs);
    theirs = -1;
    std::string text;
    std::array<char, 4096> block{};
    for (;;) {
      const ssize_t count = ::read(ours, block.data(), block.size());
      if (count <= 0) return text;  // Linux says EIO when nobody has the other end any more
      text.append(block.data(), static_cast<std::size_t>(count));
    }
  }
};

/// Only what a child may call between fork and exec.
[[noreturn]] void become_program(char* const* arguments, const char* out, const char* err, int terminal) {
  constexpr int to_write = O_WRONLY | O_CREAT | O_TRUNC;
  const int in_stream = ::open("/dev/null", O_RDONLY);
  const int out_stream = ::open(out, to_write, 0600);
  const int err_stream = terminal >= 0 ? terminal : ::open(err, to_write, 0600);
  if (::dup2(in_stream, STDIN_FILENO) >= 0 && ::dup2(out_stream, STDOUT_FILENO) >= 0 &&
      ::dup2(err_stream, STDERR_FILENO) >= 0) {
    ::execv(arguments[0], arguments);
  }
  ::_exit(126);
}

}  // namespace

std::string file_contents(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

ProgramRun run_program(const std::vector<std::string>& arguments, const ProgramStreams& streams) {
  std::vector<std::string> words = {in_build("inbetween")};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return run_command(std::move(words), streams);
}

ProgramRun run_command(std::vector<std::string> words, const ProgramStreams& streams) {
  // A test of takes names their file; no other keeps its runs beside the examples, run by hand either.
  ::setenv("INBETWEEN_TAKES", "off", 0);
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);

  const TemporaryFolder folder;
  const std::string out = streams.out_path.empty() ? (folder.path() / "out").string() : streams.out_path;
  const std::string err = streams.err_path.empty() ? (folder.path() / "err").string() : streams.err_path;
  Terminal terminal;
  const pid_t child = ::fork();
  if (child < 0) fail("fork");
  if (child == 0) {
    ::close(terminal.ours);
    become_program(pointers.data(), out.c_str(), err.c_str(), streams.err_on_terminal ? terminal.theirs : -1);
  }
  ProgramRun run;
  if (streams.err_on_terminal) run.err = terminal.read_all();
  int status = 0;
  rusage usage{};
  while (::wait4(child, &status, 0, &usage) < 0) {
    if (errno != EINTR) fail("wait4");
  }
  run.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  run.max_memory_kb = usage.ru_maxrss;
  if (streams.out_path.empty()) run.out = file_contents(out);
  if (streams.err_path.empty() && !streams.err_on_terminal) run.err = file_contents(err);
  return run;
}

}  // namespace inbetween
