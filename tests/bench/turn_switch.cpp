// A motor at a STEP and a DIR line of a chip of the kernel's gpio-sim, and a switch on its way at another: it
// closes, to high, when the motor has come down to AT steps from where it began, and opens HYSTERESIS above.
// Until it is killed, or the chip is unplugged.
//
// The kernel of the bench tells an edge at its next timer tick, every 10 ms, and a level at once. A program
// that reads both would hear of each edge too late; so the switch changes just before such a tick.
//
//   inbetween_turn_switch FOLDER_OF_THE_CHIP STEP DIR SWITCH AT HYSTERESIS
#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <string>
#include <string_view>

namespace {

/// Shorter than a pulse of STEP, or its pause.
constexpr std::int64_t between_looks_ns = 250'000;
constexpr std::int64_t kernel_tick_ns = 10'000'000;
constexpr std::int64_t before_tick_ns = 5'000;
constexpr std::int64_t ns_per_s = 1'000'000'000;

int open_line(const char* folder, const char* line, const char* what, int flags) {
  const std::string path = std::string(folder) + "/sim_gpio" + line + "/" + what;
  return ::open(path.c_str(), flags | O_CLOEXEC);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 7) return 2;
  const sched_param priority{.sched_priority = 85};
  if (::sched_setscheduler(0, SCHED_FIFO, &priority) != 0) return 1;
  const int step = open_line(arguments[1], arguments[2], "value", O_RDONLY);
  const int dir = open_line(arguments[1], arguments[3], "value", O_RDONLY);
  const int pull = open_line(arguments[1], arguments[4], "pull", O_WRONLY);
  if (step < 0 || dir < 0 || pull < 0) return 1;
  const int closes = std::atoi(arguments[5]);
  const int opens = closes + std::atoi(arguments[6]);
  int at = 0;
  bool is_closed = false;
  char before = '0';
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t now_ns = now.tv_sec * ns_per_s + now.tv_nsec;
  std::int64_t at_ns = (now_ns / kernel_tick_ns + 1) * kernel_tick_ns - before_tick_ns;
  for (;;) {
    const timespec next{.tv_sec = at_ns / ns_per_s, .tv_nsec = at_ns % ns_per_s};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr);
    char level = 0;
    char up = 0;
    if (::pread(step, &level, 1, 0) != 1 || ::pread(dir, &up, 1, 0) != 1) return 0;
    if (level == '1' && before == '0') at += up == '1' ? 1 : -1;
    before = level;
    const bool is_wrong = is_closed ? at >= opens : at <= closes;
    if (is_wrong && (at_ns + before_tick_ns) % kernel_tick_ns == 0) {
      is_closed = !is_closed;
      const std::string_view pulled = is_closed ? "pull-up" : "pull-down";
      if (::pwrite(pull, pulled.data(), pulled.size(), 0) != static_cast<ssize_t>(pulled.size())) return 0;
    }
    at_ns += between_looks_ns;
  }
}
