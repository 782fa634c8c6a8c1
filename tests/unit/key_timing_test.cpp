#include "inbetween/timing/key_timing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "tests/support/oracle_least_squares.hpp"
#include "tests/support/oracle_profile.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace key_timing_test {

using Storage = KeyTimingStorage<4, 1025>;

/// The requests of a move along a line with keys at 0, 10, 30, 60, 100.
struct Requests {
  std::vector<double> speed = {0, 0, 10, 10, 10, 10, 10, 0, 0};
  std::vector<KeyLock> locks;
  std::int32_t frames = 240;
  std::vector<double> distances = {0, 10, 30, 60, 100};
};

Result<KeyTiming> adjust(const Requests& requests, Storage& storage) {
  return adjust_to_locks({.control_values = requests.speed,
                          .key_distances = requests.distances,
                          .locks = requests.locks,
                          .frames = requests.frames},
                         storage.memory());
}

std::vector<double> adjusted(const Requests& requests) {
  const auto storage = std::make_unique<Storage>();
  const Result<KeyTiming> result = adjust(requests, *storage);
  if (!result) {
    ADD_FAILURE() << result.error().what;
    return requests.speed;
  }
  return {result->control_values.begin(), result->control_values.end()};
}

void expect_refused(const Requests& requests, ErrorCode code, std::int32_t key, std::int32_t frame) {
  const auto storage = std::make_unique<Storage>();
  const Result<KeyTiming> result = adjust(requests, *storage);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, code) << result.error().what;
  EXPECT_EQ(result.error().key, key) << result.error().what;
  EXPECT_EQ(result.error().frame, frame) << result.error().what;
  EXPECT_STRNE(result.error().remedy, "");
}

/// The share of the path that has been gone on a frame.
double share(const std::vector<double>& values, std::int32_t frame, std::int32_t frames) {
  const oracle::Profile profile(values);
  const auto f = static_cast<long double>(profile.spans());
  const long double a = static_cast<long double>(frame) * f / static_cast<long double>(frames);
  return static_cast<double>(profile.integral(a) / profile.integral(f));
}

SolvedTrack solved(const Requests& requests) {
  const std::vector<double> keys = {0, 10, 30, 60, 100};
  return {{.path = {.spline = Spline::linear, .axis_count = 1, .keys = keys},
           .control_values = requests.speed,
           .frames = requests.frames,
           .fps = {24, 1},
           .arc_length = {},
           .locks = requests.locks},
          Solver::closed_form};
}

// --- the oracle itself

TEST(QuadraticProgramOracle, SolvesWhatCanBeSolvedByHand) {
  // x + y + z = 9 from (1, 1, 1): each gains 2; with z at most 2, the others gain 2.5.
  oracle::QuadraticProgram problem{.rows = {{1, 1, 1}},
                                   .targets = {9},
                                   .drawn = {1, 1, 1},
                                   .mobility = {1, 1, 1},
                                   .ceiling = {100, 100, 100}};
  EXPECT_THAT(oracle::solve(problem).value(), testing::Each(3));
  problem.ceiling[2] = 2;
  EXPECT_THAT(oracle::solve(problem).value(), testing::ElementsAre(3.5L, 3.5L, 2));
  problem.mobility[0] = 4;
  EXPECT_NEAR(static_cast<double>(oracle::solve(problem).value()[0]), 1 + 5 * 0.8, 1e-15);
  problem.ceiling = {3, 3, 2};
  EXPECT_FALSE(oracle::solve(problem).has_value());
}

TEST(QuadraticProgramOracle, RefinementKeepsTheCurve) {
  const std::vector<long double> drawn = {3, 0, 100, 7, 7, 20};
  const oracle::Profile coarse(drawn);
  const oracle::Profile fine(oracle::refined(drawn));
  for (int i = 0; i <= 100; ++i) {
    const long double a = static_cast<long double>(i) / 20;
    EXPECT_NEAR(static_cast<double>(fine.value(2 * a)), static_cast<double>(coarse.value(a)), 1e-15);
  }
}

// --- a periodic curve

/// Eight spans in 64 frames, with keys on these frames. The stretch behind each takes this much of the path.
/// Adjusts the curve as it is with each key as its seam, where that key lies on a span.
void expect_same_at_every_seam(const std::array<std::int32_t, 3>& frames, int eased) {
  const std::vector<double> drawn = {9, 4, 6, 12, 15, 7, 5, 8};
  const std::array<double, 3> shares = {0.3, 0.56, 0.14};
  std::vector<double> first;
  for (int seam = 0; seam < 3; ++seam) {
    const std::int32_t seam_frame = frames[static_cast<std::size_t>(seam)];
    if (seam_frame % 8 != 0) continue;
    std::vector<double> speed;
    for (std::int32_t i = 0; i <= 8; ++i)
      speed.push_back(drawn[static_cast<std::size_t>(i + seam_frame / 8) % 8]);
    std::vector<double> distances = {0};
    std::vector<KeyLock> locks;
    for (int k = 0; k < 3; ++k) {
      const auto key = static_cast<std::size_t>(seam + k) % 3;
      distances.push_back(distances.back() + shares[key]);
      if (k == 0 && seam != eased) continue;
      const std::int32_t frame = (frames[key] + 64 - seam_frame) % 64;
      locks.push_back({.key = k, .frame = frame, .ease = static_cast<int>(key) == eased});
    }
    const auto storage = std::make_unique<Storage>();
    const Result<KeyTiming> result = adjust_to_locks({.control_values = speed,
                                                      .key_distances = distances,
                                                      .locks = locks,
                                                      .frames = 64,
                                                      .ends = CurveEnds::periodic},
                                                     storage->memory());
    ASSERT_TRUE(result.has_value()) << seam << " " << result.error().what;
    const std::span<const double> values = result->control_values;
    ASSERT_EQ(values.size(), (8U << result->refinements) + 1);
    EXPECT_EQ(values.front(), values.back());
    if (first.empty()) first.assign(values.begin(), values.end());
    const std::size_t count = values.size() - 1;
    const std::size_t shift = count * static_cast<std::size_t>(seam_frame) / 64;
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_NEAR(values[i], first[(i + shift) % count], 1e-11) << seam << " " << i;
    }
    EXPECT_GT(result->largest_change, 1e-3);
  }
}

TEST(PeriodicKeyTiming, IsTheSameWhicheverOfItsKeysIsTheSeam) {
  expect_same_at_every_seam({0, 24, 56}, -1);
}

TEST(PeriodicKeyTiming, IsTheSameWhereItTouchesZeroShortlyBeforeOrBehindItsSeam) {
  expect_same_at_every_seam({0, 24, 60}, 2);
  expect_same_at_every_seam({0, 4, 24}, 1);
  expect_same_at_every_seam({0, 24, 56}, 2);
}

TEST(PeriodicKeyTiming, TouchesZeroAndRestsAtItsSeam) {
  const std::vector<double> drawn(9, 10);
  for (const bool holds : {false, true}) {
    const std::vector<KeyLock> locks = {{.key = 0, .hold = holds ? 8 : 0, .ease = !holds}};
    const std::vector<double> distances = {0, 50, 100};
    const auto storage = std::make_unique<Storage>();
    const Result<KeyTiming> result = adjust_to_locks({.control_values = drawn,
                                                      .key_distances = distances,
                                                      .locks = locks,
                                                      .frames = 64,
                                                      .ends = CurveEnds::periodic},
                                                     storage->memory());
    ASSERT_TRUE(result.has_value());
    const std::span<const double> values = result->control_values;
    const std::size_t f = values.size() - 1;
    for (const std::size_t i : {f - 1, std::size_t{0}, std::size_t{1}, f}) EXPECT_EQ(values[i], 0) << i;
    const std::size_t behind = holds ? 1 + f / 8 : 1;  // the last 0
    EXPECT_EQ(values[behind], 0);
    EXPECT_GT(values[behind + 3], 0);
    // Even on either side, for nothing tells them apart.
    for (std::size_t i = 0; i < f / 4; ++i) {
      EXPECT_NEAR(values[behind + i], values[f - 1 - i], 1e-9) << i;
    }
  }
}

// --- locks

TEST(KeyTiming, ACurveThatMeetsTheKeyAlreadyIsLeftAlone) {
  // A straight line at constant speed: key 3, at 60 of 100, is met on frame 144 of 240.
  const Requests requests{.speed = {10, 10, 10, 10, 10}, .locks = {{.key = 3, .frame = 144}}};
  for (const double value : adjusted(requests)) EXPECT_NEAR(value, 10, 1e-13);
}

TEST(KeyTiming, EarlyAndLateKeysAreMet) {
  for (const std::int32_t frame : {60, 90, 110, 150}) {
    const Requests requests{.locks = {{.key = 2, .frame = frame}}};
    EXPECT_NEAR(share(adjusted(requests), frame, 240), 0.3, 1e-12) << frame;
  }
}

TEST(KeyTiming, TwoZerosAtAnEndAndThreeInsideStayARest) {
  const std::vector<double> values =
      adjusted({.speed = {0, 0, 10, 10, 0, 0, 0, 10, 10, 0, 0}, .locks = {{.key = 2, .frame = 95}}});
  ASSERT_EQ(values.size(), 11U);
  for (const std::size_t i : {0U, 1U, 4U, 5U, 6U, 9U, 10U}) EXPECT_EQ(values[i], 0) << i;
}

TEST(KeyTiming, TwoZerosInsideAreNoRestBecauseTheCurveIsAboveThem) {
  const std::vector<double> drawn{0, 0, 10, 10, 0, 0, 10, 10, 10, 0, 0};
  EXPECT_GT(oracle::Profile(drawn).value(4.5L), 0.4L);
  const std::vector<double> values = adjusted({.speed = drawn, .locks = {{.key = 2, .frame = 95}}});
  ASSERT_EQ(values.size(), 11U);
  EXPECT_GT(values[4] + values[5], 0);
}

TEST(KeyTiming, ASoleZeroIsNoRestAndMayBeRaised) {
  const std::vector<double> values =
      adjusted({.speed = {5, 5, 0, 5, 5}, .locks = {{.key = 3, .frame = 140}}});
  ASSERT_EQ(values.size(), 5U);
  EXPECT_GT(values[2], 0);
}

TEST(KeyTiming, ARefinedCurveIsTheDrawnOneOnTwiceAsManySpans) {
  // A hold of 8 frames in 240 wants spans of 2 frames: the drawn 8 are doubled until there are 120 or more.
  const Requests requests{.locks = {{.key = 2, .frame = 100, .hold = 8}}};
  const auto storage = std::make_unique<Storage>();
  const Result<KeyTiming> timing = adjust(requests, *storage);
  ASSERT_TRUE(timing.has_value());
  EXPECT_EQ(timing->refinements, 4);
  ASSERT_EQ(timing->control_values.size(), 8U * 16 + 1);
  const oracle::Profile drawn(requests.speed);
  const oracle::Profile fine(std::vector<double>(storage->drawn.begin(), storage->drawn.begin() + 129));
  for (int i = 0; i <= 160; ++i) {
    const long double a = static_cast<long double>(i) / 20;
    EXPECT_NEAR(static_cast<double>(fine.value(16 * a)), static_cast<double>(drawn.value(a)), 1e-13) << i;
  }
}

TEST(KeyTiming, APathWithoutLengthLeavesTheCurveAsDrawn) {
  const Requests requests{.locks = {{.key = 2, .frame = 100}}, .distances = {0, 0, 0, 0, 0}};
  EXPECT_EQ(adjusted(requests), requests.speed);
}

/// Keys evenly along the path, each on a frame that is a little off the even one.
struct ManyLocks {
  std::vector<double> distances;
  std::vector<KeyLock> locks;
  std::int32_t frames = 0;

  explicit ManyLocks(std::int32_t count) : frames(20 * (count + 1)) {
    for (std::int32_t key = 0; key <= count + 1; ++key) distances.push_back(key);
    for (std::int32_t key = 1; key <= count; ++key) {
      locks.push_back({.key = key, .frame = 20 * key + key * key % 5 - 2});
    }
  }
};

TEST(KeyTiming, AThousandLocksAreMetInMemoryThatGrowsAsTheyDo) {
  EXPECT_LE(lock_entry_count(1000), 24 * 1001U);
  const ManyLocks many(1000);
  const std::vector<double> speed(1101, 10);
  const auto storage = std::make_unique<KeyTimingStorage<1000, 4401>>();
  for (const CurveEnds ends : {CurveEnds::natural, CurveEnds::periodic}) {
    const auto timing = adjust_to_locks({.control_values = speed,
                                         .key_distances = many.distances,
                                         .locks = many.locks,
                                         .frames = many.frames,
                                         .ends = ends},
                                        storage->memory());
    ASSERT_TRUE(timing.has_value()) << timing.error().what << " " << timing.error().key;
    if (ends == CurveEnds::periodic) continue;  // the oracle has natural ends
    const std::vector<double> values(timing->control_values.begin(), timing->control_values.end());
    for (std::size_t i = 0; i < many.locks.size(); i += 37) {
      const KeyLock& lock = many.locks[i];
      EXPECT_NEAR(share(values, lock.frame, many.frames), lock.key / 1001.0, 1e-12) << lock.key;
    }
  }
}

TEST(KeyTiming, MoreLocksThanTheCurveHasValuesForRefineIt) {
  const ManyLocks many(120);
  const std::vector<double> speed(5, 10);
  const auto storage = std::make_unique<KeyTimingStorage<120, 1025>>();
  const auto timing = adjust_to_locks(
      {.control_values = speed, .key_distances = many.distances, .locks = many.locks, .frames = many.frames},
      storage->memory());
  ASSERT_TRUE(timing.has_value()) << timing.error().what << " " << timing.error().key;
  EXPECT_GE(timing->control_values.size(), 121U);
  const std::vector<double> values(timing->control_values.begin(), timing->control_values.end());
  for (const KeyLock& lock : many.locks) {
    EXPECT_NEAR(share(values, lock.frame, many.frames), lock.key / 121.0, 1e-12) << lock.key;
  }
}

TEST(KeyTiming, OfThreeHundredLocksThatAreHardToMeetThereIsACurveOfEnoughValues) {
  std::mt19937 random(2);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  constexpr std::int32_t count = 300;
  constexpr std::int32_t frames = 20 * (count + 1);
  std::vector<double> speed = {0, 0};
  for (int i = 0; i < count - 3; ++i) speed.push_back(between(5, 45));
  speed.insert(speed.end(), {0, 0});
  std::vector<double> keys = {0};
  for (std::int32_t i = 0; i <= count; ++i) keys.push_back(keys.back() + between(0.05, 1.3));
  std::vector<KeyLock> locks;
  for (std::int32_t key = 1; key <= count; ++key) {
    const double evenly = keys[static_cast<std::size_t>(key)] / keys.back() * frames;
    const std::int32_t after = locks.empty() ? 0 : locks.back().frame;
    locks.push_back(
        {.key = key, .frame = std::max(after + 1, static_cast<std::int32_t>(evenly + between(-2, 2)))});
  }
  const SolvedTrack track({.path = {.spline = Spline::linear, .axis_count = 1, .keys = keys},
                           .control_values = speed,
                           .frames = frames,
                           .fps = {24, 1},
                           .arc_length = {},
                           .locks = locks},
                          Solver::closed_form);
  EXPECT_GT(track.control_values().size(), 4097U);
  for (const KeyLock& lock : locks) {
    const PathPoint point = track.track().locate({lock.frame, 0});
    EXPECT_NEAR(point.segment + point.t, lock.key, 1e-9) << lock.key;
  }
}

// --- refusals

TEST(KeyTiming, RequestsThatContradictEachOtherNameKeyAndFrame) {
  const auto bad = ErrorCode::out_of_range;
  expect_refused({.locks = {{.key = 1, .frame = 80}, {.key = 2, .frame = 80}}}, bad, 2, 80);
  expect_refused({.locks = {{.key = 1, .frame = 80}, {.key = 2, .frame = 60}}}, bad, 2, 60);
  expect_refused({.locks = {{.key = 1, .frame = 80, .hold = 20}, {.key = 2, .frame = 90}}}, bad, 2, 90);
  expect_refused({.locks = {{.key = 0, .frame = 3}}}, bad, 0, 3);
  expect_refused({.locks = {{.key = 4, .frame = 239}}}, bad, 4, 239);
  expect_refused({.locks = {{.key = 2, .frame = 0}}}, bad, 2, 0);
  expect_refused({.locks = {{.key = 2, .frame = 240}}}, bad, 2, 240);
  expect_refused({.locks = {{.key = 2, .frame = 230, .hold = 11}}}, bad, 2, 230);
  expect_refused({.locks = {{.key = 2, .frame = 230, .hold = 10}}}, bad, 2, 230);
  expect_refused({.locks = {{.key = 1, .hold = 140}, {.key = 3, .hold = 100}}}, bad, 1, -1);
}

TEST(KeyTiming, AKeyThatNoCurveMeetsIsRefusedWithItsKey) {
  // From 0 to 100: the first 2 frames of 240 cannot cover 60 % of the path.
  expect_refused({.speed = {10, 10, 10, 10}, .locks = {{.key = 3, .frame = 2}}}, ErrorCode::no_solution, 3,
                 2);
}

TEST(KeyTiming, AHoldTooShortForTheMemoryNamesItsKey) {
  expect_refused({.locks = {{.key = 2, .frame = 5000, .hold = 1}}, .frames = 10000}, ErrorCode::no_solution,
                 2, 5000);
}

TEST(KeyTiming, TooLittleMemorySaysHowMuchIsNeeded) {
  const auto storage = std::make_unique<KeyTimingStorage<1, 9>>();
  const Requests requests{.locks = {{.key = 1, .frame = 60}, {.key = 2, .frame = 90}}};
  const Result<KeyTiming> result = adjust_to_locks({.control_values = requests.speed,
                                                    .key_distances = requests.distances,
                                                    .locks = requests.locks,
                                                    .frames = requests.frames},
                                                   storage->memory());
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::capacity);
  EXPECT_GE(result.error().needed, 3);
}

// --- holds

TEST(Hold, TheRigStandsStillToTheBitAndMovesBeforeAndAfter) {
  for (const std::int32_t hold : {2, 8, 24, 60}) {
    const SolvedTrack track = solved({.locks = {{.key = 2, .frame = 100, .hold = hold}}});
    const PathPoint at_key = track.track().locate({100, 0});
    EXPECT_NEAR(at_key.segment + at_key.t, 2, 1e-12);
    for (std::int32_t quarter = 0; quarter <= 4 * hold; ++quarter) {
      const FrameTime time{100 + quarter / 4, (quarter % 4) / 4.0};
      EXPECT_EQ(track.track().locate(time), at_key) << hold << " frames, " << quarter << " quarters";
      EXPECT_EQ(track.track().along(time).speed, 0);
    }
    EXPECT_LT(track.table().point(80).segment + track.table().point(80).t, 1.9999);
    const PathPoint later = track.table().point(120 + hold);
    EXPECT_GT(later.segment + later.t, 2.0001);
  }
}

TEST(Hold, TheRestIsHardlyLongerThanAsked) {
  for (const std::int32_t hold : {2, 8, 24, 60}) {
    const SolvedTrack track = solved({.locks = {{.key = 2, .frame = 100, .hold = hold}}});
    const oracle::Profile played(track.control_values());
    const auto a = [&](double frame) {
      return static_cast<long double>(frame) * static_cast<long double>(played.spans()) / 240;
    };
    double begin = 100;
    while (played.value(a(begin - 0.125)) == 0) begin -= 0.125;
    double end = 100 + hold;
    while (played.value(a(end + 0.125)) == 0) end += 0.125;
    EXPECT_LE(end - begin, 1.5 * hold + 2) << hold;
  }
}

TEST(Hold, TheAccelerationNeverSteps) {
  const SolvedTrack track = solved({.locks = {{.key = 2, .frame = 100, .hold = 24}}});
  double max_jerk = 0;
  double max_step = 0;
  double before = 0;
  for (std::int32_t step = 0; step < 240 * 64; ++step) {
    const AlongPath here = track.track().along({step / 64, (step % 64) / 64.0});
    max_jerk = std::max(max_jerk, std::fabs(here.jerk));
    max_step = std::max(max_step, std::fabs(here.acceleration - before));
    before = here.acceleration;
  }
  EXPECT_LE(max_step, 1.01 * max_jerk / (24 * 64));
}

TEST(Hold, WithoutAFrameTheKeyIsMetWhereTheDrawnCurveReachesItInTheFramesThatAreNoHolds) {
  const Requests requests{.locks = {{.key = 1, .hold = 20}, {.key = 3, .hold = 30}}};
  const auto storage = std::make_unique<Storage>();
  const Result<KeyTiming> timing = adjust(requests, *storage);
  ASSERT_TRUE(timing.has_value());
  ASSERT_EQ(timing->locks.size(), 4U);
  for (const auto& [index, held, part] : {std::tuple{1U, 0, 0.1}, {2U, 20, 0.6}}) {
    const std::int32_t moving = timing->locks[index].frame - held;
    EXPECT_GE(share(requests.speed, moving, 190), part);
    EXPECT_LT(share(requests.speed, moving - 1, 190), part);
  }
}

TEST(Hold, ManyWithoutAFrameAreEachMetWhereTheDrawnCurveReachesThem) {
  Requests requests{
      .speed = {0, 0, 10, 30, 10, 0, 0, 0, 20, 10, 0, 0}, .locks = {}, .frames = 2400, .distances = {0}};
  constexpr std::int32_t held = 20;
  for (std::int32_t key = 1; key <= 21; ++key) {
    requests.distances.push_back(key);
    if (key < 21) requests.locks.push_back({.key = key, .hold = held});
  }
  const auto storage = std::make_unique<KeyTimingStorage<20, 4097>>();
  const auto timing = adjust_to_locks({.control_values = requests.speed,
                                       .key_distances = requests.distances,
                                       .locks = requests.locks,
                                       .frames = requests.frames},
                                      storage->memory());
  ASSERT_TRUE(timing.has_value()) << timing.error().what;
  for (std::int32_t i = 1; i <= 20; ++i) {
    const std::int32_t moving = timing->locks[static_cast<std::size_t>(i)].frame - (i - 1) * held;
    EXPECT_GE(share(requests.speed, moving, 2000), i / 21.0 - 1e-12) << i;
    EXPECT_LT(share(requests.speed, moving - 1, 2000), i / 21.0) << i;
  }
}

TEST(Hold, TheFirstAndTheLastKeyMayBeHeldToo) {
  const SolvedTrack track = solved({.locks = {{.key = 0, .hold = 24}, {.key = 4, .hold = 36}}});
  for (std::int32_t frame = 0; frame <= 24; ++frame)
    EXPECT_EQ(track.table().point(frame), (PathPoint{0, 0})) << frame;
  for (std::int32_t frame = 204; frame < 240; ++frame) {
    const PathPoint point = track.table().point(frame);
    EXPECT_NEAR(point.segment + point.t, 4, 1e-12) << frame;
  }
}

// --- end to end

TEST(KeyTiming, AHoldWithoutAFrameArrivesBetweenTheLockedKeysBesideIt) {
  // Drawn evenly: keys at 0, 25, 50, 75, 100 of the path. Key 1 is locked late and held, key 3 is locked
  // later still.
  const auto storage = std::make_unique<Storage>();
  const std::vector<double> distances{0, 25, 50, 75, 100};
  const std::vector<double> speed{10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10};
  const std::vector<KeyLock> locks{
      {.key = 1, .frame = 110, .hold = 10}, {.key = 2, .hold = 20}, {.key = 3, .frame = 200}};
  const auto timing =
      adjust_to_locks({.control_values = speed, .key_distances = distances, .locks = locks, .frames = 240},
                      storage->memory());
  ASSERT_TRUE(timing.has_value()) << timing.error().what;
  EXPECT_EQ(timing->locks[2].key, 2);
  EXPECT_EQ(timing->locks[2].frame, 150)
      << "halfway through the 60 frames between 120 and 200 that are no hold";
}

TEST(KeyTiming, BetweenTwoLocksOnEqualKeysNothingMoves) {
  const auto storage = std::make_unique<Storage>();
  const std::vector<double> distances{0, 40, 40, 100};
  const std::vector<double> speed{10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10, 10};
  const std::vector<KeyLock> locks{{.key = 1, .frame = 80}, {.key = 2, .frame = 160}};
  const auto timing =
      adjust_to_locks({.control_values = speed, .key_distances = distances, .locks = locks, .frames = 240},
                      storage->memory());
  ASSERT_TRUE(timing.has_value()) << timing.error().what;
  EXPECT_EQ(timing->refinements, 0);
  for (std::size_t i = 3; i <= 9; ++i) EXPECT_EQ(timing->control_values[i], 0) << i;
}

TEST(KeyTiming, ALockOnAKeyThatIsNotThereIsRefused) {
  const auto storage = std::make_unique<Storage>();
  const std::vector<double> distances{0, 40, 100};
  const std::vector<double> speed{10, 10, 10};
  for (const std::int32_t key : {-1, 3, 1'000'000}) {
    for (const std::int32_t frame : {-1, 100}) {
      const std::vector<KeyLock> locks{{.key = key, .frame = frame, .hold = 10}};
      const auto timing = adjust_to_locks(
          {.control_values = speed, .key_distances = distances, .locks = locks, .frames = 240},
          storage->memory());
      ASSERT_FALSE(timing.has_value());
      EXPECT_EQ(timing.error().code, ErrorCode::out_of_range);
      EXPECT_EQ(timing.error().key, key);
    }
  }
}

TEST(KeyTiming, WhatTheFileAsksInVainIsOneLineAtTheKey) {
  struct Case {
    const char* second;
    const char* third;
    std::string place;
    const char* words;
  };
  const std::vector<Case> cases = {
      {", frame = 40", ", frame = 40", "move.toml:9:3: error: key 2: frame 40: ", "different frames"},
      {", frame = 40", ", frame = 30", "move.toml:9:3: error: key 2: frame 30: ", "in their own order"},
      {", frame = 1", "", "move.toml:8:3: error: key 1: frame 1: ",
       "from 0 to 100 meets this key on its frame; between key 0 on frame 0 and key 1 on frame 1 it would "
       "have "
       "to be 200 on average; move the frame, or draw the curve as a whole 2.02 times lower"},
      {"", ", frame = 99", "move.toml:9:3: error: key 2: frame 99: ",
       "between key 2 on frame 99 and key 3 on frame 100 it would have to be 160 on average"},
      {", frame = 50, hold = 49", "", "move.toml:8:3: error: key 1: frame 50: ",
       "between key 1 on frame 99 and key 3 on frame 100 it would have to be 200 on average"},
      {", frame = 90, hold = 20", "", "move.toml:8:3: error: key 1: frame 90: ", "last frame"},
      {", hold = 50", ", hold = 50", "move.toml:8:3: error: key 1: ", "all frames"},
  };
  for (const Case& each : cases) {
    const TemporaryFile file("move.toml", std::string("name = \"m\"\nfps = 24\nframes = 100\n[[track]]\naxes "
                                                      "= [\"x\"]\nkeys = [\n  { at = [0.0] },\n") +
                                              "  { at = [50.0]" + each.second + " },\n  { at = [60.0]" +
                                              each.third +
                                              " },\n  { at = [100.0] },\n]\nspeed = [0, 0, 10, 10, 0, 0]\n");
    const ProgramRun run = run_program({"plan", file.path().string()});
    EXPECT_EQ(run.status, 1);
    EXPECT_THAT(run.err, testing::StartsWith((file.path().parent_path() / each.place).string()));
    EXPECT_THAT(run.err, testing::HasSubstr(each.words));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
}

}  // namespace key_timing_test
}  // namespace inbetween
