// A periodic move in several turns, as one move: its seams are inside it.
#pragma once

#include <cstdint>

#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// Whether every track runs through its seam at a speed.
bool is_periodic(const MoveFile& move);

/// `turns` turns of a periodic move, planned as one turn: the keys and the control values that are played
/// come again and again, each turn further by the lap, and frame N of one is frame 0 of the next. The curve
/// is as its locked keys, holds and touches made it, so it has no wishes left. Cues pulse on the frames of
/// every turn but its last, which is the first of the next. Every turn is the same motion, because a periodic
/// spline through repeated keys repeats.
///
/// Throws InputError where a track is not periodic, where a cue lists frame N, or where the turns have more
/// than max_frames frames.
MoveFile turns_of(const Plan& plan, std::int32_t turns);

/// As many turns as the position limits of the rig leave, up to max_frames frames, max_keys keys in a track
/// and as many control values as the core can count; at least one. The plan has a rig and is of one turn.
std::int32_t max_turns_of(const Plan& plan);

}  // namespace inbetween
