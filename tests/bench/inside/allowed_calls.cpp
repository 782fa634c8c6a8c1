#include "tests/bench/inside/allowed_calls.hpp"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstring>

namespace inbetween {
namespace {

constexpr int could_not_filter = 99;

/// exit_group is how the child tells that it has come to its end.
constexpr std::array<unsigned, 5> allowed = {SYS_clock_nanosleep, SYS_sendmmsg, SYS_recvmmsg,
                                             SYS_clock_gettime, SYS_exit_group};

bool allow_loop_calls_only() {
  std::array<sock_filter, 2 * allowed.size() + 2> program{};
  std::size_t length = 0;
  program[length++] = BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr));
  for (const unsigned call : allowed) {
    program[length++] = BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 1);
    program[length++] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  }
  program[length++] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS);
  const sock_fprog filter{.len = static_cast<unsigned short>(length), .filter = program.data()};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

}  // namespace

std::string only_loop_calls(const std::function<void()>& prepare, const std::function<void()>& loop) {
  const pid_t child = ::fork();
  if (child < 0) return "no child process";
  if (child == 0) {
    prepare();
    if (!allow_loop_calls_only()) ::_exit(could_not_filter);
    loop();
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFSIGNALED(status)) return ::strsignal(WTERMSIG(status));
  if (WEXITSTATUS(status) == could_not_filter) return "the kernel takes no filter of system calls";
  return WEXITSTATUS(status) == 0 ? "" : "exit status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace inbetween
