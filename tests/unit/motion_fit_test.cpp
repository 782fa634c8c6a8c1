// Recorded motions of other kinds than a hand in a plane, and what is no motion.
#include "host_tools/fit/motion_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "tests/support/oracle_path.hpp"
#include "tests/support/oracle_profile.hpp"
#include "tests/support/oracle_table.hpp"

namespace inbetween {
namespace motion_fit_test {

/// Minimum jerk from 0 to 1 (Flash and Hogan 1985).
double eased(double share) {
  return share * share * share * (10 - 15 * share + 6 * share * share);
}

double position_at(const MotionFit& fit, int frame) {
  oracle::Keys keys;
  for (const std::vector<double>& key : fit.keys) keys.at.push_back({key.begin(), key.end()});
  const oracle::Path path(keys);
  const oracle::Row row = oracle::row_at(path, oracle::Profile(fit.speed), fit.frames, frame);
  return static_cast<double>(path.position(row.place.segment, row.place.t, 0));
}

std::string refusal(const SampledMotion& sampled) {
  try {
    (void)fit_motion(sampled);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

SampledMotion there_and_back() {
  SampledMotion sampled{
      .times = {}, .positions = {}, .tolerances = {0.5}, .weights = {1}, .frames_per_second = 25};
  for (int frame = 0; frame <= 100; ++frame) {
    sampled.times.push_back(frame / 25.0);
    sampled.positions.push_back(frame <= 50 ? 90 * eased(frame / 50.0) : 90 * eased((100 - frame) / 50.0));
  }
  return sampled;
}

TEST(MotionFit, ABakedAxisThatTurnsBackKeepsItsTurningPointAndItsTime) {
  const SampledMotion sampled = there_and_back();
  const MotionFit fit = fit_motion(sampled);
  EXPECT_EQ(fit.frames, 100);
  EXPECT_LE(fit.deviation, 1);
  for (int frame = 0; frame <= 100; frame += 5) {
    EXPECT_NEAR(position_at(fit, frame), sampled.positions[static_cast<std::size_t>(frame)], 0.5)
        << "frame " << frame;
  }
}

TEST(MotionFit, AnAxisThatDoesNotCountAsksForNoKeys) {
  SampledMotion sampled{.times = {},
                        .positions = {},
                        .tolerances = {1, 1, std::numeric_limits<double>::infinity()},
                        .weights = {1, 1, 1},
                        .frames_per_second = 24};
  for (int i = 0; i <= 200; ++i) {
    const double share = eased(i / 200.0);
    sampled.times.push_back(i / 100.0);
    sampled.positions.insert(sampled.positions.end(), {400 * share, 100 * share, 30 * std::sin(60 * share)});
  }
  EXPECT_LE(fit_motion(sampled).keys.size(), 3U);
  sampled.tolerances[2] = 1;
  EXPECT_GT(fit_motion(sampled).keys.size(), 20U);
}

TEST(MotionFit, AHandThatStartsAndStopsAtOnceStillRestsAtItsEnds) {
  SampledMotion sampled{
      .times = {}, .positions = {}, .tolerances = {2, 2}, .weights = {1, 1}, .frames_per_second = 24};
  for (int i = 0; i <= 120; ++i) {
    const double share = i / 120.0;
    const double rise = share * share * (3 - 2 * share);  // its acceleration steps at both ends
    sampled.times.push_back(i / 60.0);
    sampled.positions.insert(sampled.positions.end(), {600 * rise, 200 * rise * rise});
  }
  const MotionFit fit = fit_motion(sampled);
  ASSERT_GE(fit.speed.size(), 5U);
  EXPECT_EQ(fit.speed[0], 0);
  EXPECT_EQ(fit.speed[1], 0);
  EXPECT_EQ(fit.speed[fit.speed.size() - 1], 0);
  EXPECT_EQ(fit.speed[fit.speed.size() - 2], 0);
  EXPECT_LT(fit.lag, 0.01);
}

TEST(MotionFit, WhatIsNoMotionIsRefusedInOneLine) {
  SampledMotion sampled = there_and_back();
  sampled.positions.assign(sampled.positions.size(), 7);
  EXPECT_EQ(refusal(sampled), "the motion goes nowhere; draw farther");
  sampled = there_and_back();
  sampled.times[10] = sampled.times[9];
  EXPECT_EQ(refusal(sampled), "the times of a motion rise from 0");
  sampled = there_and_back();
  sampled.positions[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(sampled), "a motion has finite positions");
  sampled = there_and_back();
  sampled.tolerances[0] = 0;
  EXPECT_EQ(refusal(sampled), "a tolerance is above 0, and a weight not below");
  sampled = there_and_back();
  sampled.times.resize(7);
  sampled.positions.resize(7);
  EXPECT_EQ(refusal(sampled), "a motion needs 8 samples at least; draw longer");
}

}  // namespace motion_fit_test
}  // namespace inbetween
