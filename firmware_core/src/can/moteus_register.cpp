#include "inbetween/can/moteus_register.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace inbetween::can {
namespace {

using enum MoteusRegister;
using Kind = MoteusItem::Kind;

constexpr std::uint32_t nop = 0x50;

/// How many steps of an int8, an int16 and an int32 make one unit of the register. Steps themselves, such as
/// 0.00001, are no binary numbers, and what is divided by one may fall short of a whole.
using StepsPerUnit = std::array<double, 3>;

constexpr StepsPerUnit steps_per_unit_of(MoteusRegister reg) {
  switch (reg) {
    case position:
    case command_position:
      return {100, 10'000, 100'000};
    case velocity:
    case command_velocity:
      return {10, 4'000, 100'000};
    case torque:
    case max_torque:
      return {2, 100, 1'000};
    case voltage:
      return {2, 10, 1'000};
    case temperature:
      return {1, 10, 1'000};
    case watchdog:
      return {100, 1'000, 1'000'000};
    default:
      return {1, 1, 1};
  }
}

struct Range {
  std::int32_t min;
  std::int32_t max;
};
template <class Integer>
constexpr Range range_of() {
  return {std::numeric_limits<Integer>::min(), std::numeric_limits<Integer>::max()};
}
constexpr Range range_of(MoteusType type) {
  if (type == MoteusType::int8) return range_of<std::int8_t>();
  return type == MoteusType::int16 ? range_of<std::int16_t>() : range_of<std::int32_t>();
}

std::int32_t signed_of(std::uint32_t bits, MoteusType type) {
  if (type == MoteusType::int8) return static_cast<std::int8_t>(bits);
  if (type == MoteusType::int16) return static_cast<std::int16_t>(bits);
  return static_cast<std::int32_t>(bits);
}

MoteusRegister next_of(MoteusRegister reg) {
  return static_cast<MoteusRegister>(static_cast<std::uint32_t>(reg) + 1);
}

}  // namespace

std::uint32_t moteus_bits_of(double value, MoteusRegister reg, MoteusType type) {
  if (type == MoteusType::float32) return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  const Range range = range_of(type);
  if (!std::isfinite(value)) return static_cast<std::uint32_t>(range.min);
  const double steps = std::trunc(value * steps_per_unit_of(reg)[static_cast<std::size_t>(type)]);
  const double max = range.max;
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::clamp(steps, -max, max)));
}

double moteus_value_of(std::uint32_t bits, MoteusRegister reg, MoteusType type) {
  if (type == MoteusType::float32) return static_cast<double>(std::bit_cast<float>(bits));
  const std::int32_t steps = signed_of(bits, type);
  if (steps == range_of(type).min) return std::numeric_limits<double>::quiet_NaN();
  return steps / steps_per_unit_of(reg)[static_cast<std::size_t>(type)];
}

// --- writing

void MoteusWriter::put(std::uint32_t byte) {
  fits_ = fits_ && frame_.length < frame_.data.size();
  if (fits_) frame_.data[frame_.length++] = static_cast<std::uint8_t>(byte);
}

/// Seven bits in a byte, the lowest first; the eighth says that more follow.
void MoteusWriter::put_number(std::uint32_t number) {
  for (; number >= 0x80; number >>= 7) put((number & 0x7F) | 0x80);
  put(number);
}

void MoteusWriter::put_head(std::uint32_t operation, MoteusRegister first, MoteusType type,
                            std::uint32_t count) {
  constexpr std::uint32_t max_short = 3;
  const std::uint32_t head = operation | static_cast<std::uint32_t>(type) << 2;
  put(count <= max_short ? head | count : head);
  if (count > max_short) put_number(count);
  put_number(static_cast<std::uint32_t>(first));
}

void MoteusWriter::put_values(std::uint32_t operation, MoteusRegister first, MoteusType type,
                              std::span<const double> values) {
  put_head(operation, first, type, static_cast<std::uint32_t>(values.size()));
  MoteusRegister reg = first;
  for (const double value : values) {
    const std::uint32_t bits = moteus_bits_of(value, reg, type);
    for (std::size_t i = 0; i < size_of(type); ++i) put(bits >> (8 * i) & 0xFF);
    reg = next_of(reg);
  }
}

void MoteusWriter::read_error(MoteusRegister reg, std::uint32_t error) {
  put(0x31);
  put_number(static_cast<std::uint32_t>(reg));
  put_number(error);
}

bool MoteusWriter::finish() {
  const std::size_t length = fd_length_for(frame_.length);
  while (fits_ && frame_.length < length) put(nop);
  return fits_;
}

// --- reading

std::optional<std::uint32_t> MoteusReader::byte() {
  if (at_ >= std::min<std::size_t>(frame_.length, frame_.data.size())) return {};
  return frame_.data[at_++];
}

std::optional<std::uint32_t> MoteusReader::number() {
  std::uint32_t number = 0;
  for (unsigned shift = 0; shift < 32; shift += 7) {
    const auto part = byte();
    if (!part) return {};
    number |= (*part & 0x7F) << shift;
    if ((*part & 0x80) == 0) return number;
  }
  return {};
}

/// The first bytes of a sub-frame. False: they are none.
bool MoteusReader::begin(std::uint32_t head) {
  constexpr std::uint32_t most = 64;  // more registers have no room in an answer
  std::optional<std::uint32_t> count = 1;
  if (head < 0x30) {
    constexpr std::array kinds{Kind::write, Kind::read, Kind::reply};
    item_.kind = kinds[head >> 4];
    item_.type = static_cast<MoteusType>(head >> 2 & 3);
    count = head & 3;
    if (*count == 0) count = number();
  } else if (head == 0x30 || head == 0x31) {
    item_.kind = head == 0x30 ? Kind::write_error : Kind::read_error;
  } else {
    return false;
  }
  const auto first = number();
  if (!count || *count > most || !first) return false;
  left_ = *count;
  item_.reg = static_cast<MoteusRegister>(*first);
  return true;
}

std::optional<MoteusItem> MoteusReader::item() {
  MoteusItem item = item_;
  item_.reg = next_of(item_.reg);
  --left_;
  if (item.kind == Kind::write_error || item.kind == Kind::read_error) {
    const auto error = number();
    if (!error) return refuse();
    item.bits = *error;
  } else if (item.kind != Kind::read) {
    for (std::size_t i = 0; i < size_of(item.type); ++i) {
      const auto part = byte();
      if (!part) return refuse();
      item.bits |= *part << (8 * i);
    }
    item.value = moteus_value_of(item.bits, item.reg, item.type);
  }
  return item;
}

std::optional<MoteusItem> MoteusReader::next() {
  while (left_ == 0) {
    const auto head = byte();
    if (!head) return {};
    if (*head == nop) continue;
    constexpr std::uint32_t first_stream = 0x40;
    constexpr std::uint32_t last_stream = 0x44;
    if (*head >= first_stream && *head <= last_stream) {
      at_ = frame_.length;
      return MoteusItem{.kind = Kind::stream};
    }
    if (!begin(*head)) return refuse();
  }
  return item();
}

}  // namespace inbetween::can
