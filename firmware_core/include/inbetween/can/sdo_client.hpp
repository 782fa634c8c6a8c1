#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/can/canopen_id.hpp"
#include "inbetween/can/frame.hpp"
#include "inbetween/can/sdo.hpp"

namespace inbetween::can {

enum class SdoState : std::uint8_t {
  idle,
  queued,    ///< the request goes out with the next poll
  waiting,   ///< for the answer
  aborting,  ///< no answer in time or a senseless one: the device is told with the next poll
  done,
  failed,  ///< abort_code() says why
};
inline constexpr std::size_t sdo_states = 6;

enum class SdoEvent : std::uint8_t {
  begin,     ///< a transfer is wanted
  poll,      ///< a frame may be sent
  deadline,  ///< the answer has not come in time
  answer,    ///< the answer that was waited for, and the last
  more,      ///< the answer that was waited for, after which another segment is asked for or sent
  refusal,   ///< an abort of the device for the object that was asked for
  nonsense,  ///< an answer for the object that is none to the request, or a value that has no room
  other,     ///< a frame that cannot be read, an answer for another object, or one that comes twice or late
};
inline constexpr std::size_t sdo_events = 8;

/// The whole table; a state that stays the same with `begin` has refused it.
SdoState next_state(SdoState state, SdoEvent event);

/// Reads and writes objects, one at a time: expedited where they have one to four bytes, otherwise in
/// segments; a device may also answer in segments where four bytes would do. The device is told why a
/// transfer ends: 05040000 where a request is not answered within the timeout, 05030000 where a segment has
/// the wrong toggle, 05040005 where the value has no room, 06070010 where its length is wrong, 05040001
/// otherwise.
class SdoClient {
 public:
  /// `timeout_ns`: 500 to 1000 ms are usual, a drive that writes to flash takes its time. For each request.
  constexpr SdoClient(NodeId node, std::int64_t timeout_ns) : node_(node), timeout_ns_(timeout_ns) {}

  /// A number of `size` 1 to 4 bytes. A device may tell it with more bytes, up to 4, if it fits: with zeros
  /// above it, or extended by its sign. False while another transfer goes on.
  bool begin_upload(ObjectAddress object, std::uint8_t size);
  bool begin_download(ObjectAddress object, std::uint8_t size, std::uint32_t value);
  /// Bytes, at least one. The memory stays the caller's, and is used until the transfer has ended. An object
  /// that is longer than `storage` ends with 05040005.
  bool begin_upload(ObjectAddress object, std::span<std::uint8_t> storage);
  bool begin_download(ObjectAddress object, std::span<const std::uint8_t> bytes);
  /// At most one frame.
  std::optional<Frame> poll(std::int64_t now_ns);
  /// A frame with the identifier of this device's answers. False: not what was waited for.
  bool receive(const Frame& frame);
  /// Forgets everything, without a word to the device.
  void reset() { state_ = SdoState::idle; }

  [[nodiscard]] SdoState state() const { return state_; }
  [[nodiscard]] ObjectAddress object() const { return object_; }
  /// The number that an upload has read. Bytes beyond the size that was asked for are left out.
  [[nodiscard]] std::uint32_t value() const { return value_; }
  /// How many bytes an upload has read.
  [[nodiscard]] std::size_t length() const { return length_; }
  [[nodiscard]] std::uint32_t abort_code() const { return abort_code_; }
  /// Whether the client itself has ended the transfer, and not the device.
  [[nodiscard]] bool has_given_up() const { return has_given_up_; }

 private:
  bool begin(const SdoMessage& request, std::uint8_t size);
  SdoEvent give_up(std::uint32_t abort_code);
  SdoEvent take(const SdoMessage& answer);
  SdoEvent take_value(const SdoMessage& answer);
  SdoEvent take_announcement(const SdoMessage& answer);
  SdoEvent take_segment(const SdoMessage& answer);
  SdoEvent has_read_all();
  SdoEvent ask_next_segment(bool toggle);
  SdoEvent send_next_segment(bool toggle);
  [[nodiscard]] std::size_t room() const { return storage_.empty() ? number_.size() : storage_.size(); }
  bool append(const std::uint8_t* bytes, std::size_t count);

  NodeId node_;
  std::int64_t timeout_ns_;
  SdoState state_ = SdoState::idle;
  SdoMessage request_;
  ObjectAddress object_;
  Frame last_;                             ///< the answer that was taken last
  std::span<std::uint8_t> storage_;        ///< of an upload of bytes
  std::span<const std::uint8_t> to_send_;  ///< of a download of bytes, without those that were sent
  std::array<std::uint8_t, 4> number_{};   ///< of an upload of a number
  std::uint8_t size_ = 0;                  ///< of a number; 0: bytes
  bool has_given_up_ = false;
  std::uint32_t announced_ = 0;
  std::size_t length_ = 0;
  std::uint32_t value_ = 0;
  std::uint32_t abort_code_ = 0;
  std::int64_t deadline_ns_ = 0;
};

}  // namespace inbetween::can
