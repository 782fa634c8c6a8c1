#include "inbetween/can/sdo.hpp"

#include <algorithm>

#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/little_endian.hpp"
#include "words.hpp"

namespace inbetween::can {
namespace {

/// The three highest bits of the command byte.
enum class Command : std::uint8_t {
  segment_of_client = 0,
  download = 1,
  upload = 2,
  ask_segment = 3,
  abort = 4,
};
enum class Reply : std::uint8_t {
  segment_of_device = 0,
  segment_done = 1,
  upload = 2,
  download_done = 3,
  abort = 4,
};

constexpr std::uint8_t expedited = 0x02;
constexpr std::uint8_t size_told = 0x01;
constexpr std::uint8_t toggle_bit = 0x10;

template <class Kind>
constexpr std::uint8_t first_bits(Kind kind) {
  return static_cast<std::uint8_t>(static_cast<unsigned>(kind) << 5);
}
constexpr std::uint8_t bits_of_value(std::uint8_t size) {
  if (size == 0) return expedited;
  return static_cast<std::uint8_t>(((4U - size) << 2) | expedited | size_told);
}
constexpr std::uint8_t bits_of_segment(const SdoMessage& message) {
  const unsigned unused = 7U - std::min<unsigned>(message.size, 7);
  return static_cast<std::uint8_t>((message.toggle ? toggle_bit : 0U) | (unused << 1) |
                                   (message.is_last ? 1U : 0U));
}

std::uint8_t command_byte(const SdoMessage& message) {
  const std::uint8_t toggle = message.toggle ? toggle_bit : std::uint8_t{0};
  switch (message.kind) {
    case SdoKind::download:
      return first_bits(Command::download) | bits_of_value(message.size);
    case SdoKind::announce_download:
      return first_bits(Command::download) | size_told;
    case SdoKind::download_segment:
      return first_bits(Command::segment_of_client) | bits_of_segment(message);
    case SdoKind::upload:
      return first_bits(Command::upload);
    case SdoKind::ask_segment:
      return first_bits(Command::ask_segment) | toggle;
    case SdoKind::download_done:
      return first_bits(Reply::download_done);
    case SdoKind::download_segment_done:
      return first_bits(Reply::segment_done) | toggle;
    case SdoKind::upload_value:
      return first_bits(Reply::upload) | bits_of_value(message.size);
    case SdoKind::announce_upload:
      return first_bits(Reply::upload) | size_told;
    case SdoKind::upload_segment:
      return first_bits(Reply::segment_of_device) | bits_of_segment(message);
    case SdoKind::abort:
      break;
  }
  return first_bits(Command::abort);
}

constexpr bool is_segment(SdoKind kind) {
  return kind == SdoKind::download_segment || kind == SdoKind::upload_segment;
}
constexpr bool has_object(SdoKind kind) {
  return !is_segment(kind) && kind != SdoKind::ask_segment && kind != SdoKind::download_segment_done;
}

SdoMessage read_segment(SdoKind kind, const Frame& frame) {
  SdoMessage message{.kind = kind,
                     .size = static_cast<std::uint8_t>(7 - ((frame.data[0] >> 1) & 7)),
                     .toggle = (frame.data[0] & toggle_bit) != 0,
                     .is_last = (frame.data[0] & 1) != 0};
  std::copy_n(frame.data.begin() + 1, message.size, message.segment.begin());
  return message;
}

SdoMessage read_object(SdoKind kind, const Frame& frame) {
  return {.kind = kind,
          .object = {.index = load<std::uint16_t>(frame.data, 1), .sub = frame.data[3]},
          .value = load<std::uint32_t>(frame.data, 4)};
}

/// A transfer that begins: with the value itself, or with the announcement of segments.
std::optional<SdoMessage> read_begin(SdoKind with_value, SdoKind announced, const Frame& frame) {
  const std::uint8_t command = frame.data[0];
  if ((command & expedited) == 0) {
    if ((command & size_told) == 0) return {};
    return read_object(announced, frame);
  }
  SdoMessage message = read_object(with_value, frame);
  if ((command & size_told) == 0) return message;
  message.size = static_cast<std::uint8_t>(4 - ((command >> 2) & 3));
  message.value &= 0xFFFFFFFFU >> (8U * (4U - message.size));
  return message;
}

SdoMessage read_toggle(SdoKind kind, const Frame& frame) {
  return {.kind = kind, .toggle = (frame.data[0] & toggle_bit) != 0};
}

SdoMessage read_without_value(SdoKind kind, const Frame& frame) {
  SdoMessage message = read_object(kind, frame);
  message.value = 0;
  return message;
}

// CiA 301, table 22.
constexpr std::array codes{
    Words{0x05030000, "the toggle bit did not alternate"},
    Words{0x05040000, "no answer in time"},
    Words{0x05040001, "the command is not known"},
    Words{0x05040002, "the block size is not valid"},
    Words{0x05040003, "the sequence number is not valid"},
    Words{0x05040004, "the checksum of a block is wrong"},
    Words{0x05040005, "the device is out of memory"},
    Words{0x06010000, "the object cannot be accessed this way"},
    Words{0x06010001, "the object can only be written"},
    Words{0x06010002, "the object can only be read"},
    Words{0x06020000, "the device has no such object"},
    Words{0x06040041, "the object cannot be mapped into a PDO"},
    Words{0x06040042, "the objects to be mapped are longer than the PDO"},
    Words{0x06040043, "the parameters do not go together"},
    Words{0x06040047, "the device is not compatible with itself"},
    Words{0x06060000, "the hardware of the device failed"},
    Words{0x06070010, "the value has another length"},
    Words{0x06070012, "the value is too long"},
    Words{0x06070013, "the value is too short"},
    Words{0x06090011, "the object has no such sub-index"},
    Words{0x06090030, "the value is not allowed"},
    Words{0x06090031, "the value is too high"},
    Words{0x06090032, "the value is too low"},
    Words{0x06090036, "the maximum is less than the minimum"},
    Words{0x060A0023, "a resource is not available"},
    Words{0x08000000, "an error that the device does not name"},
    Words{0x08000020, "the value cannot be stored"},
    Words{0x08000021, "the value cannot be stored because the device is under local control"},
    Words{0x08000022, "the value cannot be stored in the present state of the device"},
    Words{0x08000023, "the object dictionary could not be made or is missing"},
    Words{0x08000024, "there are no data"},
};

}  // namespace

Frame sdo_frame(FrameId id, const SdoMessage& message) {
  Frame frame{.id = id, .length = 8};
  frame.data[0] = command_byte(message);
  if (is_segment(message.kind)) {
    std::copy_n(message.segment.begin(), std::min<unsigned>(message.size, 7), frame.data.begin() + 1);
  } else if (has_object(message.kind)) {
    store(frame.data, 1, message.object.index);
    frame.data[3] = message.object.sub;
    store(frame.data, 4, message.value);
  }
  return frame;
}

std::optional<SdoMessage> read_sdo_request(const Frame& frame) {
  if (!is_canopen(frame) || frame.length != 8) return {};
  switch (static_cast<Command>(frame.data[0] >> 5)) {
    case Command::segment_of_client:
      return read_segment(SdoKind::download_segment, frame);
    case Command::download:
      return read_begin(SdoKind::download, SdoKind::announce_download, frame);
    case Command::upload:
      return read_without_value(SdoKind::upload, frame);
    case Command::ask_segment:
      return read_toggle(SdoKind::ask_segment, frame);
    case Command::abort:
      return read_object(SdoKind::abort, frame);
  }
  return {};
}

std::optional<SdoMessage> read_sdo_answer(const Frame& frame) {
  if (!is_canopen(frame) || frame.length != 8) return {};
  switch (static_cast<Reply>(frame.data[0] >> 5)) {
    case Reply::segment_of_device:
      return read_segment(SdoKind::upload_segment, frame);
    case Reply::segment_done:
      return read_toggle(SdoKind::download_segment_done, frame);
    case Reply::upload:
      return read_begin(SdoKind::upload_value, SdoKind::announce_upload, frame);
    case Reply::download_done:
      return read_without_value(SdoKind::download_done, frame);
    case Reply::abort:
      return read_object(SdoKind::abort, frame);
  }
  return {};
}

const char* words_of_abort(std::uint32_t code) {
  return words_in(codes, code, "a reason that CiA 301 does not name");
}

}  // namespace inbetween::can
