// What an oscilloscope at a GPIO chip of the kernel's gpio-sim would show: a line for every change of its
// lines that are named, with the time (CLOCK_MONOTONIC, ns) and their levels as a number, bit i of line i.
// Until it is killed, or the chip is unplugged.
//
//   inbetween_watch_lines FOLDER_OF_THE_CHIP LINE...
#include <fcntl.h>
#include <sched.h>
#include <time.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

namespace {

/// Most of what a scene takes is looking: as seldom as pulses of a millisecond allow.
constexpr std::int64_t between_looks_ns = 400'000;
constexpr std::int64_t ns_per_s = 1'000'000'000;

struct Line {
  int number;
  int file;
};

std::optional<unsigned> levels_of(const std::vector<Line>& lines) {
  unsigned levels = 0;
  for (const Line& line : lines) {
    char value = 0;
    if (::pread(line.file, &value, 1, 0) != 1) return std::nullopt;
    if (value == '1') levels |= 1U << line.number;
  }
  return levels;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 3) return 2;
  // Before whatever it looks at.
  const sched_param priority{.sched_priority = 90};
  if (::sched_setscheduler(0, SCHED_FIFO, &priority) != 0) return 1;
  std::vector<Line> lines;
  for (int i = 2; i < count; ++i) {
    const std::string path = std::string(arguments[1]) + "/sim_gpio" + arguments[i] + "/value";
    lines.push_back({std::atoi(arguments[i]), ::open(path.c_str(), O_RDONLY | O_CLOEXEC)});
    if (lines.back().file < 0) return 1;
  }
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  std::int64_t at_ns = now.tv_sec * ns_per_s + now.tv_nsec;
  std::optional<unsigned> before;
  for (;;) {
    const std::optional<unsigned> levels = levels_of(lines);
    if (!levels) return 0;
    if (levels != before) std::printf("%lld %u\n", static_cast<long long>(at_ns), *levels);
    if (levels != before) std::fflush(stdout);
    before = levels;
    at_ns += between_looks_ns;
    const timespec next{.tv_sec = at_ns / ns_per_s, .tv_nsec = at_ns % ns_per_s};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr);
  }
}
