#include "host_tools/reference/rig_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "host_tools/files/diagnostics.hpp"

namespace inbetween {

RigReference::RigReference(const RigFile& rig, std::string file, FileLayer files) : RigReference(rig) {
  file_.emplace(std::move(file), rig, std::move(files));
  for (const KnownAxis& known : file_->axes()) {
    axes_[known.axis] = {.position = known.position, .why = known.why};
  }
}

bool RigReference::is_kept(std::size_t axis) const {
  return rig_.axes[axis].reference != Reference::by_drive;
}

void RigReference::place(RigDrives& drives) const {
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    if (axes_[a].position && !rig_.axes[a].drive_home) drives.place(a, *axes_[a].position);
  }
}

void RigReference::refuse_elsewhere(std::span<const double> positions) {
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    const RigAxis& axis = rig_.axes[a];
    if (!axis.drive_home || !axes_[a].position) continue;
    const double left = *axes_[a].position;
    if (std::fabs(positions[a] - left) <= place_tolerance(axis)) continue;
    is_lost(a, "its drive told another position than the one at which it was left");
    throw InputError(
        axis.place,
        fmt::format(
            "axis {} was left at {:g} {}, and its drive tells {:g}: it was without power, or the axis "
            "was moved; let it home with inbetween home",
            in_quotes(axis.name), left, to_string(axis.unit), positions[a]));
  }
}

void RigReference::refuse_unreferenced(std::span<const std::size_t> axes) const {
  for (const std::size_t a : axes) {
    if (is_referenced(a)) continue;
    const RigAxis& axis = rig_.axes[a];
    const char* const remedy = axis.home ? "send it to its switch with inbetween home"
                               : axis.drive_home
                                   ? "let its drive home it with inbetween home"
                                   : "bring it to its mark with inbetween jog, and say so with inbetween "
                                     "goto --set-zero";
    throw InputError(axis.place, fmt::format("axis {} does not know where it is: {}; {}",
                                             in_quotes(axis.name), axes_[a].why, remedy));
  }
}

void RigReference::about_to_move(std::span<const std::size_t> axes) {
  std::vector<std::size_t> begin;
  for (const std::size_t a : axes) {
    if (!axes_[a].moves) begin.push_back(a);
  }
  if (file_) file_->about_to_move(begin);
  for (const std::size_t a : begin) axes_[a].moves = true;
}

void RigReference::at_rest(const RigDrives& drives, std::span<const DriveState<double>> states,
                           bool power_was_cut) {
  std::vector<PositionFile::Rest> rests;
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    Axis& axis = axes_[a];
    if (!std::exchange(axis.moves, false) || !is_kept(a)) continue;
    if (is_referenced(a)) {
      if (drives.has_lost_position(a)) {
        axis.why = "it has lost steps, or its drive has started anew";
      } else if (states[a].condition == DriveCondition::unreachable) {
        axis.why = "its drive could not be reached any more while it moved";
      } else if (power_was_cut && is_open_loop(rig_.axes[a].drive)) {
        axis.why = "its motor was without power while it moved";
      }
    }
    axis.position =
        is_referenced(a) ? std::optional(drives.as_approached(a, states[a].actual)) : std::nullopt;
    rests.push_back({.axis = a, .position = axis.position});
  }
  keep(rests);
}

void RigReference::stands_at(std::size_t axis, double position) {
  if (!is_kept(axis)) throw std::logic_error("a position is said of an axis that its drive knows");
  axes_[axis] = {.position = position};
  const PositionFile::Rest rest{.axis = axis, .position = position};
  keep({&rest, 1});
}

void RigReference::is_lost(std::size_t axis, const std::string& why) {
  if (!is_kept(axis)) throw std::logic_error("a position is lost of an axis that its drive knows");
  axes_[axis] = {.position = std::nullopt, .why = why};
  const PositionFile::Rest rest{.axis = axis, .position = std::nullopt};
  keep({&rest, 1});
}

void RigReference::keep(std::span<const PositionFile::Rest> rests) {
  if (file_ && !rests.empty()) file_->at_rest(rests);
}

RigReference reference_of(const RigFile& rig, const std::optional<std::string>& file, bool is_simulated) {
  if (kept_axes(rig).empty()) return RigReference(rig);
  if (!file && is_simulated) return RigReference(rig);
  const std::string path = file ? *file : usual_position_file(rig);
  auto lock = lock_positions(path);
  RigReference reference(rig, path);
  reference.lock_ = std::move(lock);
  return reference;
}

}  // namespace inbetween
