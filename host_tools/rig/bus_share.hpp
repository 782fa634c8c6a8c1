#pragma once

#include <cstdint>
#include <string>

namespace inbetween {

/// What the drives on a bus take of it in a tick.
struct BusShare {
  std::int64_t drives = 0;
  std::int64_t frames = 0;       ///< that the host sends at most
  std::int64_t bits = 0;         ///< of both directions, at worst
  std::int64_t bits_of_bus = 0;  ///< those of them that any number of drives share
  std::string because{};         ///< stands in words before the frames: ", 2 of them guarded,"
};

/// How a simulated drive gets its power.
struct SimulatedPower {
  double position = 0;  ///< of its axis, in axis units
  std::int64_t now_ns = 0;
  bool keeps_record = false;
};

}  // namespace inbetween
