#include <gtest/gtest.h>

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/check/check_frames.hpp"
#include "tests/support/oracle_rest.hpp"
#include "tests/support/random_move.hpp"
#include "tests/support/solved_move.hpp"

/// What `check` certifies of moves whose path stands still or turns back, against a dense search in long
/// double; random ones are in tests/property.

namespace inbetween {
namespace turning_move_test {

using oracle::Kind;

constexpr double closeness = 1.01;
/// By which a search may miss a peak.
constexpr double search_rounding = 1e-6;
/// Of a limit: nothing is refined that is further from it.
constexpr double slack_share = 1e-6;

RigFile rig_of(const std::vector<std::string>& axes) {
  RigFile rig{.path = "rig.toml", .name = "rig", .rate_hz = 250, .buses = {}, .axes = {}};
  for (const std::string& name : axes) {
    RigAxis axis;
    axis.name = name;
    axis.min = -1e4;
    axis.max = 1e4;
    axis.max_velocity = 1e3;
    axis.max_acceleration = 1e4;
    axis.max_jerk = 1e5;
    rig.axes.push_back(axis);
  }
  return rig;
}

Plan plan_of(const RandomMove& move) {
  const MoveFile file = parse_move(as_toml(move), "move.toml");
  return {file, rig_of(file.tracks[0].axes), {}};
}

std::vector<oracle::RestPeaks> truth_of(const RandomMove& move, const Plan& plan) {
  const auto met = met_keys(move, plan.tracks()[0]);
  if (!met) throw std::logic_error("a hold at which the curve does not rest");
  return oracle::RestingMotion(move.keys, plan.tracks()[0].control_values(), move.frames, 24, *met).peaks();
}

/// What plays is so near to what is asked, of its acceleration and of its jerk; `share`.
void expect_close(const CheckedPeak& peak, const oracle::Found& truth, double share) {
  EXPECT_GE(peak.value, static_cast<double>(truth.value) * (1 - search_rounding - share));
  EXPECT_LE(peak.value, static_cast<double>(truth.most) * closeness * (1 + search_rounding) +
                            slack_share * peak.limit.value());
}

void expect_true_certificate(const RandomMove& move) {
  SCOPED_TRACE(as_toml(move));
  const Plan plan = plan_of(move);
  const CheckReport report = check(plan);
  const std::vector<oracle::RestPeaks> truth = truth_of(move, plan);
  for (std::size_t d = 0; d < truth.size(); ++d) {
    SCOPED_TRACE(report.axes[d].name);
    expect_close(report.axes[d].velocity, truth[d].velocity, 1e-6);
    expect_close(report.axes[d].acceleration, truth[d].acceleration, 1e-4);
    expect_close(report.axes[d].jerk, truth[d].jerk, 3e-3);
  }
}

void expect_fits(const RandomMove& move) {
  expect_true_certificate(move);
  const Plan plan = plan_of(move);
  const CheckReport report = check(plan);
  for (const CheckRefusal& refusal : report.refusals) ADD_FAILURE() << refusal.message();
  EXPECT_TRUE(report.stops.has_value());
  EXPECT_TRUE(smallest_frames(plan, report, {}).frames.has_value());
}

std::array<long double, 3> tension(long double value) {
  return {value, 0, 0};
}

RandomMove out_and_back() {
  return {.keys = {.kind = Kind::smooth,
                   .closed = false,
                   .at = {{60, -40, -4}, {420, -30, -3}, {860, 0, 4}, {420, -30, -3}, {60, -40, -4}},
                   .tension_continuity_bias = {},
                   .weights = {1, 6, 6}},
          .speed = {0, 0, 6, 6, 6, 6, 0, 0},
          .frames = 480,
          .times = {{}, {}, {.hold = 24}, {}, {}}};
}

TEST(TurningMove, ThatGoesOutHoldsAndComesBackTheSameWayFits) {
  expect_fits(out_and_back());
}

TEST(TurningMove, ThatRestsBetweenEqualKeysFits) {
  RandomMove move = out_and_back();
  move.keys.at.insert(move.keys.at.begin() + 2, move.keys.at[2]);
  move.times.insert(move.times.begin() + 2, RandomKeyTime{});
  expect_fits(move);
}

RandomMove bends_with_tension(const std::vector<long double>& tensions) {
  RandomMove move{.keys = {.kind = Kind::tcb,
                           .closed = false,
                           .at = {{60, 0, 0}, {460, 40, 3}, {660, 0, 10}, {1160, -40, 10}},
                           .tension_continuity_bias = {},
                           .weights = {1, 6, 6}},
                  .speed = {0, 0, 4, 4, 4, 4, 0, 0},
                  .frames = 480,
                  .times = {}};
  for (const long double value : tensions) move.keys.tension_continuity_bias.push_back(tension(value));
  return move;
}

TEST(TurningMove, OfTensionOneAtItsEndsIsBoundedByItsMotionOverTime) {
  expect_true_certificate(bends_with_tension({1, 0, 0, 0}));
  expect_true_certificate(bends_with_tension({0, 0, 0, 1}));
}

TEST(TurningMove, OfTensionOneAtAHeldKeyIsBoundedByItsMotionOverTime) {
  RandomMove move = bends_with_tension({0, 1, 0, 0});
  move.times = {{}, {.hold = 20}, {}, {}};
  expect_true_certificate(move);
}

TEST(TurningMove, WhoseFirstStepOfSpeedIsNoneIsBoundedThoughItsAccelerationSteps) {
  RandomMove move = bends_with_tension({1, 0, 0, 1});
  move.speed = {0, 4, 4, 4, 4, 0};
  expect_true_certificate(move);
}

TEST(TurningMove, HasOnEitherSideOfABreakItsOwnDirectionAndSpeed) {
  // 303 mm in 230 frames, then 168 mm in ten.
  const RandomMove move{.keys = {.kind = Kind::linear,
                                 .closed = false,
                                 .at = {{60, 0}, {363, 0}, {363, 168}},
                                 .tension_continuity_bias = {},
                                 .weights = {}},
                        .speed = {0, 0, 4, 4, 6, 5, 0, 0},
                        .frames = 240,
                        .times = {{}, {.break_frame = 230}, {}}};
  expect_true_certificate(move);
}

TEST(TurningMove, ThatPassesACuspHasTheSpeedOfItsDirection) {
  RandomMove move = out_and_back();
  move.keys.kind = Kind::catmull_rom;
  move.keys.at = {{60, 0, 0}, {460, 40, 3}, {60, 0, 0}, {160, -40, 10}};
  move.times.clear();
  const Plan plan = plan_of(move);
  const CheckReport report = check(plan);
  EXPECT_FALSE(report.fits());
  const std::vector<oracle::RestPeaks> truth = truth_of(move, plan);
  for (std::size_t d = 0; d < truth.size(); ++d)
    expect_close(report.axes[d].velocity, truth[d].velocity, 1e-6);
}

TEST(TurningMove, BesideATensionOfNearlyOneIsBoundedByTheTruth) {
  expect_true_certificate(bends_with_tension({0, 0.9999L, 0, 0}));
  // A turn in less than a ten-millionth of the move: the rounding of positions is felt in what plays.
  const RandomMove narrow = bends_with_tension({0, 0.999999L, 0, 0});
  const Plan plan = plan_of(narrow);
  const std::vector<oracle::RestPeaks> truth = truth_of(narrow, plan);
  const CheckReport report = check(plan);
  for (std::size_t d = 0; d < truth.size(); ++d) {
    EXPECT_NEAR(report.axes[d].velocity.value, static_cast<double>(truth[d].velocity.value),
                1e-4 * static_cast<double>(truth[d].velocity.value));
    EXPECT_GT(report.axes[d].acceleration.value, 0.9 * static_cast<double>(truth[d].acceleration.value));
  }
}

// A tension of nearly 1 lets the path turn so near its key that a lock does not tell the two apart.
TEST(TurningMove, ThatRestsWhereItTurnsBesideItsKeyFits) {
  for (const long double bias : {-1.0L, 1.0L}) {
    expect_fits({.keys = {.kind = Kind::tcb,
                          .closed = false,
                          .at = {{0, 0}, {300, 200}, {150, 100}},
                          .tension_continuity_bias = {{0, 0, 0}, {0.999999L, 0, bias}, {0, 0, 0}},
                          .weights = {}},
                 .speed = {0, 0, 6, 6, 6, 6, 0, 0},
                 .frames = 480,
                 .times = {{}, {.hold = 12}, {}}});
  }
}

}  // namespace turning_move_test
}  // namespace inbetween
