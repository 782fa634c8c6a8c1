// The text in which the positions of axes are kept.
//
//   inbetween positions 2
//   rig 8f2a0c53d1e07b94 slider with pan head
//   at 412.5 slide
//   zero -1200 37
//   moving pan
//   unreferenced focus
//   sum 5be1a89cc4bb1b35
//
// Line 2 has the identity of the rig, hexadecimal, and its name. Each axis has a line with its state and its
// name; an axis at rest has its position too, in its unit. An axis at an unknown place has no number, so that
// nobody can take a number for its place. `zero` follows an axis whose drives count by themselves: the
// position that the drive of each of its motors counts where the motor is at 0. `sum` is FNV-1a, 64 bits, of
// every byte before that line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace inbetween {

inline constexpr std::size_t max_position_bytes = 65'536;

enum class AxisRest {
  unreferenced,  // nobody has said where it is
  moving,        // it was about to move, or moved
  at             // it rests at a known place
};

struct KeptAxis {
  std::string name;
  AxisRest rest = AxisRest::unreferenced;
  double position = 0;  // only with `at`; finite, in the unit of the axis
  /// Only with `at`: for each motor, finite. Empty: its drives do not count, or have told nothing since
  /// somebody said where the axis is.
  std::vector<double> zeros = {};

  bool operator==(const KeptAxis&) const = default;
};

struct KeptPositions {
  std::string rig;             // its name
  std::uint64_t identity = 0;  // of what the positions depend on
  std::vector<KeptAxis> axes;

  bool operator==(const KeptPositions&) const = default;
};

/// Writes the text. Names have no control characters: the reader of a rig refuses them.
std::string to_text(const KeptPositions& positions);

/// Returns the positions, or the mistake in the text as the end of a sentence: "is damaged in line 3". It
/// accepts exactly what to_text writes.
std::variant<KeptPositions, std::string> parse_positions(std::string_view text);

}  // namespace inbetween
