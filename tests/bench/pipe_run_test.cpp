// A whole move to hobby servos: `run` at one end of a FIFO, somebody who writes down its lines at the other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/bench.hpp"
#include "tests/support/bus_scene.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace pipe_run_test {

using testing::HasSubstr;

const std::string rig = rig_text(
    {axis_text("jaw", "deg", {-10, 60}, {.velocity = 200, .acceleration = 2000}, R"(unpowered = "holds")",
               R"(type = "pipe", path = "servos", counts_per_unit = 11.11, count_at_zero = 1500, )"
               R"(min_count = 1300, max_count = 2200, no_watchdog = "accepted")")},
    {.name = "jaw", .rate_hz = 250});
const std::string move = R"(name = "bite"
fps = 24
frames = 48
[[track]]
axes = ["jaw"]
timing = "frames"
keys = [{ at = [0], frame = 0 }, { at = [45], frame = 20 }, { at = [0], frame = 48 }]
)";

/// In the folder with both, and with a FIFO "servos"; what its reader got is in "lines".
struct PipeScene {
  explicit PipeScene(const std::string& reader) {
    std::ofstream(folder.path() / "rig.toml") << rig;
    std::ofstream(folder.path() / "move.toml") << move;
    run = script_in_bench(
        {"--virtual-time"},
        "cd '" + folder.path().string() +
            "'\necho -1 >/proc/sys/kernel/sched_rt_runtime_us\nmkfifo servos\n" + reader +
            " & reader=$!\ninbetween goto --rig rig.toml --positions positions --set-zero jaw\nstatus=0\n"
            "until inbetween run move.toml --rig rig.toml --positions positions --json report.json 2>err; "
            "do\n"
            "  status=$?; grep -q 'nobody reads' err || break; status=0; sleep 0.01\ndone\n"
            "cat err >&2; kill $reader 2>/dev/null || true; exit $status");
  }
  TemporaryFolder folder;
  ProgramRun run;
};

TEST(PipeRun, TheLinesAreThePlanAtEveryTickAndTheLastSaysOff) {
  const PipeScene scene("cat servos >lines");
  ASSERT_EQ(scene.run.status, 0) << scene.run.err;
  std::istringstream lines(file_contents((scene.folder.path() / "lines").string()));
  std::vector<std::string> all;
  for (std::string line; std::getline(lines, line);) all.push_back(line);
  ASSERT_GT(all.size(), 500U);
  EXPECT_EQ(all.back(), "off");
  all.pop_back();
  std::vector<double> counts;
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_THAT(all[i], testing::StartsWith(std::to_string(i) + " ")) << "no line is lost";
    counts.push_back(std::stod(all[i].substr(all[i].find('=') + 1)));
  }
  const std::string csv = (scene.folder.path() / "plan.csv").string();
  ASSERT_EQ(run_program({"plan", (scene.folder.path() / "move.toml").string(), "--rig",
                         (scene.folder.path() / "rig.toml").string(), "--per", "tick", "--csv", csv})
                .status,
            0);
  const std::string table = file_contents(csv);
  std::istringstream head(table.substr(0, table.find('\n')));
  int column = 0, jaw = -1;
  for (std::string cell; std::getline(head, cell, ','); ++column) {
    if (jaw < 0 && cell.find("jaw") != std::string::npos) jaw = column;
  }
  ASSERT_GE(jaw, 0) << head.str();
  const std::vector<double> planned = column_of(table, jaw);
  const auto count_of = [](double position) { return std::floor(position * 11.11 + 1500 + 0.5); };
  // It rests before the move and after it: aligned by the first count that differs.
  std::size_t first = 0, first_planned = 0;
  while (first < counts.size() && counts[first] == 1500) ++first;
  while (first_planned < planned.size() && count_of(planned[first_planned]) == 1500) ++first_planned;
  ASSERT_GE(first, first_planned);
  for (std::size_t tick = 0; tick < planned.size(); ++tick) {
    const std::size_t at = first - first_planned + tick;
    ASSERT_LT(at, counts.size());
    ASSERT_EQ(counts[at], count_of(planned[tick])) << tick;
  }
}

TEST(PipeRun, AReaderThatStallsEndsTheRunAndTheAxisIsNotBelievedAgain) {
  const PipeScene scene("(exec 3<servos; sleep 50)");
  EXPECT_EQ(scene.run.status, 4) << scene.run.err;
  EXPECT_THAT(scene.run.out,
              HasSubstr("is not read any more; look at the program or board at its other end"));
  const ProgramRun again = run_program({"run", (scene.folder.path() / "move.toml").string(), "--rig",
                                        (scene.folder.path() / "rig.toml").string(), "--positions",
                                        (scene.folder.path() / "positions").string()});
  EXPECT_EQ(again.status, 1);
  EXPECT_THAT(again.err, HasSubstr("axis \"jaw\" does not know where it is"));
}

}  // namespace pipe_run_test
}  // namespace inbetween
