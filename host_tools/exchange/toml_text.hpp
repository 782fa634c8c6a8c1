// Texts of TOML files that are written.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace inbetween {

/// A basic string: quotes and backslashes are escaped, and so are control characters.
std::string toml_quoted(std::string_view text);
/// `["pan", "tilt"]`.
std::string toml_list(const std::vector<std::string>& texts);
/// A line of a comment: control characters, which a comment may not have, are blanks.
std::string toml_comment(std::string_view text);

}  // namespace inbetween
