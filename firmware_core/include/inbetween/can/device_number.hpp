#pragma once

#include <cstdint>

#include "inbetween/base/result.hpp"

namespace inbetween::can {

/// The number of a device on its bus, Range::min to Range::max, which must fit into a byte. Those of two
/// protocols are two types.
template <class Range>
class DeviceNumber {
 public:
  /// Errors: out_of_range.
  static constexpr Result<DeviceNumber> make(std::int64_t number) {
    if (number < Range::min || number > Range::max) {
      return Error{.code = ErrorCode::out_of_range, .what = Range::what, .remedy = Range::remedy};
    }
    return DeviceNumber(static_cast<std::uint8_t>(number));
  }
  [[nodiscard]] constexpr std::uint8_t value() const { return value_; }
  friend constexpr bool operator==(DeviceNumber, DeviceNumber) = default;

 private:
  constexpr explicit DeviceNumber(std::uint8_t value) : value_(value) {}
  std::uint8_t value_;
};

}  // namespace inbetween::can
