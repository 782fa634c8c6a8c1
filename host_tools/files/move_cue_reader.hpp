// Reading the cues of a move.
#pragma once

#include "host_tools/files/move_file.hpp"
#include "host_tools/files/toml_value.hpp"

namespace inbetween {

/// The fields `cue`, `clapper` and `start` of a move whose frames and rate have been read, into `move`.
/// Throws InputError at the first thing that is wrong, two pulses of a line that overlap or touch included.
void read_cues(const TomlTable& table, MoveFile& move);

}  // namespace inbetween
