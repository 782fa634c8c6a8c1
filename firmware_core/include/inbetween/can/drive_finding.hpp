#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>

/// The faults of a drive on a bus, in words, and what has to follow.

namespace inbetween::can {

enum class DriveFinding : std::uint8_t {
  // while it is set up
  never_booted,
  wrong_device,
  mode_not_offered,
  sync_of_another,
  sdo_silent,
  sdo_failed,
  read_back_differs,
  would_coast,
  stop_differs,
  host_loss_unbraked,
  host_loss_unsaid,
  window_disabled,
  window_unsaid,
  counts_round,
  watchdog_unset,
  unheard,
  place_unsaid,
  two_devices,
  wrong_firmware,
  place_unknown,
  watchdog_unproven,
  watchdog_unconfirmed,
  plans_by_itself,
  first_heartbeat_missing,
  not_operational,
  // while it is switched on
  fault_stays,
  not_enabled,
  mode_not_shown,
  follow_bit_missing,
  moved_while_enabling,
  moved_outside,
  // at any time after that
  feedback_missing,
  drive_fault,
  left_operation,
  switched_off_by_another,
  wrong_mode,
  target_ignored,
  following_error,
  scale_differs,
  internal_limit,
  emergency,
  heartbeat_lost,
  guard_answer_repeated,
  unexpected_boot,
  silent_for_a_while,
  left_operational,
  bad_frames,
  foreign_sender,
  setpoint_jump,
  quick_stop_ignored,
  // while it is switched off
  not_switched_off,
  moves_while_off,
  watchdog_stays,
};
inline constexpr std::size_t drive_findings = 53;

/// The reaction of the loop with the whole rig (a drive decides nothing for the others).
enum class DriveReaction : std::uint8_t {
  refuse,           ///< E: nothing is switched on
  controlled_stop,  ///< CS: all axes slow down together on the path
  own_stop,         ///< CS of the others; this drive stops by itself at once, or loses its power
  quick_stop,       ///< all drives stop by their own ramps
  cease_setpoints,  ///< SS: nothing is sent, the drive's own watchdog stops the motor
};

struct DriveFindingWords {
  const char* what = "";    ///< one clause, no full stop: "its heartbeat has stopped"
  const char* remedy = "";  ///< "look at its supply and the bus"
  DriveReaction reaction = DriveReaction::refuse;
  bool loses_reference = false;  ///< the drive may have forgotten where it is
};

DriveFindingWords words_of(DriveFinding finding);
class DriveFindings;
/// Whether the drive may have forgotten where it is, by one of these.
bool loses_reference(const DriveFindings& findings);
/// Whether the drive is not where it is told to be, by one of these, and has to stop by itself.
bool stops_alone(const DriveFindings& findings);

/// Several findings at a time.
class DriveFindings {
 public:
  constexpr DriveFindings() = default;
  constexpr DriveFindings(DriveFinding finding) : bits_(bit(finding)) {}  // NOLINT: one is several, too
  constexpr void add(DriveFinding finding) { bits_ |= bit(finding); }
  constexpr void add(const DriveFindings& others) { bits_ |= others.bits_; }
  constexpr void clear() { bits_ = 0; }
  /// Takes one out. Only where there is one.
  constexpr DriveFinding take() {
    const auto taken = static_cast<DriveFinding>(std::countr_zero(bits_));
    bits_ &= bits_ - 1;
    return taken;
  }
  [[nodiscard]] constexpr DriveFindings without(const DriveFindings& others) const {
    DriveFindings rest = *this;
    rest.bits_ &= ~others.bits_;
    return rest;
  }
  [[nodiscard]] constexpr bool has(DriveFinding finding) const { return (bits_ & bit(finding)) != 0; }
  [[nodiscard]] constexpr bool empty() const { return bits_ == 0; }
  friend constexpr bool operator==(const DriveFindings&, const DriveFindings&) = default;

 private:
  static constexpr std::uint64_t bit(DriveFinding finding) {
    return std::uint64_t{1} << static_cast<unsigned>(finding);
  }
  static_assert(drive_findings <= 64);
  std::uint64_t bits_ = 0;
};

/// It keeps what was found at a drive since somebody has seen it. A finding stays until it is acknowledged;
/// it lasts where it was found again in the present tick. A bad frame is no finding before there are too many
/// of them, and is forgiven in time. O(1).
class FindingLog {
 public:
  /// Bad frames that are still no finding; one is forgiven in every `ticks`.
  struct BadFrames {
    std::int32_t limit = 8;
    std::int32_t ticks = 250;
  };
  explicit FindingLog(const BadFrames& allowed) : allowed_(allowed), ticks_to_forgive_(allowed.ticks) {}

  void begin_tick() { lasting_.clear(); }
  /// Called once in every tick in which bad frames can come.
  void forgive() {
    if (--ticks_to_forgive_ > 0) return;
    ticks_to_forgive_ = allowed_.ticks;
    bad_frames_ = std::max<std::int32_t>(bad_frames_ - 1, 0);
  }
  void find(DriveFinding finding) {
    all_.add(finding);
    if (!first_) first_ = finding;
  }
  void find_lasting(DriveFinding finding) {
    lasting_.add(finding);
    find(finding);
  }
  /// `counter` counts such frames.
  void take_bad_frame(std::uint32_t& counter) {
    ++counter;
    if (++bad_frames_ > allowed_.limit) find(DriveFinding::bad_frames);
  }
  void acknowledge() {
    all_.clear();
    first_.reset();
    bad_frames_ = 0;
  }

  [[nodiscard]] const DriveFindings& all() const { return all_; }
  [[nodiscard]] const DriveFindings& lasting() const { return lasting_; }
  [[nodiscard]] std::optional<DriveFinding> first() const { return first_; }
  [[nodiscard]] bool empty() const { return all_.empty(); }

 private:
  BadFrames allowed_;
  DriveFindings all_;
  DriveFindings lasting_;
  std::optional<DriveFinding> first_;
  std::int32_t bad_frames_ = 0;  ///< not forgiven
  std::int32_t ticks_to_forgive_;
};

}  // namespace inbetween::can
