// The use that a move makes of lines of the rig: pulses at frames, a clapper, the start by a trigger.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/text/diagnostics.hpp"
#include "inbetween/timing/frame_time.hpp"

namespace inbetween {

struct MoveFile;
struct RigFile;

inline constexpr std::size_t max_cues = 64;
inline constexpr std::size_t max_cue_frames = 10'000;  // that a cue lists
inline constexpr std::size_t max_cue_pulses = 2'000'000;
inline constexpr double max_pulse_ms = 60'000;

/// The pulses of one line. A pulse takes the line from its idle level to the opposite one for `width_ns`.
struct MoveCue {
  std::string line;                  // an output of the rig, or "camera"
  std::vector<std::int32_t> frames;  // 0..frames of the move, ascending; empty with `every`
  std::int32_t every = 0;     // frames 0, every, 2 every, ... up to the last of the move; 0 with `frames`
  std::int64_t width_ns = 0;  // above 0
  double phase = 0;           // 0 <= phase < 1: the pulse begins at frame + phase
  Place place;
  Place line_place;
  std::vector<Place> frame_places;
};

/// A pulse at frame 0 and one at the last frame, to align picture, sound and motion.
struct Clapper {
  std::string line;
  std::int64_t width_ns = 0;
  Place place;
  Place line_place;
};

/// The event that starts a run when everything is ready.
enum class Start { command, trigger };

/// A pulse on `line`, in frames of the move; it may end after the move.
struct CuePulse {
  std::string_view line;  // in the move
  std::int32_t frame = 0;
  double phase = 0;
  std::int64_t width_ns = 0;
  const Place* place = nullptr;  // of its frame in the move, or of the cue; in the move too
};

/// The pulses of a move, or of a part of it, in the order in which they begin. Of a part those of its frames,
/// and the clapper claps on its first and its last. Pulses that begin at once have the order of the file, the
/// clapper first. The result refers to `move`, which must live longer.
std::vector<CuePulse> cue_pulses(const MoveFile& move, const std::optional<WholeFrames>& part = std::nullopt);

/// Throws InputError at the place in the move that names a line or a trigger that the rig does not have.
void check_cues(const MoveFile& move, const RigFile& rig);

}  // namespace inbetween
