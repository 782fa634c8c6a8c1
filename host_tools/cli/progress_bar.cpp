#include "host_tools/cli/progress_bar.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace inbetween {
namespace {

constexpr int width = 40;

/// The width of standard error in characters; 0 if it is unknown.
int terminal_columns() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

}  // namespace

ProgressBar::ProgressBar() : on_terminal_(::isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (line_open_) std::fputc('\n', stderr);
}

void ProgressBar::show(double share, const std::string& words) {
  if (!on_terminal_) return;
  const int filled = std::clamp(static_cast<int>(std::lround(share * width)), 0, width);
  // One line: a longer one would wrap, and could not be written over.
  const int room = terminal_columns() - width - 4;
  const std::string fitting = room > 0 ? words.substr(0, static_cast<std::size_t>(room)) : words;
  // \033[K clears what a longer text before has left.
  const std::string line =
      fmt::format("\r[{:#>{}}{:.>{}}] {}\033[K", "", filled, "", width - filled, fitting);
  // A terminal that was lost takes nothing; that is no reason to end the work otherwise than it asks for.
  static_cast<void>(std::fputs(line.c_str(), stderr));
  std::fflush(stderr);
  line_open_ = true;
}

}  // namespace inbetween
