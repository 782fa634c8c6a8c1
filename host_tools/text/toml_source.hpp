// Makes a TOML file a toml::table. Reading is bounded, and toml++ parses.
//
// A file is at most 8 MiB of UTF-8 text. One pass over the text first refuses what would cost toml++
// unbounded stack or quadratic time (see parse_toml). Every refusal is an InputError.
#pragma once

#include <toml++/toml.h>

#include <cstddef>
#include <string>
#include <string_view>

#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/text_file.hpp"

namespace inbetween {

/// Our files nest four levels deep. toml++ and its destructors recurse once per level.
inline constexpr std::size_t max_toml_nesting = 16;
/// Assignments and table headers. toml++ looks dotted keys up in a list, which is quadratic: this many take a
/// few seconds at worst. A move of 10 000 keys with every field has 70 000.
inline constexpr std::size_t max_toml_fields = 200'000;

/// Parses TOML 1.0 text; a byte order mark and CRLF are accepted. Throws InputError at line and column for
/// invalid UTF-8, nesting beyond max_toml_nesting (brackets, and dots of one key), more than max_toml_fields
/// fields, and whatever is not TOML, duplicate keys included. Stack use is bounded.
toml::table parse_toml(std::string_view text, const std::string& file_name);

/// The beginning of `node` in its file.
Place place_of(const toml::node& node);

/// The byte of `text` at a place in it that the parser gave. Columns are code points, lines end with '\n'
/// only, as toml++ counts, and a byte order mark is before the first column.
std::size_t offset_of(std::string_view text, const Place& place);

}  // namespace inbetween
