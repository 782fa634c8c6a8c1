// The state of a run at a tick, for people who look at it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/loop/supervisor.hpp"
#include "inbetween/play/frame_shoot.hpp"

namespace inbetween {

/// The state of a move that is shot frame by frame.
struct ShootSnapshot {
  ShootPhase phase = ShootPhase::idle;
  std::int32_t frame = 0;
  std::int32_t frames = 0;
  std::int64_t exposures = 0;             ///< with those of a shoot that it goes on with
  bool is_shot = false;                   ///< the frame
  bool is_due = true;                     ///< it is one of those that are shot
  std::optional<std::int32_t> next = {};  ///< the next that is to be shot
  bool camera = false;
};

/// The state of an axis that is moved by hand. The words live longer than this.
struct JogSnapshot {
  const char* axis = "";
  const char* unit = "";
  double position = 0;
  double velocity = 0;
  double stop_distance = 0;  ///< how much further a stop goes
  double min = 0, max = 0;   ///< soft limits; none where it is not referenced
  int size = 0;              ///< of a step, 1 to 5
  double increment = 0;      ///< of that size
  bool is_count = false;     ///< a count of its drive
  double reach = 0;          ///< of a key that is held
  bool by_device = false;    ///< of a device, and not of the terminal
  bool is_alone = false;     ///< there is no other axis to choose
  bool is_referenced = true;
};

/// The turn of a move that is played again and again, or in several turns.
struct TurnSnapshot {
  std::int64_t turn = 1;
  std::int32_t of = 0;  ///< 0: until it is stopped
};

/// A number that somebody types, of a frame or a key to go to.
struct EntrySnapshot {
  bool is_key = false;
  std::optional<std::int32_t> number = {};  ///< nothing before its first digit
};

/// Where an axis of the rig was told to be, and where it is.
struct AxisPlace {
  double commanded = 0;
  double actual = 0;
  double following_error = 0;  ///< 0 while no setpoints are sent
  bool is_known = false;       ///< where it is: its drive has been on, and has told
  bool is_commanded = false;   ///< it was told where to be
};

/// Plain data, made in the loop without allocation. The words are literals.
struct RunSnapshot {
  SupervisorState state = SupervisorState::disarmed;
  const char* doing = "";  ///< what runs, where it is no drawn move: "going to the start"
  bool is_resting = false;
  double frame = 0;
  std::int32_t frames = 0;  ///< N of the move
  /// The frames that are played, all where nothing is said; before them is the pre-roll, behind the
  /// post-roll.
  std::optional<WholeFrames> part = {};
  std::optional<TurnSnapshot> turn = {};    ///< `frame` is one of this turn
  std::optional<double> seconds_left = {};  ///< while it plays to an end
  double rate = 0;
  double override_rate = 1;
  bool backward = false;
  double share = 0;        ///< of the time line, or of the frames, 0..1
  const char* words = "";  ///< about the last key
  const char* keys = "";   ///< those that work now, where what runs says which
  std::optional<EntrySnapshot> entry = {};
  std::optional<ShootSnapshot> shoot = {};
  std::optional<JogSnapshot> jog = {};
  std::array<AxisPlace, max_rig_axes> axes = {};  ///< of the rig, in its order
  std::size_t axis_count = 0;

  [[nodiscard]] WholeFrames played() const { return part.value_or(WholeFrames{0, frames}); }
};

/// What happens: "pre-roll", "playing", "stopped: press a".
std::string phase_of(const RunSnapshot& snapshot);
/// That, with frame and rate, or axis and position: "playing  frame 12.2 of 48  rate +1.00 of 1.00".
std::string state_line(const RunSnapshot& snapshot);
/// What to press next, or why the last key did nothing.
std::string hint_line(const RunSnapshot& snapshot);
/// One line: state, frame, rate, or axis and position, and what to press next or why the last key did
/// nothing.
std::string status_line(const RunSnapshot& snapshot);

}  // namespace inbetween
