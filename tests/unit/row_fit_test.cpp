// Baked moves come back as they were drawn.
#include "host_tools/fit/row_fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "host_tools/exchange/keyed_move.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/plan/plan_rows.hpp"
#include "tests/support/places.hpp"

namespace inbetween {
namespace row_fit_test {

using testing::ElementsAre;

/// The frames of a move, each position rounded.
RowsToFit baked(const MoveFile& move, double resolution, double tolerance) {
  const Plan plan(move, std::nullopt, {});
  RowsToFit rows{.axes = {}, .table = {}, .fps = plan.move().fps};
  for (const PlanAxis& axis : plan.axes()) {
    const AxisColumn column(plan, axis, PlanRows::frame);
    std::vector<double>& positions = rows.table.rows.emplace_back();
    for (std::int32_t frame = 0; frame <= move.frames; ++frame)
      positions.push_back(std::round(column.position(frame) / resolution) * resolution);
    rows.axes.push_back(axis.name);
    rows.table.tolerances.push_back(tolerance);
  }
  return rows;
}

RowFit fitted(const RowsToFit& rows) {
  return fit_rows(rows, [](double) {});
}

/// By the text that is written, read again and solved.
void expect_within_tolerance(const RowsToFit& rows, const RowFit& fit) {
  MoveFile move = fit.move;
  move.name = "fitted";
  const RowsToFit played = baked(parse_move(keyed_move_text_of(move, {"a comment"}), "fit.toml"), 1e-12, 1);
  for (std::size_t axis = 0; axis < rows.axes.size(); ++axis) {
    const auto of_played =
        static_cast<std::size_t>(std::ranges::find(played.axes, rows.axes[axis]) - played.axes.begin());
    ASSERT_LT(of_played, played.axes.size());
    double worst = 0;
    for (std::size_t row = 0; row < rows.table.rows[axis].size(); ++row)
      worst = std::max(worst, std::fabs(played.table.rows[of_played][row] - rows.table.rows[axis][row]));
    EXPECT_LE(worst, rows.table.tolerances[axis]) << rows.axes[axis];
    EXPECT_NEAR(worst, fit.worst[axis], 1e-9) << rows.axes[axis];
  }
}

TEST(RowFit, ADrawnMoveHasItsKeysAndItsSpeedCurveAgain) {
  const MoveFile drawn = read_move_file(in_checkout("examples/slide_and_pan.toml"));
  const RowsToFit rows = baked(drawn, 0.01, 0.1);
  const RowFit fit = fitted(rows);
  ASSERT_EQ(fit.move.tracks.size(), 1U);
  const MoveTrack& track = fit.move.tracks[0];
  ASSERT_EQ(track.keys.size(), drawn.tracks[0].keys.size());
  for (std::size_t k = 0; k < track.keys.size(); ++k) {
    EXPECT_NEAR(track.keys[k].at[0], drawn.tracks[0].keys[k].at[0], 1) << k;
    EXPECT_NEAR(track.keys[k].at[1], drawn.tracks[0].keys[k].at[1], 0.1) << k;
  }
  EXPECT_THAT(track.weights, ElementsAre(1, 4));
  EXPECT_EQ(track.speed, drawn.tracks[0].speed);
  EXPECT_EQ(fit.numbers, 19U);
  expect_within_tolerance(rows, fit);
}

TEST(RowFit, KeysOnFramesComeBackAsKeysOnFrames) {
  const RowsToFit rows = baked(read_move_file(in_checkout("examples/rack_focus.toml")), 0.001, 0.1);
  const RowFit fit = fitted(rows);
  for (const MoveTrack& track : fit.move.tracks) EXPECT_EQ(track.timing, Timing::frames);
  EXPECT_LE(fit.numbers, 15U);
  expect_within_tolerance(rows, fit);
}

TEST(RowFit, AxesThatHaveNothingInCommonAreTracksOfTheirOwn) {
  RowsToFit rows{.axes = {"tail", "body"},
                 .table = {.rows = {{}, {}}, .tolerances = {0.2, 0.2}},
                 .fps = {{24, 1}, "24", true}};
  for (int frame = 0; frame <= 96; ++frame) {
    const double t = frame / 96.0;
    rows.table.rows[0].push_back(20 * std::sin(frame / 5.0));
    rows.table.rows[1].push_back(100 * t * t * t * (10 - 15 * t + 6 * t * t));
  }
  const RowFit fit = fitted(rows);
  EXPECT_EQ(fit.move.tracks.size(), 2U);
  expect_within_tolerance(rows, fit);
}

TEST(RowFit, AHoldHasAKeyOnEitherSide) {
  RowsToFit rows{
      .axes = {"pan"}, .table = {.rows = {{}}, .tolerances = {0.05}}, .fps = {{24, 1}, "24", true}};
  for (int frame = 0; frame <= 80; ++frame) {
    const double t = std::clamp(frame < 40 ? frame / 30.0 : (80 - frame) / 30.0, 0.0, 1.0);
    rows.table.rows[0].push_back(20 * t * t * t * (10 - 15 * t + 6 * t * t));
  }
  const RowFit fit = fitted(rows);
  expect_within_tolerance(rows, fit);
  std::vector<int> at_20;
  for (const MoveKey& key : fit.move.tracks.at(0).keys) {
    if (key.at[0] == 20) at_20.push_back(key.frame.value_or(-1));
  }
  EXPECT_THAT(at_20, ElementsAre(30, 50));
}

TEST(RowFit, ATableOfTwoRowsIsTwoKeys) {
  RowsToFit rows{
      .axes = {"pan"}, .table = {.rows = {{0, 5}}, .tolerances = {0.05}}, .fps = {{24, 1}, "24", true}};
  const RowFit fit = fitted(rows);
  EXPECT_EQ(fit.move.tracks.at(0).keys.size(), 2U);
  expect_within_tolerance(rows, fit);
}

}  // namespace row_fit_test
}  // namespace inbetween
