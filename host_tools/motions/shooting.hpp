// A move shot frame by frame, and the keys for it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/loop/loop_task.hpp"
#include "host_tools/loop/operator_keys.hpp"
#include "host_tools/motions/place_entry.hpp"
#include "host_tools/motions/shoot_count.hpp"
#include "host_tools/motions/shoot_log.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/motions/start_signal.hpp"
#include "host_tools/rig/cue_outputs.hpp"
#include "host_tools/text/frame_range.hpp"
#include "inbetween/play/frame_shoot.hpp"
#include "sim/simulated_camera.hpp"

namespace inbetween {

/// As somebody asks for it.
struct ShootOptions {
  double settle_s = 0.5;
  double exposure_s = 0.1;              ///< of the camera's signal; with a shutter, of the exposure
  std::optional<Shutter> shutter = {};  ///< the rig moves while it is open
  std::vector<std::string> still = {};  ///< axes that stand still meanwhile
  bool is_loop = false;                 ///< the last frame of the move is its first, and is not shot again
  FrameRange frames = {};               ///< those that are shot; all where nothing is said
  std::optional<std::string> log = {};  ///< a line for each exposure goes there (shoot_log.hpp)
  std::vector<LoggedShot> before = {};  ///< that were shot before, of the frames of the move
};

/// In ticks of a rig, rounded up.
ShootSpec shoot_spec(const ShootOptions& options, const RigFile& rig);

/// The frames of the move that are shot. Throws InputError where it has no such frames.
WholeFrames shot_frames(const MoveFile& move, const ShootOptions& options);

/// How often each of these frames was shot before.
std::vector<std::int32_t> shots_before(const MoveFile& move, const ShootOptions& options);

/// Where a shoot begins: on the first of its frames that was not shot before, if there is one.
std::int32_t first_frame_of(const MoveFile& move, const ShootOptions& options);

/// The lines of the rig's own camera.
struct ShootingLines {
  CueOutputs* cues = nullptr;  ///< with the line of its shutter
  StartSignal asks = {};       ///< asks for the next frame
  ShootLog* log = nullptr;
};

/// Shoots a move in a loop. Nothing is exposed before a key, or the camera, has asked for it. Refers to all
/// of them. Allocates only when it is made.
class Shooting final : public LoopTask {
 public:
  Shooting(RunLoop& loop, StagedMove& staged, SimulatedCamera& camera, const ShootOptions& options,
           bool is_attended, const ShootingLines& lines = {});

  /// Goes to the frame that it was at and stands there. Errors: those of MotionLoop::begin and
  /// FrameShoot::look_at.
  Status begin() override;
  void press(TransportKey key) override;
  void tick(std::int32_t ticks, std::int64_t now_ns) override;
  [[nodiscard]] bool is_over() const override { return is_done() || keys_.has_left(); }
  [[nodiscard]] const OperatorKeys& keys() const { return keys_; }
  /// No frame is left behind the last, which was acknowledged.
  [[nodiscard]] bool is_done() const { return shoot_.phase() == ShootPhase::done; }
  [[nodiscard]] std::int64_t exposures() const { return shoot_.exposures(); }
  [[nodiscard]] ShootCount count() const;
  [[nodiscard]] RunSnapshot snapshot() const override;
  /// Of axes that stand still during exposures the setpoints are those of another place.
  [[nodiscard]] std::optional<PlayedPlace> played() const override { return played_; }
  [[nodiscard]] std::optional<double> frame() const override {
    return spec_.playhead->time().frame + spec_.playhead->time().fraction;
  }

 private:
  void look_at(std::int32_t frame);
  void log(bool is_whole);

  RunLoop& loop_;
  LoopSpec spec_;
  SimulatedCamera& camera_;
  std::int32_t frames_;  ///< N of the move
  WholeFrames due_;
  std::vector<std::int32_t> shots_;
  FrameShoot shoot_;
  std::int64_t shot_before_;               ///< exposures of those that it goes on with
  std::optional<std::int32_t> begins_on_;  ///< until it has begun
  OperatorKeys keys_;
  PlaceEntry entry_;
  ShootingLines lines_;
  std::int64_t cut_off_ = 0;
  std::optional<PlayedPlace> played_ = {};
};

}  // namespace inbetween
