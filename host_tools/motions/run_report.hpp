// How a run went.
#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/loop/wake_latency.hpp"
#include "host_tools/motions/shoot_count.hpp"
#include "host_tools/rig/counters.hpp"
#include "host_tools/takes/take_recorder.hpp"
#include "host_tools/text/loop_log.hpp"
#include "inbetween/timing/frame_time.hpp"

namespace inbetween {

struct RunAxis {
  std::string name;
  std::string unit;
  double last_commanded = 0;
  double last_actual = 0;
  double following_error_peak = 0;
  bool is_known = true;      ///< its drive has told where it is
  bool is_commanded = true;  ///< it was told where to be
};

/// One of several takes.
struct RunTake {
  std::int32_t number = 0;
  bool is_whole = false;  ///< played to its last frame
  std::optional<std::string> file = {};
  std::optional<LoopLogEnd> record = {};
  std::optional<KeptTake> kept = {};
};

/// A name with a %n, which is the number of a take: "takes/%n.csv" is "takes/3.csv".
std::string numbered(std::string name, std::int32_t take);

enum class Ending { finished, stopped, fault };

struct RunReport {
  Ending ending = Ending::finished;
  std::string reason;
  std::int64_t ticks = 0;
  std::int64_t late_ticks = 0;                 ///< woken a whole period or more after their deadline
  std::optional<WholeFrames> played = {};      ///< the frames of --frames
  std::optional<std::int64_t> exposures = {};  ///< of a move that is shot frame by frame
  std::optional<ShootCount> shoot = {};        ///< the same, in frames
  std::vector<RunAxis> axes;                   ///< every axis of the rig
  WakeLatency wake_latency;                    ///< all 0 on a virtual clock
  std::vector<RunTake> takes = {};
  std::optional<LoopLogEnd> record = {};
  std::optional<LoopLogEnd> steps = {};  ///< records are edges
  std::optional<LoopLogEnd> cue_log = {};
  std::optional<LoopLogEnd> shoot_log = {};
  std::optional<KeptTake> kept = {};  ///< where the run is a take
  Counters counts = {};
};

/// Version 1 of the format that docs/formats.md describes.
void write_run_json(const RunReport& report, std::FILE* file);

}  // namespace inbetween
