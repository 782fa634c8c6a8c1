#include "drivers/linux/real_time.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

namespace inbetween {
namespace {

constexpr std::size_t page_bytes = 4096;
/// For what lies between the caller of touch_pages and the end of the stack: its frames, and the guard page.
constexpr std::size_t stack_reserve_bytes = 16 * 1024;

std::string reason_of(int error) {
  return std::strerror(error);
}

/// One page of stack for each call, from the caller's downwards. The write after the call keeps the frames
/// apart.
[[gnu::noinline]] void touch_pages(std::size_t pages) {
  volatile unsigned char page[page_bytes];
  page[0] = 1;
  if (pages > 1) touch_pages(pages - 1);
  page[page_bytes - 1] = page[0];
}

/// The rest of the stack of this thread; 0 if nobody knows.
std::size_t stack_left() {
  pthread_attr_t attributes;
  if (::pthread_getattr_np(::pthread_self(), &attributes) != 0) return 0;
  void* lowest = nullptr;
  std::size_t bytes = 0;
  ::pthread_attr_getstack(&attributes, &lowest, &bytes);
  ::pthread_attr_destroy(&attributes);
  const auto here = reinterpret_cast<std::uintptr_t>(&attributes);
  const auto end = reinterpret_cast<std::uintptr_t>(lowest);
  return here > end ? here - end : 0;
}

/// A number of the kernel's; none where it has no such file.
std::optional<long> kernel_number(const char* path) {
  std::ifstream file(path);
  long number = 0;
  return file >> number ? std::optional<long>(number) : std::nullopt;
}

}  // namespace

RealTimeThread::RealTimeThread(const RealTimeRequest& request) {
  if (request.locks_memory) lock_memory();
  touch_stack(request.stack_bytes, !request.locks_memory || has_locked_memory_);
  if (request.cpu) bind_to(*request.cpu);
  keep_awake();
  take_priority(request.priority);
  look_for_throttling();
}

RealTimeThread::~RealTimeThread() {
  if (policy_before_) {
    sched_param before{};
    before.sched_priority = priority_before_;
    ::sched_setscheduler(0, *policy_before_, &before);
  }
  if (latency_file_ >= 0) ::close(latency_file_);
  if (processors_before_) ::sched_setaffinity(0, sizeof *processors_before_, &*processors_before_);
  if (has_locked_memory_) ::munlockall();
}

bool RealTimeThread::is_fit() const {
  return std::none_of(rights_.begin(), rights_.end(),
                      [](const RealTimeRight& right) { return right.is_needed && right.refusal; });
}

void RealTimeThread::note(const char* name, bool is_needed, std::optional<Refusal> refusal) {
  rights_.push_back({.name = name, .is_needed = is_needed, .refusal = std::move(refusal)});
}

void RealTimeThread::lock_memory() {
  constexpr const char* name = "locked memory";
  has_locked_memory_ = ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  if (has_locked_memory_) return note(name, true, std::nullopt);
  note(name, true,
       Refusal{.what = "memory cannot be locked: " + reason_of(errno),
               .remedy = "run as root, or allow it in /etc/security/limits.d/inbetween.conf with "
                         "\"USER - memlock unlimited\" and log in again"});
}

void RealTimeThread::touch_stack(std::size_t bytes, bool is_memory_locked) {
  constexpr const char* name = "stack in memory";
  const std::size_t left = stack_left();
  if (left < bytes + stack_reserve_bytes) {
    return note(name, true,
                Refusal{.what = "the stack has " + std::to_string(left / 1024) + " KiB left, and " +
                                std::to_string((bytes + stack_reserve_bytes) / 1024) + " are needed",
                        .remedy = "raise the limit with ulimit -s"});
  }
  touch_pages((bytes + page_bytes - 1) / page_bytes);
  // Without the lock the pages may go again.
  if (is_memory_locked) return note(name, true, std::nullopt);
  note(name, true,
       Refusal{.what = "the stack does not stay in memory, for memory cannot be locked",
               .remedy = "what helps for locked memory"});
}

void RealTimeThread::bind_to(int cpu) {
  constexpr const char* name = "processor";
  const auto refuse = [&](const std::string& reason) {
    note(name, true,
         Refusal{.what = "processor " + std::to_string(cpu) + " cannot be taken: " + reason,
                 .remedy = "name one of those that the command nproc --all counts, from 0, and that taskset "
                           "-p $$ allows"});
  };
  if (cpu < 0 || cpu >= CPU_SETSIZE) return refuse("there is none of that number");
  cpu_set_t before;
  cpu_set_t only;
  CPU_ZERO(&only);
  CPU_SET(static_cast<std::size_t>(cpu), &only);
  if (::sched_getaffinity(0, sizeof before, &before) != 0 ||
      ::sched_setaffinity(0, sizeof only, &only) != 0) {
    return refuse(reason_of(errno));
  }
  processors_before_ = before;
  note(name, true, std::nullopt);
}

void RealTimeThread::keep_awake() {
  constexpr const char* name = "no deep sleep of processors";
  constexpr const char* path = "/dev/cpu_dma_latency";
  constexpr std::int32_t max_us = 0;
  latency_file_ = ::open(path, O_WRONLY | O_CLOEXEC);
  if (latency_file_ >= 0 && ::write(latency_file_, &max_us, sizeof max_us) == sizeof max_us) {
    return note(name, false, std::nullopt);
  }
  const int error = errno;
  note(name, false,
       Refusal{.what = std::string(path) + " cannot be held at 0: " + reason_of(error),
               .remedy = error == ENOENT
                             ? "nothing, if this kernel has no idle states; else build it with CPU_IDLE"
                             : "run as root, or give your user the right to write that file"});
}

void RealTimeThread::take_priority(int priority) {
  constexpr const char* name = "SCHED_FIFO priority";
  const int policy = ::sched_getscheduler(0);
  sched_param before{};
  sched_param wanted{};
  wanted.sched_priority = priority;
  if (policy >= 0 && ::sched_getparam(0, &before) == 0 && ::sched_setscheduler(0, SCHED_FIFO, &wanted) == 0) {
    policy_before_ = policy;
    priority_before_ = before.sched_priority;
    return note(name, true, std::nullopt);
  }
  const int error = errno;
  note(name, true,
       Refusal{.what = "the thread cannot be SCHED_FIFO at priority " + std::to_string(priority) + ": " +
                       reason_of(error),
               .remedy = error == EINVAL
                             ? "take a priority from 1 to 99"
                             : "run as root, or allow it in /etc/security/limits.d/inbetween.conf with "
                               "\"USER - rtprio " +
                                   std::to_string(priority) + "\" and log in again"});
}

void RealTimeThread::look_for_throttling() {
  constexpr const char* name = "no throttling of real-time threads";
  const std::optional<long> runtime_us = kernel_number("/proc/sys/kernel/sched_rt_runtime_us");
  const std::optional<long> period_us = kernel_number("/proc/sys/kernel/sched_rt_period_us");
  // A kernel without the file does not throttle.
  const bool is_throttled = runtime_us && *runtime_us >= 0 && (!period_us || *runtime_us < *period_us);
  if (!is_throttled) return note(name, true, std::nullopt);
  note(name, true,
       Refusal{.what = "the kernel gives real-time threads only " + std::to_string(*runtime_us) +
                       " us of every " + (period_us ? std::to_string(*period_us) : "?") + " us",
               .remedy = "as root: sysctl kernel.sched_rt_runtime_us=-1"});
}

}  // namespace inbetween
