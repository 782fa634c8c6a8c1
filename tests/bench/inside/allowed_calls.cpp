#include "tests/bench/inside/allowed_calls.hpp"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstddef>
#include <cstring>

namespace inbetween {
namespace {

constexpr int could_not_filter = 99;

bool allow_only(std::vector<unsigned> allowed) {
  allowed.push_back(SYS_clock_gettime);
  allowed.push_back(SYS_exit_group);  // how the child tells that it has come to its end
  std::vector<sock_filter> program;
  program.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)));
  for (const unsigned call : allowed) {
    program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 1));
    program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  }
  program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS));
  const sock_fprog filter{.len = static_cast<unsigned short>(program.size()), .filter = program.data()};
  return ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         ::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

}  // namespace

std::string only_loop_calls(const std::function<void()>& prepare, const std::function<void()>& loop,
                            const std::vector<unsigned>& calls) {
  const pid_t child = ::fork();
  if (child < 0) return "no child process";
  if (child == 0) {
    prepare();
    if (!allow_only(calls)) ::_exit(could_not_filter);
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
