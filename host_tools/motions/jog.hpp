// Axes of a rig moved by hand, step by step.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host_tools/loop/key_hold.hpp"
#include "host_tools/loop/loop_task.hpp"
#include "host_tools/loop/operator_keys.hpp"
#include "host_tools/loop/rig_session.hpp"
#include "host_tools/loop/run_loop.hpp"
#include "host_tools/motions/free_axes.hpp"
#include "inbetween/loop/motion_loop.hpp"

namespace inbetween {

/// A press moves nothing if the disk kept it waiting for longer (docs/faults.md 41).
inline constexpr double jog_press_waits_s = 0.5;
/// A held key of a device that is not told to be held for so long is let go: with the delay to the loop 200
/// ms at most. Of a terminal: KeyHold.
inline constexpr double jog_silence_s = 0.15;
/// No key that is held moves an axis further than this part of its range, unless somebody says otherwise.
inline constexpr double jog_reach_share = 0.1;
/// An axis that does not know where it is gets this part of the velocity that another axis gets.
inline constexpr double unreferenced_jog_share = 0.1;
/// No step is longer than this part of the range between the limits of its axis, or than a count of its
/// drive.
inline constexpr double jog_step_share = 0.01;

/// The keys of a Jog beside those that it always has.
struct JogKeys {
  bool teach = false;   ///< those that concern a move are for the caller to do (Jog::taught)
  bool device = false;  ///< a device moves the axes, and not the terminal
};

using JogIncrements = std::array<double, 5>;
/// The sizes of a step of the axis, the smallest first: every second number of the series 1, 2, 5, 10 up to
/// jog_step_share of its range, and a count of its drive (count_of) in place of those that are less.
JogIncrements jog_increments(const RigAxis& axis);

/// An axis in a Jog. Names live longer than it.
struct JogAxis {
  const char* name = "";
  const char* unit = "";
  JogIncrements increments = {};
  double min = 0, max = 0;                   ///< soft limits; none where it is not referenced
  double count = 0;                          ///< of its drive, in the unit of its motor
  const Calibration* calibration = nullptr;  ///< of the motor; none where its unit is that of the axis
  bool is_referenced = true;
  double reach = 0;  ///< as far as a held key moves it at most

  /// A step of a size from a position, one way: it moves the motor by a count at least.
  [[nodiscard]] double increment(std::size_t size, double position, int direction) const;
};

/// Steps by keys, as an act of a motion loop that comes back for its caller: over when somebody has left, and
/// whenever something has to be written before it can go on (`asks`). Refers to the loop, the axes and the
/// spec's memory. Allocates only when it is made.
///
/// Left and right, or - and +, move the selected axis by its increment, and 1 to 5 choose that; up and down
/// choose the axis, and any other key stops. One step at a time: a press while something moves does nothing,
/// and nothing waits for its turn. A referenced axis stays inside its soft limits.
///
/// Once its step is done a key that is held (KeyHold) moves the axis on, until it is let go, is not told to
/// be held any more, or has moved it by its reach; it must then be pressed anew. So nothing goes further than
/// the increment of a press that somebody made, and the reach while a key was told to be held, whatever
/// becomes of the terminal. A key of a device moves the axis while it is held (hold_forward, hold_backward)
/// in the same way, and without a step; those of the terminal that have a direction do nothing then.
///
/// A detent of a wheel is a step too, at once. One that comes while something moves is dropped: when the
/// wheel rests, the axis goes no further than the step that it is in.
///
/// Keys that concern a move are for the caller to do, if they are wanted, once everything rests (`teach`).
class Jog final : public LoopTask {
 public:
  enum class Ask : std::uint8_t {
    none,
    mark,   ///< axis selected() is about to move
    keep,   ///< everything rests that has moved
    teach,  ///< taught() was pressed
  };

  Jog(RunLoop& loop, const FreeSpec& spec, FreeAxes& free, std::vector<JogAxis> axes, std::size_t selected,
      JogKeys keys = {});

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
  void look_at_terminal();
  void teach(TransportKey key);
  void take_press();
  void step(int direction);
  void choose(std::size_t axis);
  void choose_increment(std::size_t size);
  void stop();
  void hold(int direction);
  void take_hold();
  void begin_hold();
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
  JogKeys wanted_;
  Ask ask_ = Ask::none;
  TransportKey taught_ = TransportKey::start;
  bool has_begun_ = false;
  KeyHold terminal_;
  int pressed_ = 0;              ///< the direction of a press or a detent that is not taken yet
  std::int64_t pressed_ns_ = 0;  ///< when it came
  int held_ = 0;                 ///< the direction of a key that is held
  bool has_begun_hold_ = false;
  std::int64_t held_ns_ = 0;  ///< when that was told last
  std::int64_t now_ns_ = 0;
  std::int64_t rested_ns_ = 0;  ///< when it did not rest for the last time
};

struct JogOptions {
  /// The share of its limits that an axis may use, up to 1. A stop may use all of them.
  double share = 0.1;
  /// The share of its range that a key that is held moves an axis at most.
  double reach = jog_reach_share;
  /// The audience has a device whose keys are held.
  bool has_device = false;
  /// What a key about a move does (Jog::taught), with the selected axis and where every axis of the rig was
  /// told to stand. None: such keys are keys like others.
  std::function<void(TransportKey key, std::size_t axis, const std::vector<double>& positions)> teach = {};
  SessionOptions session = {};
};

/// The axes that can be moved in one jog() that begins with `selected`: all of the rig, or that one alone
/// where it does not know where it is (use_alone).
std::vector<std::size_t> jogged_axes(const RigFile& rig, std::size_t selected, const RigReference& reference);

/// Lets somebody at the keys of the audience move jogged_axes(), beginning with `selected`, until they leave;
/// the snapshots are of those. SetupEnd::is_done: nothing else was the end. Throws InputError where an axis
/// is taught that does not know where it is, and what RigSession and RigReference throw.
SetupEnd jog(const RigFile& rig, std::size_t selected, RigReference& reference, const JogOptions& options);

}  // namespace inbetween
