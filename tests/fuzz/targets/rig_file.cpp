// Any text is a rig that keeps every promise of host_tools/rig_model/rig_file.hpp, or is refused in one line.
#include "host_tools/rig_model/rig_file.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <set>
#include <string_view>
#include <vector>

#include "tests/fuzz/targets/refusal.hpp"

namespace inbetween {
namespace {

void require_positive(const std::optional<double>& limit) {
  fuzz_require(!limit || (std::isfinite(*limit) && *limit > 0), "a limit is positive");
}

/// A scale and the positions that it takes the ends of the axis to.
void require_scale(const RigAxis& axis, double scale, double max_count) {
  fuzz_require(std::isfinite(scale) && scale != 0, "a scale is a number that is not 0");
  fuzz_require(std::fabs(std::round(axis.min * scale)) <= max_count, "a drive can count to min");
  fuzz_require(std::fabs(std::round(axis.max * scale)) <= max_count, "a drive can count to max");
}

void require_step_times(const RigAxis& axis, const StepDirDrive& drive) {
  fuzz_require(drive.max_step_rate > 0 && drive.max_step_rate <= max_step_rate,
               "a step rate is in its range");
  fuzz_require(std::fabs(drive.steps_per_unit) * axis.max_velocity <= drive.max_step_rate,
               "an axis is no faster than its drive may step");
  for (const std::int64_t time_ns :
       {drive.pulse_ns, drive.pause_ns, drive.dir_setup_ns, drive.dir_hold_ns, drive.latest_ns}) {
    fuzz_require(time_ns >= 1 && time_ns <= 1'000'000'000, "a time is in its range");
  }
  fuzz_require(static_cast<double>(drive.pulse_ns + drive.pause_ns) <= 1e9 / drive.max_step_rate,
               "pulse and pause permit the step rate");
}

/// The lines of a rig, and that none is used twice.
class Lines {
 public:
  void add(const LineAddress& address) {
    const auto* offset = std::get_if<int>(&address.line);
    fuzz_require(offset == nullptr || (*offset >= 0 && !address.chip.empty()), "an offset has a chip");
    for (const LineAddress& other : lines_) {
      fuzz_require(!is_same_line(address, other), "a line is used once");
    }
    lines_.push_back(address);
  }
  void add(const std::optional<InputLine>& input) {
    if (input) add(input->address);
  }

 private:
  std::vector<LineAddress> lines_;
};

/// Whether a broken wire would leave the input at `level`.
bool is_pulled_to(const InputLine& input, Level level) {
  return input.bias == (level == Level::high ? Bias::pull_up : Bias::pull_down);
}

void require_home(const RigAxis& axis) {
  fuzz_require((axis.reference == Reference::by_home) == axis.home.has_value(), "a home is used");
  fuzz_require(axis.reference != Reference::by_drive || !is_open_loop(axis.drive),
               "a drive that is asked knows");
  fuzz_require(!axis.park || (*axis.park >= axis.min && *axis.park <= axis.max), "it parks in its range");
  if (!axis.home) return;
  const Home& home = *axis.home;
  fuzz_require(is_open_loop(axis.drive), "a drive that knows is not homed");
  fuzz_require(home.direction == 1 || home.direction == -1, "a switch is on one side");
  fuzz_require(home.slow > 0 && home.slow < home.fast && home.fast <= axis.max_velocity,
               "slow is below fast");
  fuzz_require(home.back_off > 0 && home.search > 0 && std::isfinite(home.at), "a search has a length");
}

void require_lines(const RigFile& rig) {
  Lines lines;
  for (const RigAxis& axis : rig.axes) {
    if (const auto* drive = std::get_if<StepDirDrive>(&axis.drive)) {
      lines.add({drive->chip, drive->step, {}});
      lines.add({drive->chip, drive->dir, {}});
      if (drive->enable) lines.add({drive->chip, *drive->enable, {}});
    }
    if (axis.home) lines.add(axis.home->input.address);
    lines.add(axis.limit_min);
    lines.add(axis.limit_max);
  }
  lines.add(rig.emergency_stop);
  lines.add(rig.start_trigger);
  if (rig.camera) {
    lines.add(rig.camera->shutter.address);
    lines.add(rig.camera->asks);
  }
  fuzz_require(rig.outputs.size() <= max_rig_outputs, "outputs fit");
  for (const Output& output : rig.outputs) {
    fuzz_require(!output.name.empty() && output.name != "camera", "an output has a name of its own");
    lines.add(output.line.address);
  }
  const auto& stop = rig.emergency_stop;
  fuzz_require(!stop || !is_pulled_to(*stop, opposite(stop->active)), "a broken wire stops");
  const auto& start = rig.start_trigger;
  fuzz_require(!start || !is_pulled_to(*start, start->active), "a broken wire does not start");
}

void require_drive(const RigAxis& axis) {
  const double max_counts = std::numeric_limits<std::int32_t>::max();
  if (const auto* cia402 = std::get_if<Cia402Drive>(&axis.drive)) {
    fuzz_require(cia402->node >= 1 && cia402->node <= 127, "a CiA 402 node is in 1..127");
    require_scale(axis, cia402->counts_per_unit, max_counts);
  } else if (const auto* odrive = std::get_if<OdriveDrive>(&axis.drive)) {
    fuzz_require(odrive->node >= 0 && odrive->node <= 62, "an ODrive node is in 0..62");
    require_scale(axis, odrive->turns_per_unit, max_turns);
    fuzz_require(std::fabs(odrive->turns_per_unit) * axis.max_velocity <= max_odrive_turns_per_s,
                 "an ODrive can be told every velocity");
    fuzz_require(odrive->follow.max_following_error > 0, "an ODrive has a window for its following error");
  } else if (const auto* rmd = std::get_if<RmdDrive>(&axis.drive)) {
    fuzz_require(rmd->node >= 1 && rmd->node <= 32, "an RMD motor is in 1..32");
    require_scale(axis, rmd->turns_per_unit, max_turns);
    fuzz_require(max_rmd_deg_per_s_of(axis) <= max_rmd_deg_per_s, "an RMD motor has a velocity limit");
    fuzz_require(rmd->follow.max_following_error > 0, "an RMD motor has a window for its following error");
  } else if (const auto* cubemars = std::get_if<CubemarsDrive>(&axis.drive)) {
    fuzz_require(cubemars->node >= 1 && cubemars->node <= 255, "a CubeMars motor is in 1..255");
    require_scale(axis, cubemars->turns_per_unit, max_cubemars_turns);
    const CubemarsLimits limits = cubemars_limits_of(axis);
    fuzz_require(limits.velocity <= CubemarsLimits::max && limits.stop_acceleration <= CubemarsLimits::max,
                 "a CubeMars motor has its limits");
  } else if (const auto* moteus = std::get_if<MoteusDrive>(&axis.drive)) {
    fuzz_require(moteus->node >= 1 && moteus->node <= 126, "a moteus node is in 1..126");
    fuzz_require(moteus->follow.max_following_error > 0, "a moteus has a window for its following error");
    require_scale(axis, moteus->turns_per_unit, max_turns);
  } else if (const auto* step_dir = std::get_if<StepDirDrive>(&axis.drive)) {
    fuzz_require(!step_dir->chip.empty() && step_dir->step != step_dir->dir, "step and dir are two lines");
    require_scale(axis, step_dir->steps_per_unit, max_counts);
    require_step_times(axis, *step_dir);
  } else if (const auto* pipe = std::get_if<PipeDrive>(&axis.drive)) {
    fuzz_require(!pipe->path.empty(), "a pipe has a path");
    require_scale(axis, pipe->counts_per_unit, max_counts);
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
  require_home(axis);
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
  require_lines(rig);
  const auto& kinematics = rig.kinematics;
  fuzz_require(!kinematics || (!kinematics->tips.empty() && !kinematics->urdf.empty()), "a tree has a tip");
}

}  // namespace
}  // namespace inbetween

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  return inbetween::fuzz_text(bytes, size, "any.toml", [](std::string_view text, const char* file) {
    inbetween::require_rig(inbetween::parse_rig(text, file));
  });
}
