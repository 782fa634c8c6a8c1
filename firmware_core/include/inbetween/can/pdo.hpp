#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/fixed_vector.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/can/sdo.hpp"

/// Which objects travel in a PDO, CiA 301 section 7.5.2.35 ff.

namespace inbetween::can {

inline constexpr std::uint32_t cob_id_is_invalid = 0x80000000;  ///< bit 31: the PDO does not exist
inline constexpr std::uint32_t cob_id_without_rtr = 0x40000000;
inline constexpr std::uint32_t cob_id_number = 0x7FF;

/// Subs of the communication parameter.
inline constexpr std::uint8_t pdo_sub_cob_id = 1;
inline constexpr std::uint8_t pdo_sub_type = 2;
inline constexpr std::uint8_t pdo_sub_inhibit = 3;
inline constexpr std::uint8_t pdo_sub_event_timer = 5;

struct PdoEntry {
  ObjectAddress object{};
  std::uint8_t bits = 0;
  friend bool operator==(const PdoEntry&, const PdoEntry&) = default;
};
/// As it stands in the mapping object.
constexpr std::uint32_t mapping_value(const PdoEntry& entry) {
  return (std::uint32_t{entry.object.index} << 16) | (std::uint32_t{entry.object.sub} << 8) | entry.bits;
}
constexpr PdoEntry read_mapping_value(std::uint32_t value) {
  return {.object = {.index = static_cast<std::uint16_t>(value >> 16),
                     .sub = static_cast<std::uint8_t>(value >> 8)},
          .bits = static_cast<std::uint8_t>(value)};
}

/// The objects of a PDO, in the order of their bytes.
class PdoMapping {
 public:
  static constexpr std::size_t capacity = 8;
  /// Errors: wrong_count (none, or more than eight), out_of_range (no whole number of bytes, or more than
  /// 64 bits in all).
  static Result<PdoMapping> make(std::span<const PdoEntry> entries);

  [[nodiscard]] std::span<const PdoEntry> entries() const { return entries_.span(); }
  [[nodiscard]] std::uint8_t bytes() const { return bytes_; }

 private:
  FixedVector<PdoEntry, capacity> entries_;
  std::uint8_t bytes_ = 0;
};

}  // namespace inbetween::can
