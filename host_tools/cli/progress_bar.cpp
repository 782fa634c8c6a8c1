#include "host_tools/cli/progress_bar.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace inbetween {
namespace {

/// The widths of the bar: the widest that the words leave room for, so that it does not change with each.
constexpr std::array widths{40, 20, 10};

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
  // One line: a longer one would wrap, and could not be written over. The words come before the bar.
  const int columns = terminal_columns();
  const int room = columns > 0 ? columns - 1 : std::numeric_limits<int>::max();
  const int left = room - static_cast<int>(words.size()) - 3;
  const auto* const width = std::ranges::find_if(widths, [&](int wide) { return wide <= left; });
  std::string bar;
  if (width != widths.end()) {
    const int filled = std::clamp(static_cast<int>(std::lround(share * *width)), 0, *width);
    bar = fmt::format("[{:#>{}}{:.>{}}] ", "", filled, "", *width - filled);
  }
  const std::string fitting = words.substr(0, static_cast<std::size_t>(room));
  // \033[K clears what a longer text before has left.
  const std::string line = fmt::format("\r{}{}\033[K", bar, fitting);
  // A terminal that was lost takes nothing; that is no reason to end the work otherwise than it asks for.
  static_cast<void>(std::fputs(line.c_str(), stderr));
  std::fflush(stderr);
  line_open_ = true;
}

}  // namespace inbetween
