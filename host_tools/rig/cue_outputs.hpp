// The pulses of a move on the outputs of a rig.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tools/move_model/move_cue.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "host_tools/rig/awaited_pulses.hpp"
#include "host_tools/rig/counters.hpp"
#include "host_tools/rig/cue_log.hpp"
#include "host_tools/rig/rig_hardware.hpp"
#include "host_tools/rig/step_drives.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/loop/tick_chain.hpp"
#include "inbetween/steps/cue_timer.hpp"

namespace inbetween {

/// The distance of a playhead in a tick of the loop.
struct CuePassage {
  PlayheadPlace from, to;
  Repeat repeated = Repeat::none;
};

/// The lines are idle outside pulses and whenever this object does not exist. A pulse comes when the axes are
/// at its place: a tick after the loop has said so, as the steps of StepPort.
class CueOutputs {
 public:
  /// Takes all outputs of the rig, a request a chip; null where the rig has no output and no camera. `line`
  /// is the time line, with its rolls, `part` the frames of the move that are played. The others last longer.
  /// Throws InputError at the place of what is not there; then nothing has changed.
  static std::unique_ptr<CueOutputs> open(const MoveFile& move, const RigFile& rig, const WholeFrames& line,
                                          const WholeFrames& part, RigHardware& hardware);
  CueOutputs(const CueOutputs&) = delete;
  CueOutputs& operator=(const CueOutputs&) = delete;

  /// Before the first tick: pulses are timed by the same clock as the steps of the rig, which last longer, to
  /// the nanosecond.
  void go_with(const StepDrives& steps) { steps_ = &steps; }
  /// Before log_to: the frames that are logged are those of turns of so many.
  void count_frames_of_turns(std::int32_t frames) {
    for (CuePulse& pulse : pulses_) pulse.frame %= frames;
  }
  /// Before the first tick: every pulse goes there. CueLog says what it throws.
  void log_to(const std::string& file, bool waits);

  /// Before the first tick: every pulse, by its number in cue_pulses(), is told there in the tick that it
  /// begins in, by the loop's thread.
  void tell(std::function<void(std::size_t pulse)> told) { told_ = std::move(told); }

  // The loop's thread calls these. Nothing waits but the log, if it was told to; nothing is allocated.

  /// `ticks` have passed since the last call, usually 1. Begins and ends pulses.
  void tick(const CuePassage& passage, std::int32_t ticks, std::int64_t now_ns);
  /// The signal of the camera, at once, for a move that is shot frame by frame; not together with `tick`.
  void signal(bool is_exposing, std::int64_t now_ns);

  // Once no tick follows.

  /// Pulses that have begun are ended at their times: waits for that, or until `interrupted`.
  void finish(const std::function<bool()>& interrupted);
  [[nodiscard]] std::optional<LoopLogEnd> end_log();
  [[nodiscard]] const CueCounters& counters() const { return timer_->counters(); }
  /// The counters of the chips that count.
  [[nodiscard]] std::vector<Counted> chip_counts() const { return counts_of_chips(chips_); }
  /// Says the first thing that is wrong and what to do; "" if nothing is.
  [[nodiscard]] std::string trouble() const;
  /// Whether the line of that name is on, as the pulses have set it.
  [[nodiscard]] bool is_on(std::string_view line) const;

 private:
  struct Line : PulseLine {
    std::string chip;
  };
  /// A chip has the lines first..first+lines-1 of lines_.
  struct Chip {
    std::string label;
    std::size_t first = 0, lines = 0;
    std::unique_ptr<ChipOutputs> outputs;
  };

  CueOutputs(const MoveFile& move, const RigFile& rig, const WholeFrames& line, const WholeFrames& part,
             RigHardware& hardware);
  void open_chips(RigHardware& hardware);
  void put_out(const CueCount& count);
  void log_pulse(const BegunPulse& begun);
  void log_played();
  void put_out(const EdgeInstant& instant);
  [[nodiscard]] std::optional<std::size_t> number_of(std::string_view line) const;

  std::vector<CuePulse> pulses_;
  std::vector<Line> lines_;
  std::vector<TimedPulse> timed_;
  std::optional<CueTimer> timer_;
  std::vector<BegunPulse> begun_;
  std::vector<EdgeInstant> instants_;
  TickChain chain_;
  const StepDrives* steps_ = nullptr;
  std::uint64_t levels_ = 0;
  bool has_refused_ = false;
  std::optional<std::size_t> camera_;
  std::optional<CueLog> log_;
  std::function<void(std::size_t pulse)> told_;
  std::optional<AwaitedPulses> awaited_;  ///< while pulses are logged
  std::uint64_t not_logged_ = 0;
  std::vector<Chip> chips_;
};

}  // namespace inbetween
