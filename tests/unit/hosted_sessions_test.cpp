// Whole sessions of scripted hosts with a simulated rig. What the rig's own drives have recorded is held
// against what was uploaded, frame by frame, and against the sheet of the protocol, by formulas of this file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/hosted_rig_scene.hpp"

namespace inbetween {
namespace hosted_sessions_test {

using dragonframe::DmcStage;
using testing::HasSubstr;
using Motors = std::vector<std::vector<std::int32_t>>;
using Lines = std::vector<std::string>;

constexpr unsigned ok = 0x10;
constexpr unsigned loop = 0x02, ping_pong = 0x01;

/// Frames of a run: the first `count` of them are those `first`, `first` + `direction`, ... of the upload,
/// and the first is played `lead_s` after GO, which is a tick of the record.
struct PlayedFrames {
  std::size_t go_tick = 0;
  double lead_s = 0;
  double fps = 25;
  std::int32_t first = 1;
  int direction = 1;
  std::int32_t count = 0;
};

/// The greatest distance of the record from the upload, in steps, at all of these frames and motors.
double worst_at_frames(const HostedRigScene& scene, const Motors& motors, const PlayedFrames& frames) {
  double worst = 0;
  for (std::int32_t k = 0; k < frames.count; ++k) {
    const double ticks =
        static_cast<double>(frames.go_tick) + (frames.lead_s + k / frames.fps) * scene.rig.rate_hz;
    const auto row = static_cast<std::size_t>(frames.first + frames.direction * k - 1);
    for (std::size_t m = 0; m < motors.size(); ++m)
      worst = std::max(worst, std::fabs(scene.recorded_steps(m, ticks) - motors[m].at(row)));
  }
  return worst;
}

TEST(HostedSessions, ARunAtTwentyFourFramesHasEveryFrameBetweenTicks) {
  HostedScene scene(hosted_rig_text(2));
  const Motors motors{host_wave(240, 40, 2), host_wave(240, -70, 1)};
  ASSERT_TRUE(scene.stand_on_first_frame(motors)) << scene.last_words();
  // 12 frames of pre-roll are half a second, and a frame is 10.42 ticks.
  ASSERT_EQ(scene.ask(scene.host.jog_all(24'000, 51)), ok);
  scene.run_until_still();
  ASSERT_EQ(scene.ask(scene.host.run(
                {.fps_1000 = 24'000, .start = 51, .end = 180, .preroll_ms = 1000, .postroll_ms = 1000})),
            ok)
      << scene.last_words();
  scene.run_until(DmcStage::wait);
  const auto at = [&](std::size_t m, std::int32_t frame) {
    return static_cast<double>(motors[m].at(static_cast<std::size_t>(frame - 1)));
  };
  for (std::size_t m = 0; m < 2; ++m) {
    const double speed = 24 * (at(m, 52) - at(m, 51));
    EXPECT_NEAR(scene.steps(m), at(m, 51) - speed / 2, 1) << "half a second's way before the first frame";
  }
  const std::size_t go = scene.go();
  scene.run_until(DmcStage::jog);
  scene.run_for(0.1);
  EXPECT_LE(
      worst_at_frames(scene, motors, {.go_tick = go, .lead_s = 1, .fps = 24, .first = 51, .count = 131}), 1);
  // Frame 181 is behind the last; a second later everything rests half a second's way on.
  const double rest = static_cast<double>(go) + (1 + 130 / 24.0 + 1) * 250;
  for (std::size_t m = 0; m < 2; ++m) {
    const double speed = 24 * (at(m, 181) - at(m, 180));
    EXPECT_NEAR(scene.recorded_steps(m, std::ceil(rest)), at(m, 181) + speed / 2, 1);
  }
  EXPECT_EQ(scene.pushed(0x0114), 1U);
}

TEST(HostedSessions, ARunBackwardsHasEveryFrame) {
  HostedScene scene(hosted_rig_text(2));
  const Motors motors{host_wave(200, 40, 2), host_wave(200, -70, 1)};
  ASSERT_TRUE(scene.stand_on_first_frame(motors)) << scene.last_words();
  ASSERT_EQ(scene.ask(scene.host.jog_all(25'000, 150)), ok);
  scene.run_until_still();
  ASSERT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 150, .end = 40})), ok)
      << scene.last_words();
  const std::size_t go = scene.go();
  scene.run_until(DmcStage::jog);
  EXPECT_LE(worst_at_frames(scene, motors,
                            {.go_tick = go, .lead_s = 1, .first = 150, .direction = -1, .count = 112}),
            1);
}

TEST(HostedSessions, EveryRoundOfALoopIsTheUpload) {
  HostedScene scene(hosted_rig_text(2));
  Motors motors{host_wave(60, 10, 0), host_wave(60, -20, 0)};
  // There and back: the frame behind the last, where the table stands still, is the first.
  for (std::vector<std::int32_t>& steps : motors) steps.insert(steps.end(), steps.rbegin(), steps.rend());
  ASSERT_TRUE(scene.stand_on_first_frame(motors)) << scene.last_words();
  ASSERT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 1, .end = 120, .flags = loop})), ok)
      << scene.last_words();
  const std::size_t go = scene.go();
  const std::size_t pushed_before = scene.pushed(0x0034);
  scene.run_for(1 + 3.5 * 120 / 25);
  ASSERT_EQ(scene.ask(scene.host.stop_loop()), ok);
  scene.run_until(DmcStage::jog);
  for (int round = 0; round < 4; ++round) {
    EXPECT_LE(worst_at_frames(scene, motors, {.go_tick = go, .lead_s = 1 + round * 120 / 25.0, .count = 120}),
              1)
        << round;
  }
  scene.run_for(1);
  EXPECT_EQ(scene.pushed(0x0114), 1U);
  EXPECT_EQ(scene.position(0), 0);
  // A position at each frame of each round, once, and ten a second.
  EXPECT_GE(scene.pushed(0x0034) - pushed_before, 4U * 120);
  EXPECT_LE(scene.pushed(0x0034) - pushed_before, 4U * 120 + 10 * 22);
}

TEST(HostedSessions, PingPongIsTheUploadThereAndBack) {
  HostedScene scene(hosted_rig_text(2));
  const Motors motors{host_wave(101, 20, 1), host_wave(101, -30, 0)};
  ASSERT_TRUE(scene.stand_on_first_frame(motors)) << scene.last_words();
  ASSERT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 1, .end = 100, .flags = ping_pong})), ok)
      << scene.last_words();
  const std::size_t go = scene.go();
  scene.run_for(1 + 3.5 * 4);
  ASSERT_EQ(scene.ask(scene.host.stop_loop()), ok);
  scene.run_until(DmcStage::jog);
  scene.run_for(0.1);
  for (int way = 0; way < 4; ++way) {
    const bool is_back = way % 2 == 1;
    EXPECT_LE(worst_at_frames(scene, motors,
                              {.go_tick = go,
                               .lead_s = 1 + way * 4.0,
                               .first = is_back ? 101 : 1,
                               .direction = is_back ? -1 : 1,
                               .count = 101}),
              1)
        << way;
  }
}

/// Where the motors of a SHOOT_FRAME2 are: an eighth of the turn to gather speed, six of it at speed, one to
/// lose it.
double of_turn(double from, double to, double turn_s, double seconds) {
  const double speed = 8.0 / 7 * (to - from) / turn_s;
  const double eighth = turn_s / 8;
  if (seconds <= 0) return from;
  if (seconds >= turn_s) return to;
  if (seconds < eighth) {
    const double u = seconds / eighth;
    return from + speed * eighth * (u * u * u - u * u * u * u / 2);
  }
  if (seconds > 7 * eighth) return to - (of_turn(from, to, turn_s, turn_s - seconds) - from);
  return from + speed * eighth / 2 + speed * (seconds - eighth);
}

TEST(HostedSessions, ShootsAFrameWithATurnOfAShutter) {
  HostedScene scene(hosted_rig_text(2));
  const Motors motors{host_ramp(100, 1000), host_ramp(100, -400)};
  ASSERT_TRUE(scene.stand_on_first_frame(motors)) << scene.last_words();
  struct Case {
    int open_deg, close_deg;
    std::uint32_t exposure_ms;
  };
  for (const Case& shot : {Case{90, 270, 1000}, Case{0, 360, 500}, Case{-90, 90, 500}, Case{180, 450, 1000},
                           Case{90, 270, 250}}) {
    SCOPED_TRACE(shot.open_deg);
    const double s_per_deg = shot.exposure_ms / 1000.0 / (shot.close_deg - shot.open_deg);
    const double wait_s = std::max(0, -shot.open_deg) * s_per_deg;
    // The first from the table, the second by a way of the host's.
    ASSERT_EQ(scene.ask(scene.host.shoot2(20, shot.exposure_ms, {shot.open_deg, shot.close_deg},
                                          {{2, -7000, -8000}})),
              ok)
        << scene.last_words();
    scene.run_until(DmcStage::wait);
    EXPECT_EQ(scene.steps(0), 18'500);
    EXPECT_EQ(scene.steps(1), -7000);
    const std::size_t ends = scene.pushed(0x0114);
    const std::size_t go = scene.go();
    scene.run_until(DmcStage::jog);
    EXPECT_EQ(scene.pushed(0x0114), ends + 1);
    double worst = 0;
    for (std::size_t tick = go; tick + 1 < scene.path.size(); ++tick) {
      const double seconds = static_cast<double>(tick - go) / 250 - wait_s;
      worst = std::max(worst, std::fabs(scene.recorded_steps(0, static_cast<double>(tick)) -
                                        of_turn(18'500, 19'500, 360 * s_per_deg, seconds)));
      worst = std::max(worst, std::fabs(scene.recorded_steps(1, static_cast<double>(tick)) -
                                        of_turn(-7000, -8000, 360 * s_per_deg, seconds)));
    }
    EXPECT_LE(worst, 1) << "steps, at every tick";
    const double holds_s = std::max(0, shot.close_deg - 360) * s_per_deg;
    EXPECT_GE(static_cast<double>(scene.path.size() - go) / 250, wait_s + 360 * s_per_deg + holds_s - 0.004);
  }
}

/// Where a motor of `bf` is so long behind `go`: a second to gather speed, half of the exposure from the blur
/// of the frame before to this one, half to the blur of the next, a second to lose speed.
double of_blur(double from, double here, double to, double exposure_s, double seconds) {
  const double first = (here - from) / (exposure_s / 2);
  const double second = (to - here) / (exposure_s / 2);
  const auto ramp = [](double u) { return u * u * u - u * u * u * u / 2; };
  const double into = seconds - 1;
  if (seconds <= 0) return from - first / 2;
  if (into < 0) return from - first / 2 + first * ramp(seconds);
  if (into < exposure_s / 2) return from + first * into;
  if (into < exposure_s) return here + second * (into - exposure_s / 2);
  const double behind = std::min(into - exposure_s, 1.0);
  return to + second * (0.5 - ramp(1 - behind));
}

TEST(HostedSessions, DfmocoShootsABlurWithRampsOfASecond) {
  HostedDfmocoScene scene(hosted_rig_text(3));
  EXPECT_THAT(scene.told, testing::ElementsAre("hi 2 3 2.0.0"));
  ASSERT_TRUE(scene.device.arm());
  for (const char* rate : {"pr 1 20000", "pr 2 20000", "pr 3 20000"}) EXPECT_EQ(scene.ask(rate), Lines{rate});
  // Half of the way: 500 steps in 0.35 s, then 1000; a motor at one speed; and one that stays.
  ASSERT_EQ(scene.ask("bf 700 500 1 9000 10000 12000 2 1000 0 -1000"), Lines{"bf 1000"})
      << scene.last_words();
  EXPECT_EQ(scene.ask("ms"), Lines{"ms 110"});
  EXPECT_EQ(scene.ask("go"), Lines{"parse error"}) << "on the way to the start";
  scene.run_until_still();
  EXPECT_EQ(scene.ask("ms"), Lines{"ms 000"});
  const double exposure_s = 0.7;
  EXPECT_EQ(scene.steps(0), 8785) << "half a second's way before 9500, towards 0 to a whole step";
  EXPECT_EQ(scene.steps(1), 1214);
  ASSERT_EQ(scene.ask("go"), Lines{"go"}) << scene.last_words();
  const std::size_t go = scene.path.size() - 1;
  EXPECT_EQ(scene.ask("mm 3 100"), Lines{"parse error"});
  scene.run_for(2.8);
  EXPECT_EQ(scene.ask("ms"), Lines{"ms 000"}) << "2.7 s, the ramps among them";
  double worst = 0, at_corner = 0;
  for (std::size_t tick = 0; tick <= 690; ++tick) {
    const double seconds = static_cast<double>(tick) / 250;
    const double at = static_cast<double>(go + tick);
    const double one =
        std::fabs(scene.recorded_steps(0, at) - of_blur(9500, 10'000, 11'000, exposure_s, seconds));
    const double two = std::fabs(scene.recorded_steps(1, at) - of_blur(500, 0, -500, exposure_s, seconds));
    const bool is_beside_corner = std::fabs(seconds - 1.35) < 0.1;
    (is_beside_corner ? at_corner : worst) = std::max(is_beside_corner ? at_corner : worst, one);
    worst = std::max(worst, two);
    EXPECT_EQ(scene.recorded_steps(2, at), 0);
  }
  EXPECT_LE(worst, 1) << "steps, at every tick, the ends of the exposure among them";
  const double middle = static_cast<double>(go) + 1.35 * 250;
  EXPECT_NEAR(scene.recorded_steps(0, middle), 10'000, 1) << "the frame itself, in the middle";
  EXPECT_LE(at_corner, 6) << "no motor changes its speed in no time: 4 ms of the difference, for 0.1 s";
  EXPECT_EQ(scene.ask("go"), Lines{"parse error"}) << "each shot has a bf of its own";
}

TEST(HostedSessions, DfmocoBlursNothingThatBreaksALimit) {
  HostedDfmocoScene scene(hosted_rig_text(1));
  EXPECT_EQ(scene.ask("bf 500 500 1 0 1000 2000"), Lines{"parse error"}) << "nobody has agreed";
  ASSERT_TRUE(scene.device.arm());
  EXPECT_EQ(scene.ask("bf 500 1000 1 170000 179900 180000"), Lines{"bf -1"}) << "faster than 20 000 steps/s";
  EXPECT_EQ(scene.ask("bf 1000 1000 1 179000 179500 180000"), Lines{"bf -1"}) << "its end is beyond 180 deg";
  EXPECT_THAT(scene.last_words(), HasSubstr("180"));
  EXPECT_EQ(scene.ask("bf 500 500 2 0 1000 2000"), Lines{"parse error"}) << "there is no such motor";
  scene.run_for(1);
  EXPECT_EQ(scene.position(0), 0);
  EXPECT_EQ(scene.marks, 0U);
  EXPECT_EQ(scene.ask("go"), Lines{"parse error"});
}

}  // namespace hosted_sessions_test
}  // namespace inbetween
