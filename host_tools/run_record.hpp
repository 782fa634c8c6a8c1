// What every axis was told and where it was, tick by tick, in a file.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "drivers/linux/telemetry_ring.hpp"
#include "host_tools/rig_file.hpp"
#include "host_tools/run_loop.hpp"

namespace inbetween {

/// What became of a record.
struct RunRecordEnd {
  std::int64_t written = 0;  ///< ticks
  std::int64_t lost = 0;     ///< ticks that are not in the file
  std::string why;           ///< "" where none is
};

/// Comma-separated values, a line a tick: its number, seconds, the state of the supervisor, and per axis the
/// setpoint and the position that its drive told; empty while no setpoint is sent.
///
/// The loop puts ticks into a ring, a thread of its own writes them: a disk that is full, slow or gone never
/// holds the loop up. What finds no room is counted, and the file has a gap there, which its numbers show.
class RunRecord {
 public:
  /// Throws std::runtime_error, one line that starts with the name, where the file cannot be opened. `waits`:
  /// the loop has time, and waits for room instead.
  RunRecord(const std::string& file, const RigFile& rig, bool waits);
  ~RunRecord();
  RunRecord(const RunRecord&) = delete;
  RunRecord& operator=(const RunRecord&) = delete;

  /// Of the loop's thread, after a tick. No allocation, no system call unless it waits.
  void take(const RunLoop& loop);
  /// Writes what is left; a reader that takes nothing for a second is given up.
  RunRecordEnd finish();

 private:
  struct Tick {
    std::int64_t number = 0;
    SupervisorState state = SupervisorState::disarmed;
    bool is_told = false;
    std::array<double, max_rig_axes> told;
    std::array<double, max_rig_axes> actual;
  };
  using Ring = TelemetryRing<Tick, 2048>;

  void write_head(const RigFile& rig);
  void live();
  void put(const Tick& tick);
  /// Sends what has gathered. After the first failure nothing is written any more.
  void flush();

  std::size_t axes_;
  double period_s_;
  bool waits_;
  std::unique_ptr<Ring> ring_ = std::make_unique<Ring>();
  // of the loop's thread
  std::int64_t number_ = 0;
  // of the writing thread
  int file_ = -1;
  std::string text_;
  std::int64_t in_text_ = 0;
  RunRecordEnd end_;
  std::atomic<bool> leaves_{false};
  std::thread thread_;
};

}  // namespace inbetween
