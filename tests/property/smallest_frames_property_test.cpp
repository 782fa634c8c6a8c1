#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>
#include <vector>

#include "host_tools/check.hpp"
#include "host_tools/check_frames.hpp"
#include "host_tools/move_file.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"

/// The number of frames that `check` names, tried: it fits, and one less does not.

namespace inbetween {
namespace {

constexpr int many_moves = 1000;

/// A rig whose limits are 0.3 to 1.6 times the peaks of the move, sometimes without a limit of the jerk, with
/// room of the size of the move on either side.
std::optional<RigFile> rig_near(const MoveFile& move) {
  RigFile rig{.path = "rig.toml", .name = "rig", .rate_hz = 100, .buses = {}, .axes = {}};
  const auto share = [] { return *rc::gen::inRange(30, 160) / 100.0; };
  const bool limits_jerk = *rc::gen::arbitrary<bool>();
  const std::vector<std::string>& names = move.tracks.front().axes;
  for (const std::string& name : names) {
    RigAxis axis;
    axis.name = name;
    axis.min = -1e30;
    axis.max = 1e30;
    axis.max_velocity = axis.max_acceleration = 1e30;
    rig.axes.push_back(axis);
  }
  const CheckReport loose = check(Plan(move, rig, {}));
  for (std::size_t d = 0; d < names.size(); ++d) {
    const CheckedAxis& found = loose.axes[d];
    RigAxis& axis = rig.axes[d];
    const double size = found.range->highest.value - found.range->lowest.value;
    const double largest =
        std::max(std::fabs(found.range->highest.value), std::fabs(found.range->lowest.value));
    // What stands still, or hardly more than its digits let it move, has no limits of its own.
    if (!(size > 1e-6 * largest) || !std::isfinite(found.jerk.value) || largest > 1e9 || size < 1e-9) {
      return std::nullopt;
    }
    axis.min = found.range->lowest.value - size;
    axis.max = found.range->highest.value + size;
    axis.max_velocity = share() * found.velocity.value;
    axis.max_acceleration = share() * std::max(found.acceleration.value, 1e-3 * axis.max_velocity);
    if (limits_jerk) axis.max_jerk = share() * std::max(found.jerk.value, 1e-3 * axis.max_acceleration);
  }
  return rig;
}

/// Nothing where the numbers are beyond what a file may say or a rig can count in 31 bits.
std::optional<MoveFile> for_a_rig(const RandomMove& random) {
  for (const std::vector<long double>& at : random.keys.at) {
    if (std::ranges::any_of(at, [](long double value) { return std::fabs(value) > 1e9L; })) {
      return std::nullopt;
    }
  }
  const bool all_zero = std::ranges::all_of(random.keys.weights, [](auto weight) { return weight == 0; });
  if (all_zero && !random.keys.weights.empty()) return std::nullopt;
  return parse_move(as_toml(random), "move.toml");
}

TEST(SmallestFramesProperty, FitsAndOneFrameLessDoesNot) {
  int named = 0;
  int with_roll = 0;
  check_property(many_moves, [&] {
    const RandomMove random = *regular_move();
    const std::optional<MoveFile> read = for_a_rig(random);
    if (!read) return;
    const MoveFile& move = *read;
    const std::optional<RigFile> rig = rig_near(move);
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

}  // namespace
}  // namespace inbetween
