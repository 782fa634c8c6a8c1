// The identifier of a CAN frame: an illegal one cannot be made.
#include "inbetween/can/frame_id.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "inbetween/can/frame.hpp"

namespace inbetween {
namespace frame_id_test {

using can::Frame;
using can::FrameId;

static_assert(sizeof(FrameId) == 4 && sizeof(Frame) == 16, "it costs a frame nothing");

TEST(FrameId, NumbersBeyondTheirKindAreRefused) {
  for (const bool is_extended : {false, true}) {
    const std::uint32_t most = is_extended ? 0x1FFF'FFFFU : 0x7FFU;
    for (const std::uint32_t number : {0U, 1U, most}) {
      const auto id = FrameId::make(number, is_extended);
      ASSERT_TRUE(id) << number;
      EXPECT_EQ(id->number(), number);
      EXPECT_EQ(id->is_extended(), is_extended);
    }
    for (const std::uint32_t number : {most + 1, 0x8000'0000U, 0xFFFF'FFFFU}) {
      const auto id = FrameId::make(number, is_extended);
      ASSERT_FALSE(id) << number;
      EXPECT_EQ(id.error().code, ErrorCode::out_of_range);
    }
  }
}

TEST(FrameId, TheSameNumberOf11AndOf29BitsAreTwo) {
  EXPECT_EQ(FrameId(0x123), FrameId::standard(0x123));
  EXPECT_FALSE(FrameId(0x123) == FrameId::extended(0x123));
  EXPECT_EQ(FrameId(), FrameId(0));
}

TEST(FrameId, TheShortestHas11BitsWhereTheNumberHas) {
  EXPECT_EQ(FrameId::shortest(0x7FF), FrameId(0x7FF));
  EXPECT_EQ(FrameId::shortest(0x800), FrameId::extended(0x800));
}

TEST(FrameIdDeathTest, OneThatCannotBeEndsTheProgram) {
  volatile std::uint32_t number = 0x800;
  EXPECT_DEATH(static_cast<void>(FrameId::standard(number)), "");
  number = 0x2000'0000;
  EXPECT_DEATH(static_cast<void>(FrameId::extended(number)), "");
}

}  // namespace frame_id_test
}  // namespace inbetween
