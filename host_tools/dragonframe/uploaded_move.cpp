#include "host_tools/dragonframe/uploaded_move.hpp"

#include <algorithm>
#include <cmath>

namespace inbetween::dragonframe {

UploadedMove::UploadedMove(std::size_t motors, std::uint32_t capacity)
    : motor_count_(motors),
      capacity_(capacity),
      positions_(motors * capacity),
      is_there_(motors * capacity),
      triggers_(capacity) {}

void UploadedMove::clear() {
  is_open_ = false;
  is_loaded_ = false;
  count_ = 0;
  motors_with_positions_ = 0;
  trigger_mask_ = 0;
  std::fill(is_there_.begin(), is_there_.end(), false);
  std::fill(triggers_.begin(), triggers_.end(), 0);
}

RigAnswer UploadedMove::begin(std::int32_t start, std::int32_t end) {
  clear();
  const std::int64_t count = std::int64_t{end} - start + 1;
  if (count < 1 || count > capacity_) return RigAnswer::range;
  start_ = start;
  count_ = static_cast<std::uint32_t>(count);
  is_open_ = true;
  return RigAnswer::ok;
}

RigAnswer UploadedMove::put(const UploadBlock& block) {
  if (block.motor < 1 || block.motor > motor_count_) return RigAnswer::range;
  if (!is_open_ || block.positions.empty()) return RigAnswer::general;
  if (block.index >= count_ || block.positions.size() > count_ - block.index) return RigAnswer::range;
  const std::size_t motor = block.motor - 1U;
  const std::size_t behind = block.is_last ? count_ : block.index + block.positions.size();
  for (std::size_t i = block.index; i < behind; ++i) {
    positions_[place(motor, i)] = block.positions[std::min(i - block.index, block.positions.size() - 1)];
    is_there_[place(motor, i)] = true;
  }
  motors_with_positions_ |= mask_of(block.motor);
  return RigAnswer::ok;
}

RigAnswer UploadedMove::set_trigger_mask(std::uint32_t mask) {
  if (!is_open_) return RigAnswer::general;
  trigger_mask_ |= mask;
  return RigAnswer::ok;
}

RigAnswer UploadedMove::put_trigger(std::uint32_t index, std::uint32_t values) {
  if (!is_open_) return RigAnswer::general;
  if (index >= count_) return RigAnswer::range;
  triggers_[index] = values;
  return RigAnswer::ok;
}

RigAnswer UploadedMove::finish() {
  if (!is_open_) return RigAnswer::general;
  is_open_ = false;
  for (std::size_t motor = 0; motor < motor_count_; ++motor) {
    if ((motors_with_positions_ >> motor & 1U) == 0) continue;
    const auto first = is_there_.begin() + static_cast<std::ptrdiff_t>(place(motor, 0));
    const bool is_whole = std::all_of(first, first + count_, [](bool there) { return there; });
    if (!is_whole) return RigAnswer::general;
  }
  is_loaded_ = true;
  return RigAnswer::ok;
}

double UploadedMove::position(std::uint8_t motor, double frame) const {
  const std::size_t row = motor - 1U;
  const auto at = [&](std::size_t index) { return static_cast<double>(positions_[place(row, index)]); };
  const double x = frame - start_;
  const std::size_t last = count_ - 1;
  if (x >= static_cast<double>(last)) return at(last);
  if (x < 0) return last == 0 ? at(0) : at(0) + std::max(x, -1.0) * (at(1) - at(0));
  const double below = std::floor(x);
  const auto index = static_cast<std::size_t>(below);
  return at(index) + (x - below) * (at(index + 1) - at(index));
}

std::uint32_t UploadedMove::triggers_at(std::int32_t frame) const {
  return has(frame) ? triggers_[static_cast<std::size_t>(std::int64_t{frame} - start_)] : 0;
}

}  // namespace inbetween::dragonframe
