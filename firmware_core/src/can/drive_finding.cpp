#include "inbetween/can/drive_finding.hpp"

namespace inbetween::can {

DriveFindingWords words_of(DriveFinding finding) {
  using enum DriveReaction;
  switch (finding) {
    case DriveFinding::never_booted:
      return {.what = "no boot-up message came from the drive",
              .remedy = "look at its supply, node number and bitrate"};
    case DriveFinding::wrong_device:
      return {.what = "the device is not the drive that the rig has there",
              .remedy = "look at its node number"};
    case DriveFinding::no_cyclic_position:
      return {.what = "the drive does not offer cyclic synchronous position",
              .remedy = "use a drive with mode 8"};
    case DriveFinding::sync_of_another:
      return {.what = "the drive sends SYNC itself or listens to another one",
              .remedy = "set its object 1005 to 80h"};
    case DriveFinding::sdo_failed:
      return {.what = "the drive did not accept its set-up",
              .remedy = "look at the object and the reason it gave"};
    case DriveFinding::read_back_differs:
      return {.what = "the drive read back another value than was written",
              .remedy = "look whether it can have this value"};
    case DriveFinding::window_disabled:
      return {.what = "the drive does not watch its following error",
              .remedy = "set its window, object 6065"};
    case DriveFinding::watchdog_unset:
      return {.what = "the drive would run on if this program died",
              .remedy = "use a drive with a heartbeat consumer (1016) or a setpoint timeout (1400:5)"};
    case DriveFinding::first_heartbeat_missing:
      return {.what = "the first heartbeat of the drive never came", .remedy = "look at its object 1017"};
    case DriveFinding::not_operational:
      return {.what = "the drive did not begin to exchange process data",
              .remedy = "look at its display or errors"};
    case DriveFinding::fault_stays:
      return {.what = "the fault of the drive cannot be reset", .remedy = "remove its cause"};
    case DriveFinding::not_enabled:
      return {.what = "the drive did not switch on in time",
              .remedy = "look at its power stage, enable input and brake"};
    case DriveFinding::moved_while_enabling:
      return {.what = "the axis is not where its first setpoint is", .remedy = "look what moved it"};
    case DriveFinding::feedback_missing:
      return {.what = "the drive has stopped telling where it is",
              .remedy = "look at its supply and the bus",
              .reaction = controlled_stop};
    case DriveFinding::drive_fault:
      return {
          .what = "the drive is in fault", .remedy = "look at its error code", .reaction = controlled_stop};
    case DriveFinding::left_operation:
      return {.what = "the drive has switched itself off",
              .remedy = "look at its enable input and supply",
              .reaction = controlled_stop};
    case DriveFinding::wrong_mode:
      return {.what = "the drive is in another mode than cyclic synchronous position",
              .remedy = "look who changed it",
              .reaction = controlled_stop};
    case DriveFinding::target_ignored:
      return {.what = "the drive does not follow its target (statusword bit 12)",
              .remedy = "look at its limits and halt input",
              .reaction = controlled_stop};
    case DriveFinding::following_error:
      return {.what = "the axis is too far from its target",
              .remedy = "look for what holds it, or move slower",
              .reaction = controlled_stop_then_quick};
    case DriveFinding::internal_limit:
      return {.what = "the drive has reached a limit of its own (statusword bit 11)",
              .remedy = "look at its soft limits and limit switches",
              .reaction = controlled_stop};
    case DriveFinding::emergency:
      return {.what = "the drive sent an emergency",
              .remedy = "look at its error code",
              .reaction = controlled_stop};
    case DriveFinding::heartbeat_lost:
      return {.what = "the heartbeat of the drive has stopped",
              .remedy = "look at its supply and the bus",
              .reaction = controlled_stop};
    case DriveFinding::unexpected_boot:
      return {.what = "the drive has started anew",
              .remedy = "look at its supply, then find its reference again",
              .reaction = controlled_stop,
              .loses_reference = true};
    case DriveFinding::left_operational:
      return {.what = "the drive does not exchange process data any more",
              .remedy = "look at its error code, and who else commands the bus",
              .reaction = controlled_stop};
    case DriveFinding::bad_frames:
      return {.what = "too many frames of the drive are short, unknown or come twice",
              .remedy = "look at the cable, and for a second device with its node number",
              .reaction = controlled_stop};
    case DriveFinding::foreign_sender:
      return {.what = "somebody else sends what only this program may send",
              .remedy = "disconnect other masters and set-up tools from the bus",
              .reaction = controlled_stop};
    case DriveFinding::setpoint_jump:
      return {.what = "a setpoint is further from the last than the axis may go in a tick; it was not sent",
              .remedy = "report this: the program is at fault",
              .reaction = quick_stop};
    case DriveFinding::quick_stop_ignored:
      return {.what = "the drive does not answer a quick stop",
              .remedy = "use the emergency stop",
              .reaction = cease_setpoints};
  }
  return {};
}

}  // namespace inbetween::can
