// Loops that come back to where they began: until they are stopped, with the turn and the frame.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/motions/run.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/motions/transport.hpp"
#include "host_tools/plan/turns.hpp"
#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_on.hpp"
#include "tests/support/temporary_file.hpp"
#include "tests/support/terminal_screen.hpp"
#include "tests/support/ticked_rig.hpp"

namespace inbetween {
namespace endless_loop_test {

using testing::HasSubstr;
using testing::StartsWith;

AxisText neck(const std::string& name, double min, double max) {
  return axis_text(name, "deg", {min, max}, {.velocity = 150, .acceleration = 800}, "unpowered = \"holds\"");
}
const std::string head_text = rig_text(
    {neck("neck_yaw", -70, 70), neck("neck_nod", -30, 35), neck("neck_tilt", -25, 25)}, {.name = "head"});

/// The idle of a head in an exhibition: one second a turn.
std::string idle_text(const std::string& fps = "24", int frames = 24) {
  return fmt::format(
      "name = \"idle\"\nfps = {}\nframes = {}\n"
      "[[track]]\naxes = [\"neck_yaw\", \"neck_nod\", \"neck_tilt\"]\nclosed = true\n"
      "periodic = true\nkeys = [{{ at = [0, 0, 0] }}, {{ at = [4, 3, 2] }}, {{ at = [0, 5, 0] "
      "}}, {{ at = [-4, 3, -2] }}]\nspeed = [5, 8, 5, 3, 5]\n",
      fps, frames);
}

/// Planned as `run --loop` plans it.
struct Round {
  Plan once, plan;
  PlayedTurns turns;

  explicit Round(const std::string& text, int rate_hz = 100)
      : once(parse_move(text, "idle.toml"), head(rate_hz), {}),
        plan(turns_of(once, turns_to_go_round(once).turns), head(rate_hz), {}),
        turns(turns_to_go_round(once)) {}
  static RigFile head(int rate_hz) {
    RigFile rig = parse_rig(head_text, "head.toml");
    rig.rate_hz = rate_hz;
    return rig;
  }
};

TEST(EndlessLoop, AnIdleInAnExhibitionGoesOnUntilItIsStoppedAndTellsItsTurn) {
  const Round idle(idle_text());
  int tick = 0;
  constexpr int last = 100 * 2600 - 50;
  const RunReport report =
      run(idle.plan, {.simulated = true, .fast = true, .audience = {.keys = [&]() -> std::string {
                                                         return ++tick == last ? "q" : "";
                                                       }}},
          {.turns = idle.turns});
  EXPECT_EQ(report.ending, Ending::stopped);
  EXPECT_GE(report.ticks, last) << "2500 turns were the end once";
  EXPECT_THAT(report.reason, StartsWith("stopped in turn 2600, on frame "));
}

/// Ticks until the turn begins, and then so many.
class Played {
 public:
  explicit Played(const Round& round)
      : rig(round.plan),
        staged(round.plan),
        transport(rig.loop, staged, true, {.turns = round.turns}),
        motion_(round.plan.motion()),
        positions_(motion_.axis_count()) {
    EXPECT_TRUE(transport.begin());
  }
  void tick(int count = 1) { rig.tick(transport, count); }
  [[nodiscard]] RunSnapshot now() const { return transport.snapshot(); }
  [[nodiscard]] std::int64_t turn() const { return now().turn->turn; }
  [[nodiscard]] const std::vector<double>& positions() {
    motion_.positions(staged.playhead().time(), positions_);
    return positions_;
  }

  TickedRig rig;
  StagedMove staged;
  Transport transport;

 private:
  const PlayedMotion& motion_;
  std::vector<double> positions_;
};

TEST(EndlessLoop, EveryTurnIsTheSameMotionAndNothingIsLeftOfIt) {
  const Round idle(idle_text());
  Played played(idle);
  EXPECT_EQ(played.turn(), 1);
  while (played.now().frame < 0) played.tick();
  std::vector<std::vector<double>> first;
  const double begin = played.now().frame;
  for (int i = 0; i < 100; ++i) {
    first.push_back(played.positions());
    played.tick();
  }
  for (int turn = 2; turn <= 300; ++turn) {
    EXPECT_NEAR(played.now().frame, begin, 1e-9);
    ASSERT_EQ(played.turn(), turn);
    for (std::size_t i = 0; i < 100; ++i) {
      ASSERT_LT(played.now().frame, 24);
      for (std::size_t d = 0; d < 3; ++d) ASSERT_NEAR(played.positions()[d], first[i][d], 1e-9) << turn;
      played.tick();
    }
  }
  EXPECT_FALSE(played.now().seconds_left);
  EXPECT_THAT(state_line(played.now()), StartsWith("playing  turn 301  frame "));
}

// 10^7 ticks of a rate and a turn that no whole number of ticks makes: 29.97 frames a second, 50 ticks.
TEST(EndlessLoop, TurnAndFrameAreExactAfterAMillionTurns) {
  const Round round(idle_text("\"30000/1001\"", 30), 50);
  StagedMove staged(round.plan);
  Playhead& playhead = staged.playhead();
  ASSERT_TRUE(playhead.play(Direction::forward));
  const std::int32_t first = round.plan.played().first_frame();
  const WholeFrames again = round.turns.again();
  std::int64_t carried = 0;
  constexpr std::int64_t unit = 50 * 1001;
  for (std::int64_t tick = 1; carried < 1'000'000; ++tick) {
    playhead.tick();
    if (playhead.time().frame >= again.last) {
      playhead.shift_by(again.first - again.last);
      ++carried;
    }
    const std::int64_t scaled = tick * 30000;
    const std::int64_t frame = first + scaled / unit - carried * 30;
    ASSERT_EQ(playhead.time().frame, frame) << tick;
    ASSERT_EQ(playhead.time().fraction, static_cast<double>(scaled % unit) / unit) << tick;
  }
}

TEST(EndlessLoop, BackwardItGoesThroughItsTurnsToWhereItBegan) {
  const Round idle(idle_text());
  Played played(idle);
  constexpr std::int64_t far = 120;  // it was carried on the way there, and is on the way back
  while (played.turn() < far) played.tick();
  played.transport.press(TransportKey::reverse);
  std::int64_t before = far;
  while (!played.now().is_resting) {
    played.tick();
    ASSERT_LE(std::llabs(played.turn() - before), 1);
    before = played.turn();
  }
  EXPECT_EQ(played.turn(), 1);
  EXPECT_EQ(played.rig.loop.state(), SupervisorState::ready);
  EXPECT_THAT(hint_line(played.now()), StartsWith("back at the beginning"));
  played.transport.press(TransportKey::start);
  played.tick(1000);
  EXPECT_NEAR(static_cast<double>(played.turn()), 10, 1);
}

TEST(EndlessLoop, AStopAtAnyPlaceOfALateTurnKeepsThePathAndHomeGoesBackByIt) {
  const Round idle(idle_text());
  for (int phase = 0; phase < 100; phase += 7) {
    Played played(idle);
    while (played.turn() < 70) played.tick();
    played.tick(phase);
    std::vector<double> before = played.positions();
    const auto goes_smoothly = [&] {
      played.tick();
      for (std::size_t d = 0; d < 3; ++d) ASSERT_LT(std::fabs(played.positions()[d] - before[d]), 0.5);
      before = played.positions();
    };
    played.transport.press(TransportKey::pause);
    for (int i = 0; i < 200; ++i) goes_smoothly();
    EXPECT_EQ(phase_of(played.now()), "paused");
    EXPECT_GE(played.turn(), 70);
    EXPECT_LE(played.turn(), 71);
    played.transport.press(TransportKey::home);
    for (int i = 0; i < 20'000 && !(played.now().is_resting && played.now().share == 0); ++i) goes_smoothly();
    EXPECT_TRUE(played.now().is_resting);
    EXPECT_EQ(played.turn(), 1);
    EXPECT_NEAR(before[0], idle.plan.played().rolls().before[0].rest_position(), 1e-9);
  }
}

TEST(EndlessLoop, AFrameThatIsGoneToIsThatOfTheTurnThatIsPlayed) {
  const Round idle(idle_text());
  Played played(idle);
  while (played.turn() < 70) played.tick();
  played.tick(60);
  for (const TransportKey key : {TransportKey::go_to_frame, TransportKey::size_3, TransportKey::start}) {
    played.transport.press(key);
  }
  played.tick(20'000);
  EXPECT_TRUE(played.now().is_resting);
  EXPECT_EQ(played.now().frame, 3);
  EXPECT_GE(played.turn(), 70);
  EXPECT_LE(played.turn(), 71);
}

// A cue on frame 0, which is on a tick, one between ticks, and one a tick behind frame 0.
TEST(EndlessLoop, EveryTurnHasEachOfItsPulsesOnce) {
  const std::string out =
      "[output.lamp]\nchip = \"head\"\nline = 4\n[output.horn]\nchip = \"head\"\nline = 5\n";
  const std::string cued = idle_text() +
                           "[[cue]]\nline = \"lamp\"\nframes = [0, 7]\nwidth_ms = 20\n"
                           "[[cue]]\nline = \"horn\"\nframes = [0]\nwidth_ms = 20\n";
  const RigFile rig = parse_rig(head_text + out, "head.toml");
  const Plan once(parse_move(cued, "idle.toml"), rig, {});
  const PlayedTurns turns = turns_to_go_round(once);
  const Plan plan(turns_of(once, turns.turns), rig, {});
  const TemporaryFolder folder;
  const std::string log = (folder.path() / "cues.csv").string();
  int tick = 0;
  constexpr int turns_played = 150;
  run(plan, {.simulated = true, .fast = true, .audience = {.keys = [&]() -> std::string {
                                                return ++tick == 100 * turns_played ? "q" : "";
                                              }}},
      {.turns = turns, .cue_log = log});
  const std::string text = file_contents(log);
  int lamp = 0;
  int horn = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    lamp += line.find(",lamp,0,20,0,") != std::string::npos ? 1 : 0;
    horn += line.find(",horn,0,20,0,") != std::string::npos ? 1 : 0;
  }
  EXPECT_NEAR(lamp, turns_played, 2) << text.substr(0, 300);
  EXPECT_EQ(horn, lamp);
}

TEST(EndlessLoop, TurnsThatGainSayBeforehandHowManyFit) {
  const std::string move = in_checkout("examples/turntable.toml");
  const std::string rig = in_checkout("examples/turntable_rig.toml");
  const Plan table(read_move_file(move), read_rig_file(rig), {});
  EXPECT_FALSE(comes_back(table.move()));
  const FittingTurns fitting = fitting_turns(table);
  EXPECT_EQ(fitting.turns, 19) << "and its rolls";
  EXPECT_EQ(fitting.border, "axis \"table\" has the limits -7200..7200 deg");
  EXPECT_TRUE(comes_back(Round(idle_text()).once.move()));
  TerminalScreen screen({"run", move, "--rig", rig, "--sim", "--loop"});
  EXPECT_THAT(screen.wait_for("turn 1 of 19  frame "),
              StartsWith("turntable on turntable, simulated, 19 turns"));
  screen.press("q");
  EXPECT_EQ(screen.wait_for_exit(), 4);
  EXPECT_THAT(screen.shown(), HasSubstr("turntable: --loop plays 19 turns, as many as fit: axis \"table\""));
}

TEST(EndlessLoop, OnTheScreenTheTurnIsCountedAndTheFramesAreThoseOfOne) {
  const TemporaryFile move("idle.toml", idle_text());
  const TemporaryFile rig("head.toml", head_text);
  TerminalScreen screen({"run", move.path().string(), "--rig", rig.path().string(), "--sim", "--loop"});
  screen.wait_for("playing  turn 3  frame ");
  EXPECT_THAT(screen.shown(), HasSubstr(" of 24  rate +1.00 of 1.00\n"))
      << "no seconds are left of what has no end";
  screen.press("q");
  EXPECT_EQ(screen.wait_for_exit(), 4);
  EXPECT_THAT(screen.shown(), HasSubstr("idle: stopped in turn "));
}

}  // namespace endless_loop_test
}  // namespace inbetween
