// What is not a whole message, at the port of a rig that is ready to move: noise, damaged and split messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "tests/support/hosted_rig_scene.hpp"

namespace inbetween {
namespace hosted_noise_test {

using dragonframe::DmcStage;
using oracle::DmcBytes;

constexpr unsigned ok = 0x10;
constexpr std::size_t million = 1'000'000;

/// Random bytes; every second time, what a host would say with one bit wrong.
DmcBytes noise(std::mt19937& random, oracle::DmcHost& host) {
  DmcBytes bytes;
  if (random() % 2 == 0) {
    for (int i = 0; i < 1000; ++i) bytes.push_back(static_cast<std::uint8_t>(random()));
    return bytes;
  }
  while (bytes.size() < 1000) {
    DmcBytes said = random() % 3 == 0   ? host.stop_all()
                    : random() % 2 == 0 ? host.move(1 + random() % 2, static_cast<std::int32_t>(random()))
                                        : host.run({.start = 1, .end = 50});
    // Not in its first two bytes alone: what follows the wrong one is heard as well.
    said[random() % said.size()] ^= static_cast<std::uint8_t>(1U << random() % 8);
    bytes.insert(bytes.end(), said.begin(), said.end());
  }
  return bytes;
}

TEST(HostedNoise, AMillionBytesInARunChangeNothingOfIt) {
  constexpr unsigned seed = 20261129;
  std::mt19937 random(seed);
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  HostedScene scene(hosted_rig_text(2));
  const std::vector<std::vector<std::int32_t>> motors{host_wave(120, 20, 1), host_wave(120, -30, 0)};
  ASSERT_TRUE(scene.stand_on_first_frame(motors)) << scene.last_words();
  ASSERT_EQ(scene.ask(scene.host.run({.fps_1000 = 25'000, .start = 1, .end = 119})), ok);
  const std::size_t go = scene.go();
  oracle::DmcHost other;
  std::size_t bytes = 0;
  while (scene.device.stage() == DmcStage::shoot) {
    const DmcBytes heard = noise(random, other);
    bytes += heard.size();
    scene.device.hear(heard, scene.now_ns);
    scene.tick();
  }
  scene.run_for(0.1);
  EXPECT_GE(bytes, million);
  EXPECT_EQ(scene.pushed(0x0114), 1U) << "it was played to its end";
  for (std::size_t frame = 1; frame <= 120; ++frame) {
    const double tick = static_cast<double>(go + 250 + 10 * (frame - 1));
    for (std::size_t m = 0; m < 2; ++m) EXPECT_NEAR(scene.recorded_steps(m, tick), motors[m][frame - 1], 1);
  }
  EXPECT_TRUE(scene.device.is_armed());
  scene.run_for(1);
  EXPECT_EQ(scene.ask(scene.host.position_frame(60)), ok) << "and the next message is understood";
}

/// How the rig is, as far as a host could have changed it.
struct Standing {
  std::vector<double> positions{};
  std::vector<std::int32_t> steps{};
  std::size_t marks = 0;
  bool is_armed = false;
  bool operator==(const Standing&) const = default;
};
Standing standing(const HostedRigScene& scene, const auto& device) {
  Standing now{.marks = scene.marks, .is_armed = device.is_armed()};
  for (std::size_t a = 0; a < scene.rig.axes.size(); ++a) {
    now.positions.push_back(scene.position(a));
    now.steps.push_back(scene.steps(a));
  }
  return now;
}

TEST(HostedNoise, AMillionBytesMoveNothingThatIsReady) {
  constexpr unsigned seed = 20261130;
  std::mt19937 random(seed);
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  HostedScene dmc(hosted_rig_text(2));
  HostedDfmocoScene dfmoco(hosted_rig_text(2));
  ASSERT_TRUE(dmc.device.arm() && dfmoco.device.arm());
  ASSERT_EQ(dfmoco.ask("mm 1 500").size(), 1U);
  dfmoco.run_until_still();
  ASSERT_EQ(dmc.ask(dmc.host.move(2, 700)), ok);
  dmc.run_until_still();
  const Standing dmc_before = standing(dmc, dmc.device), dfmoco_before = standing(dfmoco, dfmoco.device);
  for (std::size_t heard = 0; heard < million; heard += 1000) {
    DmcBytes bytes(1000);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    dmc.device.hear(bytes, dmc.now_ns);
    dfmoco.device.hear(bytes, dfmoco.now_ns);
    dmc.tick();
    dfmoco.tick();
  }
  EXPECT_EQ(standing(dmc, dmc.device), dmc_before);
  EXPECT_EQ(standing(dfmoco, dfmoco.device), dfmoco_before);
  // A line may have begun in the noise.
  static_cast<void>(dfmoco.ask(""));
  EXPECT_EQ(dfmoco.ask("mp 1"), std::vector<std::string>{"mp 1 500"});
  dmc.run_for(1);
  EXPECT_EQ(dmc.ask(dmc.host.move(2, 0)), ok);
}

/// A request in two parts, a tick apart. It is answered once, behind the second.
unsigned ask_in_parts(HostedScene& scene, const DmcBytes& request, std::size_t at) {
  at = std::min(at, request.size() - 1);
  scene.device.hear(std::span(request).first(at), scene.now_ns);
  scene.tick();
  EXPECT_EQ(scene.host.answers(), 0U) << at;
  return scene.ask({request.begin() + static_cast<std::ptrdiff_t>(at), request.end()});
}

TEST(HostedNoise, MessagesMayBeSplitAnywhere) {
  const std::vector<std::int32_t> steps = host_wave(20, 2, 0);
  const std::size_t longest = oracle::DmcHost().upload_axis(1, 0, true, steps).size();
  for (std::size_t at = 1; at < longest; ++at) {
    SCOPED_TRACE(at);
    HostedScene scene(hosted_rig_text(1));
    ASSERT_TRUE(scene.device.arm());
    const auto ask = [&](const DmcBytes& request) { return ask_in_parts(scene, request, at); };
    ASSERT_EQ(ask(scene.host.hi()), 0U);
    ASSERT_EQ(ask(scene.host.configure(1, 3)), ok);
    ASSERT_EQ(ask(scene.host.speed(1, 60'000, 200'000)), ok);
    ASSERT_EQ(ask(scene.host.upload_begin(1, 20)), ok);
    ASSERT_EQ(ask(scene.host.upload_axis(1, 0, true, steps)), ok);
    ASSERT_EQ(ask(scene.host.upload_end()), ok);
    ASSERT_EQ(ask(scene.host.position_frame(1)), ok);
    ASSERT_EQ(ask(scene.host.run({.fps_1000 = 25'000, .start = 1, .end = 19, .preroll_ms = 200})), ok);
    scene.run_until(DmcStage::wait);
    ASSERT_EQ(ask(scene.host.go()), ok);
    const std::size_t go = scene.path.size() - 1;
    scene.run_until(DmcStage::jog);
    scene.run_for(0.1);
    for (std::size_t frame = 1; frame <= 20; ++frame)
      EXPECT_NEAR(scene.recorded_steps(0, static_cast<double>(go + 50 + 10 * (frame - 1))), steps[frame - 1],
                  1);
  }
}

TEST(HostedNoise, LinesMayBeSplitAnywhere) {
  const std::string blur = "bf 500 500 1 0 100 200";
  for (std::size_t at = 1; at <= blur.size() + 1; ++at) {
    SCOPED_TRACE(at);
    HostedDfmocoScene scene(hosted_rig_text(1));
    ASSERT_TRUE(scene.device.arm());
    const auto ask = [&](const std::string& line) {
      const std::vector<std::uint8_t> bytes = oracle::dfmoco_bytes(line);
      const std::size_t first = std::min(at, bytes.size() - 1);
      scene.told.clear();
      scene.device.hear(std::span(bytes).first(first), scene.now_ns);
      scene.tick();
      scene.device.hear(std::span(bytes).subspan(first), scene.now_ns);
      scene.tick();
      return scene.told;
    };
    EXPECT_EQ(ask("pr 1 20000"), std::vector<std::string>{"pr 1 20000"});
    EXPECT_EQ(ask(blur), std::vector<std::string>{"bf 1000"});
    scene.run_until_still();
    EXPECT_EQ(scene.steps(0), -50);
    EXPECT_EQ(ask("go"), std::vector<std::string>{"go"});
    scene.run_for(3);
    EXPECT_EQ(scene.steps(0), 250);
  }
}

}  // namespace hosted_noise_test
}  // namespace inbetween
