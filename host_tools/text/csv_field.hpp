// Text in comma-separated values.
#pragma once

#include <string>

namespace inbetween {

/// A field with a comma or a quote is quoted as RFC 4180 says.
std::string csv_field(const std::string& text);

}  // namespace inbetween
