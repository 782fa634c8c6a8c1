// A move made of rows of positions, as a host uploads them, proven for its rig.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host_tools/dragonframe/rig_port.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// A row is a position of each axis at a frame. Between rows each axis goes on a curve with a continuous
/// acceleration (`timing = "frames"`, `kinetic = "curves"`, `spline = "smooth"`), from rest to rest.
struct MoveRows {
  std::vector<std::size_t> axes = {};     ///< of the rig
  std::vector<std::int32_t> frames = {};  ///< of the rows: ascending, the first 0
  std::vector<double> positions = {};     ///< row after row, in the units of the axes
  std::uint32_t frames_per_1000_s = 0;
};

/// What the rows are for.
enum class RowUse : std::uint8_t {
  play,    ///< at their own speed
  travel,  ///< to frames of it, slowly: how fast the rows are does not matter
};

/// Refers to nothing outside.
struct RowMove {
  std::unique_ptr<const Plan> plan;
  std::unique_ptr<StagedMove> staged;
  /// At so many times the drawn speed every axis goes as slowly as in a transit.
  double slow_rate = 1;
  std::int32_t frames = 0;
};

/// A move, or why there is none: what breaks which limit at which frame of the rows.
struct ProvenRows {
  std::unique_ptr<RowMove> move = {};
  dragonframe::RigAnswer answer = dragonframe::RigAnswer::ok;
  std::string why = {};
  double frame = 0;
};

/// Positions beyond a limit are soft_upper and soft_lower, of a negative scale the other way round; what else
/// does not fit is general. Takes 0.1 s for 2000 rows of 8 axes.
ProvenRows prove_rows(const RigFile& rig, const MoveRows& rows, RowUse use);

}  // namespace inbetween
