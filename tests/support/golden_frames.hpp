// CAN frames that are known byte for byte, kept as data.
#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "inbetween/can/frame.hpp"
#include "tests/support/places.hpp"

namespace inbetween {

inline can::Frame frame_of_json(const nlohmann::json& entry) {
  const std::string bytes = entry.at("data_hex");
  can::Frame frame{.id = *can::FrameId::make(static_cast<std::uint32_t>(std::stoul(
                                                 entry.at("id_hex").get<std::string>(), nullptr, 16)),
                                             entry.at("extended")),
                   .is_remote = entry.value("rtr", false),
                   .length = static_cast<std::uint8_t>(bytes.size() / 2)};
  for (std::size_t i = 0; i < frame.length; ++i) {
    frame.data.at(i) = static_cast<std::uint8_t>(std::stoul(bytes.substr(2 * i, 2), nullptr, 16));
  }
  return frame;
}

/// By their names, from a file of tests/golden.
inline std::map<std::string, can::Frame> golden_frames(const std::string& file_name) {
  std::ifstream file(in_checkout("tests/golden/" + file_name));
  std::map<std::string, can::Frame> frames;
  for (const nlohmann::json& entry : nlohmann::json::parse(file)) {
    frames[entry.at("name")] = frame_of_json(entry);
  }
  return frames;
}

}  // namespace inbetween
