#include "drivers/linux/real_time.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <string>
#include <thread>

#include "tests/bench/inside/raw_bus.hpp"

namespace inbetween {
namespace real_time_test {

using ::testing::HasSubstr;

/// "name: what; remedy", a line for each refusal.
std::string refusals(const RealTimeThread& thread) {
  std::string text;
  for (const RealTimeRight& right : thread.rights()) {
    if (!right.refusal) continue;
    text += std::string(right.name) + (right.is_needed ? ": " : " (not needed): ") + right.refusal->what +
            "; " + right.refusal->remedy + "\n";
  }
  return text;
}

/// A line of /proc/self/status, such as "VmLck".
std::string status_line(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind(key + ":", 0) == 0) return line.substr(line.find_first_not_of(" \t", key.size() + 1));
  }
  return "";
}

long minor_faults() {
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt;
}

[[gnu::noinline]] int use_stack(int pages) {
  volatile char page[4096];
  page[0] = static_cast<char>(pages);
  const int deeper = pages > 1 ? use_stack(pages - 1) : 0;
  return deeper + page[0];
}

void give_real_time_threads(const char* us) {
  std::ofstream("/proc/sys/kernel/sched_rt_runtime_us") << us;
}

TEST(RealTimeThread, RootObtainsAllThatTheLoopNeedsAndGivesItBack) {
  give_real_time_threads("-1");
  EXPECT_EQ(::sched_getscheduler(0), SCHED_OTHER);
  {
    const RealTimeThread thread({.priority = 71, .cpu = 0, .stack_bytes = 64 * 1024});
    EXPECT_TRUE(thread.is_fit()) << refusals(thread);
    EXPECT_EQ(thread.rights().size(), 6U);
    sched_param now{};
    ::sched_getparam(0, &now);
    EXPECT_EQ(::sched_getscheduler(0), SCHED_FIFO);
    EXPECT_EQ(now.sched_priority, 71);
    EXPECT_EQ(status_line("Cpus_allowed_list"), "0");
    EXPECT_NE(status_line("VmLck"), "0 kB");
  }
  EXPECT_EQ(::sched_getscheduler(0), SCHED_OTHER);
  EXPECT_EQ(status_line("VmLck"), "0 kB");
}

TEST(RealTimeThread, ASecondOneLeavesTheMemoryLockedThatTheFirstHasLocked) {
  give_real_time_threads("-1");
  const RealTimeThread first({});
  std::thread([] {
    const RealTimeThread second({.priority = 85, .locks_memory = false});
    EXPECT_TRUE(second.is_fit()) << refusals(second);
    EXPECT_EQ(second.rights().size(), 4U) << "neither a processor nor locked memory";
  }).join();
  EXPECT_NE(status_line("VmLck"), "0 kB");
}

TEST(RealTimeThread, TheStackThatWasAskedForTakesNoPageFault) {
  constexpr int pages = 200;
  const RealTimeThread thread({.stack_bytes = (pages + 20) * 4096});
  const long before = minor_faults();
  EXPECT_NE(use_stack(pages), 0);
  EXPECT_EQ(minor_faults() - before, 0);
}

TEST(RealTimeThread, MemoryThatIsTakenLaterIsThereAtOnce) {
  constexpr std::size_t pages = 64;
  const RealTimeThread thread({});
  void* const memory =
      ::mmap(nullptr, pages * 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  // Not by page faults: the bench kernel counts one for the first touch of a page that is there.
  std::array<unsigned char, pages> is_there{};
  ASSERT_EQ(::mincore(memory, pages * 4096, is_there.data()), 0);
  EXPECT_THAT(is_there, ::testing::Each(1));
  ::munmap(memory, pages * 4096);
}

TEST(RealTimeThread, ThrottlingByTheKernelIsNamed) {
  give_real_time_threads("950000");
  const RealTimeThread thread({});
  EXPECT_FALSE(thread.is_fit());
  EXPECT_THAT(refusals(thread), HasSubstr("only 950000 us of every 1000000 us; as root: sysctl "
                                          "kernel.sched_rt_runtime_us=-1"));
  EXPECT_EQ(::sched_getscheduler(0), SCHED_FIFO) << "what can be had is taken";
}

TEST(RealTimeThread, WithoutIdleStatesThereIsNothingToHoldAndTheLoopIsFitAllTheSame) {
  give_real_time_threads("-1");
  const RealTimeThread thread({});
  EXPECT_TRUE(thread.is_fit());
  EXPECT_THAT(refusals(thread), HasSubstr("(not needed): /dev/cpu_dma_latency cannot be held at 0"));
}

TEST(RealTimeThread, RequestsThatCannotBeAreRefused) {
  give_real_time_threads("-1");
  {
    const RealTimeThread thread({.priority = 100});
    EXPECT_FALSE(thread.is_fit());
    EXPECT_THAT(refusals(thread), HasSubstr("priority 100: Invalid argument; take a priority from 1 to 99"));
  }
  for (const int none : {1, 100'000, -1}) {
    const RealTimeThread thread({.cpu = none});
    EXPECT_FALSE(thread.is_fit());
    EXPECT_THAT(refusals(thread), HasSubstr("processor " + std::to_string(none) + " cannot be taken"));
  }
  const RealTimeThread thread({.stack_bytes = std::size_t{1} << 30});
  EXPECT_FALSE(thread.is_fit());
  EXPECT_THAT(refusals(thread), HasSubstr("and 1048592 are needed; raise the limit with ulimit -s"));
}

TEST(RealTimeThread, AnOrdinaryUserIsToldWhichRightsAreMissingAndHowToGetThem) {
  give_real_time_threads("-1");
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const rlimit none{.rlim_cur = 0, .rlim_max = 0};
    if (::setrlimit(RLIMIT_MEMLOCK, &none) != 0 || ::setrlimit(RLIMIT_RTPRIO, &none) != 0 ||
        ::setresuid(65534, 65534, 65534) != 0) {
      ::_exit(1);
    }
    const RealTimeThread thread({.priority = 80});
    const std::string text = (thread.is_fit() ? "fit\n" : "not fit\n") + refusals(thread);
    ::_exit(::write(pipe[1], text.data(), text.size()) > 0 ? 0 : 1);
  }
  ::close(pipe[1]);
  std::string text;
  std::array<char, 512> part{};
  for (ssize_t count = 0; (count = ::read(pipe[0], part.data(), part.size())) > 0;) {
    text.append(part.data(), static_cast<std::size_t>(count));
  }
  ::close(pipe[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_THAT(text, HasSubstr("not fit\n"));
  EXPECT_THAT(text, HasSubstr("locked memory: memory cannot be locked: "));
  EXPECT_THAT(text, HasSubstr("\"USER - memlock unlimited\""));
  EXPECT_THAT(text,
              HasSubstr("SCHED_FIFO priority: the thread cannot be SCHED_FIFO at priority 80: Operation not "
                        "permitted; run as root"));
  EXPECT_THAT(text, HasSubstr("\"USER - rtprio 80\""));
}

}  // namespace real_time_test
}  // namespace inbetween
