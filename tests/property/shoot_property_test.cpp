// Moves shot frame by frame, at rest or in motion: whatever is not a stop keeps the limits of the motion.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/motions/run_checks.hpp"
#include "tests/support/fitting_move.hpp"
#include "tests/support/property.hpp"
#include "tests/support/recorded_play.hpp"

namespace inbetween {
namespace shoot_property_test {

constexpr int many_shoots = 1000;
constexpr int max_ticks = 60'000;

ShootOptions shoot_of(const MoveFile& move) {
  ShootOptions options{.settle_s = 0, .exposure_s = 0.01};
  if (*rc::gen::inRange(0, 4) == 0) return options;
  const double open = *rc::gen::inRange(-20, 20) / 20.0;
  const double share = *rc::gen::inRange(1, 20) / 20.0;
  const double slower = *rc::gen::inRange(10, 60) / 10.0;
  options.shutter = Shutter{open, std::min(open + share, 1.0)};
  options.exposure_s =
      slower * (options.shutter->close - options.shutter->open) / move.fps.rate.frames_per_second();
  if (*rc::gen::arbitrary<bool>()) options.still.push_back(move.tracks[0].axes[0]);
  return options;
}

struct Tried {
  int shot = 0;
  int in_motion = 0;
  int refused = 0;
  double acceleration_share = 0;
};

/// Frame after frame, and now and then another is looked at.
void shoot_at_random(StagedMove& staged, const ShootSpec& spec, const Plan& held_to,
                     const CheckReport& report, Tried& tried) {
  const double tick_s = 1.0 / held_to.rig()->rate_hz;
  const PlannedStops wide(staged.plan());
  RecordedPlay record(held_to, *wide.bounds(), tick_s);
  RecordedPlay still_record(held_to, *wide.bounds(), tick_s);
  record.allow_steps_of(report);
  still_record.allow_steps_of(report);
  const std::int32_t frames = staged.plan().move().frames;
  std::vector<std::int32_t> shots(static_cast<std::size_t>(frames) + 1);
  FrameShoot shoot(spec, {.last = frames, .shots = shots, .rests = staged.rests()}, staged.playhead(),
                   staged.still());
  RC_ASSERT(shoot.shoot(0).has_value());
  for (int tick = 0; tick < max_ticks && shoot.phase() != ShootPhase::done; ++tick) {
    const PlayheadEvent event = staged.playhead().tick();
    if (staged.still() != nullptr) {
      static_cast<void>(staged.still()->tick());
      still_record.take(*staged.still());
    }
    record.take(staged.playhead());
    shoot.tick(event);
    if (shoot.phase() == ShootPhase::waiting || shoot.phase() == ShootPhase::standing) {
      const bool looks = *rc::gen::inRange(0, 20) == 0;
      const std::int32_t other = *rc::gen::inRange(0, staged.plan().move().frames + 1);
      RC_ASSERT((looks ? shoot.look_at(other) : shoot.trigger()).has_value());
    }
    RC_ASSERT(record.complaint() == "");
    RC_ASSERT(still_record.complaint() == "");
  }
  tried.acceleration_share = std::max(tried.acceleration_share, record.acceleration_share());
}

TEST(ShootProperty, FrameByFrameAndInMotionTheMotionLimitsHold) {
  Tried tried;
  check_property(many_shoots, [&] {
    const std::optional<FittingMove> fitting = fitting_move(200);
    if (!fitting) return;
    const auto& [plan, report] = *fitting;
    const ShootOptions options = shoot_of(plan.move());
    std::unique_ptr<StagedMove> staged;
    try {
      staged = checked_shoot(plan, 1, options);
    } catch (const LimitError&) {
      ++tried.refused;
      return;
    }
    ++tried.shot;
    if (options.shutter) ++tried.in_motion;
    shoot_at_random(*staged, shoot_spec(options, *plan.rig()), without_stop_limits(plan), report, tried);
  });
  std::cout << tried.shot << " moves shot, " << tried.in_motion << " of them in motion; " << tried.refused
            << " refused; at most " << tried.acceleration_share << " of the acceleration used\n";
  if (!counts_mean_something()) return;
  EXPECT_GE(tried.shot, 200);
  EXPECT_GT(tried.in_motion, 80);
  EXPECT_LE(tried.refused, tried.shot / 4);
}

}  // namespace shoot_property_test
}  // namespace inbetween
