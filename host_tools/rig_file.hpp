// A rig: the machine, its axes, limits and drives. docs/formats.md is the manual of the file.
//
// Reading checks everything that can be seen in the file alone: types, ranges, names and addresses taken
// twice, positions that a drive cannot count to, a tick that CiA 402 cannot state. It opens no bus and no
// chip.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host_tools/diagnostics.hpp"

namespace inbetween {

inline constexpr std::int32_t max_rate_hz = 20'000;
inline constexpr std::size_t max_rig_axes = 64;
inline constexpr std::int64_t max_line_offset = 65'535;
/// ODrive and moteus take positions as float32 turns. Up to here they are at most 1/1024 turn apart.
inline constexpr double max_turns = 16'384;

enum class AxisUnit { mm, m, deg, rad, turn, unit };
std::string_view to_string(AxisUnit unit);

/// A CAN bus, by the name of its Linux network interface.
struct Bus {
  std::string name;
  std::int64_t bitrate = 0;  // bit/s, of the arbitration phase on CAN FD
  Place place;
};

// Scales are signed (the sign reverses the motor) and never 0; position 0 is count 0.
struct Cia402Drive {
  std::string bus;
  int node = 0;  // 1..127
  double counts_per_unit = 0;
};
struct OdriveDrive {
  std::string bus;
  int node = 0;  // 0..63
  double turns_per_unit = 0;
};
struct MoteusDrive {
  std::string bus;
  int node = 0;  // 1..127
  double turns_per_unit = 0;
};

/// A GPIO line by its offset on the chip, or by its name.
using GpioLine = std::variant<int, std::string>;
struct StepDirDrive {
  std::string chip;  // label, never "gpiochipN"
  GpioLine step;
  GpioLine dir;
  std::optional<GpioLine> enable;
  double steps_per_unit = 0;
};
struct PipeDrive {
  std::string path;
  double counts_per_unit = 0;
};
using Drive = std::variant<Cia402Drive, OdriveDrive, MoteusDrive, StepDirDrive, PipeDrive>;

/// Limits are magnitudes in unit, unit/s, unit/s^2, unit/s^3, all above 0.
struct RigAxis {
  std::string name;
  AxisUnit unit = AxisUnit::unit;
  double min = 0;
  double max = 0;
  double max_velocity = 0;
  double max_acceleration = 0;
  std::optional<double> max_jerk;
  std::optional<double> max_acceleration_step;  // unit/s^2
  std::optional<double> stop_acceleration;      // absent: 1.5 * max_acceleration
  std::optional<double> stop_jerk;              // absent: 1.5 * max_jerk
  Drive drive;
  Place place;
};

struct RigFile {
  std::string path;
  std::string name;
  std::int32_t rate_hz = 0;
  std::vector<Bus> buses;  // in alphabetical order
  std::vector<RigAxis> axes;
};

/// Whether CiA 402 can state the tick exactly: the period is a whole number of microseconds (SYNC, object
/// 1006h) and value * 10^index seconds with value 1..255 (interpolation time period, object 60C2h).
bool is_cia402_rate(std::int32_t rate_hz);

/// Reads and checks a rig. Throws InputError at the first thing that is wrong.
RigFile read_rig_file(const std::filesystem::path& path);

/// The same from text; `file_name` stands in places and in RigFile::path.
RigFile parse_rig(std::string_view text, const std::string& file_name);

}  // namespace inbetween
