#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "host_tools/files/diagnostics.hpp"
#include "tests/support/oracle_rest.hpp"
#include "tests/support/property.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"

/// The certificate of moves whose path stands still or turns back, against a dense search in long double: not
/// 1 % above the truth, never below it, and nothing is refused that is 1 % below its limits.

namespace inbetween {
namespace turning_move_property_test {

constexpr int many_moves = 60;
constexpr double closeness = 1.01;
/// By which a search may miss a peak, or the rounding of the product may move it.
constexpr double search_rounding = 1e-6;

RigFile rig_with(const std::vector<std::string>& axes) {
  RigFile rig{.path = "rig.toml", .name = "rig", .rate_hz = 250, .buses = {}, .axes = {}};
  for (const std::string& name : axes) {
    RigAxis axis;
    axis.name = name;
    axis.min = -1e6;
    axis.max = 1e6;
    axis.max_velocity = axis.max_acceleration = 1e12;
    rig.axes.push_back(axis);
  }
  return rig;
}

std::optional<Plan> planned(const MoveFile& move, const RigFile& rig) {
  try {
    return Plan(move, rig, {});
  } catch (const InputError&) {  // a hold for which the speed curve has no room
    return std::nullopt;
  }
}

struct Allowed {
  double most = closeness;  ///< times what is found
  double noise = 0;
  bool may_be_unbounded = false;
};

void expect_tight(const char* what, double bound, const oracle::Found& found, const Allowed& allowed) {
  RC_LOG() << what << ": bound " << bound << ", found " << static_cast<double>(found.value) << " to "
           << static_cast<double>(found.most) << " at frame " << static_cast<double>(found.frame) << '\n';
  RC_ASSERT(bound >= static_cast<double>(found.value) * (1 - search_rounding) - allowed.noise);
  if (allowed.may_be_unbounded && std::isinf(bound)) return;
  RC_ASSERT(bound <= static_cast<double>(found.most) * allowed.most * (1 + search_rounding) + allowed.noise);
}

TEST(TurningMoveProperty, IsRefusedForWhatItDoesAndForNothingElse) {
  int compared = 0;
  int unbounded = 0;
  int rested = 0;
  int unresolved = 0;
  check_property(many_moves, [&] {
    const RandomMove random = *turning_move();
    RC_LOG() << as_toml(random);
    const std::optional<MoveFile> move = [&]() -> std::optional<MoveFile> {
      try {
        return parse_move(as_toml(random), "move.toml");
      } catch (const InputError&) {
        return std::nullopt;
      }
    }();
    if (!move) return;
    RigFile rig = rig_with(move->tracks[0].axes);
    const std::optional<Plan> plan = planned(*move, rig);
    if (!plan || plan->tracks()[0].track().arc_length().total() == 0) return;
    const std::optional<std::vector<oracle::MetKey>> met = met_keys(random, plan->tracks()[0]);
    RC_ASSERT(met.has_value());
    oracle::RestingMotion motion(random.keys, plan->tracks()[0].control_values(), random.frames, 24, *met);
    const std::vector<oracle::RestPeaks> truth = motion.peaks();
    const Track<double>& track = plan->tracks()[0].track();
    std::vector<AxisTurn<double>> turns(truth.size());
    std::vector<AxisPeaks<double>> peaks(truth.size());
    const std::vector<PeakSlack<double>> slack(truth.size());
    RC_ASSERT(bound_motion<double>(track, slack, {turns}, peaks).has_value());
    ++compared;
    long double quickest = 0;
    long double hardest = 0;
    long double roughest = 0;
    for (const oracle::RestPeaks& axis : truth) {
      quickest = std::max(quickest, axis.velocity.value);
      hardest = std::max(hardest, axis.acceleration.value);
      roughest = std::max(roughest, axis.jerk.most);
    }
    // A peak that lasts less than 1e-10 of the move is passed in a few ticks of a double's time.
    const bool resolved = !(hardest < 1e-10L * random.frames / 24 * roughest);
    if (!resolved) ++unresolved;
    const double most = resolved ? closeness : 1e6;
    const double noise = 1e-9 * static_cast<double>(quickest);
    const double rate = track.curve_rate();
    for (std::size_t d = 0; d < truth.size(); ++d) {
      RC_LOG() << "axis " << d << '\n';
      const bool passes = motion.passes_standstill();
      expect_tight("velocity", peaks[d].velocity.value, truth[d].velocity, {closeness, noise, false});
      expect_tight("acceleration", peaks[d].acceleration.value, truth[d].acceleration,
                   {most, noise * rate, passes});
      expect_tight("jerk", peaks[d].jerk.value, truth[d].jerk, {most, noise * rate * rate, passes});
      rig.axes[d].max_velocity = std::max(closeness * static_cast<double>(truth[d].velocity.value), 1e-3);
      rig.axes[d].max_acceleration =
          std::max(closeness * static_cast<double>(truth[d].acceleration.value), 1e-3);
    }
    const bool steps =
        std::ranges::any_of(random.times, [](const RandomKeyTime& time) { return time.break_frame >= 0; });
    if (motion.passes_standstill()) ++unbounded;
    if (motion.passes_standstill() || steps || !resolved) return;
    if (random.speed[1] > 0 || random.speed[random.speed.size() - 2] > 0) return;  // its rolls need more
    ++rested;
    const Plan limited(*move, rig, {});
    const CheckReport report = check(limited);
    for (const CheckRefusal& refusal : report.refusals) RC_LOG() << refusal.message << '\n';
    RC_ASSERT(report.fits());
    const SmallestFrames smallest = smallest_frames(limited, report, {});
    RC_ASSERT(smallest.frames.has_value());
  });
  std::cout << compared << " compared, " << unbounded << " pass a standstill at a speed, " << rested
            << " fit just below their limits, in " << unresolved
            << " a peak is narrower than time is known\n";
  if (!counts_mean_something()) return;
  EXPECT_GT(compared, many_moves / 2);
  EXPECT_GT(rested, many_moves / 5);
}

}  // namespace turning_move_property_test
}  // namespace inbetween
