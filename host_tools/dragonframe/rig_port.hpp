// What a host program asks of a rig, what the rig answers, and what it tells by itself: plain data, the same
// for every protocol. Motors are numbered from 1, as hosts number them; positions are in steps. Nothing here
// moves anything: who owns the rig takes the orders and holds its limits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <variant>
#include <vector>

namespace inbetween::dragonframe {

class UploadedMove;

inline constexpr std::size_t max_motors = 32;
/// Bit 0 is motor 1.
using MotorMask = std::uint32_t;
using MotorPositions = std::array<std::int32_t, max_motors>;

[[nodiscard]] constexpr MotorMask mask_of(std::uint8_t motor) {
  return MotorMask{1} << (motor - 1U);
}

/// The answer to an order. All but `ok` mean that nothing was done.
enum class RigAnswer : std::uint8_t {
  ok,
  moving,           ///< not while something moves
  unsupported,      ///< the rig has no such thing
  range,            ///< a motor, a frame or a number outside of what there is
  general,          ///< not possible now
  not_in_position,  ///< not from where the rig stands
  preroll,          ///< the way into the move would break a limit
  postroll,         ///< the way out of it would
  soft_upper,
  soft_lower,
  hard_upper,
  hard_lower,
};

/// What the host has said about a motor. The limits of the rig's own file hold whatever stands here.
struct MotorSettings {
  bool is_enabled = false;
  bool has_blur = false;                   ///< it moves while a picture is exposed
  bool is_live = false;                    ///< moved by hand during a move, which leaves it alone
  bool drives_next = false;                ///< the motor behind it mirrors it
  bool drives_next_reversed = false;       ///< and turns the other way
  std::uint32_t max_velocity = 5000;       ///< steps/s
  std::uint32_t max_acceleration = 20000;  ///< steps/s^2
  std::optional<std::int32_t> lower{};
  std::optional<std::int32_t> upper{};
  std::uint8_t hardware_set = 0;  ///< of limit switches; 0: none
  bool hardware_swapped = false;

  bool operator==(const MotorSettings&) const = default;
};

/// Settings; the rig refuses with `range` what it cannot keep.
struct SetMotor {
  std::uint8_t motor = 0;
  MotorSettings settings;
  bool operator==(const SetMotor&) const = default;
};

/// Where the motor stands is called `position` from now on; it does not move.
struct PlaceMotor {
  std::uint8_t motor = 0;
  std::int32_t position = 0;
  bool operator==(const PlaceMotor&) const = default;
};

/// From any motion to rest at `target`.
struct MoveMotor {
  std::uint8_t motor = 0;
  std::int32_t target = 0;
  bool operator==(const MoveMotor&) const = default;
};

/// Towards `destination` until StopMotor, which comes when the host is no longer heard. Repeated while it
/// holds.
struct JogMotor {
  std::uint8_t motor = 0;
  std::uint16_t speed = 0;  ///< in 1/10000 of velocity and acceleration
  std::int32_t destination = 0;
  bool operator==(const JogMotor&) const = default;
};

struct StopMotor {
  std::uint8_t motor = 0;
  bool operator==(const StopMotor&) const = default;
};

/// A controlled stop of everything, on the path where there is one. It drops what was prepared.
struct StopAll {
  bool harder = false;  ///< a second one, soon behind the first
  bool operator==(const StopAll&) const = default;
};

/// The upload is whole. The rig may prove it; it stays as it is until the next TakeMove or ForgetHost.
struct TakeMove {
  const UploadedMove* move = nullptr;
  MotorMask motors = 0;  ///< that have positions
  bool operator==(const TakeMove&) const = default;
};

/// Each motor by itself to its position at the frame.
struct GoToFrame {
  std::int32_t frame = 0;
  MotorMask motors = 0;
  bool operator==(const GoToFrame&) const = default;
};

/// All together along the move to a frame.
struct JogAll {
  std::uint32_t frames_per_1000_s = 0;
  std::int32_t frame = 0;
  MotorMask motors = 0;
  bool operator==(const JogAll&) const = default;
};

enum class CameraKind : std::uint8_t { none, video, stills };

/// Go to the first frame, then to where the pre-roll begins, say InPlace, and wait for Go. Frames are played
/// from `start` in the direction of `end`, which is played too: time runs to one frame behind it.
struct PrepareRun {
  std::uint32_t frames_per_1000_s = 0;
  std::int32_t start = 0;
  std::int32_t end = 0;
  std::uint32_t preroll_ms = 0;   ///< constant acceleration from rest
  std::uint32_t postroll_ms = 0;  ///< 0 where it comes round again
  bool is_loop = false;
  bool is_ping_pong = false;
  CameraKind camera = CameraKind::none;
  std::uint16_t open_deg = 0;  ///< of a stills camera, 360 being a frame
  std::uint16_t close_deg = 0;
  MotorMask motors = 0;
  MotorPositions preroll{};   ///< where each begins
  MotorPositions postroll{};  ///< and ends
  bool operator==(const PrepareRun&) const = default;
};

/// A time in which a velocity goes straight from one value to another.
struct ShotPiece {
  double seconds = 0;
  double from = 0;  ///< steps/s
  double to = 0;
  bool operator==(const ShotPiece&) const = default;
};

struct ShotMotor {
  std::uint8_t motor = 0;
  std::int32_t start = 0;
  std::vector<ShotPiece> pieces;  ///< from Go on; of all motors as long together
  bool operator==(const ShotMotor&) const = default;
};

/// Go to the start, say InPlace, and wait for Go: one exposure in motion. The motors of `resting` go to
/// `rest` and stay. The camera's meter is on from Go until the shutter closes.
struct PrepareShot {
  std::vector<ShotMotor> motors{};
  double open_s = 0;  ///< of the shutter, behind Go
  double close_s = 0;
  MotorMask resting = 0;
  MotorPositions rest{};
  bool operator==(const PrepareShot&) const = default;
};

/// Begin what was prepared. Another motion of a motor that is not live, and a stop, have dropped it.
struct Go {
  bool operator==(const Go&) const = default;
};

/// The move ends when it next reaches an end.
struct StopLoop {
  bool operator==(const StopLoop&) const = default;
};

struct SetOutputs {
  std::uint32_t bits = 0;
  bool operator==(const SetOutputs&) const = default;
};

struct SetCamera {
  bool shutter = false;
  bool meter = false;
  bool operator==(const SetCamera&) const = default;
};

/// Another host, or none: settings, the move and what was prepared are gone. It cannot be refused.
struct ForgetHost {
  bool operator==(const ForgetHost&) const = default;
};

using RigOrder =
    std::variant<SetMotor, PlaceMotor, MoveMotor, JogMotor, StopMotor, StopAll, TakeMove, GoToFrame, JogAll,
                 PrepareRun, PrepareShot, Go, StopLoop, SetOutputs, SetCamera, ForgetHost>;

/// Takes an order, and answers at once: hosts wait for it. What is answered `ok` will be done or end in an
/// event.
using RigPort = std::function<RigAnswer(const RigOrder&)>;

/// The rig as it is now.
struct RigState {
  MotorMask moving = 0;
  MotorPositions positions{};
  std::int32_t move_time = 0;  ///< in 1/1000 frame
  std::uint32_t inputs = 0;    ///< debounced
};

/// A new frame of the move: at its beginning in playback, when it is crossed in JogAll, and at rest on one.
struct FrameReached {
  std::int32_t frame = 0;
};
/// JogAll is where it was to go; the run that is prepared goes on to its pre-roll.
struct Approached {};
/// The rig waits for Go.
struct InPlace {};
/// The last frame is over, or the exposure; the rig may still be coming to rest.
struct MoveEnded {};
/// Nothing moves, and nothing will without an order.
struct AtRest {};
enum class HardStopReason : std::uint8_t { general = 0, upper = 1, lower = 2, exception = 100 };
/// The rig stopped by itself.
struct HardStop {
  HardStopReason reason = HardStopReason::general;
  std::uint8_t motor = 0;  ///< of a limit; 0: none
};
/// Somebody pressed the start switch.
struct StartSwitch {};

using RigEvent = std::variant<FrameReached, Approached, InPlace, MoveEnded, AtRest, HardStop, StartSwitch>;

}  // namespace inbetween::dragonframe
