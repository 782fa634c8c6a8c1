// Lines of DFMoco: commands, what is none, and any way of cutting them.
#include "host_tools/dragonframe/dfmoco_line.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "host_tools/dragonframe/dfmoco_device.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace dfmoco_line_test {

using namespace dragonframe;
using Kind = DfmocoLine::Kind;
using Numbers = std::vector<std::int32_t>;

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

TEST(DfmocoLine, IsACommandAndWholeNumbers) {
  const DfmocoLine line = read_dfmoco_line("mm 1 -2147483648");
  EXPECT_EQ(line.kind, Kind::command);
  EXPECT_EQ(line.command, DfmocoCommand::mm);
  EXPECT_EQ(line.numbers, (Numbers{1, INT32_MIN}));
  EXPECT_EQ(read_dfmoco_line("bf  500 500 ").numbers, (Numbers{500, 500})) << "spaces are spaces";
  EXPECT_EQ(read_dfmoco_line("hi there").kind, Kind::command) << "the sketch reads nothing behind hi";
}

TEST(DfmocoLine, WhatIsNoNumberOf32BitsIsRefused) {
  for (const char* text : {"mm 1 1.5", "mm 1 +5", "mm 1 2147483648", "mm 1 x", "mm 1 5x", "mm -", "go 1x"}) {
    EXPECT_EQ(read_dfmoco_line(text).kind, Kind::malformed) << text;
  }
}

TEST(DfmocoLine, WhatIsNoCommandIsNone) {
  for (const char* text : {"", "h", "HI", "xx 1", "mmm 1 2", "goms", "mm1 2", " hi", "\t"}) {
    EXPECT_EQ(read_dfmoco_line(text).kind, Kind::unknown) << text;
  }
}

TEST(DfmocoLine, HasThirtyNineNumbersAtMost) {
  std::string text = "bf";
  for (int i = 0; i < 39; ++i) text += " 1";
  EXPECT_EQ(read_dfmoco_line(text).numbers.size(), 39U);
  EXPECT_EQ(read_dfmoco_line(text + " 1").kind, Kind::too_many_numbers);
  DfmocoDecoder decoder;
  const std::string endless = "mm 1 " + std::string(1000, '1') + "\r\n";
  auto left = bytes_of(endless);
  EXPECT_NE(decoder.next(left)->kind, Kind::command) << "what is cut off moves nothing";
}

TEST(DfmocoLine, EitherOfItsTwoEndsIsEnough) {
  DfmocoDecoder decoder;
  const std::string text = "hi\r\nms\nsa\r\r\n\n";
  auto left = bytes_of(text);
  for (const auto command : {DfmocoCommand::hi, DfmocoCommand::ms, DfmocoCommand::sa}) {
    EXPECT_EQ(decoder.next(left)->command, command);
  }
  EXPECT_FALSE(decoder.next(left));
  EXPECT_FALSE(decoder.has_half());
}

TEST(DfmocoLine, AMillionRandomBytesMoveNothing) {
  std::size_t orders = 0;
  DfmocoDevice device(8, [&](const RigOrder&) {
    ++orders;
    return RigAnswer::ok;
  });
  device.connect(0);
  ASSERT_TRUE(device.arm());
  std::mt19937 random(4);
  for (int block = 0; block < 1000; ++block) {
    std::vector<std::uint8_t> bytes(1000);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    device.hear(bytes, block);
  }
  EXPECT_EQ(orders, 0U);
  EXPECT_TRUE(device.is_armed());
  EXPECT_GT(device.counters().unknown, 1000U);
}

TEST(DfmocoLineProperty, ASessionIsTheSameHoweverItIsCut) {
  const std::string session =
      "hi\r\npr 1 70000\r\nmm 1 250\r\nms\r\nsm 1\r\nxx\r\nmm 9 1\r\nnp 2 500\r\nzm 2\r\njm 2 1000 "
      "5000\r\nsa\r\n";
  const auto answers = [&](const std::vector<std::size_t>& pieces) {
    DfmocoDevice device(4, [](const RigOrder&) { return RigAnswer::ok; });
    device.connect(0);
    device.arm();
    auto left = bytes_of(session);
    for (const std::size_t piece : pieces) {
      const std::size_t taken = std::min(piece, left.size());
      device.hear(left.first(taken), 1);
      left = left.subspan(taken);
    }
    device.hear(left, 1);
    return device.take_text();
  };
  const std::string whole = answers({});
  EXPECT_NE(whole.find("pr 1 20000\r\n"), std::string::npos);
  for (std::size_t cut = 0; cut <= session.size(); ++cut) EXPECT_EQ(answers({cut}), whole) << cut;
  check_property(500, [&] {
    const auto pieces = *rc::gen::container<std::vector<std::size_t>>(rc::gen::inRange<std::size_t>(0, 9));
    RC_ASSERT(answers(pieces) == whole);
  });
}

}  // namespace dfmoco_line_test
}  // namespace inbetween
