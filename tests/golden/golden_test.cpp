// The examples against the tables that the oracle has computed for them, committed as data.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "host_tools/plan/plan.hpp"
#include "inbetween/base/hash.hpp"
#include "tests/support/golden_table.hpp"
#include "tests/support/oracle_table.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/solved_move.hpp"
#include "tests/support/timing_kinds.hpp"

namespace inbetween {
namespace golden_test {

std::string example_file(const std::string& name) {
  return in_checkout("examples/") + name + ".toml";
}

std::vector<GoldenRow> committed(const std::string& name) {
  return read_golden_csv(in_checkout("tests/golden/") + name + ".csv");
}

class GoldenTable : public testing::TestWithParam<std::string> {};

/// Compares every frame of a plan with the committed table; `error` is the relative error of the speed.
void expect_plan_near_golden(const Plan& plan, const std::vector<GoldenRow>& golden, double error) {
  const std::vector<DrawnTrack> drawn = read_drawn_tracks(plan.move().path);
  std::size_t next = 0;
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    const Track& track = plan.tracks()[t].track();
    const FrameTable& table = plan.tracks()[t].table();
    const oracle::Path path(drawn[t].keys);
    for (std::int32_t frame = 0; frame <= plan.move().frames; ++frame, ++next) {
      ASSERT_LT(next, golden.size());
      const GoldenRow& row = golden[next];
      ASSERT_EQ(row.track, static_cast<int>(t));
      ASSERT_EQ(row.frame, frame);
      SCOPED_TRACE(fmt::format("track {}, frame {}", t, frame));
      const PathPoint& point = table.point(frame);
      // Steps that are each off by `error` of their length put no frame further off than `error` of its
      // distance, and none of those after it: both ends are met.
      const double length = track.arc_length().total();
      const double tolerance = error * std::min(row.distance, length - row.distance) + 1e-13 * length;
      EXPECT_NEAR(frame_row(track, table, frame).distance, row.distance, tolerance);
      const int segment = std::min(static_cast<int>(row.s), path.segments() - 1);
      const auto speed = static_cast<double>(path.speed(segment, static_cast<long double>(row.s) - segment));
      EXPECT_NEAR(point.segment + point.t, row.s, 1.1 * tolerance / speed + 1e-13);
      ASSERT_EQ(row.position.size(), static_cast<std::size_t>(track.path().axis_count()));
      for (std::size_t d = 0; d < row.position.size(); ++d) {
        const double weight =
            drawn[t].keys.weights.empty() ? 1 : static_cast<double>(drawn[t].keys.weights[d]);
        EXPECT_NEAR(track.path().position(point, static_cast<std::int32_t>(d)), row.position[d],
                    1.1 * tolerance / weight + 1e-12);
      }
    }
  }
  EXPECT_EQ(next, golden.size());
}

/// Every frame step by the oracle's own measure.
void expect_speed_as_drawn(const Plan& plan, double error) {
  const std::vector<DrawnTrack> drawn = read_drawn_tracks(plan.move().path);
  for (std::size_t t = 0; t < plan.tracks().size(); ++t) {
    const auto places = oracle_places(plan.tracks()[t].track(), plan.tracks()[t].table());
    const oracle::SpeedError worst =
        oracle::worst_speed_error(oracle::Path(drawn[t].keys), oracle::Profile(drawn[t].speed),
                                  drawn[t].frames, places, static_cast<long double>(error));
    EXPECT_LE(worst.worst, 1.0L) << "track " << t << ", frame " << worst.frame;
  }
}

TEST_P(GoldenTable, ClosedFormIsWithinDelta) {
  const Plan plan(read_move_file(example_file(GetParam())), std::nullopt, {.solver = Solver::closed_form});
  const double delta = plan.tracks()[0].table().provenance().speed_error;
  EXPECT_EQ(delta, 1e-6);
  expect_plan_near_golden(plan, committed(GetParam()), delta);
  expect_speed_as_drawn(plan, delta);
}

TEST_P(GoldenTable, ThePapersSolverIsWithinTheErrorThatItReports) {
  const Plan plan(read_move_file(example_file(GetParam())), std::nullopt, {.solver = Solver::runge_kutta});
  double error = 0;
  for (const SolvedTrack& solved : plan.tracks()) {
    error = std::max(error, solved.table().provenance().speed_error);
  }
  EXPECT_LE(error, 0.02);
  // What it reports was measured on steps longer than 1e-6 of the length, by other means than the oracle's.
  error = 1.001 * error + 1e-9;
  expect_plan_near_golden(plan, committed(GetParam()), error);
  expect_speed_as_drawn(plan, error);
}

TEST_P(GoldenTable, IsWhatTheOracleComputesToday) {
  const std::vector<GoldenRow> rows = committed(GetParam());
  const std::vector<GoldenRow> today = golden_table(read_drawn_tracks(example_file(GetParam())));
  ASSERT_EQ(rows.size(), today.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    SCOPED_TRACE(fmt::format("line {}; scripts/update-golden writes it anew", i + 2));
    EXPECT_EQ(rows[i].track, today[i].track);
    EXPECT_EQ(rows[i].frame, today[i].frame);
    EXPECT_NEAR(rows[i].s, today[i].s, 1e-15 * today[i].s);
    EXPECT_NEAR(rows[i].distance, today[i].distance, 1e-15 * today[i].distance);
    ASSERT_EQ(rows[i].position.size(), today[i].position.size());
    for (std::size_t d = 0; d < rows[i].position.size(); ++d) {
      EXPECT_NEAR(rows[i].position[d], today[i].position[d], 1e-15 * std::fabs(today[i].position[d]) + 1e-16);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Examples, GoldenTable, testing::ValuesIn(golden_examples()),
                         [](const auto& test) { return test.param; });

class TimedGoldenTable : public testing::TestWithParam<std::string> {};

TEST_P(TimedGoldenTable, IsWhatThePlanDoesAndWhatTheOracleComputesToday) {
  const std::vector<GoldenRow> rows = committed(GetParam());
  const std::vector<GoldenRow> today = timed_golden_table(example_file(GetParam()));
  const Plan plan(read_move_file(example_file(GetParam())), std::nullopt, {.solver = Solver::closed_form});
  ASSERT_EQ(rows.size(), today.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    SCOPED_TRACE(fmt::format("line {}; scripts/update-golden writes it anew", i + 2));
    ASSERT_EQ(rows[i].position.size(), today[i].position.size());
    std::vector<double> position(rows[i].position.size());
    plan.tracks()[static_cast<std::size_t>(rows[i].track)].track().positions({rows[i].frame, 0}, position);
    for (std::size_t d = 0; d < position.size(); ++d) {
      EXPECT_NEAR(rows[i].position[d], today[i].position[d], 1e-14);
      EXPECT_NEAR(position[d], rows[i].position[d], 1e-12);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Examples, TimedGoldenTable, testing::ValuesIn(timed_golden_examples()),
                         [](const auto& test) { return test.param; });

/// The positions on every frame, to the last bit: a change of a line is a change of every such move. The
/// failure shows the new lines.
TEST(GoldenBits, EveryWayOfTimingHasThem) {
  std::string lines;
  for (const TimingKind& kind : timing_kinds()) {
    const Plan plan(move_of(kind), std::nullopt, {});
    Fnv1a hash;
    std::vector<double> position(2);
    for (std::int32_t frame = 0; frame <= plan.move().frames; ++frame) {
      plan.tracks().front().track().positions({frame, 0}, position);
      for (const double axis : position) hash.add(axis);
    }
    lines += fmt::format("{} {:016x}\n", kind.name, hash.value());
  }
  EXPECT_EQ(file_contents(in_checkout("tests/golden/timing_bits.txt")), lines);
}

}  // namespace golden_test
}  // namespace inbetween
