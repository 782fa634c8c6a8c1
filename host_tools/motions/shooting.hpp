// A move shot frame by frame, and the keys for it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/loop/loop_task.hpp"
#include "host_tools/loop/operator_keys.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/motions/start_signal.hpp"
#include "host_tools/rig/cue_outputs.hpp"
#include "inbetween/play/frame_shoot.hpp"
#include "sim/simulated_camera.hpp"

namespace inbetween {

/// As somebody asks for it.
struct ShootOptions {
  double settle_s = 0.5;
  double exposure_s = 0.1;                      ///< of the camera's signal; with a shutter, of the exposure
  std::optional<Shutter<double>> shutter = {};  ///< the rig moves while it is open
  std::vector<std::string> still = {};          ///< axes that stand still meanwhile
  bool is_loop = false;  ///< the last frame of the move is its first, and is not shot again
};

/// In ticks of a rig, rounded up.
ShootSpec<double> shoot_spec(const ShootOptions& options, std::int32_t rate_hz);

/// The last frame that is shot.
std::int32_t last_shot(const MoveFile& move, const ShootOptions& options);

/// Throws LimitError, at the place of the number of frames, where a frame cannot be exposed as wanted.
void refuse_exposures(StagedMove& staged, const ShootOptions& options);

/// The lines of the rig's own camera.
struct ShootingLines {
  CueOutputs* cues = nullptr;  ///< with the line of its shutter
  StartSignal asks = {};       ///< asks for the next frame
};

/// Shoots a move in a loop. Refers to all of them. Allocates nothing.
class Shooting final : public LoopTask {
 public:
  Shooting(RunLoop& loop, StagedMove& staged, SimulatedCamera& camera, const ShootOptions& options,
           bool is_attended, const ShootingLines& lines = {})
      : loop_(loop),
        spec_(staged.loop_spec()),
        camera_(camera),
        frames_(last_shot(staged.plan().move(), options)),
        shoot_(shoot_spec(options, staged.plan().rig()->rate_hz), frames_, staged.playhead(), staged.still()),
        keys_(loop, is_attended),
        lines_(lines) {}

  /// Goes to the frame that it was at and shoots it. Errors: those of MotionLoop::begin and
  /// FrameShoot::shoot.
  Status begin() override;
  void press(TransportKey key) override;
  void tick(std::int32_t ticks, std::int64_t now_ns) override;
  [[nodiscard]] bool is_over() const override { return is_done() || keys_.has_left(); }
  [[nodiscard]] const OperatorKeys& keys() const { return keys_; }
  /// Every frame is shot, and the last was acknowledged.
  [[nodiscard]] bool is_done() const { return shoot_.phase() == ShootPhase::done; }
  [[nodiscard]] std::int64_t exposures() const { return shoot_.exposures(); }
  [[nodiscard]] RunSnapshot snapshot() const override;

 private:
  void look(int by);

  RunLoop& loop_;
  LoopSpec<double> spec_;
  SimulatedCamera& camera_;
  std::int32_t frames_;
  FrameShoot<double> shoot_;
  OperatorKeys keys_;
  ShootingLines lines_;
};

}  // namespace inbetween
