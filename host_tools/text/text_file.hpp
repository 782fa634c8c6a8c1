// Reads a file as a whole.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace inbetween {

/// That a text may begin with, in UTF-8.
inline constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
inline constexpr std::size_t max_file_bytes = std::size_t{8} << 20U;

/// The bytes of a file. Throws InputError at the file as a whole if it is missing, a directory, unreadable,
/// or above `max_bytes` (a regular file is then not read at all).
std::string read_text_file(const std::filesystem::path& path, std::size_t max_bytes = max_file_bytes);
/// How the files that a file names are read, each with its bound in bytes: read_text_file, or from where
/// their texts are kept.
using TextReader = std::function<std::string(const std::filesystem::path&, std::size_t)>;

}  // namespace inbetween
