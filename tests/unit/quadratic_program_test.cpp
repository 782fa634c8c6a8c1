#include "host_tools/fit/quadratic_program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace inbetween {
namespace quadratic_program_test {

using testing::DoubleNear;
using testing::ElementsAre;

const std::vector<double> round = {1, 0, 0, 1};
const std::vector<double> oblong = {4, 1, 1, 2};

auto near(double value) {
  return DoubleNear(value, 1e-12);
}

TEST(QuadraticProgram, WithoutConditionsTheTargetIsTheAnswer) {
  EXPECT_THAT(QuadraticProgram(oblong, std::vector<double>{3, -4}).x(), ElementsAre(3, -4));
}

TEST(QuadraticProgram, AnInequalityThatHoldsChangesNothingAndOneThatDoesNotIsMetExactly) {
  QuadraticProgram nearest(round, std::vector<double>{3, 4});
  ASSERT_TRUE(nearest.add(std::vector<double>{1, 1}, 5));
  EXPECT_THAT(nearest.x(), ElementsAre(3, 4));
  ASSERT_TRUE(nearest.add(std::vector<double>{-1, 0}, -1));
  EXPECT_THAT(nearest.x(), ElementsAre(near(1), near(4)));
}

TEST(QuadraticProgram, TheMatrixSaysWhatIsNear) {
  QuadraticProgram nearest(oblong, std::vector<double>{0, 0});
  ASSERT_TRUE(nearest.add_equality(std::vector<double>{1, 1}, 4));
  // G x = lambda (1, 1), by hand
  EXPECT_THAT(nearest.x(), ElementsAre(near(1), near(3)));
}

TEST(QuadraticProgram, AConditionThatIsNoLongerInTheWayIsLetGo) {
  QuadraticProgram nearest(round, std::vector<double>{0, 0});
  ASSERT_TRUE(nearest.add(std::vector<double>{1, 0.1}, 1));
  ASSERT_TRUE(nearest.add(std::vector<double>{1, 1}, 20));
  EXPECT_THAT(nearest.x(), ElementsAre(near(10), near(10)));
}

TEST(QuadraticProgram, WhatContradictsIsRefused) {
  QuadraticProgram nearest(round, std::vector<double>{0, 0});
  ASSERT_TRUE(nearest.add_equality(std::vector<double>{1, 1}, 4));
  EXPECT_TRUE(nearest.add_equality(std::vector<double>{2, 2}, 8)) << "the same again";
  EXPECT_FALSE(nearest.add_equality(std::vector<double>{2, 2}, 9));
  EXPECT_FALSE(nearest.add(std::vector<double>{1, 1}, 5));
  ASSERT_TRUE(nearest.add(std::vector<double>{1, 0}, 5)) << "which does not";
  EXPECT_THAT(nearest.x(), ElementsAre(near(5), near(-1)));
}

TEST(QuadraticProgram, AMatrixThatIsNotPositiveDefiniteIsRefused) {
  EXPECT_THROW(QuadraticProgram(std::vector<double>{1, 2, 2, 1}, std::vector<double>{0, 0}),
               std::invalid_argument);
}

}  // namespace quadratic_program_test
}  // namespace inbetween
