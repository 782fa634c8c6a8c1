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
template <Precise Real>
class DrawnPath {
 public:
  explicit DrawnPath(const PathSpec<Real>& spec) : result_(Path<Real>::make(spec, storage_.memory())) {}
  DrawnPath(const DrawnPath&) = delete;
  DrawnPath& operator=(const DrawnPath&) = delete;

  const Path<Real>* operator->() const { return &*result_; }
  const Result<Path<Real>>& result() const { return result_; }
  const Cubic<Real>& cubic(std::int32_t segment, std::size_t axis = 0) const {
    return result_->segment(segment)[axis];
  }

 private:
  PathStorage<Real, 16, 4> storage_;
  Result<Path<Real>> result_;
};

struct PrecisionName {
  template <class Real>
  static std::string GetName(int) {
    return std::is_same_v<Real, double> ? "double" : "float";
  }
};

template <class Real>
class PathIn : public testing::Test {};
using Precisions = testing::Types<double, float>;
TYPED_TEST_SUITE(PathIn, Precisions, PrecisionName);

constexpr Spline every_kind[] = {Spline::smooth, Spline::catmull_rom, Spline::tcb, Spline::linear};

template <Precise Real>
void expect_cubic(const Cubic<Real>& cubic, Real c0, Real c1, Real c2, Real c3) {
  const Real rounding = 8 * std::numeric_limits<Real>::epsilon();
  EXPECT_NEAR(cubic.c0, c0, rounding);
  EXPECT_NEAR(cubic.c1, c1, rounding);
  EXPECT_NEAR(cubic.c2, c2, rounding);
  EXPECT_NEAR(cubic.c3, c3, rounding);
}

template <Precise Real>
void expect_refused(const Result<Path<Real>>& result, ErrorCode code, std::int32_t key, std::int32_t axis,
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
    const DrawnPath<double> path(
        {.spline = spline, .closed = true, .axis_count = 2, .keys = keys, .lap = lap});
    const DrawnPath<double> turns(
        {.spline = spline, .closed = true, .axis_count = 2, .keys = three, .lap = three_laps});
    ASSERT_TRUE(path.result() && turns.result());
    EXPECT_EQ(path->position({3, 0}, 0), 360);
    EXPECT_EQ(path->position({3, 0}, 1), 0);
    for (std::int32_t segment = 0; segment < 3; ++segment) {
      for (const std::size_t axis : {0U, 1U}) {
        Cubic<double> middle = turns.cubic(segment + 3, axis);
        middle.c0 -= axis == 0 ? 360 : 0;
        for (const double t : {0.0, 0.3, 1.0}) {
          EXPECT_NEAR(path.cubic(segment, axis).value(t), middle.value(t), 1e-10);
          EXPECT_NEAR(path.cubic(segment, axis).derivative(t), middle.derivative(t), 1e-10);
        }
      }
    }
  }
  EXPECT_EQ(DrawnPath<double>({.axis_count = 2, .keys = keys, .lap = lap}).result().error().code,
            ErrorCode::wrong_count)
      << "an open path has none";
}

TYPED_TEST(PathIn, PassesThroughEveryKeyToTheLastBit) {
  using Real = TypeParam;
  const std::vector<Real> keys{Real(0.1), Real(-7.3), Real(3.7), Real(1e-7), Real(1e6),
                               Real(0.3), Real(1e6),  Real(0.3), Real(-2),   Real(8.125)};
  for (const Spline spline : every_kind) {
    for (const bool closed : {false, true}) {
      const DrawnPath<Real> path({.spline = spline, .closed = closed, .axis_count = 2, .keys = keys});
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

TYPED_TEST(PathIn, TheContinuationLeavesAsThePathArrives) {
  using Real = TypeParam;
  const std::vector<Real> keys{0, 1, 5, 2};
  for (const Spline spline : every_kind) {
    const DrawnPath<Real> path({.spline = spline, .axis_count = 1, .keys = keys});
    const Cubic<Real>& last = path.cubic(2);
    const Cubic<Real>& beyond = path.cubic(3);
    const Real rounding = 64 * std::numeric_limits<Real>::epsilon();
    EXPECT_NEAR(beyond.derivative(0), last.derivative(1), rounding);
    EXPECT_NEAR(beyond.second(0), last.second(1), rounding);
    EXPECT_EQ(beyond.third(), last.third());
    EXPECT_NEAR(beyond.value(Real(0.25)), last.value(Real(1.25)), rounding);
  }
}

TYPED_TEST(PathIn, OneKeyIsAPathThatStaysThere) {
  using Real = TypeParam;
  const std::vector<Real> keys{Real(3.3), Real(-4.4)};
  for (const Spline spline : every_kind) {
    for (const int ways : {0, 1, 2, 3}) {
      const DrawnPath<Real> path(
          {.spline = spline, .closed = ways % 2 == 1, .axis_count = 2, .keys = keys, .overshoot = ways < 2});
      ASSERT_TRUE(path.result());
      EXPECT_EQ(path->segment_count(), 0);
      EXPECT_EQ(path->position({0, 0}, 0), Real(3.3));
      EXPECT_EQ(path->position({0, 0}, 1), Real(-4.4));
      EXPECT_EQ(path->parametric_speed({0, 0}), 0);
    }
  }
}

TEST(Path, TellsWhatItWasMadeFrom) {
  const std::vector<double> keys{0, 0, 3, 4};
  const std::vector<double> weights{2, 0.5};
  const DrawnPath<double> path(
      {.spline = Spline::linear, .closed = true, .axis_count = 2, .keys = keys, .weights = weights});
  EXPECT_EQ(path->axis_count(), 2);
  EXPECT_EQ(path->spline(), Spline::linear);
  EXPECT_TRUE(path->closed());
  EXPECT_THAT(path->weights(), testing::ElementsAre(2, 0.5));
  const DrawnPath<double> plain({.spline = Spline::linear, .axis_count = 2, .keys = keys});
  EXPECT_THAT(plain->weights(), testing::ElementsAre(1, 1));
  EXPECT_FALSE(plain->closed());
}

TEST(Path, TwoKeysAreAStraightLineRunEvenly) {
  const std::vector<double> keys{1, 10, 4, 6};
  for (const Spline spline : every_kind) {
    const DrawnPath<double> path({.spline = spline, .axis_count = 2, .keys = keys});
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
Tangents tangents_at_key_1(const KeyShape<double>& shape) {
  const std::vector<double> keys{0, 1, 5, 2};
  std::vector<KeyShape<double>> shapes(4);
  shapes[1] = shape;
  const DrawnPath<double> path({.spline = Spline::tcb, .axis_count = 1, .keys = keys, .shapes = shapes});
  return {path.cubic(0).derivative(1), path.cubic(1).derivative(0)};
}

void expect_tangents(const KeyShape<double>& shape, double arriving, double leaving) {
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
  const std::vector<KeyShape<double>> shapes(3, {.tension = 0.5, .continuity = 0.5, .bias = 0.5});
  const DrawnPath<double> path({.spline = Spline::tcb, .axis_count = 1, .keys = keys, .shapes = shapes});
  // Leaving: (1-t)/2 ((1+c)(1+b) + (1-c)(1-b)) = 0.625; arriving, with c negated, 0.375.
  EXPECT_DOUBLE_EQ(path.cubic(0).derivative(0), 0.625 * 8);
  EXPECT_DOUBLE_EQ(path.cubic(1).derivative(1), 0.375 * 12);
}

TEST(PathTcb, AClosedPathWrapsItsTangents) {
  const std::vector<double> keys{0, 1, 5};
  const DrawnPath<double> path(
      {.spline = Spline::catmull_rom, .closed = true, .axis_count = 1, .keys = keys});
  EXPECT_EQ(path->segment_count(), 3);
  EXPECT_DOUBLE_EQ(path.cubic(0).derivative(0), -2);  // half of 1 - 5
  EXPECT_DOUBLE_EQ(path.cubic(2).derivative(0), -0.5);
  EXPECT_DOUBLE_EQ(path.cubic(2).derivative(1), -2);
  EXPECT_DOUBLE_EQ(path.cubic(3).derivative(0), -2);
}

TEST(PathTcb, AClosedPathWrapsTheShapeOfItsFirstKey) {
  const std::vector<double> keys{0, 1, 5};
  std::vector<KeyShape<double>> shapes(3);
  shapes[0] = {.tension = 0, .continuity = -1, .bias = 0};
  const DrawnPath<double> path(
      {.spline = Spline::tcb, .closed = true, .axis_count = 1, .keys = keys, .shapes = shapes});
  EXPECT_DOUBLE_EQ(path.cubic(0).derivative(0), 1);
  EXPECT_DOUBLE_EQ(path.cubic(2).derivative(1), -5);
}

TEST(PathTcb, WithAllParametersZeroIsCatmullRom) {
  const std::vector<double> keys{0.3, 1.7, 5.1, -2.2, 9.9, 4.4, 0.6, 1.2};
  const std::vector<KeyShape<double>> shapes(4);
  const std::vector<KeyShape<double>> not_read(4, {.tension = 0.5, .continuity = 0.5, .bias = 0.5});
  const PathSpec<double> tcb{.spline = Spline::tcb, .axis_count = 2, .keys = keys, .shapes = shapes};
  const DrawnPath<double> shaped(tcb);
  const DrawnPath<double> unshaped({.spline = Spline::tcb, .axis_count = 2, .keys = keys});
  const DrawnPath<double> catmull_rom(
      {.spline = Spline::catmull_rom, .axis_count = 2, .keys = keys, .shapes = not_read});
  for (std::int32_t i = 0; i < 3; ++i) {
    for (std::size_t d = 0; d < 2; ++d) {
      for (const auto part :
           {&Cubic<double>::c0, &Cubic<double>::c1, &Cubic<double>::c2, &Cubic<double>::c3}) {
        EXPECT_EQ(shaped.cubic(i, d).*part, catmull_rom.cubic(i, d).*part);
        EXPECT_EQ(unshaped.cubic(i, d).*part, catmull_rom.cubic(i, d).*part);
      }
    }
  }
}

TEST(PathTcb, WithContinuityZeroHasOneTangentAtEveryKey) {
  const std::vector<double> keys{0, 1, 5, 2, 9, -3};
  std::vector<KeyShape<double>> shapes;
  for (const double x : {-0.9, -0.2, 0.1, 0.4, 0.8, 1.0})
    shapes.push_back({.tension = x, .continuity = 0, .bias = -x});
  const DrawnPath<double> path(
      {.spline = Spline::tcb, .closed = true, .axis_count = 1, .keys = keys, .shapes = shapes});
  for (std::int32_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(path.cubic(i).derivative(1), path.cubic((i + 1) % 6).derivative(0), 1e-13) << "key " << i + 1;
  }
}

// --- smooth, by hand

TYPED_TEST(PathIn, SmoothThroughEvenlySpacedKeysIsTheNaturalSpline) {
  const std::vector<TypeParam> keys{0, 1, 0};
  const DrawnPath<TypeParam> path({.axis_count = 1, .keys = keys});
  expect_cubic<TypeParam>(path.cubic(0), 0, TypeParam(1.5), 0, TypeParam(-0.5));
  expect_cubic<TypeParam>(path.cubic(1), 1, 0, TypeParam(-1.5), TypeParam(0.5));
}

TYPED_TEST(PathIn, SmoothSpacesItsKnotsByTheSquareRootOfTheChord) {
  // Chords 1 and 4, so knots at 0, 1, 3; slopes 1 and 2; M = 6 (2 - 1) / (2 (1 + 2)) = 1.
  const std::vector<TypeParam> keys{0, 1, 5};
  const DrawnPath<TypeParam> path({.axis_count = 1, .keys = keys});
  expect_cubic<TypeParam>(path.cubic(0), 0, TypeParam(5) / 6, 0, TypeParam(1) / 6);
  expect_cubic<TypeParam>(path.cubic(1), 1, TypeParam(8) / 3, 2, TypeParam(-2) / 3);
}

TYPED_TEST(PathIn, SmoothAndClosedIsPeriodic) {
  // The corners of a square turn into one another, so M = -3 times the corner seen from the middle.
  const std::vector<TypeParam> keys{0, 0, 1, 0, 1, 1, 0, 1};
  const DrawnPath<TypeParam> path({.closed = true, .axis_count = 2, .keys = keys});
  const auto exact = [](double x) { return static_cast<TypeParam>(x); };
  expect_cubic<TypeParam>(path.cubic(0, 0), 0, exact(0.75), exact(0.75), exact(-0.5));
  expect_cubic<TypeParam>(path.cubic(0, 1), 0, exact(-0.75), exact(0.75), 0);
  expect_cubic<TypeParam>(path.cubic(3, 0), 0, exact(-0.75), exact(0.75), 0);
  expect_cubic<TypeParam>(path.cubic(3, 1), 1, exact(-0.75), exact(-0.75), exact(0.5));
}

TEST(PathSmooth, TwoKeysClosedSwingThereAndBack) {
  const std::vector<double> keys{0, 1};
  const DrawnPath<double> path({.closed = true, .axis_count = 1, .keys = keys});
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
    const DrawnPath<double> path({.closed = closed, .axis_count = 2, .keys = bent});
    const std::vector<double> h = knot_steps(bent, closed);
    const std::size_t joints = closed ? h.size() : h.size() - 1;
    for (std::size_t i = 0; i < joints; ++i) {
      const std::size_t next = (i + 1) % h.size();
      for (std::size_t d = 0; d < 2; ++d) {
        const Cubic<double>& before = path.cubic(static_cast<std::int32_t>(i), d);
        const Cubic<double>& after = path.cubic(static_cast<std::int32_t>(next), d);
        EXPECT_NEAR(before.derivative(1) / h[i], after.derivative(0) / h[next], 1e-13);
        EXPECT_NEAR(before.second(1) / (h[i] * h[i]), after.second(0) / (h[next] * h[next]), 1e-13);
      }
    }
  }
}

TEST(PathSmooth, HasNoCurvatureAtOpenEnds) {
  const DrawnPath<double> path({.axis_count = 2, .keys = bent});
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
    const DrawnPath<double> plain({.closed = closed, .axis_count = 1, .keys = once});
    const DrawnPath<double> path({.closed = closed, .axis_count = 1, .keys = repeated});
    ASSERT_TRUE(path.result());
    for (const std::int32_t still : {0, 2, 3, 5}) {
      const Cubic<double>& c = path.cubic(still);
      expect_cubic(c, repeated[static_cast<std::size_t>(still)], 0.0, 0.0, 0.0);
    }
    const Cubic<double>& rising = plain.cubic(0);
    const Cubic<double>& falling = plain.cubic(1);
    expect_cubic(path.cubic(1), 0.0, rising.c1, rising.c2, rising.c3);
    expect_cubic(path.cubic(4), 1.0, falling.c1, falling.c2, falling.c3);
  }
}

TEST(PathSmooth, AllKeysEqualStandStill) {
  const std::vector<double> keys{4, 4, 4};
  for (const bool closed : {false, true}) {
    const DrawnPath<double> path({.closed = closed, .axis_count = 1, .keys = keys});
    ASSERT_TRUE(path.result());
    for (std::int32_t i = 0; i <= path->segment_count(); ++i) expect_cubic(path.cubic(i), 4.0, 0.0, 0.0, 0.0);
  }
}

TEST(PathSmooth, AxesWithoutWeightFollowTheKnotsOfTheOthers) {
  // Knots at 0, 1, 3 by the first axis; there the second is the straight line u.
  const std::vector<double> keys{0, 0, 1, 1, 5, 3};
  const std::vector<double> weights{1, 0};
  const DrawnPath<double> path({.axis_count = 2, .keys = keys, .weights = weights});
  expect_cubic(path.cubic(0, 1), 0.0, 1.0, 0.0, 0.0);
  expect_cubic(path.cubic(1, 1), 1.0, 2.0, 0.0, 0.0);
}

TEST(PathLinear, GoesStraightFromKeyToKey) {
  const std::vector<double> keys{0, 0, 3, 4, 3, 4, -1, 6};
  const DrawnPath<double> path({.spline = Spline::linear, .closed = true, .axis_count = 2, .keys = keys});
  expect_cubic(path.cubic(0, 0), 0.0, 3.0, 0.0, 0.0);
  expect_cubic(path.cubic(1, 1), 4.0, 0.0, 0.0, 0.0);
  expect_cubic(path.cubic(2, 0), 3.0, -4.0, 0.0, 0.0);
  expect_cubic(path.cubic(3, 1), 6.0, -6.0, 0.0, 0.0);
}

// --- measure

TEST(Path, ParametricSpeedCountsEveryAxisByItsWeight) {
  const std::vector<double> keys{0, 0, 3, 4};
  const std::vector<double> weights{4, 0.5};
  const PathSpec<double> plain{.spline = Spline::linear, .axis_count = 2, .keys = keys};
  PathSpec<double> weighted = plain;
  weighted.weights = weights;
  EXPECT_DOUBLE_EQ(DrawnPath<double>(plain)->parametric_speed({0, 0.5}), 5);
  EXPECT_DOUBLE_EQ(DrawnPath<double>(weighted)->parametric_speed({0, 0.5}), std::sqrt(148.0));
}

TYPED_TEST(PathIn, AnAxisThatNothingMeasuresIsNamedWithItsKey) {
  using Real = TypeParam;
  const std::vector<Real> keys{0, 7, 1, 8, 1, 12};
  const std::vector<Real> weights{1, 0};
  for (const Spline spline : {Spline::smooth, Spline::linear}) {
    const DrawnPath<Real> path({.spline = spline, .axis_count = 2, .keys = keys, .weights = weights});
    expect_refused(path.result(), ErrorCode::unmeasured, 1, 1, "weight");
  }
  const std::vector<Real> between{0, 7, 1, 8, 1, 12, 3, 12};
  const DrawnPath<Real> bridged({.axis_count = 2, .keys = between, .weights = weights});
  expect_refused(bridged.result(), ErrorCode::unmeasured, 1, 1, "weight");
  const std::vector<Real> both{0, 7, 7, 0, 8, 9};
  const std::vector<Real> first_only{1, 0, 0};
  const DrawnPath<Real> two_unmeasured({.axis_count = 3, .keys = both, .weights = first_only});
  expect_refused(two_unmeasured.result(), ErrorCode::unmeasured, 0, 1, "weight");
  const std::vector<Real> never{2, 7, 2, 8, 2, 12};
  for (const Spline spline : every_kind) {
    const DrawnPath<Real> path({.spline = spline, .axis_count = 2, .keys = never, .weights = weights});
    expect_refused(path.result(), ErrorCode::unmeasured, 0, 1, "weight");
  }
}

TYPED_TEST(PathIn, AnAxisWithoutWeightMayMoveTogetherWithAnother) {
  using Real = TypeParam;
  const std::vector<Real> keys{0, 7, 1, 8, 2, 12};
  const std::vector<Real> weights{1, 0};
  for (const Spline spline : every_kind) {
    const DrawnPath<Real> path({.spline = spline, .axis_count = 2, .keys = keys, .weights = weights});
    EXPECT_TRUE(path.result());
  }
}

// --- scale and offset

/// The coefficients of `path` are those of `plain` times `scale`, bit for bit.
template <Precise Real>
void expect_scaled(const DrawnPath<Real>& path, const DrawnPath<Real>& plain, Real scale, Real offset) {
  for (std::int32_t i = 0; i < plain->segment_count(); ++i) {
    for (std::size_t d = 0; d < 2; ++d) {
      const Cubic<Real>& expected = plain.cubic(i, d);
      const Cubic<Real>& got = path.cubic(i, d);
      EXPECT_EQ(got.c0, expected.c0 * scale + offset);
      EXPECT_EQ(got.c1, expected.c1 * scale);
      EXPECT_EQ(got.c2, expected.c2 * scale);
      EXPECT_EQ(got.c3, expected.c3 * scale);
    }
    const PathPoint<Real> middle{i, Real(0.5)};
    EXPECT_EQ(path->parametric_speed(middle), plain->parametric_speed(middle) * scale);
  }
}

TYPED_TEST(PathIn, ScaleIsOfNoConsequence) {
  using Real = TypeParam;
  // About 1e100, 1e-100 and 1e-180 in double; the squares of the last are no numbers of the type.
  const bool wide = std::is_same_v<Real, double>;
  const std::vector<int> exponents{wide ? 332 : 40, wide ? -332 : -40, wide ? -600 : -70};
  const std::vector<Real> keys{0, 0, 1, 3, 7, 2, 8, -20};
  for (const Spline spline : every_kind) {
    const DrawnPath<Real> plain({.spline = spline, .axis_count = 2, .keys = keys});
    for (const int exponent : exponents) {
      const Real scale = std::ldexp(Real(1), exponent);
      std::vector<Real> scaled = keys;
      for (Real& coordinate : scaled) coordinate *= scale;
      const DrawnPath<Real> path({.spline = spline, .axis_count = 2, .keys = scaled});
      ASSERT_TRUE(path.result());
      expect_scaled(path, plain, scale, Real(0));
    }
  }
}

TYPED_TEST(PathIn, OffsetIsOfNoConsequence) {
  using Real = TypeParam;
  const Real offset = std::is_same_v<Real, double> ? Real(1e12) : Real(1 << 16);
  const std::vector<Real> keys{0, 0, 1, 3, 7, 2, 8, -20};
  std::vector<Real> moved = keys;
  for (Real& coordinate : moved) coordinate += offset;
  for (const Spline spline : every_kind) {
    const DrawnPath<Real> plain({.spline = spline, .axis_count = 2, .keys = keys});
    const DrawnPath<Real> path({.spline = spline, .axis_count = 2, .keys = moved});
    expect_scaled(path, plain, Real(1), offset);
  }
}

// --- what is refused

TYPED_TEST(PathIn, NamesTheKeyAndAxisOfACoordinateThatIsNoUsableNumber) {
  using Real = TypeParam;
  struct Case {
    Real value;
    ErrorCode code;
    const char* word;
  };
  const Real infinity = std::numeric_limits<Real>::infinity();
  const Real too_large = std::nextafter(Precision<Real>::largest, infinity);
  const Case cases[] = {
      {std::numeric_limits<Real>::quiet_NaN(), ErrorCode::not_finite, "finite"},
      {infinity, ErrorCode::not_finite, "finite"},
      {-infinity, ErrorCode::not_finite, "finite"},
      {std::is_same_v<Real, double> ? static_cast<Real>(1e308) : Real(3e38F), ErrorCode::out_of_range,
       "too large"},
      {too_large, ErrorCode::out_of_range, "too large"},
      {-too_large, ErrorCode::out_of_range, "too large"},
  };
  for (const Case& each : cases) {
    for (const Spline spline : every_kind) {
      std::vector<Real> keys{0, 0, 1, 2, 3, 4};
      keys[5] = each.value;
      const DrawnPath<Real> path({.spline = spline, .axis_count = 2, .keys = keys});
      expect_refused(path.result(), each.code, 2, 1, each.word);
    }
  }
}

TYPED_TEST(PathIn, TheLargestCoordinatesStillGiveFiniteNumbers) {
  using Real = TypeParam;
  const Real most = Precision<Real>::largest;
  const std::vector<Real> keys{most, -most, -most, most, most, most, -most, -most};
  for (const Spline spline : every_kind) {
    const DrawnPath<Real> path({.spline = spline, .closed = true, .axis_count = 2, .keys = keys});
    ASSERT_TRUE(path.result());
    for (std::int32_t i = 0; i <= path->segment_count(); ++i) {
      const Real speed = path->parametric_speed({i, Real(0.5)});
      EXPECT_TRUE(std::isfinite(speed));
      EXPECT_TRUE(std::isfinite(path->position({i, Real(0.5)}, 0)));
    }
  }
}

TYPED_TEST(PathIn, NamesTheAxisOfABadWeight) {
  using Real = TypeParam;
  struct Case {
    Real value;
    ErrorCode code;
    const char* word;
  };
  const Real infinity = std::numeric_limits<Real>::infinity();
  const Case cases[] = {
      {-std::numeric_limits<Real>::denorm_min(), ErrorCode::out_of_range, "negative"},
      {Real(-1), ErrorCode::out_of_range, "negative"},
      {std::numeric_limits<Real>::quiet_NaN(), ErrorCode::not_finite, "finite"},
      {infinity, ErrorCode::not_finite, "finite"},
      {-infinity, ErrorCode::not_finite, "finite"},
      {std::numeric_limits<Real>::max(), ErrorCode::out_of_range, "too large"},
  };
  const std::vector<Real> keys{0, 0, 1, 2};
  for (const Case& each : cases) {
    const std::vector<Real> weights{1, each.value};
    const DrawnPath<Real> path({.axis_count = 2, .keys = keys, .weights = weights});
    expect_refused(path.result(), each.code, -1, 1, each.word);
  }
}

TYPED_TEST(PathIn, ACoordinateTooLargeForItsWeightIsNamed) {
  using Real = TypeParam;
  const std::vector<Real> keys{0, 0, 1, 2};
  const std::vector<Real> weights{1, Precision<Real>::largest * Real(0.75)};
  const DrawnPath<Real> path({.axis_count = 2, .keys = keys, .weights = weights});
  expect_refused(path.result(), ErrorCode::out_of_range, 1, 1, "too large");
}

TYPED_TEST(PathIn, NamesTheKeyOfABadShape) {
  using Real = TypeParam;
  const Real nan = std::numeric_limits<Real>::quiet_NaN();
  const Real above = std::nextafter(Real(1), Real(2));
  const std::vector<Real> keys{0, 1, 2};
  for (const Real bad : {nan, above, -above, std::numeric_limits<Real>::infinity()}) {
    for (const KeyShape<Real>& shape : {KeyShape<Real>{bad, 0, 0}, {0, bad, 0}, {0, 0, bad}}) {
      std::vector<KeyShape<Real>> shapes(3, {1, -1, 1});
      shapes[2] = shape;
      const DrawnPath<Real> path({.spline = Spline::tcb, .axis_count = 1, .keys = keys, .shapes = shapes});
      const ErrorCode code = std::isfinite(bad) ? ErrorCode::out_of_range : ErrorCode::not_finite;
      expect_refused(path.result(), code, 2, -1, "tension, continuity or bias");
    }
  }
}

TYPED_TEST(PathIn, CountsMustFitTogether) {
  using Real = TypeParam;
  const std::vector<Real> keys{0, 0, 1, 2, 3, 4};
  const std::vector<Real> one{1};
  const std::vector<Real> three{1, 1, 1};
  const std::vector<KeyShape<Real>> two_shapes(2);
  const auto expect_wrong_count = [](const PathSpec<Real>& spec, std::int32_t key, const char* word) {
    const DrawnPath<Real> path(spec);
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
TYPED_TEST(PathIn, GivesTheValuesOfManyCubicsWithTheBitsOfOne) {
  using Real = TypeParam;
  std::vector<Cubic<Real>> cubics;
  for (int i = 1; i <= 5; ++i) {
    const auto x = static_cast<Real>(i);
    cubics.push_back({1 / x, -x / 3, std::sqrt(x), Real(0.7) - x});
  }
  for (std::size_t count = 0; count <= cubics.size(); ++count) {
    for (const Real t : {Real(0), Real(0.3), Real(0.77), Real(1)}) {
      std::vector<Real> values(cubics.size(), -1);
      write_values<Real>(cubics, t, std::span(values).first(count));
      for (std::size_t d = 0; d < count; ++d) EXPECT_EQ(values[d], cubics[d].value(t));
      for (std::size_t d = count; d < values.size(); ++d) EXPECT_EQ(values[d], -1);
    }
  }
}

TYPED_TEST(PathIn, StatesTheCapacityNeededWhichSuffices) {
  using Real = TypeParam;
  const std::vector<Real> keys{0, 0, 1, 2, 3, 4};
  std::vector<Real> weights(2);
  for (const bool closed : {false, true}) {
    const PathSpec<Real> spec{.closed = closed, .axis_count = 2, .keys = keys};
    const auto refused = Path<Real>::make(spec, {{}, weights});
    expect_refused(refused, ErrorCode::capacity, -1, -1, "memory");
    EXPECT_EQ(refused.error().needed, closed ? 8 : 6);  // (segments + 1) * axes
    std::vector<Cubic<Real>> cubics(static_cast<std::size_t>(refused.error().needed));
    EXPECT_TRUE(Path<Real>::make(spec, {cubics, weights}));
    EXPECT_FALSE(Path<Real>::make(spec, {std::span(cubics).first(cubics.size() - 1), weights}));
    EXPECT_FALSE(Path<Real>::make(spec, {cubics, std::span(weights).first(1)}));
  }
}

}  // namespace path_test
}  // namespace inbetween
