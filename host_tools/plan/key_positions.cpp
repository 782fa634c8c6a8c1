#include "host_tools/plan/key_positions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host_tools/plan/network_track.hpp"

namespace inbetween {
namespace {

/// As a share of a turn: what a conversion of units may be off by.
constexpr double half_turn_rounding = 1e-9;

MoveUnit unit_of(const std::vector<MoveUnit>& units, std::size_t axis) {
  return units.empty() ? MoveUnit::of_rig : units[axis];
}

/// One axis of a track.
class SettledAxis {
 public:
  SettledAxis(MoveTrack& track, std::size_t axis, const RigAxis* rig_axis)
      : track_(track),
        axis_(axis),
        has_rig_(rig_axis != nullptr),
        unit_(has_rig_ ? rig_axis->unit : unit_without_rig(track, axis)) {}

  void settle() {
    for (MoveKey& key : track_.keys) {
      if (!key.is_left_out.empty() && key.is_left_out[axis_]) continue;
      key.at[axis_] = in_unit(key.at[axis_], unit_of(key.units, axis_), key.at_places, axis_);
    }
    if (track_.network) settle_drawn();
    if (track_.table) settle_rows();
    if (track_.wraps.empty() || track_.wraps[axis_] == 0) return;
    turn_ = in_unit(track_.wraps[axis_], unit_of(track_.units, axis_), track_.keys.front().at_places, axis_);
    for (const MoveKey& key : track_.keys) refuse_more_than_a_turn(key);
    for (std::size_t k = 1; k < track_.keys.size(); ++k) {
      track_.keys[k].at[axis_] = way_to(k, track_.keys[k - 1].at[axis_]);
    }
    if (!track_.closed || track_.keys.size() < 2) return;
    track_.lap.resize(track_.axes.size());
    track_.lap[axis_] = way_to(0, track_.keys.back().at[axis_]) - track_.keys.front().at[axis_];
  }

 private:
  void settle_drawn() {
    for (DrawnAxis& drawn : track_.network->drawn) {
      if (drawn.axis != axis_) continue;
      for (std::size_t i = 0; i < drawn.at.size(); ++i) {
        drawn.at[i] = in_unit(drawn.at[i], drawn.unit, drawn.places, i);
      }
      drawn.unit = MoveUnit::of_rig;
    }
  }

  /// The keys, which are rows, have shown that the units go together.
  void settle_rows() {
    MoveTable& table = *track_.table;
    MoveUnit& from = table.units[axis_];
    if (unit_ && from != MoveUnit::of_rig) {
      for (std::size_t i = axis_; i < table.at.size(); i += track_.axes.size())
        table.at[i] = *converted(table.at[i], from, *unit_);
    }
    from = MoveUnit::of_rig;
  }

  /// The position is the one that stands at places[index].
  [[nodiscard]] double in_unit(double position, MoveUnit from, const std::vector<Place>& places,
                               std::size_t index) const {
    if (!unit_) return position;
    const std::string name = in_quotes(track_.axes[axis_]);
    if (!has_rig_ && from == MoveUnit::of_rig) {
      throw InputError(places[index],
                       fmt::format("axis {} is in {} elsewhere and here in the unit of the rig, which is not "
                                   "known; give it a unit, or plan with --rig",
                                   name, to_string(*unit_)));
    }
    const std::optional<double> result = converted(position, from, *unit_);
    if (result) return *result;
    throw InputError(
        places[index],
        fmt::format("axis {} is given in {}, and it counts {}{}; give it a unit of that kind, or "
                    "none: unit = {{ {} = ... }} is for one axis",
                    name, to_string(from), to_string(*unit_), has_rig_ ? " in the rig" : "",
                    track_.axes[axis_]));
  }

  void refuse_more_than_a_turn(const MoveKey& key) const {
    const double at = key.at[axis_];
    if (std::abs(at) < turn_) return;
    throw InputError(
        key.at_places[axis_],
        fmt::format("axis {} counts round with wrap = {:g}, and {:g} is not within one turn; write "
                    "{:g}, and turns = ... for whole turns",
                    in_quotes(track_.axes[axis_]), turn_, at, std::fmod(at, turn_)));
  }

  /// The position on which an axis at `from` arrives at a key.
  [[nodiscard]] double way_to(std::size_t index, double from) const {
    const MoveKey& key = track_.keys[index];
    const WayRound way = key.ways.empty() ? WayRound{} : key.ways[axis_];
    const double direction = key.at[axis_];
    double whole = std::round((from - direction) / turn_);
    const double short_way = direction + whole * turn_ - from;
    if (std::abs(std::abs(short_way) - turn_ / 2) <= half_turn_rounding * turn_) {
      if (!way.turns) {
        throw InputError(
            key.at_places[axis_],
            fmt::format("axis {} has half a turn to go, and neither way is shorter; write turns = "
                        "0 to go up, or turns = -1 to go down",
                        in_quotes(track_.axes[axis_])));
      }
      if (short_way < 0) ++whole;
    }
    if (way.is_long && short_way != 0) whole += short_way > 0 ? -1 : 1;
    return direction + (whole + way.turns.value_or(0)) * turn_;
  }

  MoveTrack& track_;
  std::size_t axis_;
  bool has_rig_;
  std::optional<AxisUnit> unit_;
  double turn_ = 0;
};

}  // namespace

std::optional<AxisUnit> unit_without_rig(const MoveTrack& track, std::size_t axis) {
  for (const MoveKey& key : track.keys) {
    const MoveUnit unit = unit_of(key.units, axis);
    if (unit != MoveUnit::of_rig) return nearest_axis_unit(unit);
  }
  if (!track.network) return std::nullopt;
  for (const DrawnAxis& drawn : track.network->drawn) {
    if (drawn.axis == axis && drawn.unit != MoveUnit::of_rig) return nearest_axis_unit(drawn.unit);
  }
  return std::nullopt;
}

void settle_positions(MoveFile& move, const std::optional<RigFile>& rig) {
  for (MoveTrack& track : move.tracks) {
    if (track.space) {  // read as metres
      if (track.network) settle_left_out(track);
      continue;
    }
    for (std::size_t d = 0; d < track.axes.size(); ++d) {
      const RigAxis* rig_axis = nullptr;
      if (rig) rig_axis = &*std::ranges::find(rig->axes, track.axes[d], &RigAxis::name);
      SettledAxis(track, d, rig_axis).settle();
    }
    track.units.clear();
    track.wraps.clear();
    for (MoveKey& key : track.keys) {
      key.units.clear();
      key.ways.clear();
    }
    if (track.network) settle_left_out(track);
  }
}

}  // namespace inbetween
