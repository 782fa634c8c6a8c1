// The doctor on a kernel with CAN and GPIO, where mistakes have been prepared.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tests/support/bench.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string rig = pan_and_tilt_text(R"([emergency_stop]
chip = "head"
line = 3
stops_at = "low"
)");

/// In the folder with rig.toml; what the doctor says is in the standard output.
ProgramRun doctor(const std::string& script, const std::string& faults = "",
                  const std::vector<std::string>& more = {}) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "rig.toml") << rig;
  std::ofstream(folder.path() / "faults.toml") << faults;
  std::vector<std::string> options{"--vcan", "can0", "--gpio", "head:8", "--virtual-time", "--timeout", "40"};
  options.insert(options.end(), more.begin(), more.end());
  return script_in_bench(options, "cd '" + folder.path().string() +
                                      "'\necho -1 >/proc/sys/kernel/sched_rt_runtime_us\n" + script);
}
const std::string with_drives =
    "inbetween sim-drives --rig rig.toml $faults 2>drives.txt & drives=$!\n"
    "until_true grep -q power drives.txt\nstatus=0\n"
    "inbetween doctor --rig rig.toml --drives --seconds 0.2 || status=$?\n"
    "kill -TERM $drives; wait $drives; exit $status";

TEST(DoctorScene, ARigThatIsFitHasNoProblem) {
  const ProgramRun run = doctor("faults=\n" + with_drives);
  EXPECT_EQ(run.status, 0) << run.out << run.err;
  EXPECT_THAT(run.out,
              AllOf(Not(HasSubstr("problem")), HasSubstr("fine     bus can0: up, and virtual"),
                    HasSubstr("axis \"pan\": node 1 has mode 8"), HasSubstr("axis \"tilt\": node 2 has")));
}

TEST(DoctorScene, ADriveWithoutAWatchdogIsNamedAndTheOtherIsFine) {
  const ProgramRun run = doctor("faults='--faults faults.toml'\n" + with_drives,
                                "[[fault]]\naxis = \"tilt\"\nwhat = \"no-watchdog\"\n");
  EXPECT_EQ(run.status, 4) << run.err;
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("fine     axis \"pan\""),
                    HasSubstr("problem  axis \"tilt\": the drive would run on if this program died")));
}

TEST(DoctorScene, MistakesOfTheMachineAreNamedWithTheirRemedies) {
  const ProgramRun run = doctor(
      "ip link set can0 txqueuelen 4\necho 950000 >/proc/sys/kernel/sched_rt_runtime_us\n"
      "inbetween doctor --rig rig.toml --drives --seconds 0.1 || true\n"
      "ip link set can0 down\ninbetween doctor --rig rig.toml --seconds 0 || true\n"
      "setpriv --reuid 65534 --clear-groups --bounding-set=-all inbetween doctor --seconds 0",
      "", {"--hog", "head:3:somebody"});
  EXPECT_EQ(run.status, 4) << run.out << run.err;
  EXPECT_THAT(
      run.out,
      AllOf(
          HasSubstr(
              "problem  no throttling of real-time threads: the kernel gives real-time threads only 950000"),
          HasSubstr("problem  bus can0: holds 4 frames to be sent, and a tick has 5; as root: ip link "
                    "set can0 txqueuelen 10"),
          HasSubstr("problem  bus can0: is down; as root: ip link set can0 up\n"), HasSubstr("somebody"),
          HasSubstr("problem  SCHED_FIFO priority: the thread cannot be SCHED_FIFO")));
  EXPECT_THAT(run.out, Not(HasSubstr("axis"))) << "with a problem before, no drive is spoken to";
}

}  // namespace
}  // namespace inbetween
