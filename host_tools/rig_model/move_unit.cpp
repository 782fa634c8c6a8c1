#include "host_tools/rig_model/move_unit.hpp"

#include <algorithm>
#include <cstddef>
#include <numbers>

namespace inbetween {
namespace {

enum class UnitKind : std::uint8_t { none, length, angle };

/// How many mm or degrees a unit is, as a fraction of numbers that are exact where that can be.
struct Size {
  UnitKind kind = UnitKind::none;
  double of_base = 1;
  double divisor = 1;
};

/// In the order of MoveUnit.
constexpr std::array sizes = {
    Size{},                                        // of_rig
    Size{UnitKind::length, 1},                     // mm
    Size{UnitKind::length, 10},                    // cm
    Size{UnitKind::length, 1000},                  // m
    Size{UnitKind::length, 254, 10},               // in
    Size{UnitKind::length, 3048, 10},              // ft
    Size{UnitKind::angle, 1},                      // deg
    Size{UnitKind::angle, 180, std::numbers::pi},  // rad
    Size{UnitKind::angle, 360},                    // turn
};

}  // namespace

MoveUnit as_move_unit(AxisUnit unit) {
  const auto* const word = std::ranges::find(move_unit_words, to_string(unit));
  return word == move_unit_words.end() ? MoveUnit::of_rig
                                       : static_cast<MoveUnit>(word - move_unit_words.begin() + 1);
}

std::string_view to_string(MoveUnit unit) {
  return unit == MoveUnit::of_rig ? "the unit of the rig"
                                  : move_unit_words.at(static_cast<std::size_t>(unit) - 1);
}

std::optional<double> converted(double position, MoveUnit from, AxisUnit to) {
  if (from == MoveUnit::of_rig || from == as_move_unit(to)) return position;
  const Size given = sizes.at(static_cast<std::size_t>(from));
  const Size wanted = sizes.at(static_cast<std::size_t>(as_move_unit(to)));
  if (given.kind != wanted.kind) return std::nullopt;
  return position * (given.of_base * wanted.divisor) / (given.divisor * wanted.of_base);
}

AxisUnit nearest_axis_unit(MoveUnit unit) {
  for (const AxisUnit own : {AxisUnit::m, AxisUnit::deg, AxisUnit::rad, AxisUnit::turn}) {
    if (as_move_unit(own) == unit) return own;
  }
  return unit == MoveUnit::of_rig ? AxisUnit::unit : AxisUnit::mm;
}

}  // namespace inbetween
