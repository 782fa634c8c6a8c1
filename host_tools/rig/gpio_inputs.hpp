// The input lines of a rig file under the motion loop.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/linux/emergency_signal.hpp"
#include "host_tools/rig/rig_hardware.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/homing/homing.hpp"
#include "inbetween/homing/line_event.hpp"
#include "inbetween/homing/switch_input.hpp"

namespace inbetween {

/// A LinePort for the emergency stop, the limit and home switches, the start trigger and the line of the
/// camera. SIGUSR1 is an emergency stop beside the wired one, SIGUSR2 releases it: one RigInputs at a time.
///
/// A wired input is asked for its level on every tick and for its edges, which have the times at which they
/// came. `read` makes two system calls for each chip, and on chips takes no memory.
class RigInputs {
 public:
  /// Takes the input lines of all chips. The rig and the hardware last longer. Throws InputError at the place
  /// of a line that is not there or that somebody else uses, whom it names; then nothing has changed.
  RigInputs(const RigFile& rig, RigHardware& hardware);
  RigInputs(const RigInputs&) = delete;
  RigInputs& operator=(const RigInputs&) = delete;

  void read(std::int64_t now_ns);

  /// The level asks to stop, or did for a moment since the tick before the last; edges of its chip were lost,
  /// any of which may have been one of its; or a chip has gone.
  [[nodiscard]] bool emergency_stop() const { return asks_to_stop_ || EmergencySignal::is_pressed(); }
  /// In the last tick a limit switch has become active, or was found never to be quiet. An axis that stands
  /// on its switch may leave it.
  [[nodiscard]] bool limit_hit() const { return limit_hit_; }
  void begin() {
    stop_ = Stop::none;
    last_limit_.reset();
  }
  [[nodiscard]] bool is_gone() const;

  /// The edges of all lines in the last tick, in the order of their times. Each line has a number in the rig.
  [[nodiscard]] std::span<const LineEvent> events() const { return events_; }
  /// For HomingSpec. Of an axis with a home switch.
  [[nodiscard]] SwitchSettings home_switch(std::size_t axis) const;
  /// The input of the last tick; limit_hit while a limit switch of the axis is active. It has nothing of the
  /// drive.
  [[nodiscard]] HomingInput homing_input(std::size_t axis) const;

  /// The start trigger has become active, and stayed so, since the last call.
  bool start_triggered();
  /// The camera has asked since the last call: by a pulse however short, but not by the bounces after it.
  bool camera_asks();

  /// Says what has stopped the rig and what to do, in order of weight: a chip, the emergency stop, the last
  /// limit switch; "" if nothing has. Not for the loop's thread.
  [[nodiscard]] std::string trouble() const;

 private:
  enum class Stop : std::uint8_t { none, pressed, events_lost };

  struct Line {
    const InputLine* input = nullptr;
    std::size_t chip = 0;    ///< of chips_
    std::size_t number = 0;  ///< on its chip
    bool level = false;
  };
  struct Chip : RigHardware::OpenedInputs {
    std::span<const LineEvent> events = {};  ///< of the last tick
  };
  struct Limit {
    std::size_t axis = 0;
    std::size_t line = 0;
    SwitchInput input;
    bool was_chattering = false;
  };
  struct AxisLines {
    std::optional<std::size_t> home;  ///< of lines_
    std::vector<std::size_t> limits;  ///< of limits_
  };

  std::size_t add(const InputLine& input);
  void add_limit(std::size_t axis, const InputLine& input);
  [[nodiscard]] SwitchSettings settings_of(std::size_t line) const;
  void open(RigHardware& hardware);

  void read_chip(Chip& chip, std::int64_t now_ns);
  void put_in_order();
  void look_at_emergency_stop();
  void look_at_limits(std::int64_t now_ns);
  void look_at_buttons(std::int64_t now_ns);

  const RigFile& rig_;
  EmergencySignal signal_;
  std::vector<Line> lines_;
  std::vector<Chip> chips_;
  std::vector<LineEvent> events_;
  std::optional<std::size_t> emergency_, trigger_, asks_;  ///< of lines_
  std::vector<Limit> limits_;
  std::vector<AxisLines> axes_;
  std::optional<SwitchInput> trigger_input_, asks_input_;
  bool has_started_ = false;
  bool asks_to_stop_ = false;
  bool limit_hit_ = false;
  bool start_triggered_ = false;
  bool camera_asks_ = false;
  Stop stop_ = Stop::none;                 ///< the last that was
  std::optional<std::size_t> last_limit_;  ///< of limits_
};

}  // namespace inbetween
