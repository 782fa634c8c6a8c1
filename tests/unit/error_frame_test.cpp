#include "drivers/can/error_frame.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>

namespace inbetween::can {
namespace error_frame_test {

// The numbers are those of linux/can/error.h, written out: the test does not include it.
constexpr std::uint32_t error_flag = 0x20000000;

ErrorFrame decoded(std::uint32_t error_class, std::uint8_t controller = 0) {
  return decode_error_frame(error_flag | error_class, {0, controller, 0, 0, 0, 0, 0, 0});
}

TEST(ErrorFrame, EveryClassThatSomebodyActsOnHasItsOwnName) {
  EXPECT_EQ(decoded(0), ErrorFrame{});
  EXPECT_EQ(decoded(0x001), ErrorFrame{}) << "only counted";
  EXPECT_EQ(decoded(0x002), ErrorFrame{}) << "only counted";
  EXPECT_EQ(decoded(0x008), ErrorFrame{}) << "only counted";
  EXPECT_EQ(decoded(0x010), ErrorFrame{}) << "only counted";
  EXPECT_EQ(decoded(0x020), ErrorFrame{.is_unacknowledged = true});
  EXPECT_EQ(decoded(0x040), ErrorFrame{.is_bus_off = true});
  EXPECT_EQ(decoded(0x080), ErrorFrame{}) << "only counted";
  EXPECT_EQ(decoded(0x100), ErrorFrame{.is_restarted = true});
}

TEST(ErrorFrame, TheControllerTellsItsState) {
  EXPECT_EQ(decoded(0x004, 0x01), ErrorFrame{.is_receive_overflow = true});
  EXPECT_EQ(decoded(0x004, 0x02), ErrorFrame{.is_transmit_overflow = true});
  for (const std::uint8_t warning : std::array<std::uint8_t, 2>{0x04, 0x08})
    EXPECT_EQ(decoded(0x004, warning), ErrorFrame{.is_warning = true});
  for (const std::uint8_t passive : std::array<std::uint8_t, 2>{0x10, 0x20})
    EXPECT_EQ(decoded(0x004, passive), ErrorFrame{.is_passive = true});
  EXPECT_EQ(decoded(0x004, 0x40), ErrorFrame{.is_active = true});
  EXPECT_EQ(decoded(0x004, 0x00), ErrorFrame{});
}

TEST(ErrorFrame, TheSecondByteCountsOnlyWhereTheControllerIsTheMatter) {
  EXPECT_EQ(decoded(0x020, 0xFF), ErrorFrame{.is_unacknowledged = true});
}

TEST(ErrorFrame, OneFrameMaySaySeveralThings) {
  EXPECT_EQ(decoded(0x044, 0x20), (ErrorFrame{.is_passive = true, .is_bus_off = true}));
}

}  // namespace error_frame_test
}  // namespace inbetween::can
