// The checks of a move against its rig, before it is played, or shot frame by frame (shoot_checks.cpp).
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "host_tools/motions/shooting.hpp"
#include "host_tools/motions/staged_move.hpp"
#include "host_tools/motions/transit.hpp"
#include "host_tools/plan/plan.hpp"
#include "inbetween/play/playhead.hpp"

namespace inbetween {

/// The move of a plan, ready to be played at up to `top_rate` times the drawn speed. Throws LimitError at the
/// place of what is wrong: the move leaves the limits of the rig (check.hpp) or would at that rate, a
/// setpoint of one of its ticks leaves the positions, it cannot be repeated. The plan has a rig.
std::unique_ptr<StagedMove> checked_move(const Plan& plan, double top_rate, Repeat repeat);

/// The axes that do not stand where the rig is to start, within start_tolerance (MotionLoop::begin), and
/// where they are to be. `actual` is a position for every axis of the rig; `start` is the beginning of the
/// time line unless said otherwise; `as_arguments` are those of SessionOptions. Throws InputError at one that
/// stands outside its limits.
std::vector<GoTarget> away_from_start(const Plan& plan, std::span<const double> actual,
                                      const std::optional<FrameTime>& start = {},
                                      const std::string& as_arguments = "");

/// Throws InputError where the axis has to go to the start of the move and nobody can agree to it.
void refuse_unagreed_transit(const Plan& plan, std::size_t axis, bool can_be_agreed);

/// The move of a plan, ready to be shot. It is held to what really moves, never to what it would take to play
/// it: every position within the limits of the rig; travels between frames, and exposures, no faster than
/// `top_rate` times drawn and than every limit holds; rests where the motion steps, so that no travel passes
/// a step. Throws LimitError at the place of what is wrong: a position, a velocity or acceleration without
/// bound, an exposure that needs a higher rate or passes a step; InputError where a frame or an axis that is
/// named does not exist. The plan has a rig.
std::unique_ptr<StagedMove> checked_shoot(const Plan& plan, double top_rate, const ShootOptions& shoot);

}  // namespace inbetween
