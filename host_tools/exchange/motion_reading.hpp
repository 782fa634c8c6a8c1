// What a file is that somebody imports, and its reader with what was said of it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "host_tools/exchange/exchange_format.hpp"
#include "host_tools/exchange/record_table.hpp"
#include "host_tools/exchange/table_csv.hpp"

namespace inbetween {

/// Takes and robots are no motions in a format of another program.
enum class ImportedFile : std::uint8_t { motion, takes, robot };
ImportedFile imported_file_of(const std::string& file, std::string_view text);

/// What nobody can see in the file.
struct MotionReading {
  CsvReading csv = {};
  RecordedPositions positions = RecordedPositions::told;  // of a record
};

/// Throws InputError as the reader of the format does.
BakedTable read_motion(ExchangeFormat format, std::string_view text, const std::string& file,
                       const MotionReading& reading);

/// "comma", "semicolon" and "tab".
std::optional<char> separator_of_word(std::string_view word);

}  // namespace inbetween
