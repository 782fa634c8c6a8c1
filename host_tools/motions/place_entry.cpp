#include "host_tools/motions/place_entry.hpp"

namespace inbetween {
namespace {

/// More digits than any frame has are not taken.
constexpr std::int32_t max_number = 99'999'999;

std::optional<std::int32_t> digit_of(TransportKey key) {
  if (key == TransportKey::digit_0) return 0;
  const auto number = static_cast<std::int32_t>(key);
  const auto one = static_cast<std::int32_t>(TransportKey::size_1);
  const auto six = static_cast<std::int32_t>(TransportKey::digit_6);
  if (key >= TransportKey::size_1 && key <= TransportKey::size_5) return number - one + 1;
  if (key >= TransportKey::digit_6 && key <= TransportKey::digit_9) return number - six + 6;
  return std::nullopt;
}

}  // namespace

bool PlaceEntry::press(TransportKey key) {
  if (key == TransportKey::go_to_frame || key == TransportKey::go_to_key) {
    typed_ = EntrySnapshot{.is_key = key == TransportKey::go_to_key};
    return true;
  }
  if (!typed_) return false;
  if (const std::optional<std::int32_t> digit = digit_of(key)) {
    press_digit(*digit);
    return true;
  }
  if (key == TransportKey::erase) {
    const std::int32_t left = typed_->number.value_or(0) / 10;
    typed_->number = left > 0 ? std::optional(left) : std::nullopt;
    return true;
  }
  const bool is_asked = key == TransportKey::start && typed_->number;
  if (is_asked) wanted_ = WantedPlace{.is_key = typed_->is_key, .number = *typed_->number};
  const bool is_own = key == TransportKey::start;  // an Enter without a number begins nothing else either
  typed_.reset();
  return is_own;
}

void PlaceEntry::press_digit(std::int32_t digit) {
  const std::int32_t before = typed_->number.value_or(0);
  if (before <= max_number / 10) typed_->number = before * 10 + digit;
}

}  // namespace inbetween
