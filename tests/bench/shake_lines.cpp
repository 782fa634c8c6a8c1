// Loose contacts at lines of a GPIO chip of the kernel's gpio-sim: each of them changes as often as the
// kernel of the bench tells of a line, at every of its timer ticks. Until it is killed, or the chip is
// unplugged.
//
//   inbetween_shake_lines FOLDER_OF_THE_CHIP FIRST_LINE COUNT
#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <string>
#include <string_view>
#include <vector>

namespace {

constexpr std::int64_t between_changes_ns = 10'000'000;
constexpr std::int64_t ns_per_s = 1'000'000'000;

}  // namespace

int main(int count, char** arguments) {
  if (count != 4) return 2;
  const sched_param priority{.sched_priority = 85};
  if (::sched_setscheduler(0, SCHED_FIFO, &priority) != 0) return 1;
  const int first = std::atoi(arguments[2]);
  std::vector<int> files;
  for (int line = first; line < first + std::atoi(arguments[3]); ++line) {
    const std::string path = std::string(arguments[1]) + "/sim_gpio" + std::to_string(line) + "/pull";
    files.push_back(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    if (files.back() < 0) return 1;
  }
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  std::int64_t at_ns = now.tv_sec * ns_per_s + now.tv_nsec;
  for (bool is_up = true;; is_up = !is_up) {
    const std::string_view pull = is_up ? "pull-up" : "pull-down";
    for (const int file : files) {
      if (::pwrite(file, pull.data(), pull.size(), 0) != static_cast<ssize_t>(pull.size())) return 0;
    }
    at_ns += between_changes_ns;
    const timespec next{.tv_sec = at_ns / ns_per_s, .tv_nsec = at_ns % ns_per_s};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr);
  }
}
