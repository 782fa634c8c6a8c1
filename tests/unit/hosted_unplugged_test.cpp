// A host that is unplugged, or dies, at any moment of anything; and noise on the port. The rig rests on its
// path, and the next host has nothing of the last one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "tests/support/hosted_port_scene.hpp"

namespace inbetween {
namespace hosted_unplugged_test {

using dragonframe::DmcStage;

constexpr unsigned ok = 0x10, general = 0x15;
constexpr LimitsText limits{.velocity = 60, .acceleration = 240, .jerk = 6000};
constexpr double stop_acceleration = 1.5 * limits.acceleration;

/// The second motor goes twice as far as the first, the other way, at every frame: on the path it does so at
/// every tick, within the rounding of steps.
std::vector<std::vector<std::int32_t>> two_on_a_line() {
  std::vector<std::vector<std::int32_t>> motors{host_wave(46, 4, 0), {}};
  // There and back, so that it may go round.
  motors[0].insert(motors[0].end(), motors[0].rbegin() + 1, motors[0].rend());
  for (const std::int32_t step : motors[0]) motors[1].push_back(-2 * step);
  return motors;
}

enum class Doing : std::uint8_t { moves, jogs, goes_to_a_frame, goes_along, waits, runs, loops, shoots };
constexpr int kinds_of_doing = 8;

/// Begins it, from frame 1 of the upload. Whether from now on both motors are on their line.
bool begin(HostedScene& scene, Doing what) {
  std::vector<unsigned> codes;
  switch (what) {
    case Doing::moves:
      codes = {scene.ask(scene.host.move(1, 30'000)), scene.ask(scene.host.move(2, 20'000))};
      break;
    case Doing::jogs:
      codes = {scene.ask(scene.host.jog(1, 10'000, 2'147'483'647)),
               scene.ask(scene.host.jog(2, 7000, -2'147'483'647))};
      break;
    case Doing::goes_to_a_frame:
      codes = {scene.ask(scene.host.position_frame(40))};
      break;
    case Doing::goes_along:
      codes = {scene.ask(scene.host.jog_all(25'000, 46))};
      break;
    case Doing::waits:
    case Doing::runs:
    case Doing::loops:
      codes = {scene.ask(scene.host.run({.fps_1000 = 25'000,
                                         .start = 1,
                                         .end = 91,
                                         .preroll_ms = 200,
                                         .flags = what == Doing::loops ? 0x02U : 0U}))};
      break;
    case Doing::shoots:
      codes = {scene.ask(scene.host.shoot(15, true, 500, 500))};
      break;
  }
  if (what == Doing::runs || what == Doing::loops || what == Doing::shoots) {
    scene.run_until(DmcStage::wait);
    codes.push_back(scene.ask(scene.host.go()));
  }
  for (const unsigned code : codes) EXPECT_EQ(code, ok) << scene.last_words();
  return what == Doing::goes_along || what == Doing::waits || what == Doing::runs || what == Doing::loops;
}

/// Every tick of the record keeps every limit of a stop, and is where the last one has led.
void expect_kept_limits(const HostedRigScene& scene) {
  double fastest = 0, hardest = 0, jump = 0;
  for (std::size_t tick = 1; tick < scene.path.size(); ++tick) {
    for (std::size_t a = 0; a < 2; ++a) {
      const Setpoint& is = scene.path[tick].axes[a];
      const Setpoint& was = scene.path[tick - 1].axes[a];
      fastest = std::max(fastest, std::fabs(is.velocity));
      hardest = std::max(hardest, std::fabs(is.acceleration));
      jump = std::max(jump, std::fabs(is.position - was.position - (is.velocity + was.velocity) / 2 / 250));
    }
  }
  EXPECT_LE(fastest, limits.velocity + 1e-9);
  EXPECT_LE(hardest, stop_acceleration + 1e-6);
  EXPECT_LE(jump, 1e-3);
}

void expect_on_line(const HostedScene& scene) {
  double worst = 0;
  for (const HostedTick& tick : scene.path)
    worst = std::max(worst, std::fabs(tick.axes[1].position + 2 * tick.axes[0].position));
  EXPECT_LE(worst, 3e-3);
}

TEST(HostedUnplugged, AThousandTimesAtAnyMomentItRestsOnItsPath) {
  constexpr unsigned seed = 20261129;
  std::mt19937 random(seed);
  HostedScene scene(hosted_rig_text(2, limits));
  for (int trial = 0; trial < 1000; ++trial) {
    const auto what = static_cast<Doing>(random() % kinds_of_doing);
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", trial " << trial << ", "
                                    << static_cast<int>(what));
    ASSERT_TRUE(scene.stand_on_first_frame(two_on_a_line())) << scene.last_words();
    scene.path.erase(scene.path.begin(), scene.path.end() - 1);
    const bool is_on_line = begin(scene, what);
    scene.run_for(std::uniform_real_distribution<double>(0, 3)(random));
    scene.device.disconnect(scene.now_ns);
    scene.run_for(0.7);
    EXPECT_EQ(scene.hosted->state().moving, 0U);
    const double rests[] = {scene.position(0), scene.position(1)};
    scene.run_for(0.1);
    EXPECT_EQ(scene.position(0), rests[0]);
    EXPECT_EQ(scene.position(1), rests[1]);
    expect_kept_limits(scene);
    if (is_on_line) expect_on_line(scene);
    ASSERT_TRUE(scene.device.connect(scene.now_ns));
    EXPECT_EQ(scene.ask(scene.host.position_frame(1)), general) << "the move is forgotten";
    EXPECT_EQ(scene.ask(scene.host.move(1, 0)), general) << "and so is the consent";
    EXPECT_EQ(scene.ask(scene.host.status()), 0U);
    EXPECT_EQ(scene.host.data()->number(0, 4), 0U);
    if (testing::Test::HasFailure()) return;
  }
}

TEST(HostedUnplugged, OverAPortToo) {
  constexpr unsigned seed = 20261130;
  std::mt19937 random(seed);
  HostedPortScene scene(hosted_rig_text(2, limits), HostProtocol::dmc);
  for (int trial = 0; trial < 12; ++trial) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", trial " << trial);
    scene.plug();
    EXPECT_EQ(scene.ask(scene.dmc.move(1, 1000)), general) << "nobody has agreed";
    scene.line.agree();
    scene.tick();
    const std::int32_t target = trial % 2 == 0 ? 50'000 : -50'000;
    for (const unsigned motor : {1U, 2U}) {
      ASSERT_EQ(scene.ask(scene.dmc.speed(motor, 60'000, 200'000)), ok);
      ASSERT_EQ(scene.ask(scene.dmc.move(motor, target)), ok) << scene.last_words();
    }
    scene.run_for(std::uniform_real_distribution<double>(0, 1)(random));
    // Some go in the midst of a message.
    const oracle::DmcBytes next = scene.dmc.move(1, 0);
    scene.write(std::span(next).first(random() % next.size()));
    scene.unplug();
    scene.run_for(0.7);
    EXPECT_FALSE(scene.line.is_connected());
    EXPECT_FALSE(scene.line.is_armed());
    EXPECT_EQ(scene.hosted->state().moving, 0U);
    const double rests = scene.position(0);
    scene.run_for(0.2);
    EXPECT_EQ(scene.position(0), rests);
    expect_kept_limits(scene);
  }
}

}  // namespace hosted_unplugged_test
}  // namespace inbetween
