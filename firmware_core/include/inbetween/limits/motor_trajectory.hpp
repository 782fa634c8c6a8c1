#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "inbetween/base/result.hpp"
#include "inbetween/limits/calibration.hpp"
#include "inbetween/limits/roll.hpp"
#include "inbetween/trajectory/trajectory.hpp"

/// The motor of an axis behind a calibration plays a trajectory of its own, so that what is proven of it is
/// proven as of any other.

namespace inbetween {

/// A moment at which the motion of a motor is not smooth, or may not be: where a piece of its axis ends, or
/// where the axis passes a mark.
struct MotorJoint {
  FrameTime time;
  std::int32_t key = -1;  ///< that is passed there
  std::uint32_t piece_before = 0, piece_after = 0;
  std::uint8_t curve_before = 0, curve_after = 0;  ///< pieces of the calibration
  std::uint8_t unbounded = 0;                      ///< UnboundedSide::order of the axis; 0: none
};

/// A motor that follows an axis of a move through a calibration.
struct CalibratedMotor {
  std::size_t axis = 0;  ///< counted through the tracks
  const Calibration* calibration = nullptr;
};

/// An axis whose motor is fitted.
struct MotorSource {
  const Trajectory* trajectory = nullptr;  ///< that the axis plays
  std::size_t axis = 0;                    ///< of the trajectory
  const Calibration* calibration = nullptr;
  double travel = 0;  ///< what the axis travels in the whole motion: FitTolerances::travel
};

/// The trajectory of one axis, the motor, in units of the motor and seconds: of what the calibration makes of
/// the axis (chain rule), within the tolerances of fit_trajectory of what plays. Its joints are as many as
/// the pieces of the axis and the passings of marks; they need not be kept. On the first frame, on the last
/// one and at rests it is where the calibration says, to the last bit. Errors: out_of_range (axis), capacity
/// (joints, and those of fit_trajectory), with what it needed when it gave up. Cost: about two samples a
/// piece.
Result<Trajectory> fit_motor(const MotorSource& source, std::span<MotorJoint> joints,
                             const TrajectoryMemory& memory);
/// The same on a roll of the axis.
Result<Trajectory> fit_motor(const RollAxis& roll, const Calibration& calibration,
                             std::span<MotorJoint> joints, const TrajectoryMemory& memory);

}  // namespace inbetween
