// The counters of the buses and outputs of a rig while it is used.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/can/socket_can.hpp"
#include "drivers/gpio/step_player.hpp"
#include "inbetween/can/bus_port.hpp"
#include "inbetween/can/drive_counters.hpp"
#include "inbetween/steps/cue_timer.hpp"
#include "inbetween/steps/step_generator.hpp"

namespace inbetween {

/// A counter by the name that it has in reports.
struct Count {
  const char* name = "";
  std::int64_t count = 0;
  bool is_traffic = false;  ///< grows also where nothing is wrong
};

/// The counters of one bus or drive.
struct Counted {
  std::string of;  ///< the name of the bus, the axis of the drive, or the label of the chip
  std::vector<Count> counts;
};

struct Counters {
  std::vector<Counted> buses;   ///< in the order of the first axis on each
  std::vector<Counted> drives;  ///< on buses, in the order of their axes, and then those that take steps
  std::vector<Counted> chips;   ///< GPIO chips with planned edges: those of steps, then those of pulses
  std::vector<Count> pulses;    ///< on the outputs; empty for a rig without
};

/// The counters of a bus; `socket` is null for a simulated one.
std::vector<Count> counts_of(const can::LaneCounters& lane, const can::CanCounters* socket);
std::vector<Count> counts_of(const can::DriveCounters& drive);
std::vector<Count> counts_of(const StepDelays& delays);
std::vector<Count> counts_of(const gpio::StepPlayerCounters& edges);
std::vector<Count> counts_of(const CueCounters& pulses);

/// All that are not 0 and no mere traffic: "bus can0: floods 2; tilt: bad frames 12, missed 12"; "" for none.
std::string trouble_of(const Counters& counts);

}  // namespace inbetween
