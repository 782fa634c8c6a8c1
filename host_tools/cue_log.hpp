// Which pulses began on the lines of a rig, and when, in a file.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "drivers/linux/telemetry_ring.hpp"
#include "host_tools/move_cue.hpp"
#include "inbetween/cue_timer.hpp"

namespace inbetween {

/// What became of a cue log.
struct CueLogEnd {
  std::int64_t written = 0;  ///< pulses
  std::int64_t lost = 0;     ///< pulses that are not in the file
  std::string why;           ///< "" where none is
};

/// Comma-separated values, a line a pulse (docs/formats.md). The loop puts pulses into a ring, a thread of
/// its own writes them: a file never holds the loop up.
class CueLog {
 public:
  /// "-" is standard output. Throws std::runtime_error, one line that starts with the name, where the file
  /// cannot be opened. `waits`: the loop has time, and waits for room instead. Refers to the pulses, and to
  /// their move.
  CueLog(const std::string& file, const std::vector<CuePulse>& pulses, bool waits);
  ~CueLog();
  CueLog(const CueLog&) = delete;
  CueLog& operator=(const CueLog&) = delete;

  /// Of the loop's thread. No allocation, no system call unless it waits.
  void take(const BegunPulse& begun);
  /// Writes what is left; a reader that takes nothing for a second is given up.
  CueLogEnd finish();

 private:
  using Ring = TelemetryRing<BegunPulse, 4096>;

  void live();
  void put(const BegunPulse& begun);
  void flush();

  const std::vector<CuePulse>& pulses_;
  bool waits_;
  std::unique_ptr<Ring> ring_ = std::make_unique<Ring>();
  std::int64_t taken_ = 0;  // of the loop's thread
  // of the writing thread
  int file_ = -1;
  std::string text_;
  std::int64_t in_text_ = 0;
  CueLogEnd end_;
  std::atomic<bool> leaves_{false};
  std::thread thread_;
};

}  // namespace inbetween
