#include "host_tools/dragonframe/dmc_message.hpp"

#include <algorithm>
#include <array>

namespace inbetween::dragonframe {
namespace {

constexpr std::size_t any = max_dmc_payload_bytes;
constexpr bool from_device = false;
// No device made of this room has DMX channels or virtual axes.
constexpr std::uint32_t never = 0x8000'0000;

// What places or moves a motor by itself has exactly its length. Elsewhere bytes behind the known ones are
// let be: a newer host may send more.
constexpr std::array type_rows{
    DmcTypeRow{DmcType::hi, "HI", true, 0, any, 0},
    DmcTypeRow{DmcType::dmx, "DMX", true, 3, any, never},
    DmcTypeRow{DmcType::gio_out, "GIO_OUT", true, 4, any, 0},
    DmcTypeRow{DmcType::gio_in, "GIO_IN", true, 0, any, 0},
    DmcTypeRow{DmcType::gio_cam, "GIO_CAM", true, 4, any, dmc_can::camera},
    DmcTypeRow{DmcType::status, "STATUS", true, 0, any, 0},
    DmcTypeRow{DmcType::move, "MOVE", true, 5, 5, 0},
    DmcTypeRow{DmcType::stop, "STOP", true, 1, any, 0},
    DmcTypeRow{DmcType::stop_all, "STOP_ALL", true, 0, any, 0},
    DmcTypeRow{DmcType::position, "POSITION", true, 0, any, 0},
    DmcTypeRow{DmcType::reset_position, "RESET_POSITION", true, 5, 5, 0},
    DmcTypeRow{DmcType::jog, "JOG", true, 7, 7, 0},
    DmcTypeRow{DmcType::configure, "CONFIGURE", true, 2, any, 0},
    DmcTypeRow{DmcType::set_speed, "SET_SPEED", true, 9, any, 0},
    DmcTypeRow{DmcType::set_limits, "SET_LIMITS", true, 12, any, 0},
    DmcTypeRow{DmcType::hard_stop, "HARD_STOP", from_device, 0, any, 0},
    DmcTypeRow{DmcType::upload_begin, "UPLOAD_BEGIN", true, 8, any,
               dmc_can::real_time | dmc_can::shoot_frame},
    DmcTypeRow{DmcType::upload_axis, "UPLOAD_AXIS", true, 9, any, 0},
    DmcTypeRow{DmcType::upload_dmx, "UPLOAD_DMX", true, 6, any, never},
    DmcTypeRow{DmcType::upload_end, "UPLOAD_END", true, 0, any, 0},
    DmcTypeRow{DmcType::upload_triggers, "UPLOAD_TRIGGERS", true, 4, any, 0},
    DmcTypeRow{DmcType::position_frame, "POSITION_FRAME", true, 4, 4, 0},
    DmcTypeRow{DmcType::run_move, "RUN_MOVE", true, 29, any, dmc_can::real_time},
    DmcTypeRow{DmcType::shoot_frame, "SHOOT_FRAME", true, 11, any, dmc_can::shoot_frame},
    DmcTypeRow{DmcType::go, "GO", true, 0, any, 0},
    DmcTypeRow{DmcType::end, "END", from_device, 0, any, 0},
    DmcTypeRow{DmcType::shoot_frame2, "SHOOT_FRAME2", true, 12, any, dmc_can::shoot_frame2},
    DmcTypeRow{DmcType::stop_loop, "STOP_LOOP", true, 0, any, dmc_can::loop},
    DmcTypeRow{DmcType::jog_all, "JOG_ALL", true, 8, 8, dmc_can::real_time},
    DmcTypeRow{DmcType::virtual_config, "VIRTUAL_CONFIG", true, 0, any, never},
    DmcTypeRow{DmcType::virtual_move, "VIRTUAL_MOVE", true, 0, any, never},
    DmcTypeRow{DmcType::virtual_stop, "VIRTUAL_STOP", true, 0, any, never},
    DmcTypeRow{DmcType::virtual_jog, "VIRTUAL_JOG", true, 0, any, never},
    DmcTypeRow{DmcType::virtual_positions, "VIRTUAL_POSITIONS", true, 0, any, never},
    DmcTypeRow{DmcType::virtual_jog_on_line, "VIRTUAL_JOG_ON_LINE", true, 0, any, never},
    DmcTypeRow{DmcType::virtual_aim_point, "VIRTUAL_AIM_POINT", true, 0, any, never},
};

/// Numbers one behind the other. A payload too short reads as 0 and is remembered.
class PayloadReader {
 public:
  explicit PayloadReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  std::uint8_t u8() { return static_cast<std::uint8_t>(number(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
  std::uint32_t u32() { return number(4); }
  std::int16_t i16() { return static_cast<std::int16_t>(u16()); }
  std::int32_t i32() { return static_cast<std::int32_t>(u32()); }
  [[nodiscard]] std::size_t left() const { return bytes_.size(); }

 private:
  std::uint32_t number(std::size_t count) {
    const std::size_t there = std::min(count, bytes_.size());
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < there; ++i) value |= std::uint32_t{bytes_[i]} << (8 * i);
    bytes_ = bytes_.subspan(there);
    return value;
  }

  std::span<const std::uint8_t> bytes_;
};

class PayloadWriter {
 public:
  PayloadWriter& u8(std::uint8_t value) { return number(value, 1); }
  PayloadWriter& u16(std::uint16_t value) { return number(value, 2); }
  PayloadWriter& u32(std::uint32_t value) { return number(value, 4); }
  PayloadWriter& i32(std::int32_t value) { return u32(static_cast<std::uint32_t>(value)); }
  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  PayloadWriter& number(std::uint32_t value, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
    return *this;
  }

  std::vector<std::uint8_t> bytes_;
};

DmcConfigure read_configure(PayloadReader& reader) {
  DmcConfigure message;
  message.motor = reader.u8();
  const std::uint8_t flags = reader.u8();
  message.is_enabled = (flags & 0x01) != 0;
  message.has_blur = (flags & 0x02) != 0;
  message.is_in_virtuals = (flags & 0x04) != 0;
  message.is_live = (flags & 0x08) != 0;
  message.couples = (flags & 0x30) != 0;
  message.is_reversed = (flags & 0x20) != 0;
  message.unknown_flags = flags & 0xC0;
  return message;
}

DmcSetLimits read_limits(PayloadReader& reader) {
  DmcSetLimits message;
  message.motor = reader.u8();
  const bool has_lower = reader.u8() != 0;
  const std::int32_t lower = reader.i32();
  const bool has_upper = reader.u8() != 0;
  const std::int32_t upper = reader.i32();
  if (has_lower) message.lower = lower;
  if (has_upper) message.upper = upper;
  const std::uint8_t set = reader.u8();
  message.hardware_set = set & 0x7F;
  message.hardware_swapped = (set & 0x80) != 0;
  return message;
}

std::optional<DmcRequest> read_axis(PayloadReader& reader) {
  if ((reader.left() - 5) % 4 != 0) return {};
  DmcUploadAxis message;
  message.motor = reader.u8();
  const std::uint32_t index = reader.u32();
  message.index = index & 0x7FFFFFFFU;
  message.is_last = (index >> 31U) != 0;
  while (reader.left() > 0) message.positions.push_back(reader.i32());
  return message;
}

std::optional<DmcRequest> read_triggers(PayloadReader& reader) {
  if ((reader.left() - 4) % 8 != 0) return {};
  DmcUploadTriggers message;
  message.mask = reader.u32();
  while (reader.left() > 0) {
    const std::uint32_t index = reader.u32();
    message.triggers.push_back({.index = index, .values = reader.u32()});
  }
  return message;
}

/// 29 bytes of older hosts, 31, or 35 with a stills camera. What lies between would move by numbers cut in
/// two.
std::optional<DmcRequest> read_run(PayloadReader& reader) {
  const std::size_t length = reader.left();
  DmcRunMove run;
  run.frames_per_1000_s = reader.u32();
  run.start = reader.i32();
  run.end = reader.i32();
  run.preroll_ms = reader.u32();
  run.postroll_ms = reader.u32();
  run.is_synced = reader.u8() != 0;
  run.bloop_bits = reader.u32();
  run.bloop_dmx = reader.u16();
  run.bloop_ms = reader.u16();
  const std::uint16_t flags = reader.u16();
  run.is_ping_pong = (flags & 0x0001) != 0;
  run.is_loop = (flags & 0x0002) != 0;
  run.has_video_camera = (flags & 0x0010) != 0;
  run.has_stills_camera = (flags & 0x0020) != 0;
  run.open_deg = reader.u16();
  run.close_deg = reader.u16();
  if (length == 30 || (run.has_stills_camera && length < 35)) return {};
  return run;
}

bool read_overrides(PayloadReader& reader, std::vector<DmcOverride>& overrides) {
  if (reader.left() % 9 != 0) return false;
  while (reader.left() > 0) {
    DmcOverride way;
    way.motor = reader.u8();
    way.from = reader.i32();
    way.to = reader.i32();
    overrides.push_back(way);
  }
  return true;
}

std::optional<DmcRequest> read_shoot_frame(PayloadReader& reader) {
  DmcShootFrame shot;
  shot.frame = reader.i32();
  shot.is_forward = reader.u8() != 0;
  shot.exposure_ms = reader.u32();
  shot.blur_permille = reader.u16();
  if (!read_overrides(reader, shot.overrides)) return {};
  return shot;
}

std::optional<DmcRequest> read_shoot_frame2(PayloadReader& reader) {
  DmcShootFrame2 shot;
  shot.frame = reader.i32();
  shot.exposure_ms = reader.u32();
  shot.open_deg = reader.i16();
  shot.close_deg = reader.i16();
  if (!read_overrides(reader, shot.overrides)) return {};
  return shot;
}

template <class T>
T motor_and_position(PayloadReader& reader) {
  const std::uint8_t motor = reader.u8();
  return {motor, reader.i32()};
}

DmcJog read_jog(PayloadReader& reader) {
  DmcJog jog;
  jog.motor = reader.u8();
  jog.speed = reader.u16();
  jog.destination = reader.i32();
  return jog;
}

DmcSetSpeed read_speed(PayloadReader& reader) {
  DmcSetSpeed speed;
  speed.motor = reader.u8();
  speed.max_velocity = reader.u32();
  speed.max_acceleration = reader.u32();
  return speed;
}

std::optional<DmcRequest> read_known(DmcType type, PayloadReader& reader) {
  switch (type) {
    case DmcType::gio_out:
      return DmcGioOut{reader.u32()};
    case DmcType::gio_cam: {
      const std::uint32_t bits = reader.u32();
      return DmcGioCam{.shutter = (bits & 1U) != 0, .meter = (bits & 2U) != 0};
    }
    case DmcType::move:
      return motor_and_position<DmcMove>(reader);
    case DmcType::stop:
      return DmcStop{reader.u8()};
    case DmcType::stop_all:
      return DmcStopAll{(reader.u32() & 1U) != 0};
    case DmcType::reset_position:
      return motor_and_position<DmcResetPosition>(reader);
    case DmcType::jog:
      return read_jog(reader);
    case DmcType::configure:
      return read_configure(reader);
    case DmcType::set_speed:
      return read_speed(reader);
    case DmcType::set_limits:
      return read_limits(reader);
    case DmcType::upload_begin: {
      const std::int32_t start = reader.i32();
      return DmcUploadBegin{.start = start, .end = reader.i32()};
    }
    case DmcType::upload_axis:
      return read_axis(reader);
    case DmcType::upload_triggers:
      return read_triggers(reader);
    case DmcType::position_frame:
      return DmcPositionFrame{reader.i32()};
    case DmcType::run_move:
      return read_run(reader);
    case DmcType::shoot_frame:
      return read_shoot_frame(reader);
    case DmcType::shoot_frame2:
      return read_shoot_frame2(reader);
    case DmcType::jog_all: {
      const std::uint32_t fps = reader.u32();
      return DmcJogAll{.frames_per_1000_s = fps, .frame = reader.i32()};
    }
    default:
      return DmcPlain{type};
  }
}

}  // namespace

std::span<const DmcTypeRow> dmc_type_table() {
  return type_rows;
}

const DmcTypeRow* dmc_type_row(std::uint16_t type) {
  const auto* const row = std::find_if(type_rows.begin(), type_rows.end(), [&](const DmcTypeRow& candidate) {
    return static_cast<std::uint16_t>(candidate.type) == type;
  });
  return row == type_rows.end() ? nullptr : row;
}

std::optional<DmcRequest> read_dmc_request(const DmcTypeRow& row, std::span<const std::uint8_t> payload) {
  if (payload.size() < row.min_bytes || payload.size() > row.max_bytes) return {};
  PayloadReader reader(payload);
  return read_known(row.type, reader);
}

std::vector<std::uint8_t> write_dmc_hi(const DmcHi& hi) {
  PayloadWriter writer;
  for (std::size_t i = 0; i < 32; ++i) {
    const bool is_told = i < 31 && i < hi.name.size();
    writer.u8(is_told ? static_cast<std::uint8_t>(hi.name[i]) : std::uint8_t{0});
  }
  constexpr std::uint16_t protocol_version = 2;
  return writer.u8(hi.major)
      .u8(hi.minor)
      .u8(hi.revision)
      .u8(hi.motors)
      .u16(hi.dmx_channels)
      .u8(hi.outputs)
      .u8(hi.inputs)
      .u8(hi.hardware_limit_sets)
      .u32(hi.frame_capacity)
      .u32(hi.capabilities)
      .u16(protocol_version)
      .take();
}

std::vector<std::uint8_t> write_dmc_code(DmcCode code) {
  return PayloadWriter().u32(static_cast<std::uint32_t>(code)).take();
}

std::vector<std::uint8_t> write_dmc_status(std::uint32_t moving) {
  return PayloadWriter().u32(moving).u8(0).take();
}

std::vector<std::uint8_t> write_dmc_positions(std::int32_t move_time,
                                              std::span<const std::int32_t> positions) {
  PayloadWriter writer;
  writer.i32(move_time);
  for (const std::int32_t position : positions) writer.i32(position);
  return writer.take();
}

std::vector<std::uint8_t> write_dmc_inputs(std::uint32_t bits) {
  return PayloadWriter().u32(bits).take();
}

std::vector<std::uint8_t> write_dmc_hard_stop(std::uint8_t reason, std::uint8_t motor) {
  PayloadWriter writer;
  writer.u8(reason);
  if (motor != 0) writer.u8(motor);
  return writer.take();
}

}  // namespace inbetween::dragonframe
