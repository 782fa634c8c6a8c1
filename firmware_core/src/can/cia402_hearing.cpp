// A drive is heard here, with what its words mean at once.
#include "inbetween/can/cia402_drive.hpp"

namespace inbetween::can {

using enum DrivePhase;

namespace {
constexpr std::uint8_t max_strays = 3;
}  // namespace

void Cia402Drive::receive(const Frame& frame, std::int64_t now_ns) {
  if (phase() == off) return;
  if (frame.id == heartbeat_id(node())) return take_heartbeat(frame, now_ns);
  if (frame.id == emergency_id(node())) return take_emergency(frame, now_ns);
  if (frame.id == tpdo1_id(node())) return take_feedback(frame, now_ns);
  if (frame.id != sdo_answer_id(node())) return;
  const bool is_awaited = is_leaving() ? exit_.receive(frame) : runner_.receive(frame);
  if (is_awaited) return;
  ++counters_.stray_answers;
  // A late answer comes once or twice. Of two devices with one number the second answers every question.
  if (phase() == configuring && ++strays_ > max_strays) {
    log_.find(DriveFinding::two_devices);
    apply(DriveEvent::refused, now_ns);
  }
}

/// The answer of a guarded drive counts if its toggle bit is another one than before: the standard takes it
/// for not received otherwise. Where the question before had been answered too, none is missing between the
/// two, and the drive is wrong. An answer to no question is one that has come twice.
std::optional<NmtState> Cia402Drive::heard_in(const Frame& frame) {
  if (!settings_.setup.is_guarded) return read_heartbeat(frame, node());
  const std::optional<GuardAnswer> answer = read_guard_answer(frame, node());
  if (!answer) return {};
  const bool is_boot_up = answer->state == NmtState::boot_up;
  if (!is_boot_up && !needs_sync()) return answer->state;  // a heartbeat: nobody has asked yet
  if (answer->toggle != (guard_toggle_ && !is_boot_up)) {
    if (guard_questions_ == 1) log_.find(DriveFinding::guard_answer_repeated);
    return {};
  }
  guard_toggle_ = !is_boot_up && !guard_toggle_;
  guard_questions_ = 0;
  return answer->state;
}

void Cia402Drive::take_heartbeat(const Frame& frame, std::int64_t now_ns) {
  const std::optional<NmtState> heard = heard_in(frame);
  if (!heard) return log_.take_bad_frame(counters_.bad_frames);
  heard_ = *heard;
  heartbeat_.receive(*heard, now_ns);
  if (*heard == NmtState::boot_up) take_boot_up(now_ns);
}

void Cia402Drive::take_boot_up(std::int64_t now_ns) {
  const bool was_told_to_leave = phase() == leaving && has_lost_touch_;
  if (phase() == booting || was_told_to_leave) {
    // One that was on its way before the reset was sent is not the answer to it.
    if (!order_) apply(was_told_to_leave ? DriveEvent::left : DriveEvent::booted, now_ns);
  } else if (phase() == configuring && !has_booted_again_) {
    // Then that one was the answer, as where rig and drive are switched on together. Its set-up begins anew.
    has_booted_again_ = true;
    was_sent_back_ = false;
    runner_.begin(script_);
  } else if (phase() != refused && phase() != gone) {
    log_.find(DriveFinding::unexpected_boot);
    apply(phase() == leaving ? DriveEvent::left : DriveEvent::vanished, now_ns);
  }
}

void Cia402Drive::take_emergency(const Frame& frame, std::int64_t now_ns) {
  const std::optional<Emergency> emergency = read_emergency(frame, node());
  if (!emergency) return log_.take_bad_frame(counters_.bad_frames);
  if (emergency->code == 0) return;
  last_emergency_ = *emergency;
  ++counters_.emergencies;
  // A drive without power may tell of an error that is over: many repeat the last one when they are started.
  // If it is not over, the fault stays when it is to be cleared.
  if (clock_.is_to_have_power() && !emergency_ns_) emergency_ns_ = now_ns;
  if (has_lost_touch_ || !is_of_communication(emergency->code)) return;
  has_lost_touch_ = true;
  if (phase() == leaving) enter_leaving(now_ns);
}

/// An emergency may be a warning: then bit 7 of the statusword is set soon, and the drive stays in operation.
/// Anything else is a finding: a fault at once, and an emergency that nothing explains after the grace.
void Cia402Drive::judge_emergency(std::int64_t now_ns) {
  if (!emergency_ns_) return;
  const bool is_well = phase() == following ? state() == Cia402State::operation_enabled
                                            : phase() == enabling && !is_faulty(state());
  if (is_well && is_fresh_ && status_has(status_warning)) return emergency_ns_.reset();
  if (is_well && now_ns - *emergency_ns_ <= settings_.ignore_grace_ns) return;
  emergency_ns_.reset();
  log_.find(DriveFinding::emergency);
}

void Cia402Drive::take_feedback(const Frame& frame, std::int64_t now_ns) {
  if (!has_process_data()) return;
  const std::optional<DriveFeedback> feedback = read_feedback(frame, node());
  if (!feedback) return log_.take_bad_frame(counters_.bad_frames);
  // A drive that has just been started may answer a SYNC that was sent before.
  if (awaited_ == 0 && phase() != starting) return log_.take_bad_frame(counters_.duplicates);
  if (awaited_ > 0) --awaited_;
  ++counters_.feedback;
  feedback_ = *feedback;
  has_feedback_ = true;
  is_fresh_ = true;
  judge_emergency(now_ns);
}

}  // namespace inbetween::can
