#include "drivers/gpio/gpio_outputs.hpp"

#include <gpiod.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <vector>

namespace inbetween::gpio {

GpioOutputs::~GpioOutputs() {
  close();
}

void GpioOutputs::close() {
  if (held_) set_safe();
  held_.reset();
  file_ = -1;
  all_ = 0;
  safe_ = 0;
}

std::optional<Refusal> GpioOutputs::open(const GpioChip& chip, std::span<const OutputLine> lines) {
  close();
  error_.store(0, std::memory_order_relaxed);
  std::vector<LineChoice> choices;
  for (const OutputLine& line : lines) choices.push_back(line.line);
  std::vector<unsigned> offsets;
  if (std::optional<Refusal> refusal = chip.find(choices, offsets)) return refusal;
  std::vector<LineUse> uses;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    uses.push_back({.offset = offsets[i],
                    .is_output = true,
                    .level = lines[i].safe_level,
                    .is_inverted = lines[i].is_inverted});
  }
  if (std::optional<Refusal> refusal = chip.take(uses, held_)) return refusal;
  file_ = gpiod_line_request_get_fd(held_.get());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    all_ |= std::uint64_t{1} << i;
    if (lines[i].safe_level) safe_ |= std::uint64_t{1} << i;
  }
  return std::nullopt;
}

void GpioOutputs::note(int error) {
  int none = 0;
  // The first failure is the cause.
  error_.compare_exchange_strong(none, error, std::memory_order_relaxed);
}

bool GpioOutputs::give(std::uint64_t levels, std::uint64_t mask) {
  gpio_v2_line_values values{};
  values.bits = levels;
  values.mask = mask;
  if (::ioctl(file_, GPIO_V2_LINE_SET_VALUES_IOCTL, &values) == 0) return true;
  note(errno);
  return false;
}

bool GpioOutputs::set(std::uint64_t levels, std::uint64_t mask) {
  if (error() != 0) return false;
  if ((mask & ~all_) != 0) {
    note(EINVAL);
    return false;
  }
  return mask == 0 || give(levels, mask);
}

bool GpioOutputs::set_safe() {
  return give(safe_, all_);
}

}  // namespace inbetween::gpio
