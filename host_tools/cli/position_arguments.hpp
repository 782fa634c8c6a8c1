// "pan=-20": axes and positions as a command line says them.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace inbetween {

/// The whole of `text` as a finite number.
std::optional<double> number_of(std::string_view text);

/// The position that each text AXIS=POSITION names. Throws UsageError, which names `argument`.
std::map<std::string, double> positions_of(const std::vector<std::string>& texts,
                                           const std::string& argument = "--from");

}  // namespace inbetween
