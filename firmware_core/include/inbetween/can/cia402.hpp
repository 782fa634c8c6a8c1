#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "inbetween/base/result.hpp"
#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/can/pdo.hpp"

/// The drive profile CiA 402 (IEC 61800-7-201): its states, the words that move between them, and the process
/// data of a drive that gets a target in every tick.

namespace inbetween::can {

enum class Cia402State : std::uint8_t {
  not_ready,           ///< starting up by itself
  switch_on_disabled,  ///< no power
  ready_to_switch_on,
  switched_on,            ///< power, but the motor is not held
  operation_enabled,      ///< follows its target
  quick_stop_active,      ///< slows down by its own ramp, or rests after it
  fault_reaction_active,  ///< slows down because of a fault
  fault,
  unknown,  ///< a statusword that the profile does not name
};
inline constexpr std::size_t cia402_states = 9;

/// Reads the state with the masks 004F and 006F of the profile.
Cia402State state_of(std::uint16_t statusword);
/// In words: "switched on".
const char* name_of(Cia402State state);

constexpr bool is_faulty(Cia402State state) {
  return state == Cia402State::fault || state == Cia402State::fault_reaction_active;
}

inline constexpr std::uint16_t status_warning = 1U << 7;
inline constexpr std::uint16_t status_internal_limit = 1U << 11;
inline constexpr std::uint16_t status_follows_target = 1U << 12;  ///< in this mode of operation
inline constexpr std::uint16_t status_following_error = 1U << 13;

inline constexpr std::uint16_t control_disable_voltage = 0x0000;
inline constexpr std::uint16_t control_quick_stop = 0x0002;
inline constexpr std::uint16_t control_shutdown = 0x0006;
inline constexpr std::uint16_t control_switch_on = 0x0007;
inline constexpr std::uint16_t control_disable_operation = 0x0007;
inline constexpr std::uint16_t control_enable_operation = 0x000F;
inline constexpr std::uint16_t control_fault_reset = 0x0080;  ///< acts where bit 7 rises

/// The state to which the host wants to bring a drive.
enum class Cia402Goal : std::uint8_t {
  off,          ///< no power; out of operation by the drive's own ramp (605C)
  reset_fault,  ///< no fault and no power
  on,           ///< operation enabled; never out of a fault by itself
  quick_stop,   ///< stopped by the drive's own ramp (605A)
};
inline constexpr std::size_t cia402_goals = 4;

/// The controlword that leads from `state` towards `goal`: the whole table. A fault is reset by 0080 in this
/// goal and state only, so that bit 7 was low before.
std::uint16_t controlword_for(Cia402Goal goal, Cia402State state);

/// In interpolated position: the drive goes from set-point to set-point.
inline constexpr std::uint16_t control_interpolate = 0x0010;

/// The modes of operation in which a drive takes a target in every tick, as 6060 and 6061 number them.
enum class Cia402Mode : std::int8_t {
  interpolated_position = 7,  ///< the target is 60C1:1, and bit 4 of the controlword begins
  cyclic_position = 8,        ///< the target is 607A
};

/// A drive receives this in every tick (RPDO1, six bytes).
struct DriveCommand {
  std::uint16_t controlword = control_disable_voltage;
  std::int32_t target = 0;  ///< counts
  friend bool operator==(const DriveCommand&, const DriveCommand&) = default;
};
/// It tells this in every tick (TPDO1, seven bytes).
struct DriveFeedback {
  std::uint16_t statusword = 0;
  std::int32_t actual = 0;  ///< counts
  std::int8_t mode = 0;     ///< object 6061
  friend bool operator==(const DriveFeedback&, const DriveFeedback&) = default;
};

/// The objects in these frames.
PdoMapping command_mapping(Cia402Mode mode);
PdoMapping feedback_mapping();

Frame command_frame(NodeId node, const DriveCommand& command, std::uint32_t rpdo = 1);
/// Nothing where the frame is another one or has another length.
std::optional<DriveFeedback> read_feedback(const Frame& frame, NodeId node);

/// The period of the loop as object 60C2 tells it: value * 10^index seconds.
struct InterpolationPeriod {
  std::uint8_t value = 0;
  std::int8_t index = 0;
  std::int32_t microseconds = 0;  ///< as in object 1006
};
/// Counts milliseconds where they suffice, else 10^-4 to 10^-6 s. Errors: out_of_range (the rate is not in
/// 1..10'000 Hz), accuracy (the period is no whole number of microseconds, or not exact in 60C2).
Result<InterpolationPeriod> interpolation_period(std::int64_t rate_hz);

}  // namespace inbetween::can
