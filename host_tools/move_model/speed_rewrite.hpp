// Replaces a speed curve in a move file and leaves the rest as its author wrote it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

/// A whole number in a file, and what is to stand in its place.
struct NumberAt {
  Place place;
  std::int64_t number = 0;
};

/// Returns `text` with other whole numbers at places that a reader gave, and all else as it is.
std::string with_numbers(std::string_view text, std::vector<NumberAt> numbers);

/// Returns `text`, a move, with `speed` in place of the numbers in the `speed` of track `track` (counted from
/// 0). All other bytes stay: comments, also inside the list, spacing, line ends, a byte order mark, the other
/// tracks. Number i stands where number i stood. Additional numbers follow the last, spaced as the last two
/// were, or by a comma and a blank if a comment is between these. Surplus numbers go with the comma before
/// them. Numbers are written in the shortest form that reads back to the same double, whole ones without a
/// decimal point.
///
/// The function reads the result again, and ensures that it is the same move with another speed curve.
///
/// `speed`: 1 or more values 0..100, otherwise it throws std::invalid_argument; std::out_of_range if the move
/// has no such track. `file_name` stands in the places of diagnostics. Throws InputError if `text` is not a
/// move, if the track has no speed curve (timing = "frames"), if `speed` has more than max_control_values, or
/// if the result would have more than max_file_bytes.
///
/// Cost: the text is parsed twice.
std::string with_speed(std::string_view text, const std::string& file_name, std::size_t track,
                       std::span<const double> speed);

/// Throws the InputError of with_speed() for a curve of so many values.
void refuse_too_many_values(const MoveFile& move, std::size_t track, std::size_t values);

}  // namespace inbetween
