#include "host_tools/numerics/band_program.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "tests/support/property.hpp"

namespace inbetween {
namespace band_program_test {

using Sum = std::vector<Term>;

const Sum x = {{0, 1}};
const Sum y = {{1, 1}};
const Sum both = {{0, 1}, {1, 1}};

/// Least where (x, y) is nearest to the target.
BandProgram nearest_to(double target_x, double target_y) {
  BandProgram program(2);
  program.add_cost(x, x, 1);
  program.add_cost(y, y, 1);
  program.add_gain(x, target_x);
  program.add_gain(y, target_y);
  return program;
}

bool solve(BandProgram& program) {
  return program.solve(std::vector<double>(2));
}

TEST(BandProgram, WithoutConditionsTheTargetIsTheAnswer) {
  BandProgram program = nearest_to(3, -4);
  ASSERT_TRUE(solve(program));
  EXPECT_NEAR(program.value(x), 3, 1e-12);
  EXPECT_NEAR(program.value(y), -4, 1e-12);
}

TEST(BandProgram, AnInequalityThatHoldsChangesNothingAndOneThatDoesNotIsMet) {
  BandProgram program = nearest_to(3, 4);
  program.demand_at_least(both, 4);
  program.demand_at_least(Sum{{0, -1}}, -1);
  ASSERT_TRUE(solve(program));
  EXPECT_NEAR(program.value(x), 1, 1e-9);
  EXPECT_NEAR(program.value(y), 4, 1e-9);
}

TEST(BandProgram, ASlackSaysHowFarASumIsAboveItsBoundAndIsNeverBelow0) {
  BandProgram program = nearest_to(3, -4);
  program.demand_at_least(x, 1);
  program.demand_at_least(y, 0);
  ASSERT_TRUE(solve(program));
  EXPECT_NEAR(program.slack(0), 2, 1e-9);
  EXPECT_NEAR(program.slack(1), 0, 1e-9);
  EXPECT_GE(program.slack(1), 0);
}

TEST(BandProgram, TheCostSaysWhatIsNear) {
  BandProgram program(2);
  program.add_cost(x, x, 4);
  program.add_cost(y, y, 2);
  program.add_cost(x, y, 2);  // x^T H x / 2 with H = (4 1; 1 2)
  program.demand(both, 4);
  ASSERT_TRUE(solve(program));
  // H x = lambda (1, 1), by hand
  EXPECT_NEAR(program.value(x), 1, 1e-12);
  EXPECT_NEAR(program.value(y), 3, 1e-12);
}

TEST(BandProgram, WhatContradictsIsRefused) {
  BandProgram program = nearest_to(0, 0);
  program.demand(both, 4);
  program.demand_at_least(both, 5);
  EXPECT_FALSE(solve(program));
}

TEST(BandProgram, AnEaseIsTakenWhereItIsCheaperThanTheDistance) {
  for (const double price : {1.0, 20.0}) {
    BandProgram program = nearest_to(0, 0);
    program.allow_ease(price, 0.002);
    program.demand_at_least(x, 2, true);
    ASSERT_TRUE(solve(program));
    // x of the distance costs x^2 / 2, and the rest is eased: x = price + 0.002 (2 - x)
    const double wanted = std::min(2.0, (price + 0.004) / 1.002);
    EXPECT_NEAR(program.value(x), wanted, 1e-8);
    EXPECT_NEAR(program.ease(), 2 - wanted, 1e-8);
  }
}

/// A smooth curve nearest to a drawn one and below a ceiling at many moments, as a fit asks for it. Its
/// conditions are nearly parallel, and with large factors in them rounding hides the last steps.
struct CrowdedCurve {
  CrowdedCurve(std::size_t values, double price, double factor, const auto& number)
      : program(values), start(values) {
    for (std::size_t i = 0; i < values; ++i) {
      start[i] = number(0, 3);
      const Sum one{{i, 1}};
      program.add_cost(one, one, 1);
      program.add_gain(one, number(0, 3));
      program.demand_at_least(one, 0);
    }
    program.allow_ease(price, price);
    ceiling = -factor * number(0.3, 1.2);
    constexpr int moments = 250;
    for (int k = 0; k < moments; ++k) {
      const double a = static_cast<double>(values - 3) * (k + 0.5) / moments;
      const double u = a - std::floor(a);
      const std::array weights{(1 - u) * (1 - u) * (1 - u) / 6, ((3 * u - 6) * u * u + 4) / 6,
                               (((-3 * u + 3) * u + 3) * u + 1) / 6, u * u * u / 6};
      Sum& sum = sums.emplace_back();
      for (const double weight : weights)
        sum.push_back({static_cast<std::size_t>(a) + sum.size(), -factor * weight});
      program.demand_at_least(sum, ceiling, true);
    }
  }

  BandProgram program;
  std::vector<double> start;
  std::vector<Sum> sums;
  double ceiling = 0;
};

TEST(BandProgram, ACrowdedOneHasTheSameAnswerFromEveryStart) {
  std::mt19937 random(2);
  const auto number = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 0x1p32;
  };
  for (std::size_t i = 0; i < 400; ++i) {
    const double price = std::pow(10, number(0, 5));
    const double factor = std::pow(10, number(-1, 4));
    SCOPED_TRACE(testing::Message() << "program " << i << ", price " << price << ", factor " << factor);
    CrowdedCurve curve(10 + i % 40, price, factor, number);
    BandProgram other = curve.program;
    ASSERT_TRUE(curve.program.solve(std::vector<double>(curve.start.size())));
    ASSERT_TRUE(other.solve(curve.start));
    for (std::size_t k = 0; k < curve.start.size(); ++k) {
      ASSERT_NEAR(curve.program.value(Sum{{k, 1}}), other.value(Sum{{k, 1}}), 1e-5);
    }
    for (const Sum& sum : curve.sums) {
      ASSERT_GE(curve.program.value(sum) + curve.program.ease(), curve.ceiling - 1e-9);
    }
  }
}

void expect_nearest() {
  const auto number = [](double low, double high) {
    return low + (high - low) * *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, 10001)) / 1e4;
  };
  const auto count = static_cast<std::size_t>(*rc::gen::inRange(2, 40));
  BandProgram program(count);
  std::vector<double> target(count);
  for (std::size_t i = 0; i < count; ++i) {
    target[i] = number(-3, 3);
    const Sum one{{i, 1}};
    program.add_cost(one, one, 1);
    program.add_gain(one, target[i]);
  }
  std::vector<double> inside(count);
  for (double& one : inside) one = number(-1, 1);
  struct Condition {
    Sum sum;
    double bound;
  };
  std::vector<Condition> conditions;
  for (int i = *rc::gen::inRange(1, 60); i > 0; --i) {
    const auto first = static_cast<std::size_t>(*rc::gen::inRange<int>(0, static_cast<int>(count) - 1));
    const Sum sum{{first, number(-1, 1)}, {first + 1, number(-1, 1)}};
    double bound = -number(0, 1);
    for (const Term& term : sum) bound += term.weight * inside[term.unknown];
    conditions.push_back({sum, bound});
    program.demand_at_least(sum, bound);
  }
  RC_ASSERT(program.solve(std::vector<double>(count)));
  std::vector<double> answer;
  for (std::size_t i = 0; i < count; ++i) answer.push_back(program.value(Sum{{i, 1}}));
  const auto value = [](const Sum& sum, const std::vector<double>& at) {
    double result = 0;
    for (const Term& term : sum) result += term.weight * at[term.unknown];
    return result;
  };
  for (const Condition& condition : conditions)
    RC_ASSERT(value(condition.sum, answer) >= condition.bound - 1e-9);
  // The nearest point of a convex set: the way to any other point of it leads away from the target.
  for (int i = 0; i < 50; ++i) {
    std::vector<double> other = inside;
    for (double& one : other) one += number(-2, 2);
    bool keeps_all = true;
    for (const Condition& condition : conditions) {
      keeps_all = keeps_all && value(condition.sum, other) >= condition.bound;
    }
    if (!keeps_all) other = inside;
    double leads_away = 0;
    for (std::size_t k = 0; k < count; ++k) leads_away += (answer[k] - target[k]) * (other[k] - answer[k]);
    RC_ASSERT(leads_away >= -1e-6);
  }
}

TEST(BandProgramProperty, ItIsTheNearestOfAllThatKeepTheConditions) {
  check_property(300, expect_nearest);
}

}  // namespace band_program_test
}  // namespace inbetween
