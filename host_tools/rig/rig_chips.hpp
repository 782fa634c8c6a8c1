// Where the lines of a rig are on this machine.
#pragma once

#include <optional>

#include "drivers/gpio/gpio_chip.hpp"
#include "drivers/refusal.hpp"
#include "host_tools/files/gpio_line.hpp"
#include "host_tools/files/rig_file.hpp"

namespace inbetween {

gpio::LineChoice choice_of(const GpioLine& line);

/// Throws InputError at the place of the line: it is not there, busy, or not allowed.
[[noreturn]] void refuse(const LineAddress& address, const Refusal& refusal);

/// Opens the chip that has the line: the one of that label, or the only one with a line of that name. Throws
/// InputError at the place of the line where there is none.
void open_chip_of(const LineAddress& address, gpio::GpioChip& chip);

/// Looks at every line that the rig has, before any of them is taken: each is there, meant once and free.
/// Nothing is changed. Throws InputError at the place of one that is not.
void refuse_unavailable_lines(const RigFile& rig);

}  // namespace inbetween
