// A move file with another speed curve in it, and otherwise the file that its author wrote.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace inbetween {

/// `text`, a move, with the numbers in the `speed` of track `track` (counted from 0) replaced by `speed`.
/// All else stays byte for byte: comments, also those inside the list, spacing, line ends, a byte order mark,
/// the other tracks. Number i stands where number i stood; further ones follow the last, spaced as the last
/// two were, or by a comma and a blank where a comment is between these; where there are fewer, the surplus
/// numbers go with the comma before them. Numbers are written in the shortest form that reads back to the
/// same double, whole ones without a decimal point.
///
/// The result has been read again: it is the same move in everything but this speed curve.
///
/// `speed`: 1 or more values 0..100, otherwise std::invalid_argument; std::out_of_range where the move has no
/// such track. `file_name` stands in the places of diagnostics. Throws InputError where `text` is not a move,
/// where the track has no speed curve (timing = "frames"), where `speed` has more than max_control_values,
/// and where the result would have more than max_file_bytes.
///
/// Cost: the text is parsed twice.
std::string with_speed(std::string_view text, const std::string& file_name, std::size_t track,
                       std::span<const double> speed);

}  // namespace inbetween
