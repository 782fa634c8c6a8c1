#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "host_tools/text/diagnostics.hpp"
#include "tests/fuzz/targets/fuzz_require.hpp"

/// A line for a terminal, at a place of the file that was read.
inline void require_one_line(std::string_view line, std::string_view file_name) {
  fuzz_require(line.starts_with(file_name), "a refusal names the file");
  fuzz_require(line.find(": error: ") != line.npos, "a refusal is marked as an error");
  for (const char c : line) {
    const auto byte = static_cast<unsigned char>(c);
    fuzz_require(byte >= 0x20 && byte != 0x7f, "a refusal has no control characters");
  }
}

/// What every refusal of a reader must be.
inline void require_one_line(const inbetween::InputError& error, std::string_view file_name) {
  fuzz_require(!error.message().empty(), "a refusal says something");
  require_one_line(std::string_view(error.what()), file_name);
}

namespace inbetween {

/// Hands the bytes as a text, and the name of its file, to `read`, which refuses it in one line or returns.
template <class Read>
int fuzz_text(const std::uint8_t* bytes, std::size_t size, const char* file, const Read& read) {
  try {
    read(std::string_view(reinterpret_cast<const char*>(bytes), size), file);
  } catch (const InputError& error) {
    require_one_line(error, file);
  }
  return 0;
}

}  // namespace inbetween
