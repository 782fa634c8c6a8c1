#include "inbetween/base/fixed_vector.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <initializer_list>
#include <span>

namespace inbetween {
namespace fixed_vector_test {

using testing::ElementsAre;
using testing::IsEmpty;

FixedVector<int, 4> vector_of(std::initializer_list<int> values) {
  FixedVector<int, 4> result;
  for (const int value : values) EXPECT_TRUE(result.push_back(value));
  return result;
}

TEST(FixedVector, IsEmptyAtFirst) {
  const FixedVector<int, 4> vector;
  EXPECT_TRUE(vector.empty());
  EXPECT_EQ(vector.size(), 0U);
  EXPECT_EQ(vector.capacity(), 4U);
  EXPECT_THAT(vector, IsEmpty());
}

TEST(FixedVector, KeepsWhatIsPushedInOrder) {
  FixedVector<int, 4> vector = vector_of({3, 1, 2});
  EXPECT_THAT(vector, ElementsAre(3, 1, 2));
  EXPECT_FALSE(vector.empty());
  vector[1] = 7;
  const std::span<const int> seen = vector;
  EXPECT_THAT(seen, ElementsAre(3, 7, 2));
  EXPECT_THAT(vector.span(), ElementsAre(3, 7, 2));
}

TEST(FixedVector, InsertsAtTheFrontInTheMiddleAndAtTheEnd) {
  FixedVector<int, 4> vector = vector_of({5});
  EXPECT_TRUE(vector.insert(0, 1));
  EXPECT_THAT(vector, ElementsAre(1, 5));
  EXPECT_TRUE(vector.insert(1, 3));
  EXPECT_THAT(vector, ElementsAre(1, 3, 5));
  EXPECT_TRUE(vector.insert(3, 9));
  EXPECT_THAT(vector, ElementsAre(1, 3, 5, 9));
}

TEST(FixedVector, InsertsACopyOfOneOfItsOwnValues) {
  FixedVector<int, 4> vector = vector_of({1, 2, 3});
  EXPECT_TRUE(vector.insert(0, vector[2]));
  EXPECT_THAT(vector, ElementsAre(3, 1, 2, 3));
}

TEST(FixedVector, ErasesAtTheFrontInTheMiddleAndAtTheEnd) {
  FixedVector<int, 4> vector = vector_of({1, 3, 5, 9});
  EXPECT_TRUE(vector.erase(1));
  EXPECT_THAT(vector, ElementsAre(1, 5, 9));
  EXPECT_TRUE(vector.erase(2));
  EXPECT_THAT(vector, ElementsAre(1, 5));
  EXPECT_TRUE(vector.erase(0));
  EXPECT_THAT(vector, ElementsAre(5));
  EXPECT_TRUE(vector.erase(0));
  EXPECT_THAT(vector, IsEmpty());
}

TEST(FixedVector, WhenFullStatesTheCapacityNeededAndKeepsItsValues) {
  FixedVector<int, 4> vector = vector_of({1, 2, 3, 4});
  for (const Status& status : {vector.push_back(5), vector.insert(0, 5)}) {
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::capacity);
    EXPECT_EQ(status.error().needed, 5);
  }
  EXPECT_THAT(vector, ElementsAre(1, 2, 3, 4));
}

TEST(FixedVector, RefusesToInsertBehindItsEnd) {
  FixedVector<int, 4> vector = vector_of({1, 2});
  const Status status = vector.insert(3, 5);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::out_of_range);
  EXPECT_THAT(vector, ElementsAre(1, 2));
}

TEST(FixedVector, RefusesToEraseWhatIsNotThere) {
  FixedVector<int, 4> vector = vector_of({1, 2});
  const Status status = vector.erase(2);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::out_of_range);
  EXPECT_THAT(vector, ElementsAre(1, 2));
  vector.clear();
  EXPECT_FALSE(vector.erase(0));
}

TEST(FixedVector, CanBeFilledAgainAfterItWasCleared) {
  FixedVector<int, 4> vector = vector_of({1, 2, 3, 4});
  vector.clear();
  EXPECT_THAT(vector, IsEmpty());
  EXPECT_TRUE(vector.push_back(8));
  EXPECT_THAT(vector, ElementsAre(8));
}

TEST(FixedVectorDeathTest, IndexingOutsideEndsTheProgram) {
  FixedVector<int, 4> vector = vector_of({1, 2});
  const FixedVector<int, 4>& unchangeable = vector;
  EXPECT_DEATH(vector[2] = 0, "");
  EXPECT_DEATH(static_cast<void>(unchangeable[2]), "");
}

}  // namespace fixed_vector_test
}  // namespace inbetween
