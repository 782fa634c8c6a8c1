// Whether a CAN interface is as a bus of the rig needs it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/can/can_link.hpp"
#include "host_tools/doctor/finding.hpp"

namespace inbetween {

/// What a rig asks of a bus.
struct BusNeeds {
  std::int64_t bitrate = 1'000'000;
  std::optional<std::int64_t> data_bitrate{};  ///< of drives that speak CAN FD
  std::int64_t frames_per_tick = 0;            ///< that are sent at once
};

/// `link` is nothing where there is no such CAN interface; `needs` where no rig says any.
Findings check_bus(const std::string& name, const std::optional<can::CanLink>& link,
                   const std::optional<BusNeeds>& needs);

}  // namespace inbetween
