#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include "host_tools/move_model/move_readers.hpp"

namespace inbetween {
namespace {

constexpr std::array<std::string_view, 5> cue_fields = {"line", "frames", "every", "width_ms", "phase"};
constexpr std::array<std::string_view, 2> clapper_fields = {"line", "width_ms"};

std::int64_t read_width(const TomlTable& table) {
  const TomlValue value = table.required("width_ms", "width_ms = 20, say");
  const auto width_ns = static_cast<std::int64_t>(std::llround(value.number(0, max_pulse_ms) * 1e6));
  if (width_ns == 0) value.refuse("is less than a nanosecond; write a longer pulse");
  return width_ns;
}

void read_frames(const TomlValue& frames, std::int32_t last_frame, MoveCue& cue) {
  for (const TomlValue& value : frames.list(max_cue_frames)) {
    const auto frame = static_cast<std::int32_t>(value.integer(0, last_frame));
    if (!cue.frames.empty() && frame <= cue.frames.back()) {
      value.refuse(
          fmt::format("is {}, not after {}; write the frames in ascending order", frame, cue.frames.back()));
    }
    cue.frames.push_back(frame);
    cue.frame_places.push_back(value.place());
  }
}

MoveCue read_cue(const TomlValue& section, std::int32_t last_frame) {
  const TomlTable table(section.table(), "a cue", cue_fields);
  MoveCue cue;
  cue.place = table.place();
  const TomlValue line = table.required("line", R"(line = "the name of an output of the rig", or "camera")");
  cue.line = line.text();
  cue.line_place = line.place();
  const auto frames = table.optional("frames");
  const auto every = table.optional("every");
  if (frames && every) every->refuse("says the same as frames; remove one of the two");
  if (every) {
    cue.every = static_cast<std::int32_t>(every->integer(1, last_frame));
  } else {
    read_frames(table.required("frames", "frames = [1, 24], or every = 1 for every frame"), last_frame, cue);
  }
  cue.width_ns = read_width(table);
  if (const auto phase = table.optional("phase")) {
    cue.phase = phase->number(0, 1);
    if (cue.phase == 1) phase->refuse("is 1, the next frame; write a number below 1");
  }
  return cue;
}

Clapper read_clapper(const TomlValue& value) {
  const TomlTable table(value.table(), "the clapper", clapper_fields);
  const TomlValue line = table.required("line", R"(line = "the name of an output of the rig")");
  return {line.text(), read_width(table), value.place(), line.place()};
}

void refuse_too_many_pulses(const MoveFile& move) {
  std::size_t pulses = 0;
  for (const MoveCue& cue : move.cues) {
    pulses += cue.every > 0 ? static_cast<std::size_t>(move.frames / cue.every) + 1 : cue.frames.size();
    if (pulses <= max_cue_pulses) continue;
    throw InputError(cue.place, fmt::format("the cues have more than {} pulses together; raise every, or "
                                            "make the move shorter",
                                            max_cue_pulses));
  }
}

void refuse_overlaps(const MoveFile& move) {
  const double frame_ns = 1e9 / move.fps.rate.frames_per_second();
  std::map<std::string_view, CuePulse> latest;
  for (const CuePulse& pulse : cue_pulses(move)) {
    const auto [found, is_first] = latest.emplace(pulse.line, pulse);
    if (is_first) continue;
    const CuePulse& before = found->second;
    const double apart_ns = (pulse.frame - before.frame + (pulse.phase - before.phase)) * frame_ns;
    if (apart_ns <= static_cast<double>(before.width_ns)) {
      throw InputError(
          *pulse.place,
          fmt::format(
              "on line {} a pulse begins at frame {}, {:.6g} ms after that of frame {} (line {}), which is "
              "{:.6g} ms wide; make that narrower, or use another line",
              in_quotes(pulse.line), pulse.frame, apart_ns / 1e6, before.frame, before.place->line,
              static_cast<double>(before.width_ns) / 1e6));
    }
    found->second = pulse;
  }
}

}  // namespace

void read_cues(const TomlTable& table, MoveFile& move) {
  if (const auto cues = table.optional("cue")) {
    for (const TomlValue& cue : cues->tables(max_cues)) move.cues.push_back(read_cue(cue, move.frames));
  }
  if (const auto clapper = table.optional("clapper")) move.clapper = read_clapper(*clapper);
  if (const auto start = table.optional("start")) {
    move.start = start->choice({"command", "trigger"}) == 0 ? Start::command : Start::trigger;
    move.start_place = start->place();
  }
  refuse_too_many_pulses(move);
  refuse_overlaps(move);
}

}  // namespace inbetween
