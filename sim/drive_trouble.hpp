#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "inbetween/can/sdo.hpp"

namespace inbetween {

/// A fault of a simulated drive, and its time.
struct DriveTrouble {
  enum class Kind : std::uint8_t {
    lose_feedback,   ///< TPDOs are not sent
    lose_heartbeat,  ///< heartbeats are not sent
    emergency,       ///< at `at_ns`: an EMCY with code `value`, and a fault
    stick,           ///< the motor is held
    run_away,        ///< with power the motor runs at `place` drive units/s, whatever it is told
    blind,           ///< it does not see its following error
    other_scale,     ///< it takes positions for `place` times what they are
    reboot,          ///< at `at_ns`: the drive starts anew
    move_by_hand,    ///< at `at_ns`: the axis is moved by `value` counts
    put_by_hand,  ///< at `at_ns`: the axis is moved to `place`, from where 0 was at power-on, in drive units
    wrong_mode,   ///< 6061 shows mode `value`
    ignore_target,   ///< statusword bit 12 is clear, and the axis comes to rest
    lose_sent,       ///< nothing that it sends arrives
    lose_heard,      ///< nothing that is sent to it arrives
    shorten,         ///< its process data lack their last byte
    duplicate,       ///< its process data come twice
    foreign_sender,  ///< at `at_ns`: a target for it that is not from the host: where it stands
    flood,           ///< it sends `value` SDO answers a second that nobody has asked for
    stay_on,         ///< it does not take the order to switch off; its watchdogs still do
    switched_off,    ///< at `at_ns`: somebody switches it off, by another way than this bus
    sink,            ///< without power the axis moves by `value` counts/s
    no_home,         ///< it does not see its home switch
    homing_error,    ///< its homing fails: bit 13 of the statusword, and the axis comes to rest
    no_window,       ///< at `at_ns`: it is one that does not watch its following error
    no_watchdog,     ///< at `at_ns`: it is one with neither heartbeat consumer nor setpoint timer
    no_object,       ///< at `at_ns`: it is one without `object`
    fixed_object,    ///< at `at_ns`: it is one whose `object` is `value` and can only be read
    silent_object,   ///< at `at_ns`: it is one that does not answer for `object`
  };
  Kind kind = Kind::lose_feedback;
  std::int64_t at_ns = 0;
  std::int64_t for_ns = std::int64_t{1} << 62;
  std::int32_t value = 0;
  double place = 0;  ///< put_by_hand, run_away, other_scale
  /// How many frames are lost, shortened or doubled at most; of those meant for it, where it hears nothing.
  std::int32_t frames = std::numeric_limits<std::int32_t>::max();
  can::ObjectAddress object{};
};

/// The faults of one simulated drive, and how far each has come. Times are those of the drive.
class DriveTroubles {
 public:
  using Kind = DriveTrouble::Kind;

  void add(const DriveTrouble& trouble) { met_.push_back({.trouble = trouble}); }
  [[nodiscard]] bool has_any() const { return !met_.empty(); }
  /// Takes the next one that begins by `now_ns` and has not begun before.
  std::optional<DriveTrouble> begin_next(std::int64_t now_ns);
  [[nodiscard]] bool has(Kind kind, std::int64_t now_ns) const;
  /// 0 where there is none.
  [[nodiscard]] std::int32_t value(Kind kind, std::int64_t now_ns) const;
  [[nodiscard]] std::optional<double> place(Kind kind, std::int64_t now_ns) const;
  /// Whether such a trouble takes this frame; it is one of those that it may take.
  bool takes_frame(Kind kind, std::int64_t now_ns);
  /// How many frames of a flood are due since the last call.
  std::int64_t flood(std::int64_t now_ns);

 private:
  struct Met {
    DriveTrouble trouble;
    bool is_begun = false;
    std::int64_t frames = 0;  ///< that it has taken or, in a flood, sent
  };
  /// The first of this kind that is there now; null where there is none.
  [[nodiscard]] const DriveTrouble* find(Kind kind, std::int64_t now_ns) const;

  std::vector<Met> met_;
};

}  // namespace inbetween
