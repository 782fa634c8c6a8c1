#pragma once

#include <cstdint>

/// How much of a CAN bus the setpoints of a rig take, at worst.

namespace inbetween::can {

/// Bits on the wire of a classic data frame with `length` bytes (0 to 8) and the three bits of pause behind
/// it, with as many stuffing bits as ISO 11898-1 can ask for: one after the first five and then after every
/// four of those between start and checksum.
constexpr std::int32_t worst_case_bits(std::int32_t length, bool is_extended) {
  const std::int32_t stuffed = (is_extended ? 54 : 34) + 8 * length;
  const std::int32_t never_stuffed = 13;
  return stuffed + never_stuffed + (stuffed - 1) / 4;
}

/// Bits of a CAN FD frame with the pause behind it, by the bitrate at which they are sent.
struct FdBits {
  std::int32_t arbitration = 0;
  std::int32_t data = 0;
};
/// With fast data and a length that such a frame can have, at worst: stuffing bits as in a classic frame up
/// to the last byte, a fixed one before every fourth bit of the checksum and its count (ISO 11898-1:2015).
constexpr FdBits worst_case_fd_bits(std::int32_t length, bool is_extended) {
  constexpr std::int32_t head_and_end = 10;  // ESI, DLC and the end of the checksum
  constexpr std::int32_t longest_of_17 = 16;
  const std::int32_t stuffed = is_extended ? (40 + 8 * length) / 4 - 8 : (21 + 8 * length) / 4 - 4;
  const std::int32_t checksum = length <= longest_of_17 ? 17 + 6 : 21 + 7;
  return {.arbitration = is_extended ? 56 : 33, .data = head_and_end + 8 * length + stuffed + checksum};
}
/// How many bits of the arbitration take as long, rounded up.
constexpr std::int64_t bits_of_arbitration(const FdBits& bits, std::int64_t bitrate,
                                           std::int64_t data_bitrate) {
  return bits.arbitration + (bits.data * bitrate + data_bitrate - 1) / data_bitrate;
}

/// The cyclic frames of CiA 402 drives: a SYNC, and for each drive an RPDO of 6 and a TPDO of 7 bytes a tick.
struct BusUse {
  std::int64_t bitrate = 1'000'000;  ///< bit/s
  std::int64_t rate_hz = 250;
  std::int64_t drives = 1;
  bool counts_sync = false;  ///< SYNC carries a counter
};

/// The usable share: the rest is for SDO, EMCY, heartbeats and whatever has to be sent again.
inline constexpr std::int64_t bus_load_limit_percent = 70;

/// Worst-case bits of the cyclic frames in a second.
constexpr std::int64_t cyclic_bits_per_second(const BusUse& use) {
  const std::int64_t sync = worst_case_bits(use.counts_sync ? 1 : 0, false);
  const std::int64_t drive = worst_case_bits(6, false) + worst_case_bits(7, false);
  return (sync + use.drives * drive) * use.rate_hz;
}

/// Tells the load in thousandths of the bus, rounded up. Needs a bitrate > 0.
constexpr std::int64_t bus_load_per_mille(const BusUse& use) {
  return (1000 * cyclic_bits_per_second(use) + use.bitrate - 1) / use.bitrate;
}

/// How many drives stay within the limit.
constexpr std::int64_t max_drives(const BusUse& use) {
  std::int64_t drives = 0;
  while (drives < 127) {
    BusUse more = use;
    more.drives = drives + 1;
    if (100 * cyclic_bits_per_second(more) > bus_load_limit_percent * use.bitrate) break;
    ++drives;
  }
  return drives;
}

}  // namespace inbetween::can
