// What is held against the rig before a move is played on it.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "host_tools/motions/shooting.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/play/playhead.hpp"

namespace inbetween {

/// The move of a plan, ready to be played at up to `top_rate` times the drawn speed, or with `shoot` to be
/// shot frame by frame. Throws LimitError at the place of what is wrong: the move leaves the limits of the
/// rig (check.hpp) or would at that rate, a setpoint of one of its ticks leaves the positions, it cannot be
/// repeated, or a frame cannot be exposed, as wanted; InputError where an axis that is to stand still is
/// none. The plan has a rig.
std::unique_ptr<StagedMove> checked_move(const Plan& plan, double top_rate, Repeat repeat,
                                         const std::optional<ShootOptions>& shoot);

/// The slow way (approach.hpp) from `actual`, a position for every axis of the rig, to where the move starts;
/// nothing where the rig stands there. Throws InputError where there is one and nobody can agree to it, or an
/// axis stands outside its limits.
std::optional<Plan> allowed_approach(const Plan& plan, std::span<const double> actual, bool can_be_agreed);

}  // namespace inbetween
