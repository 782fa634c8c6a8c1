// Which frames of a shoot were exposed, in a file that goes on with the shoot.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host_tools/text/loop_log.hpp"

namespace inbetween {

struct LoggedShot {
  std::int32_t frame = 0;
  std::int32_t shots =
      0;  ///< of this frame in this run and in those that it goes on with, this one included if it is whole
  bool is_whole = true;  ///< false: the rig was stopped while the camera had its signal
};

/// The exposures in such a log, in their order. Throws std::runtime_error, one line that starts with the
/// name, where it cannot be read, or a line is none of a shoot log or names no frame 0..`last`.
std::vector<LoggedShot> read_shoot_log(const std::string& name, std::int32_t last);

/// Comma-separated values, a line an exposure (docs/formats.md). A file that is there goes on at its end, and
/// each line is written at once, so that after whatever happened its last line names the last frame. It never
/// holds the loop up (LoopLog).
class ShootLog {
 public:
  /// "-" is standard output. Throws std::runtime_error, one line that starts with the name, where the file
  /// cannot be opened, or is there and is no such log. `waits`: the loop has time, and waits for room.
  ShootLog(const std::string& file, bool waits);

  /// The loop's thread calls it. It allocates nothing and makes no system call unless it waits.
  void take(const LoggedShot& shot) { log_.take(shot); }
  /// Writes what is left. Records are exposures.
  LoopLogEnd finish() { return log_.finish("it was written more slowly than frames were shot"); }

 private:
  LoopLog<LoggedShot, 256> log_;
};

}  // namespace inbetween
