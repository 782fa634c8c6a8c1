#include "inbetween/timing/speed_profile.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

namespace inbetween {
namespace speed_profile_test {

using testing::ElementsAre;
using testing::HasSubstr;

/// A curve with the memory it stands in.
class DrawnCurve {
 public:
  explicit DrawnCurve(const std::vector<double>& values)
      : result_(SpeedProfile::make(values, storage_.memory())) {}
  DrawnCurve(const DrawnCurve&) = delete;
  DrawnCurve& operator=(const DrawnCurve&) = delete;

  const SpeedProfile& operator*() const { return *result_; }
  const SpeedProfile* operator->() const { return &*result_; }
  const Result<SpeedProfile>& result() const { return result_; }

 private:
  SpeedProfileStorage<16> storage_;
  Result<SpeedProfile> result_;
};

// --- the curve

/// Against a natural curve through three turns of the same values, whose ends are far away.
TEST(SpeedProfile, APeriodicCurveGoesOnFromItsEndToItsBeginning) {
  const std::vector<double> values = {3, 8, 1, 12, 3};
  SpeedProfileStorage<16> storage;
  const auto curve = SpeedProfile::make(values, storage.memory(), CurveEnds::periodic);
  ASSERT_TRUE(curve);
  const DrawnCurve unrolled({3, 8, 1, 12, 3, 8, 1, 12, 3, 8, 1, 12, 3});
  for (const double a : {0.0, 0.25, 1.0, 1.7, 2.5, 3.0, 3.9, 4.0}) {
    EXPECT_NEAR(curve->value(a), unrolled->value(4 + a), 1e-14) << a;
    EXPECT_NEAR(curve->derivative(a), unrolled->derivative(4 + a), 1e-13) << a;
    EXPECT_NEAR(curve->integral(a), unrolled->integral(4 + a) - unrolled->integral(4), 1e-13) << a;
  }
  EXPECT_NEAR(curve->value(0), curve->value(4), 1e-14);
  EXPECT_NEAR(curve->second(0), curve->second(4), 1e-13);
  const std::vector<double> open = {3, 8, 1};
  const auto refused = SpeedProfile::make(open, storage.memory(), CurveEnds::periodic);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().control_value, 2);
}

TEST(SpeedProfile, RefinedAPeriodicCurveIsTheSameCurve) {
  for (const std::vector<double>& drawn : {std::vector<double>{7, 7}, {8, 3, 8}, {8, 3, 0, 11, 6, 8}}) {
    const std::size_t f = drawn.size() - 1;
    std::vector<double> fine = drawn;
    fine.resize(2 * f + 1);
    refine_control_values(fine, f, CurveEnds::periodic);
    EXPECT_EQ(fine.front(), fine.back());
    for (std::size_t i = 0; i < 2 * f; ++i) {
      for (const double t : {0.0, 0.3, 0.9}) {
        const double of_fine = speed_span(fine, i, CurveEnds::periodic).value(t);
        const double half = (static_cast<double>(i % 2) + t) / 2;
        EXPECT_NEAR(of_fine, speed_span(drawn, i / 2, CurveEnds::periodic).value(half), 1e-14) << i;
      }
    }
  }
}

TEST(SpeedProfile, APeriodicCurveRestsWhereThreeValuesInARowAreZeroAlsoAcrossItsSeam) {
  const std::vector<double> across = {0, 0, 5, 5, 5, 0, 0};
  const std::vector<double> two = {0, 0, 5, 5, 5, 5, 0};
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(is_rest(across, i, CurveEnds::periodic), across[i] == 0) << i;
    EXPECT_FALSE(is_rest(two, i, CurveEnds::periodic)) << i;
    EXPECT_EQ(is_rest(two, i), i <= 1) << "with natural ends " << i;
  }
}

TEST(SpeedProfile, OneRaisedValueGivesTheBellThatPaperAndPencilGive) {
  // phi = 6 t - 2 t^3 up to the middle, and its mirror image after it.
  const DrawnCurve curve({0, 6, 0});
  EXPECT_EQ(curve->span_count(), 2);
  EXPECT_EQ(curve->value(0), 0);
  EXPECT_DOUBLE_EQ(curve->value(0.5), 2.75);
  EXPECT_DOUBLE_EQ(curve->value(1), 4);
  EXPECT_DOUBLE_EQ(curve->value(1.5), 2.75);
  EXPECT_EQ(curve->value(2), 0);
  EXPECT_DOUBLE_EQ(curve->derivative(0), 6);
  EXPECT_DOUBLE_EQ(curve->derivative(0.5), 4.5);
  EXPECT_NEAR(curve->derivative(1), 0, 1e-14);
  EXPECT_DOUBLE_EQ(curve->derivative(2), -6);
  EXPECT_DOUBLE_EQ(curve->second(0.5), -6);
  EXPECT_DOUBLE_EQ(curve->second(1), -12);
  EXPECT_DOUBLE_EQ(curve->integral(0.5), 0.71875);
  EXPECT_DOUBLE_EQ(curve->integral(1), 2.5);
  EXPECT_DOUBLE_EQ(curve->integral(1.5), 4.28125);
  EXPECT_DOUBLE_EQ(curve->integral(2), 5);
  EXPECT_DOUBLE_EQ(curve->total_integral(), 5);
}

TEST(SpeedProfile, TheFirstSpanIsTheStatedMeanOfThreeValues) {
  const DrawnCurve curve({7, 1, 30, 2});
  for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const double cube = t * t * t / 6;
    EXPECT_DOUBLE_EQ(curve->value(t), (1 - t + cube) * 7 + (t - 2 * cube) * 1 + cube * 30) << t;
  }
}

TEST(SpeedProfile, AnInnerKnotIsASixthFourSixthsASixth) {
  const DrawnCurve curve({3, 9, 30, 6, 12});
  EXPECT_DOUBLE_EQ(curve->value(1), (3 + 4 * 9 + 30) / 6.0);
  EXPECT_DOUBLE_EQ(curve->value(2), (9 + 4 * 30 + 6) / 6.0);
  EXPECT_DOUBLE_EQ(curve->value(3), (30 + 4 * 6 + 12) / 6.0);
}

TEST(SpeedProfile, BeginsAndEndsOnItsControlValuesToTheLastBit) {
  const std::vector<double> values{0.1, 33.3, 0.7, 99.9, 12.3};
  const DrawnCurve curve(values);
  EXPECT_EQ(curve->value(0), values.front());
  EXPECT_EQ(curve->value(4), values.back());
}

TEST(SpeedProfile, HasNaturalEnds) {
  const DrawnCurve curve({10, 2, 30, 4, 50});
  const double rounding = 400 * std::numeric_limits<double>::epsilon();
  EXPECT_NEAR(curve->second(0), 0, rounding);
  EXPECT_NEAR(curve->second(4), 0, rounding);
}

TEST(SpeedProfile, OneValueMeansTwoEqualOnes) {
  const DrawnCurve one({2.5});
  const DrawnCurve two({2.5, 2.5});
  EXPECT_EQ(one->span_count(), 1);
  EXPECT_EQ(two->span_count(), 1);
  for (const double a : {0.0, 0.375, 1.0}) {
    EXPECT_EQ(one->value(a), two->value(a));
    EXPECT_NEAR(one->value(a), 2.5, 4 * std::numeric_limits<double>::epsilon());
    EXPECT_EQ(one->integral(a), two->integral(a));
    EXPECT_NEAR(one->derivative(a), 0, 32 * std::numeric_limits<double>::epsilon());
  }
  EXPECT_NEAR(one->total_integral(), 2.5, 4 * std::numeric_limits<double>::epsilon());
}

TEST(SpeedProfile, TwoValuesAreAStraightLine) {
  const DrawnCurve curve({10, 30});
  EXPECT_EQ(curve->span_count(), 1);
  for (const double a : {0.0, 0.125, 0.5, 0.9, 1.0}) {
    EXPECT_DOUBLE_EQ(curve->value(a), 10 + 20 * a);
    EXPECT_NEAR(curve->derivative(a), 20, 1e-13);
    EXPECT_NEAR(curve->second(a), 0, 1e-13);
    EXPECT_NEAR(curve->integral(a), 10 * a + 10 * a * a, 1e-14);
  }
}

TEST(SpeedProfile, FourZerosInARowAreADwell) {
  const DrawnCurve curve({8, 0, 0, 0, 0, 8});
  for (const double a : {2.0, 2.3, 2.5, 3.0}) EXPECT_EQ(curve->value(a), 0) << a;
  EXPECT_EQ(curve->integral(2), curve->integral(3));
  EXPECT_GT(curve->value(1.9), 0);
  EXPECT_GT(curve->value(3.1), 0);
}

TEST(SpeedProfile, TwoZerosAtAnEndStartFromRestWithoutAcceleration) {
  const DrawnCurve curve({0, 0, 10, 10});
  EXPECT_EQ(curve->value(0), 0);
  EXPECT_EQ(curve->derivative(0), 0);
}

// --- what is refused

void expect_refused(const Status& status, ErrorCode code, std::int32_t control_value, const char* word) {
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, code);
  EXPECT_EQ(status.error().control_value, control_value);
  EXPECT_THAT(status.error().what, HasSubstr(word));
  EXPECT_STRNE(status.error().remedy, "");
}

TEST(SpeedProfile, NamesTheControlValueThatIsNotOne) {
  struct Case {
    double value;
    ErrorCode code;
    const char* word;
  };
  const Case cases[] = {
      {std::numeric_limits<double>::quiet_NaN(), ErrorCode::not_finite, "finite"},
      {std::numeric_limits<double>::infinity(), ErrorCode::not_finite, "finite"},
      {-std::numeric_limits<double>::infinity(), ErrorCode::not_finite, "finite"},
      {-std::numeric_limits<double>::denorm_min(), ErrorCode::out_of_range, "negative"},
      {std::nextafter(100.0, 200.0), ErrorCode::out_of_range, "above 100"},
      {std::numeric_limits<double>::max(), ErrorCode::out_of_range, "above 100"},
  };
  for (const Case& each : cases) {
    for (const std::int32_t index : {0, 1, 3}) {
      std::vector<double> values{1, 0, 100, 50};
      EXPECT_TRUE(DrawnCurve(values).result()) << "0 and 100 are allowed";
      values[static_cast<std::size_t>(index)] = each.value;
      const DrawnCurve curve(values);
      ASSERT_FALSE(curve.result());
      expect_refused(curve.result().error(), each.code, index, each.word);
    }
  }
}

TEST(SpeedProfile, NeedsAtLeastOneControlValue) {
  const DrawnCurve curve({});
  ASSERT_FALSE(curve.result());
  EXPECT_EQ(curve.result().error().code, ErrorCode::wrong_count);
}

TEST(SpeedProfile, StatesTheCapacityNeededWhichSuffices) {
  const std::vector<double> values{1, 2, 3, 4, 5};
  SpeedProfileStorage<4> small;
  const auto refused = SpeedProfile::make(values, small.memory());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::capacity);
  ASSERT_EQ(refused.error().needed, 5);
  SpeedProfileStorage<5> enough;
  EXPECT_TRUE(SpeedProfile::make(values, enough.memory()));
  SpeedProfileStorage<1> one;
  EXPECT_TRUE(SpeedProfile::make(std::vector<double>{1}, one.memory()));
}

TEST(SpeedProfile, RefusesMemoryThatIsShortInEitherPart) {
  const std::vector<double> values{1, 2, 3};
  std::array<SpeedSpan, 2> spans;
  std::array<TwoSum, 3> integrals;
  const std::span all_spans(spans);
  const std::span all_integrals(integrals);
  EXPECT_TRUE(SpeedProfile::make(values, {all_spans, all_integrals}));
  EXPECT_FALSE(SpeedProfile::make(values, {all_spans.first(1), all_integrals}));
  EXPECT_FALSE(SpeedProfile::make(values, {all_spans, all_integrals.first(2)}));
}

}  // namespace speed_profile_test
}  // namespace inbetween
