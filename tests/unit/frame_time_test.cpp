#include "inbetween/timing/frame_time.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace inbetween {
namespace frame_time_test {

constexpr FrameRate film{24, 1};
constexpr FrameRate ntsc_film{24000, 1001};

TEST(FrameTime, FramesPerSecondIsTheFraction) {
  EXPECT_EQ(film.frames_per_second(), 24.0);
  EXPECT_EQ(ntsc_film.frames_per_second(), 24000.0 / 1001.0);
}

TEST(FrameTime, TickZeroIsFrameZero) {
  const auto time = frame_time_of_tick(0, film, 250);
  EXPECT_EQ(time.frame, 0);
  EXPECT_EQ(time.fraction, 0.0);
}

TEST(FrameTime, TheThirdTickOfTenAFrameStandsAtThreeTenths) {
  const auto time = frame_time_of_tick(73, {25, 1}, 250);
  EXPECT_EQ(time.frame, 7);
  EXPECT_EQ(time.fraction, 0.3);
}

TEST(FrameTime, SeveralFramesPassWithinATickThatIsSlowerThanTheFrames) {
  const auto time = frame_time_of_tick(3, {60, 1}, 8);
  EXPECT_EQ(time.frame, 22);
  EXPECT_EQ(time.fraction, 0.5);
}

/// At 250 Hz a tick is 24000 / 1001 / 250 = 96 / 1001 frames.
template <class Real>
void expect_exact_phase(std::int64_t tick) {
  const auto time = frame_time_of_tick<Real>(tick, ntsc_film, 250);
  ASSERT_EQ(time.frame, tick * 96 / 1001) << tick;
  ASSERT_EQ(time.fraction, static_cast<Real>(tick * 96 % 1001) / Real(1001)) << tick;
}

TEST(FrameTime, ABillionTicksAt24000Over1001LoseNoDigit) {
  constexpr std::int64_t billion = 1'000'000'000;
  for (std::int64_t tick = 0; tick <= billion; tick += 997) {
    ASSERT_NO_FATAL_FAILURE(expect_exact_phase<double>(tick));
    ASSERT_NO_FATAL_FAILURE(expect_exact_phase<float>(tick));
  }
  for (std::int64_t tick = billion - 2002; tick <= billion; ++tick) {
    ASSERT_NO_FATAL_FAILURE(expect_exact_phase<double>(tick));
    ASSERT_NO_FATAL_FAILURE(expect_exact_phase<float>(tick));
  }
}

TEST(FrameTime, Every1001TicksAreExactly96Frames) {
  for (std::int64_t times = 0; times <= 999'000; times += 37) {
    const auto time = frame_time_of_tick<float>(times * 1001, ntsc_film, 250);
    ASSERT_EQ(time.frame, times * 96);
    ASSERT_EQ(time.fraction, 0.0F);
  }
}

TEST(LastTick, IsOnTheEndWhereTheTicksMeetIt) {
  EXPECT_EQ(last_tick(240, film, 250), 2500);
  EXPECT_EQ(last_tick(240, film, 1000), 10'000);
}

TEST(LastTick, IsTheFirstAfterTheEndWhereTheTicksMissIt) {
  EXPECT_EQ(last_tick(240, ntsc_film, 250), 2503);               // 10.01 s are 2502.5 ticks
  EXPECT_EQ(last_tick(1, film, 250), 11);                        // 10.4 ticks
  EXPECT_EQ(last_tick(1'000'000, ntsc_film, 1000), 41'708'334);  // 41708333.3 ticks
}

TEST(LastTick, IsTheFirstTickAtOrAfterTheLastFrame) {
  for (const FrameRate fps :
       {film, ntsc_film, FrameRate{30000, 1001}, FrameRate{12, 1}, FrameRate{1000, 1}}) {
    for (const std::int32_t rate : {1, 7, 250, 1000}) {
      for (std::int32_t frames = 1; frames < 100; ++frames) {
        const std::int64_t last = last_tick(frames, fps, rate);
        const auto at_last = frame_time_of_tick(last, fps, rate);
        const auto before = frame_time_of_tick(last - 1, fps, rate);
        EXPECT_GE(at_last.frame, frames);
        EXPECT_LT(before.frame, frames) << "a tick earlier would do";
      }
    }
  }
}

TEST(FrameTime, IsKnownWhileTheProgramIsCompiled) {
  static_assert(last_tick(240, ntsc_film, 250) == 2503);
  static_assert(frame_time_of_tick<float>(1001, ntsc_film, 250).frame == 96);
}

}  // namespace frame_time_test
}  // namespace inbetween
