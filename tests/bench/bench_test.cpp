// The bench itself: sim/bench/run gives back what a command did in a kernel with CAN and GPIO, and always
// ends.
#include "tests/support/bench.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>
#if defined(__x86_64__)
#include <cpuid.h>
#endif

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace bench_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string bench_run = in_checkout("sim/bench/run");
const std::string in_script = "'" + bench_run + "'";

/// Processes whose arguments hold a text.
int processes_with(std::string_view text) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (std::isdigit(static_cast<unsigned char>(name.front())) == 0) continue;
    if (file_contents((entry.path() / "cmdline").string()).find(text) != std::string::npos) ++count;
  }
  return count;
}

#if defined(__x86_64__)
/// The bytes that the registers of a process take, as the processor says: those of the features that are
/// switched on, or of all that it has.
std::size_t register_bytes() {
  constexpr unsigned extended_state = 0xD;
  unsigned eax = 0;
  unsigned switched_on = 0;
  unsigned all = 0;
  unsigned edx = 0;
  if (__get_cpuid_count(extended_state, 0, &eax, &switched_on, &all, &edx) == 0) return 512;  // FXSAVE's
  return std::max(switched_on, all);
}

TEST(Bench, ItsKernelHasRoomForTheRegistersOfEveryProcessor) {
  const ProgramRun run = run_command(
      {"/bin/bash", "-euc",
       "kernel=$('" + in_checkout("sim/bench/kernel") + "'); cat \"${kernel%/*}/register_buffer_bytes\""});
  ASSERT_EQ(run.status, 0) << run.err;
  const std::size_t room = std::stoul(run.out);
  EXPECT_GE(room, register_bytes()) << "write a larger register_buffer_bytes in sim/bench/kernel";
  // A developer whose processor has fewer registers sees it too.
  constexpr std::size_t with_amx = 11'008;
  EXPECT_GE(room, with_amx);
}
#endif

TEST(Bench, GivesBackOutputErrorAndExitStatus) {
  const ProgramRun run = in_bench({}, {"/bin/sh", "-c", "echo told; echo complained >&2; exit 7"});
  EXPECT_EQ(run.status, 7);
  EXPECT_EQ(run.out, "told\n");
  EXPECT_EQ(run.err, "complained\n");
}

TEST(Bench, EveryByteOfALongOutputArrives) {
  const ProgramRun run =
      in_bench({}, {"/bin/sh", "-c", "head -c 3000000 /dev/zero; printf 'end\\r\\n\\377'"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.out, std::string(3'000'000, '\0') + "end\r\n\xff");
}

TEST(Bench, SaysWhichSignalEndedTheCommand) {
  EXPECT_EQ(in_bench({}, {"/bin/sh", "-c", "kill -KILL $$"}).status, 128 + 9);
}

TEST(Bench, ACommandThatIsNotThereIsToldFromABenchThatIsNot) {
  EXPECT_EQ(in_bench({}, {"/nowhere/at-all"}).status, 127);
}

TEST(Bench, RunsInTheFolderAndWithTheEnvironmentOfItsCaller) {
  const TemporaryFolder folder;
  const std::string script = "cd '" + folder.path().string() + "' && NOTE=\"two words\n and a line\" " +
                             in_script + " -- /bin/sh -c 'pwd; printf \"%s\" \"$NOTE\"; echo kept >beside'";
  const ProgramRun run = run_command({"/bin/bash", "-c", script});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.out, folder.path().string() + "\ntwo words\n and a line");
  EXPECT_EQ(file_contents((folder.path() / "beside").string()), "kept\n");
}

TEST(Bench, TheCommandIsTheFileOfTheHost) {
  const ProgramRun inside = in_bench({}, {in_build("inbetween"), "--help"});
  const ProgramRun outside = run_program({"--help"});
  EXPECT_EQ(inside.status, 0) << inside.err;
  EXPECT_EQ(inside.out, outside.out);
  EXPECT_FALSE(outside.out.empty());
}

TEST(Bench, TheTimeLimitEndsAHungGuestAndAllItsProcesses) {
  const ProgramRun run = in_bench({"--kernel", "--timeout", "12", "--memory", "203"},
                                  {"/bin/sh", "-c", "echo begun; sleep 1000"});
  EXPECT_EQ(run.status, 124);
  EXPECT_EQ(run.out, "begun\n");
  EXPECT_EQ(run.err,
            "sim/bench/run: error: not done after 12 s, the time limit; ended with all that ran in it\n");
  EXPECT_EQ(processes_with("mem=203M"), 0);
}

TEST(Bench, AGuestThatStopsBeforeTheCommandIsAnError) {
  const ProgramRun run =
      in_bench({"--kernel"}, {"/usr/bin/perl", "-e", "syscall(169, 0xfee1dead, 672274793, 0x4321fedc, 0)"});
  EXPECT_EQ(run.status, 125);
  EXPECT_THAT(run.err, HasSubstr("error: the bench ended before the command did"));
}

TEST(Bench, WhoeverKillsTheScriptEndsTheGuest) {
  const TemporaryFolder folder;
  const std::string begun = (folder.path() / "begun").string();
  const std::string script =
      in_script + " --kernel --memory 207 -- /bin/sh -c 'echo $INBETWEEN_BENCH_GPIO >" + begun +
      "; sleep 1000' & pid=$!\n"
      "until [[ -s " +
      begun +
      " ]]; do sleep 0.01; done\n"
      "kill -KILL $pid\n"
      "while grep --quiet --no-messages mem=[2]07M /proc/[0-9]*/cmdline; do sleep 0.01; done\n"
      "rm -r \"$(dirname \"$(<" +
      begun + ")\")\"";
  EXPECT_EQ(run_command({"/usr/bin/timeout", "100", "/bin/bash", "-c", script}).status, 0);
}

TEST(Bench, AskedToEndAgainAndAgainItEndsTheGuestAndTakesItsFilesAway) {
  const TemporaryFolder folder;
  const std::string begun = (folder.path() / "begun").string();
  const std::string script =
      in_script + " --kernel --memory 211 -- /bin/sh -c 'echo $INBETWEEN_BENCH_GPIO >" + begun +
      "; sleep 1000' & pid=$!\n"
      "until [[ -s " +
      begun +
      " ]]; do sleep 0.01; done\n"
      "while kill -TERM $pid 2>/dev/null; do :; done\n"
      "wait $pid; status=$?\n"
      "while grep --quiet --no-messages mem=[2]11M /proc/[0-9]*/cmdline; do sleep 0.01; done\n"
      "[[ -e $(<" +
      begun + ") ]] && echo left; exit $status";
  const ProgramRun run = run_command({"/usr/bin/timeout", "100", "/bin/bash", "-c", script});
  EXPECT_EQ(run.status, 128 + 15);
  EXPECT_EQ(run.out, "");
}

TEST(Bench, OptionsThatMakeNoSenseAreRefused) {
  const auto refused = [](const std::vector<std::string>& options) {
    const ProgramRun run = in_bench(options, {"/bin/true"});
    EXPECT_EQ(run.status, 125);
    return run.err;
  };
  EXPECT_EQ(
      refused({"--vcan", "a name"}),
      "sim/bench/run: error: --vcan a name: an interface has a name of 1 to 15 letters, digits, - and _, a "
      "letter first\n");
  EXPECT_EQ(refused({"--gpio", "io"}), "sim/bench/run: error: --gpio io: write LABEL:LINES, such as io:8\n");
  EXPECT_EQ(refused({"--name", "io:FOCUS"}),
            "sim/bench/run: error: --name io:FOCUS: write LABEL:LINE:NAME, such as io:3:lamp\n");
  EXPECT_EQ(refused({"--disk", "/dev/null"}),
            "sim/bench/run: error: --disk /dev/null: it is no file that can be read and written\n");
  EXPECT_EQ(refused({"--disk", bench_run, "--disk", bench_run}),
            "sim/bench/run: error: --disk " + bench_run + ": the bench has one disk, and that is " +
                bench_run + "\n");
  const TemporaryFile empty("disk", "");
  EXPECT_EQ(refused({"--disk", empty.path()}),
            "sim/bench/run: error: --disk " + empty.path().string() +
                ": it is empty; make it as long as the disk, such as with truncate --size=16M\n");
  EXPECT_EQ(refused({"--timeout", "0"}),
            "sim/bench/run: error: --timeout 0: write a whole number from 1 to 604800\n");
  EXPECT_EQ(refused({"--frobnicate"}), "sim/bench/run: error: unknown option '--frobnicate'; see --help\n");
  EXPECT_EQ(run_command({bench_run, "--vcan"}).err,
            "sim/bench/run: error: --vcan needs a value; see --help\n");
  EXPECT_EQ(run_command({bench_run}).err, "sim/bench/run: error: no command is given; see --help\n");
}

TEST(Bench, HelpNamesEveryOptionThatTheScriptKnows) {
  const ProgramRun help = run_command({bench_run, "--help"});
  EXPECT_EQ(help.status, 0);
  std::istringstream lines(file_contents(bench_run));
  int options = 0;
  for (std::string line; std::getline(lines, line);) {
    // The branches of the option loop: four blanks, the option, a bracket.
    const std::size_t bracket = line.find(')');
    if (line.rfind("    --", 0) != 0 || bracket == std::string::npos || bracket < 7) continue;
    const std::string option = line.substr(4, line.find_first_of(" |)", 4) - 4);
    if (option == "--") continue;
    EXPECT_THAT(help.out, HasSubstr(option));
    ++options;
  }
  EXPECT_GE(options, 10);
}

TEST(Bench, FramesGoFromProgramToProgramOnVcan) {
  // An interface that nobody listens to stands in the kernel's list too, in brackets.
  const ProgramRun run = script_in_bench({"--vcan", "can0", "--vcan", "can1"}, R"(
    told=$(mktemp)
    candump -L -n 1 can1 >$told & listener=$!
    until_true grep --quiet '^ *can1 ' /proc/net/can/rcvlist_all
    cansend can0 111#00     # the other bus
    cansend can1 123#DEADBEEF
    wait $listener
    cut -d' ' -f2- $told
    rm $told)");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.out, "can1 123#DEADBEEF\n");
}

TEST(Bench, ALinkThatGoesDownOrAwayIsSeen) {
  const ProgramRun run = script_in_bench({"--vcan", "can0"}, R"(
    ip link set can0 down
    cansend can0 123#00 && echo sent
    ip link set can0 up
    cansend can0 123#00 && echo sent
    ip link del can0
    cansend can0 123#00 && echo sent
    true)");
  EXPECT_EQ(run.out, "sent\n");
  EXPECT_THAT(run.err, HasSubstr("write: Network is down"));
  EXPECT_THAT(run.err, HasSubstr("No such device"));
}

TEST(Bench, AFullQueueRefusesFrames) {
  const ProgramRun run = script_in_bench({"--vcan", "can0", "--echo"}, R"(
    tc qdisc add dev can0 root netem delay 100s limit 10
    for frame in 1 2 3 4 5 6 7 8 9 10; do cansend can0 123#00; done
    cansend can0 123#00)");
  EXPECT_NE(run.status, 0);
  EXPECT_THAT(run.err, HasSubstr("No buffer space available"));
}

TEST(Bench, LinesOfAGpioChipAreDrivenAndRead) {
  const ProgramRun run = script_in_bench({"--gpio", "lines:8", "--gpio", "more:3"}, R"(
    gpiodetect | sed 's/^[^ ]* //'
    io=$INBETWEEN_BENCH_GPIO/lines
    chip=$(basename $(readlink $io))
    gpioset --chip $chip 3=1 & setter=$!
    until_true grep --quiet 1 $io/sim_gpio3/value
    kill $setter
    echo pull-up >$io/sim_gpio5/pull
    gpioget --numeric --chip $chip 4 5)");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("[lines] (8 lines)\n"));
  EXPECT_THAT(run.out, HasSubstr("[more] (3 lines)\n"));
  EXPECT_THAT(run.out, HasSubstr("\n0 1\n"));
}

TEST(Bench, AHoggedLineIsBusyAndNamesItsConsumer) {
  const ProgramRun run = script_in_bench({"--gpio", "busy:4", "--hog", "busy:2:lamp"}, R"(
    chip=$(basename $(readlink $INBETWEEN_BENCH_GPIO/busy))
    gpioinfo --chip $chip | grep 'line *2:'
    gpioset --chip $chip 2=1)");
  EXPECT_NE(run.status, 0);
  EXPECT_THAT(run.out, HasSubstr("lamp"));
  EXPECT_THAT(run.err, HasSubstr("Device or resource busy"));
}

TEST(Bench, ALineHasTheNameThatItIsGivenAndMayBeBusyAsWell) {
  const ProgramRun run = script_in_bench(
      {"--gpio", "named:4", "--name", "named:1:FOCUS", "--name", "named:3:LAMP", "--hog", "named:3:switch"},
      "gpioget --numeric FOCUS; gpioinfo LAMP");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("0\n"));
  EXPECT_THAT(run.out, HasSubstr("switch"));
}

TEST(Bench, AnEdgeOfALineIsHeard) {
  const ProgramRun run = script_in_bench({"--gpio", "edges:4"}, R"(
    io=$INBETWEEN_BENCH_GPIO/edges
    gpiomon --num-events 1 --format '%o %E' --chip $(basename $(readlink $io)) 2 & listener=$!
    listens() { gpioinfo | grep --quiet gpiomon; }
    until_true listens
    echo pull-up >$io/sim_gpio2/pull
    wait $listener)");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.out, "2 rising\n");
}

TEST(Bench, OnVirtualTimeAnHourOfWaitingPassesAtOnce) {
  const ProgramRun run = script_in_bench({"--virtual-time"}, R"(
    read -r before _ </proc/uptime
    sleep 3600
    read -r after _ </proc/uptime
    echo $((${after%.*} - ${before%.*})))");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.out, "3600\n");
}

// The bench kernel is a host that has everything, and from which the namespaces can be looked at.
TEST(Bench, OnAHostWithCanAndGpioItNeedsNoKernelOfItsOwn) {
  const ProgramRun run = script_in_bench(
      {"--kernel"}, in_script + R"( --vcan can5 --gpio io:2 --hog io:1:lamp -- /bin/bash -euc '
      echo $INBETWEEN_IN_BENCH
      ip -brief link show type vcan | cut -d" " -f1
      gpioinfo | grep -c lamp
      echo pull-up >$INBETWEEN_BENCH_GPIO/io/sim_gpio0/pull
      gpioget --numeric --chip $(basename $(readlink $INBETWEEN_BENCH_GPIO/io)) 0
      exit 3' || echo status $?
    ip -brief link show type vcan
    ls /sys/kernel/config/gpio-sim)");
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.out, "host\ncan5\n1\n1\nstatus 3\n");
}

TEST(Bench, TheTimeLimitHoldsOnAHostToo) {
  const ProgramRun run = script_in_bench({"--kernel", "--timeout", "60"},
                                         in_script + R"( --host --timeout 1 -- sleep 1000 || echo status $?
    pgrep -c sleep || true)");
  EXPECT_EQ(run.out, "status 124\n0\n");
}

TEST(Bench, InsideItRefusesToStartAnotherKernel) {
  const ProgramRun run = script_in_bench({"--kernel"}, in_script + " -- true");
  EXPECT_EQ(run.status, 125);
  EXPECT_EQ(
      run.err,
      "sim/bench/run: error: this is the bench kernel already, and there is none inside it; use --host\n");
}

TEST(Bench, AHostWithoutWhatIsAskedForIsNamed) {
  const ProgramRun run = script_in_bench({"--kernel"}, in_script + " --host --virtual-time -- true");
  EXPECT_EQ(run.status, 125);
  EXPECT_EQ(run.err, "sim/bench/run: error: --host is not possible: --virtual-time needs the bench kernel\n");
}

// As in containers: its default is 64 MB of shared memory, from which nothing may be executed.
TEST(Bench, NeedsNoSharedMemoryOfTheHost) {
  for (const std::string options : {"size=16m", "size=16m,noexec", "size=400m,noexec"}) {
    const std::string script = "mount -t tmpfs -o " + options + " none /dev/shm || exit 77\n" + in_script +
                               " --kernel -- /usr/bin/perl -e 'print length(\"x\" x 100000000)'";
    const ProgramRun run = run_command({"/usr/bin/unshare", "--mount", "/bin/bash", "-c", script});
    if (run.err.find("unshare") != std::string::npos || run.status == 77)
      GTEST_SKIP() << "nobody may mount here";
    EXPECT_EQ(run.status, 0) << options << ": " << run.err;
    EXPECT_EQ(run.out, "100000000") << options;
  }
}

/// A bench and its kernel where somebody without rights can read them, wherever the checkout is.
class BenchOfAnOrdinaryUser : public ::testing::Test {
 protected:
  static constexpr const char* nobody = "65534";

  void SetUp() override {
    if (::geteuid() != 0) GTEST_SKIP() << "every other test here is this test already";
    const std::string script = "cd '" + folder_.path().string() + "'; kernel=$('" +
                               in_checkout("sim/bench/kernel") + "'); cp -r \"${kernel%/*}\" . ; cp -r '" +
                               in_checkout("sim/bench") + "' bench; chmod -R a+rX .";
    ASSERT_EQ(run_command({"/bin/bash", "-euc", script}).status, 0);
    ::setenv("INBETWEEN_BENCH_CACHE", folder_.path().c_str(), 1);
  }
  void TearDown() override { ::unsetenv("INBETWEEN_BENCH_CACHE"); }

  std::vector<std::string> bench_of_nobody(const std::vector<std::string>& arguments) {
    const std::string folder = folder_.path().string();
    std::vector<std::string> words = {"/usr/bin/env", "--chdir=" + folder,
                                      "setpriv",      "--reuid",
                                      nobody,         "--regid",
                                      nobody,         "--clear-groups",
                                      "--",           folder + "/bench/run"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return words;
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(BenchOfAnOrdinaryUser, HasEverythingThatRootHas) {
  const ProgramRun run = run_command(
      bench_of_nobody({"--vcan", "can0", "--gpio", "io:2", "--", "/bin/bash", "-euc",
                       "id -u; cansend can0 123#00; gpioget --numeric --chip gpiochip0 0; chrt -f 80 true"}));
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.out, "0\n0\n");
}

}  // namespace bench_test
}  // namespace inbetween
