// A move shot frame by frame: who waits for whom, and when the camera has its signal.
#include "inbetween/play/frame_shoot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "host_tools/check/planned_stops.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/loop/motion_loop.hpp"
#include "sim/simulated_rig.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/simulated_lines.hpp"

namespace inbetween {
namespace frame_shoot_test {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double tick_s = 1.0 / 250;

const std::string glide = R"(name = "glide"
fps = 12
frames = 6
[[track]]
axes = ["pan", "track"]
keys = [ { at = [10, 100] }, { at = [12, 104] }, { at = [9, 110] } ]
speed = [0, 0, 10, 0, 0]
)";

const std::string crane_rig = rig_text(
    {{.name = "pan", .unit = "deg", .min = -90, .max = 90, .max_velocity = 120, .max_acceleration = 4000},
     {.name = "track", .min = 0, .max = 500, .max_velocity = 250, .max_acceleration = 8000}},
    {.rate_hz = 250});

/// A rig that is armed and shot frame by frame. Its second axis stands still if it is told to.
struct Set {
  Plan plan{parse_move(glide, "move.toml"), parse_rig(crane_rig, "rig.toml"), {}};
  PlannedStops stops{plan};
  Playhead moving{plan.played(), *stops.bounds(), 250};
  Playhead still{plan.played(), *stops.bounds(), 250};
  std::array<bool, 2> is_still{false, true};
  std::vector<std::size_t> drive_of{0, 1};
  SimulatedRig rig{std::vector<double>{10, 100}};
  SimulatedLines lines;
  LoopStorage room{2, 2};
  MotionLoop<SimulatedRig, SimulatedLines> loop{rig, lines, room.memory()};
  std::array<std::int32_t, 7> shots{};
  FrameShoot shoot;

  explicit Set(const ShootSpec& spec, bool second_stands_still = false, std::span<const FrameTime> rests = {})
      : shoot(spec, {.last = 6, .shots = shots, .rests = rests}, moving,
              second_stands_still ? &still : nullptr) {
    LoopSpec loaded{&plan.motion(), &moving, drive_of, plan.limits(), tick_s};
    if (second_stands_still) {
      loaded.still = &still;
      loaded.is_still = is_still;
    }
    EXPECT_TRUE(loop.load(loaded));
    loop.post(SupervisorEvent::arm);
    loop.tick(1, 0);
    loop.tick(1, 0);
    EXPECT_TRUE(loop.begin());
  }
  void tick() { shoot.tick(loop.tick(1, 0).event); }
  /// The ticks that it takes until then, at most 10 000.
  int tick_until(ShootPhase phase) {
    int ticks = 0;
    for (; shoot.phase() != phase && ticks < 10'000; ++ticks) tick();
    EXPECT_EQ(shoot.phase(), phase);
    return ticks;
  }
  [[nodiscard]] std::vector<double> planned(const FrameTime& time) const {
    std::vector<double> at(2);
    plan.motion().positions(time, at);
    return at;
  }
};

const ShootSpec resting{.settle_ticks = 5, .exposure_ticks = 3, .shutter = {}};
const ShootSpec in_motion{
    .settle_ticks = 5, .exposure_ticks = 1, .shutter = Shutter{0, 0.5}, .exposure_s = 0.1};

TEST(FrameShoot, GoesSettlesSignalsAndWaitsOnEveryFrame) {
  Set set(resting);
  ASSERT_TRUE(set.shoot.shoot(0));
  for (std::int32_t frame = 0; frame <= 6; ++frame) {
    SCOPED_TRACE(frame);
    EXPECT_EQ(set.shoot.frame(), frame);
    set.tick_until(ShootPhase::settling);
    EXPECT_TRUE(set.moving.is_resting());
    EXPECT_FALSE(set.shoot.camera());
    EXPECT_EQ(set.tick_until(ShootPhase::exposing), 5);
    for (int i = 0; i < 3; ++i) {
      EXPECT_TRUE(set.shoot.camera());
      EXPECT_EQ(set.room.targets(), set.planned({frame, 0}));
      EXPECT_EQ(set.shoot.trigger().error().code, ErrorCode::wrong_state)
          << "nothing moves while the camera exposes";
      set.tick();
    }
    EXPECT_FALSE(set.shoot.camera());
    EXPECT_EQ(set.shoot.phase(), ShootPhase::waiting);
    for (int i = 0; i < 50; ++i) set.tick();
    EXPECT_EQ(set.room.targets(), set.planned({frame, 0})) << "it waits";
    EXPECT_EQ(set.shoot.exposures(), frame + 1);
    ASSERT_TRUE(set.shoot.trigger());
  }
  EXPECT_EQ(set.shoot.phase(), ShootPhase::done);
  EXPECT_TRUE(set.loop.finish());
  EXPECT_EQ(set.loop.state(), SupervisorState::ready);
}

TEST(FrameShoot, LooksAtAFrameWithoutExposingIt) {
  Set set(resting);
  ASSERT_TRUE(set.shoot.shoot(0));
  set.tick_until(ShootPhase::waiting);
  ASSERT_TRUE(set.shoot.look_at(3));
  set.tick_until(ShootPhase::standing);
  EXPECT_EQ(set.room.targets(), set.planned({3, 0}));
  EXPECT_EQ(set.shoot.exposures(), 1);
  ASSERT_TRUE(set.shoot.trigger());
  set.tick_until(ShootPhase::waiting);
  EXPECT_EQ(set.shoot.frame(), 3);
  EXPECT_EQ(set.shoot.exposures(), 2);
}

TEST(FrameShoot, ATriggerGoesOnWithTheNextFrameThatIsNotShot) {
  Set set(resting);
  ASSERT_TRUE(set.shoot.shoot(0));
  set.tick_until(ShootPhase::waiting);
  ASSERT_TRUE(set.shoot.look_at(3));
  set.tick_until(ShootPhase::standing);
  ASSERT_TRUE(set.shoot.trigger());
  set.tick_until(ShootPhase::waiting);
  ASSERT_TRUE(set.shoot.look_at(0));
  set.tick_until(ShootPhase::standing);
  ASSERT_TRUE(set.shoot.trigger()) << "frame 0 was shot: it goes on";
  set.tick_until(ShootPhase::waiting);
  EXPECT_EQ(set.shoot.frame(), 1);
  ASSERT_TRUE(set.shoot.shoot_again());
  set.tick_until(ShootPhase::waiting);
  EXPECT_THAT(set.shots, ElementsAre(1, 2, 0, 1, 0, 0, 0));
  for (const std::int32_t next : {2, 4, 5, 6}) {
    ASSERT_TRUE(set.shoot.trigger());
    set.tick_until(ShootPhase::waiting);
    EXPECT_EQ(set.shoot.frame(), next);
  }
  ASSERT_TRUE(set.shoot.trigger());
  EXPECT_EQ(set.shoot.phase(), ShootPhase::done);
}

/// A travel that is stopped at any tick of it rests before the place at which it was to rest, or on it.
TEST(FrameShoot, NoStopPassesAPlaceAtWhichTravelsRest) {
  const std::array rests{FrameTime{2, 0.37}, FrameTime{4, 0}};
  for (const std::int32_t to : {6, 0}) {
    std::size_t rested = 0;
    for (int stop = 1; stop < 300; ++stop) {
      Set set(resting, false, rests);
      ASSERT_TRUE(set.moving.place_on(6 - to));
      ASSERT_TRUE(set.shoot.look_at(to));
      std::size_t here = 0;  // how many of the rests it has been on
      for (int i = 0; i < stop; ++i) {
        set.moving.tick();
        if (set.moving.is_resting()) ++here;
        set.shoot.tick(PlayheadEvent::none);
      }
      rested = std::max(rested, here);
      if (set.shoot.phase() != ShootPhase::travelling) break;
      const FrameTime next = here >= rests.size() ? FrameTime{to, 0}
                             : to == 6            ? rests[here]
                                                  : rests[1 - here];
      set.moving.stop();
      while (!set.moving.is_resting()) set.moving.tick();
      EXPECT_TRUE(to == 6 ? set.moving.time() <= next : next <= set.moving.time())
          << "stopped at tick " << stop;
    }
    EXPECT_EQ(rested, 3) << "two rests, and the frame itself";
  }
}

TEST(FrameShoot, InMotionTheSignalLastsFromOpenToClose) {
  Set set(in_motion);
  ASSERT_TRUE(set.shoot.check());
  ASSERT_TRUE(set.shoot.shoot(0));
  for (std::int32_t frame = 0; frame <= 6; ++frame) {
    SCOPED_TRACE(frame);
    int ticks = 0;
    while (set.shoot.phase() != ShootPhase::waiting) {
      const bool was_open = set.shoot.camera();
      const std::vector<double> before = set.room.targets();
      set.tick();
      if (set.shoot.camera() && !was_open) {
        const std::vector<double> open = set.planned({frame, 0});
        for (std::size_t d = 0; d < 2; ++d) EXPECT_NEAR(set.room.targets()[d], open[d], 1e-6);
      }
      if (!set.shoot.camera() && was_open) {
        const std::vector<double> close = set.planned({frame, 0.5});
        for (std::size_t d = 0; d < 2; ++d) EXPECT_NEAR(set.room.targets()[d], close[d], 1e-6);
      }
      if (was_open) ++ticks;
    }
    EXPECT_EQ(ticks, 25) << "0.1 s at 250 Hz";
    ASSERT_TRUE(set.shoot.trigger());
  }
  EXPECT_EQ(set.shoot.exposures(), 7);
}

TEST(FrameShoot, AnAxisThatIsLeftOutStandsOnTheFrameWhileTheOtherMoves) {
  Set set(in_motion, true);
  ASSERT_TRUE(set.shoot.shoot(2));
  std::vector<double> moved;
  while (set.shoot.phase() != ShootPhase::waiting) {
    set.tick();
    if (!set.shoot.camera()) continue;
    EXPECT_EQ(set.room.targets()[1], set.planned({2, 0})[1]);
    moved.push_back(set.room.targets()[0]);
  }
  EXPECT_GT(std::abs(moved.back() - moved.front()), 0.1);
  ASSERT_TRUE(set.shoot.trigger());
  set.tick_until(ShootPhase::exposing);
  EXPECT_EQ(set.room.targets()[1], set.planned({3, 0})[1]);
}

TEST(FrameShoot, AStopEndsTheSignalAndTheFrameIsShotAgain) {
  Set set(in_motion, true);
  ASSERT_TRUE(set.shoot.shoot(3));
  while (!set.shoot.camera()) set.tick();
  set.loop.post(SupervisorEvent::stop);
  set.shoot.interrupt();
  EXPECT_FALSE(set.shoot.camera());
  for (int i = 0; i < 1000 && set.loop.state() != SupervisorState::latched; ++i) set.tick();
  EXPECT_EQ(set.loop.state(), SupervisorState::latched);
  EXPECT_EQ(set.shoot.phase(), ShootPhase::idle);
  EXPECT_EQ(set.shoot.exposures(), 0);
  EXPECT_EQ(set.shoot.trigger().error().code, ErrorCode::wrong_state);
  ASSERT_TRUE(set.loop.post(SupervisorEvent::acknowledge));
  set.tick();
  set.tick();
  ASSERT_TRUE(set.loop.begin());
  ASSERT_TRUE(set.shoot.shoot(set.shoot.frame()));
  set.tick_until(ShootPhase::waiting);
  EXPECT_EQ(set.shoot.frame(), 3);
  EXPECT_EQ(set.shoot.exposures(), 1);
}

TEST(FrameShoot, AnExposureThatNoRateAllowsIsNamedWithItsFrame) {
  ShootSpec short_one = in_motion;
  short_one.exposure_s = 0.01;
  Set set(short_one);
  const Status refused = set.shoot.check();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().frame, 0);
  EXPECT_THAT(refused.error().remedy, HasSubstr("expose longer"));
  EXPECT_FALSE(set.shoot.shoot(0));
  EXPECT_EQ(set.shoot.phase(), ShootPhase::idle);
}

/// Every phase times every request: what is answered, and where it leads.
TEST(FrameShoot, InEveryPhaseEveryRequestIsAnsweredOrRefused) {
  const std::array<ShootPhase, shoot_phases> phases{
      ShootPhase::idle,     ShootPhase::travelling, ShootPhase::settling, ShootPhase::standing,
      ShootPhase::exposing, ShootPhase::waiting,    ShootPhase::done};
  for (const ShootPhase phase : phases) {
    SCOPED_TRACE(name_of(phase));
    const auto in_phase = [&](Set& set) {
      if (phase == ShootPhase::idle) return;
      ASSERT_TRUE(phase == ShootPhase::standing ? set.shoot.look_at(2)
                                                : set.shoot.shoot(phase == ShootPhase::done ? 6 : 2));
      if (phase == ShootPhase::travelling) set.tick();
      set.tick_until(phase == ShootPhase::done ? ShootPhase::waiting : phase);
      if (phase == ShootPhase::done) {
        ASSERT_TRUE(set.shoot.trigger());
      }
      ASSERT_EQ(set.shoot.phase(), phase);
    };
    const bool can_go = phase != ShootPhase::travelling && phase != ShootPhase::exposing;
    {
      Set set(resting);
      in_phase(set);
      EXPECT_EQ(static_cast<bool>(set.shoot.shoot(4)), can_go);
      EXPECT_EQ(set.shoot.phase(), can_go ? ShootPhase::travelling : phase);
    }
    {
      Set set(resting);
      in_phase(set);
      EXPECT_EQ(static_cast<bool>(set.shoot.look_at(4)), can_go);
      EXPECT_EQ(set.shoot.phase(), can_go ? ShootPhase::travelling : phase);
    }
    {
      Set set(resting);
      in_phase(set);
      EXPECT_FALSE(set.shoot.shoot(7)) << "there are 0..6";
      EXPECT_FALSE(set.shoot.look_at(-1));
      EXPECT_EQ(set.shoot.phase(), phase);
    }
    {
      Set set(resting);
      in_phase(set);
      const bool waits = phase == ShootPhase::standing || phase == ShootPhase::waiting;
      EXPECT_EQ(static_cast<bool>(set.shoot.trigger()), waits);
      EXPECT_EQ(set.shoot.phase(), waits ? ShootPhase::travelling : phase);
    }
    {
      Set set(resting);
      in_phase(set);
      set.shoot.interrupt();
      EXPECT_FALSE(set.shoot.camera());
      EXPECT_EQ(set.shoot.phase(), phase == ShootPhase::done ? ShootPhase::done : ShootPhase::idle);
    }
  }
}

TEST(FrameShoot, FinishesOnlyAtRest) {
  Set set(resting);
  ASSERT_TRUE(set.shoot.shoot(5));
  set.tick();
  EXPECT_EQ(set.loop.finish().error().code, ErrorCode::wrong_state);
  set.tick_until(ShootPhase::waiting);
  EXPECT_TRUE(set.loop.finish());
  EXPECT_EQ(set.loop.finish().error().code, ErrorCode::wrong_state) << "it does not run any more";
}

}  // namespace frame_shoot_test
}  // namespace inbetween
