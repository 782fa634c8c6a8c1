#pragma once

#include <cstdint>

#include "inbetween/base/result.hpp"

namespace inbetween::can {

/// The identifier of a CAN frame (ISO 11898-1): a number of 11 bits, or of 29 bits in an extended frame.
/// There is no other: an illegal one is refused, ends the program or does not compile. The same number of 11
/// bits and of 29 bits are two identifiers.
class FrameId {
 public:
  static constexpr std::uint32_t max_standard = 0x7FF;
  static constexpr std::uint32_t max_extended = 0x1FFF'FFFF;

  /// 0, of 11 bits.
  constexpr FrameId() = default;
  /// A constant of 11 bits, as in `Frame{.id = 0x80}`.
  consteval FrameId(std::uint32_t number) : FrameId(standard(number)) {}

  /// For a number that comes from outside. Errors: out_of_range.
  static constexpr Result<FrameId> make(std::uint32_t number, bool is_extended) {
    if (number > (is_extended ? max_extended : max_standard)) {
      return Error{.code = ErrorCode::out_of_range,
                   .what = "the identifier of a CAN frame has more bits than its kind",
                   .remedy = "give one up to 7FFh, or up to 1FFFFFFFh in an extended frame"};
    }
    return FrameId(Bits{is_extended ? number | extended_bit : number});
  }
  /// For a number that is legal by construction: another is a defect of the caller and ends the program.
  /// Where the compiler sees the range of the number, as that of a NodeId, nothing is left of the check.
  static constexpr FrameId standard(std::uint32_t number) {
    if (number > max_standard) __builtin_trap();
    return FrameId(Bits{number});
  }
  static constexpr FrameId extended(std::uint32_t number) {
    if (number > max_extended) __builtin_trap();
    return FrameId(Bits{number | extended_bit});
  }
  /// Of 11 bits if the number has no more, else of 29.
  static constexpr FrameId shortest(std::uint32_t number) {
    return number <= max_standard ? standard(number) : extended(number);
  }

  [[nodiscard]] constexpr std::uint32_t number() const { return bits_ & ~extended_bit; }
  [[nodiscard]] constexpr bool is_extended() const { return (bits_ & extended_bit) != 0; }
  /// Written out, since the default takes its arguments by way of the stack on a Cortex-M.
  friend constexpr bool operator==(FrameId a, FrameId b) { return a.bits_ == b.bits_; }

 private:
  struct Bits {
    std::uint32_t value;
  };
  static constexpr std::uint32_t extended_bit = 0x8000'0000;
  constexpr explicit FrameId(Bits bits) : bits_(bits.value) {}
  std::uint32_t bits_ = 0;
};

}  // namespace inbetween::can
