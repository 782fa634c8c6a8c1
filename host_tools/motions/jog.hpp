// Axes of a rig moved by hand, step by step.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tools/loop/loop_task.hpp"
#include "host_tools/loop/operator_keys.hpp"
#include "host_tools/loop/rig_session.hpp"
#include "host_tools/loop/run_loop.hpp"
#include "host_tools/motions/free_axes.hpp"
#include "inbetween/loop/motion_loop.hpp"

namespace inbetween {

/// A press counts if no other came so long before it, and none so long after it. A terminal does not tell a
/// key that is let go, but it repeats one that is held 11 to 30 times a second: those repeats move nothing.
inline constexpr double jog_repeat_s = 0.15;
/// A press moves nothing if the disk kept it waiting for longer (docs/faults.md 41).
inline constexpr double jog_press_waits_s = 0.5;
/// A held key that is not told to be held for so long is let go: with the way to the loop 200 ms at most.
inline constexpr double jog_silence_s = 0.15;
/// An axis that does not know where it is gets this part of the velocity that another axis gets.
inline constexpr double unreferenced_jog_share = 0.1;
/// No step is longer than this part of the way between the limits of its axis.
inline constexpr double jog_way_share = 0.01;

using JogIncrements = std::array<double, 5>;
/// The sizes of a step of the axis, the smallest first: every second number of the series 1, 2, 5, 10 up to
/// jog_way_share of its range.
JogIncrements jog_increments(const RigAxis& axis);

/// An axis in a Jog. Names live longer than it.
struct JogAxis {
  const char* name = "";
  const char* unit = "";
  JogIncrements increments = {};
  double min = 0, max = 0;  ///< soft limits; none where it is not referenced
  double count = 0;         ///< of its drive, in its unit; 0 where it has none
  bool is_referenced = true;
  double reach = 0;  ///< as far as a held key moves it at most; 0: it moves by steps
};

/// Steps by keys, as an act of a motion loop that comes back for its caller: over when somebody has left, and
/// whenever something has to be written before it can go on (`asks`). Refers to the loop, the axes and the
/// spec's memory. Allocates only when it is made.
///
/// Left and right, or - and +, move the selected axis by its increment, and 1 to 5 choose that; up and down
/// choose the axis, and any other key stops. One step at a time: a press while something moves does nothing,
/// and nothing waits for its turn. So nothing goes further than the increment of a press that somebody made,
/// whatever becomes of the terminal. A referenced axis stays inside its soft limits.
///
/// An axis with a reach moves while a key of a device is held (hold_forward, hold_backward), until that is
/// let go, is not told to be held any more, or has moved it by its reach; it must then be pressed anew.
///
/// A detent of a wheel is a step too, at once. One that comes while something moves is dropped: when the
/// wheel rests, the axis goes no further than the step that it is in.
///
/// With `teaches`, keys that concern a move are for the caller to do, once everything rests (`teach`).
class Jog final : public LoopTask {
 public:
  enum class Ask : std::uint8_t {
    none,
    mark,   ///< axis selected() is about to move
    keep,   ///< everything rests that has moved
    teach,  ///< taught() was pressed
  };

  Jog(RunLoop& loop, const FreeSpec& spec, FreeAxes& free, std::vector<JogAxis> axes, std::size_t selected,
      bool teaches = false);

  /// Errors: those of MotionLoop::load and begin, the first time.
  Status begin() override;
  void press(TransportKey key) override;
  void tick(std::int32_t ticks, std::int64_t now_ns) override;
  [[nodiscard]] bool is_over() const override { return ask_ != Ask::none || keys_.has_left(); }
  [[nodiscard]] RunSnapshot snapshot() const override;

  // Between the acts.

  [[nodiscard]] Ask asks() const { return ask_; }
  [[nodiscard]] std::size_t selected() const { return selected_; }
  void marked();
  void kept();
  /// The key about a move. TransportKey::start is a key at the end.
  [[nodiscard]] TransportKey taught() const { return taught_; }
  void has_taught() { ask_ = Ask::none; }
  /// The states of all drives in the last tick.
  [[nodiscard]] const std::vector<DriveState>& states() const { return states_; }
  /// The operator is the reason that it is over, and nothing else is.
  [[nodiscard]] bool was_left() const {
    return keys_.wants_to_leave() && loop_.state() == SupervisorState::latched && !keys_.has_lost_time();
  }

 private:
  void pressed(int direction);
  void turned(int direction);
  void teach(TransportKey key);
  void take_press();
  void step(int direction);
  void choose(std::size_t axis);
  void choose_increment(std::size_t size);
  void stop();
  void hold(int direction);
  void take_hold();
  void let_go();
  [[nodiscard]] FreeAxis& axis() { return free_.axes()[selected_]; }

  RunLoop& loop_;
  FreeSpec spec_;
  FreeAxes& free_;
  std::vector<JogAxis> axes_;
  std::vector<bool> is_marked_;
  std::vector<DriveState> states_;
  OperatorKeys keys_;
  std::size_t selected_;
  std::size_t size_ = 2;  ///< of the increments
  bool teaches_;
  Ask ask_ = Ask::none;
  TransportKey taught_ = TransportKey::start;
  bool has_begun_ = false;
  int pressed_ = 0;         ///< the direction of a press or a detent that is not taken yet
  bool is_detent_ = false;  ///< it cannot be the repeat of a key
  std::optional<std::int64_t> pressed_ns_ = {};  ///< when the last one came, taken or not
  int held_ = 0;                                 ///< the direction of a key that is held
  bool has_begun_hold_ = false;
  std::int64_t held_ns_ = 0;  ///< when that was told last
  std::int64_t now_ns_ = 0;
  std::int64_t rested_ns_ = 0;  ///< when it did not rest for the last time
};

struct JogOptions {
  /// The share of its limits that an axis may use, up to 1. A stop may use all of them.
  double share = 0.1;
  /// With a device whose keys are held: the share of its range that an axis moves at most. None: steps.
  std::optional<double> reach = {};
  /// What a key about a move does (Jog::taught), with the selected axis and where every axis of the rig was
  /// told to stand. None: such keys are keys like others.
  std::function<void(TransportKey key, std::size_t axis, const std::vector<double>& positions)> teach = {};
  SessionOptions session = {};
};

/// Lets somebody at the keys of the audience move axes, beginning with `selected`, until they leave.
/// SetupEnd::is_done: nothing else was the end. Throws what RigSession and RigReference throw.
SetupEnd jog(const RigFile& rig, std::size_t selected, RigReference& reference, const JogOptions& options);

}  // namespace inbetween
