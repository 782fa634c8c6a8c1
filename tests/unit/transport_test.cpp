// The tape recorder: keys as a terminal sends them, and what they do to a running move.
#include "host_tools/motions/transport.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "drivers/linux/interrupt_watch.hpp"
#include "host_tools/motions/run.hpp"
#include "host_tools/motions/run_checks.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/motions/start_signal.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"
#include "tests/support/ticked_rig.hpp"

namespace inbetween {
namespace transport_test {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

const std::string reveal = in_checkout("examples/reveal.toml");
const std::string camera_rig = in_checkout("examples/camera_rig.toml");

std::vector<TransportKey> keys_of(std::string_view bytes) {
  TransportKeys keys;
  keys.feed(bytes);
  std::vector<TransportKey> all;
  while (const auto key = keys.next()) all.push_back(*key);
  return all;
}

TEST(TransportKeys, ReadWhatATerminalSends) {
  EXPECT_THAT(
      keys_of(" r+-aq\r\n"),
      ElementsAre(TransportKey::pause, TransportKey::reverse, TransportKey::faster, TransportKey::slower,
                  TransportKey::acknowledge, TransportKey::quit, TransportKey::start, TransportKey::start));
  EXPECT_THAT(
      keys_of("\x1b[C\x1b[D\x1bOC"),
      ElementsAre(TransportKey::step_forward, TransportKey::step_backward, TransportKey::step_forward));
  EXPECT_THAT(keys_of("\x1b"), ElementsAre(TransportKey::stop));
  EXPECT_THAT(keys_of("\x1b\x1b"), ElementsAre(TransportKey::stop, TransportKey::stop));
  EXPECT_THAT(keys_of("\x1b[A\x1b[B"), ElementsAre(TransportKey::previous_axis, TransportKey::next_axis));
  EXPECT_THAT(keys_of("\x1b[H\x1bOH\x1b[1~\x1b[7~"), Each(TransportKey::home));
  EXPECT_THAT(keys_of("\x1b[<64;10;5M\x1b[<65;10;5Mgk09\x7f"),
              ElementsAre(TransportKey::detent_forward, TransportKey::detent_backward,
                          TransportKey::go_to_frame, TransportKey::go_to_key, TransportKey::digit_0,
                          TransportKey::digit_9, TransportKey::erase));
  EXPECT_THAT(keys_of("xyz\x1b[<0;10;5M\x1b[<0;10;5m\x1b[F\x1b[15~\x1b[1;5C\x1b[5~\xff"), IsEmpty())
      << "other keys do nothing";
  EXPECT_THAT(keys_of("\x1b[M`+q\x1b[M#Q\xE0\x1b[M g"), IsEmpty()) << "nor does a mouse of before SGR";
}

// Kitty's keyboard protocol, with Num Lock on (129) and off, and the keys of a US keyboard and its keypad.
TEST(TransportKeys, ReadWhatATerminalTellsOfAKeyThatIsHeldAndLetGo) {
  EXPECT_THAT(keys_of("\x1b[?2u\x1b[?3u"), Each(TransportKey::tells_releases));
  EXPECT_THAT(keys_of("\x1b[?0u\x1b[?1u"), IsEmpty()) << "it can, and does not";
  EXPECT_THAT(keys_of("\x1b[1;1:1C\x1b[1;129C\x1b[C"), Each(TransportKey::step_forward));
  EXPECT_THAT(
      keys_of("\x1b[1;1:2C\x1b[1;129:2C\x1b[43;1:2u\x1b[61:43;2:2u\x1b[57413;129:2u"),
      ElementsAre(TransportKey::repeat_forward, TransportKey::repeat_forward, TransportKey::repeat_forward,
                  TransportKey::repeat_forward, TransportKey::repeat_forward));
  EXPECT_THAT(keys_of("\x1b[1;1:2D\x1b[45;1:2u\x1b[57412;1:2u"), Each(TransportKey::repeat_backward));
  EXPECT_THAT(keys_of("\x1b[1;1:3C\x1b[1;1:3D\x1b[61;1:3u\x1b[45;1:3u\x1b[1;5:3C"),
              ElementsAre(TransportKey::let_go, TransportKey::let_go, TransportKey::let_go,
                          TransportKey::let_go, TransportKey::let_go))
      << "whatever is held with it";
  EXPECT_THAT(keys_of("\x1b[27;1:3u\x1b[113;1:3u\x1b[113;1:2u\x1b[1;1:3A\x1b[1;1:2B\x1b[97;1:3u"), IsEmpty())
      << "other keys that are let go or repeated";
  EXPECT_THAT(keys_of("\x1b[27u\x1b[113;129u\x1b[99;5u"),
              ElementsAre(TransportKey::stop, TransportKey::quit, TransportKey::quit));
  EXPECT_THAT(keys_of("\x1b[;;;u\x1b[99999999999999999999u\x1b[:::C\x1b[1;:C\x1b[?u\x1b[-1u").size(), 2U)
      << "and nonsense is an arrow at most";
}

/// Plays the example on a virtual clock, typing `typed[i].second` before tick `typed[i].first`.
struct Session {
  std::vector<std::string> lines;
  RunReport report;

  explicit Session(const std::vector<std::pair<int, std::string>>& typed, Repeat repeat = Repeat::none)
      : Session(typed, RunOptions{.repeat = repeat}) {}
  Session(const std::vector<std::pair<int, std::string>>& typed, const RunOptions& options,
          const FrameRange& frames = {}) {
    const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {.frames = frames});
    int tick = 0;
    std::size_t next = 0;
    report = run(plan,
                 {.simulated = true,
                  .fast = true,
                  .audience = {.keys =
                                   [&] {
                                     const bool now = next < typed.size() && typed[next].first == tick;
                                     ++tick;
                                     return now ? typed[next++].second : std::string();
                                   }}},
                 options);
  }
};

TEST(Transport, WithoutAKeyTheMoveIsPlayedToItsEnd) {
  const Session session({});
  EXPECT_EQ(session.report.ending, Ending::finished);
  EXPECT_EQ(session.report.ticks, 2001);
  EXPECT_EQ(session.report.axes[0].last_actual, 1640);
}

TEST(Transport, APauseAndStepsAndATurnStillEndWhereTheMoveEnds) {
  const Session session(
      {{500, " "}, {1000, "\x1b[C"}, {1400, "\x1b[D\x1b[D"}, {2000, " "}, {2300, "r"}, {2600, "r"}});
  EXPECT_EQ(session.report.ending, Ending::finished);
  EXPECT_GT(session.report.ticks, 3500);
  EXPECT_EQ(session.report.axes[0].last_actual, 1640);
}

TEST(Transport, PlayedBackwardToItsBeginningItRestsThereAndWaits) {
  const Session left({{800, "r"}, {3000, "q"}});
  EXPECT_EQ(left.report.ending, Ending::stopped);
  EXPECT_GE(left.report.ticks, 3000);
  EXPECT_EQ(left.report.axes[0].last_actual, 60);
  const Session played({{800, "r"}, {3000, "\r"}});
  EXPECT_EQ(played.report.ending, Ending::finished);
  EXPECT_NEAR(static_cast<double>(played.report.ticks), 5000, 5);
  EXPECT_EQ(played.report.axes[0].last_actual, 1640);
}

TEST(Transport, HomeGoesBackAlongThePathAndRestsThere) {
  for (const std::vector<std::pair<int, std::string>>& before :
       {std::vector<std::pair<int, std::string>>{{1000, "\x1b[H"}},
        {{1000, " "}, {1200, "\x1b[H"}},
        {{1000, "\x1b"}, {1500, "a"}, {1600, "\x1b[H"}}}) {
    auto typed = before;
    typed.emplace_back(6000, "q");
    const Session session(typed);
    EXPECT_EQ(session.report.axes[0].last_actual, 60);
    EXPECT_GE(session.report.ticks, 6000) << "it does not play on by itself";
    typed.back().second = " ";
    EXPECT_EQ(Session(typed).report.axes[0].last_actual, 1640);
  }
  const Session latched({{1000, "\x1b"}, {1200, "\x1b[H"}, {6000, "q"}});
  EXPECT_GT(latched.report.axes[0].last_actual, 61) << "not before the stop is acknowledged";
}

TEST(Transport, APartOfAMoveBeginsAtItsOwnPreRollGoesHomeThereAndReversedPausesThere) {
  const Plan part(read_move_file(reveal), read_rig_file(camera_rig), {.frames = {80, 120}});
  const double start = part.played().rolls().before[0].rest_position();
  const double end = part.played().rolls().after[0].rest_position();
  constexpr double count = 0.001;
  ASSERT_GT(start, 200);
  ASSERT_LT(end, 1600);
  const auto play = [](const std::vector<std::pair<int, std::string>>& typed) {
    return Session(typed, RunOptions{}, {80, 120}).report;
  };
  const RunReport played = play({});
  EXPECT_EQ(played.ending, Ending::finished);
  EXPECT_EQ(played.reason, "frames 80..120 of 192 were played");
  EXPECT_NEAR(played.axes[0].last_actual, end, count);
  const std::int64_t ticks = part.played().last_tick_at(250) + 1;
  EXPECT_EQ(played.ticks, ticks);

  const RunReport home = play({{250, "\x1b[H"}, {6000, "q"}});
  EXPECT_NEAR(home.axes[0].last_actual, start, count);
  EXPECT_GE(home.ticks, 6000) << "it does not play on by itself";
  const RunReport back = play({{250, "r"}, {3000, "q"}});
  EXPECT_NEAR(back.axes[0].last_actual, start, count);
  EXPECT_GE(back.ticks, 3000);
  EXPECT_NEAR(play({{250, "\x1b"}, {800, "a"}, {900, "\r"}}).axes[0].last_actual, end, count);
}

struct Takes {
  TemporaryFolder folder;
  RunReport report;

  explicit Takes(const std::vector<std::pair<int, std::string>>& typed) {
    std::ofstream(folder.path() / "1.csv") << "of yesterday\n";
    report = Session(typed, RunOptions{.has_takes = true, .take_record = folder.path() / "%n.csv"}).report;
  }
  [[nodiscard]] long lines_of(const char* file) const {
    const std::string text = file_contents(folder.path() / file);
    return std::ranges::count(text, '\n');
  }
};

TEST(Takes, EachBeginsWhenSomebodyAsksAndHasARecordOfItsOwn) {
  const Takes takes({{500, "\r"},
                     {3000, "\x1b[H"},
                     {8000, "\r"},
                     {8500, "\x1b"},
                     {9000, "a"},
                     {9100, "\x1b[H"},
                     {14000, "\r"},
                     {16500, "q"}});
  EXPECT_EQ(takes.report.ending, Ending::finished) << takes.report.reason;
  EXPECT_EQ(takes.report.reason, "3 takes played, and left");
  ASSERT_EQ(takes.report.takes.size(), 3U);
  const std::array whole{true, false, true};
  for (std::size_t i = 0; i < 3; ++i) {
    const RunTake& take = takes.report.takes[i];
    EXPECT_EQ(take.number, static_cast<int>(i) + 2) << "1.csv is there already";
    EXPECT_EQ(take.is_whole, whole[i]) << i;
    EXPECT_EQ(take.record->lost, 0);
  }
  EXPECT_EQ(takes.lines_of("1.csv"), 1) << "of yesterday";
  EXPECT_NEAR(static_cast<double>(takes.lines_of("2.csv")), 2001, 2);
  EXPECT_NEAR(static_cast<double>(takes.lines_of("3.csv")), 1100, 10) << "until somebody went home";
  EXPECT_NEAR(static_cast<double>(takes.lines_of("4.csv")), 2001, 2);
  EXPECT_EQ(takes.report.axes[0].last_actual, 1640);
}

TEST(Takes, NothingMovesWithoutAnEnterThatCameWhileItWaited) {
  for (const char* keys : {" ", "r", "a", "+-", "g96", "k1\x7f", "\x1b[H", "\x1b", " r r "}) {
    const Takes takes({{500, keys}, {3000, "q"}});
    EXPECT_EQ(takes.report.takes.size(), 0U) << keys;
    EXPECT_EQ(takes.report.axes[0].last_actual, 60) << keys;
    EXPECT_EQ(takes.report.reason, "0 takes played, and left");
  }
  const Takes typed_ahead({{0, "\r"}, {3000, "q"}});
  EXPECT_EQ(typed_ahead.report.takes.size(), 0U);
}

TEST(Takes, ATakeBeginsNowhereButAtTheStart) {
  const Takes takes({{500, "\r\r"},
                     {600, "\r"},
                     {3000, "\r"},
                     {3500, "\x1b[H"},
                     {4000, "\r"},
                     {4500, " "},
                     {5000, "\r"},
                     {5200, " "},
                     {9000, "q"}});
  EXPECT_EQ(takes.report.takes.size(), 1U);
  EXPECT_LT(takes.report.axes[0].last_actual, 1640);
  EXPECT_GT(takes.report.axes[0].last_actual, 60) << "space stopped it on its way home";
}

TEST(Takes, LeavingInATakeIsNoEndOfIt) {
  const Takes takes({{500, "\r"}, {1000, "q"}});
  EXPECT_EQ(takes.report.ending, Ending::stopped);
  ASSERT_EQ(takes.report.takes.size(), 1U);
  EXPECT_FALSE(takes.report.takes[0].is_whole);
  EXPECT_GT(takes.lines_of("2.csv"), 500);
}

TEST(Transport, ASlowerRateTakesLonger) {
  const Session session({{0, "-----"}});
  EXPECT_EQ(session.report.ending, Ending::finished);
  EXPECT_NEAR(static_cast<double>(session.report.ticks), 4000, 60);
}

// The move begins at the drawn speed, and passes up to 20 ticks of it before the keys have slowed it down.
TEST(Transport, BelowATenthTheRateChangesByAHundredth) {
  const Session down({{0, std::string(9 + 5, '-')}});
  EXPECT_NEAR(static_cast<double>(down.report.ticks), 2000 / 0.05, 20 / 0.05);
  const Session up_again({{0, std::string(9 + 5, '-') + std::string(5 + 4, '+')}});
  EXPECT_NEAR(static_cast<double>(up_again.report.ticks), 2000 / 0.5, 20 / 0.5);
  const Session no_pause({{0, std::string(40, '-') + "+"}});
  EXPECT_NEAR(static_cast<double>(no_pause.report.ticks), 2000 / 0.02, 20 / 0.02);
}

// A slow move, and somebody who presses + until nothing more happens.
TEST(Transport, TheRateGoesUpToTheTopRateThatWasAskedForAndNotBeyond) {
  const std::string slow =
      "name = \"slow\"\nfps = 24\nframes = 960\n[[track]]\naxes = [\"pan\"]\n"
      "keys = [{ at = [0] }, { at = [40] }]\nspeed = [0, 0, 10, 10, 0, 0]\n";
  const Plan plan(parse_move(slow, "move.toml"), read_rig_file(camera_rig), {});
  for (const auto& [top, steps] : {std::pair(1.2, 2), {1.25, 3}, {1.0, 0}, {2.0, 10}, {1.0001, 1}}) {
    TickedRig rig(plan);
    const auto staged = checked_move(plan, top, Repeat::none);
    Transport transport(rig.loop, *staged, true);
    ASSERT_TRUE(transport.begin());
    for (int i = 0; i < steps; ++i) {
      EXPECT_LT(transport.snapshot().override_rate, top);
      transport.press(TransportKey::faster);
    }
    EXPECT_EQ(transport.snapshot().override_rate, top);
    transport.press(TransportKey::faster);
    EXPECT_EQ(transport.snapshot().override_rate, top);
    EXPECT_THAT(hint_line(transport.snapshot()), StartsWith("this is the top rate"));
    rig.tick(transport, 1000);
    EXPECT_EQ(transport.snapshot().rate, top) << "it plays at what it says";
    transport.press(TransportKey::slower);
    EXPECT_NEAR(transport.snapshot().override_rate, std::ceil(top * 10 - 1e-9) / 10 - 0.1, 1e-9);
  }
}

TEST(Transport, AStopHasToBeAcknowledgedAndStarted) {
  const Session session({{500, "\x1b"}, {1000, " "}, {1100, "\r"}, {1200, "a"}, {1300, "\r"}});
  EXPECT_EQ(session.report.ending, Ending::finished);
  EXPECT_GT(session.report.ticks, 2700);
  EXPECT_EQ(session.report.axes[0].last_actual, 1640);
}

TEST(Transport, LeavingStopsOnThePathFirst) {
  const Session session({{700, "q"}});
  EXPECT_EQ(session.report.ending, Ending::stopped);
  EXPECT_GT(session.report.ticks, 720);
  EXPECT_LT(session.report.ticks, 1000);
  EXPECT_NEAR(session.report.axes[0].last_actual, session.report.axes[0].last_commanded, 1e-3);
}

// docs/faults.md 41: a running move whose terminal is lost is stopped on the path, as one that is
// interrupted.
TEST(Transport, ALostTerminalStopsTheMoveOnThePath) {
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {});
  for (const int signal : {SIGHUP, SIGINT, SIGTERM}) {
    const InterruptWatch watch;
    int tick = 0;
    const auto asked = [&] {
      if (++tick == 900) std::raise(signal);  // the drives are switched on meanwhile
      return InterruptWatch::asked();
    };
    const RunReport report = run(plan, {.simulated = true, .fast = true, .audience = {.interrupted = asked}});
    EXPECT_EQ(report.ending, Ending::stopped) << signal;
    EXPECT_GT(report.ticks, 100) << signal;
    EXPECT_LT(report.ticks, 1200) << signal;
    EXPECT_NEAR(report.axes[0].last_actual, report.axes[0].last_commanded, 1e-3) << signal;
  }
}

// docs/faults.md 28: setpoints cease, and nothing resumes by itself when it is released.
TEST(Transport, AnEmergencyStopEndsAMoveThatNobodyAttends) {
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {});
  int tick = 0;
  const auto asked = [&] {
    if (++tick == 900) std::raise(SIGUSR1);
    return false;
  };
  const RunReport report = run(plan, {.simulated = true, .fast = true, .audience = {.interrupted = asked}});
  EXPECT_EQ(report.ending, Ending::fault);
  EXPECT_THAT(report.reason, HasSubstr("the emergency stop is pressed"));
  EXPECT_LT(report.axes[0].last_actual, 1640);
}

TEST(Transport, AfterAReleasedEmergencyStopTheRigIsAcknowledgedAndDoesNotJumpBack) {
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {});
  int tick = 0;
  const auto keys = [&]() -> std::string {
    ++tick;
    if (tick == 900) std::raise(SIGUSR1);
    if (tick == 1000) return "a\r";
    if (tick == 1100) std::raise(SIGUSR2);
    if (tick == 1200) return "\r";
    if (tick == 1300) return "a";
    if (tick == 3000) return "\r";
    return tick == 3200 ? "q" : "";
  };
  const RunReport report = run(plan, {.simulated = true, .fast = true, .audience = {.keys = keys}});
  EXPECT_NE(report.ending, Ending::finished);
  EXPECT_GT(report.axes[0].last_actual, 60);
  EXPECT_LT(report.axes[0].last_actual, 1640);
}

TEST(Transport, ToAndFroGoesOnUntilSomebodyLeaves) {
  const Session session({{9000, "q"}}, Repeat::ping_pong);
  EXPECT_EQ(session.report.ending, Ending::stopped);
  EXPECT_GT(session.report.ticks, 9000);
}

TEST(Transport, ALoopThatWouldStepIsRefusedWithItsAxis) {
  const ProgramRun run = run_program({"run", reveal, "--rig", camera_rig, "--sim", "--loop"});
  EXPECT_EQ(run.status, 3);
  EXPECT_THAT(run.err, HasSubstr("axis \"slide\": a loop would step"));
  const ProgramRun usage =
      run_program({"run", reveal, "--rig", camera_rig, "--sim", "--fast", "--ping-pong"});
  EXPECT_EQ(usage.status, 2);
  EXPECT_THAT(usage.err, HasSubstr("leave out --fast"));
}

TEST(Transport, ATriggerThatCameBeforeAnybodyWaitedStartsNothing) {
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {});
  TickedRig rig(plan);
  StagedMove staged(plan);
  bool has_told = true;
  const auto trigger = [&](std::int64_t) { return std::exchange(has_told, false); };
  Transport transport(rig.loop, staged, true, {.start = trigger});
  ASSERT_TRUE(transport.begin());
  rig.tick(transport, 100);
  EXPECT_EQ(rig.loop.state(), SupervisorState::ready) << "it waits";
  has_told = true;
  rig.tick(transport, 2);
  EXPECT_EQ(rig.loop.state(), SupervisorState::running);
}

TEST(Transport, ThePhasesOfAPartAreThoseOfItsOwnFrames) {
  const Plan plan(read_move_file(reveal), read_rig_file(camera_rig), {.frames = {80, 120}});
  TickedRig rig(plan);
  StagedMove staged(plan);
  Transport transport(rig.loop, staged, true);
  ASSERT_TRUE(transport.begin());
  std::vector<std::string> phases;
  std::string line;
  for (int i = 0; i < 1000 && !transport.is_over(); ++i) {
    rig.tick(transport, 1);
    const std::string phase = phase_of(transport.snapshot());
    if (phases.empty() || phases.back() != phase) phases.push_back(phase);
    if (phase == "playing") line = state_line(transport.snapshot());
  }
  EXPECT_THAT(phases, ElementsAre("pre-roll", "playing", "post-roll", "ready"));
  EXPECT_THAT(line, HasSubstr(" of 80..120  rate +1.00 of 1.00"));
}

}  // namespace transport_test
}  // namespace inbetween
