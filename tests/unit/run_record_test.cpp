// `run --record`: every tick is in the file, and a file that takes none holds nothing up (docs/faults.md 43).
// And a rig file that is changed while the rig is armed (docs/faults.md 11).
#include "host_tools/loop/run_record.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
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
  EXPECT_EQ(rows.front(), (std::vector<std::string>{"tick", "seconds", "state", "slide", "slide actual",
                                                    "pan", "pan actual", "tilt", "tilt actual"}));
  ASSERT_GT(rows.size(), 2001U);
  std::size_t running = 0;
  std::string last_told;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    ASSERT_EQ(rows[i].size(), 9U);
    ASSERT_EQ(rows[i][0], std::to_string(i - 1)) << "none is missing";
    if (rows[i][2] == "running") ++running;
    if (!rows[i][3].empty()) last_told = rows[i][3];
  }
  EXPECT_EQ(rows[1][3], "") << "told nothing before it is on";
  EXPECT_EQ(running, 1999U) << "2001 ticks, of which the first stands ready and the last has finished";
  EXPECT_EQ(last_told, "1640");
  EXPECT_EQ(rows.back()[3], "") << "nor while it is switched off";
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["record"]["ticks"], rows.size() - 1);
  EXPECT_EQ(json["record"]["lost"], 0);
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
