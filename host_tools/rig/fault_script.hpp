// A script of faults: which faults the simulated drives of a rig have, and when. docs/formats.md is the
// manual of the file.
//
// The reader checks the file against its rig: types, ranges, names of axes, fields that do not belong to a
// fault, positions that a drive cannot count to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/rig_model/rig_file.hpp"
#include "sim/drive_trouble.hpp"

namespace inbetween {

inline constexpr std::size_t max_faults = 1000;
inline constexpr double max_fault_seconds = 86'400;
/// More than any CAN bus carries.
inline constexpr std::int64_t max_flood_per_s = 100'000;

struct ScriptedFault {
  std::size_t axis = 0;  ///< index of an axis of the rig; its drive is on a CAN bus
  std::string what;      ///< the word in the file
  /// Its `at_ns` counts from power-on, or from the first motion of the rig.
  DriveTrouble trouble;
  bool is_after_motion = false;
};

struct FaultScript {
  std::string path;
  std::vector<ScriptedFault> faults;  ///< in the order of the file
};

/// Reads and checks a script for this rig. Throws InputError at the first thing that is wrong.
FaultScript read_fault_script(const std::filesystem::path& path, const RigFile& rig);

/// The same from text; `file_name` stands in places and in FaultScript::path.
FaultScript parse_fault_script(std::string_view text, const std::string& file_name, const RigFile& of);

}  // namespace inbetween
