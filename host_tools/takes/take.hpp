// A take: a run that was kept, as plain data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "inbetween/loop/supervisor.hpp"
#include "inbetween/timing/frame_time.hpp"

namespace inbetween {

/// An axis of the rig, in its order.
struct TakeAxis {
  std::string name;
  std::string unit;
  /// Actual positions are kept as whole numbers of this, in the unit of the axis: a count of its drive where
  /// it has counts, and otherwise so small that half of it is no error that anybody measures.
  double resolution = 0;
  std::optional<std::size_t> move_axis = {};  ///< through the tracks; absent: in no track
};

/// What happened in a tick, in words: a change of state, a fault, a pulse, a key that was pressed.
struct TakeEvent {
  enum class Kind : std::uint8_t { state, fault, pulse, key };
  std::int64_t tick = 0;
  Kind kind = Kind::state;
  std::string text;
};

/// A file that the move or the rig was read from, with its text as it was then.
struct TakeFile {
  enum class Role : std::uint8_t { move, rig, other };  ///< other: a CSV file, a URDF file, a data sheet
  Role role = Role::other;
  std::string path;  ///< as the file that names it says, or as the command said
  std::string text;
  std::string hash;  ///< of the text
};

/// Of a take, what a list shows.
struct TakeInfo {
  std::int64_t number = 0;  ///< in its file, from 1
  std::string move_name, rig_name;
  std::string started_at;  ///< UTC, ISO 8601: "2026-11-29T12:20:05.125Z"
  std::string version;     ///< of the program
  std::string ending;      ///< in words; empty where the program ended before the take did
  bool is_simulated = false;
  bool is_whole = false;   ///< played from its first frame to its last
  bool is_marked = false;  ///< never forgotten to make room
  std::int32_t rate_hz = 0;
  FrameRate frame_rate = {};
  std::int32_t frames = 0;      ///< N of the move
  WholeFrames part = {};        ///< the frames that were to be played
  std::int32_t turns = 0;       ///< of a periodic move, planned as one; 0: it was no such
  bool is_repeated = false;     ///< over its end and its beginning, until somebody stopped it
  bool is_shot = false;         ///< frame by frame
  double top_rate = 1;          ///< up to which stops were proven
  std::int64_t ticks = 0;       ///< that are kept
  std::int64_t lost_ticks = 0;  ///< that found no room in the ring or on the disk
  std::int64_t bytes = 0;       ///< that it takes in the file
};

/// A tick: where the playhead was, and where the axes were.
struct TakeTick {
  std::int64_t number = 0;  ///< from 0 at the beginning of the take; a gap is lost ticks
  SupervisorState state = SupervisorState::disarmed;
  /// Where the move was on its time line, as the playhead had it, bit for bit: with the trajectory it is what
  /// was commanded. Nothing while no move is played.
  std::optional<FrameTime> time = {};
  double rate = 0, rate_change = 0;  ///< of the playhead there (Playhead::rate)
  bool shows_frame = false;          ///< a record of it has the frame, also where the move rests and waits
  std::int64_t turn = 0;             ///< of a move that goes round, by which the playhead was carried back
  std::vector<double> told = {};     ///< setpoint of every axis of the rig; empty: none was sent
  std::vector<double> actual = {};   ///< of every axis of the rig, in its unit

  friend bool operator==(const TakeTick&, const TakeTick&) = default;
};

struct Take : TakeInfo {
  std::vector<TakeFile> files;
  std::string trajectory;  ///< what was played (taken_motion.hpp)
  std::vector<TakeAxis> axes;
  std::vector<TakeTick> ticks_of_take;
  std::vector<TakeEvent> events;
};

}  // namespace inbetween
