#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "inbetween/can/cia402.hpp"

/// A CiA 402 drive homes itself (mode of operation 6): the host starts it, watches it, and ends it.

namespace inbetween::can {

/// Mode of operation 6. No target of the host moves the axis in it.
inline constexpr std::int8_t homing_mode = 6;

// The bits of the two words in this mode.
inline constexpr std::uint16_t control_start_homing = 0x0010;
inline constexpr std::uint16_t control_halt = 0x0100;
inline constexpr std::uint16_t status_stands = 1U << 10;
inline constexpr std::uint16_t status_homing_attained = 1U << 12;
inline constexpr std::uint16_t status_homing_error = 1U << 13;

/// Whether the profile has this method of homing: 1 to 14, 17 to 30, 33 to 35 and 37.
constexpr bool is_homing_method(std::int64_t method) {
  const bool is_reserved = method == 15 || method == 16 || method == 31 || method == 32 || method == 36;
  return method >= 1 && method <= 37 && !is_reserved;
}
/// The axis is home where it stands, and does not move.
constexpr bool homes_where_it_stands(std::int64_t method) {
  return method == 35 || method == 37;
}

enum class DriveHomingState : std::uint8_t {
  waiting,  ///< nobody has started it: the axis stands
  seeking,  ///< started (bit 4)
  halting,  ///< it is to stand still (bit 8), and is not home
  done,     ///< it is home, stands, and has told the position that it shall
  ended,    ///< it is over, and the axis is not home
};
inline constexpr std::size_t drive_homing_states = 5;

enum class DriveHomingEvent : std::uint8_t {
  start,
  attained,
  failed,
  stop,   ///< somebody or something wants the axis to stand
  stood,  ///< it stands, or has had the time to
  lost,   ///< the drive is not in operation any more
};
inline constexpr std::size_t drive_homing_events = 6;

/// The whole table. Nothing leads to seeking but a start of what waits, and nothing out of done and ended.
DriveHomingState next_state(DriveHomingState state, DriveHomingEvent event);

enum class DriveHomingFailure : std::uint8_t { none, error, timed_out, too_fast, elsewhere };
inline constexpr std::size_t drive_homing_failures = 5;
/// One clause each, no full stop: "the drive tells a homing error".
const char* words_of(DriveHomingFailure failure);
const char* remedy_of(DriveHomingFailure failure);

/// In counts and nanoseconds.
struct DriveHomingSpec {
  std::int32_t home = 0;       ///< the position that the drive shall tell at its end
  std::int32_t tolerance = 0;  ///< how far it may rest from there
  std::int32_t max_step = 1;   ///< in a tick; further in three in a row is too fast
  std::int64_t timeout_ns = 60'000'000'000;
  friend bool operator==(const DriveHomingSpec&, const DriveHomingSpec&) = default;
};

/// One homing, from when the drive is in operation in mode 6. Every call is O(1); nothing waits.
class Cia402Homing {
 public:
  explicit Cia402Homing(const DriveHomingSpec& spec) : spec_(spec) {}

  /// False: it has been started, or is over.
  bool start(std::int64_t now_ns);
  /// What moves is halted.
  void stop(std::int64_t now_ns);
  /// The drive is not in operation any more, by whatever.
  void lose() { apply(DriveHomingEvent::lost); }
  /// Once a tick, with what the drive has told last.
  void tick(const DriveFeedback& told, std::int64_t now_ns);

  /// The bits that go with the controlword of operation. The halt stays for good, so that nothing begins
  /// again.
  [[nodiscard]] std::uint16_t control_bits() const;
  [[nodiscard]] DriveHomingState state() const { return state_; }
  [[nodiscard]] bool is_over() const {
    return state_ == DriveHomingState::done || state_ == DriveHomingState::ended;
  }
  /// Why it was not done; none where it was stopped from outside.
  [[nodiscard]] DriveHomingFailure failure() const { return failure_; }

 private:
  bool apply(DriveHomingEvent event);
  void fail(DriveHomingFailure failure, std::int64_t now_ns);
  void seek(const DriveFeedback& told, std::int64_t now_ns);
  [[nodiscard]] bool is_too_fast(std::int32_t actual);

  DriveHomingSpec spec_;
  DriveHomingState state_ = DriveHomingState::waiting;
  DriveHomingFailure failure_ = DriveHomingFailure::none;
  std::int64_t since_ns_ = 0;            ///< when it was started, or halted
  std::optional<std::uint16_t> before_;  ///< what the bits said when it was started
  bool has_answered_ = false;            ///< they have changed since
  std::optional<std::int32_t> last_;
  std::int32_t fast_ticks_ = 0;
};

}  // namespace inbetween::can
