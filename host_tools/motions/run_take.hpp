// A run as a take: kept, and played again.
#pragma once

#include <memory>

#include "host_tools/motions/run.hpp"
#include "host_tools/motions/staged_move.hpp"

namespace inbetween {

/// Null where the run is no take, or cannot be kept, which a line on standard error says.
std::unique_ptr<TakeRecorder> begun_take(const StagedMove& staged, const SessionOptions& rig,
                                         const RunOptions& options);

/// Throws InputError where a take is no way of the playhead of this move: each of its places is held to the
/// stop bounds that were proven for this run. The playhead rests where the move begins.
void refuse_to_follow(const FollowedTake& take, const StagedMove& staged);

}  // namespace inbetween
