// Every run is a take: what was played and where the axes were comes back from the file, and is played again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/cli/take_export.hpp"
#include "host_tools/motions/run.hpp"
#include "host_tools/takes/replayed_take.hpp"
#include "host_tools/takes/take_store.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace take_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

const std::string reveal = in_checkout("examples/reveal.toml");
const std::string camera_rig = in_checkout("examples/camera_rig.toml");
const std::string slide_and_pan = in_checkout("examples/slide_and_pan.toml");
const std::string slider_rig = in_checkout("examples/slider_rig.toml");

/// A folder with takes, into which runs are kept.
class TakesOfRuns : public testing::Test {
 protected:
  [[nodiscard]] std::string in_folder(const std::string& name) const { return folder_.path() / name; }
  [[nodiscard]] TakeStore store() const { return {db_, TakeStore::Access::read}; }
  [[nodiscard]] TakeRequest request() const { return {.keeping = {.file = db_}}; }

  /// Types `typed[i].second` before tick `typed[i].first`.
  static SessionOptions typing(const std::vector<std::pair<int, std::string>>& typed) {
    SessionOptions options{.simulated = true, .fast = true};
    if (typed.empty()) return options;
    options.audience.keys = [typed, tick = 0, next = std::size_t{0}]() mutable {
      const bool now = next < typed.size() && typed[next].first == tick;
      ++tick;
      return now ? typed[next++].second : std::string();
    };
    return options;
  }

  TemporaryFolder folder_;
  std::string db_ = folder_.path() / "takes.db";
  Plan plan_{read_move_file(reveal), read_rig_file(camera_rig), {}};
};

TEST_F(TakesOfRuns, ATakeHasWhatWasPlayedAndWhereTheAxesWere) {
  TakeRequest take = request();
  take.version = "7.1";
  take.files = {{TakeFile::Role::move, reveal, "the move\n", hash_of_content("the move\n")}};
  const RunReport report = run(plan_, typing({}), {.take = take});
  ASSERT_EQ(report.ending, Ending::finished) << report.reason;
  ASSERT_TRUE(report.kept);
  EXPECT_EQ(report.kept->number, 1);
  EXPECT_EQ(report.kept->lost, 0) << report.kept->why;
  EXPECT_GT(report.kept->ticks, 2001);
  TakeStore kept = store();
  const Take all = kept.read(1);
  EXPECT_EQ(all.move_name, "reveal");
  EXPECT_EQ(all.version, "7.1");
  EXPECT_EQ(all.ending, report.reason);
  EXPECT_TRUE(all.is_whole);
  EXPECT_TRUE(all.is_simulated);
  EXPECT_FALSE(all.is_marked);
  EXPECT_EQ(all.rate_hz, 250);
  EXPECT_EQ(all.frames, 192);
  EXPECT_EQ(all.ticks, report.kept->ticks);
  EXPECT_EQ(all.bytes, report.kept->bytes);
  ASSERT_THAT(all.files, SizeIs(1));
  EXPECT_EQ(all.files[0].text, "the move\n");
  ASSERT_THAT(all.axes, SizeIs(3));
  EXPECT_EQ(all.axes[1].name, "pan");
  ASSERT_EQ(static_cast<std::int64_t>(all.ticks_of_take.size()), all.ticks);
  EXPECT_EQ(all.ticks_of_take.back().actual[0], 1640);
  std::vector<double> positions(3);
  std::int64_t played = 0;
  for (const TakeTick& tick : all.ticks_of_take) {
    if (!tick.time) continue;
    ++played;
    plan_.motion().positions(*tick.time, positions);
    for (std::size_t a = 0; a < 3; ++a) ASSERT_EQ(tick.told[a], positions[plan_.axes()[a].move_axis]);
  }
  EXPECT_EQ(played, 2000);
  std::vector<std::string> events;
  for (const TakeEvent& event : all.events) events.push_back(event.text);
  EXPECT_THAT(events, ElementsAre("enabling", "ready", "running", "ready", "disarmed"));
}

/// The setpoints that the CSV of a record has in ticks that play.
std::vector<std::string> played_rows(const std::string& csv) {
  std::vector<std::string> rows;
  std::istringstream text(csv);
  for (std::string line; std::getline(text, line);) {
    const std::size_t state = line.find(",running,");
    if (state != std::string::npos) rows.push_back(line.substr(state));
  }
  return rows;
}

TEST_F(TakesOfRuns, ExportedItIsWhatTheRecordHas) {
  const std::string csv = in_folder("run.csv");
  SessionOptions rig = typing({{300, "+"}, {700, " "}, {1300, "r"}, {1500, "r"}, {1700, " "}});
  rig.record = csv;
  rig.standing = {{"slide", 30}};
  rig.audience.confirm = [](const std::string&) { return true; };
  const RunReport report = run(plan_, rig, {.top_rate = 1, .take = request()});
  ASSERT_EQ(report.ending, Ending::finished) << report.reason;
  TakeStore kept = store();
  export_take_csv(kept, 1, in_folder("take.csv"));
  EXPECT_EQ(file_contents(in_folder("take.csv")), file_contents(csv));
}

TEST_F(TakesOfRuns, PlayedAgainItHasTheSameSetpointsAndEdgesToTheLastBit) {
  const Plan plan(read_move_file(slide_and_pan), read_rig_file(slider_rig), {});
  SessionOptions rig = typing({{100, "-"}, {160, "-"}, {400, "r"}, {440, "r"}, {600, "+"}});
  rig.steps = in_folder("steps.csv");
  const RunReport first = run(plan, rig, {.take = request()});
  ASSERT_EQ(first.ending, Ending::finished) << first.reason;
  TakeStore kept = store();
  const ReplayedTake take = replayed_take(kept, 1);
  SessionOptions again = typing({});
  again.steps = in_folder("again.csv");
  const RunReport second =
      run(plan, again, {.take = request(), .follow = FollowedTake{"take 1", take.places}});
  ASSERT_EQ(second.ending, Ending::finished) << second.reason;
  const auto played = [&](std::int64_t number) {
    std::vector<TakeTick> ticks = kept.read(number).ticks_of_take;
    std::erase_if(ticks, [](const TakeTick& tick) { return !tick.time; });
    const std::int64_t before = ticks.front().number;
    for (TakeTick& tick : ticks) tick.number -= before;
    return ticks;
  };
  EXPECT_EQ(played(1), played(2));
  EXPECT_EQ(file_contents(in_folder("steps.csv")), file_contents(in_folder("again.csv")));
}

TEST_F(TakesOfRuns, OneThatWasStoppedIsPlayedAgainUpToThere) {
  const RunReport first = run(plan_, typing({{900, "\x1b"}, {2000, "q"}}), {.take = request()});
  ASSERT_EQ(first.ending, Ending::stopped);
  TakeStore kept = store();
  const ReplayedTake take = replayed_take(kept, 1);
  const RunReport second =
      run(plan_, typing({}), {.take = request(), .follow = FollowedTake{"take 1", take.places}});
  EXPECT_EQ(second.ending, Ending::finished) << second.reason;
  EXPECT_THAT(second.reason, StartsWith("take 1 was played again"));
  EXPECT_EQ(replayed_take(kept, 2).places, take.places);
  for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(first.axes[a].last_commanded, second.axes[a].last_commanded);
}

TEST_F(TakesOfRuns, PlayedAgainItIsStoppedOnItsPathAndGoesOnAsAnyMove) {
  run(plan_, typing({}), {.take = request()});
  TakeStore kept = store();
  const FollowedTake follow{"take 1", replayed_take(kept, 1).places};
  const RunReport second =
      run(plan_, typing({{900, " "}, {1500, " "}}), {.take = request(), .follow = follow});
  EXPECT_EQ(second.ending, Ending::finished) << second.reason;
  const Take take = kept.read(2);
  std::vector<double> positions(3);
  bool has_rested = false;
  for (const TakeTick& tick : take.ticks_of_take) {
    if (!tick.time) continue;
    has_rested = has_rested || tick.rate == 0;
    plan_.motion().positions(*tick.time, positions);
    ASSERT_EQ(tick.told[0], positions[0]);
  }
  EXPECT_TRUE(has_rested);
  EXPECT_EQ(second.axes[0].last_commanded, 1640);
}

TEST_F(TakesOfRuns, OneOfAnotherMoveIsNotPlayed) {
  const std::string other = in_folder("other.toml");
  std::ofstream(other) << file_contents(in_checkout("examples/reveal.toml")) << "\n";
  run(plan_, typing({{10, "+"}}), {.take = request()});
  TakeStore kept = store();
  std::vector<PlayheadPlace> places = replayed_take(kept, 1).places;
  places[700].time.frame += 1;
  EXPECT_THAT(
      [&] {
        run(plan_, typing({}), {.follow = FollowedTake{"take 1", places}});
      },
      testing::ThrowsMessage<InputError>(
          HasSubstr("reveal.toml: error: take 1 cannot be played again: in tick 700 ")));
}

TEST_F(TakesOfRuns, ATakeThatNothingWasPlayedInIsNotKept) {
  SessionOptions rig = typing({});
  rig.standing = {{"slide", 30}};
  rig.audience.confirm = [](const std::string&) { return false; };
  const RunReport report = run(plan_, rig, {.take = request()});
  EXPECT_EQ(report.ending, Ending::stopped);
  ASSERT_TRUE(report.kept);
  EXPECT_EQ(report.kept->number, 0);
  EXPECT_THAT(store().list(), IsEmpty());
  EXPECT_THROW(
      run(plan_, {.simulated = true, .fast = true, .standing = {{"slide", 30}}}, {.take = request()}),
      InputError);
  EXPECT_THAT(store().list(), IsEmpty());
}

TEST_F(TakesOfRuns, KeysAreInIt) {
  run(plan_, typing({{1100, " "}, {1400, " "}}), {.take = request()});
  std::vector<std::string> keys;
  for (const TakeEvent& event : store().read(1).events) {
    if (event.kind == TakeEvent::Kind::key) keys.push_back(event.text);
  }
  EXPECT_THAT(keys, ElementsAre("space", "space"));
}

}  // namespace take_test
}  // namespace inbetween
