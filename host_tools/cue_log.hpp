// Which pulses began on the lines of a rig, and when, in a file.
#pragma once

#include <string>
#include <vector>

#include "host_tools/loop_log.hpp"
#include "host_tools/move_cue.hpp"
#include "inbetween/cue_timer.hpp"

namespace inbetween {

/// Comma-separated values, a line a pulse (docs/formats.md). A file never holds the loop up (LoopLog).
class CueLog {
 public:
  /// "-" is standard output. Throws std::runtime_error, one line that starts with the name, where the file
  /// cannot be opened. `waits`: the loop has time, and waits for room instead. Refers to the pulses, and to
  /// their move.
  CueLog(const std::string& file, const std::vector<CuePulse>& pulses, bool waits);

  /// Of the loop's thread. No allocation, no system call unless it waits.
  void take(const BegunPulse& begun) { log_.take(begun); }
  /// Writes what is left; a reader that takes nothing for a second is given up. Records are pulses.
  LoopLogEnd finish() { return log_.finish("it was written more slowly than pulses came"); }

 private:
  void put(const BegunPulse& begun, std::string& text) const;

  const std::vector<CuePulse>& pulses_;
  LoopLog<BegunPulse, 4096> log_;
};

}  // namespace inbetween
