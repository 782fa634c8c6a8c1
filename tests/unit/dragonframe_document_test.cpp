// docs/dragonframe.md names every message that the device knows, and says of each whether it is supported.
#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "host_tools/dragonframe/dmc_device.hpp"
#include "tests/support/oracle_dmc_host.hpp"
#include "tests/support/places.hpp"

namespace inbetween {
namespace dragonframe_document_test {

using namespace dragonframe;

std::string hex_of(DmcType type) {
  std::string digits;
  for (auto left = static_cast<unsigned>(type); digits.size() < 4; left /= 16) {
    digits.insert(digits.begin(), "0123456789ABCDEF"[left % 16]);
  }
  return "0x" + digits;
}

TEST(DragonframeDocument, NamesEveryMessageAndWhatIsUnsupported) {
  std::ifstream file(in_checkout("docs/dragonframe.md"));
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  DmcDevice device({.motors = 8, .outputs = 2, .inputs = 1, .capabilities = 0x0783},
                   [](const RigOrder&) { return RigAnswer::ok; });
  device.connect(0);
  for (const DmcTypeRow& row : dmc_type_table()) {
    const std::string name = hex_of(row.type) + " " + std::string(row.name);
    const std::size_t begin = text.find(name);
    ASSERT_NE(begin, std::string::npos) << name;
    const std::string line = text.substr(begin, text.find('\n', begin) - begin);
    static_cast<void>(device.take_bytes());
    device.hear(
        oracle::dmc_message(static_cast<unsigned>(row.type), 7, std::vector<std::uint8_t>(row.min_bytes)), 0);
    oracle::DmcHost host;
    host.next_id(8);
    host.hear(device.take_bytes());
    EXPECT_EQ(host.answers(), 1U) << name;
    EXPECT_EQ(host.code() == 0x13, line.find("| UNSUPPORTED |") != std::string::npos) << name;
  }
}

}  // namespace dragonframe_document_test
}  // namespace inbetween
