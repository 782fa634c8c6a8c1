// A rig as a host drives it: orders in, motions out, and what happens.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/dragonframe/rig_port.hpp"
#include "host_tools/dragonframe/uploaded_move.hpp"
#include "host_tools/hosted/hosted_motion.hpp"
#include "host_tools/hosted/row_move.hpp"
#include "host_tools/hosted/step_scale.hpp"
#include "host_tools/motions/transit.hpp"
#include "host_tools/rig_model/rig_file.hpp"

namespace inbetween {

struct HostedRigOptions {
  /// Of their limits, on every way but that of a run: above 0, up to 1.
  double share = transit_share;
  /// Before any of these axes moves; throws where nothing may move.
  std::function<void(std::span<const std::size_t>)> about_to_move = {};
  /// Everything has rested for a while.
  std::function<void(const std::vector<DriveState>&)> keep = {};
  std::function<bool()> rig_has_changed = {};
};

/// How many outputs of the rig a host has.
inline std::size_t output_count(const RigFile& rig) {
  return std::min(rig.outputs.size(), LevelOutputs::max_outputs);
}

/// Takes the orders of a RigPort, beside the loop's thread. Motor 1 is the first axis.
///
/// Its own limits come first: a position beyond one is soft_upper or soft_lower, and a run is proven with
/// its pre-roll and its post-roll before it is answered. A motor of its own, the way to a frame, to a start,
/// and JogAll use a share of the limits of the rig, and no more than the host has set; a run has its own
/// speed. Consent is the business of who stands between the host and this.
///
/// Outputs are those of the rig, in its order. Live and coupled motors and a camera's lines are unsupported.
class HostedRig {
 public:
  /// Refers to the rig, which has a section [dragonframe], and to the motion.
  HostedRig(const RigFile& rig, HostedMotion& motion, HostedRigOptions options);

  dragonframe::RigAnswer take(const dragonframe::RigOrder& order);
  /// Takes what the loop has told. Often: every few ticks.
  void look();
  /// As it was then.
  [[nodiscard]] const dragonframe::RigState& state() const { return state_; }
  [[nodiscard]] std::optional<dragonframe::RigEvent> take_event();
  /// Why something was refused or stopped, for the person at the terminal.
  [[nodiscard]] std::vector<std::string> take_words() { return std::exchange(words_, {}); }
  /// The time of the loop.
  [[nodiscard]] std::int64_t now_ns() const { return now_.now_ns; }

  /// The drives are on, and nothing has stopped the rig.
  [[nodiscard]] bool is_ready() const;
  /// After a stop the drives are asked where they are. is_ready() tells when they have told.
  void acknowledge();

 private:
  enum class Phase : std::uint8_t {
    none,
    going,     ///< axes by themselves
    along,     ///< the uploaded move, to a frame
    approach,  ///< the same, to where a run begins
    to_start,  ///< axes by themselves, to the pre-roll of a run or to a shot
    waiting,   ///< for Go
    running,   ///< until it rests
    stopping,
  };
  /// How the time line of what moves is told in frames of the host.
  struct HostFrames {
    std::int32_t first = 0;   ///< of the host's, at ...
    std::int32_t before = 0;  ///< ... this frame of the time line
    int direction = 1;
    std::int32_t count = 0;  ///< so many frames on it is over
    bool are_told = true;
  };
  struct Prepared {
    std::unique_ptr<RowMove> move;
    std::vector<std::size_t> axes;
    HostFrames frames;
    double delay_s = 0;
    dragonframe::MotorMask motors = 0;
    bool comes_round = false;
  };

  dragonframe::RigAnswer apply(const dragonframe::SetMotor& order);
  dragonframe::RigAnswer apply(const dragonframe::PlaceMotor& order);
  dragonframe::RigAnswer apply(const dragonframe::MoveMotor& order);
  dragonframe::RigAnswer apply(const dragonframe::JogMotor& order);
  dragonframe::RigAnswer apply(const dragonframe::StopMotor& order);
  dragonframe::RigAnswer apply(const dragonframe::StopAll& order);
  dragonframe::RigAnswer apply(const dragonframe::TakeMove& order);
  dragonframe::RigAnswer apply(const dragonframe::GoToFrame& order);
  dragonframe::RigAnswer apply(const dragonframe::JogAll& order);
  dragonframe::RigAnswer apply(const dragonframe::PrepareRun& order);
  dragonframe::RigAnswer apply(const dragonframe::PrepareShot& order);
  dragonframe::RigAnswer apply(const dragonframe::Go& order);
  dragonframe::RigAnswer apply(const dragonframe::StopLoop& order);
  dragonframe::RigAnswer apply(const dragonframe::SetOutputs& order);
  dragonframe::RigAnswer apply(const dragonframe::SetCamera& order);
  dragonframe::RigAnswer apply(const dragonframe::ForgetHost& order);

  // hosted_rig.cpp: axes by themselves.
  dragonframe::RigAnswer refuse(dragonframe::RigAnswer answer, std::string why);
  dragonframe::RigAnswer may_move();
  dragonframe::RigAnswer may_go();
  [[nodiscard]] dragonframe::RigAnswer judge_position(std::size_t axis, double& position);
  [[nodiscard]] FreeAxisLimits limits_of_axis(std::size_t axis) const;
  dragonframe::RigAnswer go(std::size_t axis, double position, double velocity);
  dragonframe::RigAnswer go_all(const std::vector<std::pair<std::size_t, double>>& targets);
  bool send(MotionOrder order, dragonframe::MotorMask moves = 0);
  bool mark(dragonframe::MotorMask motors);
  void leave_frame();
  [[nodiscard]] bool has_axis(std::uint8_t motor) const { return motor >= 1 && motor <= scales_.size(); }
  [[nodiscard]] const RigAxis& axis_of(std::size_t axis) const { return rig_.axes[axis]; }
  [[nodiscard]] double commanded(std::size_t axis) const { return now_.commanded.at(axis); }

  // hosted_plays.cpp: the uploaded move.
  [[nodiscard]] std::vector<std::size_t> axes_of(dragonframe::MotorMask motors) const;
  dragonframe::RigAnswer prove_travel(dragonframe::MotorMask motors);
  dragonframe::RigAnswer begin_travel(std::int32_t frame, double rate);
  [[nodiscard]] double position_at(std::size_t axis, std::int32_t frame) const;
  dragonframe::RigAnswer prove_run(const dragonframe::PrepareRun& order, Prepared& run);
  dragonframe::RigAnswer go_to_start();
  void begin_phase(Phase phase, dragonframe::MotorMask motors);
  void retire(std::unique_ptr<RowMove> move);
  void drop_prepared();
  void drop_travel();
  void drop_retired();

  // hosted_events.cpp: what the loop tells.
  void note(const MotionState& now);
  void note_frames(const MotionState& now);
  void note_rest();
  void note_refusal(const MotionState& now);
  void note_stop(SupervisorState was);
  void show();
  void keep_places();
  void tell(dragonframe::RigEvent event) { events_.push_back(event); }

  const RigFile& rig_;
  HostedMotion& motion_;
  HostedRigOptions options_;
  std::vector<StepScale> scales_;
  std::vector<dragonframe::MotorSettings> settings_;
  MotionState now_;
  std::uint32_t sent_ = 0;
  dragonframe::MotorMask pending_ = 0;  ///< ordered to move, and not yet heard
  std::uint32_t refused_ = 0;
  Phase phase_ = Phase::none;
  dragonframe::MotorMask phase_motors_ = 0;

  const dragonframe::UploadedMove* upload_ = nullptr;
  dragonframe::MotorMask uploaded_ = 0;
  Prepared travel_;
  Prepared run_;
  std::vector<std::unique_ptr<RowMove>> retired_;  ///< to which the loop may still refer
  std::uint32_t forget_ = 0;                       ///< the order by which it does no longer; 0: not given
  std::optional<std::int32_t> at_frame_;           ///< of the upload, where the rig stands
  std::optional<std::int32_t> goal_frame_;         ///< to which it goes
  std::optional<HostFrames> told_frames_;          ///< of what moves
  double told_time_ = 0;
  std::int64_t told_repeats_ = 0;
  bool has_ended_ = false;

  dragonframe::RigState state_;
  std::deque<dragonframe::RigEvent> events_;
  std::vector<std::string> words_;
  bool is_marked_ = false;
  std::int64_t rested_ns_ = 0;
};

}  // namespace inbetween
