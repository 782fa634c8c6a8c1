#include "inbetween/path/path.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

namespace inbetween {
namespace path_test {

using testing::HasSubstr;

/// A path with the memory it stands in. Keys are in rows, one number per axis.
class DrawnPath {
 public:
  explicit DrawnPath(const PathSpec& spec) : result_(Path::make(spec, storage_.memory())) {}
  DrawnPath(const DrawnPath&) = delete;
  DrawnPath& operator=(const DrawnPath&) = delete;

  const Path* operator->() const { return &*result_; }
  const Result<Path>& result() const { return result_; }
  const Cubic& cubic(std::int32_t segment, std::size_t axis = 0) const {
    return result_->segment(segment)[axis];
  }

 private:
  PathStorage<16, 4> storage_;
  Result<Path> result_;
};

constexpr Spline every_kind[] = {Spline::smooth, Spline::catmull_rom, Spline::tcb, Spline::linear};

void expect_cubic(const Cubic& cubic, double c0, double c1, double c2, double c3) {
  const double rounding = 8 * std::numeric_limits<double>::epsilon();
  EXPECT_NEAR(cubic.c0, c0, rounding);
  EXPECT_NEAR(cubic.c1, c1, rounding);
  EXPECT_NEAR(cubic.c2, c2, rounding);
  EXPECT_NEAR(cubic.c3, c3, rounding);
}

void expect_refused(const Result<Path>& result, ErrorCode code, std::int32_t key, std::int32_t axis,
                    const char* word) {
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, code);
  EXPECT_EQ(result.error().key, key);
  EXPECT_EQ(result.error().axis, axis);
  EXPECT_THAT(result.error().what, HasSubstr(word));
  EXPECT_STRNE(result.error().remedy, "");
}

// --- keys

/// Of three turns in one path each is the path of one turn, an axis that goes round a lap further on.
TEST(Path, AClosedPathGoesOnByItsLap) {
  const std::vector<double> keys = {0, 0, 100, 7, 250, -3};
  const std::vector<double> lap = {360, 0};
  std::vector<double> three;
  for (const double turn : {0.0, 360.0, 720.0}) {
    for (std::size_t k = 0; k < 3; ++k) three.insert(three.end(), {keys[2 * k] + turn, keys[2 * k + 1]});
  }
  const std::vector<double> three_laps = {1080, 0};
  for (const Spline spline : every_kind) {
    const DrawnPath path({.spline = spline, .closed = true, .axis_count = 2, .keys = keys, .lap = lap});
    const DrawnPath turns(
        {.spline = spline, .closed = true, .axis_count = 2, .keys = three, .lap = three_laps});
    ASSERT_TRUE(path.result() && turns.result());
    EXPECT_EQ(path->position({3, 0}, 0), 360);
    EXPECT_EQ(path->position({3, 0}, 1), 0);
    for (std::int32_t segment = 0; segment < 3; ++segment) {
      for (const std::size_t axis : {0U, 1U}) {
        Cubic middle = turns.cubic(segment + 3, axis);
        middle.c0 -= axis == 0 ? 360 : 0;
        for (const double t : {0.0, 0.3, 1.0}) {
          EXPECT_NEAR(path.cubic(segment, axis).value(t), middle.value(t), 1e-10);
          EXPECT_NEAR(path.cubic(segment, axis).derivative(t), middle.derivative(t), 1e-10);
        }
      }
    }
  }
  EXPECT_EQ(DrawnPath({.axis_count = 2, .keys = keys, .lap = lap}).result().error().code,
            ErrorCode::wrong_count)
      << "an open path has none";
}

TEST(Path, PassesThroughEveryKeyToTheLastBit) {
  const std::vector<double> keys{0.1, -7.3, 3.7, 1e-7, 1e6, 0.3, 1e6, 0.3, -2.0, 8.125};
  for (const Spline spline : every_kind) {
    for (const bool closed : {false, true}) {
      const DrawnPath path({.spline = spline, .closed = closed, .axis_count = 2, .keys = keys});
      ASSERT_TRUE(path.result());
      EXPECT_EQ(path->key_count(), 5);
      EXPECT_EQ(path->segment_count(), closed ? 5 : 4);
      for (std::int32_t i = 0; i <= path->segment_count(); ++i) {
        for (std::int32_t d = 0; d < 2; ++d) {
          EXPECT_EQ(path->position({i, 0}, d), keys[static_cast<std::size_t>(i % 5 * 2 + d)]);
        }
      }
    }
  }
}

TEST(Path, TheContinuationLeavesAsThePathArrives) {
  const std::vector<double> keys{0, 1, 5, 2};
  for (const Spline spline : every_kind) {
    const DrawnPath path({.spline = spline, .axis_count = 1, .keys = keys});
    const Cubic& last = path.cubic(2);
    const Cubic& beyond = path.cubic(3);
    const double rounding = 64 * std::numeric_limits<double>::epsilon();
    EXPECT_NEAR(beyond.derivative(0), last.derivative(1), rounding);
    EXPECT_NEAR(beyond.second(0), last.second(1), rounding);
    EXPECT_EQ(beyond.third(), last.third());
    EXPECT_NEAR(beyond.value(0.25), last.value(1.25), rounding);
  }
}

TEST(Path, OneKeyIsAPathThatStaysThere) {
  const std::vector<double> keys{3.3, -4.4};
  for (const Spline spline : every_kind) {
    for (const int kind : {0, 1, 2, 3}) {
      const DrawnPath path(
          {.spline = spline, .closed = kind % 2 == 1, .axis_count = 2, .keys = keys, .overshoot = kind < 2});
      ASSERT_TRUE(path.result());
      EXPECT_EQ(path->segment_count(), 0);
      EXPECT_EQ(path->position({0, 0}, 0), 3.3);
      EXPECT_EQ(path->position({0, 0}, 1), -4.4);
      EXPECT_EQ(path->parametric_speed({0, 0}), 0);
    }
  }
}

TEST(Path, TellsWhatItWasMadeFrom) {
  const std::vector<double> keys{0, 0, 3, 4};
  const std::vector<double> weights{2, 0.5};
  const DrawnPath path(
      {.spline = Spline::linear, .closed = true, .axis_count = 2, .keys = keys, .weights = weights});
  EXPECT_EQ(path->axis_count(), 2);
  EXPECT_EQ(path->spline(), Spline::linear);
  EXPECT_TRUE(path->closed());
  EXPECT_THAT(path->weights(), testing::ElementsAre(2, 0.5));
  const DrawnPath plain({.spline = Spline::linear, .axis_count = 2, .keys = keys});
  EXPECT_THAT(plain->weights(), testing::ElementsAre(1, 1));
  EXPECT_FALSE(plain->closed());
}

TEST(Path, TwoKeysAreAStraightLineRunEvenly) {
  const std::vector<double> keys{1, 10, 4, 6};
  for (const Spline spline : every_kind) {
    const DrawnPath path({.spline = spline, .axis_count = 2, .keys = keys});
    expect_cubic(path.cubic(0, 0), 1.0, 3.0, 0.0, 0.0);
    expect_cubic(path.cubic(0, 1), 10.0, -4.0, 0.0, 0.0);
  }
}

// --- tangents of Kochanek and Bartels, by hand

/// Keys 0, 1, 5, 2 (chords 1, 4, -3) with one shaped key 1: the derivatives on either side of it.
struct Tangents {
  double arriving;
  double leaving;
};
Tangents tangents_at_key_1(const KeyShape& shape) {
  const std::vector<double> keys{0, 1, 5, 2};
  std::vector<KeyShape> shapes(4);
  shapes[1] = shape;
  const DrawnPath path({.spline = Spline::tcb, .axis_count = 1, .keys = keys, .shapes = shapes});
  return {path.cubic(0).derivative(1), path.cubic(1).derivative(0)};
}

void expect_tangents(const KeyShape& shape, double arriving, double leaving) {
  const Tangents tangents = tangents_at_key_1(shape);
  EXPECT_DOUBLE_EQ(tangents.arriving, arriving);
  EXPECT_DOUBLE_EQ(tangents.leaving, leaving);
}

TEST(PathTcb, AnUnshapedKeyHasHalfTheChordBetweenItsNeighbours) {
  expect_tangents({}, 2.5, 2.5);
}

TEST(PathTcb, TensionShortensBothTangents) {
  expect_tangents({.tension = 0.5}, 1.25, 1.25);
  expect_tangents({.tension = 1}, 0, 0);
  expect_tangents({.tension = -1}, 5, 5);
}

TEST(PathTcb, ContinuityBreaksTheTangentTowardsTheChords) {
  expect_tangents({.continuity = -1}, 1, 4);
  expect_tangents({.continuity = 1}, 4, 1);
  expect_tangents({.continuity = -0.5}, 1.75, 3.25);
}

TEST(PathTcb, BiasTurnsTheTangentToOneOfTheChords) {
  expect_tangents({.bias = 1}, 1, 1);
  expect_tangents({.bias = -1}, 4, 4);
  expect_tangents({.bias = 0.5}, 1.75, 1.75);
}

TEST(PathTcb, AllThreeTogetherAreThePapersEquations8And9) {
  // (1-t)(1-c)(1+b)/2 * 1 + (1-t)(1+c)(1-b)/2 * 4, and with c negated.
  expect_tangents({.tension = 0.5, .continuity = 0.25, .bias = -0.5}, 0.09375 + 1.875, 0.15625 + 1.125);
}

TEST(PathTcb, BothChordsOfAnEndKeyAreItsOnlyChord) {
  const std::vector<double> keys{0, 8, 20};
  const std::vector<KeyShape> shapes(3, {.tension = 0.5, .continuity = 0.5, .bias = 0.5});
  const DrawnPath path({.spline = Spline::tcb, .axis_count = 1, .keys = keys, .shapes = shapes});
  // Leaving: (1-t)/2 ((1+c)(1+b) + (1-c)(1-b)) = 0.625; arriving, with c negated, 0.375.
  EXPECT_DOUBLE_EQ(path.cubic(0).derivative(0), 0.625 * 8);
  EXPECT_DOUBLE_EQ(path.cubic(1).derivative(1), 0.375 * 12);
}

TEST(PathTcb, AClosedPathWrapsItsTangents) {
  const std::vector<double> keys{0, 1, 5};
  const DrawnPath path({.spline = Spline::catmull_rom, .closed = true, .axis_count = 1, .keys = keys});
  EXPECT_EQ(path->segment_count(), 3);
  EXPECT_DOUBLE_EQ(path.cubic(0).derivative(0), -2);  // half of 1 - 5
  EXPECT_DOUBLE_EQ(path.cubic(2).derivative(0), -0.5);
  EXPECT_DOUBLE_EQ(path.cubic(2).derivative(1), -2);
  EXPECT_DOUBLE_EQ(path.cubic(3).derivative(0), -2);
}

TEST(PathTcb, AClosedPathWrapsTheShapeOfItsFirstKey) {
  const std::vector<double> keys{0, 1, 5};
  std::vector<KeyShape> shapes(3);
  shapes[0] = {.tension = 0, .continuity = -1, .bias = 0};
  const DrawnPath path(
      {.spline = Spline::tcb, .closed = true, .axis_count = 1, .keys = keys, .shapes = shapes});
  EXPECT_DOUBLE_EQ(path.cubic(0).derivative(0), 1);
  EXPECT_DOUBLE_EQ(path.cubic(2).derivative(1), -5);
}

TEST(PathTcb, WithAllParametersZeroIsCatmullRom) {
  const std::vector<double> keys{0.3, 1.7, 5.1, -2.2, 9.9, 4.4, 0.6, 1.2};
  const std::vector<KeyShape> shapes(4);
  const std::vector<KeyShape> not_read(4, {.tension = 0.5, .continuity = 0.5, .bias = 0.5});
  const PathSpec tcb{.spline = Spline::tcb, .axis_count = 2, .keys = keys, .shapes = shapes};
  const DrawnPath shaped(tcb);
  const DrawnPath unshaped({.spline = Spline::tcb, .axis_count = 2, .keys = keys});
  const DrawnPath catmull_rom(
      {.spline = Spline::catmull_rom, .axis_count = 2, .keys = keys, .shapes = not_read});
  for (std::int32_t i = 0; i < 3; ++i) {
    for (std::size_t d = 0; d < 2; ++d) {
      for (const auto part : {&Cubic::c0, &Cubic::c1, &Cubic::c2, &Cubic::c3}) {
        EXPECT_EQ(shaped.cubic(i, d).*part, catmull_rom.cubic(i, d).*part);
        EXPECT_EQ(unshaped.cubic(i, d).*part, catmull_rom.cubic(i, d).*part);
      }
    }
  }
}

TEST(PathTcb, WithContinuityZeroHasOneTangentAtEveryKey) {
  const std::vector<double> keys{0, 1, 5, 2, 9, -3};
  std::vector<KeyShape> shapes;
  for (const double x : {-0.9, -0.2, 0.1, 0.4, 0.8, 1.0})
    shapes.push_back({.tension = x, .continuity = 0, .bias = -x});
  const DrawnPath path(
      {.spline = Spline::tcb, .closed = true, .axis_count = 1, .keys = keys, .shapes = shapes});
  for (std::int32_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(path.cubic(i).derivative(1), path.cubic((i + 1) % 6).derivative(0), 1e-13) << "key " << i + 1;
  }
}

// --- smooth, by hand

TEST(Path, SmoothThroughEvenlySpacedKeysIsTheNaturalSpline) {
  const std::vector<double> keys{0, 1, 0};
  const DrawnPath path({.axis_count = 1, .keys = keys});
  expect_cubic(path.cubic(0), 0, 1.5, 0, -0.5);
  expect_cubic(path.cubic(1), 1, 0, -1.5, 0.5);
}

TEST(Path, SmoothSpacesItsKnotsByTheSquareRootOfTheChord) {
  // Chords 1 and 4, so knots at 0, 1, 3; slopes 1 and 2; M = 6 (2 - 1) / (2 (1 + 2)) = 1.
  const std::vector<double> keys{0, 1, 5};
  const DrawnPath path({.axis_count = 1, .keys = keys});
  expect_cubic(path.cubic(0), 0, 5.0 / 6, 0, 1.0 / 6);
  expect_cubic(path.cubic(1), 1, 8.0 / 3, 2, -2.0 / 3);
}

TEST(Path, SmoothAndClosedIsPeriodic) {
  // The corners of a square turn into one another, so M = -3 times the corner seen from the middle.
  const std::vector<double> keys{0, 0, 1, 0, 1, 1, 0, 1};
  const DrawnPath path({.closed = true, .axis_count = 2, .keys = keys});
  expect_cubic(path.cubic(0, 0), 0, 0.75, 0.75, -0.5);
  expect_cubic(path.cubic(0, 1), 0, -0.75, 0.75, 0);
  expect_cubic(path.cubic(3, 0), 0, -0.75, 0.75, 0);
  expect_cubic(path.cubic(3, 1), 1, -0.75, -0.75, 0.5);
}

TEST(PathSmooth, TwoKeysClosedSwingThereAndBack) {
  const std::vector<double> keys{0, 1};
  const DrawnPath path({.closed = true, .axis_count = 1, .keys = keys});
  expect_cubic(path.cubic(0), 0.0, 0.0, 3.0, -2.0);
  expect_cubic(path.cubic(1), 1.0, 0.0, -3.0, 2.0);
}

/// sqrt of the chord after every key, and 0 after a repeated one.
std::vector<double> knot_steps(const std::vector<double>& keys, bool closed) {
  std::vector<double> steps;
  for (std::size_t i = 0; i + (closed ? 0 : 2) < keys.size(); i += 2) {
    const std::size_t next = (i + 2) % keys.size();
    steps.push_back(std::sqrt(std::hypot(keys[next] - keys[i], keys[next + 1] - keys[i + 1])));
  }
  return steps;
}

const std::vector<double> bent{0, 0, 1, 3, 7, 2, 7.5, 2.5, -4, -20, 5, 5};

TEST(PathSmooth, FirstAndSecondDerivativesInTheKnotsPassThroughEveryKey) {
  for (const bool closed : {false, true}) {
    const DrawnPath path({.closed = closed, .axis_count = 2, .keys = bent});
    const std::vector<double> h = knot_steps(bent, closed);
    const std::size_t joints = closed ? h.size() : h.size() - 1;
    for (std::size_t i = 0; i < joints; ++i) {
      const std::size_t next = (i + 1) % h.size();
      for (std::size_t d = 0; d < 2; ++d) {
        const Cubic& before = path.cubic(static_cast<std::int32_t>(i), d);
        const Cubic& after = path.cubic(static_cast<std::int32_t>(next), d);
        EXPECT_NEAR(before.derivative(1) / h[i], after.derivative(0) / h[next], 1e-13);
        EXPECT_NEAR(before.second(1) / (h[i] * h[i]), after.second(0) / (h[next] * h[next]), 1e-13);
      }
    }
  }
}

TEST(PathSmooth, HasNoCurvatureAtOpenEnds) {
  const DrawnPath path({.axis_count = 2, .keys = bent});
  for (std::size_t d = 0; d < 2; ++d) {
    EXPECT_EQ(path.cubic(0, d).second(0), 0);
    EXPECT_NEAR(path.cubic(4, d).second(1), 0, 1e-13);
    EXPECT_NE(path.cubic(1, d).second(0), 0);
  }
}

TEST(PathSmooth, RepeatedKeysShareAKnotAndTakeNoTime) {
  const std::vector<double> once{0, 1, 0};
  const std::vector<double> repeated{0, 0, 1, 1, 1, 0, 0};
  for (const bool closed : {false, true}) {
    const DrawnPath plain({.closed = closed, .axis_count = 1, .keys = once});
    const DrawnPath path({.closed = closed, .axis_count = 1, .keys = repeated});
    ASSERT_TRUE(path.result());
    for (const std::int32_t still : {0, 2, 3, 5}) {
      const Cubic& c = path.cubic(still);
      expect_cubic(c, repeated[static_cast<std::size_t>(still)], 0.0, 0.0, 0.0);
    }
    const Cubic& rising = plain.cubic(0);
    const Cubic& falling = plain.cubic(1);
    expect_cubic(path.cubic(1), 0.0, rising.c1, rising.c2, rising.c3);
    expect_cubic(path.cubic(4), 1.0, falling.c1, falling.c2, falling.c3);
  }
}

TEST(PathSmooth, AllKeysEqualStandStill) {
  const std::vector<double> keys{4, 4, 4};
  for (const bool closed : {false, true}) {
    const DrawnPath path({.closed = closed, .axis_count = 1, .keys = keys});
    ASSERT_TRUE(path.result());
    for (std::int32_t i = 0; i <= path->segment_count(); ++i) expect_cubic(path.cubic(i), 4.0, 0.0, 0.0, 0.0);
  }
}

TEST(PathSmooth, AxesWithoutWeightFollowTheKnotsOfTheOthers) {
  // Knots at 0, 1, 3 by the first axis; there the second is the straight line u.
  const std::vector<double> keys{0, 0, 1, 1, 5, 3};
  const std::vector<double> weights{1, 0};
  const DrawnPath path({.axis_count = 2, .keys = keys, .weights = weights});
  expect_cubic(path.cubic(0, 1), 0.0, 1.0, 0.0, 0.0);
  expect_cubic(path.cubic(1, 1), 1.0, 2.0, 0.0, 0.0);
}

TEST(PathLinear, GoesStraightFromKeyToKey) {
  const std::vector<double> keys{0, 0, 3, 4, 3, 4, -1, 6};
  const DrawnPath path({.spline = Spline::linear, .closed = true, .axis_count = 2, .keys = keys});
  expect_cubic(path.cubic(0, 0), 0.0, 3.0, 0.0, 0.0);
  expect_cubic(path.cubic(1, 1), 4.0, 0.0, 0.0, 0.0);
  expect_cubic(path.cubic(2, 0), 3.0, -4.0, 0.0, 0.0);
  expect_cubic(path.cubic(3, 1), 6.0, -6.0, 0.0, 0.0);
}

// --- measure

TEST(Path, ParametricSpeedCountsEveryAxisByItsWeight) {
  const std::vector<double> keys{0, 0, 3, 4};
  const std::vector<double> weights{4, 0.5};
  const PathSpec plain{.spline = Spline::linear, .axis_count = 2, .keys = keys};
  PathSpec weighted = plain;
  weighted.weights = weights;
  EXPECT_DOUBLE_EQ(DrawnPath(plain)->parametric_speed({0, 0.5}), 5);
  EXPECT_DOUBLE_EQ(DrawnPath(weighted)->parametric_speed({0, 0.5}), std::sqrt(148.0));
}

TEST(Path, AnAxisThatNothingMeasuresIsNamedWithItsKey) {
  const std::vector<double> keys{0, 7, 1, 8, 1, 12};
  const std::vector<double> weights{1, 0};
  for (const Spline spline : {Spline::smooth, Spline::linear}) {
    const DrawnPath path({.spline = spline, .axis_count = 2, .keys = keys, .weights = weights});
    expect_refused(path.result(), ErrorCode::unmeasured, 1, 1, "weight");
  }
  const std::vector<double> between{0, 7, 1, 8, 1, 12, 3, 12};
  const DrawnPath bridged({.axis_count = 2, .keys = between, .weights = weights});
  expect_refused(bridged.result(), ErrorCode::unmeasured, 1, 1, "weight");
  const std::vector<double> both{0, 7, 7, 0, 8, 9};
  const std::vector<double> first_only{1, 0, 0};
  const DrawnPath two_unmeasured({.axis_count = 3, .keys = both, .weights = first_only});
  expect_refused(two_unmeasured.result(), ErrorCode::unmeasured, 0, 1, "weight");
  const std::vector<double> never{2, 7, 2, 8, 2, 12};
  for (const Spline spline : every_kind) {
    const DrawnPath path({.spline = spline, .axis_count = 2, .keys = never, .weights = weights});
    expect_refused(path.result(), ErrorCode::unmeasured, 0, 1, "weight");
  }
}

TEST(Path, AnAxisWithoutWeightMayMoveTogetherWithAnother) {
  const std::vector<double> keys{0, 7, 1, 8, 2, 12};
  const std::vector<double> weights{1, 0};
  for (const Spline spline : every_kind) {
    const DrawnPath path({.spline = spline, .axis_count = 2, .keys = keys, .weights = weights});
    EXPECT_TRUE(path.result());
  }
}

// --- scale and offset

/// The coefficients of `path` are those of `plain` times `scale`, bit for bit.
void expect_scaled(const DrawnPath& path, const DrawnPath& plain, double scale, double offset) {
  for (std::int32_t i = 0; i < plain->segment_count(); ++i) {
    for (std::size_t d = 0; d < 2; ++d) {
      const Cubic& expected = plain.cubic(i, d);
      const Cubic& got = path.cubic(i, d);
      EXPECT_EQ(got.c0, expected.c0 * scale + offset);
      EXPECT_EQ(got.c1, expected.c1 * scale);
      EXPECT_EQ(got.c2, expected.c2 * scale);
      EXPECT_EQ(got.c3, expected.c3 * scale);
    }
    const PathPoint middle{i, 0.5};
    EXPECT_EQ(path->parametric_speed(middle), plain->parametric_speed(middle) * scale);
  }
}

TEST(Path, ScaleIsOfNoConsequence) {
  // About 1e100, 1e-100 and 1e-180; the squares of the last are no doubles.
  const std::vector<int> exponents{332, -332, -600};
  const std::vector<double> keys{0, 0, 1, 3, 7, 2, 8, -20};
  for (const Spline spline : every_kind) {
    const DrawnPath plain({.spline = spline, .axis_count = 2, .keys = keys});
    for (const int exponent : exponents) {
      const double scale = std::ldexp(1.0, exponent);
      std::vector<double> scaled = keys;
      for (double& coordinate : scaled) coordinate *= scale;
      const DrawnPath path({.spline = spline, .axis_count = 2, .keys = scaled});
      ASSERT_TRUE(path.result());
      expect_scaled(path, plain, scale, 0.0);
    }
  }
}

TEST(Path, OffsetIsOfNoConsequence) {
  const double offset = 1e12;
  const std::vector<double> keys{0, 0, 1, 3, 7, 2, 8, -20};
  std::vector<double> moved = keys;
  for (double& coordinate : moved) coordinate += offset;
  for (const Spline spline : every_kind) {
    const DrawnPath plain({.spline = spline, .axis_count = 2, .keys = keys});
    const DrawnPath path({.spline = spline, .axis_count = 2, .keys = moved});
    expect_scaled(path, plain, 1.0, offset);
  }
}

// --- what is refused

TEST(Path, NamesTheKeyAndAxisOfACoordinateThatIsNoUsableNumber) {
  struct Case {
    double value;
    ErrorCode code;
    const char* word;
  };
  const double infinity = std::numeric_limits<double>::infinity();
  const double too_large = std::nextafter(Precision::largest, infinity);
  const Case cases[] = {
      {std::numeric_limits<double>::quiet_NaN(), ErrorCode::not_finite, "finite"},
      {infinity, ErrorCode::not_finite, "finite"},
      {-infinity, ErrorCode::not_finite, "finite"},
      {static_cast<double>(1e308), ErrorCode::out_of_range, "too large"},
      {too_large, ErrorCode::out_of_range, "too large"},
      {-too_large, ErrorCode::out_of_range, "too large"},
  };
  for (const Case& each : cases) {
    for (const Spline spline : every_kind) {
      std::vector<double> keys{0, 0, 1, 2, 3, 4};
      keys[5] = each.value;
      const DrawnPath path({.spline = spline, .axis_count = 2, .keys = keys});
      expect_refused(path.result(), each.code, 2, 1, each.word);
    }
  }
}

TEST(Path, TheLargestCoordinatesStillGiveFiniteNumbers) {
  const double most = Precision::largest;
  const std::vector<double> keys{most, -most, -most, most, most, most, -most, -most};
  for (const Spline spline : every_kind) {
    const DrawnPath path({.spline = spline, .closed = true, .axis_count = 2, .keys = keys});
    ASSERT_TRUE(path.result());
    for (std::int32_t i = 0; i <= path->segment_count(); ++i) {
      const double speed = path->parametric_speed({i, 0.5});
      EXPECT_TRUE(std::isfinite(speed));
      EXPECT_TRUE(std::isfinite(path->position({i, 0.5}, 0)));
    }
  }
}

TEST(Path, NamesTheAxisOfABadWeight) {
  struct Case {
    double value;
    ErrorCode code;
    const char* word;
  };
  const double infinity = std::numeric_limits<double>::infinity();
  const Case cases[] = {
      {-std::numeric_limits<double>::denorm_min(), ErrorCode::out_of_range, "negative"},
      {-1.0, ErrorCode::out_of_range, "negative"},
      {std::numeric_limits<double>::quiet_NaN(), ErrorCode::not_finite, "finite"},
      {infinity, ErrorCode::not_finite, "finite"},
      {-infinity, ErrorCode::not_finite, "finite"},
      {std::numeric_limits<double>::max(), ErrorCode::out_of_range, "too large"},
  };
  const std::vector<double> keys{0, 0, 1, 2};
  for (const Case& each : cases) {
    const std::vector<double> weights{1, each.value};
    const DrawnPath path({.axis_count = 2, .keys = keys, .weights = weights});
    expect_refused(path.result(), each.code, -1, 1, each.word);
  }
}

TEST(Path, ACoordinateTooLargeForItsWeightIsNamed) {
  const std::vector<double> keys{0, 0, 1, 2};
  const std::vector<double> weights{1, Precision::largest * 0.75};
  const DrawnPath path({.axis_count = 2, .keys = keys, .weights = weights});
  expect_refused(path.result(), ErrorCode::out_of_range, 1, 1, "too large");
}

TEST(Path, NamesTheKeyOfABadShape) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double above = std::nextafter(1.0, 2.0);
  const std::vector<double> keys{0, 1, 2};
  for (const double bad : {nan, above, -above, std::numeric_limits<double>::infinity()}) {
    for (const KeyShape& shape : {KeyShape{bad, 0, 0}, {0, bad, 0}, {0, 0, bad}}) {
      std::vector<KeyShape> shapes(3, {1, -1, 1});
      shapes[2] = shape;
      const DrawnPath path({.spline = Spline::tcb, .axis_count = 1, .keys = keys, .shapes = shapes});
      const ErrorCode code = std::isfinite(bad) ? ErrorCode::out_of_range : ErrorCode::not_finite;
      expect_refused(path.result(), code, 2, -1, "tension, continuity or bias");
    }
  }
}

TEST(Path, CountsMustFitTogether) {
  const std::vector<double> keys{0, 0, 1, 2, 3, 4};
  const std::vector<double> one{1};
  const std::vector<double> three{1, 1, 1};
  const std::vector<KeyShape> two_shapes(2);
  const auto expect_wrong_count = [](const PathSpec& spec, std::int32_t key, const char* word) {
    const DrawnPath path(spec);
    expect_refused(path.result(), ErrorCode::wrong_count, key, -1, word);
  };
  expect_wrong_count({.axis_count = 0, .keys = keys}, -1, "no axes");
  expect_wrong_count({.axis_count = -2, .keys = keys}, -1, "no axes");
  expect_wrong_count({.axis_count = 2, .keys = {}}, 0, "no keys");
  expect_wrong_count({.axis_count = 4, .keys = keys}, 1, "unequal length");
  expect_wrong_count({.axis_count = 2, .keys = keys, .weights = one}, -1, "weights");
  expect_wrong_count({.axis_count = 2, .keys = keys, .weights = three}, -1, "weights");
  expect_wrong_count({.spline = Spline::tcb, .axis_count = 2, .keys = keys, .shapes = two_shapes}, -1,
                     "tensions");
}

/// ... however many there are: some are computed two at once.
TEST(Path, GivesTheValuesOfManyCubicsWithTheBitsOfOne) {
  std::vector<Cubic> cubics;
  for (int i = 1; i <= 5; ++i) {
    const auto x = static_cast<double>(i);
    cubics.push_back({1 / x, -x / 3, std::sqrt(x), 0.7 - x});
  }
  for (std::size_t count = 0; count <= cubics.size(); ++count) {
    for (const double t : {0.0, 0.3, 0.77, 1.0}) {
      std::vector<double> values(cubics.size(), -1);
      write_values(cubics, t, std::span(values).first(count));
      for (std::size_t d = 0; d < count; ++d) EXPECT_EQ(values[d], cubics[d].value(t));
      for (std::size_t d = count; d < values.size(); ++d) EXPECT_EQ(values[d], -1);
    }
  }
}

TEST(Path, StatesTheCapacityNeededWhichSuffices) {
  const std::vector<double> keys{0, 0, 1, 2, 3, 4};
  std::vector<double> weights(2);
  for (const bool closed : {false, true}) {
    const PathSpec spec{.closed = closed, .axis_count = 2, .keys = keys};
    const auto refused = Path::make(spec, {{}, weights});
    expect_refused(refused, ErrorCode::capacity, -1, -1, "memory");
    EXPECT_EQ(refused.error().needed, closed ? 8 : 6);  // (segments + 1) * axes
    std::vector<Cubic> cubics(static_cast<std::size_t>(refused.error().needed));
    EXPECT_TRUE(Path::make(spec, {cubics, weights}));
    EXPECT_FALSE(Path::make(spec, {std::span(cubics).first(cubics.size() - 1), weights}));
    EXPECT_FALSE(Path::make(spec, {cubics, std::span(weights).first(1)}));
  }
}

}  // namespace path_test
}  // namespace inbetween
