#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

/// Loops at speed: what a periodic move does at its seam, differentiated from what was sent to the drives.

namespace inbetween {
namespace periodic_move_test {

using Json = nlohmann::json;
using testing::HasSubstr;

const std::string rig = R"(
name = "table"
rate_hz = 480
[[axis]]
name = "x"
unit = "mm"
min = -1000
max = 1000
max_velocity = 1000
max_acceleration = 4000
drive = { type = "pipe", path = "/dev/null", counts_per_unit = 1000 }
[[axis]]
name = "y"
unit = "mm"
min = -1000
max = 1000
max_velocity = 1000
max_acceleration = 4000
drive = { type = "pipe", path = "/dev/null", counts_per_unit = 1000 }
[[output]]
)";
const std::string plain_rig = rig.substr(0, rig.find("[[output]]"));

/// A walk that is quicker on one side, in 48 frames a turn.
std::string loop_of(const std::string& timing) {
  return "name = \"loop\"\nfps = 24\nframes = 48\n[[track]]\naxes = [\"x\", \"y\"]\nclosed = true\nperiodic "
         "= "
         "true\n" +
         timing;
}
const std::string drawn = loop_of(
    "keys = [{ at = [0, 0] }, { at = [80, 20] }, { at = [100, 90] }, { at = [10, 60] }]\nspeed = [8, 5, 9, "
    "12, "
    "10, 8]\n");
const std::string by_frames = loop_of(
    "timing = \"frames\"\nkeys = [{ at = [0, 0], frame = 0 }, { at = [80, 20], frame = 9 }, { at = [100, "
    "90], "
    "frame = 25 }, { at = [10, 60], frame = 40 }]\n");

struct RigAndMove {
  explicit RigAndMove(const std::string& text) : move("move.toml", text), rig_file("rig.toml", plain_rig) {}
  ProgramRun run(const std::string& command, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {command, move.path().string(), "--rig", rig_file.path().string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words);
  }
  TemporaryFile move, rig_file;
};

/// The column of a record, every tick.
std::vector<double> column(const std::string& csv, const std::string& name) {
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  std::vector<std::string> heads;
  std::istringstream head(line);
  for (std::string word; std::getline(head, word, ',');) heads.push_back(word);
  const auto index = static_cast<std::size_t>(std::ranges::find(heads, name) - heads.begin());
  EXPECT_LT(index, heads.size()) << line;
  std::vector<double> values;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (std::size_t i = 0; i <= index; ++i) std::getline(cells, cell, ',');
    values.push_back(std::stod(cell));
  }
  return values;
}

struct Sent {
  std::vector<double> x, y;
};
Sent sent(const RigAndMove& files, const std::string& turns) {
  const TemporaryFolder folder;
  const std::string csv = (folder.path() / "ticks.csv").string();
  const ProgramRun run = files.run("plan", {"--turns", turns, "--per", "tick", "--csv", csv});
  EXPECT_EQ(run.status, 0) << run.err;
  const std::string text = file_contents(csv);
  return {column(text, "x (mm)"), column(text, "y (mm)")};
}

/// The largest magnitude of the k-th difference in [begin, end).
double largest_difference(std::vector<double> values, int k, std::size_t begin, std::size_t end) {
  for (int i = 0; i < k; ++i) {
    for (std::size_t j = 0; j + 1 < values.size(); ++j) values[j] = values[j + 1] - values[j];
    values.pop_back();
  }
  double largest = 0;
  for (std::size_t j = begin; j < std::min(end, values.size()); ++j) {
    largest = std::max(largest, std::fabs(values[j]));
  }
  return largest;
}

TEST(PeriodicMove, RunsThroughItsSeamsForThreeTurnsWithoutAStep) {
  constexpr std::size_t turn = 48 * 20;  // ticks
  for (const std::string& text : {drawn, by_frames}) {
    const RigAndMove files(text);
    const Sent three = sent(files, "3");
    const ProgramRun json = files.run("plan", {"--turns", "3", "--json", "-"});
    ASSERT_EQ(json.status, 0) << json.err;
    const Json plan = Json::parse(json.out);
    const std::size_t roll =
        plan.contains("pre_roll") ? plan["pre_roll"]["frames"].get<std::size_t>() * 20 : 0;
    ASSERT_GT(roll, 0U) << json.out.substr(0, 400);
    for (const std::vector<double>& axis : {three.x, three.y}) {
      ASSERT_GT(axis.size(), roll + 3 * turn);
      // Each turn is the same motion, seams included.
      for (std::size_t tick = 0; tick <= turn; ++tick) {
        EXPECT_NEAR(axis[roll + tick], axis[roll + turn + tick], 1e-9) << tick;
        EXPECT_NEAR(axis[roll + tick], axis[roll + 2 * turn + tick], 1e-9) << tick;
      }
      // A step of the velocity would be a second difference, one of the acceleration a third difference, far
      // above those elsewhere on the turn.
      const std::size_t begin = roll + turn / 2;
      for (const int k : {2, 3}) {
        const double elsewhere = largest_difference(axis, k, begin, begin + turn / 2 - 10);
        const double whole = largest_difference(axis, k, roll + 5, roll + turn - 10);
        for (const std::size_t seam : {roll + turn, roll + 2 * turn}) {
          EXPECT_LE(largest_difference(axis, k, seam - 5, seam + 5), 1.5 * std::max(whole, elsewhere) + 1e-12)
              << k;
        }
      }
    }
  }
}

TEST(PeriodicMove, HasOnePreRollAndOnePostRollAndItsStopsAreProvenAcrossTheSeams) {
  const RigAndMove files(drawn);
  const ProgramRun one = files.run("check", {"--json", "-"});
  const ProgramRun three = files.run("check", {"--turns", "3", "--json", "-"});
  ASSERT_EQ(one.status, 0) << one.err;
  ASSERT_EQ(three.status, 0) << three.err;
  const Json of_one = Json::parse(one.out);
  const Json of_three = Json::parse(three.out);
  for (const std::size_t axis : {0U, 1U}) {
    for (const char* quantity : {"velocity", "acceleration"}) {
      EXPECT_NEAR(of_three["axes"][axis][quantity]["peak"].get<double>() /
                      of_one["axes"][axis][quantity]["peak"].get<double>(),
                  1, 0.02)
          << quantity;
    }
    EXPECT_LE(of_three["stop"]["axes"][axis]["acceleration"]["peak"].get<double>(), 6000);
  }
  EXPECT_TRUE(of_three["steps"].empty());
  EXPECT_GT(of_three["stop"]["longest_s"].get<double>(), 0);
  const ProgramRun run = files.run("run", {"--sim", "--fast", "--turns", "3"});
  EXPECT_EQ(run.status, 0) << run.err;
}

TEST(PeriodicMove, IsRefusedWhereItWouldStep) {
  const auto refused = [](const std::string& text, const std::string& words) {
    const TemporaryFile file("move.toml", text);
    const ProgramRun run = run_program({"plan", file.path().string()});
    EXPECT_EQ(run.status, 1);
    EXPECT_THAT(run.err, HasSubstr(words));
  };
  const std::string keys = "keys = [{ at = [0, 0] }, { at = [80, 20] }, { at = [9, 60] }]\n";
  refused(loop_of(keys + "speed = [8, 5, 9]\n"), "the speed is 9 at the end and 8 at the start");
  refused(loop_of(keys + "speed = [8, 8]\nease_in = 4\n"), "has a speed curve without ends");
  refused(loop_of("keys = [{ at = [0, 0] }, { at = [80, 20], frame = 9 }]\nspeed = [8, 8]\n"),
          "that no key changes");
  std::string open = loop_of(keys + "speed = [8, 8]\n");
  open.replace(open.find("closed = true"), 13, "closed = false");
  refused(open, "needs a closed path");
  std::string plain = loop_of(keys + "speed = [8, 8]\n");
  plain.replace(plain.find("periodic = true"), 15, "periodic = false");
  const RigAndMove files(plain);
  const ProgramRun run = files.run("run", {"--sim", "--fast", "--turns", "2"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("only a periodic move has turns"));
}

TEST(PeriodicMove, IsShotInNFramesATurnOfWhichFrameNIsFrame0) {
  const RigAndMove files(drawn);
  const ProgramRun once =
      files.run("run", {"--sim", "--fast", "--step", "--settle", "0", "--exposure", "0.01"});
  EXPECT_THAT(once.out, HasSubstr("49 frames exposed")) << once.err;
  const ProgramRun loop =
      files.run("run", {"--sim", "--fast", "--step", "--loop", "--settle", "0", "--exposure", "0.01"});
  EXPECT_THAT(loop.out, HasSubstr("48 frames exposed")) << loop.err;
  const ProgramRun two =
      files.run("run", {"--sim", "--fast", "--step", "--turns", "2", "--settle", "0", "--exposure", "0.01"});
  EXPECT_THAT(two.out, HasSubstr("96 frames exposed")) << two.err;
}

TEST(PeriodicMove, ATurntableGoesRoundAndItsCountsGoOn) {
  const std::string move = in_checkout("examples/turntable.toml");
  const std::string table = in_checkout("examples/turntable_rig.toml");
  const ProgramRun run = run_program({"run", move, "--rig", table, "--sim", "--fast", "--turns", "3"});
  EXPECT_EQ(run.status, 0) << run.err;
  const ProgramRun json = run_program({"plan", move, "--rig", table, "--turns", "3", "--json", "-"});
  ASSERT_EQ(json.status, 0) << json.err;
  const Json axis = Json::parse(json.out)["axes"][0];
  const auto position = axis["position"].get<std::vector<double>>();
  const double frames = static_cast<double>(position.size() - 1);
  for (std::size_t frame = 0; frame < position.size(); ++frame) {
    EXPECT_NEAR(position[frame], 1080 * static_cast<double>(frame) / frames, 1e-6) << frame;
  }
  const ProgramRun many = run_program({"run", move, "--rig", table, "--sim", "--fast", "--turns", "1000"});
  EXPECT_EQ(many.status, 3) << "the rig has fewer turns";
}

}  // namespace periodic_move_test
}  // namespace inbetween
