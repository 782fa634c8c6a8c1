#include "host_tools/reference/rig_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <variant>

#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

/// A turn of something that an axis moves with, in its unit.
struct TurnOf {
  double distance;
  const char* what;
};

/// The turns that a drive may lose: of its output shaft, and of its rotor.
std::vector<TurnOf> turns_of(const RigAxis& axis) {
  std::vector<TurnOf> turns;
  if (axis.calibration) return turns;  // the axis has another distance for each
  if (const std::optional<double> turns_per_unit = turns_per_unit_of(axis.drive)) {
    turns.push_back({1 / std::fabs(*turns_per_unit), "the output shaft"});
    if (const auto* motor = std::get_if<CubemarsDrive>(&axis.drive)) {
      turns.push_back({turns.front().distance / motor->gear, "the rotor"});
    }
  } else if (axis.unit == AxisUnit::deg) {
    turns.push_back({360, "the axis"});
  }
  return turns;
}

/// Without digits that no drive has.
double rounded(double position) {
  return std::round(position * 1e4) / 1e4 + 0.0;  // no -0
}

/// "360 deg, one turn of the output shaft".
std::string distance_in_words(const RigAxis& axis, double distance) {
  std::string words = fmt::format("{:.5g} {}", distance, to_string(axis.unit));
  for (const TurnOf& turn : turns_of(axis)) {
    const double count = std::round(distance / turn.distance);
    const bool is_whole = count >= 1 && std::fabs(distance - count * turn.distance) <= 0.01 * turn.distance;
    if (!is_whole) continue;
    return count == 1 ? fmt::format("{} (one turn of {})", words, turn.what)
                      : fmt::format("{} ({:g} turns of {})", words, count, turn.what);
  }
  return words;
}

}  // namespace

RigReference::RigReference(const RigFile& rig, std::string file, FileLayer files) : RigReference(rig) {
  file_.emplace(std::move(file), rig, std::move(files));
  for (const KnownAxis& known : file_->axes()) {
    axes_[known.axis] = {.position = known.position, .zeros = known.zeros, .why = known.why};
  }
}

bool RigReference::is_kept(std::size_t axis) const {
  return rig_.axes[axis].reference != Reference::by_drive;
}

bool RigReference::is_told(std::size_t axis) const {
  return is_kept(axis) && !is_open_loop(rig_.axes[axis].drive);
}

std::optional<double> RigReference::counted_position(std::size_t axis) const {
  const Axis& of = axes_[axis];
  if (!of.position || of.zeros.empty()) return of.position;
  const RigAxis& in_rig = rig_.axes[axis];
  const AxisMotor first{.axis = axis, .offset = in_rig.offset};
  return axis_position(in_rig, first, motor_position(in_rig, first, *of.position) + of.zeros.front());
}

void RigReference::place(RigDrives& drives) const {
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    const Axis& axis = axes_[a];
    if (!axis.position) continue;
    if (!axis.zeros.empty()) {
      drives.set_zeros(a, axis.zeros);
    } else if (!rig_.axes[a].drive_home) {  // that drive counts from its home
      drives.place(a, *axis.position);
    }
  }
}

void RigReference::refuse_if_elsewhere(std::size_t axis, double told) {
  const RigAxis& of = rig_.axes[axis];
  const double left = *axes_[axis].position;
  // Noise of the encoder, and what is lost where its count is rounded.
  if (std::fabs(told - left) <= std::max(place_tolerance(of), 2 * count_of(of))) return;
  is_lost(axis, "its drive told another position than the one at which it was left");
  const char* const unit = to_string(of.unit).data();
  std::string remedy = "let it home with inbetween home";
  if (!of.drive_home) {
    remedy = fmt::format("look where it stands, and say it with inbetween goto --stands-at {}={:.10g}",
                         of.name, rounded(left));
    if (told >= of.min && told <= of.max) remedy += fmt::format(" or {}={:.10g}", of.name, rounded(told));
  }
  throw InputError(
      of.place,
      fmt::format("axis {} was left at {:.10g} {}, and its drive tells {:.10g}, {} {}: it has forgotten that "
                  "without power, or the axis was moved; {}",
                  in_quotes(of.name), rounded(left), unit, rounded(told),
                  distance_in_words(of, std::fabs(told - left)), told > left ? "more" : "less", remedy));
}

void RigReference::compare(const RigDrives& drives, std::span<const double> positions) {
  std::vector<PositionFile::Rest> rests;
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    Axis& axis = axes_[a];
    if (!axis.position || axis.moves || !is_told(a)) continue;
    refuse_if_elsewhere(a, positions[a]);
    if (!axis.zeros.empty()) continue;
    axis.zeros = drives.zeros(a);
    rests.push_back({.axis = a, .position = axis.position, .zeros = axis.zeros});
  }
  keep(rests);
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
    const char* const or_vouch =
        is_told(a) && !axis.drive_home
            ? "; or write reference = \"drive\" if its encoder knows its turns without power"
            : "";
    throw InputError(axis.place, fmt::format("axis {} does not know where it is: {}; {}{}",
                                             in_quotes(axis.name), axes_[a].why, remedy, or_vouch));
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

void RigReference::at_rest(const RigDrives& drives, std::span<const DriveState> states, bool power_was_cut) {
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
    axis.zeros = drives.zeros(a);
    rests.push_back({.axis = a, .position = axis.position, .zeros = axis.zeros});
  }
  keep(rests);
}

void RigReference::forget_restarted(const RigDrives& drives) {
  for (std::size_t a = 0; a < axes_.size(); ++a) {
    if (axes_[a].position && is_told(a) && drives.has_lost_position(a)) {
      is_lost(a, "its drive has started anew");
    }
  }
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
