// Which edges simulated stepper drivers got on their STEP lines, and when, in a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/loop_log.hpp"

namespace inbetween {

/// An edge on the STEP line of a motor.
struct LoggedEdge {
  std::int64_t at_ns = 0;
  std::size_t motor = 0;   ///< of RigMotors::rig
  bool step = false;       ///< the level after it: a rise is a step
  bool dir = false;        ///< the level of DIR: up where it is high
  std::int64_t steps = 0;  ///< since the start, with sign
};

/// Comma-separated values, a line an edge (docs/formats.md). A file never holds the loop up (LoopLog).
class StepLog {
 public:
  /// "-" is standard output. Throws std::runtime_error, one line that starts with the name, where the file
  /// cannot be opened, or is there already. `waits`: the loop has time, and waits for room instead. Refers to
  /// the motors.
  StepLog(const std::string& file, const std::vector<RigAxis>& motors, bool waits);

  /// The loop's thread calls it. It allocates nothing and makes no system call unless it waits.
  void take(const LoggedEdge& edge) { log_.take(edge); }
  /// Writes what is left; a reader that takes nothing for a second is given up. Records are edges.
  LoopLogEnd finish() { return log_.finish("it was written more slowly than steps came"); }

 private:
  LoopLog<LoggedEdge, 16384> log_;
};

}  // namespace inbetween
