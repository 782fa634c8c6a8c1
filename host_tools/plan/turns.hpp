// A periodic move in several turns, as one move: its seams are inside it.
#pragma once

#include <cstdint>
#include <string>

#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// Whether every track runs through its seam at a speed.
bool is_periodic(const MoveFile& move);

/// `turns` turns of a periodic move, planned as one turn: the keys and the control values that are played
/// come again and again, each turn further by the lap, and frame N of one is frame 0 of the next. The curve
/// is as its locked keys, holds and touches made it, so it has no requests left. Cues pulse on the frames of
/// every turn but its last, which is the first of the next. Every turn is the same motion, because a periodic
/// spline through repeated keys repeats.
///
/// Throws InputError where a track is not periodic, where a cue lists frame N, or where the turns have more
/// than max_frames frames.
MoveFile turns_of(const Plan& plan, std::int32_t turns);

/// How many turns fit, at least one, and what leaves no room for more: "the limits of \"table\", 0..3600
/// deg".
struct FittingTurns {
  std::int32_t turns = 1;
  std::string border;
};

/// As many turns as the position limits of the rig leave, up to max_frames frames, max_keys keys in a track
/// and as many control values as the core can count. The plan has a rig and is of one turn.
FittingTurns fitting_turns(const Plan& plan);

/// Whether every turn of a periodic move comes back to where it began, so that it can go round and round.
bool comes_back(const MoveFile& move);

/// The turns of a periodic move that a rig plays, all of them one move.
struct PlayedTurns {
  std::int32_t frames = 1;  ///< of a turn
  std::int32_t turns = 1;
  /// The turn in the middle is played again and again, and those around it are there for what begins in it
  /// and is not over at its end: a stop, a change of the rate, a motion to a frame.
  bool goes_round = false;

  /// A turn of frames in the middle.
  [[nodiscard]] WholeFrames again() const {
    const std::int32_t first = (turns - 1) * frames / 2;
    return {first, first + frames};
  }
};

/// For a move that goes round and round: at least half a minute around the middle, as far as a move has room.
/// Throws InputError where not even two turns are a move.
PlayedTurns turns_to_go_round(const Plan& plan);

}  // namespace inbetween
