#pragma once

#include <linux/gpio.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/gpio/gpio_chip.hpp"
#include "drivers/refusal.hpp"
#include "inbetween/homing/line_event.hpp"

namespace inbetween::gpio {

struct InputLine {
  LineChoice line = 0U;
  Bias bias = Bias::as_it_is;
  bool is_inverted = false;  ///< high on the wire is false here
};

/// Input lines of a chip, in one request, for a real-time loop: line i is line i of `open`. After `open`
/// nothing is allocated, nothing waits, and `levels` and `read` are one system call each. Of one thread.
///
/// Edges carry the time at which the interrupt came, CLOCK_MONOTONIC; behind an I2C or SPI expander the time
/// at which the kernel asked it. The kernel does not debounce: it would answer late and put the time of its
/// decision in place of the time of the edge.
class GpioInputs {
 public:
  /// The most edges of one `read`.
  static constexpr std::size_t max_events = 64;

  GpioInputs() = default;
  GpioInputs(const GpioInputs&) = delete;
  GpioInputs& operator=(const GpioInputs&) = delete;

  /// Takes the lines, all or none; the counts begin at 0. What was open before is closed first. Busy lines
  /// are refused by name.
  [[nodiscard]] std::optional<Refusal> open(const GpioChip& chip, std::span<const InputLine> lines);
  void close();

  /// The levels of all lines now, by one GPIO_V2_LINE_GET_VALUES. None: not known, and `state` says why.
  [[nodiscard]] std::optional<std::uint64_t> levels();

  /// Takes the edges that have come, oldest first, by one read, and says how many it put at the beginning of
  /// `events`: at most as many as fit, and at most `max_events`.
  ///
  /// The kernel keeps the last 1024 edges and throws older ones away: then numbers are missing, and the next
  /// event says so. Two lines that change at once may come in either order; an event that overtook another
  /// says that edges were lost too, wrongly, but `lost` then counts back. Of a pulse shorter than the
  /// kernel's answer both edges may carry the same level: it looks at the line only then. Whoever needs to
  /// know what holds now asks `levels`.
  std::size_t read(std::span<LineEvent> events);

  /// Edges that were thrown away before they could be read, as far as later ones have told.
  [[nodiscard]] std::uint64_t lost() const { return told_ - received_; }

  /// As the calls have found it; asks nobody. What is not there any more tells nothing more.
  [[nodiscard]] ChipState state() const { return state_after(error_); }
  /// The errno of what ended it, 0 if nothing did.
  [[nodiscard]] int error() const { return error_; }

 private:
  LineEvent take(const gpio_v2_line_event& raw);

  HeldLines held_;
  int file_ = -1;
  int error_ = 0;
  std::size_t count_ = 0;
  std::array<unsigned, GpioChip::max_lines> offsets_{};
  std::uint64_t received_ = 0;
  std::uint64_t told_ = 0;  ///< the highest number of an edge, over all lines
  std::array<std::uint32_t, GpioChip::max_lines> line_told_{};  ///< the same of each line
  std::array<gpio_v2_line_event, max_events> raw_{};
};

}  // namespace inbetween::gpio
