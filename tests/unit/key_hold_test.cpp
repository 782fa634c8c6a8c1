// Whether a key of a terminal is pressed once or held.
#include "host_tools/loop/key_hold.hpp"

#include <gtest/gtest.h>

namespace inbetween {
namespace key_hold_test {

constexpr std::int64_t ms = 1'000'000;

TEST(KeyHold, APressCountsOnceNoOtherHasFollowedIt) {
  KeyHold keys;
  keys.press(1, 0);
  EXPECT_EQ(keys.take_press(149 * ms), 0);
  EXPECT_EQ(keys.take_press(150 * ms), 1);
  EXPECT_EQ(keys.pressed_ns(), 0);
  EXPECT_EQ(keys.take_press(151 * ms), 0) << "once";
  EXPECT_EQ(keys.held(151 * ms), 0);
}

TEST(KeyHold, TwoRepeatsAtTheRateOfAKeyboardAreAHoldUntilSilence) {
  for (const int period : {10, 17, 33, 92, 120}) {
    KeyHold keys;
    keys.press(-1, 0);
    EXPECT_EQ(keys.take_press(200 * ms), -1);
    const std::int64_t first = 400 * ms;  // which could be another press
    keys.press(-1, first);
    keys.press(-1, first + period * ms);
    EXPECT_EQ(keys.held(first + period * ms), 0);
    const std::int64_t last = first + 2 * period * ms;
    keys.press(-1, last);
    EXPECT_EQ(keys.held(last), -1) << period;
    EXPECT_EQ(keys.held(last + 149 * ms), -1);
    EXPECT_EQ(keys.held(last + 150 * ms), 0);
    EXPECT_EQ(keys.take_press(last + 300 * ms), 0) << "and none of them is a press";
  }
}

TEST(KeyHold, SomebodyWhoTypesQuicklyHoldsNothing) {
  KeyHold keys;
  for (int i = 0; i < 20; ++i) {
    keys.press(1, i * 125 * ms);
    EXPECT_EQ(keys.held(i * 125 * ms), 0) << i;
  }
}

TEST(KeyHold, ALineThatGathersAFewKeysIsNoHindranceAndOneThatGathersManyIs) {
  KeyHold few, many;
  for (int i = 0; i < 20; ++i) {
    for (int key = 0; key < 3; ++key) few.press(1, i * 100 * ms);
    for (int key = 0; key < 14; ++key) many.press(1, i * 100 * ms);
  }
  EXPECT_EQ(few.held(1900 * ms), 1);
  EXPECT_FALSE(few.is_refused());
  EXPECT_EQ(many.held(1900 * ms), 0);
  EXPECT_TRUE(many.is_refused());
  EXPECT_EQ(many.take_press(2500 * ms), 0);
  many.press(1, 2500 * ms);
  EXPECT_EQ(many.take_press(2650 * ms), 1) << "after silence";
}

TEST(KeyHold, FourKeysMayComeAtOnceAndAnotherEveryTenMilliseconds) {
  // The machine has been on for an hour, which allows no more of them.
  const std::int64_t first = 3'600'000 * ms;
  KeyHold keys;
  for (int key = 0; key < 4; ++key) keys.press(1, first);
  EXPECT_FALSE(keys.is_refused());
  keys.press(1, first + 10 * ms);
  EXPECT_FALSE(keys.is_refused());
  keys.press(1, first + 10 * ms);
  EXPECT_TRUE(keys.is_refused());
}

TEST(KeyHold, WithReleasesAPressCountsAtOnceAndAReleaseEndsIt) {
  KeyHold keys;
  keys.tells_releases();
  keys.press(1, 0);
  EXPECT_EQ(keys.take_press(0), 1);
  for (int i = 0; i < 3; ++i) keys.repeat(1, (500 + 33 * i) * ms);
  EXPECT_EQ(keys.held(570 * ms), 1);
  keys.release();
  EXPECT_EQ(keys.held(570 * ms), 0);
  for (int i = 0; i < 9; ++i) keys.repeat(1, (600 + 33 * i) * ms);
  EXPECT_EQ(keys.held(864 * ms), 0) << "it must be pressed";
  keys.press(1, 900 * ms);
  keys.press(1, 910 * ms);
  EXPECT_EQ(keys.take_press(910 * ms), 1) << "quickly pressed twice is pressed";
}

TEST(KeyHold, WithReleasesSilenceEndsItUntilItIsPressedAnew) {
  KeyHold keys;
  keys.tells_releases();
  keys.press(1, 0);
  for (int i = 0; i < 9; ++i) keys.repeat(1, (500 + 33 * i) * ms);
  EXPECT_EQ(keys.held(764 * ms + 149 * ms), 1);
  EXPECT_EQ(keys.held(764 * ms + 150 * ms), 0);
  for (int i = 0; i < 9; ++i) keys.repeat(1, (1000 + 33 * i) * ms);
  EXPECT_EQ(keys.held(1264 * ms), 0);
}

TEST(KeyHold, ASecondDirectionOrAnotherKeyEndsIt) {
  for (const bool tells : {false, true}) {
    for (const bool is_other_direction : {false, true}) {
      KeyHold keys;
      if (tells) keys.tells_releases();
      keys.press(1, 0);
      for (int i = 0; i < 9; ++i) keys.repeat(1, (500 + 33 * i) * ms);
      ASSERT_EQ(keys.held(764 * ms), 1);
      is_other_direction ? keys.repeat(-1, 770 * ms) : keys.forget();
      EXPECT_EQ(keys.held(770 * ms), 0);
      for (int i = 0; i < 9; ++i) keys.repeat(1, (797 + 33 * i) * ms);
      EXPECT_EQ(keys.held(1061 * ms), 0) << "as long as it is held";
      EXPECT_TRUE(keys.is_refused());
    }
  }
}

TEST(KeyHold, OfADeviceIsHeldAtOnceAndForAsLongAsThatIsTold) {
  KeyHold keys;
  keys.hold(-1, 0);
  EXPECT_EQ(keys.held(0), -1);
  keys.hear(100 * ms);
  EXPECT_EQ(keys.held(249 * ms), -1);
  EXPECT_EQ(keys.held(250 * ms), 0);
  keys.hear(260 * ms);
  EXPECT_EQ(keys.held(260 * ms), 0) << "it must be pressed anew";
  EXPECT_EQ(keys.take_press(900 * ms), 0);
  keys.hold(1, 1000 * ms);
  keys.release();
  EXPECT_EQ(keys.held(1000 * ms), 0);
  keys.hear(1100 * ms);
  keys.press(1, 1200 * ms);
  EXPECT_EQ(keys.take_press(1350 * ms), 1) << "which nothing was held before";
}

}  // namespace key_hold_test
}  // namespace inbetween
