// Numbers as bytes of a text, lowest byte first on every machine.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace inbetween {

/// Whole numbers in the order of the doubles whose bits they are, -0 directly below 0: how many doubles lie
/// between two.
constexpr std::int64_t place_of_bits(double number) {
  const auto bits = std::bit_cast<std::int64_t>(number);
  return bits < 0 ? static_cast<std::int64_t>(~static_cast<std::uint64_t>(bits) | (std::uint64_t{1} << 63U))
                  : bits;
}
constexpr double at_place_of_bits(std::int64_t place) {
  const auto bits = static_cast<std::uint64_t>(place);
  return std::bit_cast<double>(place < 0 ? ~(bits & ~(std::uint64_t{1} << 63U)) : bits);
}

class ByteWriter {
 public:
  void byte(std::uint8_t value) { text_ += static_cast<char>(value); }
  void fixed(std::uint64_t value) {
    for (unsigned shift = 0; shift < 64; shift += 8) byte(static_cast<std::uint8_t>(value >> shift));
  }
  void number(double value) { fixed(std::bit_cast<std::uint64_t>(value)); }
  /// Seven bits a byte, the lowest first; all but the last have the eighth (LEB128).
  void whole(std::uint64_t value) {
    for (; value > 0x7F; value >>= 7U) byte(static_cast<std::uint8_t>(value | 0x80U));
    byte(static_cast<std::uint8_t>(value));
  }
  /// 0, -1, 1, -2, ... as 0, 1, 2, 3, ...
  void whole_signed(std::int64_t value) { whole(folded(value)); }
  /// By how many doubles it is off.
  void near(double value, double expected) {
    whole(folded(static_cast<std::int64_t>(static_cast<std::uint64_t>(place_of_bits(value)) -
                                           static_cast<std::uint64_t>(place_of_bits(expected)))));
  }
  [[nodiscard]] static std::uint64_t folded(std::int64_t value) {
    return (static_cast<std::uint64_t>(value) << 1U) ^ (value < 0 ? ~std::uint64_t{0} : 0);
  }
  [[nodiscard]] std::string& text() { return text_; }

 private:
  std::string text_;
};

/// Reads the same. What is not there is 0, and told at the end.
class ByteReader {
 public:
  explicit ByteReader(std::string_view text) : text_(text) {}
  std::uint8_t byte() {
    if (text_.empty()) {
      is_short_ = true;
      return 0;
    }
    const auto value = static_cast<std::uint8_t>(text_.front());
    text_.remove_prefix(1);
    return value;
  }
  std::uint64_t fixed() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 8) value |= std::uint64_t{byte()} << shift;
    return value;
  }
  double number() { return std::bit_cast<double>(fixed()); }
  std::uint64_t whole() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const std::uint8_t next = byte();
      value |= std::uint64_t{next & 0x7FU} << shift;
      if (next < 0x80) return value;
    }
    is_short_ = true;  // longer than any number
    return value;
  }
  std::int64_t whole_signed() { return unfolded(whole()); }
  double near(double expected) {
    return at_place_of_bits(static_cast<std::int64_t>(static_cast<std::uint64_t>(place_of_bits(expected)) +
                                                      static_cast<std::uint64_t>(unfolded(whole()))));
  }
  [[nodiscard]] static std::int64_t unfolded(std::uint64_t value) {
    return static_cast<std::int64_t>((value >> 1U) ^ ((value & 1U) != 0 ? ~std::uint64_t{0} : 0));
  }
  [[nodiscard]] bool is_short() const { return is_short_; }
  [[nodiscard]] std::size_t left() const { return text_.size(); }

 private:
  std::string_view text_;
  bool is_short_ = false;
};

/// FNV-1a of bytes.
std::uint64_t sum_of(std::string_view bytes);

}  // namespace inbetween
