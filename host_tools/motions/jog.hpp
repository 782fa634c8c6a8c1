// Axes of a rig moved by hand, one at a time, as long as a key is held.
#pragma once

#include <cstddef>
#include <cstdint>
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

/// An axis rests no later than this after its key has come for the last time (docs/faults.md 41) ...
inline constexpr double jog_stops_within_s = 0.2;
/// ... of which the key may be missed for so long: terminals repeat a key 11 to 30 times a second.
inline constexpr double jog_key_missed_s = 0.1;
/// An axis that does not know where it is gets this part of the share that another axis gets.
inline constexpr double unreferenced_jog_share = 0.1;
/// Such an axis goes this part of the way between its limits, until the key is let go.
inline constexpr double unreferenced_way_share = 0.01;

/// At up to `share` of its velocity, the speed at which an axis can be held to run. With a tick so long that
/// there is none it is 0.
double jog_speed(const RigAxis& axis, double share, double tick_seconds);

/// An axis in a Jog. Names live longer than it.
struct JogAxis {
  const char* name = "";
  const char* unit = "";
  double speed = 0;  ///< unit/s
  bool is_referenced = true;
  double way = 0;  ///< of an unreferenced axis, until the key is let go, in unit
};

/// Hold to run, as an act of a motion loop that comes back for its caller: over when somebody has left, and
/// whenever something has to be written before it can go on (`asks`). Refers to the loop, the axes and the
/// spec's memory. Allocates only when it is made.
///
/// Left and right, or - and +, are the directions; up and down choose the axis, and any other key stops. An
/// axis is let go when its key has not come for jog_key_missed_s, and rests jog_stops_within_s after it came
/// for the last time: its speed is one from which the rest of that time is enough. A terminal that is gone
/// sends no keys. A referenced axis stays inside its soft limits.
class Jog final : public LoopTask {
 public:
  enum class Ask : std::uint8_t {
    none,
    mark,  ///< axis selected() is about to move
    keep,  ///< everything rests that has moved
  };

  Jog(RunLoop& loop, const FreeSpec<double>& spec, FreeAxes& free, std::vector<JogAxis> axes,
      std::size_t selected);

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
  /// The states of all drives in the last tick.
  [[nodiscard]] const std::vector<DriveState<double>>& states() const { return states_; }
  /// The operator is the reason that it is over, and nothing else is.
  [[nodiscard]] bool was_left() const {
    return keys_.wants_to_leave() && loop_.state() == SupervisorState::latched && !keys_.has_lost_time();
  }

 private:
  void hold(int direction);
  void set_off();
  void drive();
  void let_go();
  void choose(std::size_t axis);
  [[nodiscard]] FreeAxis<double>& axis() { return free_.axes()[selected_]; }

  RunLoop& loop_;
  FreeSpec<double> spec_;
  FreeAxes& free_;
  std::vector<JogAxis> axes_;
  std::vector<bool> is_marked_;
  std::vector<DriveState<double>> states_;
  OperatorKeys keys_;
  std::size_t selected_;
  Ask ask_ = Ask::none;
  bool has_begun_ = false;
  int held_ = 0;             ///< the direction of the key that is held
  std::int64_t key_ns_ = 0;  ///< no later than when it came
  std::int64_t now_ns_ = 0;
  std::int64_t rested_ns_ = 0;  ///< when it did not rest for the last time
};

struct JogOptions {
  /// The share of max_velocity that an axis may use, up to 1.
  double share = 0.1;
  SessionOptions session = {};
};

/// Lets somebody at the keys of the audience move axes, beginning with `selected`, until they leave.
/// SetupEnd::is_done: nothing else was the end. Throws InputError where an axis cannot be held to run because
/// the ticks of the rig are too long, and what RigSession and RigReference throw.
SetupEnd jog(const RigFile& rig, std::size_t selected, RigReference& reference, const JogOptions& options);

}  // namespace inbetween
