#include "host_tools/dragonframe/dmc_frame.hpp"

#include <algorithm>
#include <stdexcept>

namespace inbetween::dragonframe {
namespace {

constexpr std::uint8_t first_mark = 0x44;   // 'D'
constexpr std::uint8_t second_mark = 0x46;  // 'F'
// The maker's parser takes a type with any other bit for noise.
constexpr std::uint16_t possible_type_bits = 0x83FF;

struct FletcherSums {
  std::uint32_t first = 0;
  std::uint32_t second = 0;
};

FletcherSums fletcher_sums(std::span<const std::uint8_t> bytes) {
  FletcherSums sums;
  for (const std::uint8_t byte : bytes) {
    sums.first = (sums.first + byte) % 255;
    sums.second = (sums.second + sums.first) % 255;
  }
  return sums;
}

std::uint32_t number_at(std::span<const std::uint8_t> bytes, std::size_t offset, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value |= std::uint32_t{bytes[offset + i]} << (8 * i);
  return value;
}

void append_number(std::uint32_t value, std::size_t count, std::vector<std::uint8_t>& bytes) {
  for (std::size_t i = 0; i < count; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

}  // namespace

std::array<std::uint8_t, 2> dmc_check(std::span<const std::uint8_t> bytes) {
  const FletcherSums sums = fletcher_sums(bytes);
  const std::uint32_t first = 255 - ((sums.first + sums.second) % 255);
  const std::uint32_t second = 255 - ((sums.first + first) % 255);
  return {static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(second)};
}

void append_dmc_frame(const DmcFrame& frame, std::vector<std::uint8_t>& bytes) {
  if (frame.payload.size() > max_dmc_payload_bytes) throw std::length_error("a DMC payload above 2036 bytes");
  const std::size_t begin = bytes.size();
  bytes.push_back(first_mark);
  bytes.push_back(second_mark);
  append_number(frame.id, 4, bytes);
  append_number(frame.type, 2, bytes);
  append_number(static_cast<std::uint32_t>(frame.payload.size()), 2, bytes);
  bytes.insert(bytes.end(), frame.payload.begin(), frame.payload.end());
  const auto check = dmc_check(std::span(bytes).subspan(begin));
  bytes.insert(bytes.end(), check.begin(), check.end());
}

void DmcDecoder::drop(std::size_t count) {
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(count),
            buffer_.begin() + static_cast<std::ptrdiff_t>(size_), buffer_.begin());
  size_ -= count;
}

/// The length of the frame in front, or 0 while its header is not whole.
std::size_t DmcDecoder::frame_bytes() const {
  if (size_ < dmc_header_bytes) return 0;
  return dmc_header_bytes + number_at(buffer_, 8, 2) + dmc_check_bytes;
}

/// Skips bytes until what stands in front can be the beginning of a frame.
void DmcDecoder::hunt() {
  std::size_t skipped = 0;
  const auto can_begin = [&](std::size_t at) {
    const std::size_t there = size_ - at;
    const std::span<const std::uint8_t> bytes(buffer_.data() + at, there);
    if (bytes[0] != first_mark) return false;
    if (there > 1 && bytes[1] != second_mark) return false;
    if (there < dmc_header_bytes) return true;
    return (number_at(bytes, 6, 2) & ~std::uint32_t{possible_type_bits}) == 0 &&
           number_at(bytes, 8, 2) <= max_dmc_payload_bytes;
  };
  while (skipped < size_ && !can_begin(skipped)) ++skipped;
  if (skipped == 0) return;
  counters_.skipped_bytes += skipped;
  drop(skipped);
}

std::optional<DmcFrame> DmcDecoder::next(std::span<const std::uint8_t>& bytes) {
  if (consumed_ > 0) {
    drop(was_damaged_ ? 1 : consumed_);
    if (was_damaged_) ++counters_.skipped_bytes;
    consumed_ = 0;
  }
  while (true) {
    hunt();
    const std::size_t length = frame_bytes();
    if (length > 0 && size_ >= length) {
      const std::span<const std::uint8_t> whole(buffer_.data(), length);
      const FletcherSums sums = fletcher_sums(whole);
      was_damaged_ = sums.first != 0 || sums.second != 0;
      ++(was_damaged_ ? counters_.damaged : counters_.frames);
      consumed_ = length;
      return DmcFrame{.id = number_at(whole, 2, 4),
                      .type = static_cast<std::uint16_t>(number_at(whole, 6, 2)),
                      .payload = whole.subspan(dmc_header_bytes, length - dmc_header_bytes - dmc_check_bytes),
                      .is_intact = !was_damaged_};
    }
    if (bytes.empty()) return {};
    // Never more than what is missing, so that the buffer is always large enough.
    const std::size_t wanted = (length > 0 ? length : dmc_header_bytes) - size_;
    const std::size_t taken = std::min(wanted, bytes.size());
    std::copy_n(bytes.begin(), taken, buffer_.begin() + static_cast<std::ptrdiff_t>(size_));
    size_ += taken;
    bytes = bytes.subspan(taken);
  }
}

void DmcDecoder::give_up() {
  if (!has_half()) return;
  drop(consumed_ + 1);
  consumed_ = 0;
  ++counters_.skipped_bytes;
  ++counters_.abandoned;
}

void DmcDecoder::clear() {
  if (has_half()) {
    counters_.skipped_bytes += size_ - consumed_;
    ++counters_.abandoned;
  }
  size_ = 0;
  consumed_ = 0;
}

}  // namespace inbetween::dragonframe
