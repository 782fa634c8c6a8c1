// "pan=-20": where axes stand, from a command line.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace inbetween {

/// The whole of `text` as a finite number.
std::optional<double> number_of(std::string_view text);

/// Of AXIS=POSITION each, said with `argument`. Throws UsageError.
std::map<std::string, double> positions_of(const std::vector<std::string>& texts,
                                           const std::string& argument = "--from");

}  // namespace inbetween
