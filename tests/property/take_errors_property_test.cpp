// Takes with random errors: what is measured, against the text of their record, Orocos KDL and a pinhole
// camera by its matrix.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "host_tools/takes/take_compare.hpp"
#include "host_tools/takes/take_errors.hpp"
#include "host_tools/takes/take_passes.hpp"
#include "tests/support/example_joints.hpp"
#include "tests/support/oracle_kinematics.hpp"
#include "tests/support/oracle_pinhole.hpp"
#include "tests/support/oracle_take.hpp"
#include "tests/support/played_take.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace take_errors_property_test {

using Point = std::array<double, 3>;
constexpr int camera_link = 7;

const Plan& crane() {
  static const Plan plan = plan_of_crane();
  return plan;
}

/// Smooth errors, and here and there a bad tick: mm of the track, degrees of the others.
PlayedTake random_take(std::int64_t number) {
  PlayedTake played{.number = number};
  const auto seed = *rc::gen::arbitrary<std::uint32_t>();
  const double size = std::pow(10, *rc::gen::inRange(-4, 1));
  std::mt19937 numbers(seed);
  std::uniform_real_distribution<double> share(-1, 1);
  std::vector<std::array<double, 3>> waves(6);
  for (auto& [height, turns, phase] : waves) {
    height = size * share(numbers);
    turns = 0.05 * share(numbers);
    phase = 3 * share(numbers);
  }
  std::vector<double> bad(4000);
  for (double& one : bad) one = share(numbers) > 0.99 ? 3 * size * share(numbers) : 0;
  played.error = [waves, bad](std::int64_t tick, std::size_t axis) {
    const auto& [height, turns, phase] = waves[axis];
    return height * std::sin(turns * static_cast<double>(tick) + phase) + bad[static_cast<std::size_t>(tick)];
  };
  return played;
}

/// Loses some ticks of a take.
void lose_ticks(Take& take) {
  for (int holes = *rc::gen::inRange(0, 4); holes > 0; --holes) {
    const auto at = *rc::gen::inRange<std::size_t>(10, take.ticks_of_take.size() - 100);
    const auto first = take.ticks_of_take.begin() + static_cast<std::ptrdiff_t>(at);
    take.ticks_of_take.erase(first, first + *rc::gen::inRange(1, 50));
  }
}

OraclePinhole oracle_camera(const OraclePose& pose) {
  const OraclePinhole::Lens lens{.focal_mm = 50, .sensor_mm = {36, 24}, .pixels = {4096, 2730}};
  return {lens, pose.position, pose.columns};
}

constexpr std::array<std::array<double, 2>, 5> marks = {
    {{2048, 1365}, {0, 0}, {4096, 0}, {0, 2730}, {4096, 2730}}};

double distance_of(const Point& a, const Point& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

double angle_of(const OraclePose& a, const OraclePose& b) {
  // |A - B| of two rotations is 2 sqrt(2) sin(w / 2).
  double squares = 0;
  for (std::size_t i = 0; i < 3; ++i) squares += std::pow(distance_of(a.columns.at(i), b.columns.at(i)), 2);
  return 2 * std::asin(std::min(1.0, std::sqrt(squares / 8))) * 180 / std::acos(-1);
}

double shift_of(const OraclePose& a, const OraclePose& b) {
  double largest = 0;
  for (const auto& mark : marks) {
    const std::array<double, 2> image = oracle_camera(b).image(oracle_camera(a).point(mark, 2.0));
    largest = std::max(largest, std::hypot(image[0] - mark[0], image[1] - mark[1]));
  }
  return largest;
}

std::vector<double> told_in(const OracleRow& row) {
  std::vector<double> told;
  for (const auto& one : row.told) told.push_back(one.value());
  return told;
}

void expect_same(const ErrorFigures& figures, const OracleFigures& expected, double tolerance) {
  RC_ASSERT(figures.count() == expected.count);
  if (expected.count == 0) return;
  RC_ASSERT(std::fabs(std::fabs(figures.worst()) - std::fabs(expected.worst)) <= tolerance);
  RC_ASSERT(std::fabs(figures.mean() - expected.mean) <= tolerance);
  RC_ASSERT(std::fabs(figures.rms() - expected.rms) <= tolerance);
}

/// Errors of every measure, from the record of a take.
struct RecordedErrors {
  std::vector<std::vector<double>> errors = std::vector<std::vector<double>>(9);
  std::vector<double> frames;
};

RecordedErrors errors_in(const std::string& record) {
  const OracleTree tree(joints_of_crane());
  const std::vector<OracleRow> rows = rows_of_record(record);
  RecordedErrors found;
  for (const OracleAnswer& one : answers_in(rows)) {
    const std::vector<double> told = told_in(rows[one.setpoint]);
    const std::vector<double>& actual = rows[one.answer].actual;
    const OraclePose from = tree.pose(camera_link, told), to = tree.pose(camera_link, actual);
    for (std::size_t a = 0; a < 6; ++a) found.errors[a].push_back(actual[a] - told[a]);
    found.errors[6].push_back(1000 * distance_of(from.position, to.position));
    found.errors[7].push_back(angle_of(from, to));
    found.errors[8].push_back(shift_of(from, to));
    found.frames.push_back(rows[one.setpoint].frame.value());
  }
  return found;
}

TEST(TakeErrorsProperty, AreThoseThatTheRecordShows) {
  check_property(100, [] {
    Take take = played_take(crane(), random_take(1));
    lose_ticks(take);
    const TakeErrors errors = errors_of(TakeSamples(take), measures_of(crane()));
    const RecordedErrors expected = errors_in(record_of(take, crane()));
    RC_ASSERT(errors.measures.size() == 9U);
    for (std::size_t m = 0; m < 9; ++m) {
      const MeasuredErrors& measured = errors.measures[m].errors;
      const double tolerance = m < 8 ? 1e-8 : 1e-6;
      expect_same(measured.all(), figures_of_errors(expected.errors[m], expected.frames), tolerance);
      for (const FrameFigures& frame : measured.frames()) {
        expect_same(frame.figures,
                    figures_of_errors(expected.errors[m], expected.frames, frame.frame, frame.frame + 1),
                    tolerance);
      }
      RC_ASSERT(measured.at_rest().count() + measured.moving().count() == measured.all().count());
    }
  });
}

TEST(TakeErrorsProperty, ADifferenceOfTwoTakesIsThatOfTheirRecords) {
  check_property(100, [] {
    const Take first = played_take(crane(), random_take(1)), second = played_take(crane(), random_take(2));
    const TakeComparison comparison =
        compare_takes(TakeSamples(first), TakeSamples(second), measures_of(crane()));
    const std::vector<OracleRow> a = rows_of_record(record_of(first, crane()));
    const std::vector<OracleRow> b = rows_of_record(record_of(second, crane()));
    const OracleTree tree(joints_of_crane());
    std::vector<std::vector<double>> errors(9);
    std::vector<double> frames;
    for (std::size_t i = 1; i < a.size(); ++i) {
      // Of the rest at the end the last.
      if (i + 1 < a.size() && a[i].frame == a[i - 1].frame) continue;
      const OraclePose from = tree.pose(camera_link, a[i].actual), to = tree.pose(camera_link, b[i].actual);
      for (std::size_t x = 0; x < 6; ++x) errors[x].push_back(b[i].actual[x] - a[i].actual[x]);
      errors[6].push_back(1000 * distance_of(from.position, to.position));
      errors[7].push_back(angle_of(from, to));
      errors[8].push_back(shift_of(from, to));
      frames.push_back(a[i - 1].frame.value());
    }
    for (std::size_t m = 0; m < 9; ++m) {
      expect_same(comparison.measures[m].errors.all(), figures_of_errors(errors[m], frames),
                  m < 8 ? 1e-8 : 1e-6);
      RC_ASSERT(comparison.measures[m].interpolation == 0);
    }
  });
}

TEST(TakeErrorsProperty, BetweenTicksATakeOnItsPathIsOffByNoMoreThanTheBound) {
  check_property(100, [] {
    const double phase = 0.01 * *rc::gen::inRange(1, 100);
    const TakeComparison comparison =
        compare_takes(TakeSamples(played_take(crane(), {})),
                      TakeSamples(played_take(crane(), {.number = 2, .phase = phase})), measures_of(crane()));
    for (const TakeComparison::Of& of : comparison.measures) {
      RC_ASSERT(of.interpolation > 0);
      // The roll rests but for rounding, and a pixel has more of that.
      RC_ASSERT(std::fabs(of.errors.all().worst()) <= 1.001 * of.interpolation + 1e-9);
    }
  });
}

TEST(TakeErrorsProperty, PassesHaveTheAccuracyAndRepeatabilityOfTheirPoints) {
  check_property(50, [] {
    const int passes = *rc::gen::inRange(2, 6);
    std::vector<TakeSamples> samples;
    std::vector<std::vector<OracleRow>> records;
    for (int k = 0; k < passes; ++k) {
      const Take take = played_take(crane(), random_take(k + 1));
      samples.emplace_back(take);
      records.push_back(rows_of_record(record_of(take, crane())));
    }
    const PathReport report = path_report(samples, measures_of(crane()));
    const OracleTree tree(joints_of_crane());
    std::vector<std::array<double, 2>> largest(8, {0, 0});
    const auto add = [&](std::size_t measure, const Point& command, const std::vector<Point>& points) {
      const auto [accuracy, repeatability] = accuracy_and_repeatability(command, points);
      largest[measure] = {std::max(largest[measure][0], accuracy),
                          std::max(largest[measure][1], repeatability)};
    };
    for (std::size_t i = 1; i < records[0].size(); ++i) {
      if (i + 1 < records[0].size() && records[0][i].frame == records[0][i - 1].frame) continue;
      const std::vector<double> told = told_in(records[0][i - 1]);
      const OraclePose command = tree.pose(camera_link, told);
      std::vector<OraclePose> poses;
      for (const auto& record : records) poses.push_back(tree.pose(camera_link, record[i].actual));
      std::vector<Point> points;
      for (std::size_t a = 0; a < 6; ++a) {
        points.clear();
        for (const auto& record : records) points.push_back({record[i].actual[a], 0, 0});
        add(a, {told[a], 0, 0}, points);
      }
      const auto in_mm = [](const Point& p) { return Point{1000 * p[0], 1000 * p[1], 1000 * p[2]}; };
      points.clear();
      for (const OraclePose& pose : poses) points.push_back(in_mm(pose.position));
      add(6, in_mm(command.position), points);
      for (const auto& mark : marks) {
        const auto seen = oracle_camera(command).point(mark, 2.0);
        points.clear();
        for (const OraclePose& pose : poses) {
          const auto image = oracle_camera(pose).image(seen);
          points.push_back({image[0], image[1], 0});
        }
        add(7, {mark[0], mark[1], 0}, points);
      }
    }
    RC_ASSERT(report.measures.size() == 8U);
    for (std::size_t m = 0; m < 8; ++m) {
      const double tolerance = m < 7 ? 1e-8 : 1e-6;
      RC_ASSERT(std::fabs(report.measures[m].largest.accuracy - largest[m][0]) <= tolerance);
      RC_ASSERT(std::fabs(report.measures[m].largest.repeatability - largest[m][1]) <= tolerance);
    }
  });
}

}  // namespace take_errors_property_test
}  // namespace inbetween
