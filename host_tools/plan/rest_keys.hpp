// A rest at a key of a move that is timed by frames: the key is written twice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>

#include "host_tools/move_model/move_file.hpp"

namespace inbetween {

/// The two neighbouring frames of a key that is written twice.
struct RestFrames {
  std::int32_t first = 0;
  std::int32_t second = 0;
};

/// Where key `key` would rest if it were written twice: from its frame to the next, or from the one before to
/// its own, on the side that has more frames. Nothing at an end, where a key rests there already, where no
/// frame is free beside it, and unless every axis is a curve over time (kinetic = "curves").
std::optional<RestFrames> rest_at_key(const MoveTrack& track, std::size_t key);

/// Of the keys on either side of frame `frame` the one that can rest; of two the one at which the coordinate
/// `axis` is higher, or with `low` lower: there it turns back, if it goes beyond its keys between them.
std::optional<std::size_t> key_to_rest(const MoveTrack& track, double frame, std::size_t axis, bool low);

/// Writes each of these keys twice. They can rest.
void write_twice(MoveTrack& track, const std::set<std::size_t>& keys);

/// "key 1 twice, on frames 8 and 9, for a rest there". They can rest.
std::string twice_in_words(const MoveTrack& track, const std::set<std::size_t>& keys);

}  // namespace inbetween
