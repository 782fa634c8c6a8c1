// The drives of a rig file under the motion loop.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tools/rig/bus_kind.hpp"
#include "host_tools/rig/counters.hpp"
#include "host_tools/rig/rig_hardware.hpp"
#include "host_tools/rig/step_drives.hpp"
#include "host_tools/rig_model/rig_motors.hpp"

namespace inbetween {

/// Throws InputError at the place of an axis that falls without power, or does not say what it does then. Not
/// for a simulated rig, which nothing pulls down.
void refuse_falling_axes(const RigFile& rig);

/// A DrivePort for every axis of a rig, over those of its motors: through its gears (MotorPort) where it has
/// some.
class RigDrives {
 public:
  /// Opens the buses and chips of the rig, which last longer. Throws InputError at the place of what is not
  /// there, of a bus that would be too full, or of a drive that the hardware does not have.
  RigDrives(const RigFile& rig, RigHardware& hardware);
  RigDrives(const RigDrives&) = delete;
  RigDrives& operator=(const RigDrives&) = delete;

  void read(std::span<DriveState> states, std::int64_t now_ns);
  void write(std::span<const Setpoint> setpoints, std::int64_t now_ns);
  void enable();
  void disable();
  void quick_stop();
  /// MotorPort::plan_motor.
  void plan_motor(std::size_t axis, const Setpoint& told, const Setpoint& motor);

  /// Axis `axis` of the rig stands at `position`, whatever its drive says. Only before the drives are
  /// switched on, or while nothing is sent to them. Throws InputError at an axis whose drive cannot count so
  /// far.
  void place(std::size_t axis, double position);
  /// For each motor of the axis the position that its drive counts, in the unit of the motor, where the motor
  /// is at 0. Empty where one of them cannot tell that, or has not told its place since it was placed.
  [[nodiscard]] std::vector<double> zeros(std::size_t axis) const;
  /// The same is true now as in an earlier program, which had as many motors. Only before the drives are
  /// switched on.
  void set_zeros(std::size_t axis, std::span<const double> zeros);
  /// The homing that the drive of an axis does by itself, for the loop's thread; null where it takes targets.
  [[nodiscard]] can::Cia402Homing* homing(std::size_t axis) const {
    return motors_.of[axis].drives->homing(motors_.of[axis].number);
  }
  /// Steps were lost, so that nobody knows where the axis is.
  [[nodiscard]] bool has_lost_position(std::size_t axis) const;
  /// The position that an axis at `position` would be at with its motors where they are, if it had been
  /// approached: what is true in the next program, which knows nothing of the side on which the gear lies.
  [[nodiscard]] double as_approached(std::size_t axis, double position) const;
  /// No motor still crosses the play of its gear.
  [[nodiscard]] bool is_resting() const;
  /// Null where the rig has no stepper.
  [[nodiscard]] const StepDrives* steps() const { return steps_; }

  /// Says the first thing that is wrong with a drive and what to do; "" if nothing is. Not for the loop's
  /// thread.
  [[nodiscard]] std::string trouble() const;
  /// Once disable() was over: which drive may have power, or will report that this program is gone, and what
  /// to do; "" for none.
  [[nodiscard]] std::string left_on() const;
  /// AxisDrives::notes.
  [[nodiscard]] std::vector<std::string> notes() const;
  /// The counters of the buses, the drives on them and the chips that steps go to. Once no tick follows.
  [[nodiscard]] Counters counts() const;

 private:
  /// Some motors of the rig, and what passes between them and their drives.
  struct Part {
    std::vector<std::size_t> axes;
    std::unique_ptr<AxisDrives> drives;
    std::vector<DriveState> states = std::vector<DriveState>(axes.size());
    std::vector<Setpoint> setpoints = std::vector<Setpoint>(axes.size());
  };
  /// The drives that a motor of the rig belongs to, and its number among them.
  struct OfPart {
    AxisDrives* drives = nullptr;
    std::size_t number = 0;
  };
  /// A DrivePort for every motor.
  struct MotorDrives {
    void read(std::span<DriveState> states, std::int64_t now_ns);
    void write(std::span<const Setpoint> setpoints, std::int64_t now_ns);
    void enable();
    void disable();
    void quick_stop();
    void stop_one(std::size_t motor, OwnStop how) { of[motor].drives->stop_one(of[motor].number, how); }

    std::vector<Part> parts;
    std::vector<OfPart> of;  ///< for each motor
  };
  void add(std::span<const std::size_t> axes, std::unique_ptr<AxisDrives> drives);
  [[nodiscard]] std::string first_of(std::string (AxisDrives::*words)() const) const;
  [[nodiscard]] std::string skew_trouble() const;

  RigHardware& hardware_;
  RigMotors rig_;
  MotorDrives motors_;
  std::vector<DriveState> states_;
  std::vector<Setpoint> setpoints_;
  std::optional<MotorPort<MotorDrives>> axes_;  ///< where an axis has a gear
  const StepDrives* steps_ = nullptr;
};

}  // namespace inbetween
