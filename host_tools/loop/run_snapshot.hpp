// The state of a run at a tick, for people who look at it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "inbetween/loop/supervisor.hpp"
#include "inbetween/play/frame_shoot.hpp"

namespace inbetween {

/// The state of a move that is shot frame by frame.
struct ShootSnapshot {
  ShootPhase phase = ShootPhase::idle;
  std::int32_t frame = 0;
  std::int32_t frames = 0;
  std::int64_t exposures = 0;
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
  double stop_way = 0;      ///< how much further a stop goes
  double min = 0, max = 0;  ///< soft limits; none where it is not referenced
  int size = 0;             ///< of a step, 1 to 5
  double increment = 0;     ///< of that size
  bool is_referenced = true;
};

/// Plain data, made in the loop without allocation. The words are literals.
struct RunSnapshot {
  SupervisorState state = SupervisorState::disarmed;
  bool is_resting = false;
  double frame = 0;
  double rate = 0;
  double override_rate = 1;
  bool backward = false;
  double share = 0;        ///< of the time line, or of the frames, 0..1
  const char* words = "";  ///< about the last key
  std::optional<ShootSnapshot> shoot = {};
  std::optional<JogSnapshot> jog = {};
};

/// One line: state, frame, rate, or axis and position, and what to press next or why the last key did
/// nothing.
std::string status_line(const RunSnapshot& snapshot);

}  // namespace inbetween
