// The motors of a rig: what its drives turn, behind the gears of its axes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host_tools/rig_model/rig_file.hpp"
#include "inbetween/limits/limits.hpp"
#include "inbetween/loop/motor_port.hpp"

namespace inbetween {

/// Whether an axis is something else than one motor that counts in its unit from its 0.
bool has_gear(const RigAxis& axis);

/// Names one of RigAxis::ganged: "NAME.2", the second motor of the axis.
std::string ganged_name(const RigAxis& axis, std::size_t ganged);

/// An axis as its motor: in the unit of the motor, with the range and the limits that the motor has. `offset`
/// is that of the motor, and its `axis` is not looked at.
RigAxis motor_of(const RigAxis& axis, const AxisMotor& motor);

/// The same rig with its motors in place of its axes, which is the rig that buses, chips and drives know.
/// Motor m is the first one of axis m; those of axes that have several come behind (ganged_name). Homes and
/// limit switches are of axes, and so is the geometry: the motors have none.
struct RigMotors {
  RigFile rig;
  std::vector<AxisMotor> of;    ///< for each axis of `rig`
  std::vector<AxisGear> gears;  ///< one for each axis of the rig, or none where no axis has one
};
/// Refers to the calibrations of `rig`, which its copies share.
RigMotors motors_of(const RigFile& rig);

/// Where the motor is while the axis is at a position that was approached; and back.
double motor_position(const RigAxis& axis, const AxisMotor& motor, double position);
double axis_position(const RigAxis& axis, const AxisMotor& motor, double position);

/// The limits within which the take-up of the backlash leaves the motors of an axis; of an axis with a
/// calibration.
AxisLimits limits_beside_take_up(const RigAxis& axis);

/// The axis with limits so low that its motors keep theirs wherever in its range it moves: for motions that
/// nobody has planned, such as a jog. The axis itself where it has no calibration.
RigAxis slow_enough_everywhere(const RigAxis& axis);

/// The size of a count of the drive in axis units: where a calibration has it change, the least in the range.
double count_of(const RigAxis& axis);

}  // namespace inbetween
