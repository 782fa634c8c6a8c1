// The doctor on a kernel with CAN and GPIO, where mistakes have been prepared.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/support/bench.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace doctor_scene_test {

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
  std::vector<std::string> options{"--vcan", "can0", "--gpio", "head:8", "--virtual-time"};
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

/// What somebody has got wrong, and what the doctor says of it with its remedy.
struct Mistake {
  const char* name;
  const char* script;
  const char* words;
};
const std::vector<Mistake> mistakes{
    {"the interface is down", "ip link set can0 down; look rig.toml; ip link set can0 up",
     "problem  bus can0: is down; as root: ip link set can0 up\n"},
    {"the queue is too short",
     "ip link set can0 txqueuelen 4; look rig.toml --drives; ip link set can0 txqueuelen 64",
     "problem  bus can0: holds 4 frames to be sent, and a tick has 5; as root: ip link set can0 txqueuelen "
     "10"},
    {"real-time threads are throttled",
     "echo 950000 >/proc/sys/kernel/sched_rt_runtime_us; look rig.toml; echo -1 "
     ">/proc/sys/kernel/sched_rt_runtime_us",
     "problem  no throttling of real-time threads: the kernel gives real-time threads only 950000"},
    {"there are no rights",
     "setpriv --reuid 65534 --clear-groups --bounding-set=-all inbetween doctor --seconds 0 || true",
     "problem  SCHED_FIFO priority: the thread cannot be SCHED_FIFO"},
    {"a drive is missing", "drives pan.toml; look rig.toml --drives; no_drives",
     "problem  axis \"tilt\": no boot-up message came from the drive; look at"},
    {"a watchdog is off", "drives rig.toml --faults watchdog.toml; look rig.toml --drives; no_drives",
     "problem  axis \"tilt\": the drive would run on if this program died (object 1016h:1"},
    {"60C2 is wrong", "drives rig.toml --faults period.toml; look rig.toml --drives; no_drives",
     "60C2h:1 is 20 (14h), not 4 (4h)"},
    {"a node id is there twice", "drives rig.toml; drives pan.toml; look rig.toml --drives; no_drives",
     "problem  axis \"pan\": two devices answer as node 1; give each device of the bus a node number of its "
     "own"},
    {"the load is too high", "look slow.toml", "may be used; lower rate_hz, or spread them over more buses"},
    {"a line is busy", "look busy.toml", "somebody"},
};

// The bitrate of a file that is not that of the interface needs an interface that has one, and a virtual one
// has none: Doctor.EveryMistakeOfABusIsNamedWithItsRemedy.
TEST(DoctorScene, TenPreparedMistakesAreNamedEachWithItsRemedy) {
  const TemporaryFolder folder;
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(folder.path() / name) << text;
  };
  write("rig.toml", pan_and_tilt_text());
  write("busy.toml", rig);
  write("pan.toml",
        rig_text({{.name = "pan", .unit = "deg", .more = "unpowered = \"holds\"", .drive = cia402_text(1)}},
                 {.rate_hz = 250, .more = bus_can0}));
  std::string slow = pan_and_tilt_text();
  slow.replace(slow.find("bitrate = 1000000"), 17, "bitrate = 100000");
  write("slow.toml", slow);
  write("watchdog.toml", "[[fault]]\naxis = \"tilt\"\nwhat = \"no-watchdog\"\n");
  write("period.toml",
        "[[fault]]\naxis = \"tilt\"\nwhat = \"fixed-object\"\nobject = 0x60C2\nsub = 1\nvalue = 20\n");
  std::string script = "cd '" + folder.path().string() +
                       "'\necho -1 >/proc/sys/kernel/sched_rt_runtime_us\n"
                       "look() { inbetween doctor --seconds 0 --rig \"$@\" || true; }\n"
                       "drives() { : >drives.txt; inbetween sim-drives --rig \"$@\" 2>drives.txt & "
                       "until_true grep -q power drives.txt; }\n"
                       "no_drives() { kill -TERM $(jobs -p); wait || true; }\n";
  for (const Mistake& mistake : mistakes)
    script += fmt::format("echo '== {}'\n{}\n", mistake.name, mistake.script);
  const ProgramRun run =
      script_in_bench({"--vcan", "can0", "--gpio", "head:8", "--hog", "head:3:somebody", "--virtual-time"},
                      script + "echo '== end'\n");
  EXPECT_EQ(run.status, 0) << run.out << run.err;
  for (std::size_t i = 0; i < mistakes.size(); ++i) {
    const std::size_t begin = run.out.find(fmt::format("== {}\n", mistakes[i].name));
    ASSERT_NE(begin, std::string::npos) << mistakes[i].name << run.out;
    const std::string said = run.out.substr(begin, run.out.find("\n== ", begin) - begin + 1);
    EXPECT_THAT(said, AllOf(HasSubstr(mistakes[i].words), HasSubstr("\nproblem  "))) << mistakes[i].name;
    if (mistakes[i].name == std::string("the queue is too short")) {
      EXPECT_THAT(said, Not(HasSubstr("axis"))) << "with a problem before, no drive is spoken to";
    }
  }
}

}  // namespace doctor_scene_test
}  // namespace inbetween
