#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "drivers/refusal.hpp"

struct gpiod_chip;
struct gpiod_line_request;

namespace inbetween::gpio {

/// A line of a chip: its offset, or the name that the machine's device tree gives it.
using LineChoice = std::variant<unsigned, std::string>;

/// A chip, as the calls on its lines have found it. What is no longer `there` stays so until its lines are
/// taken anew: nothing moves again because a plug was put back.
enum class ChipState : std::uint8_t {
  there,
  gone,    ///< unplugged, or its driver was unloaded (ENODEV)
  failed,  ///< a call failed in another way; its errno is kept
};
[[nodiscard]] ChipState state_after(int error);

/// The pull that holds a line when nobody drives it.
enum class Bias : std::uint8_t { as_it_is, none, pull_up, pull_down };

/// The use for which a line is taken.
struct LineUse {
  unsigned offset = 0;
  bool is_output = false;
  bool level = false;          ///< of an output, from the moment it is taken
  Bias bias = Bias::as_it_is;  ///< of an input
  bool is_inverted = false;    ///< high on the wire is false here (the kernel's "active low")
};

/// Lines that this program holds. They are given back with it, in no particular state.
struct GiveBack {
  void operator()(gpiod_line_request* request) const;
};
using HeldLines = std::unique_ptr<gpiod_line_request, GiveBack>;

/// A GPIO chip of Linux, by its label, for the set-up: nothing of it is for a real-time loop. The numbers of
/// chips (gpiochip0) change from start to start and are not asked for.
///
/// Source: libgpiod 2, gpiod.h; Linux include/uapi/linux/gpio.h.
class GpioChip {
 public:
  /// The most lines of one request.
  static constexpr std::size_t max_lines = 64;

  GpioChip();
  ~GpioChip();
  GpioChip(const GpioChip&) = delete;
  GpioChip& operator=(const GpioChip&) = delete;

  /// Finds the one chip with this label, and asks the names of its lines. No chip of that label, or several,
  /// are refused. What was open before is closed first; lines that were taken stay taken.
  [[nodiscard]] std::optional<Refusal> open(const std::string& label);
  /// The same, of the one chip that has a line of this name. No such line, or several, are refused.
  [[nodiscard]] std::optional<Refusal> open_with_line(const std::string& name);
  [[nodiscard]] bool is_open() const { return chip_ != nullptr; }
  /// The label of the open chip.
  [[nodiscard]] const std::string& label() const { return label_; }

  /// The offsets of lines, in their order: each of them is there, is meant once, and is free. Nothing is
  /// changed: whoever takes lines in several requests asks for all of them first. A name that two lines have
  /// is refused, and a busy line with the name of who uses it.
  [[nodiscard]] std::optional<Refusal> find(std::span<const LineChoice> lines,
                                            std::vector<unsigned>& offsets) const;

  /// Takes lines, all or none, in one request; line i of the request is lines[i]. They must be as `find`
  /// gives them; at least 1, at most `max_lines`. Inputs tell of both edges at CLOCK_MONOTONIC, without the
  /// kernel's debouncing.
  [[nodiscard]] std::optional<Refusal> take(std::span<const LineUse> lines, HeldLines& held) const;

 private:
  struct Close {
    void operator()(gpiod_chip* chip) const;
  };
  [[nodiscard]] std::optional<Refusal> find_one(const LineChoice& line, unsigned& offset) const;
  [[nodiscard]] std::optional<Refusal> refuse_busy(unsigned offset) const;
  [[nodiscard]] std::string name_of(unsigned offset) const;

  std::unique_ptr<gpiod_chip, Close> chip_;
  std::string label_;
  std::vector<std::string> line_names_;
};

}  // namespace inbetween::gpio
