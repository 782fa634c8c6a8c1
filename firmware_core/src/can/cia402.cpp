#include "inbetween/can/cia402.hpp"

#include <array>

#include "inbetween/can/little_endian.hpp"

namespace inbetween::can {
namespace {

using enum Cia402State;

struct Row {
  std::uint16_t mask;
  std::uint16_t value;
  Cia402State state;
};
constexpr std::array rows{
    Row{0x004F, 0x0000, not_ready},
    Row{0x004F, 0x0040, switch_on_disabled},
    Row{0x006F, 0x0021, ready_to_switch_on},
    Row{0x006F, 0x0023, switched_on},
    Row{0x006F, 0x0027, operation_enabled},
    Row{0x006F, 0x0007, quick_stop_active},
    Row{0x004F, 0x000F, fault_reaction_active},
    Row{0x004F, 0x0008, fault},
};

constexpr std::uint16_t no_power = control_disable_voltage;
constexpr std::uint16_t quick = control_quick_stop;
constexpr std::uint16_t shutdown = control_shutdown;
constexpr std::uint16_t switch_on = control_switch_on;
constexpr std::uint16_t disable = control_disable_operation;
constexpr std::uint16_t enable = control_enable_operation;
constexpr std::uint16_t reset = control_fault_reset;

constexpr std::array<std::array<std::uint16_t, cia402_states>, cia402_goals> table{{
    // not ready, disabled, ready, switched on, enabled, quick stop, fault reaction, fault, unknown
    {no_power, no_power, no_power, shutdown, disable, no_power, no_power, no_power, no_power},  // off
    {no_power, no_power, no_power, shutdown, disable, no_power, no_power, reset, no_power},     // reset_fault
    {shutdown, shutdown, switch_on, enable, enable, no_power, shutdown, shutdown, shutdown},    // on
    {quick, quick, quick, quick, quick, quick, quick, quick, quick},                            // quick_stop
}};

constexpr std::array<const char*, cia402_states> state_names{"not ready to switch on",
                                                             "switch-on disabled",
                                                             "ready to switch on",
                                                             "switched on",
                                                             "operation enabled",
                                                             "quick stop active",
                                                             "fault reaction active",
                                                             "fault",
                                                             "unknown"};

constexpr PdoEntry object(std::uint16_t index, std::uint8_t bits, std::uint8_t sub = 0) {
  return {.object = {.index = index, .sub = sub}, .bits = bits};
}

}  // namespace

Cia402State state_of(std::uint16_t statusword) {
  for (const Row& row : rows) {
    if ((statusword & row.mask) == row.value) return row.state;
  }
  return unknown;
}

const char* name_of(Cia402State state) {
  return state_names[static_cast<std::size_t>(state)];
}

std::uint16_t controlword_for(Cia402Goal goal, Cia402State state) {
  return table[static_cast<std::size_t>(goal)][static_cast<std::size_t>(state)];
}

PdoMapping command_mapping(Cia402Mode mode) {
  const bool is_interpolated = mode == Cia402Mode::interpolated_position;
  const std::array entries{object(0x6040, 16), is_interpolated ? object(0x60C1, 32, 1) : object(0x607A, 32)};
  return PdoMapping::make(entries).value();
}
PdoMapping feedback_mapping() {
  static constexpr std::array entries{object(0x6041, 16), object(0x6064, 32), object(0x6061, 8)};
  return PdoMapping::make(entries).value();
}

Frame command_frame(NodeId node, const DriveCommand& command, std::uint32_t rpdo) {
  Frame frame{.id = rpdo_id(node, rpdo), .length = 6};
  store(frame.data, 0, command.controlword);
  store(frame.data, 2, static_cast<std::uint32_t>(command.target));
  return frame;
}

std::optional<DriveFeedback> read_feedback(const Frame& frame, NodeId node) {
  if (!is_canopen(frame) || frame.id != tpdo1_id(node) || frame.length != 7) return {};
  return DriveFeedback{.statusword = load<std::uint16_t>(frame.data, 0),
                       .actual = static_cast<std::int32_t>(load<std::uint32_t>(frame.data, 2)),
                       .mode = static_cast<std::int8_t>(load<std::uint8_t>(frame.data, 6))};
}

Result<InterpolationPeriod> interpolation_period(std::int64_t rate_hz) {
  if (rate_hz < 1 || rate_hz > 10'000) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the rate is not between 1 and 10000 Hz",
                 .remedy = "use 100, 200, 250, 500 or 1000"};
  }
  std::int64_t units_per_second = 1000;
  for (std::int8_t index = -3; index >= -6; --index, units_per_second *= 10) {
    const std::int64_t value = units_per_second / rate_hz;
    const bool is_exact = units_per_second % rate_hz == 0 && value <= 255;
    if (!is_exact) continue;
    return InterpolationPeriod{.value = static_cast<std::uint8_t>(value),
                               .index = index,
                               .microseconds = static_cast<std::int32_t>(1'000'000 / rate_hz)};
  }
  return Error{.code = ErrorCode::accuracy,
               .what = "the period is not exact in the drive (1 to 255 times a power of ten, in object 60C2)",
               .remedy = "use 100, 125, 200, 250, 400, 500 or 1000 Hz"};
}

}  // namespace inbetween::can
