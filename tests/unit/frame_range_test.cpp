// `--frames 20..80` of plan, check and run: a part of a move is a move of its own.
#include "host_tools/text/frame_range.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace frame_range_test {

using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::ordered_json;

const std::string reveal = in_checkout("examples/reveal.toml");
const std::string camera_rig = in_checkout("examples/camera_rig.toml");

ProgramRun program(const char* command, const std::vector<std::string>& more,
                   const std::string& move = reveal, const std::string& rig = camera_rig) {
  std::vector<std::string> arguments{command, move, "--rig", rig};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_program(arguments);
}

/// The cells behind the first of each line, by that.
std::map<std::string, std::string> table_of(const std::string& csv) {
  std::map<std::string, std::string> rows;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) rows[line.substr(0, line.find(','))] = line;
  return rows;
}

TEST(FrameRange, IsReadInEveryForm) {
  EXPECT_EQ(frames_in_words({0, 48}, 48), "48 frames");
  EXPECT_EQ(frames_in_words({12, 48}, 48), "frames 12..48 of 48");
  EXPECT_EQ(played_frames_of(*frame_range_of("12.."), 48, {}), (WholeFrames{12, 48}));
  EXPECT_EQ(played_frames_of(*frame_range_of("..12"), 48, {}), (WholeFrames{0, 12}));
  EXPECT_EQ(played_frames_of({}, 48, {}), (WholeFrames{0, 48}));
}

TEST(FrameRange, BadOnesAreOneClearLineWhateverTheCommand) {
  const std::vector<std::pair<const char*, std::vector<std::string>>> commands{
      {"plan", {}}, {"check", {}}, {"run", {"--sim", "--fast"}}};
  for (const auto& [command, options] : commands) {
    const auto refused = [&, &command = command, &options = options](const char* frames, int status) {
      std::vector<std::string> arguments = options;
      arguments.insert(arguments.end(), {"--frames", frames});
      const ProgramRun run = program(command, arguments);
      EXPECT_EQ(run.status, status) << command << " " << frames << run.err;
      EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
      return run.err;
    };
    for (const char* frames : {"80..20", "20", "20-80", "a..b", "1.5..3", "-3..20", "..", "20..80..90"}) {
      EXPECT_THAT(refused(frames, 2), HasSubstr("write FIRST..LAST, FIRST.. or ..LAST, for example 20..80"));
    }
    EXPECT_THAT(refused("20..193", 1), HasSubstr("--frames names frame 193, and there are 0..192"));
    EXPECT_THAT(refused("192..", 1), HasSubstr("--frames names frame 192 alone"));
    EXPECT_THAT(refused("20..20", 1), HasSubstr("name two, for example 20..21"));
  }
}

TEST(FrameRange, PlanShowsThePartWithItsRollsAndTheFrameNumbersOfTheWhole) {
  const std::map<std::string, std::string> whole = table_of(program("plan", {"--csv", "-"}).out);
  const ProgramRun run = program("plan", {"--frames", "80..120", "--csv", "-"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("reveal: frames 80..120 of 192 at 24 fps, 1.667 s"));
  EXPECT_THAT(run.err, HasSubstr("pre-roll: "));
  EXPECT_THAT(run.err, HasSubstr("post-roll: "));
  const std::map<std::string, std::string> part = table_of(run.out);
  for (int frame = 80; frame <= 120; ++frame) {
    const std::string name = std::to_string(frame);
    EXPECT_EQ(part.at(name), whole.at(name)) << "to the last digit";
  }
  ASSERT_TRUE(part.contains("79") && part.contains("121"));
  EXPECT_NE(part.at("79"), whole.at("79")) << "on the pre-roll";

  const Json json = Json::parse(program("plan", {"--frames", "80..120", "--json", "-"}).out);
  EXPECT_EQ(json["frames"], 192);
  EXPECT_EQ(json["first"], 80);
  EXPECT_EQ(json["last"], 120);
  EXPECT_EQ(json["axes"][0]["position"].size(), 41U);
  EXPECT_EQ(json["tracks"][0]["table"].front()["frame"], 80);
  EXPECT_EQ(json["tracks"][0]["table"].back()["frame"], 120);
  EXPECT_EQ(part.size(), 1U + 41U + json["pre_roll"]["frames"].get<std::size_t>() +
                             json["post_roll"]["frames"].get<std::size_t>());
}

TEST(FrameRange, NamedFramesAreToldThoughTheyAreAll) {
  for (const auto& [command, more] : {std::pair<const char*, std::vector<std::string>>{"plan", {}},
                                      {"check", {}},
                                      {"run", {"--sim", "--fast"}}}) {
    std::vector<std::string> plain = more;
    plain.insert(plain.end(), {"--json", "-"});
    std::vector<std::string> named = plain;
    named.insert(named.end(), {"--frames", "0..192"});
    Json report = Json::parse(program(command, named).out);
    EXPECT_EQ(report.value("first", -1), 0) << command;
    EXPECT_EQ(report.value("last", -1), 192) << command;
    report.erase("first");
    report.erase("last");
    EXPECT_EQ(report, Json::parse(program(command, plain).out)) << "the whole of it is the whole";
  }
}

/// Two seconds too fast, in the middle; the ends at rest.
const std::string too_fast =
    "name = \"slide\"\nfps = 24\nframes = 192\n[[track]]\naxes = [\"slide\"]\n"
    "keys = [{ at = [60] }, { at = [1640] }]\nspeed = [0, 0, 2, 30, 2, 2, 2, 0, 0]\n";

TEST(FrameRange, APartMayFitWhereTheWholeDoesNotAndTheOtherWayRound) {
  const TemporaryFile move("slide.toml", too_fast);
  const ProgramRun whole = program("check", {}, move.path());
  EXPECT_EQ(whole.status, 3);
  EXPECT_THAT(whole.err, HasSubstr("max_velocity"));
  const ProgramRun part = program("check", {"--frames", "120.."}, move.path());
  EXPECT_EQ(part.status, 0) << part.err;
  EXPECT_THAT(part.out, HasSubstr("slide on "));
  EXPECT_THAT(part.out, HasSubstr(": frames 120..192 of 192 at 24 fps, 3.000 s"));
  EXPECT_THAT(part.out, HasSubstr("\nfits in frames 120..192 of 192\n"));
  EXPECT_THAT(part.out, Not(HasSubstr("would do"))) << "fewer frames are another move";
  const Json json = Json::parse(program("check", {"--frames", "120..", "--json", "-"}, move.path()).out);
  EXPECT_EQ(json["first"], 120);
  EXPECT_EQ(json["fits"], true);
  EXPECT_EQ(json["smallest_frames"], nullptr);
  EXPECT_GE(json["axes"][0]["velocity"]["frame"].get<double>(), 100);
  EXPECT_GE(json["stop"]["from_frame"].get<double>(), 100);

  // From the very end of its axis, as quickly as it may: a pre-roll into frame 4 would need room before that.
  std::string rig = file_contents(camera_rig);
  for (std::size_t at = rig.find("max_jerk"); at != std::string::npos; at = rig.find("max_jerk")) {
    rig.erase(at, rig.find('\n', at) - at);
  }
  const TemporaryFile without_jerk("rig.toml", rig);
  const TemporaryFile edge("edge.toml",
                           "name = \"slide\"\nfps = 24\nframes = 47\n[[track]]\naxes = [\"slide\"]\n"
                           "keys = [{ at = [0] }, { at = [600] }]\nspeed = [0, 10, 10, 0]\n");
  EXPECT_EQ(program("check", {}, edge.path(), without_jerk.path()).status, 0);
  for (const char* command : {"check", "run"}) {
    std::vector<std::string> frames{"--frames", "4.."};
    if (command == std::string("run")) frames.insert(frames.end(), {"--sim", "--fast"});
    const ProgramRun refused = program(command, frames, edge.path(), without_jerk.path());
    EXPECT_EQ(refused.status, 3);
    EXPECT_THAT(refused.err,
                HasSubstr("edge.toml:5:9: error: frame 4 is passed moving, and on a pre-roll of "));
    EXPECT_THAT(refused.err, HasSubstr("axis \"slide\" would go to -"));
    EXPECT_THAT(refused.err, HasSubstr("begin on a frame where the move is slower or rests"));
  }
}

TEST(FrameRange, AStepCountsWhereItIsPassedAndNotWhereAPartBeginsOrEnds) {
  const TemporaryFile corner(
      "corner.toml",
      "name = \"corner\"\nfps = 24\nframes = 96\n[[track]]\naxes = [\"pan\", \"tilt\"]\n"
      "spline = \"linear\"\nkeys = [{ at = [0, 0] }, { at = [30, 0], frame = 48 }, { at = [30, "
      "20] }]\nspeed = [0, 0, 10, 10, 10, 0, 0]\n");
  for (const char* frames : {"0..96", "20..60", "47..", "..49"}) {
    const bool is_whole = std::string_view(frames) == "0..96";
    const ProgramRun run = program("check", {"--frames", frames}, corner.path());
    EXPECT_EQ(run.status, 3) << frames;
    EXPECT_THAT(run.err, HasSubstr(is_whole ? "note: it fits with ease = true at key 1; this was tried"
                                            : "let the speed touch 0 there with ease = true"));
  }
  for (const char* frames : {"..48", "48..", "10..48", "48..50"}) {
    const ProgramRun run = program("check", {"--frames", frames}, corner.path());
    EXPECT_EQ(run.status, 0) << frames << run.err;
    EXPECT_THAT(run.out, HasSubstr("no step of velocity or acceleration"));
  }
}

TEST(FrameRange, CheckFewestHasItsFormerSpellingNamed) {
  const ProgramRun run = program("check", {"--fit", "-", "--frames", "fewest"});
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.err, HasSubstr("for a fitted move in the fewest frames write --fit OUT --fewest"));
  EXPECT_EQ(program("check", {"--fewest"}).status, 2) << "it needs --fit";
  EXPECT_THAT(program("check", {"--fit", "-", "--frames", "20..80"}).err,
              HasSubstr("--fit fits the whole move"));
}

/// The positions in which the slide was told to be, tick by tick, as they are written.
std::vector<std::string> told_in(const std::string& record) {
  std::ifstream file(record);
  std::string line;
  std::getline(file, line);
  std::vector<std::string> told;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (int i = 0; i < 5; ++i) std::getline(cells, cell, ',');
    if (!cell.empty()) told.push_back(cell);
  }
  return told;
}

TEST(FrameRange, APlayedPartIsTheWholeMoveRowForRow) {
  // 10 ticks a frame: the reveal begins at rest, so that tick 10 j is frame j.
  std::string text = file_contents(reveal);
  text.replace(text.find("fps    = 24"), 11, "fps    = 25");
  const TemporaryFile move("reveal.toml", text);
  const TemporaryFolder folder;
  const auto file = [&](const char* name) { return (folder.path() / name).string(); };
  ASSERT_EQ(program("run", {"--sim", "--fast", "--record", file("whole.csv")}, move.path()).status, 0);
  const ProgramRun run =
      program("run", {"--sim", "--fast", "--frames", "80..120", "--record", file("part.csv"), "--json", "-"},
              move.path());
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("reveal: frames 80..120 of 192 were played; "));
  const Json report = Json::parse(run.out);
  EXPECT_EQ(report["first"], 80);
  EXPECT_EQ(report["last"], 120);
  EXPECT_EQ(report["ended"], "finished");

  const Json plan = Json::parse(program("plan", {"--frames", "80..120", "--json", "-"}, move.path()).out);
  const auto pre_roll = plan["pre_roll"]["frames"].get<std::size_t>();
  const auto post_roll = plan["post_roll"]["frames"].get<std::size_t>();
  const std::vector<std::string> whole = told_in(file("whole.csv"));
  const std::vector<std::string> part = told_in(file("part.csv"));
  ASSERT_GE(part.size(), 10 * (pre_roll + 40 + post_roll));
  for (std::size_t tick = 0; tick <= 400; ++tick)
    EXPECT_EQ(part[10 * pre_roll + tick], whole[800 + tick]) << tick;
  EXPECT_NE(part[10 * pre_roll - 30], whole[770]) << "on the pre-roll";
}

TEST(FrameRange, TheTransitToThePartIsAgreedToOrTheRigStays) {
  const std::vector<std::string> elsewhere{"--sim", "--fast", "--frames", "80..120", "--from", "slide=60"};
  const ProgramRun refused = program("run", elsewhere);
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("--yes"));
  std::vector<std::string> agreed = elsewhere;
  agreed.insert(agreed.end(), {"--yes", "--json", "-"});
  const ProgramRun run = program("run", agreed);
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("the rig is not where the move starts:"));
}

TEST(FrameRange, AShootGoesToSingleFramesOfTheWholeMove) {
  const ProgramRun run = program("run", {"--sim", "--fast", "--step", "--frames", "20..20", "--json", "-"});
  EXPECT_EQ(run.status, 0) << run.err;
  const Json report = Json::parse(run.out);
  EXPECT_EQ(report["exposures"], 1);
  EXPECT_FALSE(report.contains("first")) << "nothing of it is played";
}

TEST(FrameRange, GoingRoundAPartIsRefusedUnlessItComesBack) {
  const ProgramRun loop = program("run", {"--sim", "--frames", "80..120", "--loop"});
  EXPECT_EQ(loop.status, 3);
  EXPECT_THAT(loop.err, HasSubstr("axis \"slide\""));
  const ProgramRun turns =
      program("run", {"--sim", "--frames", "20..80", "--loop"}, in_checkout("examples/turntable.toml"),
              in_checkout("examples/turntable_rig.toml"));
  EXPECT_EQ(turns.status, 2) << turns.err;
  EXPECT_THAT(turns.err, HasSubstr("--loop goes round the whole of a periodic move"));
}

TEST(FrameRange, EveryExampleCanBePlayedFromTheMiddle) {
  struct Example {
    const char *move, *rig;
    std::vector<std::string> more = {};
  };
  for (const Example& example :
       std::vector<Example>{{"slide_and_pan.toml", "slider_rig.toml"},
                            {"turntable.toml", "turntable_rig.toml"},
                            {"turntable.toml", "turntable_rig.toml", {"--turns", "2"}},
                            {"nod.toml", "puppet_head.toml"},
                            {"arm/reach_over.toml", "arm/rig.toml"},
                            {"crane/over_the_table.toml", "crane/rig.toml"},
                            {"crane/round_the_puppet.toml", "crane/rig.toml"},
                            {"blink.toml", "puppet_head.toml"}}) {
    const std::string move = in_checkout(std::string("examples/") + example.move);
    const std::string rig = in_checkout(std::string("examples/") + example.rig);
    std::vector<std::string> frames = example.more;
    frames.insert(frames.end(), {"--frames", "5..15"});
    const ProgramRun check = program("check", frames, move, rig);
    frames.insert(frames.end(), {"--sim", "--fast", "--yes"});
    const ProgramRun run = program("run", frames, move, rig);
    EXPECT_EQ(check.status, run.status) << example.move << "\n" << check.err << run.err;
    EXPECT_EQ(run.status, 0) << example.move << "\n" << run.err;
  }
}

}  // namespace frame_range_test
}  // namespace inbetween
