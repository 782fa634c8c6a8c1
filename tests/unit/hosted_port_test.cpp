// Whole sessions over a pseudo-terminal: a scripted host at one end, a simulated rig behind the other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/support/hosted_port_scene.hpp"

namespace inbetween {
namespace hosted_port_test {

using testing::Contains;
using testing::HasSubstr;
using Motors = std::vector<std::vector<std::int32_t>>;
using Lines = std::vector<std::string>;

constexpr unsigned ok = 0x10, moving = 0x12, unsupported = 0x13, range = 0x14, general = 0x15,
                   not_in_position = 0x16, soft_upper = 0x20, hard_lower = 0x23;

void agree(HostedPortScene& scene) {
  scene.line.agree();
  scene.tick();
  ASSERT_TRUE(scene.line.is_armed()) << scene.last_words();
}

/// In blocks of 100 frames, the motors in turns, as the order of blocks is free.
void upload(HostedPortScene& scene, const Motors& motors) {
  const std::size_t frames = motors.front().size();
  for (unsigned m = 1; m <= motors.size(); ++m) {
    ASSERT_EQ(scene.ask(scene.dmc.configure(m, 0x03)), ok);
    ASSERT_EQ(scene.ask(scene.dmc.speed(m, 60'000, 200'000)), ok);
  }
  ASSERT_EQ(scene.ask(scene.dmc.upload_begin(1, static_cast<std::int32_t>(frames))), ok);
  for (std::size_t first = 0; first < frames; first += 100) {
    for (unsigned m = 1; m <= motors.size(); ++m) {
      const auto from = motors[m - 1].begin() + static_cast<std::ptrdiff_t>(first);
      const auto to = motors[m - 1].begin() + static_cast<std::ptrdiff_t>(std::min(first + 100, frames));
      ASSERT_EQ(scene.ask(scene.dmc.upload_axis(m, static_cast<std::uint32_t>(first),
                                                to == motors[m - 1].end(), {from, to})),
                ok);
    }
  }
  ASSERT_EQ(scene.ask(scene.dmc.upload_end()), ok) << scene.last_words();
}

/// The distance of the record from the upload in steps, at all frames from `first` to `last` of a run of 25 a
/// second whose first frame is a second behind GO.
double worst_at_frames(const HostedPortScene& scene, const Motors& motors, std::size_t go, std::int32_t first,
                       std::int32_t last) {
  double worst = 0;
  for (std::int32_t frame = first; frame <= last; ++frame) {
    const double tick = static_cast<double>(go) + 250 + 10 * (frame - first);
    for (std::size_t m = 0; m < motors.size(); ++m) {
      const double asked = motors[m].at(static_cast<std::size_t>(frame - 1));
      worst = std::max(worst, std::fabs(scene.recorded_steps(m, tick) - asked));
    }
  }
  return worst;
}

void say_hello(HostedPortScene& scene) {
  scene.plug();
  scene.tick();
  ASSERT_FALSE(scene.heard.empty());
  EXPECT_EQ(scene.heard.front().type, 0x0001U) << "it greets by itself";
  ASSERT_EQ(scene.ask(scene.dmc.hi()), 0U);
  const oracle::DmcHeard hi = scene.dmc.data().value();
  ASSERT_EQ(hi.payload.size(), 51U);
  EXPECT_EQ(hi.payload[35], 8) << "motors";
  EXPECT_EQ(hi.number(41, 4), 9997U) << "frames of an upload";
  EXPECT_EQ(hi.number(49, 2), 2U) << "the version of the protocol";
}

/// Errors have their codes, and change nothing.
void meet_errors(HostedPortScene& scene) {
  EXPECT_EQ(scene.ask(scene.dmc.move(9, 0)), range);
  EXPECT_EQ(scene.ask(scene.dmc.move(1, 180'001)), soft_upper);
  EXPECT_EQ(scene.ask(scene.dmc.ask(0x0031, {1, 0})), general) << "too short";
  EXPECT_EQ(scene.ask(scene.dmc.ask(0x0020, {1, 0, 0, 0})), unsupported) << "DMX";
  EXPECT_EQ(scene.ask(scene.dmc.ask(0x0203, {0})), unsupported) << "virtual axes";
  EXPECT_EQ(scene.ask(scene.dmc.run({.fps_1000 = 25'000, .start = 1, .end = 2000})), not_in_position);
  EXPECT_EQ(scene.ask(scene.dmc.go()), not_in_position);
}

void play_all(HostedPortScene& scene, const Motors& motors) {
  ASSERT_EQ(scene.ask(scene.dmc.position_frame(1)), ok);
  scene.run_until_still();
  ASSERT_EQ(scene.ask(scene.dmc.run({.fps_1000 = 25'000, .start = 1, .end = 2000})), ok);
  const std::size_t go = scene.go();
  EXPECT_EQ(scene.ask(scene.dmc.move(1, 0)), moving) << "a motor does not leave a run";
  scene.run_until_still();
  scene.run_for(0.1);
  EXPECT_LE(worst_at_frames(scene, motors, go, 1, 2000), 1) << "steps";
}

void stop_in_the_middle_and_jog(HostedPortScene& scene, const Motors& motors) {
  ASSERT_EQ(scene.ask(scene.dmc.position_frame(500)), ok);
  scene.run_until_still();
  ASSERT_EQ(scene.ask(scene.dmc.run({.fps_1000 = 25'000, .start = 500, .end = 1500})), ok);
  const std::size_t go = scene.go();
  scene.run_for(10);
  ASSERT_EQ(scene.ask(scene.dmc.stop_all()), ok);
  EXPECT_LE(worst_at_frames(scene, motors, go, 500, 500 + 9 * 25 - 2), 1);
  scene.run_until_still();
  EXPECT_EQ(scene.ask(scene.dmc.jog(2, 5000, 2'147'483'647)), hard_lower)
      << "for 2 s behind a stop in motion";
  scene.run_for(2.1);
  EXPECT_EQ(scene.ask(scene.dmc.jog(2, 5000, 2'147'483'647)), general) << "and it took the consent away";
  agree(scene);
  const double stood = scene.position(1);
  ASSERT_EQ(scene.ask(scene.dmc.jog(2, 5000, 2'147'483'647)), ok);
  scene.run_for(0.4);
  ASSERT_EQ(scene.ask(scene.dmc.stop(2)), ok);
  scene.run_until_still();
  EXPECT_GT(scene.position(1), stood);
  EXPECT_EQ(scene.ask(scene.dmc.run({.fps_1000 = 25'000, .start = 500, .end = 1500})), not_in_position);
}

void shoot_a_frame(HostedPortScene& scene, const Motors& motors) {
  ASSERT_EQ(scene.ask(scene.dmc.shoot(1000, true, 500, 500)), ok) << scene.last_words();
  const std::size_t go = scene.go();
  scene.run_until_still();
  scene.run_for(0.1);
  const auto at = [&](std::size_t m, std::size_t frame) {
    return static_cast<double>(motors[m].at(frame - 1));
  };
  for (std::size_t m = 0; m < 8; ++m) {
    const double opens = at(m, 1000) - (at(m, 1000) - at(m, 999)) / 4;
    const double closes = at(m, 1000) + (at(m, 1001) - at(m, 1000)) / 4;
    EXPECT_NEAR(scene.recorded_steps(m, static_cast<double>(go) + 250), opens, 1) << m;
    EXPECT_NEAR(scene.recorded_steps(m, static_cast<double>(go) + 375), closes, 1) << m;
  }
}

void go_round(HostedPortScene& scene) {
  Motors round{host_wave(50, 10, 0)};
  round[0].insert(round[0].end(), round[0].rbegin(), round[0].rend());
  upload(scene, round);
  ASSERT_EQ(scene.ask(scene.dmc.position_frame(1)), ok);
  scene.run_until_still();
  ASSERT_EQ(scene.ask(scene.dmc.run({.fps_1000 = 25'000, .start = 1, .end = 100, .flags = 0x02})), ok);
  const std::size_t go = scene.go();
  scene.run_for(1 + 2.5 * 4);
  ASSERT_EQ(scene.ask(scene.dmc.stop_loop()), ok);
  scene.run_until_still();
  scene.run_for(0.1);
  for (std::size_t turn = 0; turn < 3; ++turn)
    EXPECT_LE(worst_at_frames(scene, round, go + turn * 1000, 1, 100), 1);
}

TEST(HostedPort, DmcHasAWholeSession) {
  HostedPortScene scene(hosted_rig_text(8), HostProtocol::dmc);
  ASSERT_NO_FATAL_FAILURE(say_hello(scene));
  Motors motors;
  for (int m = 0; m < 8; ++m) motors.push_back(host_wave(2000, 20 + 10 * m, m));
  EXPECT_EQ(scene.ask(scene.dmc.upload_begin(1, 9998)), range) << "more than it has room for";
  upload(scene, motors);
  EXPECT_EQ(scene.ask(scene.dmc.position_frame(1)), general) << "nobody has agreed";
  EXPECT_THAT(scene.words, Contains(HasSubstr("agree")));
  agree(scene);
  ASSERT_NO_FATAL_FAILURE(meet_errors(scene));
  ASSERT_NO_FATAL_FAILURE(play_all(scene, motors));
  ASSERT_NO_FATAL_FAILURE(stop_in_the_middle_and_jog(scene, motors));
  ASSERT_NO_FATAL_FAILURE(shoot_a_frame(scene, motors));
  ASSERT_NO_FATAL_FAILURE(go_round(scene));
}

TEST(HostedPort, DfmocoHasAWholeSession) {
  HostedPortScene scene(hosted_rig_text(4), HostProtocol::dfmoco);
  scene.plug();
  EXPECT_THAT(scene.ask("hi"), Contains("hi 2 4 2.0.0"));
  EXPECT_EQ(scene.ask("mm 1 100"), Lines{"parse error"}) << "nobody has agreed";
  agree(scene);
  for (const char* rate : {"pr 1 20000", "pr 2 20000"}) EXPECT_EQ(scene.ask(rate), Lines{rate});
  EXPECT_EQ(scene.ask("mm 1 250"), Lines{"mm 1 250"});
  EXPECT_EQ(scene.ask("ms"), Lines{"ms 1000"});
  scene.run_until_still();
  EXPECT_EQ(scene.ask("ms"), Lines{"ms 0000"});
  EXPECT_EQ(scene.steps(0), 250);
  EXPECT_EQ(scene.ask("np 2 500"), Lines{"mp 2 500"});
  EXPECT_EQ(scene.ask("jm 2 1000000 10000"), Lines{"jm 2"});
  scene.run_for(0.3);
  EXPECT_THAT(scene.ask("sm 2"), Contains("sm 2"));
  scene.run_until_still();
  EXPECT_GT(scene.steps(1), 500);
  EXPECT_EQ(scene.ask("mm 1 180001"), Lines{"parse error"}) << "beyond the limit of the rig";

  ASSERT_EQ(scene.ask("bf 500 500 1 1000 2000 3000 3 0 0 200"), Lines{"bf 1000"})
      << testing::PrintToString(scene.words);
  scene.run_until_still();
  ASSERT_EQ(scene.ask("go"), Lines{"go"});
  const std::size_t go = scene.path.size() - 1;
  scene.run_for(2.6);
  const auto recorded = [&](std::size_t motor, double seconds) {
    return scene.recorded_steps(motor, static_cast<double>(go) + 250 * seconds);
  };
  EXPECT_NEAR(recorded(0, 0), 1500 - 1000, 1) << "half a second's way before";
  EXPECT_NEAR(recorded(0, 1), 1500, 1) << "the shutter opens";
  EXPECT_NEAR(recorded(0, 1.25), 2000, 1);
  EXPECT_NEAR(recorded(0, 1.5), 2500, 1) << "it closes";
  EXPECT_NEAR(recorded(0, 2.5), 2500 + 1000, 1);
  EXPECT_NEAR(recorded(2, 1.25), 0, 1) << "it begins in the middle of the exposure";
  EXPECT_NEAR(recorded(2, 1.5), 100, 1);
  EXPECT_EQ(recorded(3, 1.5), 0) << "it is not in the shot";
  EXPECT_EQ(scene.ask("sa"), Lines{"sa"});
  scene.unplug();
  scene.tick();
  EXPECT_THAT(scene.words, Contains(HasSubstr("the host is gone")));
}

}  // namespace hosted_port_test
}  // namespace inbetween
