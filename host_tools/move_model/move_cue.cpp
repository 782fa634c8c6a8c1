#include "host_tools/move_model/move_cue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {
namespace {

constexpr std::string_view camera_line = "camera";

void add_pulses(const MoveCue& cue, const WholeFrames& part, std::vector<CuePulse>& pulses) {
  for (std::size_t i = 0; i < cue.frames.size(); ++i) {
    if (cue.frames[i] < part.first || cue.frames[i] > part.last) continue;
    pulses.push_back({cue.line, cue.frames[i], cue.phase, cue.width_ns, &cue.frame_places[i]});
  }
  if (cue.every == 0) return;
  const std::int32_t first = (part.first + cue.every - 1) / cue.every * cue.every;
  for (std::int32_t frame = first; frame <= part.last; frame += cue.every) {
    pulses.push_back({cue.line, frame, cue.phase, cue.width_ns, &cue.place});
  }
}

void check_line(const std::string& line, const Place& place, const RigFile& rig) {
  if (line == camera_line) {
    if (rig.camera) return;
    throw InputError(
        place, fmt::format("the rig {} has no camera; add a [camera] to it with the line of its shutter",
                           in_quotes(rig.name)));
  }
  const auto is_it = [&](const Output& output) { return output.name == line; };
  if (std::any_of(rig.outputs.begin(), rig.outputs.end(), is_it)) return;
  std::vector<std::string> known;
  for (const Output& output : rig.outputs) known.push_back(output.name);
  if (rig.camera) known.emplace_back(camera_line);
  throw InputError(
      place, fmt::format("the rig {} has no output {}; {}", in_quotes(rig.name), in_quotes(line),
                         known.empty() ? "add an [output.NAME] to it" : "it has " + comma_separated(known)));
}

}  // namespace

std::vector<CuePulse> cue_pulses(const MoveFile& move, const std::optional<WholeFrames>& part) {
  const WholeFrames played = part.value_or(WholeFrames{0, move.frames});
  std::vector<CuePulse> pulses;
  if (move.clapper) {
    const Clapper& clapper = *move.clapper;
    for (const std::int32_t frame : {played.first, played.last}) {
      pulses.push_back({clapper.line, frame, 0, clapper.width_ns, &clapper.place});
    }
  }
  for (const MoveCue& cue : move.cues) add_pulses(cue, played, pulses);
  std::stable_sort(pulses.begin(), pulses.end(), [](const CuePulse& a, const CuePulse& b) {
    return std::tie(a.frame, a.phase) < std::tie(b.frame, b.phase);
  });
  return pulses;
}

void check_cues(const MoveFile& move, const RigFile& rig) {
  if (move.clapper) check_line(move.clapper->line, move.clapper->line_place, rig);
  for (const MoveCue& cue : move.cues) check_line(cue.line, cue.line_place, rig);
  if (move.start == Start::trigger && !rig.start_trigger) {
    throw InputError(move.start_place,
                     fmt::format("the rig {} has no trigger; add a [start_trigger] to it, or remove start",
                                 in_quotes(rig.name)));
  }
}

}  // namespace inbetween
