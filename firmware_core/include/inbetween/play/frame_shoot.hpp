#pragma once

#include <cstdint>
#include <optional>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/play/playhead.hpp"

/// Shoots a move frame by frame: the rig rests on each frame (stop motion), or moves while each frame is
/// exposed (go-motion).

namespace inbetween {

enum class ShootPhase : std::uint8_t {
  idle,        ///< nothing has begun, or it was interrupted
  travelling,  ///< moves to the frame, or to the start of the run-up to its exposure
  settling,    ///< rests until the rig has stopped swinging
  standing,    ///< rests on a frame that somebody looks at; a trigger shoots it
  exposing,    ///< the camera has its signal, or the rig runs up to its exposure or out of it
  waiting,     ///< the frame is shot; a trigger goes on to the next
  done,        ///< the last frame is shot and was acknowledged by a trigger
};
inline constexpr int shoot_phases = 7;

/// The part of a frame during which the shutter is open, in frames from the frame on: 0..0.5 is a shutter of
/// 180 degrees that opens on the frame, -0.25..0.25 one that is centred on it.
template <Precise Real>
struct Shutter {
  Real open = 0;
  Real close = Real(0.5);
};

template <Precise Real>
struct ShootSpec {
  std::int64_t settle_ticks = 0;
  std::int64_t exposure_ticks = 1;  ///< length of the camera's signal if the rig rests meanwhile; at least 1
  std::optional<Shutter<Real>> shutter;  ///< the rig moves while it is open
  Real exposure_s = 0;                   ///< with a shutter: how long it is open
};

/// Decides what the playheads of a rig do, frame by frame, and when the camera has its signal. It goes to a
/// frame, settles, signals the camera, waits for a trigger, and so on over frames 0..N. Nothing moves while
/// the camera has its signal, unless a shutter is given.
///
/// If there is a shutter, the axes of `moving` pass each exposure at a constant rate (Playhead::expose), and
/// the axes of `still` rest on the frame meanwhile. Exposures of frames 0 and N may reach beyond the ends of
/// the time line, where nothing moves.
///
/// Refers to the playheads; the motion loop ticks them. O(1) a tick, no allocation.
template <Precise Real>
class FrameShoot {
 public:
  /// `frames` is N of the move. `still` may be null.
  FrameShoot(const ShootSpec<Real>& spec, std::int32_t frames, Playhead<Real>& moving, Playhead<Real>* still)
      : spec_(spec), frames_(frames), moving_(&moving), still_(still) {}

  /// Checks that every frame can be exposed as wanted. Errors: those of Playhead::go_to_run_up, with frame.
  /// O(N times the cells that a run-up passes).
  [[nodiscard]] Status check() const;
  /// Goes to a frame and shoots it. The playheads rest. Errors: out_of_range (no such frame; the camera
  /// exposes), those of Playhead::go_to_run_up.
  Status shoot(std::int32_t frame);
  /// Goes to a frame and stands there. Errors: out_of_range (no such frame; the rig moves or the camera
  /// exposes).
  Status look_at(std::int32_t frame);
  /// Takes a trigger from a key or from the line of a camera. A trigger during the run-out of an exposure is
  /// kept until the rig rests. Errors: out_of_range if nothing waits for it.
  Status trigger();
  /// Tells that the rig was stopped: the camera loses its signal, and the frame is not shot.
  void interrupt();
  /// The caller calls this after every tick of the motion loop, with the event of `moving`.
  void tick(PlayheadEvent event);

  /// The camera's signal.
  [[nodiscard]] bool camera() const { return camera_; }
  [[nodiscard]] ShootPhase phase() const { return phase_; }
  /// The frame that it goes to, stands on or shoots.
  [[nodiscard]] std::int32_t frame() const { return frame_; }
  /// The number of exposures; a frame that is shot twice counts twice.
  [[nodiscard]] std::int64_t exposures() const { return exposures_; }

 private:
  [[nodiscard]] Exposure<Real> exposure_of(std::int32_t frame) const;
  [[nodiscard]] bool rests() const {
    return moving_->is_resting() && (still_ == nullptr || still_->is_resting());
  }
  [[nodiscard]] Status can_leave(std::int32_t frame) const;
  void expose();
  void end_exposure();

  ShootSpec<Real> spec_;
  std::int32_t frames_;
  Playhead<Real>* moving_;
  Playhead<Real>* still_;
  ShootPhase phase_ = ShootPhase::idle;
  bool only_looks_ = false;
  bool camera_ = false;
  bool is_exposed_ = false;  ///< the shutter has closed, and the rig runs out
  bool goes_on_ = false;     ///< a trigger came meanwhile
  std::int32_t frame_ = 0;
  std::int64_t ticks_left_ = 0;  ///< of settling or of the camera's signal
  std::int64_t exposures_ = 0;
};

/// The phase in words for people: "waiting".
const char* name_of(ShootPhase phase);

extern template class FrameShoot<double>;
extern template class FrameShoot<float>;

}  // namespace inbetween
