// Reads the cues of a move.
#pragma once

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/text/toml_value.hpp"

namespace inbetween {

/// Reads the fields `cue`, `clapper` and `start` into `move`, whose frames and rate have been read. Throws
/// InputError at the first mistake. Two pulses of a line that overlap or touch are a mistake.
void read_cues(const TomlTable& table, MoveFile& move);

}  // namespace inbetween
