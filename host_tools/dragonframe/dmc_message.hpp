// The messages of the DMC protocol as plain data. A table has their numbers, and says how long each may be.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host_tools/dragonframe/dmc_frame.hpp"

namespace inbetween::dragonframe {

enum class DmcType : std::uint16_t {
  hi = 0x0001,
  dmx = 0x0020,
  gio_out = 0x0021,
  gio_in = 0x0022,
  gio_cam = 0x0023,
  status = 0x0030,
  move = 0x0031,
  stop = 0x0032,
  stop_all = 0x0033,
  position = 0x0034,
  reset_position = 0x0035,
  jog = 0x0036,
  configure = 0x0037,
  set_speed = 0x0038,
  set_limits = 0x0039,
  hard_stop = 0x003A,
  upload_begin = 0x0100,
  upload_axis = 0x0101,
  upload_dmx = 0x0102,
  upload_end = 0x0103,
  upload_triggers = 0x0104,
  position_frame = 0x0110,
  run_move = 0x0111,
  shoot_frame = 0x0112,
  go = 0x0113,
  end = 0x0114,
  shoot_frame2 = 0x0115,
  stop_loop = 0x0116,
  jog_all = 0x0120,
  virtual_config = 0x0200,
  virtual_move = 0x0201,
  virtual_stop = 0x0202,
  virtual_jog = 0x0203,
  virtual_positions = 0x0205,
  virtual_jog_on_line = 0x0206,
  virtual_aim_point = 0x0207,
};

/// What a device can do, as HI tells it.
namespace dmc_can {
inline constexpr std::uint32_t real_time = 0x0001;
inline constexpr std::uint32_t shoot_frame = 0x0002;
inline constexpr std::uint32_t virtuals = 0x007C;  ///< all five; this device has none
inline constexpr std::uint32_t shoot_frame2 = 0x0080;
inline constexpr std::uint32_t couple = 0x0100;
inline constexpr std::uint32_t loop = 0x0200;
inline constexpr std::uint32_t camera = 0x0400;
}  // namespace dmc_can

enum class DmcCode : std::uint16_t {
  ok = 0x10,
  checksum = 0x11,
  moving = 0x12,
  unsupported = 0x13,
  range = 0x14,
  general = 0x15,
  not_in_position = 0x16,
  preroll = 0x17,
  postroll = 0x18,
  soft_upper = 0x20,
  soft_lower = 0x21,
  hard_upper = 0x22,
  hard_lower = 0x23,
};

/// A row of the table. Lengths are those of a request; what only a device sends has `is_request` false.
struct DmcTypeRow {
  DmcType type{};
  std::string_view name;
  bool is_request = true;
  std::size_t min_bytes = 0;
  std::size_t max_bytes = max_dmc_payload_bytes;  ///< bytes behind those that are known are let be
  std::uint32_t needs = 0;  ///< one of these capabilities, or it is UNSUPPORTED; 0: none
};

[[nodiscard]] std::span<const DmcTypeRow> dmc_type_table();
/// Nothing where the protocol has no such number.
[[nodiscard]] const DmcTypeRow* dmc_type_row(std::uint16_t type);

/// A request without numbers in it: HI, GIO_IN, STATUS, POSITION, UPLOAD_END, GO, STOP_LOOP.
struct DmcPlain {
  DmcType type{};
};
struct DmcGioOut {
  std::uint32_t bits = 0;
};
struct DmcGioCam {
  bool shutter = false;
  bool meter = false;
};
struct DmcMove {
  std::uint8_t motor = 0;
  std::int32_t target = 0;
};
struct DmcStop {
  std::uint8_t motor = 0;
};
struct DmcStopAll {
  bool is_silent = false;  ///< the host tidies up; otherwise a person wants a stop
};
struct DmcResetPosition {
  std::uint8_t motor = 0;
  std::int32_t position = 0;
};
struct DmcJog {
  std::uint8_t motor = 0;
  std::uint16_t speed = 0;  ///< 1: an inch; up to 10000, which is all of speed and acceleration
  std::int32_t destination = 0;
};
struct DmcConfigure {
  std::uint8_t motor = 0;
  bool is_enabled = false;
  bool has_blur = false;
  bool is_in_virtuals = false;
  bool is_live = false;
  bool couples = false;
  bool is_reversed = false;
  std::uint8_t unknown_flags = 0;
};
struct DmcSetSpeed {
  std::uint8_t motor = 0;
  std::uint32_t max_velocity = 0;
  std::uint32_t max_acceleration = 0;
};
struct DmcSetLimits {
  std::uint8_t motor = 0;
  std::optional<std::int32_t> lower;
  std::optional<std::int32_t> upper;
  std::uint8_t hardware_set = 0;
  bool hardware_swapped = false;
};
struct DmcUploadBegin {
  std::int32_t start = 0;
  std::int32_t end = 0;  ///< inclusive
};
struct DmcUploadAxis {
  std::uint8_t motor = 0;
  std::uint32_t index = 0;  ///< of the first position, 0 being the start frame
  bool is_last = false;     ///< the last position holds until the end of the move
  std::vector<std::int32_t> positions;
};
struct DmcTrigger {
  std::uint32_t index = 0;
  std::uint32_t values = 0;
};
struct DmcUploadTriggers {
  std::uint32_t mask = 0;
  std::vector<DmcTrigger> triggers;
};
struct DmcPositionFrame {
  std::int32_t frame = 0;
};
struct DmcRunMove {
  std::uint32_t frames_per_1000_s = 0;
  std::int32_t start = 0;
  std::int32_t end = 0;
  std::uint32_t preroll_ms = 0;
  std::uint32_t postroll_ms = 0;
  bool is_synced = false;  ///< triggers are played
  std::uint32_t bloop_bits = 0;
  std::uint16_t bloop_dmx = 0;
  std::uint16_t bloop_ms = 0;
  bool is_ping_pong = false;
  bool is_loop = false;
  bool has_video_camera = false;
  bool has_stills_camera = false;
  std::uint16_t open_deg = 0;
  std::uint16_t close_deg = 0;
};
/// A way for one shot only: at shutter angle 0, and at 360.
struct DmcOverride {
  std::uint8_t motor = 0;
  std::int32_t from = 0;
  std::int32_t to = 0;
};
struct DmcShootFrame {
  std::int32_t frame = 0;
  bool is_forward = true;
  std::uint32_t exposure_ms = 0;
  std::uint16_t blur_permille = 0;
  std::vector<DmcOverride> overrides;
};
struct DmcShootFrame2 {
  std::int32_t frame = 0;
  std::uint32_t exposure_ms = 0;
  std::int16_t open_deg = 0;
  std::int16_t close_deg = 0;
  std::vector<DmcOverride> overrides;
};
struct DmcJogAll {
  std::uint32_t frames_per_1000_s = 0;
  std::int32_t frame = 0;
};

using DmcRequest =
    std::variant<DmcPlain, DmcGioOut, DmcGioCam, DmcMove, DmcStop, DmcStopAll, DmcResetPosition, DmcJog,
                 DmcConfigure, DmcSetSpeed, DmcSetLimits, DmcUploadBegin, DmcUploadAxis, DmcUploadTriggers,
                 DmcPositionFrame, DmcRunMove, DmcShootFrame, DmcShootFrame2, DmcJogAll>;

/// Reads a payload of a type of the table. Nothing: its length is not one that the message can have.
[[nodiscard]] std::optional<DmcRequest> read_dmc_request(const DmcTypeRow& row,
                                                         std::span<const std::uint8_t> payload);

/// The answer to HI.
struct DmcHi {
  std::string name;  ///< UTF-8; 31 bytes are told, and a last one that is 0
  std::uint8_t major = 0;
  std::uint8_t minor = 0;
  std::uint8_t revision = 0;
  std::uint8_t motors = 0;
  std::uint16_t dmx_channels = 0;
  std::uint8_t outputs = 0;
  std::uint8_t inputs = 0;
  std::uint8_t hardware_limit_sets = 0;
  std::uint32_t frame_capacity = 0;
  std::uint32_t capabilities = 0;
};

/// Payloads of what a device sends.
[[nodiscard]] std::vector<std::uint8_t> write_dmc_hi(const DmcHi& hi);
[[nodiscard]] std::vector<std::uint8_t> write_dmc_code(
    DmcCode code);  ///< four bytes, as the maker's devices do
[[nodiscard]] std::vector<std::uint8_t> write_dmc_status(std::uint32_t moving);
[[nodiscard]] std::vector<std::uint8_t> write_dmc_positions(std::int32_t move_time,
                                                            std::span<const std::int32_t> positions);
[[nodiscard]] std::vector<std::uint8_t> write_dmc_inputs(std::uint32_t bits);
/// The motor is told with a limit only.
[[nodiscard]] std::vector<std::uint8_t> write_dmc_hard_stop(std::uint8_t reason, std::uint8_t motor);

}  // namespace inbetween::dragonframe
