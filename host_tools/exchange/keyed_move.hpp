// The text of a move whose tracks have keys and a speed curve, or keys on frames.
#pragma once

#include <string>
#include <vector>

#include "host_tools/move_model/move_file.hpp"

namespace inbetween {

/// What stands in its tracks: axes, timing, rest, keys with their frames, speed and weights. Numbers read
/// back exactly. `comments` stand at its head, a line each.
std::string keyed_move_text_of(const MoveFile& move, const std::vector<std::string>& comments);

}  // namespace inbetween
