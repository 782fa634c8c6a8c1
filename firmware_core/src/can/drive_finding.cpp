#include "inbetween/can/drive_finding.hpp"

#include <algorithm>
#include <array>

namespace inbetween::can {
namespace {

using enum DriveReaction;

struct Row {
  DriveFinding finding;
  DriveFindingWords words;
};

constexpr std::array table{
    Row{DriveFinding::never_booted,
        {.what = "no boot-up message came from the drive",
         .remedy = "look at its supply, node number and bitrate; if it obeys reset node only, write reset = "
                   "\"node\" in the drive of the axis"}},
    Row{DriveFinding::wrong_device,
        {.what = "the device is not the drive that the rig has there", .remedy = "look at its node number"}},
    Row{DriveFinding::mode_not_offered,
        {.what = "the drive does not offer the mode of operation that the rig says",
         .remedy = "use a drive with mode 8, or write mode = \"interpolated\" in the drive of the axis for "
                   "one with "
                   "mode 7"}},
    Row{DriveFinding::sync_of_another,
        {.what = "the drive sends SYNC itself or listens to another one",
         .remedy = "set its object 1005 to 80h"}},
    Row{DriveFinding::sdo_silent,
        {.what = "the drive did not answer while it was set up", .remedy = "look at its supply and the bus"}},
    Row{DriveFinding::sdo_failed,
        {.what = "the drive did not accept its set-up",
         .remedy = "look at the object and the reason it gave"}},
    Row{DriveFinding::read_back_differs,
        {.what = "the drive read back another value than was written",
         .remedy = "look whether it can have this value"}},
    Row{DriveFinding::would_coast,
        {.what = "the drive would switch its motor off at once where it must brake, and the axis would coast",
         .remedy = "set this object to a ramp, or write coasts = true for an axis that may roll out"}},
    Row{DriveFinding::stop_differs,
        {.what = "the drive brakes by another deceleration than the axis has in the rig",
         .remedy = "set its object 6085, or change stop_acceleration or deceleration_per_unit of the axis"}},
    Row{DriveFinding::host_loss_unbraked,
        {.what = "the drive would not brake if this program died",
         .remedy = "set its object 6007 to 3 (quick stop)"}},
    Row{DriveFinding::host_loss_unsaid,
        {.what = "the drive does not say what it does if this program dies (it has no object 6007)",
         .remedy =
             "write on_host_lost = \"stops\" for the axis if the manual of the drive says that it brakes"}},
    Row{DriveFinding::window_disabled,
        {.what = "the drive does not watch its following error", .remedy = "set its window, object 6065"}},
    Row{DriveFinding::window_unsaid,
        {.what = "the drive does not say whether it watches its following error (it has no object 6065)",
         .remedy = "write watches_following_error = true in the drive of the axis if the manual of the drive "
                   "says that it does"}},
    Row{DriveFinding::counts_round,
        {.what = "the drive counts its positions round (object 607B), and setpoints go on",
         .remedy = "set its object 607B:1 to 80000000h and 607B:2 to 7FFFFFFFh, which is off"}},
    Row{DriveFinding::watchdog_unset,
        {.what = "the drive would run on if this program died",
         .remedy = "set its heartbeat consumer (1016) or its setpoint timeout (1400:5), or write watchdog = "
                   "\"life-guarding\" in the drive of the axis if it has objects 100C and 100D"}},
    Row{DriveFinding::unheard,
        {.what = "the drive does not tell how and where it is",
         .remedy = "look at its supply, node number and bitrate, and that it sends its heartbeat and its "
                   "estimates"}},
    Row{DriveFinding::place_unsaid,
        {.what = "the drive tells how it is, but not where",
         .remedy =
             "let it send its position by itself, as often as its manual allows (encoder_msg_rate_ms of an "
             "ODrive)"}},
    Row{DriveFinding::two_devices,
        {.what = "two devices answer to its node number",
         .remedy = "give each device of the bus a node number of its own"}},
    Row{DriveFinding::wrong_firmware,
        {.what = "the drive has another firmware than the rig says",
         .remedy = "correct firmware in the drive of the axis, or load another into the drive"}},
    Row{DriveFinding::place_unknown,
        {.what = "the drive counts its position from wherever it got its power, and the rig believes it",
         .remedy =
             "tell the drive where it stands (its manual: home, or set output), give it an encoder at its "
             "output, or write reference = \"operator\" for the axis"}},
    Row{DriveFinding::watchdog_unproven,
        {.what = "the drive did not notice that this program was silent: it would run on if the program died",
         .remedy = "switch its watchdog on, with a timeout of 0.1 s or so, and save that in the drive"}},
    Row{DriveFinding::watchdog_unconfirmed,
        {.what = "the drive did not confirm the time after which it stops if this program dies",
         .remedy = "use a firmware that does, or write no_watchdog = \"accepted\" in the drive of the axis"}},
    Row{DriveFinding::plans_by_itself,
        {.what = "the drive does not say that it follows a position at once, without a ramp of its own",
         .remedy = "set its planning acceleration to 0 with its maker's tool, and start it anew"}},
    Row{DriveFinding::first_heartbeat_missing,
        {.what = "the first heartbeat of the drive never came", .remedy = "look at its object 1017"}},
    Row{DriveFinding::not_operational,
        {.what = "the drive did not begin to exchange process data",
         .remedy = "look at its display or errors"}},
    Row{DriveFinding::fault_stays,
        {.what = "the fault of the drive cannot be reset", .remedy = "remove its cause"}},
    Row{DriveFinding::not_enabled,
        {.what = "the drive did not switch on in time",
         .remedy = "look at its power stage, enable input and brake"}},
    Row{DriveFinding::mode_not_shown,
        {.what = "the drive did not go into the mode of operation that it was told (6061 shows another)",
         .remedy =
             "look whether it has mode 8 (7 with mode = \"interpolated\"), and what else sets its mode"}},
    Row{DriveFinding::follow_bit_missing,
        {.what = "the drive is in operation, but does not tell that it follows its target (statusword bit 12 "
                 "stays clear)",
         .remedy = "look at its limits and halt input; a drive that never sets bit 12 in this mode cannot be "
                   "used"}},
    Row{DriveFinding::moved_while_enabling,
        {.what = "the axis does not stand where its drive was told to hold it",
         .remedy = "look at its brake and load, and at the scale of its drive in the rig"}},
    Row{DriveFinding::moved_outside,
        {.what = "the axis was moved out of its limits after its drive was set up",
         .remedy = "end this command, and bring the axis in with inbetween goto"}},
    Row{DriveFinding::feedback_missing,
        {.what = "the drive has stopped telling where it is",
         .remedy = "look at its supply and the bus",
         .reaction = controlled_stop}},
    Row{DriveFinding::drive_fault,
        {.what = "the drive is in fault", .remedy = "look at its error code", .reaction = controlled_stop}},
    Row{DriveFinding::left_operation,
        {.what = "the drive has switched itself off",
         .remedy = "look at its enable input and supply",
         .reaction = controlled_stop}},
    Row{DriveFinding::switched_off_by_another,
        {.what = "somebody else has switched the drive off: it tells no error, and was heard all the time",
         .remedy = "disconnect other masters and set-up tools from the drive",
         .reaction = controlled_stop}},
    Row{DriveFinding::wrong_mode,
        {.what = "the drive is in another mode of operation than it was told",
         .remedy = "look who changed it",
         .reaction = controlled_stop}},
    Row{DriveFinding::target_ignored,
        {.what = "the drive does not follow its target (statusword bit 12)",
         .remedy = "look at its limits and halt input",
         .reaction = controlled_stop}},
    Row{DriveFinding::following_error,
        {.what = "the axis is too far from its target",
         .remedy = "look for what holds it, or move slower",
         .reaction = own_stop}},
    Row{DriveFinding::scale_differs,
        {.what = "the axis moves by more or less than it is told: the drive takes positions in another scale "
                 "than it tells them",
         .remedy = "compare its scales with those of its firmware, and measure with inbetween jog --measure",
         .reaction = own_stop}},
    Row{DriveFinding::internal_limit,
        {.what = "the drive has reached a limit of its own (statusword bit 11)",
         .remedy = "look at its soft limits and limit switches",
         .reaction = controlled_stop}},
    Row{DriveFinding::emergency,
        {.what = "the drive sent an emergency",
         .remedy = "look at its error code",
         .reaction = controlled_stop}},
    Row{DriveFinding::heartbeat_lost,
        {.what = "the heartbeat of the drive has stopped",
         .remedy = "look at its supply and the bus",
         .reaction = controlled_stop}},
    Row{DriveFinding::guard_answer_repeated,
        {.what = "the drive has answered two questions in a row with the same toggle bit (life guarding)",
         .remedy = "look for a second device with its node number; a drive that does so alone cannot be "
                   "guarded",
         .reaction = controlled_stop}},
    Row{DriveFinding::unexpected_boot,
        {.what = "the drive has started anew",
         .remedy = "look at its supply, then find its reference again",
         .reaction = controlled_stop,
         .loses_reference = true}},
    Row{DriveFinding::silent_for_a_while,
        {.what = "the drive was silent for a while and may have started anew",
         .remedy = "look at its supply and the bus, then find its reference again",
         .reaction = controlled_stop,
         .loses_reference = true}},
    Row{DriveFinding::left_operational,
        {.what = "the drive does not exchange process data any more",
         .remedy = "look at its error code, and who else commands the bus",
         .reaction = controlled_stop}},
    Row{DriveFinding::bad_frames,
        {.what = "too many frames of the drive are short, unknown or come twice",
         .remedy = "look at the cable, and for a second device with its node number",
         .reaction = controlled_stop}},
    Row{DriveFinding::foreign_sender,
        {.what = "somebody else sends what only this program may send",
         .remedy = "disconnect other masters and set-up tools from the bus",
         .reaction = controlled_stop}},
    Row{DriveFinding::setpoint_jump,
        {.what = "a setpoint is further from the last than the axis may go in a tick; it was not sent",
         .remedy = "report this: the program is at fault",
         .reaction = quick_stop}},
    Row{DriveFinding::quick_stop_ignored,
        {.what = "the drive does not answer a quick stop",
         .remedy = "use the emergency stop",
         .reaction = cease_setpoints}},
    Row{DriveFinding::not_switched_off,
        {.what = "the drive did not tell that it is switched off",
         .remedy = "take its power away before anybody goes near the axis",
         .reaction = cease_setpoints}},
    Row{DriveFinding::moves_while_off,
        {.what = "the axis moves though its drive is switched off",
         .remedy = "hold it, and look at its brake and balance",
         .reaction = cease_setpoints}},
    Row{DriveFinding::watchdog_stays,
        {.what = "the drive is off, but goes on to watch this program and will report that it is gone",
         .remedy = "look at the bus; the next start resets the drive"}},
};

constexpr bool is_in_order() {
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (static_cast<std::size_t>(table[i].finding) != i) return false;
  }
  return table.size() == drive_findings;
}
static_assert(is_in_order());

}  // namespace

DriveFindingWords words_of(DriveFinding finding) {
  return table[static_cast<std::size_t>(finding)].words;
}

bool stops_alone(const DriveFindings& findings) {
  return findings.has(DriveFinding::following_error) || findings.has(DriveFinding::scale_differs);
}

bool loses_reference(const DriveFindings& findings) {
  return std::ranges::any_of(
      table, [&](const Row& row) { return row.words.loses_reference && findings.has(row.finding); });
}

}  // namespace inbetween::can
