// Messages of a byte stream that are known byte for byte, kept as data.
#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/places.hpp"

namespace inbetween {

/// By their names, from a file of tests/golden.
inline std::map<std::string, std::vector<std::uint8_t>> golden_bytes(const std::string& file_name) {
  std::ifstream file(in_checkout("tests/golden/" + file_name));
  std::map<std::string, std::vector<std::uint8_t>> messages;
  for (const nlohmann::json& entry : nlohmann::json::parse(file)) {
    const std::string hex = entry.at("hex");
    std::vector<std::uint8_t>& bytes = messages[entry.at("name")];
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
      bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
    }
  }
  return messages;
}

}  // namespace inbetween
