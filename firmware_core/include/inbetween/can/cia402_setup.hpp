#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "inbetween/base/fixed_vector.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/cia402.hpp"
#include "inbetween/can/cia402_homing.hpp"
#include "inbetween/can/drive_finding.hpp"
#include "inbetween/can/sdo_client.hpp"

/// How a drive is made ready for a target in every tick: a list of objects that are checked or
/// written, each read back, in the order that CiA 301 asks for. A PDO that is as it shall be is left alone.

namespace inbetween::can {

/// The range of positions that a drive itself shall keep, in counts (object 607D).
struct CountRange {
  std::int32_t min = 0;
  std::int32_t max = 0;
};

/// How the drive homes by itself, in its own units.
struct HomingSetup {
  std::uint8_t method = 0;         ///< 6098
  std::uint32_t fast = 0;          ///< 6099:1; 0 and the next two not written: it homes where it stands
  std::uint32_t slow = 0;          ///< 6099:2
  std::uint32_t acceleration = 0;  ///< 609A
  std::int32_t offset = 0;         ///< 607C
};

/// The settings of a drive before it is switched on. An empty one stays as it is in the drive.
struct Cia402Setup {
  NodeId node;
  NodeId host;
  std::int64_t rate_hz = 250;
  Cia402Mode mode = Cia402Mode::cyclic_position;
  std::uint8_t rpdo = 1;  ///< which RPDO has the controlword and the target, 1 to 4
  /// It is switched on to home by itself, and takes no targets.
  std::optional<HomingSetup> homing{};
  std::uint8_t sync_overflow = 0;         ///< object 1019; 0: no counter in SYNC
  std::uint16_t drive_heartbeat_ms = 50;  ///< how often the drive tells that it lives (1017)
  std::uint16_t host_timeout_ms = 100;    ///< how long it believes that the host lives (1016)
  /// It is asked whether it lives (guarding, 100C and 100D), for a drive that knows no heartbeats (1016,
  /// 1017).
  bool is_guarded = false;
  std::uint16_t setpoint_timeout_ms = 50;                     ///< how long it waits for setpoints (1400:5)
  std::optional<std::uint32_t> following_error_window{};      ///< 6065, counts
  std::optional<std::uint16_t> following_error_timeout_ms{};  ///< 6066
  /// 607D, as long as the axis stands inside; it becomes the hull of this and of where the axis stands, with
  /// place_window_counts to either side. A drive clamps a target outside and goes there by itself.
  std::optional<CountRange> position_limits{};
  std::int32_t place_window_counts = 0;  ///< by which the axis may move until it is switched on
  /// How it brakes in a quick stop (605A), 1 to 8: 2 by the ramp of 6085 and then without power, 6 by the
  /// same ramp and then held.
  std::int16_t quick_stop_option = 2;
  std::optional<std::uint32_t> quick_stop_deceleration{};  ///< 6085, in units of the drive
  /// The axis may roll out: the drive may switch its power off where it could brake (605A to 605E, 6007).
  bool coasts = false;
  /// Somebody has read that the drive brakes when the host is lost, though it has no object 6007.
  bool stops_without_host = false;
  /// Somebody has read that the drive watches its following error, though it has no object 6065.
  bool watches_following_error = false;
  std::optional<std::uint32_t> vendor{};   ///< 1018:1, must be so
  std::optional<std::uint32_t> product{};  ///< 1018:2, must be so
  std::optional<std::uint32_t> serial{};   ///< 1018:4, must be so

  /// As 6060 and 6061 number it.
  [[nodiscard]] std::int8_t mode_of_operation() const {
    return homing ? homing_mode : static_cast<std::int8_t>(mode);
  }
};

/// The questions that a guarded drive may miss: its life time (host_timeout_ms) is so many guard times.
inline constexpr std::uint8_t life_time_factor = 4;

/// Objects of which the steps depend on each other.
inline constexpr ObjectAddress guard_time{.index = 0x100C};
inline constexpr ObjectAddress life_factor{.index = 0x100D};
inline constexpr ObjectAddress heartbeat_consumer{.index = 0x1016, .sub = 1};
inline constexpr ObjectAddress heartbeat_producer{.index = 0x1017};
inline constexpr std::uint16_t fault_reaction_index = 0x605E;
inline constexpr std::uint16_t host_loss_index = 0x6007;
inline constexpr std::uint16_t range_limit_index = 0x607B;
inline constexpr std::uint16_t window_index = 0x6065;
inline constexpr std::uint16_t position_limit_index = 0x607D;
inline constexpr ObjectAddress interpolation_time{.index = 0x60C2, .sub = 1};
inline constexpr ObjectAddress interpolation_exponent{.index = 0x60C2, .sub = 2};

enum class SetupAction : std::uint8_t {
  expect,           ///< (object & mask) must be `value`, or `finding`
  forbid,           ///< (object & mask) must not be `value`, or `finding`
  expect_no_range,  ///< it must be `value`, or 0 as the other end of the range, or `finding`
  look,             ///< whether the object is 0 or absent is remembered
  note_error,       ///< the code of the error that the drive has
  note_place,       ///< the position of the axis, for the limits that are written later
  compare,          ///< whether (object & mask) is `value`: of several in a row each must be, for `unless_so`
  // These read first, and write only what differs: a drive may have it fixed, or keep it in flash.
  write,       ///< it must be `value`
  try_write,   ///< `value` if the drive takes it now; it may be anything
  limit,       ///< a limit of positions: `value`, or further out where the axis stands beyond it
  try_limit,   ///< the same, if the drive takes it now
  sync_watch,  ///< `value`, or 0 where the drive watches the host's heartbeat: it must be one of the two
  switch_off,  ///< COB-ID of a PDO: bit 31 set, all others kept
  switch_on,   ///< COB-ID of a PDO: `value` with bit 30 as it is in the drive
  // These write at once. What the drive has then, is read and judged; also where it has refused to be
  // written.
  write_at_once,  ///< it must be `value`
  write_near,     ///< it must be `value`, or off by no more than a drive rounds
  write_code,     ///< it must be a number of which `mask` has the bit
  watchdog,       ///< a heartbeat, guarding or the setpoint timeout: it must be as long, or up to twice
};

struct SetupStep {
  SetupAction action = SetupAction::write;
  DriveFinding finding = DriveFinding::read_back_differs;
  ObjectAddress object{};
  std::uint8_t size = 4;
  bool may_be_absent : 1 = false;  ///< the abort "no such object" or "no such sub-index" is an answer, too
  bool may_be_hidden : 1 = false;  ///< it need not be readable
  bool may_stay : 1 = false;       ///< nothing depends on it: a drive in which it is fixed may keep it
  bool unless_so : 1 = false;      ///< left out where the comparisons before it have found what they look for
  std::uint32_t value = 0;
  std::uint32_t mask = 0xFFFFFFFF;  ///< of a limit: how far it is from an axis that stands beyond it
};
inline constexpr std::size_t setup_steps = 80;
using SetupScript = FixedVector<SetupStep, setup_steps>;

/// Writes the steps for a drive, in pre-operational: who it is; no PDO but one RPDO and TPDO1, and those
/// mapped as command_mapping and feedback_mapping say; the period; what watches over it; the mode. Errors:
/// those of interpolation_period; out_of_range (an RPDO that is not 1 to 4, a time of 0, an option or a range
/// that leaves the drive unwatched, host and drive the same node).
Status write_setup_script(const Cia402Setup& setup, SetupScript& script);
/// The same script with the RPDO `to`, 1 to 4, for controlword and target instead of `from`. In place,
/// because a drive finds in a tick that it needs that, and there is no stack for a second script.
void change_rpdo(SetupScript& script, NodeId node, std::uint8_t from, std::uint8_t to);

/// Why a drive was refused.
struct SetupRefusal {
  DriveFinding finding = DriveFinding::sdo_failed;
  ObjectAddress object{};
  std::uint32_t expected = 0;
  std::optional<std::uint32_t> found{};  ///< what the drive has in the object; nothing where it did not say
  std::uint32_t abort_code = 0;          ///< its reason not to be read or written; 0 where it gave none
};

enum class SetupState : std::uint8_t {
  idle,
  reading,  ///< before a write, or to check
  writing,
  verifying,  ///< reading what it has after a write
  done,
  refused,
};
inline constexpr std::size_t setup_states = 6;

enum class SetupEvent : std::uint8_t {
  begin_reading,  ///< a step that reads first
  begin_writing,  ///< a step that writes at once, or has read what it had to know
  written,        ///< the drive has taken the value, or keeps what it has
  finished,       ///< no step is left
  differs,        ///< the drive does not answer, or has another value
};
inline constexpr std::size_t setup_events = 5;

/// The whole table.
SetupState next_state(SetupState state, SetupEvent event);

/// Works a script off through SDO, one request at a time.
class SetupRunner {
 public:
  SetupRunner(NodeId node, std::int64_t sdo_timeout_ns) : client_(node, sdo_timeout_ns) {}

  /// The same script for `begin` and every `poll` until done or refused.
  void begin(const SetupScript& script);
  /// At most one frame.
  std::optional<Frame> poll(const SetupScript& script, std::int64_t now_ns);
  /// An SDO answer of the drive. False: not what was waited for.
  bool receive(const Frame& frame) { return client_.receive(frame); }

  [[nodiscard]] SetupState state() const { return state_; }
  [[nodiscard]] const SetupRefusal& refusal() const { return refusal_; }
  /// How many steps are done.
  [[nodiscard]] std::size_t step() const { return step_; }
  /// The times of the drive's own watchdogs as read back, in milliseconds; 0: it has none.
  [[nodiscard]] std::uint16_t host_timeout_ms() const { return host_timeout_ms_; }
  [[nodiscard]] std::uint16_t setpoint_timeout_ms() const { return setpoint_timeout_ms_; }
  /// How often it will tell that it lives, as read back; a guarded drive, how often it is asked.
  [[nodiscard]] std::uint16_t drive_heartbeat_ms() const { return drive_heartbeat_ms_; }
  /// The objects that were to be written or checked and that the drive does not have, by their index, in
  /// order.
  using Absent = FixedVector<std::uint16_t, 24>;
  [[nodiscard]] const Absent& absent() const { return absent_; }
  /// The code of the error that it had when it was set up (603F, or else 1003:1); 0 for none.
  [[nodiscard]] std::uint16_t error_code() const { return error_code_; }
  /// Whether the drive does not switch off a PDO that nobody needs, by the index of its identifier.
  [[nodiscard]] bool has_kept(std::uint16_t pdo) const { return (kept_pdos_ & bit_of(pdo)) != 0; }
  /// Where the axis stood when it was set up, in counts; nothing where no limits of positions were written.
  [[nodiscard]] std::optional<std::int32_t> place() const { return place_; }
  /// Neither a velocity (60FF) nor a torque (6071) is asked of it, whatever mode it is in.
  [[nodiscard]] bool has_no_other_target() const { return has_no_other_target_; }

 private:
  /// RPDOs in the low four bits, TPDOs above.
  static std::uint8_t bit_of(std::uint16_t pdo) {
    return static_cast<std::uint8_t>(1U << ((pdo & 3U) + (pdo >= 0x1800 ? 4U : 0U)));
  }
  void begin_step(const SetupScript& script);
  void note_cob_id(const SetupStep& step);
  [[nodiscard]] bool is_left_out(const SetupScript& script);
  void next_step(const SetupScript& script);
  [[nodiscard]] std::uint32_t value_for(const SetupStep& step) const;
  [[nodiscard]] std::uint32_t limit_for(const SetupStep& step) const;
  void write(const SetupStep& step);
  void read_back(const SetupStep& step);
  void answered(const SetupScript& script);
  bool has_read(const SetupStep& step);
  void has_failed(const SetupScript& script, const SetupStep& step);
  [[nodiscard]] bool can_do_without(const SetupStep& step) const;
  void is_absent(const SetupScript& script, const SetupStep& step);
  void refuse(const SetupStep& step, DriveFinding finding);
  bool is_right(const SetupStep& step);
  [[nodiscard]] bool is_right_code(const SetupStep& step) const;
  bool is_no_range(const SetupStep& step);
  bool note_watchdog(const SetupStep& step);
  bool note_life_time(const SetupStep& step);

  SdoClient client_;
  SetupState state_ = SetupState::idle;
  SetupRefusal refusal_;
  std::size_t step_ = 0;
  std::uint32_t written_ = 0;
  std::optional<std::uint32_t> found_;  ///< of this step
  std::uint32_t abort_code_ = 0;        ///< of this step
  bool is_so_ = false;                  ///< the comparisons
  bool has_no_other_target_ = true;
  Absent absent_;
  /// The identifier of a PDO as it is now: several steps in a row need it.
  struct CobId {
    ObjectAddress object{};
    std::uint32_t value = 0;
  };
  CobId cob_id_;
  std::uint8_t kept_pdos_ = 0;
  std::uint16_t error_code_ = 0;
  std::optional<std::int32_t> place_;  ///< of the axis when it was set up
  bool has_period_ = true;             ///< 60C2 tells it how long a tick is
  bool fault_may_coast_ = false;       ///< nobody knows what it does in a fault
  std::uint32_t range_begin_ = 0;      ///< 607B:1
  std::uint16_t host_timeout_ms_ = 0;
  std::uint16_t setpoint_timeout_ms_ = 0;
  std::uint16_t drive_heartbeat_ms_ = 0;
};

}  // namespace inbetween::can
