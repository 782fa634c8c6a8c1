// The text in which the positions of axes are kept.
//
//   inbetween positions 1
//   rig 8f2a0c53d1e07b94 slider with pan head
//   at 412.5 slide
//   moving pan
//   unreferenced focus
//   sum 5be1a89cc4bb1b35
//
// Line 2 is the identity of the rig, hexadecimal, and its name. A line per axis: its state and its name, and
// where it rests its position in its unit. An axis of which nothing is known has no number, so that none can
// be mistaken for one. `sum` is FNV-1a, 64 bits, of every byte before that line.
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

  bool operator==(const KeptAxis&) const = default;
};

struct KeptPositions {
  std::string rig;             // its name
  std::uint64_t identity = 0;  // of what the positions depend on
  std::vector<KeptAxis> axes;

  bool operator==(const KeptPositions&) const = default;
};

/// Names are without control characters, as the reader of a rig sees to.
std::string to_text(const KeptPositions& positions);

/// The positions, or what is wrong with the text, as the end of a sentence: "is damaged in line 3". Accepts
/// exactly what to_text writes.
std::variant<KeptPositions, std::string> parse_positions(std::string_view text);

}  // namespace inbetween
