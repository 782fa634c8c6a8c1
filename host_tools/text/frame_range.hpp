// A part of a move: "20..80", "37..", "..20".
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "host_tools/text/diagnostics.hpp"
#include "inbetween/timing/frame_time.hpp"

namespace inbetween {

/// As somebody writes it. What is left out is the first or the last frame that there is.
struct FrameRange {
  std::optional<std::int32_t> first = {};
  std::optional<std::int32_t> last = {};
};

/// Nothing where it is no range: at least one end is named, and the first is not behind the last.
std::optional<FrameRange> frame_range_of(std::string_view text);

/// The frames of a range among those that there are. Throws InputError at `place` where one is not among
/// them.
WholeFrames frames_of(const FrameRange& range, const WholeFrames& all, const Place& place);
/// The same of a move of `frames` frames that is played from one frame to a later one.
WholeFrames played_frames_of(const FrameRange& range, std::int32_t frames, const Place& place);

/// "48 frames", or of a part of them "frames 12..36 of 48".
std::string frames_in_words(const WholeFrames& part, std::int32_t frames);

}  // namespace inbetween
