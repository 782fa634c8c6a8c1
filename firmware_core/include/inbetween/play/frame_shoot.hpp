#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

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
  standing,    ///< rests on a frame; a trigger shoots it, or goes on if it was shot
  exposing,    ///< the camera has its signal, or the rig runs up to its exposure or out of it
  waiting,     ///< the frame is shot; a trigger goes on to the next
  done,        ///< no frame is left behind this one, and a trigger has acknowledged it
};
inline constexpr int shoot_phases = 7;

/// The part of a frame during which the shutter is open, in frames from the frame on: 0..0.5 is a shutter of
/// 180 degrees that opens on the frame, -0.25..0.25 one that is centred on it.
struct Shutter {
  double open = 0;
  double close = 0.5;
};

struct ShootSpec {
  std::int64_t settle_ticks = 0;
  std::int64_t exposure_ticks = 1;  ///< length of the camera's signal if the rig rests meanwhile; at least 1
  std::optional<Shutter> shutter;   ///< the rig moves while it is open
  double exposure_s = 0;            ///< with a shutter: how long it is open
};

/// The frames of a shoot. Refers to the caller's memory.
struct ShootFrames {
  std::int32_t last = 0;   ///< N of the move: each of the frames 0..N can be looked at
  std::int32_t first = 0;  ///< that is to be shot
  /// From `first` on an entry for each frame that is to be shot: how often it was.
  std::span<std::int32_t> shots;
  /// In ascending order the places at which every travel rests, because the motion steps there.
  std::span<const FrameTime> rests = {};
};

/// Decides what the playheads of a rig do, frame by frame, and when the camera has its signal. It goes to a
/// frame, settles, and stands there until a trigger asks for the exposure; then it signals the camera, and
/// waits for the trigger that asks for the next frame. Nothing is exposed that no trigger has asked for, and
/// no frame a second time but by shoot_again. Nothing moves while the camera has its signal, unless a shutter
/// is given.
///
/// If there is a shutter, the axes of `moving` pass each exposure at a constant rate (Playhead::expose), and
/// the axes of `still` rest on the frame meanwhile. Exposures of frames 0 and N may reach beyond the ends of
/// the time line, where nothing moves.
///
/// Refers to the playheads; the motion loop ticks them. O(1) a tick, no allocation.
class FrameShoot {
 public:
  /// `still` may be null.
  FrameShoot(const ShootSpec& spec, const ShootFrames& frames, Playhead& moving, Playhead* still)
      : spec_(spec), frames_(frames), frame_(frames.first), moving_(&moving), still_(still) {}

  /// Checks that every frame that is to be shot can be exposed as wanted. Errors, with frame: those of
  /// Playhead::travel_of; no_solution (the motion steps while the rig exposes it). O(N times the cells that a
  /// run-up passes).
  [[nodiscard]] Status check() const;
  /// Goes to a frame and shoots it. The playheads rest. Errors: those of look_at; out_of_range (the frame
  /// is not to be shot), those of Playhead::go_to_run_up.
  Status shoot(std::int32_t frame);
  /// Goes to a frame and stands there. Errors: out_of_range (no such frame), wrong_state (the rig moves or
  /// the camera exposes).
  Status look_at(std::int32_t frame);
  /// Takes a trigger from a key or from the line of a camera: shoots the frame that it stands on, or where
  /// that was shot the next that was not; is done where there is none. A trigger during the run-out of an
  /// exposure is kept until the rig rests. Errors: wrong_state if nothing waits for it. O(N).
  Status trigger();
  /// Shoots the frame that it stands on, which may have been shot before. Errors: those of shoot;
  /// wrong_state if it stands on none.
  Status shoot_again();
  /// Tells that the rig was stopped: the camera loses its signal, and the frame is not shot.
  void interrupt();
  /// The caller calls this after every tick of the motion loop, with the event of `moving`.
  void tick(PlayheadEvent event);

  /// The camera's signal.
  [[nodiscard]] bool camera() const { return camera_; }
  [[nodiscard]] ShootPhase phase() const { return phase_; }
  /// The frame that it goes to, stands on or shoots.
  [[nodiscard]] std::int32_t frame() const { return frame_; }
  [[nodiscard]] bool is_due(std::int32_t frame) const {
    return frame >= frames_.first && frame - frames_.first < static_cast<std::int64_t>(frames_.shots.size());
  }
  /// How often a frame was shot.
  [[nodiscard]] std::int32_t shots(std::int32_t frame) const { return is_due(frame) ? shots_of(frame) : 0; }
  /// The first frame behind this one that is to be shot and was not. O(N).
  [[nodiscard]] std::optional<std::int32_t> next_frame() const;
  /// The number of exposures; a frame that is shot twice counts twice.
  [[nodiscard]] std::int64_t exposures() const { return exposures_; }

 private:
  [[nodiscard]] std::int32_t& shots_of(std::int32_t frame) const {
    return frames_.shots[static_cast<std::size_t>(frame - frames_.first)];
  }
  [[nodiscard]] Exposure exposure_of(std::int32_t frame) const;
  [[nodiscard]] bool rests() const {
    return moving_->is_resting() && (still_ == nullptr || still_->is_resting());
  }
  [[nodiscard]] Status can_leave(std::int32_t frame) const;
  [[nodiscard]] std::optional<FrameTime> rest_between(const FrameTime& from, const FrameTime& to) const;
  Status travel();
  Status travel(Playhead& playhead, const FrameTime& to, bool is_run_up);
  [[nodiscard]] bool has_arrived() const;
  Status go_on();
  void expose();
  void end_exposure();

  ShootSpec spec_;
  ShootFrames frames_;
  ShootPhase phase_ = ShootPhase::idle;
  bool only_looks_ = false;
  bool camera_ = false;
  bool is_exposed_ = false;  ///< the shutter has closed, and the rig runs out
  bool goes_on_ = false;     ///< a trigger came meanwhile
  std::int32_t frame_;
  FrameTime stand_;              ///< where `moving` is to rest: on the frame, or where its run-up starts
  std::int64_t ticks_left_ = 0;  ///< of settling or of the camera's signal
  std::int64_t exposures_ = 0;
  Playhead* moving_;
  Playhead* still_;
};

/// The phase in words for people: "waiting".
const char* name_of(ShootPhase phase);

}  // namespace inbetween
