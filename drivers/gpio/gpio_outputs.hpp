#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/gpio/gpio_chip.hpp"
#include "drivers/refusal.hpp"

namespace inbetween::gpio {

struct OutputLine {
  LineChoice line = 0U;
  bool safe_level = false;   ///< at which it is taken, and at which it is left
  bool is_inverted = false;  ///< high on the wire is false here
};

/// All output lines of a chip, in one request, for a real-time loop: bit i of a set is line i of `open`.
/// After `open` nothing is allocated here, nothing waits, and a set is one system call (the kernel, 6.1,
/// allocates in it for more than one line). Sets may come from several threads; the kernel puts them in
/// order.
///
/// All lines of a set change in one call. Whether they change at once is the chip's affair: most write a bank
/// of lines at a time, some one line after the other.
///
/// A process that ends without `close`, by kill -9 or a crash, gives its lines back as they are, and then the
/// kernel promises nothing: many chips keep the level, some make the line an input. Nobody releases ENABLE
/// then but the wiring. Put a resistor on it that disables when nothing drives the line, and a drive or relay
/// behind it that wants to be fed, if the chip keeps its outputs.
class GpioOutputs {
 public:
  GpioOutputs() = default;
  ~GpioOutputs();
  GpioOutputs(const GpioOutputs&) = delete;
  GpioOutputs& operator=(const GpioOutputs&) = delete;

  /// Takes the lines, all or none, straight at their safe levels. What was open before is closed first. Busy
  /// lines are refused by name before any line has changed.
  [[nodiscard]] std::optional<Refusal> open(const GpioChip& chip, std::span<const OutputLine> lines);
  /// Puts the lines back to their safe levels, if the chip is there, and gives them back.
  void close();
  [[nodiscard]] bool is_open() const { return held_ != nullptr; }

  /// Gives the lines in `mask` these levels, by one GPIO_V2_LINE_SET_VALUES; those not in it keep theirs.
  /// false: the chip did not take them, and `state` says why; from then on nothing is set any more. A bit of
  /// `mask` that is no line is such a failure (EINVAL).
  bool set(std::uint64_t levels, std::uint64_t mask);
  /// All lines to their safe levels. Tried even after a failure.
  bool set_safe();

  /// As the sets have found it; asks nobody.
  [[nodiscard]] ChipState state() const { return state_after(error_.load(std::memory_order_relaxed)); }
  /// The errno of what ended it, 0 if nothing did.
  [[nodiscard]] int error() const { return error_.load(std::memory_order_relaxed); }

 private:
  bool give(std::uint64_t levels, std::uint64_t mask);
  void note(int error);

  HeldLines held_;
  int file_ = -1;
  std::uint64_t all_ = 0;
  std::uint64_t safe_ = 0;
  std::atomic<int> error_{0};
};

}  // namespace inbetween::gpio
