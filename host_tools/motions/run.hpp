// Streams a plan to a rig, a position of every axis per tick.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "host_tools/files/fault_script.hpp"
#include "host_tools/loop/loop_runner.hpp"
#include "host_tools/motions/run_report.hpp"
#include "host_tools/motions/shooting.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/play/playhead.hpp"

namespace inbetween {

struct RunOptions {
  /// On a virtual clock, as fast as it can be computed.
  bool fast = false;
  Repeat repeat = Repeat::none;
  /// A real rig: without the rights of a real-time program, at a tenth of the drawn speed at most.
  bool allow_jitter = false;
  /// Up to how many times the drawn speed the override goes.
  double top_rate = 1;
  /// The move is shot frame by frame instead of played.
  std::optional<ShootOptions> shoot = {};
  /// Where axes stand before anything moves, by name; the others stand where the move starts.
  std::map<std::string, double> standing = {};
  /// What goes wrong with simulated drives; of the same rig.
  FaultScript faults = {};
  /// Asked before the rig goes slowly from where it stands to where the move starts. Without it, it does not.
  std::function<bool(const std::string& question)> confirm = {};
  /// A line a tick goes there (run_record.hpp).
  std::optional<std::string> record = {};
  /// Where the positions of axes are kept that no drive knows (position_file.hpp). None: on a rig its usual
  /// place, in a simulation nowhere.
  std::optional<std::string> positions = {};
  /// A line a pulse on an output goes there (cue_log.hpp).
  std::optional<std::string> cue_log = {};
  LoopAudience audience = {};
};

/// Plays the plan on simulated axes at the rig's rate: tick k at k / rate_hz seconds from the beginning
/// of the move, or of its pre-roll, to the first tick at or after the end, and one more in which the axes
/// arrive. Axes in no track stay where they are. It is the motion loop of the core that drives hardware as
/// well. A tick that comes a period late or more delays those after it: there is no burst.
///
/// Before the first tick the plan is checked (check.hpp), and every setpoint of the move is held against the
/// rig's position limits. Where the rig does not stand at the start of the move it goes there first
/// (approach.hpp), if `confirm` agrees. With `shoot` the move is shot frame by frame; on a keyboard (`keys`)
/// somebody asks for each frame, without one the camera does.
///
/// Throws LimitError at the place of what is wrong, InputError where the rig stands elsewhere and nobody can
/// confirm. The plan has a rig.
RunReport run_simulated(const Plan& plan, const RunOptions& options);

/// The same on the drives of the rig, in a real-time thread, where they stand being asked of the drives. A
/// late tick is made up for while no axis would go beyond its velocity, otherwise it is a controlled stop.
/// Throws InputError where a bus or a right is missing, with what to do.
RunReport run_on_rig(const Plan& plan, const RunOptions& options);

}  // namespace inbetween
