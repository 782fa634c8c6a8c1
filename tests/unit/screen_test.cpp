// The screen before somebody who plays a move: its text, and the whole of it in a terminal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "host_tools/cli/screen_text.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"
#include "tests/support/terminal_screen.hpp"

namespace inbetween {
namespace screen_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const std::string reveal = in_checkout("examples/reveal.toml");
const std::string camera_rig = in_checkout("examples/camera_rig.toml");

RunSnapshot playing() {
  RunSnapshot now{.state = SupervisorState::running,
                  .frame = 96,
                  .frames = 192,
                  .seconds_left = 4.0,
                  .rate = 1,
                  .share = 0.5,
                  .keys = "space pauses, r turns, + - rate, Esc stops"};
  now.axis_count = 3;
  now.axes[0] = {
      .commanded = 810.5, .actual = 810.25, .following_error = 0.25, .is_known = true, .is_commanded = true};
  return now;
}

TEST(ScreenText, IsRightIn80ColumnsAnd24Lines) {
  const RigFile rig = read_rig_file(camera_rig);
  const std::vector<std::string> text = screen_text("reveal on a slider", rig, playing(), 79, 24);
  ASSERT_EQ(text.size(), 24U);
  EXPECT_EQ(text[0], "reveal on a slider");
  EXPECT_EQ(text[2], "playing  frame 96.0 of 192  rate +1.00 of 1.00  4.0 s left");
  EXPECT_THAT(text[3], StartsWith("[######"));
  EXPECT_EQ(text[3].size(), 79U);
  EXPECT_EQ(text[5], "  axis                commanded       actual  following error");
  EXPECT_EQ(text[6], "  slide                810.5000     810.2500           0.2500  mm");
  EXPECT_EQ(text[7], "  pan                         -            -                -  deg")
      << "nobody knows where it is";
  EXPECT_EQ(text[23], "space pauses, r turns, + - rate, Esc stops");
}

TEST(ScreenText, WhateverItsSizeItFitsAndTellsWhatHappensAndTheKeys) {
  const RigFile rig = read_rig_file(camera_rig);
  for (int columns = 1; columns <= 90; ++columns) {
    for (int lines = 2; lines <= 30; ++lines) {
      const std::vector<std::string> text = screen_text("reveal", rig, playing(), columns, lines);
      ASSERT_EQ(text.size(), static_cast<std::size_t>(lines));
      for (const std::string& line : text) ASSERT_LE(line.size(), static_cast<std::size_t>(columns));
      const std::string state = std::string("playing  frame").substr(0, static_cast<std::size_t>(columns));
      EXPECT_TRUE(std::ranges::any_of(text, [&](const auto& line) { return line.starts_with(state); }));
      EXPECT_THAT(text.back(), StartsWith(std::string("space").substr(0, static_cast<std::size_t>(columns))));
    }
  }
}

TEST(ScreenText, AxesWithoutRoomAreCounted) {
  const RigFile rig = read_rig_file(camera_rig);
  const std::vector<std::string> text = screen_text("reveal", rig, playing(), 79, 7);
  EXPECT_THAT(text, ElementsAre(StartsWith("playing"), "", HasSubstr("commanded"), StartsWith("  slide"),
                                "  and 2 more; they need a higher window", "", HasSubstr("Esc stops")));
}

TEST(ScreenText, ACutNameKeepsItsLettersWhole) {
  const RigFile rig = read_rig_file(camera_rig);
  EXPECT_EQ(screen_text("Käfer über", rig, playing(), 2, 24).front(), "Kä");
}

TEST(ScreenText, ByHandEveryAxisHasItsLimits) {
  const RigFile rig = read_rig_file(camera_rig);
  RunSnapshot now = playing();
  now.jog =
      JogSnapshot{.axis = "pan", .unit = "deg", .stop_distance = 0.5, .min = -170, .max = 170, .size = 3};
  const std::vector<std::string> text = screen_text("by hand", rig, now, 79, 24);
  EXPECT_THAT(text[2], HasSubstr("stops in 0.5"));
  EXPECT_THAT(text[4], HasSubstr("position         from           to"));
  EXPECT_THAT(text[5], StartsWith("  slide                810.2500"));
  EXPECT_THAT(text[6], StartsWith("> pan "));
}

TEST(Screen, PlayPauseBackToTheBeginningStopAcknowledgeTakeTwoAndQuit) {
  const TemporaryFolder folder;
  const std::string takes = folder.path() / "%n.csv";
  TerminalScreen screen({"run", reveal, "--rig", camera_rig, "--sim", "--takes", "--record", takes, "--plot",
                         folder.path() / "%n.svg"});
  EXPECT_THAT(screen.wait_for("ready  frame 0.0 of 192"), HasSubstr("Enter begins a take, "));
  screen.press("Enter");
  screen.wait_for("playing  frame ");
  screen.press("Space");
  const std::string paused = screen.wait_for("paused  frame ");
  EXPECT_THAT(paused, StartsWith("reveal on slider with pan and tilt head, simulated\n\npaused  frame "));
  EXPECT_THAT(paused, HasSubstr("rate +0.00 of 1.00\n"));
  EXPECT_THAT(paused,
              HasSubstr("\n  axis                commanded       actual  following error\n  slide  "));
  EXPECT_THAT(paused,
              HasSubstr("space plays, arrows step, r turns, Home, g frame, k key, Esc stops, q leaves"));
  screen.press("r");
  screen.press("Space");
  EXPECT_THAT(screen.wait_for("back at the beginning: Enter plays, q leaves"),
              HasSubstr("ready  frame 0.0 of 192"));
  EXPECT_THAT(screen.shown(), HasSubstr("  slide                 60.0000"));
  screen.press("Enter");
  screen.wait_for(" s left");
  screen.press("Escape");
  EXPECT_THAT(screen.wait_for("stopped: press a"), HasSubstr("a acknowledges, q leaves"));
  screen.press("a");
  screen.wait_for("ready  frame ");
  screen.press("Home");
  screen.wait_for("ready  frame 0.0 of 192");
  screen.press("q");
  EXPECT_EQ(screen.wait_for_exit(), 0);
  const std::string summary = screen.shown();
  EXPECT_THAT(summary, HasSubstr("reveal: 2 takes played, and left; "));
  EXPECT_THAT(summary, HasSubstr("  take 1: not played to its end, "));
  EXPECT_THAT(summary, HasSubstr("  take 2: not played to its end, "));
  EXPECT_THAT(summary, Not(HasSubstr("####"))) << "the histogram is only there with --latency";
  for (const char* take : {"1.csv", "2.csv"}) {
    EXPECT_THAT(file_contents(folder.path() / take), StartsWith("tick,seconds,state,frame,slide,"));
  }
  for (const char* number : {"1", "2"}) {
    EXPECT_THAT(file_contents(folder.path() / (std::string(number) + ".svg")),
                HasSubstr("reveal, take " + std::string(number)));
  }
}

TEST(Screen, FollowsTheSizeOfItsWindow) {
  TerminalScreen screen({"run", reveal, "--rig", camera_rig, "--sim", "--takes"});
  EXPECT_THAT(screen.wait_for("ready  frame 0.0"), HasSubstr("  tilt  "));
  screen.resize(60, 6);
  EXPECT_THAT(screen.wait_for("and 3 more; they need a higher window"), StartsWith("ready  frame 0.0"));
  screen.resize(100, 30);
  EXPECT_THAT(screen.wait_for("  tilt  "), StartsWith("reveal on "));
  screen.press("q");
  EXPECT_EQ(screen.wait_for_exit(), 0);
}

TEST(Screen, InAPipeIsALineWheneverSomethingElseHappens) {
  const ProgramRun run = run_program({"run", in_checkout("examples/nod.toml"), "--rig",
                                      in_checkout("examples/puppet_head.toml"), "--sim", "--latency"});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("\nplaying  frame "));
  EXPECT_THAT(run.err, Not(HasSubstr("\x1b")));
  EXPECT_EQ(run.err.back(), '\n');
  EXPECT_THAT(run.out, HasSubstr(" us "));
}

}  // namespace screen_test
}  // namespace inbetween
