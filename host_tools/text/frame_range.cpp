#include "host_tools/text/frame_range.hpp"

#include <fmt/format.h>

#include <charconv>
#include <system_error>

namespace inbetween {
namespace {

/// Whether the whole text is a frame, or nothing.
bool read_frame(std::string_view text, std::optional<std::int32_t>& frame) {
  if (text.empty()) return true;
  std::int32_t number = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, number);
  if (error != std::errc() || end != last || number < 0) return false;
  frame = number;
  return true;
}

}  // namespace

std::optional<FrameRange> frame_range_of(std::string_view text) {
  const std::size_t dots = text.find("..");
  if (dots == std::string_view::npos) return std::nullopt;
  FrameRange range;
  if (!read_frame(text.substr(0, dots), range.first)) return std::nullopt;
  if (!read_frame(text.substr(dots + 2), range.last)) return std::nullopt;
  if (!range.first && !range.last) return std::nullopt;
  if (range.first && range.last && *range.first > *range.last) return std::nullopt;
  return range;
}

WholeFrames frames_of(const FrameRange& range, const WholeFrames& all, const Place& place) {
  const WholeFrames frames{range.first.value_or(all.first), range.last.value_or(all.last)};
  for (const std::int32_t frame : {frames.first, frames.last}) {
    if (frame >= all.first && frame <= all.last) continue;
    throw InputError(
        place, fmt::format("--frames names frame {}, and there are {}..{}; name frames of the move", frame,
                           all.first, all.last));
  }
  return frames;
}

WholeFrames played_frames_of(const FrameRange& range, std::int32_t frames, const Place& place) {
  const WholeFrames part = frames_of(range, {0, frames}, place);
  if (part.first < part.last) return part;
  throw InputError(place,
                   fmt::format("--frames names frame {} alone, and a move goes from one frame to a later "
                               "one; name two, for example {}..{}",
                               part.first, part.first < frames ? part.first : part.first - 1,
                               part.first < frames ? part.first + 1 : part.first));
}

std::string frames_in_words(const WholeFrames& part, std::int32_t frames) {
  if (part == WholeFrames{0, frames}) return counted(frames, "frame");
  return fmt::format("frames {}..{} of {}", part.first, part.last, frames);
}

}  // namespace inbetween
