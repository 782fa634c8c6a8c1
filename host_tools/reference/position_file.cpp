#include "host_tools/reference/position_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>

#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/state_folder.hpp"
#include "inbetween/base/hash.hpp"

namespace inbetween {
namespace {

constexpr const char* nobody_has_said = "nobody has said where it is";

class Identity {
 public:
  void add(std::string_view text) {
    hash_.add(static_cast<std::uint64_t>(text.size()), 8);
    for (const char byte : text) hash_.add(static_cast<unsigned char>(byte), 1);
  }
  void add(double number) { hash_.add(number); }
  void add(int number) { hash_.add(static_cast<std::int32_t>(number)); }
  void add(const GpioLine& line) {
    add(static_cast<int>(line.index()));
    std::visit([this](const auto& which) { add(which); }, line);
  }
  void add(const std::string& text) { add(std::string_view(text)); }

  void add(const Cia402Drive& drive) { add_node(drive.bus, drive.node, drive.counts_per_unit); }
  void add(const OdriveDrive& drive) { add_node(drive.bus, drive.node, drive.turns_per_unit); }
  void add(const MoteusDrive& drive) { add_node(drive.bus, drive.node, drive.turns_per_unit); }
  void add(const RmdDrive& drive) { add_node(drive.bus, drive.node, drive.turns_per_unit); }
  void add(const CubemarsDrive& drive) { add_node(drive.bus, drive.node, drive.turns_per_unit); }
  void add(const StepDirDrive& drive) {
    add(drive.chip);
    add(drive.step);
    add(drive.dir);
    add(drive.steps_per_unit);
  }
  void add(const PipeDrive& drive) {
    add(drive.path);
    add(drive.counts_per_unit);
  }
  void add(const Home& home) {
    add(home.input.address.chip);
    add(home.input.address.line);
    add(home.direction);
    add(home.at);
  }

  void add(const DriveHome& home) {
    add(home.method);
    add(home.at);
  }

  /// What lies between the axis and its motors.
  void add_gear(const RigAxis& axis) {
    add(axis.offset);
    add(axis.backlash ? axis.backlash->play : 0.0);
    add(axis.backlash && axis.backlash->approach_is_up ? 1 : 0);
    if (axis.calibration) {
      for (const CalibrationMark& mark : axis.calibration->marks) {
        add(mark.axis);
        add(mark.motor);
      }
    }
    for (const GangedMotor& motor : axis.ganged) {
      add(motor.offset);
      std::visit([this](const auto& drive) { add(drive); }, motor.drive);
    }
  }

  [[nodiscard]] std::uint64_t value() const { return hash_.value(); }

 private:
  void add_node(const std::string& bus, int node, double scale) {
    add(bus);
    add(node);
    add(scale);
  }

  Fnv1a hash_;
};

[[noreturn]] void fail(const std::string& path, const FileFailure& failure) {
  const bool is_full = failure.error == ENOSPC || failure.error == EDQUOT;
  throw std::runtime_error(fmt::format(
      "{}: error: the positions of the axes cannot be kept, {} {}: {}; {}", path, failure.path, failure.what,
      std::generic_category().message(failure.error),
      is_full ? "make room on the disk" : "make the folder one that you may write to, or choose another"));
}

}  // namespace

std::vector<std::size_t> kept_axes(const RigFile& rig) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < rig.axes.size(); ++i) {
    if (rig.axes[i].reference != Reference::by_drive) kept.push_back(i);
  }
  return kept;
}

std::uint64_t position_identity(const RigFile& rig) {
  Identity identity;
  identity.add(rig.name);
  for (const std::size_t index : kept_axes(rig)) {
    const RigAxis& axis = rig.axes[index];
    identity.add(axis.name);
    identity.add(static_cast<int>(axis.unit));
    identity.add(static_cast<int>(axis.drive.index()));
    std::visit([&](const auto& drive) { identity.add(drive); }, axis.drive);
    if (has_gear(axis)) identity.add_gear(axis);
    identity.add(axis.home ? 1 : 0);
    if (axis.home) identity.add(*axis.home);
    if (axis.drive_home) identity.add(*axis.drive_home);
  }
  return identity.value();
}

std::string position_file_path(const std::string& rig_name, const char* xdg_state_home, const char* home) {
  const auto folder = state_folder(xdg_state_home, home);
  if (!folder) {
    throw std::runtime_error(
        "error: there is no folder for the positions of the axes; set XDG_STATE_HOME or HOME to one");
  }
  return (*folder / state_file_name(rig_name, rig_name, "positions")).string();
}

PositionFile::PositionFile(std::string path, const RigFile& rig, FileLayer files)
    : path_(std::move(path)), files_(std::move(files)) {
  kept_.rig = rig.name;
  kept_.identity = position_identity(rig);
  for (const std::size_t axis : kept_axes(rig)) {
    kept_.axes.push_back({.name = rig.axes[axis].name});
    known_.push_back({.axis = axis, .position = std::nullopt, .zeros = {}, .why = ""});
  }

  std::string why;
  std::string text;
  if (const int error = files_.read(path_, max_position_bytes, text)) {
    why = error == ENOENT
              ? fmt::format("no position has been kept for it in {}", path_)
              : fmt::format("{} cannot be read: {}", path_, std::generic_category().message(error));
  } else {
    auto parsed = parse_positions(text);
    if (const auto* problem = std::get_if<std::string>(&parsed)) {
      why = fmt::format("{} {}", path_, *problem);
    } else {
      auto& kept = std::get<KeptPositions>(parsed);
      why = why_not(kept);
      if (why.empty()) kept_ = std::move(kept);
    }
  }
  for (std::size_t i = 0; i < known_.size(); ++i) {
    const KeptAxis& axis = kept_.axes[i];
    if (!why.empty()) {
      known_[i].why = why;
    } else if (axis.rest == AxisRest::at) {
      known_[i].position = axis.position;
      known_[i].zeros = axis.zeros;
    } else {
      known_[i].why = axis.rest == AxisRest::moving
                          ? "it was moving when the power was cut or the program ended"
                          : "nobody has said where it is";
    }
  }
}

/// Why `kept` does not hold for this rig; empty if it does.
std::string PositionFile::why_not(const KeptPositions& kept) const {
  if (kept.rig != kept_.rig) return fmt::format("{} is of another rig, {}", path_, in_quotes(kept.rig));
  const auto has_same_name = [](const KeptAxis& a, const KeptAxis& b) { return a.name == b.name; };
  const bool same_axes =
      std::equal(kept.axes.begin(), kept.axes.end(), kept_.axes.begin(), kept_.axes.end(), has_same_name);
  if (!same_axes) return fmt::format("the rig had other axes when {} was written", path_);
  if (kept.identity != kept_.identity) {
    return fmt::format("a unit, a drive or a home of the rig has changed since {} was written", path_);
  }
  return "";
}

void PositionFile::about_to_move(std::span<const std::size_t> axes) {
  KeptPositions kept = kept_;
  std::vector<KnownAxis> known = known_;
  bool any = false;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (std::find(axes.begin(), axes.end(), known[i].axis) == axes.end()) continue;
    any = true;
    kept.axes[i] = {.name = kept.axes[i].name, .rest = AxisRest::moving};
    known[i] = {.axis = known[i].axis, .position = std::nullopt, .zeros = {}, .why = "it moves"};
  }
  if (!any) return;
  write(kept);  // if it throws, nothing moves, and what is known stays so
  kept_ = std::move(kept);
  known_ = std::move(known);
}

void PositionFile::at_rest(std::span<const Rest> rests) {
  for (const Rest& rest : rests) {
    const auto known = std::find_if(known_.begin(), known_.end(),
                                    [&](const KnownAxis& axis) { return axis.axis == rest.axis; });
    if (known == known_.end() || (rest.position && !std::isfinite(*rest.position))) {
      throw std::logic_error("a position is kept of an axis that has none");
    }
    const auto i = static_cast<std::size_t>(known - known_.begin());
    kept_.axes[i] = {.name = kept_.axes[i].name,
                     .rest = rest.position ? AxisRest::at : AxisRest::unreferenced,
                     .position = rest.position.value_or(0),
                     .zeros = rest.position ? rest.zeros : std::vector<double>()};
    *known = {.axis = rest.axis,
              .position = rest.position,
              .zeros = kept_.axes[i].zeros,
              .why = rest.position ? "" : nobody_has_said};
  }
  write(kept_);
}

void PositionFile::write(const KeptPositions& kept) {
  const std::string folder = std::filesystem::path(path_).parent_path().string();
  if (!folder.empty()) {
    if (const FileFailure failure = make_folders(files_, folder)) fail(path_, failure);
  }
  if (const FileFailure failure = replace_durably(files_, path_, to_text(kept))) fail(path_, failure);
}

std::unique_ptr<InstanceLock> lock_positions(const std::string& path) {
  std::error_code error;
  const std::filesystem::path file = std::filesystem::weakly_canonical(path, error);
  if (error) throw InputError({path, 0, 0}, fmt::format("cannot be found: {}", error.message()));
  Identity hash;
  hash.add(file.string());
  auto lock = std::make_unique<InstanceLock>();
  if (const auto refusal = lock->take(fmt::format("positions {:016x}", hash.value()), "these positions")) {
    refuse_at({path, 0, 0}, *refusal);
  }
  return lock;
}

std::string usual_position_file(const RigFile& rig) {
  return position_file_path(rig.name, std::getenv("XDG_STATE_HOME"), std::getenv("HOME"));
}

}  // namespace inbetween
