// Every way in which a program that moves drives can end, one after the other in one bench: what the drives
// recorded of it, and whether the next start succeeds on the same drives. INBETWEEN_ENDINGS=200 makes so many
// instead of one of each kind.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/bench.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace can_ending_test {

const std::string rig = rig_text({axis_text("slide", "mm", {-10, 200}, {.velocity = 200, .acceleration = 800},
                                            "unpowered = \"holds\"\nreference = \"drive\"", cia402_text(1)),
                                  axis_text("pan", "deg", {-90, 90}, {.velocity = 100, .acceleration = 400},
                                            "unpowered = \"holds\"\nreference = \"drive\"", cia402_text(2))},
                                 {.name = "two", .rate_hz = 250, .more = bus_can0});
constexpr std::string_view move = R"(name = "nod"
fps = 24
frames = 36
[[track]]
axes = ["slide", "pan"]
keys = [ { at = [0, 0] }, { at = [40, 20] } ]
speed = [0, 0, 10, 10, 0, 0]
)";

/// A kind of end: the bash that brings it about, where $run is the command that plays the move. The move
/// begins 1.3 s after the start and lasts 1.5 s.
struct Ending {
  std::string name;
  std::string how;
  int status;
  std::string faults = {};           ///< of the drives
  std::set<std::string> codes = {};  ///< the emergencies that belong to it
  std::string stays = {};            ///< the axis that it leaves to its own watchdogs
  bool drops = false;                ///< it is a drive that loses its power in motion
};

std::string fault(std::string_view what, std::string_view more) {
  return fmt::format("[[fault]]\naxis = \"pan\"\nwhat = \"{}\"\nafter_motion = 0.5\n{}\n", what, more);
}

/// Counts/s (3 mm/s, 3 deg/s) of a motor whose demand has come to rest. The simulated motor is behind a ramp
/// of `a` by at most a / (e omega): 800 mm/s^2 at 30 Hz are 1.6 mm/s, and the ramp ends within a tick, which
/// is another 0.8 mm/s.
constexpr double max_settling_speed = 3000;

/// Everything that a drive reports when it misses SYNC, setpoints or the host's heartbeat.
const std::set<std::string> missing{"8100", "8130", "8250"};

const std::vector<Ending>& endings() {
  const auto killed = [](const char* signal, const char* after) {
    return fmt::format("$run & sleep {}; kill -{} $!; wait $!", after, signal);
  };
  const auto typed = [](const char* keys, const char* command) {
    return fmt::format("({}) | script -qec \"{}; exit \\$?\" /dev/null", keys, command);
  };
  static const std::vector<Ending> all{
      {"finished", "$run", 0},
      {"Ctrl-C", killed("INT", "2"), 4},
      {"SIGTERM", killed("TERM", "2"), 4},
      {"SIGHUP", killed("HUP", "2"), 4},
      {"Ctrl-C during the set-up", killed("INT", "0.5"), 4},
      {"Esc, then q", typed("sleep 2; printf '\\033'; sleep 1; printf q; sleep 1", "$run"), 4},
      {"q", typed("sleep 2; printf q; sleep 1", "$run"), 4},
      {"lost terminal",
       "rm -f end.json; script -qec \"exec $run --json end.json\" /dev/null <hold & sleep 2; kill -KILL $!; "
       "until_true test -s end.json; grep -q '\"stopped\"' end.json && exit 4",
       4},
      {"e-stop", "$run & sleep 2; kill -USR1 $!; wait $!", 4, "", missing},
      {"fault of one axis", "$run", 4, fault("emergency", "code = 0x2310\nfor = 0.5"), {"2310"}},
      {"an axis that sticks", "$run", 4, fault("stick", "for = 0.5"), {"8611"}},
      {"a drive that starts anew", "$run", 4, fault("reboot", ""), {}, "", true},
      {"a heartbeat that stops", "$run", 4, fault("lose-heartbeat", "for = 0.5")},
      {"a drive that does not switch off", "$run", 4, fault("stay-on", ""), missing, "pan"},
      {"a refused start", "inbetween goto slide=10 --rig rig.toml --yes; ${run% --yes}", 1},
      {"goto", "inbetween goto slide=10 --rig rig.toml --yes", 0},
      {"goto, stopped", "inbetween goto slide=60 --rig rig.toml --yes & sleep 2; kill -INT $!; wait $!", 4},
      {"jog", typed("sleep 2; printf q; sleep 1", "inbetween jog slide --rig rig.toml"), 0},
      {"killed", killed("KILL", "2"), 128 + 9, "", missing},
  };
  return all;
}

/// Round `number`: drives, the end, a second in which drives would complain, and the next start on the same
/// drives.
std::string script_of(std::size_t number, const Ending& ending) {
  const std::string drives =
      "inbetween sim-drives --rig rig.toml --record record" + std::to_string(number) +
      (ending.faults.empty() ? "" : " --faults faults" + std::to_string(number) + ".toml");
  return fmt::format(
      "{} 2>power & drives=$!\nuntil_true grep -q power power\n"
      "status=0; ({}) >said{} 2>&1 </dev/null || status=$?\nsleep 1\n"
      "next=0; $run >next{} 2>&1 || next=$?\nsleep 1\n"
      "kill -TERM $drives; wait $drives; echo round {} $status $next\n",
      drives, ending.how, number, number, number);
}

struct Round {
  int status = -1;
  int next = -1;
};

class CanEnding : public testing::Test {
 protected:
  TemporaryFolder folder;

  void write(const std::string& name, std::string_view text) const {
    std::ofstream(folder.path() / name) << text;
  }
  [[nodiscard]] std::string read(const std::string& name) const {
    return file_contents((folder.path() / name).string());
  }

  std::map<std::size_t, Round> play(std::size_t rounds) const {
    write("rig.toml", rig);
    write("move.toml", move);
    std::string script = "echo -1 >/proc/sys/kernel/sched_rt_runtime_us\ncd " + folder.path().string() +
                         "\nset +e\nexport run=\"inbetween run move.toml --rig rig.toml --yes\"\n"
                         "mkfifo hold; sleep 100000 >hold & export -f until_true\n";
    for (std::size_t round = 0; round < rounds; ++round) {
      const Ending& ending = endings()[round % endings().size()];
      write("faults" + std::to_string(round) + ".toml", ending.faults);
      script += script_of(round, ending);
    }
    const std::string seconds = std::to_string(1000 + 30 * rounds);
    const ProgramRun all =
        script_in_bench({"--vcan", "can0", "--virtual-time", "--timeout", seconds}, script + "exit 0\n");
    EXPECT_EQ(all.status, 0) << all.err;
    std::map<std::size_t, Round> ended;
    std::istringstream lines(all.out);
    std::size_t number = 0;
    for (std::string word; lines >> word;) {
      if (word != "round") continue;
      Round round;
      lines >> number >> round.status >> round.next;
      ended[number] = round;
    }
    return ended;
  }

  /// What the drives recorded: nobody fell, nobody was left with power, nobody complained of what is not
  /// there.
  void expect_record(std::size_t number, const Ending& ending) const {
    std::istringstream lines(read("record" + std::to_string(number)));
    std::set<std::string> ended;
    for (std::string line; std::getline(lines, line);) {
      std::vector<std::string> cells;
      std::istringstream text(line);
      for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
      if (cells.at(1) == "emergency") {
        const std::string& code = cells.at(3);
        EXPECT_TRUE(code == "0000" || ending.codes.contains(code)) << line;
      } else if (cells.at(1) == "state") {
        const std::string& state = cells.at(3);
        const bool has_power =
            state == "operation enabled" || state == "quick stop active" || state == "fault reaction active";
        EXPECT_LT(has_power || ending.drops ? 0 : std::fabs(std::stod(cells.at(4))), max_settling_speed)
            << line;
      } else if (cells.at(1) == "end") {
        ended.insert(cells[0]);
        EXPECT_EQ(cells.at(2), "switch-on disabled") << line;
        EXPECT_TRUE(cells[0] == ending.stays || cells.at(5) == "misses nothing") << line;
      }
    }
    EXPECT_EQ(ended, (std::set<std::string>{"slide", "pan"}));
  }
};

TEST_F(CanEnding, NoneLeavesADriveOnAndTheNextStartSucceedsOrSaysWhatMustBeDone) {
  const char* const wanted = std::getenv("INBETWEEN_ENDINGS");
  const std::size_t rounds = wanted == nullptr ? endings().size() : std::stoul(wanted);
  const std::map<std::size_t, Round> ended = play(rounds);
  for (std::size_t number = 0; number < rounds; ++number) {
    const Ending& ending = endings()[number % endings().size()];
    SCOPED_TRACE(fmt::format("round {}: {}", number, ending.name));
    ASSERT_TRUE(ended.contains(number));
    const Round round = ended.at(number);
    EXPECT_EQ(round.status, ending.status) << read("said" + std::to_string(number));
    const std::string next = read("next" + std::to_string(number));
    if (ending.stays.empty()) {
      EXPECT_EQ(round.next, 0) << next;
    } else {
      EXPECT_EQ(round.next, 4);
      EXPECT_THAT(next,
                  testing::HasSubstr("axis \"pan\": the drive did not tell that it is switched off; take "
                                     "its power away before anybody goes near the axis"));
    }
    expect_record(number, ending);
  }
}

}  // namespace can_ending_test
}  // namespace inbetween
