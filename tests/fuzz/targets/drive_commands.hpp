// What the targets with a bus have in common: the bytes that say what happens, and what an operator does with
// a drive.
#pragma once

#include <cstdint>
#include <span>

#include "tests/fuzz/targets/fuzz_require.hpp"

namespace inbetween::can {

/// One byte after the other; zeros when there are no more.
class Bytes {
 public:
  explicit Bytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  [[nodiscard]] bool empty() const { return bytes_.empty(); }
  std::uint8_t next() {
    if (bytes_.empty()) return 0;
    const std::uint8_t byte = bytes_[0];
    bytes_ = bytes_.subspan(1);
    return byte;
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

/// One of the first five commands of any drive, else `last`, which only some have.
template <class Drive, class Last>
void command_drive(Drive& drive, std::uint8_t what, std::int64_t now_ns, Last last) {
  switch (what % 6) {
    case 0:
      drive.connect(now_ns);
      break;
    case 1:
      fuzz_require(!drive.enable(now_ns) || drive.findings().empty(), "enabled over findings");
      break;
    case 2:
      drive.disable(now_ns);
      break;
    case 3:
      drive.quick_stop(now_ns);
      break;
    case 4:
      drive.acknowledge();
      break;
    default:
      last();
  }
}

}  // namespace inbetween::can
