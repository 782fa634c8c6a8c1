// Any text is a rig that keeps every promise of host_tools/rig_file.hpp, or is refused in one line.
#include "host_tools/rig_file.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <set>
#include <string_view>

#include "tests/fuzz/targets/refusal.hpp"

namespace inbetween {
namespace {

void require_positive(const std::optional<double>& limit) {
  fuzz_require(!limit || (std::isfinite(*limit) && *limit > 0), "a limit is positive");
}

/// A scale and the positions that it takes the ends of the axis to.
void require_scale(const RigAxis& axis, double scale, double most) {
  fuzz_require(std::isfinite(scale) && scale != 0, "a scale is a number that is not 0");
  fuzz_require(std::fabs(std::round(axis.min * scale)) <= most, "a drive can count to min");
  fuzz_require(std::fabs(std::round(axis.max * scale)) <= most, "a drive can count to max");
}

void require_drive(const RigAxis& axis) {
  const double most_counts = std::numeric_limits<std::int32_t>::max();
  if (const auto* cia402 = std::get_if<Cia402Drive>(&axis.drive)) {
    fuzz_require(cia402->node >= 1 && cia402->node <= 127, "a CiA 402 node is in 1..127");
    require_scale(axis, cia402->counts_per_unit, most_counts);
  } else if (const auto* odrive = std::get_if<OdriveDrive>(&axis.drive)) {
    fuzz_require(odrive->node >= 0 && odrive->node <= 63, "an ODrive node is in 0..63");
    require_scale(axis, odrive->turns_per_unit, max_turns);
  } else if (const auto* moteus = std::get_if<MoteusDrive>(&axis.drive)) {
    fuzz_require(moteus->node >= 1 && moteus->node <= 127, "a moteus node is in 1..127");
    require_scale(axis, moteus->turns_per_unit, max_turns);
  } else if (const auto* step_dir = std::get_if<StepDirDrive>(&axis.drive)) {
    fuzz_require(!step_dir->chip.empty() && step_dir->step != step_dir->dir, "step and dir are two lines");
    require_scale(axis, step_dir->steps_per_unit, most_counts);
  } else if (const auto* pipe = std::get_if<PipeDrive>(&axis.drive)) {
    fuzz_require(!pipe->path.empty(), "a pipe has a path");
    require_scale(axis, pipe->counts_per_unit, most_counts);
  }
}

void require_axis(const RigAxis& axis) {
  fuzz_require(!axis.name.empty(), "an axis has a name");
  fuzz_require(std::isfinite(axis.min) && std::isfinite(axis.max) && axis.min < axis.max, "min is below max");
  require_positive(axis.max_velocity);
  require_positive(axis.max_acceleration);
  require_positive(axis.max_jerk);
  require_positive(axis.max_acceleration_step);
  require_positive(axis.stop_acceleration);
  require_positive(axis.stop_jerk);
  require_drive(axis);
}

void require_rig(const RigFile& rig) {
  fuzz_require(!rig.name.empty(), "a rig has a name");
  fuzz_require(rig.rate_hz >= 1 && rig.rate_hz <= max_rate_hz, "a rate is in its range");
  fuzz_require(!rig.axes.empty() && rig.axes.size() <= max_rig_axes, "a rig has axes");
  std::set<std::string_view> names;
  for (const RigAxis& axis : rig.axes) {
    fuzz_require(names.insert(axis.name).second, "an axis has a name of its own");
    require_axis(axis);
    const bool counts_time = std::holds_alternative<Cia402Drive>(axis.drive);
    fuzz_require(!counts_time || is_cia402_rate(rig.rate_hz), "CiA 402 can state the rate");
  }
}

}  // namespace
}  // namespace inbetween

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  try {
    inbetween::require_rig(inbetween::parse_rig(text, "any.toml"));
  } catch (const inbetween::InputError& error) {
    require_one_line(error, "any.toml");
  }
  return 0;
}
