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

#include "host_tools/files/toml_source.hpp"
#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
namespace fuzz_finds_test {

template <Precise Real>
struct Move {
  Spline spline = Spline::catmull_rom;
  bool closed = false;
  std::int32_t axis_count = 1;
  std::vector<Real> keys;
  std::vector<Real> speed = {10};
  std::int32_t frames = 50;
  ArcLengthOptions<Real> options = {};
  std::vector<std::int32_t> key_frames = {};
  std::vector<Real> weights = {};
  FrameRate fps = {24, 1};
  Kinetic kinetic = Kinetic::linear;
  std::vector<KeyLock> locks = {};
};

template <Precise Real>
SolvedTrack<Real> solved(const Move<Real>& move, Solver solver = Solver::closed_form) {
  return SolvedTrack<Real>({.path = {.spline = move.spline,
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
template <Precise Real>
Error refusal(const Move<Real>& move, Solver solver = Solver::closed_form) {
  try {
    static_cast<void>(solved(move, solver));
  } catch (const SolverError& error) {
    return error.error();
  }
  ADD_FAILURE() << "the move is not refused";
  return {};
}

template <Precise Real>
void expect_sound(const SolvedTrack<Real>& solution) {
  const Status invariants = check_invariants(solution.track(), solution.table());
  EXPECT_TRUE(invariants) << (invariants ? "" : invariants.error().what);
  for (std::int32_t frame = 0; frame <= solution.track().frames(); ++frame) {
    EXPECT_TRUE(std::isfinite(frame_row(solution.track(), solution.table(), frame).distance)) << frame;
  }
}

template <Precise Real>
struct Reported {
  std::vector<AxisMotion<Real>> axes;
  std::uint8_t order{};
};

/// The motion of every axis, which must be finite.
template <Precise Real>
Reported<Real> motion_at(const SolvedTrack<Real>& solution, const FrameTime<Real>& time) {
  Reported<Real> motion;
  motion.axes.resize(static_cast<std::size_t>(solution.track().path().axis_count()));
  motion.order = solution.track().motion(time, motion.axes);
  for (const AxisMotion<Real>& axis : motion.axes) {
    for (const Real number : {axis.position, axis.velocity, axis.acceleration, axis.jerk}) {
      EXPECT_TRUE(std::isfinite(number)) << "frame " << time.frame << " + " << time.fraction;
    }
  }
  return motion;
}

TEST(FuzzFinds, DivisionEndsWhereSinglePrecisionHasNoMoreDigits) {
  // The certificate of a piece cannot be better than rounding, and a stretch of a few ulp cannot be divided:
  // that never ended. Three axes stand still, and two keys are the same.
  Move<float> move{.closed = true, .axis_count = 4, .keys = {127, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}};
  for (const Acceptance acceptance : {Acceptance::estimated, Acceptance::certified}) {
    for (const float delta : {1e-2F, 1e-4F, 1e-5F, 4e-6F}) {
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
  const Error error = refusal<float>({.keys = {0x1p-146F, 0, 0}});
  EXPECT_EQ(error.code, ErrorCode::out_of_range);
  EXPECT_EQ(refusal<double>({.keys = {0x1p-1070, 0, 0}}).code, ErrorCode::out_of_range);
}

TEST(FuzzFinds, ASegmentTooShortToBeToldFromAPointIsPassedInNoDistance) {
  for (const float near : {0x1p-146F, 0x1p-120F, 0x1p-60F}) {
    const auto solution = solved<float>({.spline = Spline::linear, .keys = {0, near, 100}});
    expect_sound(solution);
    EXPECT_EQ(solution.track().arc_length().total(), 100);
  }
  for (const double near : {0x1p-1070, 0x1p-1000, 0x1p-300}) {
    const auto solution = solved<double>({.spline = Spline::linear, .keys = {0, near, 100}});
    expect_sound(solution);
    EXPECT_EQ(solution.track().arc_length().total(), 100);
  }
}

TEST(FuzzFinds, PiecesShorterThanTheLastBitOfTheDistanceAreNotExtrapolated) {
  // Beside a near-cusp in single precision several pieces begin at the same distance, as far as its upper
  // part can tell. The last of them was evaluated far outside itself: 97 units off in a step of 45926.
  const auto solution = solved<float>({.closed = true,
                                       .axis_count = 2,
                                       .keys = {0x1.78p+5F, 0x1.e847fep+19F, 0x1.78008ap+5F, 0, 0, 0, 0, 0},
                                       .speed = {74}});
  expect_sound(solution);
  const Track<float>& track = solution.track();
  const float travelled = track.arc_length().distance(track.path(), solution.table().point(25)).high;
  EXPECT_NEAR(travelled, track.distance({25, 0}).high, 1);
}

template <Precise Real>
void expect_sound_or_refused(const Move<Real>& move, Solver solver) {
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
    for (const float top : {7.0F, 8.0F, 8.3F}) {
      expect_sound_or_refused<float>({.keys = {0, top, top, 0}, .frames = frames}, Solver::runge_kutta);
      const auto same = static_cast<double>(top);
      expect_sound_or_refused<double>({.keys = {0, same, same, 0}, .frames = frames}, Solver::runge_kutta);
    }
  }
}

TEST(FuzzFinds, RungeKuttaStandsStillInADwellAtTheEnd) {
  // The last frame is put on the last key, which is within the tolerance of the root finder. The step from
  // the dwell before it moved by that much where the drawn speed is 0.
  Move<double> move{.keys = {-67, -68}, .speed = {56, 32, 0, 0, 0, 0}, .frames = 34};
  const auto solution = solved(move, Solver::runge_kutta);
  expect_sound(solution);
  for (std::int32_t frame = 29; frame <= 34; ++frame) {
    EXPECT_EQ(solution.table().point(frame), solution.table().point(34)) << frame;
  }
}

TEST(FuzzFinds, RungeKuttaRefusesAMoveThatHasNoSpeedCurve) {
  // It read the integral of a curve without spans.
  const Move<double> move{.keys = {0, 5, 30}, .frames = 20, .key_frames = {0, 8, 20}};
  expect_sound(solved(move));
  const Error error = refusal(move, Solver::runge_kutta);
  EXPECT_EQ(error.code, ErrorCode::out_of_range);
  EXPECT_STREQ(error.remedy, "use the closed-form solver");
}

template <class Real>
class FuzzFindsIn : public testing::Test {};
using Precisions = testing::Types<double, float>;
TYPED_TEST_SUITE(FuzzFindsIn, Precisions);

// --- chords, control values and weights beside which others are nothing

TYPED_TEST(FuzzFindsIn, ASmoothPathSharesAKnotWhereAChordIsNothingBesideTheLongest) {
  using Real = TypeParam;
  // Divided by the longest chord the second one is 0, and the knots were divided by it.
  const Real longest = std::is_same_v<Real, double> ? Real(1e110) : Real(1e11);
  const Real nothing = std::numeric_limits<Real>::min();
  for (const bool closed : {false, true}) {
    const auto solution = solved<Real>({.spline = Spline::smooth,
                                        .closed = closed,
                                        .axis_count = 2,
                                        .keys = {0, longest, nothing, 0, 0, 0, 0, -longest},
                                        .frames = 60});
    expect_sound(solution);
    for (std::int32_t frame = 0; frame <= 60; ++frame) motion_at<Real>(solution, {frame, 0});
    EXPECT_EQ(solution.track().path().position({1, 0}, 0), nothing);
    EXPECT_EQ(solution.track().path().position({3, 0}, 1), -longest);
  }
}

TYPED_TEST(FuzzFindsIn, ASmoothPathThatSwingsBeyondTheNumbersIsRefused) {
  using Real = TypeParam;
  // Axis 1 counts for next to nothing and goes far between keys 1 and 2, which share nearly one knot: its
  // second derivative there was infinite, and the length not a number.
  const Real next_to_nothing = std::is_same_v<Real, double> ? Real(1e-300) : Real(1e-30);
  const Real far = std::is_same_v<Real, double> ? Real(1e100) : Real(1e12);
  const Error error = refusal<Real>({.spline = Spline::smooth,
                                     .axis_count = 2,
                                     .keys = {0, 0, far, 0, far, far, 0, 0},
                                     .weights = {1, next_to_nothing}});
  EXPECT_EQ(error.code, ErrorCode::out_of_range);
  EXPECT_STREQ(error.what, "the path swings beyond the range of numbers after this key");
  EXPECT_EQ(error.axis, 1);
}

TYPED_TEST(FuzzFindsIn, ASpeedCurveTooNearZeroForItsConstantIsRefused) {
  using Real = TypeParam;
  // K = L / Phi(f) was infinite.
  const Real subnormal = std::numeric_limits<Real>::denorm_min();
  for (const Real value : {subnormal, 8 * subnormal, Precision<Real>::smallest_square_root / 2}) {
    const Error error = refusal<Real>({.keys = {0, 100}, .speed = {value}});
    EXPECT_EQ(error.code, ErrorCode::no_distance);
    EXPECT_STREQ(error.what, "the speed curve is too near zero everywhere for a path that has length");
    EXPECT_STREQ(error.remedy, "raise a control value above 0");
  }
  EXPECT_STREQ(refusal<Real>({.keys = {0, 100}, .speed = {0, 0}}).what,
               "the speed curve is zero everywhere, but the path has length");
  expect_sound(solved<Real>({.keys = {0, 100}, .speed = {2 * Precision<Real>::smallest_square_root}}));
}

TYPED_TEST(FuzzFindsIn, APortionWhoseSpeedIsTooNearZeroForItsConstantIsRefused) {
  using Real = TypeParam;
  const auto broken_at_key_1 = [](Real before) {
    return Move<Real>{.keys = {0, 50, 100},
                      .speed = {before, before, before, before, 0, 0, 10, 10},
                      .frames = 70,
                      .locks = {{.key = 1, .frame = 20, .breaks = true}}};
  };
  const Error error = refusal(broken_at_key_1(std::numeric_limits<Real>::denorm_min()));
  EXPECT_EQ(error.code, ErrorCode::no_distance);
  EXPECT_EQ(error.key, 1);
  EXPECT_STREQ(error.what, "the speed curve is too near zero on the whole way to this key");
  EXPECT_STREQ(refusal(broken_at_key_1(0)).what, "the speed curve is zero on the whole way to this key");
  expect_sound(solved(broken_at_key_1(1)));
}

TYPED_TEST(FuzzFindsIn, ABreakBehindWhichNextToNothingOfTheCurveIsLeftIsOnItsKey) {
  using Real = TypeParam;
  // K of the second portion is 340 000: its distances are small differences of large numbers, which were
  // looked up by the high half of a sum and ended in another piece of the path.
  const auto solution = solved<Real>({.keys = {0, 127, Real(127.1), Real(127.15), 254, 381},
                                      .speed = {43, 43, 0, 0, 0, 0},
                                      .frames = 14,
                                      .locks = {{.key = 1, .frame = 8, .breaks = true}}});
  expect_sound(solution);
  EXPECT_EQ(solution.track().distance({8, 0}), solution.track().arc_length().segment_begin(1));
  EXPECT_NEAR(motion_at<Real>(solution, {8, 0}).axes[0].position, 127,
              512 * std::numeric_limits<Real>::epsilon());
}

TYPED_TEST(FuzzFindsIn, InADwellAtTheEndTheMoveIsAtItsEndToTheLastBit) {
  using Real = TypeParam;
  // K Phi(f) was an ulp below the length, and the rig stood at t = 1 of the last segment, not on the key.
  const std::vector<Real> speed = std::is_same_v<Real, float> ? std::vector<Real>{25, 4, 0, 0, 0, 0}
                                                              : std::vector<Real>{5, 5, 0, 0, 0, 0};
  const auto solution =
      solved<Real>({.spline = Spline::linear, .keys = {0, 1}, .speed = speed, .frames = 35});
  expect_sound(solution);
  for (std::int32_t frame = 21; frame <= 35; ++frame) {
    EXPECT_EQ(solution.track().locate({frame, 0}), (PathPoint<Real>{1, 0})) << frame;
    EXPECT_EQ(motion_at<Real>(solution, {frame, 0}).axes[0].velocity, 0) << frame;
  }
}

// --- derivatives that no number can hold

TEST(FuzzFinds, ADerivativeBeyondTheRangeIsGivenAsZeroAndReported) {
  const FrameRate quick{2'147'483'647, 1};
  const auto by_frames = solved<float>({.keys = {0, 7e14F, 1e15F},
                                        .frames = 3,
                                        .key_frames = {0, 1, 3},
                                        .fps = quick,
                                        .kinetic = Kinetic::monotone});
  EXPECT_EQ(motion_at<float>(by_frames, {0, 0}).order, 0);
  const auto by_curve = solved<float>(
      {.spline = Spline::linear, .keys = {0, 1e15F}, .speed = {0, 0, 9, 0, 0}, .frames = 3, .fps = quick});
  EXPECT_EQ(motion_at<float>(by_curve, {1, 0}).order, 0);
  for (const SolvedTrack<float>* solution : {&by_frames, &by_curve}) {
    for (const std::int32_t frame : {0, 1, 2, 3}) {
      const AlongPath<float> along = solution->track().along({frame, 0});
      EXPECT_TRUE(std::isfinite(along.speed) && std::isfinite(along.acceleration) &&
                  std::isfinite(along.jerk));
    }
  }
}

// --- where the weighted path stands still

TYPED_TEST(FuzzFindsIn, AnAxisOfWeightZeroThatMovesOnWhereThePathStandsStillIsReported) {
  using Real = TypeParam;
  // Axis 0 turns back on key 1 at a speed of 8; axis 1 counts for nothing and has to pass the same stretch
  // of t in no time. It was given a finite velocity from its second derivative.
  const Move<Real> move{
      .axis_count = 2, .keys = {0, 0, 8, 5, 0, 10}, .speed = {10}, .frames = 48, .weights = {1, 0}};
  const auto solution = solved(move);
  const Reported<Real> turn = motion_at<Real>(solution, {24, 0});
  EXPECT_EQ(turn.order, 0);
  EXPECT_NEAR(turn.axes[0].velocity, -8, Real(1e-3));
  EXPECT_NEAR(turn.axes[1].position, 5, 1e-2);
  EXPECT_EQ(turn.axes[1].velocity, 0);
  EXPECT_EQ(turn.axes[1].acceleration, 0);
  // Beside it the velocity is what it is, and grows as the root of the distance falls.
  const Reported<Real> near = motion_at<Real>(solution, {24, Real(0.25)});
  const Reported<Real> nearer = motion_at<Real>(solution, {24, Real(0.0625)});
  EXPECT_EQ(near.order, 3);
  EXPECT_EQ(nearer.order, 3);
  EXPECT_NEAR(nearer.axes[1].velocity / near.axes[1].velocity, 2, 0.1);
}

TYPED_TEST(FuzzFindsIn, ATurnBetweenKeysIsReportedForTheAxisOfWeightZeroToo) {
  using Real = TypeParam;
  const auto solution = solved<Real>(
      {.axis_count = 2, .keys = {9, 0, 1, 1, 1, 2, 9, 3}, .speed = {10}, .frames = 48, .weights = {1, 0}});
  const Reported<Real> turn = motion_at<Real>(solution, {24, 0});
  EXPECT_EQ(turn.order, 0);
  EXPECT_NEAR(turn.axes[1].position, 1.5, 1e-3);
  EXPECT_EQ(turn.axes[1].velocity, 0);
}

TYPED_TEST(FuzzFindsIn, AnAxisThatCountsForNextToNothingIsAsUnboundedAsOneOfWeightZero) {
  using Real = TypeParam;
  // On key 0 axis 0 turns. The velocity of axis 1 was the drawn speed over its weight, its jerk infinite.
  const Real next_to_nothing = std::is_same_v<Real, double> ? Real(1e-110) : Real(1e-30);
  const auto solution = solved<Real>({.closed = true,
                                      .axis_count = 2,
                                      .keys = {8, 0, 0, 5, 0, 10},
                                      .speed = {10},
                                      .frames = 48,
                                      .weights = {1, next_to_nothing}});
  EXPECT_EQ(motion_at<Real>(solution, {0, 0}).order, 0);
}

TYPED_TEST(FuzzFindsIn, AnAxisOfWeightZeroThatTurnsWithThePathHasItsShareOfTheVelocity) {
  using Real = TypeParam;
  const auto solution = solved<Real>(
      {.axis_count = 2, .keys = {0, 0, 8, 4, 0, 0}, .speed = {10}, .frames = 48, .weights = {1, 0}});
  const Reported<Real> turn = motion_at<Real>(solution, {24, 0});
  EXPECT_EQ(turn.order, 1);
  EXPECT_NEAR(turn.axes[0].velocity, -8, Real(1e-3));
  EXPECT_NEAR(turn.axes[1].velocity, -4, Real(1e-3));
}

TYPED_TEST(FuzzFindsIn, AnAxisOfWeightZeroRestsWhereTheSpeedIsDrawnToRest) {
  using Real = TypeParam;
  const auto solution = solved<Real>({.axis_count = 2,
                                      .keys = {0, 0, 8, 5, 0, 10},
                                      .speed = {0, 0, 0, 5, 0, 0, 0, 0, 0, 5, 0, 0, 0},
                                      .frames = 48,
                                      .weights = {1, 0}});
  const Reported<Real> turn = motion_at<Real>(solution, {24, 0});
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
template <Precise Real>
FrameTime<Real> time_of(const Track<Real>& track, const TwoSum<Real>& distance) {
  const auto before = [&](const FrameTime<Real>& time) { return track.distance(time).minus(distance) <= 0; };
  std::int32_t frame = 0;
  while (frame + 1 < track.frames() && before({frame + 1, 0})) ++frame;
  Real low = 0;
  Real high = 1;
  for (int i = 0; i < std::numeric_limits<Real>::digits; ++i) {
    const Real middle = (low + high) / 2;
    (before({frame, middle}) ? low : high) = middle;
  }
  return {frame, low};
}

TYPED_TEST(FuzzFindsIn, ACuspBetweenKeysIsReportedWhereverItLies) {
  using Real = TypeParam;
  // What is known of the distance of a cusp is a few roundings of the length: no move meets it better.
  std::mt19937 random(5489);
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE("path " + std::to_string(i));
    const bool alone = i < 7;
    const CuspedPath path = alone ? CuspedPath{{9, -11, 1, -1, 1, 1, 9, 11}, 1} : path_with_cusp(random);
    const auto solution = solved<Real>({.axis_count = 2,
                                        .keys = {path.keys.begin(), path.keys.end()},
                                        .speed = {5, static_cast<Real>(3 + i % 7), 5},
                                        .frames = 48});
    const Track<Real>& track = solution.track();
    const TwoSum<Real> cusp = track.arc_length().distance(track.path(), {path.cusp, Real(0.5)});
    const FrameTime<Real> time = time_of(track, cusp);
    const Reported<Real> at = motion_at<Real>(solution, time);
    ASSERT_EQ(at.order, 1);
    const AlongPath<Real> along = track.along(time);
    EXPECT_NEAR(std::hypot(at.axes[0].velocity, at.axes[1].velocity) / along.speed, 1, 1e-3);
    EXPECT_NEAR(at.axes[0].acceleration * at.axes[0].velocity + at.axes[1].acceleration * at.axes[1].velocity,
                along.acceleration * along.speed,
                Real(1e-3) * along.speed * (along.speed + std::fabs(along.acceleration)));
    // A thousand roundings away the acceleration is known, and large.
    TwoSum<Real> away = cusp;
    away.add(1000 * std::numeric_limits<Real>::epsilon() * track.arc_length().total());
    EXPECT_EQ(motion_at<Real>(solution, time_of(track, away)).order, 3);
  }
}

TEST(FuzzFinds, ASegmentAtTheEdgeOfTheNumbersHasAFiniteLengthWhateverItsWeight) {
  // Its scale by a power of two times its weight was infinite, and 0 times that the distance at the end.
  const auto single = solved<float>({.spline = Spline::linear, .keys = {1, 0, 0x1p-130F}, .weights = {100}});
  expect_sound(single);
  EXPECT_EQ(frame_row(single.track(), single.table(), 50).distance, 100);
  const auto full = solved<double>({.spline = Spline::linear, .keys = {1, 0, 0x1p-1026}, .weights = {1000}});
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
