// A part of a move: "20..80", "37..", "..20".
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "host_tools/files/diagnostics.hpp"

namespace inbetween {

/// As somebody writes it. What is left out is the first or the last frame that there is.
struct FrameRange {
  std::optional<std::int32_t> first = {};
  std::optional<std::int32_t> last = {};
};

/// Frames `first` to `last`, both included.
struct WholeFrames {
  std::int32_t first = 0;
  std::int32_t last = 0;
};

/// Nothing where it is no range: at least one end is named, and the first is not behind the last.
std::optional<FrameRange> frame_range_of(std::string_view text);

/// The frames of a range among those that there are. Throws InputError at `place` where one is not among
/// them.
WholeFrames frames_of(const FrameRange& range, const WholeFrames& all, const Place& place);

}  // namespace inbetween
