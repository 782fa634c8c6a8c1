// The checks of a move against its rig, before it is shot frame by frame.
#pragma once

#include <memory>

#include "host_tools/motions/shooting.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/plan/plan.hpp"

namespace inbetween {

/// The move of a plan, ready to be shot. It is held to what really moves, never to what it would take to play
/// it: every position within the limits of the rig; travels between frames, and exposures, no faster than
/// `top_rate` times drawn and than every limit holds; rests where the motion steps, so that no travel passes
/// a step. Throws LimitError at the place of what is wrong: a position, a velocity or acceleration without
/// bound, an exposure that needs a higher rate or passes a step; InputError where a frame or an axis that is
/// named does not exist. The plan has a rig.
std::unique_ptr<StagedMove> checked_shoot(const Plan& plan, double top_rate, const ShootOptions& shoot);

}  // namespace inbetween
