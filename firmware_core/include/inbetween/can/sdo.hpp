#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "inbetween/can/frame.hpp"

/// The messages by which the objects of a device are read and written, CiA 301 section 7.2.4.3. A client
/// sends requests, the device that has the objects sends answers; the same command byte means different
/// things in the two directions. Block transfer is not spoken.

namespace inbetween::can {

/// The address of an object in the dictionary of a device.
struct ObjectAddress {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  friend bool operator==(const ObjectAddress&, const ObjectAddress&) = default;
};

enum class SdoKind : std::uint8_t {
  // of a client
  download,           ///< writes 1 to 4 bytes: object, size, value
  announce_download,  ///< will write `value` bytes in segments: object
  download_segment,   ///< toggle, is_last, size, segment
  upload,             ///< asks for an object
  ask_segment,        ///< toggle
  // of a device
  download_done,          ///< object
  download_segment_done,  ///< toggle
  upload_value,           ///< 1 to 4 bytes: object, size, value
  announce_upload,        ///< will send `value` bytes in segments: object
  upload_segment,         ///< toggle, is_last, size, segment
  // of either
  abort,  ///< `value` is the reason: object
};

struct SdoMessage {
  SdoKind kind = SdoKind::abort;
  ObjectAddress object{};
  std::uint8_t size = 0;  ///< bytes of value or segment that count; 0 with a value: not told
  std::uint32_t value = 0;
  bool toggle = false;
  bool is_last = false;
  std::array<std::uint8_t, 7> segment{};
  friend bool operator==(const SdoMessage&, const SdoMessage&) = default;
};

/// `id` is sdo_request_id or sdo_answer_id of the device.
Frame sdo_frame(FrameId id, const SdoMessage& message);
/// Reads what a client says in a frame of the right identifier. Nothing where it has not eight bytes or
/// an unknown command. Bytes that the standard reserves are not looked at.
std::optional<SdoMessage> read_sdo_request(const Frame& frame);
/// The same for what a device says.
std::optional<SdoMessage> read_sdo_answer(const Frame& frame);

/// Reasons of an abort that this project gives or looks for; words_of_abort knows all of CiA 301.
inline constexpr std::uint32_t abort_toggle = 0x05030000;
inline constexpr std::uint32_t abort_timeout = 0x05040000;
inline constexpr std::uint32_t abort_unknown_command = 0x05040001;
inline constexpr std::uint32_t abort_out_of_memory = 0x05040005;
inline constexpr std::uint32_t abort_unsupported_access = 0x06010000;
inline constexpr std::uint32_t abort_write_only = 0x06010001;
inline constexpr std::uint32_t abort_read_only = 0x06010002;
inline constexpr std::uint32_t abort_no_object = 0x06020000;
inline constexpr std::uint32_t abort_not_mappable = 0x06040041;
inline constexpr std::uint32_t abort_pdo_too_long = 0x06040042;
inline constexpr std::uint32_t abort_wrong_length = 0x06070010;
inline constexpr std::uint32_t abort_no_sub_index = 0x06090011;
inline constexpr std::uint32_t abort_bad_value = 0x06090030;
inline constexpr std::uint32_t abort_too_high = 0x06090031;
inline constexpr std::uint32_t abort_too_low = 0x06090032;
inline constexpr std::uint32_t abort_device_state = 0x08000022;

/// The reason in words: "the object can only be read".
const char* words_of_abort(std::uint32_t code);

}  // namespace inbetween::can
