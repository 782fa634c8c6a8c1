// Why a move breaks the limits of its rig, in words: each refusal has its place and a remedy.
#pragma once

#include <cstddef>

#include "host_tools/check/check.hpp"
#include "host_tools/check/planned_stops.hpp"

namespace inbetween {

/// Adds what is wrong with the motion of an axis of a track, which the report has.
void refuse_axis(const Plan& plan, std::size_t axis, CheckReport& report);
/// Adds that the move starts or ends moving where its roll has no room.
void refuse_roll(const Plan& plan, const RollObstacle& obstacle, CheckReport& report);
/// Adds that the rig could not be stopped, unless the motion itself breaks a limit: that is said already.
void refuse_stop(const Plan& plan, const PlannedStops& planned, CheckReport& report);
/// Adds what is wrong with a motor.
void refuse_motor(const Plan& plan, const CheckedMotor& motor, CheckReport& report);

}  // namespace inbetween
