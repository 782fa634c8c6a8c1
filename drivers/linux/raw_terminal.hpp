#pragma once

#include <cstdint>

namespace inbetween {

/// Whether a serial port can be set to it.
bool is_baud(std::int32_t baud);

/// Bytes pass through an open serial port or pseudo-terminal as they are: 8 bits, no parity, 1 stop bit,
/// no flow control, no echo, no signals, at `baud` bit/s. False, with the reason in errno: it has not this
/// speed, or is no terminal.
bool make_raw(int file, std::int32_t baud);

}  // namespace inbetween
