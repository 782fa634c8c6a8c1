// What an oscilloscope at a GPIO chip of the kernel's gpio-sim would show: a line for every change of its
// lines that are named, with the time (CLOCK_MONOTONIC, ns) and their levels as a number, bit i of line i.
// Until it is killed, or the chip is unplugged.
//
//   inbetween_watch_lines FOLDER_OF_THE_CHIP LINE...
#include <fcntl.h>
#include <linux/aio_abi.h>
#include <sched.h>
#include <sys/syscall.h>
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

/// The lines, all read with one system call: a call takes the kernel of the bench longer than what it does.
class Lines {
 public:
  /// Where there is no such line: is_there() is false.
  Lines(const std::string& chip, const std::vector<int>& numbers)
      : numbers_(numbers), values_(numbers.size()), events_(numbers.size()) {
    is_there_ = ::syscall(SYS_io_setup, numbers.size(), &context_) == 0;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const std::string path = chip + "/sim_gpio" + std::to_string(numbers[i]) + "/value";
      const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
      is_there_ = is_there_ && file >= 0;
      iocb& read = reads_.emplace_back();
      read.aio_lio_opcode = IOCB_CMD_PREAD;
      read.aio_fildes = static_cast<std::uint32_t>(file);
      read.aio_buf = reinterpret_cast<std::uintptr_t>(&values_[i]);
      read.aio_nbytes = 1;
    }
    for (iocb& read : reads_) pointers_.push_back(&read);
  }
  [[nodiscard]] bool is_there() const { return is_there_; }

  /// Nothing once the chip is unplugged.
  std::optional<unsigned> levels() {
    const auto count = static_cast<long>(numbers_.size());
    if (::syscall(SYS_io_submit, context_, count, pointers_.data()) != count) return std::nullopt;
    if (::syscall(SYS_io_getevents, context_, count, count, events_.data(), nullptr) != count)
      return std::nullopt;
    for (const io_event& event : events_) {
      if (event.res != 1) return std::nullopt;
    }
    unsigned levels = 0;
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      if (values_[i] == '1') levels |= 1U << numbers_[i];
    }
    return levels;
  }

 private:
  std::vector<int> numbers_;
  std::vector<char> values_;
  std::vector<iocb> reads_;
  std::vector<iocb*> pointers_;
  std::vector<io_event> events_;
  aio_context_t context_ = 0;
  bool is_there_ = false;
};

}  // namespace

int main(int count, char** arguments) {
  if (count < 3) return 2;
  // Before whatever it looks at.
  const sched_param priority{.sched_priority = 90};
  if (::sched_setscheduler(0, SCHED_FIFO, &priority) != 0) return 1;
  std::vector<int> numbers;
  for (int i = 2; i < count; ++i) numbers.push_back(std::atoi(arguments[i]));
  Lines lines(arguments[1], numbers);
  if (!lines.is_there()) return 1;
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  std::int64_t at_ns = now.tv_sec * ns_per_s + now.tv_nsec;
  std::optional<unsigned> before;
  for (;;) {
    const std::optional<unsigned> levels = lines.levels();
    if (!levels) return 0;
    if (levels != before) std::printf("%lld %u\n", static_cast<long long>(at_ns), *levels);
    if (levels != before) std::fflush(stdout);
    before = levels;
    at_ns += between_looks_ns;
    const timespec next{.tv_sec = at_ns / ns_per_s, .tv_nsec = at_ns % ns_per_s};
    ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, nullptr);
  }
}
