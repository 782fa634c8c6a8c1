#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdint>
#include <iostream>
#include <optional>

#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/rig_near.hpp"

/// The number of frames that `check` names, tried: it fits, and one less does not.

namespace inbetween {
namespace smallest_frames_property_test {

constexpr int many_moves = 1000;

TEST(SmallestFramesProperty, FitsAndOneFrameLessDoesNot) {
  int named = 0;
  int with_roll = 0;
  check_property(many_moves, [&] {
    const RandomMove random = *regular_move();
    const std::optional<MoveFile> read = for_a_rig(random);
    if (!read) return;
    const MoveFile& move = *read;
    const std::optional<RigFile> rig =
        rig_near(move, {.share = [] { return *rc::gen::inRange(30, 160) / 100.0; },
                        .limits_jerk = *rc::gen::arbitrary<bool>()});
    if (!rig) return;
    const Plan plan(move, rig, {});
    const CheckReport report = check(plan);
    const SmallestFrames smallest = smallest_frames(plan, report, {});
    RC_LOG() << as_toml(random) << "smallest " << smallest.frames.value_or(-1) << " " << smallest.reason
             << '\n';
    RC_ASSERT(smallest.frames.has_value() != !smallest.reason.empty());
    if (!smallest.frames) {
      RC_ASSERT(!report.fits());
      return;
    }
    ++named;
    const auto fits_in = [&](std::int32_t frames) {
      const Plan other(with_frames(move, frames), rig, {});
      if (other.played().first_frame() < 0 || other.played().last_frame() > frames) ++with_roll;
      return check(other).fits();
    };
    RC_ASSERT(fits_in(*smallest.frames));
    if (*smallest.frames > 1) RC_ASSERT(!fits_in(*smallest.frames - 1));
  });
  std::cout << named << " named a number of frames; " << with_roll << " plans had a roll\n";
  if (!counts_mean_something()) return;
  EXPECT_GT(named, many_moves / 10);
  EXPECT_GT(with_roll, many_moves / 20);
}

/// The same keys on frames of their own, without a speed curve.
MoveFile timed_by_frames(MoveFile move) {
  MoveTrack& track = move.tracks.front();
  track.timing = Timing::frames;
  track.speed.clear();
  track.speed_places.clear();
  std::int32_t frame = 0;
  for (MoveKey& key : track.keys) {
    key.frame = frame;
    frame += *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(2, 48));
  }
  move.frames = *track.keys.back().frame;
  return move;
}

/// Whole frames make what is needed jump up and down from one number to the next; the one that is named is
/// one that was tried as it would be written.
TEST(SmallestFramesProperty, OfKeysOnFramesTheNamedNumberFits) {
  int named = 0;
  int slower = 0;
  check_property(many_moves, [&] {
    const RandomMove random = *regular_move();
    const std::optional<MoveFile> read = for_a_rig(random);
    if (!read || read->tracks.front().closed || read->tracks.front().spline == Spline::linear) return;
    const MoveFile move = timed_by_frames(*read);
    const std::optional<RigFile> rig =
        rig_near(move, {.share = [] { return *rc::gen::inRange(30, 160) / 100.0; },
                        .limits_jerk = *rc::gen::arbitrary<bool>(),
                        .allows_steps = *rc::gen::arbitrary<bool>()});
    if (!rig) return;
    const Plan plan(move, rig, {});
    const CheckReport report = check(plan);
    const SmallestFrames smallest = smallest_frames(plan, report, {});
    RC_LOG() << as_toml(random) << "in " << move.frames << " frames, smallest "
             << smallest.frames.value_or(-1) << " " << smallest.reason << '\n';
    RC_ASSERT(smallest.frames.has_value() != !smallest.reason.empty());
    if (!smallest.frames) {
      RC_ASSERT(!report.fits());
      return;
    }
    ++named;
    if (*smallest.frames > move.frames) ++slower;
    RC_ASSERT(check(Plan(with_frames(move, *smallest.frames), rig, {})).fits());
  });
  std::cout << named << " named a number of frames, " << slower << " of them a larger one\n";
  if (!counts_mean_something()) return;
  EXPECT_GT(named, many_moves / 10);
  EXPECT_GT(slower, many_moves / 50);
}

}  // namespace smallest_frames_property_test
}  // namespace inbetween
