// A file with the setpoint and the position of every axis, tick by tick.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tools/loop/tick_sink.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/loop_log.hpp"

namespace inbetween {

/// A line of a record.
struct RecordedTick {
  std::int64_t number = 0;
  SupervisorState state = SupervisorState::disarmed;
  std::optional<double> frame = {};
  std::span<const double> told = {};  ///< empty: no setpoint was sent
  std::span<const double> actual = {};
};
void put_recorded(const RecordedTick& tick, double period_s, std::string& text);
/// The first line.
std::string head_of_record(const std::vector<std::string>& axes);

/// Comma-separated values, a line a tick: its number, seconds, the state of the supervisor, the frame on
/// which the move is, and per axis the setpoint and the position that its drive told. Empty: no move is
/// played, no setpoint is sent.
///
/// A disk that is full, slow or gone never holds the loop up (LoopLog): what finds no room is counted, and
/// the file has a gap there, which its numbers show.
class RunRecord final : public TickSink {
 public:
  /// Throws std::runtime_error, one line that starts with the name, where the file cannot be opened, or is
  /// there already. `waits`: the loop has time, and waits for room instead.
  RunRecord(const std::string& file, const RigFile& rig, bool waits);

  void take(const RunLoop& loop, const LoopTask* act) override;
  /// Writes what is left; a reader that takes nothing for a second is given up. Records are ticks.
  LoopLogEnd finish() { return log_.finish("it was written more slowly than the rig moved"); }

 private:
  struct Tick {
    std::int64_t number = 0;
    SupervisorState state = SupervisorState::disarmed;
    std::optional<double> frame;
    bool is_told = false;
    std::array<double, max_rig_axes> told;
    std::array<double, max_rig_axes> actual;
  };
  void put(const Tick& tick, std::string& text) const;

  std::size_t axes_;
  double period_s_;
  std::int64_t number_ = 0;  // of the loop's thread
  LoopLog<Tick, 2048> log_;
};

}  // namespace inbetween
