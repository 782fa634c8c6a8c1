#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "inbetween/timing/track.hpp"
#include "tests/support/oracle_path.hpp"
#include "tests/support/oracle_profile.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

/// The ways of timing other than one drawn curve: portions between breaks, and a frame for every key.

namespace inbetween {
namespace track_timing_test {

long double widened(double value) {
  return static_cast<long double>(value);
}

struct Drawing {
  Spline spline = Spline::smooth;
  bool closed = false;
  std::int32_t axis_count = 2;
  std::vector<double> keys;
  std::vector<double> speed = {};
  std::vector<KeyLock> locks = {};
  std::vector<std::int32_t> key_frames = {};
  Kinetic kinetic = Kinetic::linear;
  std::int32_t frames = 0;
};

SolvedTrack solved(const Drawing& drawing) {
  return {{.path = {.spline = drawing.spline,
                    .closed = drawing.closed,
                    .axis_count = drawing.axis_count,
                    .keys = drawing.keys},
           .control_values = drawing.speed,
           .frames = drawing.frames,
           .fps = {25, 1},
           .arc_length = {},
           .locks = drawing.locks,
           .key_frames = drawing.key_frames,
           .kinetic = drawing.kinetic},
          Solver::closed_form};
}

oracle::Path oracle_path(const Drawing& drawing) {
  oracle::Keys keys;
  keys.kind = drawing.spline == Spline::linear ? oracle::Kind::linear : oracle::Kind::smooth;
  keys.closed = drawing.closed;
  const auto axes = static_cast<std::size_t>(drawing.axis_count);
  for (std::size_t i = 0; i < drawing.keys.size(); i += axes) {
    auto& key = keys.at.emplace_back();
    for (std::size_t d = 0; d < axes; ++d) key.push_back(widened(drawing.keys[i + d]));
  }
  return oracle::Path(keys);
}

Error refusal(const Drawing& drawing) {
  try {
    static_cast<void>(solved(drawing));
  } catch (const SolverError& refused) {
    return refused.error();
  }
  ADD_FAILURE() << "the drawing is not refused";
  return {};
}

std::vector<AxisMotion> motion(const SolvedTrack& solution, const FrameTime& time) {
  std::vector<AxisMotion> axes(static_cast<std::size_t>(solution.track().path().axis_count()));
  EXPECT_EQ(solution.track().motion(time, axes), 3);
  return axes;
}

double parameter(const SolvedTrack& solution, const FrameTime& time) {
  const PathPoint point = solution.track().locate(time);
  return point.segment + point.t;
}

// --- breaks

Drawing broken_twice() {
  return {.keys = {0, 0, 42, 60, 90, 80, 150, 0, 160, -40},
          .speed = {0, 0, 10, 10, 4, 10, 10, 0, 0},
          .locks = {{.key = 1, .frame = 70, .breaks = true}, {.key = 3, .frame = 150, .breaks = true}},
          .frames = 240};
}

TEST(BreakKeys, EachPortionPlaysTheDrawnCurveWithAConstantOfItsOwn) {
  const Drawing drawing = broken_twice();
  const SolvedTrack track = solved(drawing);
  const oracle::Path path = oracle_path(drawing);
  const oracle::Profile drawn(drawing.speed);
  EXPECT_EQ(track.control_values(), drawing.speed) << "breaks leave the drawn curve alone";
  const std::vector<std::int32_t> bounds = {0, 70, 150, 240};
  const std::vector<int> keys = {0, 1, 3, 4};
  ASSERT_EQ(track.track().portions().size(), 3U);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto a = [](std::int32_t frame) { return static_cast<long double>(frame) * 8 / 240; };
    const oracle::Place end = keys[k + 1] == 4 ? oracle::Place{3, 1} : oracle::Place{keys[k + 1], 0};
    const long double length = path.travelled({keys[k], 0}, end);
    const long double constant = length / drawn.integral(a(bounds[k]), a(bounds[k + 1]));
    EXPECT_EQ(track.track().portions()[k].begin_frame, bounds[k]);
    EXPECT_NEAR(track.track().portions()[k].constant, static_cast<double>(constant), 1e-12);
    for (std::int32_t frame = bounds[k]; frame < bounds[k + 1]; ++frame) {
      const PathPoint point = track.table().point(frame);
      ASSERT_GE(point.segment, keys[k]) << frame;
      const long double travelled = path.travelled({keys[k], 0}, {point.segment, widened(point.t)});
      const long double wanted = constant * drawn.integral(a(bounds[k]), a(frame));
      ASSERT_NEAR(static_cast<double>(travelled - wanted), 0, 1e-6 * static_cast<double>(length)) << frame;
      const TwoSum distance = track.track().distance({frame, 0});
      const long double before = path.travelled({0, 0}, {keys[k], 0});
      ASSERT_NEAR(static_cast<double>(widened(distance.high) + widened(distance.low) - before - wanted), 0,
                  1e-12)
          << frame;
    }
  }
}

TEST(BreakKeys, TheKeyIsMetOnItsFrameAndTheSpeedJumpsThere) {
  const Drawing drawing = broken_twice();
  const SolvedTrack track = solved(drawing);
  for (const KeyLock& lock : drawing.locks) {
    EXPECT_NEAR(parameter(track, {lock.frame, 0}), lock.key, 1e-12);
    EXPECT_NEAR(parameter(track, {lock.frame - 1, 1 - 1e-9}), lock.key, 1e-9);
    const double arriving = track.track().along({lock.frame - 1, 1 - 1e-9}).speed;
    const double leaving = track.track().along({lock.frame, 0}).speed;
    EXPECT_GT(std::fabs(leaving - arriving), 0.05 * arriving);
  }
  EXPECT_EQ(track.track().locate({240, 0}), (PathPoint{4, 0}));
}

TEST(BreakKeys, VelocitiesAreThoseOfTheirPortion) {
  const SolvedTrack track = solved(broken_twice());
  const double h = 1e-4;
  for (const std::int32_t frame : {20, 69, 70, 100, 149, 150, 200}) {
    const auto at = motion(track, {frame, 0.5});
    const auto before = motion(track, {frame, 0.5 - h});
    const auto after = motion(track, {frame, 0.5 + h});
    for (std::size_t d = 0; d < 2; ++d) {
      const double quotient = (after[d].position - before[d].position) / (2 * h) * 25;
      EXPECT_NEAR(at[d].velocity, quotient, 1e-4) << frame;
      EXPECT_NEAR(at[d].acceleration, (after[d].velocity - before[d].velocity) / (2 * h) * 25, 1e-3) << frame;
    }
  }
}

TEST(BreakKeys, APortionUnderACurveOfZerosIsRefusedWithItsKey) {
  Drawing drawing = broken_twice();
  drawing.speed = {0, 0, 0, 0, 0, 10, 10, 10, 10};
  drawing.locks = {{.key = 2, .frame = 60, .breaks = true}};
  const Error error = refusal(drawing);
  EXPECT_EQ(error.code, ErrorCode::no_distance);
  EXPECT_EQ(error.key, 2);
  EXPECT_EQ(error.frame, 60);
}

TEST(BreakKeys, ALockBetweenTwoBreaksChangesTheCurveInItsOwnPortionOnly) {
  Drawing drawing = broken_twice();
  drawing.speed = {5, 5, 10, 10, 4, 10, 10, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5};
  drawing.frames = 160;
  drawing.locks = {{.key = 1, .frame = 40, .breaks = true},
                   {.key = 2, .frame = 75},
                   {.key = 3, .frame = 120, .breaks = true}};
  const SolvedTrack track = solved(drawing);
  for (const KeyLock& lock : drawing.locks) {
    EXPECT_NEAR(parameter(track, {lock.frame, 0}), lock.key, 1e-9);
  }
  const oracle::Profile played(track.control_values());
  const oracle::Profile drawn(drawing.speed);
  for (const auto& [from, to] : {std::pair{0.0L, 4.0L}, {4.0L, 12.0L}, {12.0L, 16.0L}}) {
    EXPECT_NEAR(static_cast<double>(played.integral(from, to) - drawn.integral(from, to)), 0, 1e-10);
  }
}

// --- a frame for every key

Drawing keys_on_frames(Kinetic kinetic) {
  return {.keys = {10, 0, 42, 60, 90, 80, 150, 0, 160, -40},
          .key_frames = {0, 20, 70, 75, 100},
          .kinetic = kinetic,
          .frames = 100};
}

TEST(KeyFrames, LinearOnLinearPathsIsPlainKeyFrameInterpolation) {
  Drawing drawing = keys_on_frames(Kinetic::linear);
  drawing.spline = Spline::linear;
  const SolvedTrack track = solved(drawing);
  for (std::size_t n = 0; n + 1 < drawing.key_frames.size(); ++n) {
    const std::int32_t begin = drawing.key_frames[n];
    const std::int32_t end = drawing.key_frames[n + 1];
    for (std::int32_t frame = begin; frame < end; ++frame) {
      for (const double fraction : {0.0, 0.3}) {
        const auto at = motion(track, {frame, fraction});
        for (std::size_t d = 0; d < 2; ++d) {
          const double from = drawing.keys[2 * n + d];
          const double slope = (drawing.keys[2 * n + 2 + d] - from) / (end - begin);
          EXPECT_NEAR(at[d].position, from + (frame + fraction - begin) * slope, 1e-12);
          EXPECT_NEAR(at[d].velocity, 25 * slope, 1e-11);
          EXPECT_NEAR(at[d].acceleration, 0, 1e-9);
        }
      }
    }
  }
}

TEST(KeyFrames, EveryKeyIsPassedOnItsFrameToTheLastBit) {
  for (const Kinetic kinetic : {Kinetic::linear, Kinetic::monotone}) {
    const Drawing drawing = keys_on_frames(kinetic);
    const SolvedTrack track = solved(drawing);
    EXPECT_FALSE(track.track().has_profile());
    EXPECT_TRUE(track.control_values().empty());
    for (std::size_t n = 0; n < drawing.key_frames.size(); ++n) {
      const PathPoint key{static_cast<int>(n), 0};
      EXPECT_EQ(track.track().locate({drawing.key_frames[n], 0}), key);
      EXPECT_EQ(track.table().point(drawing.key_frames[n]), key);
    }
  }
}

TEST(KeyFrames, SmoothNeverGoesBackAndHasNoJumpOfTheRateAtAKey) {
  const Drawing drawing = keys_on_frames(Kinetic::monotone);
  const SolvedTrack track = solved(drawing);
  double before = 0;
  for (std::int32_t step = 0; step <= 3200; ++step) {
    const double here = parameter(track, {step / 32, (step % 32) / 32.0});
    EXPECT_GE(here, before) << step;
    before = here;
  }
  const double h = 0x1p-16;
  for (std::size_t n = 1; n + 1 < drawing.key_frames.size(); ++n) {
    const std::int32_t frame = drawing.key_frames[n];
    const double key = static_cast<double>(n);
    const double arriving = (key - parameter(track, {frame - 1, 1 - h})) / h;
    const double leaving = (parameter(track, {frame, h}) - key) / h;
    EXPECT_NEAR(arriving, leaving, 1e-4) << "key " << n;
    // Fritsch and Butland: the harmonic mean of the secants, weighted.
    const double one = frame - drawing.key_frames[n - 1];
    const double two = drawing.key_frames[n + 1] - frame;
    const double alpha = (1 + two / (one + two)) / 3;
    const double wanted = (1 / one) * (1 / two) / (alpha * (1 / two) + (1 - alpha) * (1 / one));
    EXPECT_NEAR(leaving, wanted, 1e-4) << "key " << n;
  }
}

TEST(KeyFrames, SmoothKeepsEvenlyTimedKeysAtAnEvenRate) {
  Drawing drawing = keys_on_frames(Kinetic::monotone);
  drawing.key_frames = {0, 25, 50, 75, 100};
  const SolvedTrack track = solved(drawing);
  for (std::int32_t frame = 0; frame <= 100; ++frame)
    EXPECT_NEAR(parameter(track, {frame, 0}), frame / 25.0, 1e-14);
}

TEST(KeyFrames, VelocityAndAccelerationAreTheDerivativesOfThePosition) {
  for (const Kinetic kinetic : {Kinetic::linear, Kinetic::monotone}) {
    const SolvedTrack track = solved(keys_on_frames(kinetic));
    const double h = 1e-4;
    for (const std::int32_t frame : {0, 13, 20, 50, 69, 72, 90, 99}) {
      const auto at = motion(track, {frame, 0.5});
      const auto before = motion(track, {frame, 0.5 - h});
      const auto after = motion(track, {frame, 0.5 + h});
      double speed = 0;
      for (std::size_t d = 0; d < 2; ++d) {
        const auto quotient = [&](double high, double low) { return (high - low) / (2 * h) * 25; };
        EXPECT_NEAR(at[d].velocity, quotient(after[d].position, before[d].position), 1e-4) << frame;
        EXPECT_NEAR(at[d].acceleration, quotient(after[d].velocity, before[d].velocity), 1e-2) << frame;
        EXPECT_NEAR(at[d].jerk, quotient(after[d].acceleration, before[d].acceleration), 1) << frame;
        speed = std::hypot(speed, at[d].velocity);
      }
      const AlongPath along = track.track().along({frame, 0.5});
      EXPECT_NEAR(along.speed, speed, 1e-9) << frame;
      const double rise =
          track.track().along({frame, 0.5 + h}).speed - track.track().along({frame, 0.5 - h}).speed;
      EXPECT_NEAR(along.acceleration, rise / (2 * h) * 25, 1e-2) << frame;
    }
  }
}

TEST(KeyFrames, AClosedPathReturnsToItsFirstKeyOnTheLastFrame) {
  for (const Kinetic kinetic : {Kinetic::linear, Kinetic::monotone}) {
    const SolvedTrack track = solved({.closed = true,
                                      .keys = {10, 0, 42, 60, 90, 80},
                                      .key_frames = {0, 20, 70, 100},
                                      .kinetic = kinetic,
                                      .frames = 100});
    EXPECT_EQ(track.track().locate({70, 0}), (PathPoint{2, 0}));
    const auto end = motion(track, {100, 0});
    EXPECT_NEAR(end[0].position, 10, 1e-13);
    EXPECT_NEAR(end[1].position, 0, 1e-13);
  }
}

TEST(KeyFrames, AKeyWrittenTwiceIsHeldBetweenItsTwoFrames) {
  Drawing drawing = keys_on_frames(Kinetic::monotone);
  drawing.spline = Spline::linear;
  drawing.keys = {10, 0, 42, 60, 42, 60, 150, 0, 160, -40};
  const SolvedTrack track = solved(drawing);
  for (std::int32_t frame = 20; frame <= 70; ++frame) {
    const auto at = motion(track, {frame, 0});
    EXPECT_EQ(at[0].position, 42);
    EXPECT_EQ(at[1].position, 60);
  }
}

TEST(KeyFrames, WhatIsNotAFrameForEveryKeyInOrderIsRefusedWithTheKey) {
  struct Case {
    std::vector<std::int32_t> frames;
    ErrorCode code;
    std::int32_t key, frame;
  };
  const std::vector<Case> cases = {{{5, 20, 70, 75, 100}, ErrorCode::out_of_range, 0, 5},
                                   {{0, 20, 70, 75, 99}, ErrorCode::out_of_range, 4, 99},
                                   {{0, 20, 20, 75, 100}, ErrorCode::out_of_range, 2, 20},
                                   {{0, 70, 20, 75, 100}, ErrorCode::out_of_range, 2, 20},
                                   {{0, 20, 70, 100, 100}, ErrorCode::out_of_range, 4, 100},
                                   {{0, 20, 70, 100}, ErrorCode::wrong_count, -1, -1}};
  for (const Case& each : cases) {
    Drawing drawing = keys_on_frames(Kinetic::monotone);
    drawing.key_frames = each.frames;
    const Error error = refusal(drawing);
    EXPECT_EQ(error.code, each.code) << error.what;
    EXPECT_EQ(error.key, each.key) << error.what;
    EXPECT_EQ(error.frame, each.frame) << error.what;
  }
}

// --- end to end

ProgramRun plan(const std::string& text) {
  const TemporaryFile file("move.toml", text);
  ProgramRun run = run_program({"plan", file.path().string()});
  const std::string folder = file.path().parent_path().string() + "/";
  for (std::size_t at; (at = run.err.find(folder)) != std::string::npos;) run.err.erase(at, folder.size());
  return run;
}

TEST(KeyFrames, WhatTheFileGetsWrongIsOneLineAtTheKey) {
  const std::string head =
      "name = \"timed\"\nfps = 25\nframes = 100\n[[track]]\naxes = [\"x\"]\ntiming = \"frames\"\nkeys = [\n";
  struct Case {
    const char* keys;
    const char* place;
    const char* words;
  };
  const std::vector<Case> cases = {
      {"  { at = [0.0], frame = 3 },\n  { at = [1.0], frame = 100 },\n]\n",
       "move.toml:8:3: error: ", "frame 0"},
      {"  { at = [0.0], frame = 0 },\n  { at = [1.0], frame = 99 },\n]\n",
       "move.toml:9:3: error: ", "last frame"},
      {"  { at = [0.0], frame = 0 },\n  { at = [3.0] },\n  { at = [1.0], frame = 100 },\n]\n",
       "move.toml:9:3: error: ", "no frame"},
      {"  { at = [0.0], frame = 0 },\n  { at = [3.0], frame = 0 },\n  { at = [1.0], frame = 100 },\n]\n",
       "move.toml:9:3: error: ", "later frame"},
      {"  { at = [0.0], frame = 0 },\n  { at = [3.0], frame = 10, hold = 5 },\n  { at = [1.0], frame = 100 "
       "},\n]\n",
       "move.toml:9:3: error: ", "hold"},
  };
  for (const Case& each : cases) {
    const ProgramRun run = plan(head + each.keys);
    EXPECT_EQ(run.status, 1);
    EXPECT_THAT(run.err, testing::StartsWith(each.place));
    EXPECT_THAT(run.err, testing::HasSubstr(each.words));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
}

}  // namespace track_timing_test
}  // namespace inbetween
