#include "host_tools/exchange/keyed_move.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "host_tools/exchange/toml_text.hpp"

namespace inbetween {
namespace {

std::string_view ends_that_rest(const RestingEnds& rest) {
  if (rest.start) return rest.end ? "both" : "start";
  return rest.end ? "end" : "none";
}

/// The coordinates of all keys, each column as wide as its longest.
std::vector<std::string> written_keys(const MoveTrack& track) {
  std::vector<std::string> rows(track.keys.size());
  for (std::size_t axis = 0; axis < track.axes.size(); ++axis) {
    std::vector<std::string> column;
    std::size_t width = 0;
    for (const MoveKey& key : track.keys) {
      column.push_back(fmt::format("{}", key.at[axis]));
      width = std::max(width, column.back().size());
    }
    for (std::size_t k = 0; k < rows.size(); ++k)
      rows[k] += fmt::format("{}{:>{}}", axis == 0 ? "" : ", ", column[k], width);
  }
  return rows;
}

}  // namespace

std::string keyed_move_text_of(const MoveFile& move, const std::vector<std::string>& comments) {
  std::string text;
  for (const std::string& comment : comments) text += toml_comment(comment);
  text += fmt::format("name   = {}\n", toml_quoted(move.name));
  text += move.fps.written_as_integer ? fmt::format("fps    = {}\n", move.fps.as_written)
                                      : fmt::format("fps    = \"{}\"\n", move.fps.as_written);
  text += fmt::format("frames = {}\n", move.frames);
  for (const MoveTrack& track : move.tracks) {
    text += fmt::format("\n[[track]]\naxes   = {}\n", toml_list(track.axes));
    if (track.timing == Timing::frames) text += "timing = \"frames\"\n";
    if (track.rest) text += fmt::format("rest   = \"{}\"\n", ends_that_rest(*track.rest));
    text += "keys   = [\n";
    const std::vector<std::string> keys = written_keys(track);
    for (std::size_t k = 0; k < keys.size(); ++k) {
      text += fmt::format("  {{ at = [{}]", keys[k]);
      if (track.keys[k].frame) text += fmt::format(", frame = {}", *track.keys[k].frame);
      text += " },\n";
    }
    text += "]\n";
    if (!track.speed.empty()) text += fmt::format("speed  = [{}]\n", fmt::join(track.speed, ", "));
    if (!track.weights.empty()) text += fmt::format("weights = [{}]\n", fmt::join(track.weights, ", "));
  }
  return text;
}

}  // namespace inbetween
