#pragma once

#include "tests/embedded/target/moves.hpp"

namespace inbetween::embedded {

/// Prints a line: hashes of the bounds of the move's stops and of a session of its
/// playhead.
void report_play(const Move& move);

}  // namespace inbetween::embedded
