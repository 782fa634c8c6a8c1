// Streams a plan to a rig, a position of every axis per tick.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host_tools/loop/rig_session.hpp"
#include "host_tools/motions/run_report.hpp"
#include "host_tools/motions/shooting.hpp"
#include "host_tools/motions/transit.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/plan/turns.hpp"
#include "host_tools/takes/take_recorder.hpp"
#include "inbetween/play/playhead.hpp"

namespace inbetween {

/// What is kept of a run, beside what it plays.
struct TakeRequest {
  TakeKeeping keeping;
  std::vector<TakeFile> files = {};  ///< the move, the rig and what they name, as they were read
  std::string version = {};          ///< of the program
};

/// A take that is played again.
struct FollowedTake {
  std::string name;                        ///< "take 7"
  std::vector<PlayheadPlace> places = {};  ///< of its playhead, tick by tick, to where it rested first
};

struct RunOptions {
  Repeat repeat = Repeat::none;
  /// The plan is of turns of a periodic move, played to their end or until somebody leaves.
  std::optional<PlayedTurns> turns = {};
  /// Up to how many times the drawn speed the override goes. A tenth where jitter is allowed.
  double top_rate = 1;
  /// At how many times the drawn speed it begins; no more than the top rate.
  double rate = 1;
  /// The share of their limits that the axes may use on the way to the start: above 0, up to 1.
  double start_share = transit_share;
  /// Take after take, until somebody leaves: each begins when they ask for it. Not for a move that is shot.
  bool has_takes = false;
  /// The record of a take: %n is its number, and the first is the lowest without a file.
  std::optional<std::string> take_record = {};
  /// The move is shot frame by frame instead of played.
  std::optional<ShootOptions> shoot = {};
  /// The file that keeps positions which no drive knows (position_file.hpp). None: on a rig its usual
  /// place, in a simulation nowhere.
  std::optional<std::string> positions = {};
  /// A line a pulse on an output goes there (cue_log.hpp).
  std::optional<std::string> cue_log = {};
  /// The run is a take, or with has_takes each of its takes is one. Where it cannot be kept, one line on
  /// standard error says so, and the run goes on.
  std::optional<TakeRequest> take = {};
  /// Not with repeat, and not shot.
  std::optional<FollowedTake> follow = {};
};

/// Plays the plan on a rig at its rate, in a real-time thread or simulated: tick k at k / rate_hz seconds
/// from the beginning of the move, or of its pre-roll, to the first tick at or after the end, and one more in
/// which the axes arrive. Axes in no track stay where they are. Lateness (loop_runner.hpp) says what a late
/// tick is.
///
/// Before anything is opened the plan is checked (check.hpp), and every setpoint of the move is held against
/// the rig's position limits. Where the rig does not stand at the start of the move it goes there first
/// (transit.hpp), if the audience confirms it; simulated axes stand there unless something else is said or
/// kept. With `shoot` the move is shot frame by frame; on a keyboard somebody asks for each frame, without
/// one the camera does.
///
/// Throws LimitError at the place of what is wrong, InputError where the rig stands elsewhere and nobody can
/// confirm, or a take is no way of a playhead of this plan, and what RigSession and RigReference throw. The
/// plan has a rig.
RunReport run(const Plan& plan, const SessionOptions& rig, const RunOptions& options = {});

}  // namespace inbetween
