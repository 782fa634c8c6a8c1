#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/can/socket_can.hpp"

namespace inbetween::can {

/// A CAN interface as the kernel has it set up.
struct CanLink {
  bool is_up = false;
  bool carries_fd = false;
  std::uint32_t queue_frames = 0;  ///< that wait to be sent at most (txqueuelen); 0: no limit
  // A virtual interface has none of these.
  std::optional<std::uint32_t> bitrate{};                ///< bit/s
  std::optional<std::uint32_t> data_bitrate{};           ///< bit/s, of CAN FD
  std::optional<std::uint32_t> sample_point_permille{};  ///< of a bit
  std::optional<ControllerState> controller{};
};

/// Asks the kernel (rtnetlink, RTM_GETLINK) and waits for its answer; nobody needs rights for that. Nothing
/// where there is no such CAN interface.
std::optional<CanLink> read_can_link(const std::string& interface);
/// The same, from the answer.
std::optional<CanLink> parse_can_link(std::span<const std::byte> answer);

}  // namespace inbetween::can
