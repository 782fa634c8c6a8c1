// Any text is a move that keeps every promise of host_tools/move_model/move_file.hpp, or is refused in one
// line. What stands behind a byte 0 are the rows of every file that it names.
#include "host_tools/move_model/move_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "tests/fuzz/targets/refusal.hpp"

namespace inbetween {
namespace {

void require_numbers(const std::vector<double>& numbers, double min, double max) {
  for (const double number : numbers) {
    fuzz_require(std::isfinite(number) && number >= min && number <= max, "a number is in its range");
  }
}

void require_key(const MoveKey& key, const MoveTrack& track, std::int32_t frames) {
  fuzz_require(key.at.size() == track.axes.size(), "a key has a coordinate for every axis");
  fuzz_require(key.at_places.size() == key.at.size(), "a coordinate has a place");
  require_numbers(key.at, -Precision::largest, Precision::largest);
  require_numbers({key.tension, key.continuity, key.bias}, -1, 1);
  const bool shaped = key.tension != 0 || key.continuity != 0 || key.bias != 0;
  fuzz_require(!shaped || track.spline == Spline::tcb, "only a tcb key is shaped");
  fuzz_require(!key.frame || (*key.frame >= 0 && *key.frame <= frames), "a locked key is on a frame");
  fuzz_require(!key.hold || (*key.hold >= 1 && *key.hold <= frames), "a key is held within the move");
  fuzz_require(!key.breaks || key.frame, "only a locked key breaks the move");
}

void require_table(const MoveTable& table, const MoveTrack& track, std::int32_t frames) {
  const std::size_t rows = table.frames.size();
  fuzz_require(rows >= 2 && table.lines.size() == rows, "a table has two rows or more, each on its line");
  fuzz_require(table.at.size() == rows * track.axes.size(), "a row has a number for every axis");
  fuzz_require(table.units.size() == track.axes.size(), "an axis of a table has its unit");
  fuzz_require(table.frames.front() == 0 && table.frames.back() == frames, "a table is on all of the move");
  fuzz_require(std::ranges::adjacent_find(table.frames, std::greater_equal()) == table.frames.end(),
               "the rows are in order");
  require_numbers(table.at, -Precision::largest, Precision::largest);
  fuzz_require(track.keys.size() == 2 && track.timing == Timing::frames, "the ends of a table are its keys");
}

void require_track(const MoveTrack& track, std::int32_t frames) {
  if (track.table) require_table(*track.table, track, frames);
  fuzz_require(!track.axes.empty() && track.axes.size() <= max_track_axes, "a track has axes");
  fuzz_require(track.axis_places.size() == track.axes.size(), "an axis has a place");
  fuzz_require(!track.keys.empty() && track.keys.size() <= max_keys, "a track has keys");
  for (const MoveKey& key : track.keys) require_key(key, track, frames);
  fuzz_require(track.speed.empty() == (track.timing == Timing::frames),
               "a speed curve goes with timing by it");
  fuzz_require(track.speed.size() <= max_control_values, "a speed curve fits");
  fuzz_require(track.speed_places.size() == track.speed.size(), "a control value has a place");
  require_numbers(track.speed, 0, max_control_value);
  fuzz_require(track.weights.empty() || track.weights.size() == track.axes.size(), "every axis has a weight");
  require_numbers(track.weights, 0, Precision::largest);
  fuzz_require(!track.kinetic || track.timing == Timing::frames, "a kinetic goes with frame times");
}

void require_cues(const MoveFile& move) {
  fuzz_require(move.cues.size() <= max_cues, "cues fit");
  for (const MoveCue& cue : move.cues) {
    fuzz_require(!cue.line.empty(), "a cue has a line");
    fuzz_require(cue.frames.empty() == (cue.every > 0) && cue.every <= move.frames,
                 "a cue has frames or every");
    fuzz_require(cue.frame_places.size() == cue.frames.size(), "a frame has a place");
    fuzz_require(cue.phase >= 0 && cue.phase < 1, "a pulse begins in its frame");
  }
  const double frame_ns = 1e9 / move.fps.rate.frames_per_second();
  std::map<std::string_view, double> ends;  // of the latest pulse of a line
  for (const CuePulse& pulse : cue_pulses(move)) {
    fuzz_require(pulse.frame >= 0 && pulse.frame <= move.frames, "a pulse is in the move");
    fuzz_require(pulse.width_ns >= 1 && pulse.width_ns <= 60'000'000'000, "a pulse has a width");
    fuzz_require(pulse.place != nullptr && pulse.place->line > 0, "a pulse has a place");
    const double begin = (pulse.frame + pulse.phase) * frame_ns;
    const auto [end, is_first] = ends.emplace(pulse.line, 0);
    fuzz_require(is_first || begin > end->second - 1 - 1e-9 * begin, "pulses of a line are apart");
    end->second = begin + static_cast<double>(pulse.width_ns);
  }
}

void require_move(const MoveFile& move) {
  fuzz_require(!move.name.empty(), "a move has a name");
  fuzz_require(move.frames >= 1 && move.frames <= max_frames, "a move has frames");
  fuzz_require(move.fps.rate.numerator >= 1 && move.fps.rate.denominator >= 1, "a frame rate is positive");
  fuzz_require(move.fps.rate.frames_per_second() <= 1000, "a frame rate is at most 1000");
  fuzz_require(!move.tracks.empty() && move.tracks.size() <= max_tracks, "a move has tracks");
  for (const MoveTrack& track : move.tracks) require_track(track, move.frames);
  require_cues(move);
}

}  // namespace
}  // namespace inbetween

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(bytes), size);
  const std::string_view text = input.substr(0, input.find('\0'));
  const std::string rows(input.substr(std::min(text.size() + 1, size)));
  const auto beside = [&](const std::filesystem::path&, std::size_t) { return rows; };
  try {
    inbetween::require_move(inbetween::parse_move_beside(beside, text, "any.toml"));
  } catch (const inbetween::InputError& error) {
    // The name of a file is the input's own.
    require_one_line(error, error.place().file == "any.toml" ? "any.toml" : "");
  }
  return 0;
}
