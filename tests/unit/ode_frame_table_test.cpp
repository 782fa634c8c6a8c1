#include "host_tools/plan/ode_frame_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "inbetween/base/zeroin.hpp"

namespace inbetween {
namespace ode_frame_table_test {

using testing::HasSubstr;

struct Drawing {
  Spline spline = Spline::smooth;
  bool closed = false;
  std::int32_t axis_count = 2;
  std::vector<double> keys = {0, 0, 5, 9, 20, 3, 18, -4, 30, -10};
  std::vector<KeyShape> shapes = {};
  std::vector<double> speed = {0, 0, 10, 30, 4, 4, 0, 0};
  std::int32_t frames = 100;
};

TrackSpec spec_of(const Drawing& drawing) {
  return {.path = {.spline = drawing.spline,
                   .closed = drawing.closed,
                   .axis_count = drawing.axis_count,
                   .keys = drawing.keys,
                   .shapes = drawing.shapes},
          .control_values = drawing.speed,
          .frames = drawing.frames,
          .fps = {24, 1},
          .arc_length = {.delta = 1e-9}};
}

SolvedTrack integrated(const Drawing& drawing, std::int32_t substeps = 10) {
  return SolvedTrack(spec_of(drawing), Solver::runge_kutta, {.substeps = substeps});
}

SolvedTrack closed_form(const Drawing& drawing) {
  return SolvedTrack(spec_of(drawing), Solver::closed_form);
}

/// The error with which the Runge-Kutta solver refuses a drawing that the closed form solves.
Error refusal(const Drawing& drawing, std::int32_t substeps = 10) {
  EXPECT_NO_THROW(closed_form(drawing));
  try {
    const auto solution = integrated(drawing, substeps);
    ADD_FAILURE() << "solved, with a speed error of " << solution.table().provenance().speed_error;
  } catch (const SolverError& error) {
    return error.error();
  }
  return {};
}

// --- the solver

TEST(RungeKutta, FindsTheTableOfTheClosedForm) {
  for (const bool closed : {false, true}) {
    const Drawing drawing{.closed = closed};
    const auto expected = closed_form(drawing);
    const auto solution = integrated(drawing, 200);
    const Track& track = solution.track();
    ASSERT_EQ(solution.table().frames(), 100);
    for (std::int32_t frame = 0; frame <= 100; ++frame) {
      EXPECT_NEAR(frame_row(track, solution.table(), frame).distance,
                  frame_row(track, expected.table(), frame).distance, 1e-4 * track.arc_length().total());
    }
  }
}

TEST(RungeKutta, TheFirstAndLastFrameAreTheKeysToTheLastBit) {
  for (const bool closed : {false, true}) {
    const Drawing drawing{.closed = closed};
    const auto solution = integrated(drawing);
    EXPECT_EQ(solution.table().point(0), (PathPoint{0, 0}));
    EXPECT_EQ(solution.table().point(100), (PathPoint{closed ? 5 : 4, 0}));
    EXPECT_TRUE(check_invariants(solution.track(), solution.table()));
  }
}

TEST(RungeKutta, TheTableCarriesItsProvenance) {
  const auto solution = integrated({});
  const Provenance& provenance = solution.table().provenance();
  ASSERT_TRUE(solution.integrated());
  const OdeTable& made = *solution.integrated();
  EXPECT_EQ(made.substeps, 10);
  EXPECT_GE(made.integrations, 4);  // two that bracket, one that ZEROIN asks for, and the final one
  EXPECT_LE(made.integrations, 25);
  EXPECT_GT(provenance.speed_error, 0);
  EXPECT_LE(provenance.speed_error, 0.02);
  EXPECT_GE(made.speed_error_frame, 1);
  EXPECT_LE(made.speed_error_frame, 100);
  EXPECT_NEAR(provenance.constant / solution.track().constant(), 1, 1e-3);
}

TEST(RungeKutta, IsOfFourthOrderWhereThePathIsSmooth) {
  // One segment, within which |P'| varies: half the step, a sixteenth of the error.
  const Drawing drawing{.spline = Spline::tcb,
                        .axis_count = 1,
                        .keys = {0, 1},
                        .shapes = {{.tension = 0.2}, {.tension = 0.2}},
                        .speed = {1, 3},
                        .frames = 5};
  const auto error = [&](std::int32_t substeps) {
    const OdeOptions options{.substeps = substeps, .tolerance = 1e-13};
    return SolvedTrack(spec_of(drawing), Solver::runge_kutta, options).table().provenance().speed_error;
  };
  double error_before = error(8);
  EXPECT_LT(error_before, 1e-6);
  for (const std::int32_t substeps : {16, 32, 64}) {
    const double error_now = error(substeps);
    EXPECT_NEAR(error_before / error_now, 16, 1) << substeps;
    error_before = error_now;
  }
}

TEST(RungeKutta, IsExactOnAStraightLineRunEvenly) {
  const Drawing drawing{.axis_count = 1, .keys = {0, 1}, .speed = {2}, .frames = 10};
  const auto solution = integrated(drawing, 1);
  EXPECT_LE(solution.table().provenance().speed_error, 1e-8);
  EXPECT_NEAR(solution.table().provenance().constant, 0.5, 1e-9);
  for (std::int32_t frame = 0; frame < 10; ++frame)
    EXPECT_NEAR(solution.table().point(frame).t, frame / 10.0, 1e-8);
}

TEST(RungeKutta, IsTheClassicalMethodStepForStep) {
  // One step of Kutta's formula by hand: P' = c1 + 2 c2 t + 3 c3 t^2, phi = 1 + 2 a, a = 0.5 a frame.
  const Drawing drawing{.spline = Spline::tcb,
                        .axis_count = 1,
                        .keys = {0, 1},
                        .shapes = {{.tension = 0.5}, {.tension = 0.5}},
                        .speed = {1, 3},
                        .frames = 2};
  const auto solution = integrated(drawing, 1);
  const double k = solution.table().provenance().constant;
  const auto slope = [&](double a, double s) { return k * (1 + 2 * a) / (0.5 + 3 * s - 3 * s * s); };
  const auto step = [&](double a, double s) {
    const double h = 0.5;
    const double s1 = h * slope(a, s);
    const double s2 = h * slope(a + h / 2, s + s1 / 2);
    const double s3 = h * slope(a + h / 2, s + s2 / 2);
    const double s4 = h * slope(a + h, s + s3);
    return s + (s1 + 2 * s2 + 2 * s3 + s4) / 6;
  };
  const double middle = step(0, 0);
  EXPECT_NEAR(solution.table().point(1).t, middle, 1e-12);
  EXPECT_NEAR(step(0.5, middle), 1, 1e-8);
}

TEST(RungeKutta, MoreStepsAFrameShrinkItsError) {
  const auto error = [](std::int32_t substeps) {
    return integrated({}, substeps).table().provenance().speed_error;
  };
  const double coarse = error(5);
  const double fine = error(50);
  const double finest = error(500);
  EXPECT_LT(fine, coarse / 5);
  EXPECT_LT(finest, fine / 5);
}

TEST(RungeKutta, StaysThroughADwell) {
  const Drawing drawing{.speed = {8, 0, 0, 0, 0, 8}, .frames = 50};
  const auto solution = integrated(drawing, 40);
  for (std::int32_t frame = 21; frame <= 30; ++frame) {
    EXPECT_EQ(solution.table().point(frame), solution.table().point(20));
  }
}

TEST(RungeKutta, APathThatStaysIsNoTask) {
  const auto solution = integrated({.axis_count = 1, .keys = {4, 4}, .frames = 3});
  EXPECT_EQ(solution.table().point(2), (PathPoint{0, 0}));
  EXPECT_EQ(solution.table().point(3), (PathPoint{1, 0}));
  EXPECT_EQ(solution.table().provenance().constant, 0);
}

TEST(RungeKutta, RefusesASpeedMoreThanTwoPercentOffAndAsksForMoreSteps) {
  // A hairpin in ten frames.
  const Drawing drawing{
      .spline = Spline::catmull_rom, .keys = {9, -0.3, 1, -0.1, 1, 0.1, 9, 0.3}, .frames = 10};
  const Error error = refusal(drawing, 1);
  EXPECT_EQ(error.code, ErrorCode::accuracy);
  EXPECT_THAT(error.remedy, HasSubstr("more steps a frame"));
  EXPECT_GE(error.frame, 1);
  EXPECT_LE(error.frame, 10);
  const auto solution = integrated(drawing, 1000);
  EXPECT_LE(solution.table().provenance().speed_error, 0.02);
}

TEST(RungeKutta, RefusesATableThatMissesTheLastKey) {
  // |P'| jumps at the keys, so that s(f) jumps as a function of K and may jump over the end.
  const Drawing steady{
      .spline = Spline::linear, .axis_count = 1, .keys = {17, 18, 2, 16, 13}, .speed = {9, 9}, .frames = 31};
  const Drawing slow_end{
      .spline = Spline::linear, .axis_count = 1, .keys = {0, 6, 16, 13}, .speed = {0, 1, 4, 0}, .frames = 22};
  for (const Drawing& drawing : {steady, slow_end}) {
    const Error error = refusal(drawing);
    EXPECT_EQ(error.code, ErrorCode::not_converged);
    EXPECT_THAT(error.remedy, HasSubstr("closed-form"));
  }
}

TEST(RungeKutta, TensionOneIsSingularAndNamesItsKey) {
  std::vector<KeyShape> shapes(5);
  for (const std::int32_t key : {0, 2, 4}) {
    shapes.assign(5, {});
    shapes[static_cast<std::size_t>(key)].tension = 1;
    const Error error = refusal({.spline = Spline::tcb, .shapes = shapes});
    EXPECT_EQ(error.code, ErrorCode::singular);
    EXPECT_EQ(error.key, key);
    EXPECT_THAT(error.remedy, HasSubstr("closed-form"));
  }
}

TEST(RungeKutta, ARepeatedKeyIsSingularAndNamed) {
  const Error error = refusal({.keys = {0, 0, 5, 9, 5, 9, 20, 3}});
  EXPECT_EQ(error.code, ErrorCode::singular);
  EXPECT_EQ(error.key, 1);
}

TEST(RungeKutta, ACuspInsideASegmentNeverGivesAWrongTable) {
  for (const std::int32_t substeps : {1, 7, 10, 32, 100}) {
    const Drawing cusp{.spline = Spline::catmull_rom, .keys = {9, -11, 1, -1, 1, 1, 9, 11}, .frames = 24};
    try {
      const auto solution = integrated(cusp, substeps);
      EXPECT_LE(solution.table().provenance().speed_error, 0.02);
      EXPECT_TRUE(check_invariants(solution.track(), solution.table()));
    } catch (const SolverError& error) {
      EXPECT_THAT(error.error().remedy, HasSubstr("closed-form"));
    }
  }
}

TEST(RungeKutta, StepsAFrameAreCountedFromOneToTenThousand) {
  for (const std::int32_t substeps : {0, -1, 10'001}) {
    EXPECT_EQ(refusal({}, substeps).code, ErrorCode::out_of_range) << substeps;
  }
  EXPECT_EQ(integrated({.axis_count = 1, .keys = {0, 1}, .speed = {1}, .frames = 1}, 10'000).table().frames(),
            1);
}

TEST(RungeKutta, StatesTheCapacityNeededWhichSuffices) {
  const Drawing drawing{.frames = 20};
  const auto good = closed_form(drawing);
  std::vector<PathPoint> points(100);
  const auto solve = [&](std::size_t point_count) {
    return runge_kutta_table(good.track(), {.substeps = 50}, std::span(points).first(point_count));
  };
  const auto no_points = solve(20);
  ASSERT_FALSE(no_points);
  EXPECT_EQ(no_points.error().code, ErrorCode::capacity);
  EXPECT_EQ(no_points.error().needed, 21);
  EXPECT_TRUE(solve(21));
}

// --- its root finder

/// Runs ZEROIN from the ends of an interval and counts what it asks for.
struct Search {
  Sample found;
  int evaluations = 0;
  double least = std::numeric_limits<double>::infinity();  ///< |y| of the best sample it was shown

  template <class Function>
  Search(Function function, double from, double to, double tolerance, std::int32_t most = 200) {
    const auto counted = [&](double x) {
      ++evaluations;
      const double y = function(x);
      least = std::min(least, std::fabs(y));
      return y;
    };
    const Sample a{from, function(from)};
    const Sample b{to, function(to)};
    least = std::min(std::fabs(a.y), std::fabs(b.y));
    found = zeroin(counted, a, b, tolerance, most);
  }
};

TEST(Zeroin, ALineIsFoundAtOnce) {
  const auto line = [](double x) { return 3 * x - 1; };
  for (const bool turned : {false, true}) {
    const Search search(line, turned ? 5.0 : -2.0, turned ? -2.0 : 5.0, 1e-6);
    EXPECT_NEAR(search.found.x, 1.0 / 3, 1e-6);
    EXPECT_EQ(search.found.y, line(search.found.x));
    EXPECT_LE(search.evaluations, 3);
  }
}

TEST(Zeroin, ACubicIsFoundFasterThanByHalving) {
  const auto cubic = [](double x) { return x * x * x - 2; };
  const Search search(cubic, 0, 4, 1e-6);
  EXPECT_NEAR(search.found.x, std::cbrt(2.0), 1e-6);
  EXPECT_LE(search.evaluations, 12) << "halving takes 22";
}

TEST(Zeroin, ATightToleranceIsMetToTheLastDigits) {
  const Search search([](double x) { return std::cos(x) - x; }, 0.0, 1.0, 0.0);
  EXPECT_NEAR(search.found.x, 0.7390851332151607, 4e-16);
  EXPECT_LE(search.evaluations, 10);
}

TEST(Zeroin, AFlatZeroIsStillBracketed) {
  const auto flat = [](double x) { return std::pow(x - 0.3, 9.0); };
  const Search search(flat, -1.0, 4.0, 1e-6);
  EXPECT_NEAR(search.found.x, 0.3, 1e-6);
  EXPECT_LE(search.evaluations, 150);
}

TEST(Zeroin, APlateauOfZeroEndsTheSearch) {
  const auto plateau = [](double x) { return x < 1 ? x - 1 : x > 3 ? x - 3 : 0.0; };
  const Search search(plateau, -2.0, 9.0, 1e-12);
  EXPECT_EQ(search.found.y, 0);
  EXPECT_GE(search.found.x, 1);
  EXPECT_LE(search.found.x, 3);
}

TEST(Zeroin, AStepIsHalvedDownToItsTolerance) {
  for (int i = 1; i < 100; ++i) {
    const double edge = i / 100.0 + 1e-3;
    const Search search([&](double x) { return x < edge ? -1.0 : 5.0; }, 0.0, 1.0, 1e-9);
    EXPECT_NEAR(search.found.x, edge, 1.0001e-9);
    EXPECT_LE(search.evaluations, 80);
  }
}

TEST(Zeroin, AFunctionFlatOnOneSideOnlyIsStillFound) {
  // Beyond the zero all trials look alike, as where an integration stops at its slack.
  const auto saturated = [](double x) { return std::min(x * x - 0.25, 1e-3); };
  const Search search(saturated, 0.0, 1000.0, 1e-12);
  EXPECT_NEAR(search.found.x, 0.5, 1e-12);
  EXPECT_LE(search.evaluations, 100);
}

TEST(Zeroin, AZeroAtAnEndIsReturnedWithoutSearching) {
  const auto line = [](double x) { return x - 1; };
  const Search upper(line, 0.0, 1.0, 1e-9);
  EXPECT_EQ(upper.found.x, 1);
  EXPECT_EQ(upper.evaluations, 0);
  const Search lower(line, 1.0, 3.0, 1e-9);
  EXPECT_EQ(lower.found.x, 1);
  EXPECT_EQ(lower.evaluations, 0);
}

TEST(Zeroin, NeverAsksForMoreThanItMayAndReturnsTheBestItSaw) {
  const auto steep = [](double x) { return std::exp(20 * x) - 2; };
  for (std::int32_t most = 0; most <= 20; ++most) {
    const Search search(steep, -3.0, 1.0, 1e-12, most);
    EXPECT_LE(search.evaluations, most);
    EXPECT_EQ(std::fabs(search.found.y), search.least) << "after " << most;
    EXPECT_EQ(search.found.y, steep(search.found.x));
  }
}

}  // namespace ode_frame_table_test
}  // namespace inbetween
