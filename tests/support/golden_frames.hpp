// CAN frames that are known byte for byte, kept as data.
#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>

#include "inbetween/can/fd_frame.hpp"
#include "inbetween/can/frame.hpp"
#include "tests/support/places.hpp"

namespace inbetween {

template <class Frame>
Frame frame_of_json(const nlohmann::json& entry) {
  const std::string bytes = entry.at("data_hex");
  const auto id = static_cast<std::uint32_t>(std::stoul(entry.at("id_hex").get<std::string>(), nullptr, 16));
  Frame frame{.id = *can::FrameId::make(id, entry.value("extended", false)),
              .length = static_cast<std::uint8_t>(bytes.size() / 2)};
  if constexpr (std::is_same_v<Frame, can::FdFrame>) {
    frame.is_classic = !entry.at("fd");
  } else {
    frame.is_remote = entry.value("rtr", false);
  }
  for (std::size_t i = 0; i < frame.length; ++i) {
    frame.data.at(i) = static_cast<std::uint8_t>(std::stoul(bytes.substr(2 * i, 2), nullptr, 16));
  }
  return frame;
}

/// By their names, from a file of tests/golden; also can::FdFrame.
template <class Frame = can::Frame>
std::map<std::string, Frame> golden_frames(const std::string& file_name) {
  std::ifstream file(in_checkout("tests/golden/" + file_name));
  std::map<std::string, Frame> frames;
  for (const nlohmann::json& entry : nlohmann::json::parse(file)) {
    frames[entry.at("name")] = frame_of_json<Frame>(entry);
  }
  return frames;
}

}  // namespace inbetween
