// What the fuzz targets have found, each as the smallest move that showed it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "host_tools/text/toml_source.hpp"

namespace inbetween {
namespace fuzz_finds_test {

struct Move {
  Spline spline = Spline::catmull_rom;
  bool closed = false;
  std::int32_t axis_count = 1;
  std::vector<double> keys;
  std::vector<double> speed = {10};
  std::int32_t frames = 50;
  ArcLengthOptions options = {};
  std::vector<std::int32_t> key_frames = {};
  std::vector<double> weights = {};
  FrameRate fps = {24, 1};
  Kinetic kinetic = Kinetic::linear;
  std::vector<KeyLock> locks = {};
};

SolvedTrack solved(const Move& move, Solver solver = Solver::closed_form) {
  return SolvedTrack({.path = {.spline = move.spline,
                               .closed = move.closed,
                               .axis_count = move.axis_count,
                               .keys = move.keys,
                               .weights = move.weights},
                      .control_values = move.speed,
                      .frames = move.frames,
                      .fps = move.fps,
                      .arc_length = move.options,
                      .locks = move.locks,
                      .key_frames = move.key_frames,
                      .kinetic = move.kinetic},
                     solver);
}

/// The error with which the core refuses a move.
Error refusal(const Move& move, Solver solver = Solver::closed_form) {
  try {
    static_cast<void>(solved(move, solver));
  } catch (const SolverError& error) {
    return error.error();
  }
  ADD_FAILURE() << "the move is not refused";
  return {};
}

void expect_sound(const SolvedTrack& solution) {
  const Status invariants = check_invariants(solution.track(), solution.table());
  EXPECT_TRUE(invariants) << (invariants ? "" : invariants.error().what);
  for (std::int32_t frame = 0; frame <= solution.track().frames(); ++frame) {
    EXPECT_TRUE(std::isfinite(frame_row(solution.track(), solution.table(), frame).distance)) << frame;
  }
}

struct Reported {
  std::vector<AxisMotion> axes;
  std::uint8_t order{};
};

/// The motion of every axis, which must be finite.
Reported motion_at(const SolvedTrack& solution, const FrameTime& time) {
  Reported motion;
  motion.axes.resize(static_cast<std::size_t>(solution.track().path().axis_count()));
  motion.order = solution.track().motion(time, motion.axes);
  for (const AxisMotion& axis : motion.axes) {
    for (const double number : {axis.position, axis.velocity, axis.acceleration, axis.jerk}) {
      EXPECT_TRUE(std::isfinite(number)) << "frame " << time.frame << " + " << time.fraction;
    }
  }
  return motion;
}

TEST(FuzzFinds, DivisionEndsWhereAPieceHasNoMoreDigits) {
  // The certificate of a piece cannot be better than rounding, and a stretch of a few ulp cannot be divided:
  // that never ended. Three axes stand still, and two keys are the same.
  Move move{.closed = true, .axis_count = 4, .keys = {127, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}};
  for (const Acceptance acceptance : {Acceptance::estimated, Acceptance::certified}) {
    for (const double delta : {1e-2, 1e-4, 1e-6, 1e-9}) {
      move.options = {.delta = delta, .acceptance = acceptance};
      try {
        expect_sound(solved(move));
      } catch (const SolverError& error) {
        EXPECT_EQ(error.error().code, ErrorCode::accuracy);
        EXPECT_GE(error.error().key, 0);
      }
    }
  }
}

TEST(FuzzFinds, APathOfSubnormalLengthIsRefused) {
  // Its scale by a power of two was infinite.
  EXPECT_EQ(refusal({.keys = {0x1p-1070, 0, 0}}).code, ErrorCode::out_of_range);
}

TEST(FuzzFinds, ASegmentTooShortToBeToldFromAPointIsPassedInNoDistance) {
  for (const double near : {0x1p-1070, 0x1p-1000, 0x1p-300}) {
    const auto solution = solved({.spline = Spline::linear, .keys = {0, near, 100}});
    expect_sound(solution);
    EXPECT_EQ(solution.track().arc_length().total(), 100);
  }
}

TEST(FuzzFinds, PiecesShorterThanTheLastBitOfTheDistanceAreNotExtrapolated) {
  // Beside a near-cusp several pieces begin at the same distance, as far as its upper part can tell. The last
  // of them was evaluated far outside itself, once in single precision: 97 units off in a step of 45926.
  const auto solution = solved({.closed = true,
                                .axis_count = 2,
                                .keys = {0x1.78p+5, 0x1.e847fep+19, 0x1.78008ap+5, 0, 0, 0, 0, 0},
                                .speed = {74}});
  expect_sound(solution);
  const Track& track = solution.track();
  const double travelled = track.arc_length().distance(track.path(), solution.table().point(25)).high;
  EXPECT_NEAR(travelled, track.distance({25, 0}).high, 1);
}

void expect_sound_or_refused(const Move& move, Solver solver) {
  try {
    expect_sound(solved(move, solver));
  } catch (const SolverError& error) {
    EXPECT_STRNE(error.error().remedy, "") << error.error().what;
  }
}

TEST(FuzzFinds, RungeKuttaThatOverflowsIsAnErrorAndNotAnIndex) {
  // Where the line turns back inside a segment its speed is 0, or rounds to less: 1 / sqrt of that is no
  // number, and was converted to the index of a segment.
  for (std::int32_t frames = 1; frames <= 60; ++frames) {
    for (const double top : {7.0, 8.0, 8.3}) {
      expect_sound_or_refused({.keys = {0, top, top, 0}, .frames = frames}, Solver::runge_kutta);
    }
  }
}

TEST(FuzzFinds, RungeKuttaStandsStillInADwellAtTheEnd) {
  // The last frame is put on the last key, which is within the tolerance of the root finder. The step from
  // the dwell before it moved by that much where the drawn speed is 0.
  Move move{.keys = {-67, -68}, .speed = {56, 32, 0, 0, 0, 0}, .frames = 34};
  const auto solution = solved(move, Solver::runge_kutta);
  expect_sound(solution);
  for (std::int32_t frame = 29; frame <= 34; ++frame) {
    EXPECT_EQ(solution.table().point(frame), solution.table().point(34)) << frame;
  }
}

TEST(FuzzFinds, RungeKuttaRefusesAMoveThatHasNoSpeedCurve) {
  // It read the integral of a curve without spans.
  const Move move{.keys = {0, 5, 30}, .frames = 20, .key_frames = {0, 8, 20}};
  expect_sound(solved(move));
  const Error error = refusal(move, Solver::runge_kutta);
  EXPECT_EQ(error.code, ErrorCode::out_of_range);
  EXPECT_STREQ(error.remedy, "use the closed-form solver");
}

// --- chords, control values and weights beside which others are nothing

TEST(FuzzFinds, ASmoothPathSharesAKnotWhereAChordIsNothingBesideTheLongest) {
  // Divided by the longest chord the second one is 0, and the knots were divided by it.
  const double longest = 1e110;
  const double nothing = std::numeric_limits<double>::min();
  for (const bool closed : {false, true}) {
    const auto solution = solved({.spline = Spline::smooth,
                                  .closed = closed,
                                  .axis_count = 2,
                                  .keys = {0, longest, nothing, 0, 0, 0, 0, -longest},
                                  .frames = 60});
    expect_sound(solution);
    for (std::int32_t frame = 0; frame <= 60; ++frame) motion_at(solution, {frame, 0});
    EXPECT_EQ(solution.track().path().position({1, 0}, 0), nothing);
    EXPECT_EQ(solution.track().path().position({3, 0}, 1), -longest);
  }
}

TEST(FuzzFinds, ASmoothPathThatSwingsBeyondTheNumbersIsRefused) {
  // Axis 1 counts for next to nothing and goes far between keys 1 and 2, which share nearly one knot: its
  // second derivative there was infinite, and the length not a number.
  const double next_to_nothing = 1e-300;
  const double far = 1e100;
  const Error error = refusal({.spline = Spline::smooth,
                               .axis_count = 2,
                               .keys = {0, 0, far, 0, far, far, 0, 0},
                               .weights = {1, next_to_nothing}});
  EXPECT_EQ(error.code, ErrorCode::out_of_range);
  EXPECT_STREQ(error.what, "the path swings beyond the range of numbers after this key");
  EXPECT_EQ(error.axis, 1);
}

TEST(FuzzFinds, ASpeedCurveTooNearZeroForItsConstantIsRefused) {
  // K = L / Phi(f) was infinite.
  const double subnormal = std::numeric_limits<double>::denorm_min();
  for (const double value : {subnormal, 8 * subnormal, Precision::smallest_square_root / 2}) {
    const Error error = refusal({.keys = {0, 100}, .speed = {value}});
    EXPECT_EQ(error.code, ErrorCode::no_distance);
    EXPECT_STREQ(error.what, "the speed curve is too near zero everywhere for a path that has length");
    EXPECT_STREQ(error.remedy, "raise a control value above 0");
  }
  EXPECT_STREQ(refusal({.keys = {0, 100}, .speed = {0, 0}}).what,
               "the speed curve is zero everywhere, but the path has length");
  expect_sound(solved({.keys = {0, 100}, .speed = {2 * Precision::smallest_square_root}}));
}

TEST(FuzzFinds, APortionWhoseSpeedIsTooNearZeroForItsConstantIsRefused) {
  const auto broken_at_key_1 = [](double before) {
    return Move{.keys = {0, 50, 100},
                .speed = {before, before, before, before, 0, 0, 10, 10},
                .frames = 70,
                .locks = {{.key = 1, .frame = 20, .breaks = true}}};
  };
  const Error error = refusal(broken_at_key_1(std::numeric_limits<double>::denorm_min()));
  EXPECT_EQ(error.code, ErrorCode::no_distance);
  EXPECT_EQ(error.key, 1);
  EXPECT_STREQ(error.what, "the speed curve is too near zero on the whole path to this key");
  EXPECT_STREQ(refusal(broken_at_key_1(0)).what, "the speed curve is zero on the whole path to this key");
  expect_sound(solved(broken_at_key_1(1)));
}

TEST(FuzzFinds, ABreakBehindWhichNextToNothingOfTheCurveIsLeftIsOnItsKey) {
  // K of the second portion is 340 000: its distances are small differences of large numbers, which were
  // looked up by the high half of a sum and ended in another piece of the path.
  const auto solution = solved({.keys = {0, 127, 127.1, 127.15, 254, 381},
                                .speed = {43, 43, 0, 0, 0, 0},
                                .frames = 14,
                                .locks = {{.key = 1, .frame = 8, .breaks = true}}});
  expect_sound(solution);
  EXPECT_EQ(solution.track().distance({8, 0}), solution.track().arc_length().segment_begin(1));
  EXPECT_NEAR(motion_at(solution, {8, 0}).axes[0].position, 127,
              512 * std::numeric_limits<double>::epsilon());
}

TEST(FuzzFinds, InADwellAtTheEndTheMoveIsAtItsEndToTheLastBit) {
  // K Phi(f) was an ulp below the length, and the rig stood at t = 1 of the last segment, not on the key.
  const std::vector<double> speed{5, 5, 0, 0, 0, 0};
  const auto solution = solved({.spline = Spline::linear, .keys = {0, 1}, .speed = speed, .frames = 35});
  expect_sound(solution);
  for (std::int32_t frame = 21; frame <= 35; ++frame) {
    EXPECT_EQ(solution.track().locate({frame, 0}), (PathPoint{1, 0})) << frame;
    EXPECT_EQ(motion_at(solution, {frame, 0}).axes[0].velocity, 0) << frame;
  }
}

// --- derivatives that no number can hold

TEST(FuzzFinds, ADerivativeBeyondTheRangeIsGivenAsZeroAndReported) {
  // What has no weight goes far while the path goes hardly anywhere, in a billionth of a second.
  const auto solution = solved({.spline = Spline::linear,
                                .axis_count = 2,
                                .keys = {0, 0, 1e-100, 1e120, 1e120, 0},
                                .frames = 3,
                                .weights = {1, 0},
                                .fps = {2'147'483'647, 1}});
  EXPECT_EQ(motion_at(solution, {0, 0}).order, 0);
  for (const std::int32_t frame : {0, 1, 2, 3}) {
    const AlongPath along = solution.track().along({frame, 0});
    EXPECT_TRUE(std::isfinite(along.speed) && std::isfinite(along.acceleration) && std::isfinite(along.jerk));
  }
}

// --- where the weighted path stands still

TEST(FuzzFinds, AnAxisOfWeightZeroThatMovesOnWhereThePathStandsStillIsReported) {
  // Axis 0 turns back on key 1 at a speed of 8; axis 1 counts for nothing and has to pass the same stretch
  // of t in no time. It was given a finite velocity from its second derivative.
  const Move move{
      .axis_count = 2, .keys = {0, 0, 8, 5, 0, 10}, .speed = {10}, .frames = 48, .weights = {1, 0}};
  const auto solution = solved(move);
  const Reported turn = motion_at(solution, {24, 0});
  EXPECT_EQ(turn.order, 0);
  EXPECT_NEAR(turn.axes[0].velocity, -8, 1e-3);
  EXPECT_NEAR(turn.axes[1].position, 5, 1e-2);
  EXPECT_EQ(turn.axes[1].velocity, 0);
  EXPECT_EQ(turn.axes[1].acceleration, 0);
  // Beside it the velocity is what it is, and grows as the root of the distance falls.
  const Reported near = motion_at(solution, {24, 0.25});
  const Reported nearer = motion_at(solution, {24, 0.0625});
  EXPECT_EQ(near.order, 3);
  EXPECT_EQ(nearer.order, 3);
  EXPECT_NEAR(nearer.axes[1].velocity / near.axes[1].velocity, 2, 0.1);
}

TEST(FuzzFinds, ATurnBetweenKeysIsReportedForTheAxisOfWeightZeroToo) {
  const auto solution = solved(
      {.axis_count = 2, .keys = {9, 0, 1, 1, 1, 2, 9, 3}, .speed = {10}, .frames = 48, .weights = {1, 0}});
  const Reported turn = motion_at(solution, {24, 0});
  EXPECT_EQ(turn.order, 0);
  EXPECT_NEAR(turn.axes[1].position, 1.5, 1e-3);
  EXPECT_EQ(turn.axes[1].velocity, 0);
}

TEST(FuzzFinds, AnAxisThatCountsForNextToNothingIsAsUnboundedAsOneOfWeightZero) {
  // On key 0 axis 0 turns. The velocity of axis 1 was the drawn speed over its weight, its jerk infinite.
  const double next_to_nothing = 1e-110;
  const auto solution = solved({.closed = true,
                                .axis_count = 2,
                                .keys = {8, 0, 0, 5, 0, 10},
                                .speed = {10},
                                .frames = 48,
                                .weights = {1, next_to_nothing}});
  EXPECT_EQ(motion_at(solution, {0, 0}).order, 0);
}

TEST(FuzzFinds, AnAxisOfWeightZeroThatTurnsWithThePathHasItsShareOfTheVelocity) {
  const auto solution =
      solved({.axis_count = 2, .keys = {0, 0, 8, 4, 0, 0}, .speed = {10}, .frames = 48, .weights = {1, 0}});
  const Reported turn = motion_at(solution, {24, 0});
  EXPECT_EQ(turn.order, 1);
  EXPECT_NEAR(turn.axes[0].velocity, -8, 1e-3);
  EXPECT_NEAR(turn.axes[1].velocity, -4, 1e-3);
}

TEST(FuzzFinds, AnAxisOfWeightZeroRestsWhereTheSpeedIsDrawnToRest) {
  const auto solution = solved({.axis_count = 2,
                                .keys = {0, 0, 8, 5, 0, 10},
                                .speed = {0, 0, 0, 5, 0, 0, 0, 0, 0, 5, 0, 0, 0},
                                .frames = 48,
                                .weights = {1, 0}});
  const Reported turn = motion_at(solution, {24, 0});
  EXPECT_EQ(turn.order, 3);
  EXPECT_EQ(turn.axes[1].velocity, 0);
  EXPECT_NEAR(turn.axes[1].position, 5, 1e-2);
}

/// Catmull-Rom keys of which the stretch behind key `cusp` is (u^2, u^3), -1 <= u <= 1, large or small beside
/// the stretches before and behind it.
struct CuspedPath {
  std::vector<double> keys;
  std::int32_t cusp = 0;
};

CuspedPath path_with_cusp(std::mt19937& random) {
  std::uniform_real_distribution<double> anywhere(-40, 40);
  std::uniform_int_distribution<int> count(0, 3);
  std::uniform_int_distribution<int> magnitude(-4, 6);
  CuspedPath path;
  const auto add_keys = [&](int keys) {
    for (int i = 0; i < 2 * keys; ++i) path.keys.push_back(anywhere(random));
  };
  const int before = count(random);
  add_keys(before);
  path.cusp = before + 1;
  const double scale = std::ldexp(1.0, magnitude(random));
  const double x = anywhere(random);
  const double y = anywhere(random);
  for (const double side : {-1.0, 1.0}) {
    const double near[] = {x + scale, y + side * scale};
    const double far[] = {x + 9 * scale, y + side * 11 * scale};
    path.keys.insert(path.keys.end(), std::begin(side < 0 ? far : near), std::end(side < 0 ? far : near));
    path.keys.insert(path.keys.end(), std::begin(side < 0 ? near : far), std::end(side < 0 ? near : far));
  }
  add_keys(count(random));
  return path;
}

/// The last time at which the move is not beyond a distance from its start.
FrameTime time_of(const Track& track, const TwoSum& distance) {
  const auto before = [&](const FrameTime& time) { return track.distance(time).minus(distance) <= 0; };
  std::int32_t frame = 0;
  while (frame + 1 < track.frames() && before({frame + 1, 0})) ++frame;
  double low = 0;
  double high = 1;
  for (int i = 0; i < std::numeric_limits<double>::digits; ++i) {
    const double middle = (low + high) / 2;
    (before({frame, middle}) ? low : high) = middle;
  }
  return {frame, low};
}

TEST(FuzzFinds, ACuspBetweenKeysIsReportedWhereverItLies) {
  // What is known of the distance of a cusp is a few roundings of the length: no move meets it better.
  std::mt19937 random(5489);
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE("path " + std::to_string(i));
    const bool alone = i < 7;
    const CuspedPath path = alone ? CuspedPath{{9, -11, 1, -1, 1, 1, 9, 11}, 1} : path_with_cusp(random);
    const auto solution = solved({.axis_count = 2,
                                  .keys = {path.keys.begin(), path.keys.end()},
                                  .speed = {5, static_cast<double>(3 + i % 7), 5},
                                  .frames = 48});
    const Track& track = solution.track();
    const TwoSum cusp = track.arc_length().distance(track.path(), {path.cusp, 0.5});
    const FrameTime time = time_of(track, cusp);
    const Reported at = motion_at(solution, time);
    ASSERT_EQ(at.order, 1);
    const AlongPath along = track.along(time);
    EXPECT_NEAR(std::hypot(at.axes[0].velocity, at.axes[1].velocity) / along.speed, 1, 1e-3);
    EXPECT_NEAR(at.axes[0].acceleration * at.axes[0].velocity + at.axes[1].acceleration * at.axes[1].velocity,
                along.acceleration * along.speed,
                1e-3 * along.speed * (along.speed + std::fabs(along.acceleration)));
    // A thousand roundings away the acceleration is known, and large.
    TwoSum away = cusp;
    away.add(1000 * std::numeric_limits<double>::epsilon() * track.arc_length().total());
    EXPECT_EQ(motion_at(solution, time_of(track, away)).order, 3);
  }
}

TEST(FuzzFinds, ASegmentAtTheEdgeOfTheNumbersHasAFiniteLengthWhateverItsWeight) {
  // Its scale by a power of two times its weight was infinite, and 0 times that the distance at the end.
  const auto full = solved({.spline = Spline::linear, .keys = {1, 0, 0x1p-1026}, .weights = {1000}});
  expect_sound(full);
  EXPECT_EQ(frame_row(full.track(), full.table(), 50).distance, 1000);
}

TEST(FuzzFinds, AQuoteDirectlyAfterAWordIsRefusedBeforeTomlSeesIt) {
  for (const std::string_view text :
       {"a = 6z\"b\xEF\xBB\xB6", "a = 1'\xEF\xBB\xB6'", "a\"b\" = 1", "a = 5!'ê'", "a = 5.'ê'", "a = [5.'ê']",
        "a = {b = [1], c = 5.'ê'}", "[a]\nb = 1.'ê'", "a = [[1], 5.'ê']", "a = 5x='ê'",
        "a=[{b = 0x605Easksd=[{c=\"ê\"}", "a = [5x['ê']]"}) {
    EXPECT_THAT([&] { parse_toml(text, "f.toml"); },
                testing::ThrowsMessage<InputError>(testing::HasSubstr("a quote directly after")))
        << text;
  }
  EXPECT_THAT([] { parse_toml(std::string_view("a = 1\0", 6), "f.toml"); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("f.toml:1:6: error: a zero byte")));
  for (const std::string_view text :
       {"a = 5#'ê'\nb = 'ê'\n", "a = [1979-05-27 07:32:00,'ê']\n",
        "a = ['x','y']\nb = {'c'='d'}\n'e' = \"\"\"f\"\"\"\n", "a.'ê'.b = [[1.5],\n[2]]\nc.'ê' = 1\n",
        "a = {b = [1], c.'ê' = 1}\n", "[[a.'ê']]\nb = 1.5\n\n[c.\"ê\"]\n"}) {
    EXPECT_NO_THROW(parse_toml(text, "f.toml")) << text;
  }
}

TEST(FuzzFinds, ACharacterBeyondAsciiBehindABackslashIsRefusedBeforeTomlSeesIt) {
  // In a string of several lines toml++ 3.3 does not define whether such a character is read.
  for (const std::string_view text : {"a = \"\"\"\\\n ê\"\"\"", "a = \"\"\"b\\ê\"\"\""}) {
    EXPECT_THAT([&] { parse_toml(text, "f.toml"); },
                testing::ThrowsMessage<InputError>(testing::HasSubstr("directly after a backslash; leave")))
        << text;
  }
  const toml::table read = parse_toml("a = \"\"\"\\\n b\\\\ê\nê\"\"\"\nb = '''\\ê'''\n", "f.toml");
  EXPECT_EQ(read["a"].value<std::string>(), "b\\ê\nê");
  EXPECT_EQ(read["b"].value<std::string>(), "\\ê");
}

TEST(FuzzFinds, AHeaderThatBeginsWithNoNameIsRefusedInALine) {
  // An assertion of toml++ 3.3 ended a program that was built without NDEBUG.
  EXPECT_THAT([] { parse_toml("[(a]\n", "f.toml"); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("f.toml:1:2: error: not valid TOML")));
}

}  // namespace fuzz_finds_test
}  // namespace inbetween
