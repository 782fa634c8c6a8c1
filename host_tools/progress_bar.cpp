#include "host_tools/progress_bar.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace inbetween {
namespace {

constexpr int width = 40;

}  // namespace

ProgressBar::ProgressBar() : on_terminal_(::isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (line_open_) std::fputc('\n', stderr);
}

void ProgressBar::show(double share, const std::string& words) {
  if (!on_terminal_) return;
  const int filled = std::clamp(static_cast<int>(std::lround(share * width)), 0, width);
  // \033[K clears what a longer text before has left.
  fmt::print(stderr, "\r[{:#>{}}{:.>{}}] {}\033[K", "", filled, "", width - filled, words);
  std::fflush(stderr);
  line_open_ = true;
}

}  // namespace inbetween
