#include "inbetween/can/pdo.hpp"

namespace inbetween::can {

Result<PdoMapping> PdoMapping::make(std::span<const PdoEntry> entries) {
  if (entries.empty() || entries.size() > capacity) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "a PDO carries none or more than eight objects",
                 .remedy = "map one to eight"};
  }
  PdoMapping mapping;
  unsigned bits = 0;
  for (const PdoEntry& entry : entries) {
    bits += entry.bits;
    if (entry.bits == 0 || entry.bits % 8 != 0 || bits > 64) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "the objects of a PDO are no whole bytes or more than eight",
                   .remedy = "map objects of 8, 16 or 32 bits, 64 bits in all"};
    }
    if (const Status added = mapping.entries_.push_back(entry); !added) return added.error();
  }
  mapping.bytes_ = static_cast<std::uint8_t>(bits / 8);
  return mapping;
}

}  // namespace inbetween::can
