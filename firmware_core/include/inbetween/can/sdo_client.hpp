#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

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
  answer,    ///< the answer that was waited for
  refusal,   ///< an abort of the device for the object that was asked for
  nonsense,  ///< an answer for the object that is none to the request, or in segments
  other,     ///< a frame that cannot be read, or an answer for another object (after its deadline)
};
inline constexpr std::size_t sdo_events = 7;

/// The whole table; a state that stays the same with `begin` has refused it.
SdoState next_state(SdoState state, SdoEvent event);

/// Reads and writes objects of up to four bytes, one at a time. A request that is not answered within the
/// timeout ends with abort 05040000, an answer in segments or of another size with 05040001: the objects
/// that set up a drive need neither.
class SdoClient {
 public:
  /// `timeout_ns`: 500 to 1000 ms are usual, a drive that writes to flash takes its time.
  constexpr SdoClient(NodeId node, std::int64_t timeout_ns) : node_(node), timeout_ns_(timeout_ns) {}

  /// `size` 1 to 4 bytes. False while another transfer goes on.
  bool begin_upload(ObjectAddress object, std::uint8_t size);
  bool begin_download(ObjectAddress object, std::uint8_t size, std::uint32_t value);
  /// At most one frame.
  std::optional<Frame> poll(std::int64_t now_ns);
  /// A frame with the identifier of this device's answers. False: not what was waited for.
  bool receive(const Frame& frame);
  /// Forgets everything, without a word to the device.
  void reset() { state_ = SdoState::idle; }

  [[nodiscard]] SdoState state() const { return state_; }
  [[nodiscard]] ObjectAddress object() const { return request_.object; }
  /// The data that an upload has read, without the bytes that do not count.
  [[nodiscard]] std::uint32_t value() const { return value_; }
  [[nodiscard]] std::uint32_t abort_code() const { return abort_code_; }

 private:
  bool begin(const SdoMessage& request, std::uint8_t size);
  [[nodiscard]] SdoEvent event_of(const std::optional<SdoMessage>& answer) const;

  NodeId node_;
  std::int64_t timeout_ns_;
  SdoState state_ = SdoState::idle;
  SdoMessage request_;
  std::uint8_t size_ = 0;
  std::uint32_t value_ = 0;
  std::uint32_t abort_code_ = 0;
  std::int64_t deadline_ns_ = 0;
};

}  // namespace inbetween::can
