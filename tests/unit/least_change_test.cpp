#include "host_tools/least_change.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace inbetween {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;

const std::vector<double> round = {1, 0, 0, 1};
const std::vector<double> oblong = {4, 1, 1, 2};

auto near(double value) {
  return DoubleNear(value, 1e-12);
}

TEST(LeastChange, WithoutConditionsTheTargetIsTheAnswer) {
  EXPECT_THAT(LeastChange(oblong, std::vector<double>{3, -4}).x(), ElementsAre(3, -4));
}

TEST(LeastChange, AnInequalityThatHoldsChangesNothingAndOneThatDoesNotIsMetExactly) {
  LeastChange nearest(round, std::vector<double>{3, 4});
  ASSERT_TRUE(nearest.add(std::vector<double>{1, 1}, 5));
  EXPECT_THAT(nearest.x(), ElementsAre(3, 4));
  ASSERT_TRUE(nearest.add(std::vector<double>{-1, 0}, -1));
  EXPECT_THAT(nearest.x(), ElementsAre(near(1), near(4)));
}

TEST(LeastChange, TheMatrixSaysWhatIsNear) {
  LeastChange nearest(oblong, std::vector<double>{0, 0});
  ASSERT_TRUE(nearest.add_equality(std::vector<double>{1, 1}, 4));
  // G x = lambda (1, 1), by hand
  EXPECT_THAT(nearest.x(), ElementsAre(near(1), near(3)));
}

TEST(LeastChange, AConditionThatIsNoLongerInTheWayIsLetGo) {
  LeastChange nearest(round, std::vector<double>{0, 0});
  ASSERT_TRUE(nearest.add(std::vector<double>{1, 0.1}, 1));
  ASSERT_TRUE(nearest.add(std::vector<double>{1, 1}, 20));
  EXPECT_THAT(nearest.x(), ElementsAre(near(10), near(10)));
}

TEST(LeastChange, WhatContradictsIsRefused) {
  LeastChange nearest(round, std::vector<double>{0, 0});
  ASSERT_TRUE(nearest.add_equality(std::vector<double>{1, 1}, 4));
  EXPECT_TRUE(nearest.add_equality(std::vector<double>{2, 2}, 8)) << "the same again";
  EXPECT_FALSE(nearest.add_equality(std::vector<double>{2, 2}, 9));
  EXPECT_FALSE(nearest.add(std::vector<double>{1, 1}, 5));
  ASSERT_TRUE(nearest.add(std::vector<double>{1, 0}, 5)) << "which does not";
  EXPECT_THAT(nearest.x(), ElementsAre(near(5), near(-1)));
}

TEST(LeastChange, AMatrixThatIsNotPositiveDefiniteIsRefused) {
  EXPECT_THROW(LeastChange(std::vector<double>{1, 2, 2, 1}, std::vector<double>{0, 0}),
               std::invalid_argument);
}

}  // namespace
}  // namespace inbetween
