// The simulated drives of a rig on the buses of the bench, in a process of their own.
#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

#include "drivers/linux/interrupt_watch.hpp"
#include "host_tools/motions/sim_drives.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

/// The drives of the rig, for as long as this lives. They have power when it is made.
class DrivesProcess {
 public:
  explicit DrivesProcess(const RigFile& rig) {
    std::array<int, 2> ready{};
    if (::pipe(ready.data()) != 0) std::abort();
    child_ = ::fork();
    if (child_ == 0) {
      const InterruptWatch watch;
      run_sim_drives(rig, {.interrupted = &InterruptWatch::asked, .ready = [&] {
                             if (::write(ready[1], "!", 1) != 1) ::_exit(1);
                           }});
      ::_exit(0);
    }
    ::close(ready[1]);
    char byte = 0;
    if (::read(ready[0], &byte, 1) != 1) std::abort();
    ::close(ready[0]);
  }
  ~DrivesProcess() {
    ::kill(child_, SIGTERM);
    ::waitpid(child_, nullptr, 0);
  }
  DrivesProcess(const DrivesProcess&) = delete;
  DrivesProcess& operator=(const DrivesProcess&) = delete;

 private:
  pid_t child_ = -1;
};

}  // namespace inbetween
