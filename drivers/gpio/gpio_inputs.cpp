#include "drivers/gpio/gpio_inputs.hpp"

#include <fcntl.h>
#include <gpiod.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

namespace inbetween::gpio {

void GpioInputs::close() {
  held_.reset();
  file_ = -1;
  count_ = 0;
}

std::optional<Refusal> GpioInputs::open(const GpioChip& chip, std::span<const InputLine> lines) {
  close();
  error_ = 0;
  received_ = 0;
  told_ = 0;
  line_told_ = {};
  std::vector<LineChoice> choices;
  for (const InputLine& line : lines) choices.push_back(line.line);
  std::vector<unsigned> offsets;
  if (std::optional<Refusal> refusal = chip.find(choices, offsets)) return refusal;
  std::vector<LineUse> uses;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    uses.push_back({.offset = offsets[i], .bias = lines[i].bias, .is_inverted = lines[i].is_inverted});
  }
  if (std::optional<Refusal> refusal = chip.take(uses, held_)) return refusal;
  file_ = gpiod_line_request_get_fd(held_.get());
  count_ = lines.size();
  std::copy(offsets.begin(), offsets.end(), offsets_.begin());
  // A read of libgpiod's own waits for an edge.
  const int flags = ::fcntl(file_, F_GETFL);
  if (flags < 0 || ::fcntl(file_, F_SETFL, flags | O_NONBLOCK) != 0) {
    const std::string reason = std::strerror(errno);
    close();
    return Refusal{.what = "lines cannot be read without waiting: " + reason,
                   .remedy = "none is known; report it with the version of your kernel"};
  }
  return std::nullopt;
}

std::optional<std::uint64_t> GpioInputs::levels() {
  if (!held_ || error_ != 0) return std::nullopt;
  gpio_v2_line_values values{};
  values.mask = ~std::uint64_t{0} >> (GpioChip::max_lines - count_);
  if (::ioctl(file_, GPIO_V2_LINE_GET_VALUES_IOCTL, &values) == 0) return values.bits & values.mask;
  error_ = errno;
  return std::nullopt;
}

LineEvent GpioInputs::take(const gpio_v2_line_event& raw) {
  // The kernel tells of no line but those that were taken.
  const auto line = static_cast<std::size_t>(
      std::find(offsets_.begin(), offsets_.begin() + count_ - 1, raw.offset) - offsets_.begin());
  // Both numbers go round at 2^32.
  const auto ahead = static_cast<std::int32_t>(raw.seqno - static_cast<std::uint32_t>(told_));
  const std::uint32_t line_ahead = raw.line_seqno - line_told_[line];
  if (ahead > 0) told_ += static_cast<std::uint32_t>(ahead);
  line_told_[line] = raw.line_seqno;
  ++received_;
  return {.at_ns = static_cast<std::int64_t>(raw.timestamp_ns),
          .line = static_cast<std::uint8_t>(line),
          .level = raw.id == GPIO_V2_LINE_EVENT_RISING_EDGE,
          .lost_before = ahead > 1 || line_ahead != 1};
}

std::size_t GpioInputs::read(std::span<LineEvent> events) {
  const std::size_t room = std::min(events.size(), max_events);
  if (!held_ || error_ != 0 || room == 0) return 0;
  const ssize_t bytes = ::read(file_, raw_.data(), room * sizeof(gpio_v2_line_event));
  if (bytes < 0) {
    if (errno != EAGAIN && errno != EINTR) error_ = errno;
    return 0;
  }
  const std::size_t count = static_cast<std::size_t>(bytes) / sizeof(gpio_v2_line_event);
  std::transform(raw_.begin(), raw_.begin() + count, events.begin(),
                 [this](const gpio_v2_line_event& raw) { return take(raw); });
  return count;
}

}  // namespace inbetween::gpio
