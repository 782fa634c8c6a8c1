// Which pulses began on the lines of a rig, and when, in a file.
#pragma once

#include <string>
#include <vector>

#include "host_tools/move_model/move_cue.hpp"
#include "host_tools/rig/awaited_pulses.hpp"
#include "host_tools/text/loop_log.hpp"

namespace inbetween {

/// Comma-separated values, a line a pulse (docs/formats.md). A file never holds the loop up (LoopLog).
class CueLog {
 public:
  /// "-" is standard output. Throws std::runtime_error, one line that starts with the name, where the file
  /// cannot be opened, or is there already. `waits`: the loop has time, and waits for room instead. Refers to
  /// the pulses, and to their move.
  CueLog(const std::string& file, const std::vector<CuePulse>& pulses, bool waits);

  /// The loop's thread calls it. It allocates nothing and makes no system call unless it waits.
  void take(const PlayedPulse& pulse) { log_.take(pulse); }
  /// Writes what is left; a reader that takes nothing for a second is given up. Records are pulses.
  LoopLogEnd finish() { return log_.finish("it was written more slowly than pulses came"); }

 private:
  void put(const PlayedPulse& played, std::string& text) const;

  const std::vector<CuePulse>& pulses_;
  LoopLog<PlayedPulse, 4096> log_;
};

}  // namespace inbetween
