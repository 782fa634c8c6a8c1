#include "host_tools/files/move_unit.hpp"

#include <cstddef>
#include <numbers>

namespace inbetween {
namespace {

enum class Kind : std::uint8_t { none, length, angle };

/// How many mm or degrees a unit is, as a fraction of numbers that are exact where that can be.
struct Size {
  Kind kind = Kind::none;
  double of_base = 1;
  double divisor = 1;
};

constexpr Size size_of(MoveUnit unit) {
  switch (unit) {
    case MoveUnit::mm:
      return {Kind::length, 1};
    case MoveUnit::cm:
      return {Kind::length, 10};
    case MoveUnit::m:
      return {Kind::length, 1000};
    case MoveUnit::inch:
      return {Kind::length, 254, 10};
    case MoveUnit::ft:
      return {Kind::length, 3048, 10};
    case MoveUnit::deg:
      return {Kind::angle, 1};
    case MoveUnit::rad:
      return {Kind::angle, 180, std::numbers::pi};
    case MoveUnit::turn:
      return {Kind::angle, 360};
    case MoveUnit::of_rig:
      break;
  }
  return {};
}

constexpr MoveUnit as_move_unit(AxisUnit unit) {
  switch (unit) {
    case AxisUnit::mm:
      return MoveUnit::mm;
    case AxisUnit::m:
      return MoveUnit::m;
    case AxisUnit::deg:
      return MoveUnit::deg;
    case AxisUnit::rad:
      return MoveUnit::rad;
    case AxisUnit::turn:
      return MoveUnit::turn;
    case AxisUnit::unit:
      break;
  }
  return MoveUnit::of_rig;
}

}  // namespace

std::string_view to_string(MoveUnit unit) {
  return unit == MoveUnit::of_rig ? "the unit of the rig"
                                  : move_unit_words.at(static_cast<std::size_t>(unit) - 1);
}

std::optional<double> converted(double position, MoveUnit from, AxisUnit to) {
  if (from == MoveUnit::of_rig || from == as_move_unit(to)) return position;
  const Size given = size_of(from);
  const Size wanted = size_of(as_move_unit(to));
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
