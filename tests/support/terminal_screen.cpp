#include "tests/support/terminal_screen.hpp"

#include <gtest/gtest.h>
#include <poll.h>

#include <chrono>
#include <cstdlib>
#include <stdexcept>

#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"

namespace inbetween {
namespace {

constexpr std::chrono::seconds patience{60};
/// Between two looks at the screen, so that who looks leaves the processor to what it looks at.
constexpr int look_ms = 20;
const std::string ended = "exit status ";

}  // namespace

TerminalScreen::TerminalScreen(const std::vector<std::string>& arguments, int columns, int lines) {
  // The pane stays until it is closed, so that its last words can be read.
  std::vector<std::string> words{"new-session",
                                 "-d",
                                 "-x",
                                 std::to_string(columns),
                                 "-y",
                                 std::to_string(lines),
                                 "sh",
                                 "-c",
                                 "\"$@\"; echo \"" + ended + "$?\"; exec cat",
                                 "sh",
                                 in_build("inbetween")};
  words.insert(words.end(), arguments.begin(), arguments.end());
  tmux(words);
}

TerminalScreen::~TerminalScreen() {
  run_command({"/usr/bin/tmux", "-S", folder_.path() / "tmux", "kill-server"});
}

std::string TerminalScreen::tmux(std::vector<std::string> words) const {
  words.insert(words.begin(), {"/usr/bin/tmux", "-u", "-f", "/dev/null", "-S", folder_.path() / "tmux"});
  const ProgramRun run = run_command(words);
  if (run.status != 0) throw std::runtime_error("tmux: " + run.err);
  return run.out;
}

void TerminalScreen::press(const std::string& key) {
  tmux({"send-keys", key});
}

void TerminalScreen::resize(int columns, int lines) {
  tmux({"resize-window", "-x", std::to_string(columns), "-y", std::to_string(lines)});
}

std::string TerminalScreen::shown() const {
  return tmux({"capture-pane", "-p"});
}

std::string TerminalScreen::wait_for(const std::string& text) {
  const auto end = std::chrono::steady_clock::now() + patience;
  std::string screen;
  while (std::chrono::steady_clock::now() < end) {
    screen = shown();
    if (screen.find(text) != std::string::npos) return screen;
    if (screen.find(ended) != std::string::npos) break;  // nothing more will be shown
    ::poll(nullptr, 0, look_ms);
  }
  ADD_FAILURE() << "the screen never showed \"" << text << "\"; it shows\n" << screen;
  return screen;
}

int TerminalScreen::wait_for_exit() {
  const std::string screen = wait_for(ended);
  const std::size_t at = screen.rfind(ended);
  return at == std::string::npos ? -1 : std::atoi(screen.c_str() + at + ended.size());
}

}  // namespace inbetween
