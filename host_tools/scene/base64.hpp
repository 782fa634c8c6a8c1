// Bytes as text (RFC 4648, 4).
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace inbetween {

std::string base64_of(std::string_view bytes);
/// Nothing where it is none: another sign, or a length that is no multiple of 4.
std::optional<std::string> bytes_of_base64(std::string_view text);

}  // namespace inbetween
