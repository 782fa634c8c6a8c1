#include "inbetween/loop/tick_chain.hpp"

#include <gtest/gtest.h>

namespace inbetween {
namespace tick_chain_test {

TEST(TickChain, MotionsFollowEachOtherWithoutAGapHoweverTheLoopWakesUp) {
  TickChain chain(1000, 1'000'000);
  EXPECT_FALSE(chain.is_running());
  EXPECT_EQ(chain.next(5'000'000), 0);
  EXPECT_TRUE(chain.is_running());
  EXPECT_EQ(chain.start_ns(), 6'000'000);
  std::int64_t end_ns = chain.end_ns();
  for (const std::int64_t jitter_ns : {0, 400'000, -300'000, 900'000, 100'000}) {
    EXPECT_EQ(chain.next(end_ns - 1'000'000 + jitter_ns), 0);
    EXPECT_EQ(chain.start_ns(), end_ns);
    end_ns = chain.end_ns();
  }
}

TEST(TickChain, TicksThatAreNoWholeNumberOfNanosecondsDoNotAddUp) {
  // 1/600 s is 1 666 666.67 ns: counted in whole ones, a lead of a tick would be gone within 1.2 hours.
  constexpr std::int32_t rate_hz = 600;
  constexpr std::int64_t five_hours = 5 * 3600;
  TickChain chain(rate_hz, 1'666'666);
  static_cast<void>(chain.next(0));
  for (std::int64_t tick = 1; tick <= five_hours * rate_hz; ++tick) {
    ASSERT_EQ(chain.next(time_of_tick(tick, rate_hz)), 0) << "tick " << tick;
  }
  EXPECT_EQ(chain.start_ns(), 1'666'666 + five_hours * ns_per_s);
}

TEST(TickChain, TicksThatWereMissedAreLeftOutOfTheCount) {
  TickChain chain(1000, 1'000'000);
  static_cast<void>(chain.next(0));
  EXPECT_EQ(chain.next(3'000'000, 3), 0);
  EXPECT_EQ(chain.start_ns(), 4'000'000);
  EXPECT_EQ(chain.end_ns(), 5'000'000);
}

TEST(TickChain, ALoopThatComesTooLateBeginsAnewALeadLater) {
  TickChain chain(1000, 1'000'000);
  static_cast<void>(chain.next(0));
  EXPECT_EQ(chain.next(2'000'000), 0) << "at the last moment";
  EXPECT_EQ(chain.next(3'700'000), 700'000);
  EXPECT_EQ(chain.start_ns(), 4'700'000);
  EXPECT_EQ(chain.next(4'700'000), 0);
  EXPECT_EQ(chain.start_ns(), 5'700'000);
}

TEST(TickChain, AfterAnEndTheNextBeginsAtItsOwnTime) {
  TickChain chain(1000, 1'000'000);
  static_cast<void>(chain.next(0));
  chain.end();
  EXPECT_FALSE(chain.is_running());
  EXPECT_EQ(chain.next(9'000'000), 0);
  EXPECT_EQ(chain.start_ns(), 10'000'000);
  chain.begin(20'000'000);
  EXPECT_EQ(chain.start_ns(), 20'000'000);
}

}  // namespace tick_chain_test
}  // namespace inbetween
