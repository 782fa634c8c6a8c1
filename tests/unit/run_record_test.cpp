// `run --record`: every tick is in the file, and a file that takes none holds nothing up (docs/faults.md 43).
// And a rig file that is changed while the rig is armed (docs/faults.md 11).
#include "host_tools/loop/run_record.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "host_tools/motions/run.hpp"
#include "host_tools/rig/rig_watch.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace run_record_test {

using testing::HasSubstr;

const std::string reveal = in_checkout("examples/reveal.toml");
const std::string camera_rig = in_checkout("examples/camera_rig.toml");

std::vector<std::vector<std::string>> rows_of(const std::string& path) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> row;
    std::size_t at = 0;
    for (std::size_t comma = 0; comma != std::string::npos; at = comma + 1) {
      comma = line.find(',', at);
      row.push_back(line.substr(at, comma - at));
    }
    rows.push_back(row);
  }
  return rows;
}

TEST(RunRecord, HasEveryTickOfEveryAxis) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "run.csv";
  const ProgramRun run =
      run_program({"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--record", file, "--json", "-"});
  ASSERT_EQ(run.status, 0) << run.err;
  const std::vector<std::vector<std::string>> rows = rows_of(file);
  EXPECT_EQ(rows.front(),
            (std::vector<std::string>{"tick", "seconds", "state", "frame", "slide", "slide actual", "pan",
                                      "pan actual", "tilt", "tilt actual"}));
  ASSERT_GT(rows.size(), 2001U);
  std::size_t running = 0;
  std::string last_told;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    ASSERT_EQ(rows[i].size(), 10U);
    ASSERT_EQ(rows[i][0], std::to_string(i - 1)) << "none is missing";
    if (rows[i][2] == "running") ++running;
    if (!rows[i][4].empty()) last_told = rows[i][4];
  }
  EXPECT_EQ(rows[1][4], "") << "told nothing before it is on";
  EXPECT_EQ(running, 1999U) << "2001 ticks, of which the first stands ready and the last has finished";
  EXPECT_EQ(last_told, "1640");
  EXPECT_EQ(rows.back()[4], "") << "nor while it is switched off";
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["record"]["ticks"], rows.size() - 1);
  EXPECT_EQ(json["record"]["lost"], 0);
}

TEST(RunRecord, TellsTheFrameOfEveryTickThatPlays) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "run.csv";
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {.frames = {80, 120}});
  const RunReport report = run(plan, {.simulated = true, .fast = true, .record = file});
  ASSERT_EQ(report.ending, Ending::finished) << report.reason;
  const Move& move = plan.played();
  std::vector<double> positions(3), frames;
  for (const std::vector<std::string>& row : rows_of(file)) {
    if (row[2] != "running") continue;
    frames.push_back(std::stod(row[3]));
    const double whole = std::floor(frames.back());
    const FrameTime time{static_cast<std::int32_t>(whole), frames.back() - whole};
    plan.motion().positions(time, positions);
    EXPECT_NEAR(std::stod(row[4]), positions[0], 1e-3) << "it is where the move is on that frame";
  }
  ASSERT_GT(frames.size(), 400U);
  EXPECT_NEAR(frames.front(), move.first_frame(), 0.2) << "the pre-roll is on the time line too";
  EXPECT_NEAR(frames.back(), move.last_frame(), 0.2);
  EXPECT_TRUE(std::ranges::is_sorted(frames));
  EXPECT_EQ(rows_of(file)[1][3], "") << "before anything is played there is none";
  EXPECT_EQ(rows_of(file).back()[3], "");
}

TEST(RunRecord, IsNeverWrittenOverAFileThatIsThere) {
  const TemporaryFile yesterday("run.csv", "of yesterday\n");
  const ProgramRun run = run_program(
      {"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--record", yesterday.path().string()});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("run.csv: error: it is there already, and is not written over; name another "
                                 "file, or move it away"));
  EXPECT_EQ(file_contents(yesterday.path()), "of yesterday\n");
}

/// Files of this process are at most so long while it lives.
class ShortFiles {
 public:
  explicit ShortFiles(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit shorter{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &shorter);
  }
  ~ShortFiles() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, SIG_DFL);
  }
  ShortFiles(const ShortFiles&) = delete;
  ShortFiles& operator=(const ShortFiles&) = delete;

 private:
  rlimit before_{};
};

// docs/faults.md 43
TEST(RunRecord, ADiskThatFillsUpHasWhatIsCountedAndEndsWithAWholeLine) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "run.csv";
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {});
  RunReport report;
  {
    const ShortFiles full(100'000);
    report = run(plan, {.simulated = true, .fast = true, .record = file});
  }
  EXPECT_EQ(report.ending, Ending::finished) << "the rig was not held up";
  const std::string text = file_contents(file);
  EXPECT_LE(text.size(), 100'000U);
  EXPECT_GT(text.size(), 99'800U);
  EXPECT_EQ(text.back(), '\n');
  EXPECT_EQ(report.record->written, std::ranges::count(text, '\n') - 1) << "without the names of the columns";
  EXPECT_GT(report.record->lost, 0);
  EXPECT_NE(report.record->why, "");
}

// docs/faults.md 43
TEST(RunRecord, AFullDiskDoesNotHoldTheRigUpAndWhatIsLostIsCounted) {
  const std::vector<std::string> plain = {"run",   reveal,   "--rig",  camera_rig,
                                          "--sim", "--fast", "--json", "-"};
  std::vector<std::string> recorded = plain;
  recorded.insert(recorded.end(), {"--record", "/dev/full"});
  const ProgramRun run = run_program(recorded);
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.err, HasSubstr("/dev/full: warning: "));
  EXPECT_THAT(run.err, HasSubstr("it holds 0 of "));
  EXPECT_THAT(run.err, HasSubstr("No space left on device; the rig was not held up"));
  auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["record"]["ticks"], 0);
  EXPECT_GT(json["record"]["lost"], 2001);
  json.erase("record");
  EXPECT_EQ(json, nlohmann::json::parse(run_program(plain).out)) << "it moved as without a record";
}

TEST(RunRecord, AReaderThatTakesNothingDoesNotHoldUpTheEnd) {
  const TemporaryFolder folder;
  const std::string pipe = folder.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(reader, 0);
  const ProgramRun run =
      run_program({"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--record", pipe});
  close(reader);
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.err, HasSubstr("nobody reads it"));
}

TEST(RunRecord, APipeThatNobodyReadsIsRefusedAtOnce) {
  const TemporaryFolder folder;
  const std::string pipe = folder.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const ProgramRun run =
      run_program({"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--record", pipe});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.err, HasSubstr("pipe: error: cannot be written"));
}

TEST(RunRecord, AFileThatCannotBeWrittenIsRefusedBeforeAnythingMoves) {
  const ProgramRun run =
      run_program({"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--record", "/nowhere/run.csv"});
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(
      run.err,
      HasSubstr("/nowhere/run.csv: error: cannot be written: No such file or directory; choose a folder"));
}

const std::string slide_and_pan = in_checkout("examples/slide_and_pan.toml");
const std::string slider_rig = in_checkout("examples/slider_rig.toml");

TEST(StepLog, HasEveryEdgeThatASimulatedStepperGot) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "steps.csv";
  const Plan plan(read_move_file(slide_and_pan), read_rig_file(slider_rig), {});
  const RunReport report = run(plan, {.simulated = true, .fast = true, .steps = file});
  ASSERT_EQ(report.ending, Ending::finished) << report.reason;
  const std::vector<std::vector<std::string>> rows = rows_of(file);
  EXPECT_EQ(rows.front(), (std::vector<std::string>{"seconds", "motor", "step", "dir", "steps"}));
  EXPECT_EQ(report.steps->written, static_cast<std::int64_t>(rows.size()) - 1);
  EXPECT_EQ(report.steps->lost, 0);
  std::map<std::string, std::int64_t> counts;
  std::map<std::string, std::string> levels;
  double seconds = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const std::string& motor = rows[i][1];
    EXPECT_GE(std::stod(rows[i][0]), seconds);
    seconds = std::stod(rows[i][0]);
    EXPECT_NE(rows[i][2], levels[motor]) << "a rise and a fall take turns";
    levels[motor] = rows[i][2];
    if (rows[i][2] == "1") counts[motor] += rows[i][3] == "1" ? 1 : -1;
    ASSERT_EQ(rows[i][4], std::to_string(counts[motor])) << "line " << i + 1;
  }
  std::vector<double> start(2);
  plan.motion().positions({0, 0}, start);
  for (const std::size_t a : {0U, 1U}) {
    const RigAxis& axis = plan.rig()->axes[a];
    const double scale = std::get<StepDirDrive>(axis.drive).steps_per_unit;
    EXPECT_NEAR(static_cast<double>(counts.at(axis.name)) / scale, report.axes[a].last_actual - start[a],
                1e-9 + 1 / std::fabs(scale));
  }
}

TEST(StepLog, IsRefusedWithoutSimulatedSteppers) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "steps.csv";
  const ProgramRun none =
      run_program({"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--steps", file});
  EXPECT_EQ(none.status, 1);
  EXPECT_THAT(none.err, HasSubstr("has no axis with a step-dir drive"));
  const ProgramRun real = run_program({"run", slide_and_pan, "--rig", slider_rig, "--steps", file});
  EXPECT_EQ(real.status, 2);
  EXPECT_THAT(real.err, HasSubstr("add --sim"));
}

class RigChanged : public testing::Test {
 protected:
  Plan plan_{read_move_file(reveal), read_rig_file(camera_rig), {}};
  bool has_changed_ = false;
  SessionOptions options_{
      .simulated = true, .fast = true, .audience = {.rig_has_changed = [this] { return has_changed_; }}};
};

TEST_F(RigChanged, NothingIsBegunAnyMore) {
  has_changed_ = true;
  EXPECT_THAT([&] { run(plan_, options_); },
              testing::ThrowsMessage<InputError>(
                  HasSubstr("camera_rig.toml: error: the file was changed since it was read")));
}

// docs/faults.md 11
TEST_F(RigChanged, WhileTheRigMovesItGoesOnAndIsNotBegunAgainAfterAStop) {
  int looks = 0;
  options_.audience.keys = [&]() -> std::string {
    ++looks;
    if (looks == 500) has_changed_ = true;
    if (looks == 1500) return "\x1b";  // it has gone on until here
    if (looks == 2500) return "a";
    if (looks == 2510) return "\r";
    if (looks == 3000) return "q";
    return "";
  };
  const RunReport report = run(plan_, options_);
  EXPECT_EQ(report.ending, Ending::stopped);
  EXPECT_GE(looks, 3000) << "it was not begun again";
  EXPECT_LE(looks, 3100);
}

TEST_F(RigChanged, BetweenTheAcknowledgementAndTheStartItIsNotBegunAgainEither) {
  for (const bool changes : {false, true}) {
    int looks = 0;
    options_.audience.keys = [&]() -> std::string {
      ++looks;
      if (looks == 500) return "\x1b";
      if (looks == 1500) return "a";
      if (looks == 1600) has_changed_ = changes;
      if (looks == 1700) return "\r";
      if (looks == 6000) return "q";  // a move that is begun again has finished
      return "";
    };
    EXPECT_EQ(run(plan_, options_).ending, changes ? Ending::stopped : Ending::finished);
  }
}

TEST(RigWatch, SeesAnotherTextAndAFileThatHasGone) {
  const TemporaryFile rig("rig.toml", "one");
  const RigWatch watch(rig.path());
  EXPECT_FALSE(watch.has_changed());
  std::ofstream(rig.path()) << "two";
  EXPECT_TRUE(watch.has_changed());
  std::ofstream(rig.path()) << "one";
  EXPECT_FALSE(watch.has_changed());
  std::filesystem::remove(rig.path());
  EXPECT_TRUE(watch.has_changed());
}

}  // namespace run_record_test
}  // namespace inbetween
