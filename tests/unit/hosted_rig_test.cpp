// A host of Dragonframe's DMC drives a simulated rig: positions, jogs, an upload and its run, stops, errors.
#include "host_tools/hosted/hosted_rig.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/hosted_rig_scene.hpp"

namespace inbetween {
namespace hosted_rig_test {

using dragonframe::DmcStage;
using testing::HasSubstr;

constexpr unsigned ok = 0x10, general = 0x15, not_in_position = 0x16, preroll = 0x17, soft_upper = 0x20,
                   soft_lower = 0x21;

TEST(HostedRig, MovesNothingBeforeSomebodyAgrees) {
  HostedScene scene(hosted_rig_text(1));
  EXPECT_EQ(scene.ask(scene.host.move(1, 1000)), general);
  scene.run_for(1);
  EXPECT_EQ(scene.position(0), 0);
  EXPECT_EQ(scene.marks, 0U);
  ASSERT_TRUE(scene.device.arm());
  EXPECT_EQ(scene.ask(scene.host.move(1, 1000)), ok);
  scene.run_until_still();
  EXPECT_EQ(scene.position(0), 1) << "a degree, to the last bit";
  EXPECT_EQ(scene.steps(0), 1000);
  EXPECT_GT(scene.marks, 0U);
  scene.run_for(1);
  EXPECT_EQ(scene.keeps, 1) << "where it rests is kept, once";
}

TEST(HostedRig, GoesNowhereBeyondTheLimitsOfTheRig) {
  HostedScene scene(hosted_rig_text(1));
  ASSERT_TRUE(scene.device.arm());
  EXPECT_EQ(scene.ask(scene.host.move(1, 180'001)), soft_upper);
  EXPECT_EQ(scene.ask(scene.host.move(1, -180'001)), soft_lower);
  scene.run_for(0.1);
  EXPECT_EQ(scene.position(0), 0);
  ASSERT_FALSE(scene.words.empty());
  EXPECT_THAT(scene.words.front(), HasSubstr("180.001 deg, outside its limits -180..180 deg"));
  EXPECT_EQ(scene.ask(scene.host.speed(1, 500'000, 900'000)), ok);
  EXPECT_EQ(scene.ask(scene.host.move(1, 180'000)), ok);
  scene.run_until_still();
  EXPECT_EQ(scene.steps(0), 180'000);
  double fastest = 0;
  for (const HostedTick& tick : scene.path) fastest = std::max(fastest, std::fabs(tick.axes[0].velocity));
  EXPECT_LE(fastest, 60 + 1e-9) << "whatever the host has set";
  EXPECT_GT(fastest, 59);
}

TEST(HostedRig, IsNoFasterThanTheHostHasSet) {
  HostedScene scene(hosted_rig_text(1));
  ASSERT_TRUE(scene.device.arm());
  ASSERT_EQ(scene.ask(scene.host.speed(1, 5000, 10'000)), ok);
  ASSERT_EQ(scene.ask(scene.host.move(1, 20'000)), ok);
  scene.run_until_still();
  double fastest = 0, hardest = 0;
  for (const HostedTick& tick : scene.path) {
    fastest = std::max(fastest, std::fabs(tick.axes[0].velocity));
    hardest = std::max(hardest, std::fabs(tick.axes[0].acceleration));
  }
  EXPECT_NEAR(fastest, 5, 1e-6);
  EXPECT_LE(hardest, 10 + 1e-6);
}

TEST(HostedRig, JogsUntilTheHostIsSilent) {
  HostedScene scene(hosted_rig_text(1));
  ASSERT_TRUE(scene.device.arm());
  ASSERT_EQ(scene.ask(scene.host.speed(1, 20'000, 100'000)), ok);
  for (int i = 0; i < 10; ++i) {
    ASSERT_EQ(scene.ask(scene.host.jog(1, 10'000, 2'147'483'647)), ok);
    scene.run_for(0.2);
  }
  EXPECT_NEAR(scene.path.back().axes[0].velocity, 20, 1e-6);
  const double here = scene.position(0);
  scene.run_until_still();
  EXPECT_GT(scene.position(0), here);
  EXPECT_LT(scene.position(0), here + 20 * 0.6) << "half a second, and the stop";
}

TEST(HostedRig, CountsAsTheHostSaysWithoutMoving) {
  HostedScene scene(hosted_rig_text(1));
  ASSERT_TRUE(scene.device.arm());
  ASSERT_EQ(scene.ask(scene.host.reset(1, 50'000)), ok);
  scene.run_for(0.1);
  EXPECT_EQ(scene.steps(0), 50'000);
  EXPECT_EQ(scene.position(0), 0);
  ASSERT_EQ(scene.ask(scene.host.move(1, 51'000)), ok);
  scene.run_until_still();
  EXPECT_EQ(scene.position(0), 1);
  EXPECT_EQ(scene.ask(scene.host.move(1, 230'001)), soft_upper) << "the limits stay where they are";
}

/// Where each axis was when the frames of a run were played, counted from the tick of the first.
void expect_run_as_uploaded(const HostedScene& scene, const std::vector<std::vector<std::int32_t>>& motors,
                            std::size_t first_tick, double fps) {
  double worst = 0;
  for (std::size_t frame = 0; frame < motors.front().size(); ++frame) {
    const double tick =
        static_cast<double>(first_tick) + static_cast<double>(frame) * scene.rig.rate_hz / fps;
    if (tick != std::floor(tick)) continue;
    for (std::size_t m = 0; m < motors.size(); ++m) {
      const double at = scene.path.at(static_cast<std::size_t>(tick)).axes[m].position * host_steps_per_deg;
      worst = std::max(worst, std::fabs(at - motors[m][frame]));
    }
  }
  EXPECT_LE(worst, 1) << "steps";
}

TEST(HostedRig, PlaysAnUploadOfTwoThousandFramesAndEightAxesToOneStep) {
  HostedScene scene(hosted_rig_text(8));
  ASSERT_TRUE(scene.device.arm());
  std::vector<std::vector<std::int32_t>> motors;
  for (int m = 0; m < 8; ++m) {
    motors.push_back(host_wave(2000, 20 + 10 * m, m));
    ASSERT_EQ(scene.ask(scene.host.speed(static_cast<unsigned>(m + 1), 60'000, 200'000)), ok);
  }
  ASSERT_EQ(scene.upload(1, motors), ok) << scene.last_words();
  ASSERT_EQ(scene.ask(scene.host.run({.start = 1, .end = 2000})), not_in_position);
  ASSERT_EQ(scene.ask(scene.host.position_frame(1)), ok);
  scene.run_until_still();
  // 25 frames a second are 10 ticks each.
  ASSERT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 1, .end = 2000, .preroll_ms = 1000})), ok)
      << scene.last_words();
  scene.run_until(DmcStage::wait);
  scene.run_for(1);
  scene.heard.clear();
  ASSERT_EQ(scene.ask(scene.host.go()), ok);
  const std::size_t go_tick = scene.path.size();
  scene.run_until(DmcStage::jog);
  EXPECT_EQ(scene.pushed(0x0114), 1U) << "END, once";
  // The pre-roll takes its second; a tick after GO the run is a tick old.
  expect_run_as_uploaded(scene, motors, go_tick - 1 + 250, 25);
  EXPECT_GE(scene.pushed(0x0034), 2000U) << "a position at each frame";
}

TEST(HostedRig, GathersSpeedInThePreRollAndLosesItInThePostRoll) {
  HostedScene scene(hosted_rig_text(2));
  ASSERT_TRUE(scene.stand_on_first_frame({host_ramp(100, 400), host_ramp(100, -200)})) << scene.last_words();
  // 10 deg/s and 5 deg/s from frame 11 to 60, a second before and behind.
  ASSERT_EQ(scene.ask(scene.host.jog_all(25'000, 11)), ok);
  scene.run_until_still();
  EXPECT_EQ(scene.steps(0), 4000);
  ASSERT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 11, .end = 60})), ok)
      << scene.last_words();
  scene.run_until(DmcStage::wait);
  EXPECT_EQ(scene.steps(0), 4000 - 5000) << "half a second's way before its first frame";
  EXPECT_EQ(scene.steps(1), -2000 + 2500);
  ASSERT_EQ(scene.ask(scene.host.go()), ok);
  const std::size_t first = scene.path.size() - 1 + 250;
  scene.run_until(DmcStage::jog);
  for (std::size_t k = 0; k < 50; ++k) {
    EXPECT_NEAR(scene.path.at(first + 10 * k).axes[0].position, 0.4 * static_cast<double>(10 + k), 1e-3);
    EXPECT_NEAR(scene.path.at(first + 10 * k).axes[1].position, -0.2 * static_cast<double>(10 + k), 1e-3);
  }
  scene.run_until_still();
  EXPECT_EQ(scene.steps(0), 24'000) << "and then the frame behind the last, as the sheet says";
}

TEST(HostedRig, StopsInTheMiddleOfARunOnItsPath) {
  HostedScene scene(hosted_rig_text(2));
  ASSERT_TRUE(scene.stand_on_first_frame({host_wave(200, 40, 0), host_wave(200, 80, 0)}))
      << scene.last_words();
  ASSERT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 1, .end = 200})), ok)
      << scene.last_words();
  scene.run_until(DmcStage::wait);
  ASSERT_EQ(scene.ask(scene.host.go()), ok);
  scene.run_for(5);
  ASSERT_EQ(scene.ask(scene.host.stop_all()), ok);
  scene.run_until_still();
  EXPECT_GT(scene.steps(0), 1000);
  EXPECT_LT(scene.steps(0), 39'000);
  // The second axis goes twice as far as the first, everywhere.
  for (const HostedTick& tick : scene.path)
    EXPECT_NEAR(tick.axes[1].position, 2 * tick.axes[0].position, 2e-3);
  EXPECT_FALSE(scene.device.is_armed());
  EXPECT_EQ(scene.pushed(0x0114), 0U) << "no END behind a stop";
  const double rests = scene.position(0);
  scene.run_for(3);
  EXPECT_EQ(scene.ask(scene.host.move(1, 0)), general) << "nobody has agreed again";
  scene.run_for(1);
  EXPECT_EQ(scene.position(0), rests);
}

TEST(HostedRig, RefusesWhatItsLimitsDoNotHold) {
  HostedScene scene(hosted_rig_text(1));
  ASSERT_TRUE(scene.device.arm());
  EXPECT_EQ(scene.upload(1, {host_wave(100, 181, 0)}), soft_upper);
  EXPECT_THAT(scene.last_words(), HasSubstr("of the uploaded move"));
  EXPECT_EQ(scene.upload(1, {host_wave(100, -181, 0)}), soft_lower);
  scene.run_for(0.1);
  EXPECT_EQ(scene.ask(scene.host.position_frame(1)), general) << "there is no move";
  // In two seconds 170 degrees are too fast for 60 deg/s: the upload is fine, its run is not.
  ASSERT_EQ(scene.upload(1, {host_wave(50, 170, 0)}), ok);
  ASSERT_EQ(scene.ask(scene.host.position_frame(1)), ok);
  scene.run_until_still();
  EXPECT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 1, .end = 50})), general);
  scene.tick();
  EXPECT_THAT(scene.last_words(), HasSubstr("velocity"));
  EXPECT_EQ(scene.ask(scene.host.run({.fps_1000 = 5'000, .start = 1, .end = 50})), ok) << "slower it is";
}

TEST(HostedRig, RefusesAPreRollThatIsTooShort) {
  HostedScene scene(hosted_rig_text(1));
  ASSERT_TRUE(scene.stand_on_first_frame({host_ramp(100, 1000)})) << scene.last_words();
  // To 25 deg/s in 0.12 s takes 200 deg/s^2 in the mean, and 240 at most are there.
  EXPECT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 1, .end = 50, .preroll_ms = 120})),
            preroll);
  EXPECT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 1, .end = 50, .preroll_ms = 0})), preroll);
  EXPECT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 1, .end = 50, .postroll_ms = 120})),
            0x18U);
  EXPECT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 1, .end = 50})), ok);
}

TEST(HostedRig, ComesRoundUntilTheLoopIsStopped) {
  HostedScene scene(hosted_rig_text(1));
  std::vector<std::int32_t> there = host_wave(50, 10, 0);
  there.push_back(there.back());
  ASSERT_TRUE(scene.stand_on_first_frame({there})) << scene.last_words();
  ASSERT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 1, .end = 50, .flags = 0x01})), ok)
      << scene.last_words();
  scene.run_until(DmcStage::wait);
  ASSERT_EQ(scene.ask(scene.host.go()), ok);
  scene.run_for(1 + 4 * 2);
  EXPECT_EQ(scene.device.stage(), DmcStage::shoot) << "there and back twice";
  EXPECT_EQ(scene.pushed(0x0114), 0U);
  ASSERT_EQ(scene.ask(scene.host.stop_loop()), ok);
  scene.run_until(DmcStage::jog);
  EXPECT_EQ(scene.pushed(0x0114), 1U);
}

TEST(HostedRig, ExposesAFrameInMotion) {
  HostedScene scene(hosted_rig_text(1));
  ASSERT_TRUE(scene.stand_on_first_frame({host_ramp(100, 1000)})) << scene.last_words();
  // Half a frame, half a degree, in 0.5 s: 1 deg/s.
  ASSERT_EQ(scene.ask(scene.host.shoot(20, true, 500, 500)), ok) << scene.last_words();
  scene.run_until(DmcStage::wait);
  ASSERT_EQ(scene.ask(scene.host.go()), ok);
  const std::size_t go_tick = scene.path.size() - 1;
  scene.run_until(DmcStage::jog);
  EXPECT_EQ(scene.pushed(0x0114), 1U);
  for (std::size_t tick = 250; tick <= 375; ++tick) {
    const double seconds = static_cast<double>(tick - 250) / 250;
    EXPECT_NEAR(scene.path.at(go_tick + tick).axes[0].position, 18.75 + seconds, 2e-3) << tick;
  }
  EXPECT_NEAR(scene.position(0), 19.25 + 0.5, 2e-3) << "a second before and behind";
}

TEST(HostedRig, TellsTheHostOfAStopByTheRig) {
  HostedScene scene(hosted_rig_text(1));
  ASSERT_TRUE(scene.device.arm());
  ASSERT_EQ(scene.ask(scene.host.speed(1, 60'000, 200'000)), ok);
  ASSERT_EQ(scene.ask(scene.host.move(1, 100'000)), ok);
  scene.run_for(1);
  scene.loop.post(SupervisorEvent::stop);
  scene.run_until_still();
  EXPECT_EQ(scene.pushed(0x003A), 1U);
  EXPECT_FALSE(scene.device.is_armed());
  EXPECT_FALSE(scene.hosted->is_ready());
  scene.run_for(3);
  scene.hosted->acknowledge();
  scene.run_for(1);
  ASSERT_TRUE(scene.hosted->is_ready());
  ASSERT_TRUE(scene.device.arm());
  ASSERT_EQ(scene.ask(scene.host.move(1, 0)), ok);
  scene.run_until_still();
  EXPECT_EQ(scene.position(0), 0);
}

/// Two lamps and a clapper, of which the host has numbers in this order.
std::string rig_with_outputs() {
  return hosted_rig_text(1) + R"([output.a_lamp]
chip = "relays"
line = 3
[output.b_lamp]
chip = "others"
line = 0
[output.clapper]
chip = "relays"
line = 7
)";
}

TEST(HostedRig, SwitchesTheOutputsOfTheRig) {
  HostedScene scene(rig_with_outputs());
  ASSERT_EQ(scene.ask(scene.host.hi()), 0U);
  EXPECT_EQ(scene.host.data()->payload.at(38), 3) << "outputs";
  EXPECT_EQ(scene.ask(scene.host.ask(0x0021, {0x05, 0, 0, 0})), ok) << "they need no consent";
  scene.tick();
  EXPECT_EQ(scene.path.back().outputs, 0x05U);
  EXPECT_EQ(scene.ask(scene.host.ask(0x0021, {0x08, 0, 0, 0})), 0x14U) << "there is no fourth";
  scene.tick();
  EXPECT_EQ(scene.path.back().outputs, 0x05U);
  scene.device.disconnect(scene.now_ns);
  scene.tick();
  EXPECT_EQ(scene.path.back().outputs, 0U) << "with the host they are off";
  EXPECT_EQ(scene.outputs->trouble(), "");
}

TEST(HostedRig, PlaysTriggersAndTheBloopOnItsOutputs) {
  HostedScene scene(rig_with_outputs());
  ASSERT_TRUE(scene.stand_on_first_frame({host_wave(60, 10, 0)})) << scene.last_words();
  ASSERT_EQ(scene.ask(scene.host.upload_begin(1, 60)), ok);
  ASSERT_EQ(scene.ask(scene.host.upload_axis(1, 0, true, host_wave(60, 10, 0))), ok);
  // The lamps at frames 11 and 31, the second one alone from there on.
  ASSERT_EQ(scene.ask(scene.host.upload_triggers(0x03, {{10, 1}, {11, 1}, {30, 2}})), ok);
  ASSERT_EQ(scene.ask(scene.host.upload_end()), ok);
  ASSERT_EQ(scene.ask(scene.host.position_frame(1)), ok);
  scene.run_until_still();
  ASSERT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000,
                                      .start = 1,
                                      .end = 59,
                                      .is_synced = true,
                                      .bloop_bits = 0x04,
                                      .bloop_ms = 400})),
            ok);
  const std::size_t go = scene.go();
  scene.run_until(DmcStage::jog);
  scene.run_for(0.2);
  const auto outputs_at = [&](std::size_t frame) {
    return scene.path.at(go + 250 + 10 * (frame - 1) + 2).outputs;
  };
  EXPECT_EQ(scene.path.at(go + 2).outputs, 0x04U) << "the bloop begins with GO";
  EXPECT_EQ(scene.path.at(go + 98).outputs, 0x04U);
  EXPECT_EQ(scene.path.at(go + 103).outputs, 0U) << "and is over 0.4 s later";
  for (std::size_t frame = 1; frame <= 59; ++frame) {
    const std::uint32_t lamps = frame == 11 || frame == 12 ? 1 : frame == 31 ? 2 : 0;
    EXPECT_EQ(outputs_at(frame), lamps) << frame << ", within two ticks of it";
  }
  EXPECT_EQ(outputs_at(60), 0x04U) << "and a bloop at the end";
}

}  // namespace hosted_rig_test
}  // namespace inbetween
