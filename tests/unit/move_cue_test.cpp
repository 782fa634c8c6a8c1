// Cues: what a move does on lines of the rig, and at which frames.
#include "host_tools/move_model/move_cue.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace move_cue_test {

using testing::ElementsAre;

constexpr const char* take = R"(name = "take"
fps = 25
frames = 10
start = "trigger"
clapper = { line = "clap", width_ms = 30 }
[[track]]
axes = ["x"]
keys = [ { at = [0] }, { at = [1] } ]
speed = [0, 0, 1, 0, 0]
[[cue]]
line = "camera"
every = 1
width_ms = 5.5
phase = 0.25
[[cue]]
line = "lamp"
frames = [0, 3, 10]
width_ms = 60
)";

const std::string rig = rig_text({axis_text("x", "mm", {-1, 100}, {.velocity = 100, .acceleration = 100}, "",
                                            R"(type = "pipe", path = "/dev/null", counts_per_unit = 1)")},
                                 {.name = "table", .more = R"([start_trigger]
line = "START"
[camera]
line = "SHUTTER"
[output.lamp]
line = "LAMP"
[output.clap]
line = "CLAP"
)"});

void expect_move_refused(const std::string& marked, std::initializer_list<std::string_view> words) {
  expect_refused([](std::string_view text, const std::string& file) { parse_move(text, file); }, marked,
                 words);
}

/// The take with one thing changed; the mark @ is in `to`.
void expect_change_refused(std::string_view from, std::string_view to,
                           std::initializer_list<std::string_view> words) {
  expect_move_refused(with(take, from, to), words);
}

/// The take, with the mark @ at the place that the rig `machine` refuses.
void expect_refused_by(const std::string& machine, const std::string& marked,
                       std::initializer_list<std::string_view> words) {
  const auto check = [&](std::string_view text, const std::string& file) {
    check_cues(parse_move(text, file), parse_rig(machine, "rig.toml"));
  };
  expect_refused(check, marked, words);
}

/// "line frame+phase width_us" of every pulse.
std::vector<std::string> pulses_of(const std::string& text) {
  const MoveFile move = parse_move(text, "take.toml");
  std::vector<std::string> pulses;
  for (const CuePulse& pulse : cue_pulses(move)) {
    pulses.push_back(fmt::format("{} {}+{} {}", pulse.line, pulse.frame, pulse.phase, pulse.width_ns / 1000));
  }
  return pulses;
}

// ---- what is accepted

TEST(MoveCue, ReadsCuesClapperAndStart) {
  const MoveFile move = parse_move(take, "take.toml");
  ASSERT_EQ(move.cues.size(), 2U);
  EXPECT_EQ(move.cues[0].line, "camera");
  EXPECT_EQ(move.cues[0].every, 1);
  EXPECT_TRUE(move.cues[0].frames.empty());
  EXPECT_EQ(move.cues[0].width_ns, 5'500'000);
  EXPECT_EQ(move.cues[0].phase, 0.25);
  EXPECT_EQ(to_string(move.cues[0].line_place), "take.toml:11:8");
  EXPECT_EQ(to_string(move.cues[0].place), "take.toml:10:1");
  EXPECT_THAT(move.cues[1].frames, ElementsAre(0, 3, 10));
  EXPECT_EQ(move.cues[1].every, 0);
  EXPECT_EQ(move.cues[1].phase, 0);
  EXPECT_EQ(to_string(move.cues[1].frame_places.at(2)), "take.toml:17:17");
  ASSERT_TRUE(move.clapper.has_value());
  EXPECT_EQ(move.clapper->line, "clap");
  EXPECT_EQ(move.clapper->width_ns, 30'000'000);
  EXPECT_EQ(move.start, Start::trigger);
  EXPECT_EQ(to_string(move.start_place), "take.toml:4:9");
}

TEST(MoveCue, AMoveWithoutCuesStartsByCommand) {
  const std::string text = take;
  const std::string plain = with(with(text.substr(0, text.find("[[cue]]")), "start = \"trigger\"\n", ""),
                                 "clapper = { line = \"clap\", width_ms = 30 }\n", "");
  const MoveFile move = parse_move(plain, "m");
  EXPECT_TRUE(move.cues.empty());
  EXPECT_FALSE(move.clapper.has_value());
  EXPECT_EQ(move.start, Start::command);
  EXPECT_TRUE(cue_pulses(move).empty());
  EXPECT_EQ(parse_move(with(take, "\"trigger\"", "\"command\""), "m").start, Start::command);
}

// ---- pulses

TEST(MoveCue, PulsesComeInTheOrderOfTheirBeginnings) {
  EXPECT_THAT(pulses_of(with(take, "every = 1", "every = 3")),
              ElementsAre("clap 0+0 30000", "lamp 0+0 60000", "camera 0+0.25 5500", "lamp 3+0 60000",
                          "camera 3+0.25 5500", "camera 6+0.25 5500", "camera 9+0.25 5500", "clap 10+0 30000",
                          "lamp 10+0 60000"));
}

TEST(MoveCue, EveryFrameIsOneMoreThanTheFramesOfTheMove) {
  EXPECT_EQ(pulses_of(take).size(), 11U + 3 + 2);
}

TEST(MoveCue, EveryLastFrameIsTheFirstAndTheLast) {
  EXPECT_EQ(pulses_of(with(take, "every = 1", "every = 10")).size(), 2U + 3 + 2);
}

TEST(MoveCue, APulseKnowsItsPlace) {
  const MoveFile move = parse_move(take, "take.toml");
  const std::vector<CuePulse> pulses = cue_pulses(move);
  EXPECT_EQ(to_string(*pulses.at(0).place), "take.toml:5:11");
  EXPECT_EQ(to_string(*pulses.at(1).place), "take.toml:17:11");
  EXPECT_EQ(to_string(*pulses.at(2).place), "take.toml:10:1");
}

TEST(MoveCue, PulsesOfALineMayNotOverlap) {
  // A frame lasts 40 ms, so that 40 ms from frame to frame would be one long pulse.
  expect_change_refused("[0, 3, 10]\nwidth_ms = 60", "[0, 3, @4]\nwidth_ms = 40",
                        {"on line \"lamp\" a pulse begins at frame 4, 40 ms after that of frame 3 (line 17)",
                         "which is 40 ms wide; make that narrower, or use another line"});
  EXPECT_EQ(pulses_of(with(take, "[0, 3, 10]\nwidth_ms = 60", "[0, 3, 4]\nwidth_ms = 39.999")).size(), 16U);
  expect_move_refused(
      with(with(take, "[[cue]]\nline = \"camera\"", "@[[cue]]\nline = \"camera\""), "5.5", "41"),
      {"a pulse begins at frame 1, 40 ms after that of frame 0 (line 10), which is 41 ms wide"});
}

TEST(MoveCue, PulsesOfTwoCuesOnALineMayNotOverlap) {
  const std::string third = "[[cue]]\nline = \"lamp\"\nframes = [2, @4]\nwidth_ms = 1\nphase = 0.25\n";
  expect_move_refused(take + third,
                      {"at frame 4, 50 ms after that of frame 3 (line 17), which is 60 ms wide"});
  const std::string after = "[[cue]]\nline = \"lamp\"\nframes = [4]\nwidth_ms = 1\nphase = 0.6\n";
  EXPECT_EQ(pulses_of(take + after).size(), 17U) << "64 ms after the beginning of a pulse of 60 ms";
  const std::string before = "[[cue]]\nline = \"lamp\"\nframes = [2]\nwidth_ms = 10.1\nphase = 0.75\n";
  expect_move_refused(with(take, "[0, 3, 10]", "[0, @3, 10]") + before,
                      {"at frame 3, 10 ms after that of frame 2 (line 21)"});
}

TEST(MoveCue, TheClapperIsAPulseLikeAnyOther) {
  expect_change_refused("\"lamp\"\nframes = [0, 3, 10]", "\"clap\"\nframes = [@0, 3]",
                        {"on line \"clap\" a pulse begins at frame 0, 0 ms after that of frame 0 (line 5)"});
  expect_change_refused("{ line = \"clap\", width_ms = 30 }", "@{ line = \"clap\", width_ms = 400 }",
                        {"a pulse begins at frame 10, 400 ms after that of frame 0"});
}

// ---- what is refused

TEST(MoveCue, FramesAreInTheMoveAndAscend) {
  expect_change_refused("[0, 3, 10]", "[0, 3, @11]", {"frames[2] is 11; write a whole number from 0 to 10"});
  expect_change_refused("[0, 3, 10]", "[@-1, 3]", {"frames[0] is -1"});
  expect_change_refused("[0, 3, 10]", "[0, @3.0]", {"frames[1] is a number with a fraction"});
  expect_change_refused("[0, 3, 10]", "[3, @3]", {"frames[1] is 3, not after 3", "ascending order"});
  expect_change_refused("[0, 3, 10]", "@[]", {"frames is empty"});
}

TEST(MoveCue, EveryIsWithinTheMove) {
  expect_change_refused("every = 1", "every = @0", {"every is 0; write a whole number from 1 to 10"});
  expect_change_refused("every = 1", "every = @11", {"every is 11"});
  expect_change_refused("every = 1", "every = @true", {"every is true or false; write a whole number"});
}

TEST(MoveCue, ACueHasFramesOrEvery) {
  expect_change_refused("every = 1", "frames = [1]\nevery = @1",
                        {"every says the same as frames; remove one"});
  expect_move_refused(
      with(with(take, "every = 1\n", ""), "[[cue]]\nline = \"camera\"", "@[[cue]]\nline = \"camera\""),
      {"a cue has no frames; add frames = [1, 24], or every = 1"});
}

TEST(MoveCue, WidthAndPhaseAreInTheirRanges) {
  expect_change_refused("5.5", "@0", {"width_ms is less than a nanosecond"});
  expect_change_refused("5.5", "@4e-7", {"width_ms is less than a nanosecond"});
  expect_change_refused("5.5", "@-5", {"width_ms is -5; write a number from 0 to 60000"});
  expect_change_refused("5.5", "@60_001", {"width_ms is 60001"});
  expect_change_refused("0.25", "@1", {"phase is 1, the next frame; write a number below 1"});
  expect_change_refused("0.25", "@-0.1", {"phase is -0.1; write a number from 0 to 1"});
  expect_change_refused("0.25", "@nan", {"phase is nan"});
}

TEST(MoveCue, CueAndClapperHaveTheirFields) {
  expect_change_refused("phase = 0.25", "@fase = 0.25", {"a cue has no field \"fase\"", "\"phase\"?"});
  expect_change_refused("{ line = \"clap\", width_ms = 30 }", "@{ line = \"clap\" }",
                        {"the clapper has no width_ms; add width_ms = 20"});
  expect_change_refused("{ line = \"clap\", width_ms = 30 }", "@{ width_ms = 30 }",
                        {"the clapper has no line"});
  expect_change_refused("width_ms = 30", "width_ms = 30, @frames = [1]", {"the clapper has no field"});
  expect_change_refused("\"trigger\"", "@\"input\"",
                        {"start is \"input\"; write \"command\" or \"trigger\""});
  expect_change_refused("\"lamp\"", "@\"\"", {"line is empty"});
  const std::string text = take;
  expect_move_refused(with(text.substr(0, text.find("[[cue]]")), "start", "cue = @5\nstart"),
                      {"cue is a whole number"});
}

TEST(MoveCue, AMoveHasAtMost64CuesAndTwoMillionPulses) {
  std::string many = "name=\"a\"\nfps=24\nframes=2\n[[track]]\naxes=[\"x\"]\nspeed=[1]\nkeys=[{at=[1]}]\n@";
  for (int i = 0; i < 65; ++i) many += fmt::format("[[cue]]\nline=\"{}\"\nevery=1\nwidth_ms=1\n", i);
  expect_move_refused(many, {"cue has 65 elements; write at most 64"});
  std::string longest =
      "name=\"a\"\nfps=24\nframes=1_000_000\n[[track]]\naxes=[\"x\"]\nspeed=[1]\nkeys=[{at=[1]}]\n";
  longest += "[[cue]]\nline=\"a\"\nevery=1\nwidth_ms=1\n@[[cue]]\nline=\"b\"\nevery=1\nwidth_ms=1\n";
  expect_move_refused(longest, {"more than 2000000 pulses together; raise every"});
}

// ---- on a rig

TEST(MoveCue, TheRigHasWhatTheMoveNeeds) {
  EXPECT_NO_THROW(check_cues(parse_move(take, "m"), parse_rig(rig, "r")));
}

TEST(MoveCue, ALineThatTheRigDoesNotHaveMeetsThoseThatItHas) {
  expect_refused_by(rig, with(take, "\"lamp\"", "@\"lump\""),
                    {"the rig \"table\" has no output \"lump\"; it has clap, lamp, camera"});
  expect_refused_by(rig, with(take, "\"clap\"", "@\"clip\""), {"has no output \"clip\""});
  const std::string bare =
      with(with(rig, "[output.lamp]\nline = \"LAMP\"\n", ""), "[output.clap]\nline = \"CLAP\"\n", "");
  expect_refused_by(with(bare, "[camera]\nline = \"SHUTTER\"\n", ""), with(take, "\"clap\"", "@\"clap\""),
                    {"has no output \"clap\"; add an [output.NAME] to it"});
}

TEST(MoveCue, ACameraAndATriggerMustBeThere) {
  expect_refused_by(with(rig, "[camera]\nline = \"SHUTTER\"\n", ""), with(take, "\"camera\"", "@\"camera\""),
                    {"the rig \"table\" has no camera; add a [camera]"});
  expect_refused_by(with(rig, "[start_trigger]\nline = \"START\"\n", ""),
                    with(take, "\"trigger\"", "@\"trigger\""),
                    {"the rig \"table\" has no trigger; add a [start_trigger]"});
}

}  // namespace move_cue_test
}  // namespace inbetween
