// An axis moves while a key is held, and no longer.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/linux/event_device.hpp"
#include "host_tools/loop/loop_preparations.hpp"
#include "host_tools/motions/jog.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "tests/support/event_pipe.hpp"
#include "tests/support/places.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"
#include "tests/support/terminal_screen.hpp"

namespace inbetween {
namespace held_jog_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string slider = rig_text({stepper_track()}, {.name = "slider", .rate_hz = 250});
constexpr double tick_s = 0.004;

/// An axis under the keys of a device, on a virtual clock. What happens to the key happens before the tick of
/// that number; while it is held that is told every eight ticks.
struct Bench {
  RigFile rig = parse_rig(slider, "rig.toml");
  SimulatedHardware hardware;
  RigInputs lines{rig, hardware};
  RigDrives drives{rig, hardware};
  LoopStorage room{1, 1};
  std::optional<RunLoop> loop;
  LoopTrace trace{1};
  LoopAudience audience;
  std::vector<std::size_t> drive_of{0};
  std::vector<AxisLimits> limits{limits_of(rig.axes[0])};
  std::optional<FreeAxes> free;
  std::optional<Jog> jog;
  std::optional<FastRunner> runner;

  std::map<int, TransportKey> keys;  ///< by tick
  int silent_from = 1'000'000;       ///< nobody is told of the device any more
  std::vector<double> path{0};       ///< by tick
  std::function<void(int)> look = [](int) {};

  explicit Bench(double at = 100, double reach = 50) : hardware(rig, std::vector<double>{at}) {
    loop.emplace(drives, lines, room.memory());
    free.emplace(std::vector{*FreeAxis::make(free_limits_of(rig.axes[0], 1), at, tick_s)});
    jog.emplace(
        *loop,
        FreeSpec{.source = source_of(*free), .drive_of = drive_of, .limits = limits, .tick_seconds = tick_s},
        *free,
        std::vector<JogAxis>{{.name = "track",
                              .unit = "mm",
                              .increments = {0.01, 0.05, 0.2, 1, 5},
                              .min = 0,
                              .max = 500,
                              .count = 1.0 / 40,
                              .is_referenced = true,
                              .reach = reach}},
        0, JogKeys{.device = true});
    audience.keys = [] { return std::string(); };
    audience.device = [this, held = false]() mutable {
      path.push_back(loop->setpoints()[0].position);
      const int tick = static_cast<int>(path.size()) - 1;
      look(tick);
      std::vector<TransportKey> now;
      if (keys.contains(tick) && tick < silent_from) {
        now.push_back(keys[tick]);
        held = keys[tick] == TransportKey::hold_forward || keys[tick] == TransportKey::hold_backward;
      } else if (held && tick % 8 == 0 && tick < silent_from) {
        now.push_back(TransportKey::still_held);
      }
      if (keys.contains(tick) && keys[tick] == TransportKey::quit) now = {TransportKey::quit};
      return now;
    };
    runner.emplace(*loop, 250, audience, trace);
    Arming arming(*loop);
    runner->run(arming, std::nullopt);
  }

  void run(int end) {
    keys[end] = TransportKey::quit;
    for (;;) {
      ASSERT_TRUE(runner->run(*jog, std::nullopt).begun);
      if (jog->asks() == Jog::Ask::none) return;
      if (jog->asks() == Jog::Ask::mark) {
        jog->marked();
      } else {
        jog->kept();
      }
    }
  }
  /// The last tick in which the axis had another position than in the one before.
  [[nodiscard]] int last_motion() const {
    int last = 0;
    for (std::size_t tick = 2; tick < path.size(); ++tick) {
      if (path[tick] != path[tick - 1]) last = static_cast<int>(tick);
    }
    return last;
  }
  /// From so many mm/s, and speeding up as quickly as it may, it takes this long to rest at the limits of the
  /// axis, in ticks: a / j until it does not speed up any more, (v + a^2 / 2j) / a + a / j until it rests,
  /// and a tick for each of the three changes and for the answer.
  [[nodiscard]] static int stop_ticks(double velocity) {
    constexpr double a = 1000, j = 20'000;
    return static_cast<int>(std::ceil((a / j + (velocity + a * a / (2 * j)) / a + a / j) / tick_s)) + 4;
  }
};

TEST(HeldJog, MovesWhileTheKeyIsHeldAndRestsWithinItsLimitsWhenItIsLetGo) {
  Bench bench;
  bench.keys = {{10, TransportKey::hold_forward}, {60, TransportKey::let_go}};
  bench.run(600);
  const auto& path = bench.path;
  EXPECT_GT(path[60], 110) << "not as slow as steps";
  EXPECT_LT(path.back(), 150) << "and ended before its reach";
  const double velocity = (path[60] - path[59]) / tick_s;
  EXPECT_LE(bench.last_motion(), 60 + Bench::stop_ticks(velocity));
}

TEST(HeldJog, HeldForAMinuteItEndsAtItsReachAndMustBePressedAnew) {
  Bench bench;
  bench.keys = {{10, TransportKey::hold_forward},
                {15'010, TransportKey::let_go},
                {15'020, TransportKey::hold_backward},
                {15'400, TransportKey::let_go}};
  bench.run(16'000);
  EXPECT_EQ(bench.path[15'000], 150);
  EXPECT_EQ(*std::ranges::max_element(bench.path), 150);
  EXPECT_EQ(bench.path.back(), 100) << "pressed anew it goes its reach again";
}

TEST(HeldJog, NeverGoesBeyondALimit) {
  Bench bench(490);
  bench.keys = {{10, TransportKey::hold_forward}};
  bench.run(1000);
  EXPECT_EQ(bench.path.back(), 500);
  EXPECT_EQ(*std::ranges::max_element(bench.path), 500);
}

TEST(HeldJog, SilenceIsTakenForLettingGoWithin200Milliseconds) {
  Bench bench(100, 400);
  bench.keys = {{10, TransportKey::hold_forward}};
  bench.silent_from = 40;
  bench.run(600);
  EXPECT_LE(bench.last_motion(), 40 + static_cast<int>(0.2 / tick_s) + Bench::stop_ticks(250));
  EXPECT_LT(bench.path.back(), 400);
}

TEST(HeldJog, AKeyThatIsPressedWhileItStillMovesBeginsNothing) {
  Bench bench;
  bench.keys = {
      {10, TransportKey::hold_forward}, {60, TransportKey::let_go}, {62, TransportKey::hold_backward}};
  std::string words;
  bench.look = [&](int tick) {
    if (tick == 70) words = bench.jog->snapshot().words;
  };
  bench.run(600);
  EXPECT_THAT(words, HasSubstr("press again"));
  EXPECT_GT(bench.path.back(), bench.path[60]);
}

TEST(HeldJog, ADetentOfAWheelIsAStep) {
  Bench bench;
  bench.keys = {
      {10, TransportKey::detent_forward}, {300, TransportKey::size_4}, {310, TransportKey::detent_backward}};
  bench.run(600);
  EXPECT_DOUBLE_EQ(bench.path[299], 100.2);
  EXPECT_DOUBLE_EQ(bench.path.back(), 99.2);
}

/// The ticks from a detent of the largest step to the last that it moves the axis in.
int ticks_of_a_step() {
  Bench bench;
  bench.keys = {{5, TransportKey::size_5}, {10, TransportKey::detent_forward}};
  bench.run(600);
  EXPECT_EQ(bench.path.back(), 105);
  return bench.last_motion() - 10;
}

TEST(HeldJog, AWheelThatWasSpunForASecondRestsWithinTheTimeOfOneStep) {
  const int step = ticks_of_a_step();
  for (const int period : {1, 2, 7, 25}) {  // up to 250 detents a second
    Bench bench;
    bench.keys = {{5, TransportKey::size_5}};
    int last = 0;
    for (int tick = 10; tick <= 260; tick += period) bench.keys[last = tick] = TransportKey::detent_forward;
    bool is_said = false;
    bench.look = [&](int) {
      const std::string words = bench.jog->snapshot().words;
      is_said = is_said || words.find("turns faster than the axis goes") != std::string::npos;
    };
    bench.run(900);
    EXPECT_LE(bench.last_motion(), last + step) << period;
    const double steps = (bench.path.back() - 100) / 5;
    EXPECT_EQ(steps, std::round(steps)) << "whole steps only";
    EXPECT_GE(steps, 2) << period;
    EXPECT_TRUE(is_said) << period;
  }
}

TEST(HeldJog, ADetentWhileAKeyIsHeldMovesNothing) {
  Bench bench;
  bench.keys = {
      {10, TransportKey::hold_forward}, {600, TransportKey::detent_backward}, {700, TransportKey::let_go}};
  bench.run(1000);
  EXPECT_EQ(bench.path.back(), 150);
}

/// A pipe that speaks as the device does, and who reads it.
struct EventDevice : testing::Test {
  TemporaryFolder folder;
  EventPipe pipe{folder.path() / "device"};
  inbetween::EventDevice device{pipe.path()};
};

TEST_F(EventDevice, TellsEachDetentOfAWheelOnce) {
  pipe.tell(EV_REL, REL_DIAL, 1);
  pipe.tell(EV_REL, REL_WHEEL, -1);
  EXPECT_THAT(device.events(), ElementsAre(HandEvent::detent_forward, HandEvent::detent_backward));
  pipe.report({{EV_REL, REL_WHEEL_HI_RES, 120}, {EV_REL, REL_WHEEL, 1}});
  EXPECT_THAT(device.events(), ElementsAre(HandEvent::detent_forward)) << "told twice by the kernel";
  pipe.tell(EV_REL, REL_DIAL, 1'000'000'000);
  EXPECT_EQ(device.events().size(), 2U) << "and no more than it takes to know that there were several";
}

TEST_F(EventDevice, AWheelOfHighResolutionHas120UnitsInADetentAndBeginsAnewTheOtherWay) {
  for (int i = 0; i < 3; ++i) pipe.tell(EV_REL, REL_WHEEL_HI_RES, 30);
  EXPECT_THAT(device.events(), IsEmpty());
  pipe.tell(EV_REL, REL_WHEEL_HI_RES, 30);
  EXPECT_THAT(device.events(), ElementsAre(HandEvent::detent_forward));
  pipe.tell(EV_REL, REL_WHEEL_HI_RES, 90);
  pipe.tell(EV_REL, REL_WHEEL_HI_RES, -90);
  EXPECT_THAT(device.events(), IsEmpty());
  pipe.tell(EV_REL, REL_WHEEL_HI_RES, -30);
  EXPECT_THAT(device.events(), ElementsAre(HandEvent::detent_backward));
}

TEST_F(EventDevice, ItsOtherKeysTypeWhatATerminalWouldAndCtrlCLeaves) {
  for (const std::uint16_t code :
       std::initializer_list<std::uint16_t>{KEY_UP, KEY_3, KEY_F1, KEY_ENTER, KEY_ESC}) {
    pipe.key(code, 1);
    pipe.key(code, 2);
    pipe.key(code, 0);
  }
  EXPECT_THAT(device.events(), IsEmpty());
  EXPECT_EQ(device.typed(), "\x1b[A3\r\x1b");
  pipe.key(KEY_LEFTCTRL, 1);
  pipe.key(KEY_C, 1);
  EXPECT_THAT(device.events(), IsEmpty());
  EXPECT_EQ(device.typed(), "q");
}

TEST_F(EventDevice, WhatFollowsLostEventsInTheirReportDoesNotCount) {
  pipe.report({{EV_SYN, SYN_DROPPED, 0}, {EV_KEY, KEY_RIGHT, 1}, {EV_REL, REL_DIAL, 1}});
  EXPECT_THAT(device.events(), IsEmpty());
}

TEST_F(EventDevice, TellsAKeyThatIsPressedAndLetGoAndNoRepeat) {
  EXPECT_THAT(device.events(), IsEmpty());
  pipe.key(KEY_RIGHT, 1);
  pipe.key(KEY_RIGHT, 2);
  pipe.key(KEY_A, 1);
  pipe.key(KEY_RIGHT, 0);
  pipe.tell(EV_ABS, ABS_HAT0X, -1);
  pipe.tell(EV_ABS, ABS_HAT0X, 0);
  EXPECT_THAT(device.events(),
              ElementsAre(HandEvent::forward, HandEvent::let_go, HandEvent::backward, HandEvent::let_go));
}

TEST_F(EventDevice, ASecondKeyEndsItUntilAllAreLetGo) {
  pipe.key(KEY_RIGHT, 1);
  pipe.key(KEY_LEFT, 1);
  pipe.key(KEY_RIGHT, 0);
  EXPECT_THAT(device.events(), ElementsAre(HandEvent::forward, HandEvent::let_go))
      << "left is still held, and begins nothing";
  pipe.key(KEY_LEFT, 0);
  pipe.key(KEY_LEFT, 1);
  EXPECT_THAT(device.events(), ElementsAre(HandEvent::backward));
}

TEST_F(EventDevice, EventsThatWereLostEndIt) {
  pipe.key(KEY_RIGHT, 1);
  pipe.tell(EV_SYN, SYN_DROPPED, 0);
  pipe.key(KEY_RIGHT, 2);
  EXPECT_THAT(device.events(), ElementsAre(HandEvent::forward, HandEvent::let_go));
}

TEST_F(EventDevice, ThatGoesAwayOrTellsHalfAnEventHoldsNothing) {
  for (const bool is_torn : {false, true}) {
    EventPipe failing(folder.path() / (is_torn ? "torn" : "gone"));
    inbetween::EventDevice of_it(failing.path());
    failing.key(KEY_RIGHT, 1);
    EXPECT_THAT(of_it.events(), ElementsAre(HandEvent::forward));
    if (is_torn) {
      failing.write("torn", 4);
    } else {
      failing.unplug();
    }
    EXPECT_THAT(of_it.events(), ElementsAre(HandEvent::let_go));
    EXPECT_TRUE(of_it.is_gone());
  }
}

TEST(HeldJog, OfADeviceThatIsUnpluggedRests) {
  const TemporaryFolder folder;
  const std::string rig = folder.path() / "rig.toml";
  std::ofstream(rig) << slider;
  EventPipe pipe(folder.path() / "device");
  TerminalScreen screen({"jog", "track", "--rig", rig, "--sim", "--from", "track=100", "--speed", "0.02",
                         "--device", pipe.path(), "--reach", "1"});
  screen.wait_for("track 100.000 mm in 0..500  reach 500  step 3: 0.2\n");
  pipe.key(KEY_RIGHT, 1);
  screen.wait_for("stops in ");
  pipe.unplug();
  screen.wait_for("  reach 500  step 3: 0.2\n");  // without a distance to stop
  screen.wait_for("the device is gone");
  screen.press("q");
  EXPECT_EQ(screen.wait_for_exit(), 0);
  EXPECT_THAT(screen.shown(), HasSubstr("left"));
}

TEST(HeldJog, OfAWheelMovesAStepADetentAndTheKeysOfTheDeviceDoWhatThoseOfTheTerminalDo) {
  const TemporaryFolder folder;
  const std::string rig = folder.path() / "rig.toml";
  std::ofstream(rig) << slider;
  EventPipe pipe(folder.path() / "device");
  TerminalScreen screen(
      {"jog", "track", "--rig", rig, "--sim", "--from", "track=100", "--device", pipe.path()});
  screen.wait_for("track 100.000 mm in 0..500  reach 50  step 3: 0.2\n");
  pipe.tell(EV_REL, REL_DIAL, 1);
  screen.wait_for("track 100.200 mm");
  pipe.key(KEY_4, 1);
  screen.wait_for("step 4: 1\n");
  pipe.tell(EV_REL, REL_WHEEL, -1);
  screen.wait_for("track 99.200 mm");
  pipe.key(KEY_Q, 1);
  EXPECT_EQ(screen.wait_for_exit(), 0);
  EXPECT_THAT(screen.shown(), HasSubstr("left"));
}

TEST(HeldJog, ADeviceThatCannotBeOpenedIsOneLine) {
  const TemporaryFolder folder;
  const std::string rig = folder.path() / "rig.toml";
  std::ofstream(rig) << slider;
  TerminalScreen screen({"jog", "track", "--rig", rig, "--sim", "--device", "nowhere"}, 120);
  EXPECT_EQ(screen.wait_for_exit(), 1);
  EXPECT_THAT(screen.shown(), HasSubstr("nowhere: error: the device cannot be used: No such file or "
                                        "directory; name one of /dev/input/by-id"));
}

/// At a run a held key scrubs, and a detent of the wheel is a frame.
TEST(HeldKeys, OfADeviceAtARunGoAlongThePathUntilTheyAreLetGo) {
  const TemporaryFolder folder;
  EventPipe pipe(folder.path() / "device");
  TerminalScreen screen({"run", in_checkout("examples/reveal.toml"), "--rig",
                         in_checkout("examples/camera_rig.toml"), "--sim", "--device", pipe.path()});
  screen.wait_for("playing  frame ");
  screen.press("Space");
  screen.wait_for("paused  frame ");
  pipe.key(KEY_RIGHT, 1);
  screen.wait_for("going along the path  frame ");
  pipe.key(KEY_RIGHT, 0);
  screen.wait_for("paused  frame ");
  pipe.unplug();
  screen.wait_for("the device is gone");
  screen.press("q");
  EXPECT_EQ(screen.wait_for_exit(), 4);
}

TEST(HeldKeys, AreForSomebodyAtATerminal) {
  const ProgramRun run =
      run_program({"run", in_checkout("examples/reveal.toml"), "--rig",
                   in_checkout("examples/camera_rig.toml"), "--sim", "--fast", "--device", "nowhere"});
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.err, HasSubstr("--device is for somebody at a terminal"));
}

}  // namespace held_jog_test
}  // namespace inbetween
