#include "inbetween/base/result.hpp"

#include <gtest/gtest.h>

#include <type_traits>

namespace inbetween {
namespace result_test {

constexpr Error no_room{.code = ErrorCode::capacity, .what = "full", .remedy = "make room", .needed = 7};

TEST(Result, HoldsTheValueItWasMadeFrom) {
  Result<double> result = 2.5;
  EXPECT_TRUE(result.has_value());
  EXPECT_TRUE(static_cast<bool>(result));
  EXPECT_EQ(result.value(), 2.5);
  *result = 3.5;
  EXPECT_EQ(*result, 3.5);
  result.value() = 4.5;
  EXPECT_EQ(*result, 4.5);
}

TEST(Result, ReachesTheMembersOfItsValue) {
  struct Pair {
    int first, second;
  };
  Result<Pair> result = Pair{1, 2};
  result->second = 5;
  const Result<Pair>& unchangeable = result;
  EXPECT_EQ(unchangeable->first, 1);
  EXPECT_EQ(unchangeable->second, 5);
}

TEST(Result, HoldsTheErrorWordForWord) {
  const Result<double> result = no_room;
  EXPECT_FALSE(result.has_value());
  EXPECT_FALSE(static_cast<bool>(result));
  EXPECT_EQ(result.error().code, ErrorCode::capacity);
  EXPECT_STREQ(result.error().what, "full");
  EXPECT_STREQ(result.error().remedy, "make room");
  EXPECT_EQ(result.error().needed, 7);
}

TEST(Result, APlaceThatDoesNotApplyIsMinusOne) {
  const Error error;
  EXPECT_EQ(error.key, -1);
  EXPECT_EQ(error.axis, -1);
  EXPECT_EQ(error.control_value, -1);
  EXPECT_EQ(error.frame, -1);
  EXPECT_EQ(error.needed, -1);
}

TEST(Result, ACopyIsIndependent) {
  const Result<int> original = 1;
  Result<int> copy = original;
  *copy = 2;
  EXPECT_EQ(*original, 1);
  copy = Result<int>(no_room);
  EXPECT_FALSE(copy);
  EXPECT_TRUE(original);
}

TEST(Result, AnActionIsDoneOrAnError) {
  const Status done = Done{};
  const Status refused = no_room;
  EXPECT_TRUE(done);
  EXPECT_FALSE(refused);
}

TEST(Result, WorksWhileTheProgramIsCompiled) {
  constexpr Result<int> value = 3;
  constexpr Result<int> error = no_room;
  static_assert(*value == 3);
  static_assert(error.error().needed == 7);
  static_assert(std::is_trivially_destructible_v<Result<int>>);
}

TEST(ResultDeathTest, AskingAnErrorForItsValueEndsTheProgram) {
  Result<int> error = no_room;
  const Result<int>& unchangeable = error;
  EXPECT_DEATH(static_cast<void>(error.value()), "");
  EXPECT_DEATH(static_cast<void>(unchangeable.value()), "");
  EXPECT_DEATH(static_cast<void>(*unchangeable), "");
}

TEST(ResultDeathTest, AskingAValueForItsErrorEndsTheProgram) {
  const Result<int> value = 3;
  EXPECT_DEATH(static_cast<void>(value.error()), "");
}

}  // namespace result_test
}  // namespace inbetween
