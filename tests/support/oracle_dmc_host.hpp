// The host's side of the DMC protocol, written from its description alone: it shares nothing with the device.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace inbetween::oracle {

using DmcBytes = std::vector<std::uint8_t>;

/// What a device sent.
struct DmcHeard {
  std::uint32_t id = 0;
  unsigned type = 0;
  DmcBytes payload;

  /// Little-endian, `count` bytes from `offset`; the test fails by std::out_of_range where there are none.
  [[nodiscard]] std::uint32_t number(std::size_t offset, std::size_t count) const;
  [[nodiscard]] std::int32_t position(std::size_t motor) const;  ///< of a message 0x0034
};

/// A whole frame.
DmcBytes dmc_message(unsigned type, std::uint32_t id, const DmcBytes& payload);

class DmcPayload {
 public:
  /// The `count` low bytes of the number.
  DmcPayload& add(std::int64_t number, std::size_t count);
  [[nodiscard]] const DmcBytes& bytes() const { return bytes_; }

 private:
  DmcBytes bytes_;
};

struct DmcRunScript {
  std::uint32_t fps_1000 = 24'000;
  std::int32_t start = 1;
  std::int32_t end = 1;
  std::uint32_t preroll_ms = 1000;
  std::uint32_t postroll_ms = 1000;
  bool is_synced = false;
  std::uint32_t bloop_bits = 0;
  unsigned bloop_ms = 0;
  unsigned flags = 0;
  std::optional<std::pair<unsigned, unsigned>> shutter_deg{};
};

struct DmcWayScript {
  unsigned motor = 0;
  std::int32_t from = 0;
  std::int32_t to = 0;
};

/// Writes requests, each with an identifier of its own, and reads what comes back.
class DmcHost {
 public:
  /// The identifier of the next request; it counts on from there.
  void next_id(std::uint32_t id) { id_ = id; }
  [[nodiscard]] std::uint32_t last_id() const { return id_ - 1; }

  DmcBytes ask(unsigned type, const DmcBytes& payload = {});
  DmcBytes hi() { return ask(0x0001); }
  DmcBytes status() { return ask(0x0030); }
  DmcBytes positions() { return ask(0x0034); }
  DmcBytes move(unsigned motor, std::int32_t target);
  DmcBytes stop(unsigned motor);
  DmcBytes stop_all(std::optional<std::uint32_t> flags = {});
  DmcBytes reset(unsigned motor, std::int32_t position);
  DmcBytes jog(unsigned motor, unsigned speed, std::int32_t destination);
  DmcBytes configure(unsigned motor, unsigned flags);
  DmcBytes speed(unsigned motor, std::uint32_t velocity, std::uint32_t acceleration);
  DmcBytes limits(unsigned motor, std::optional<std::int32_t> lower, std::optional<std::int32_t> upper);
  DmcBytes upload_begin(std::int32_t start, std::int32_t end);
  DmcBytes upload_axis(unsigned motor, std::uint32_t index, bool is_last,
                       const std::vector<std::int32_t>& positions);
  DmcBytes upload_triggers(std::uint32_t mask,
                           const std::vector<std::pair<std::uint32_t, std::uint32_t>>& triggers);
  DmcBytes upload_end() { return ask(0x0103); }
  DmcBytes position_frame(std::int32_t frame);
  DmcBytes run(const DmcRunScript& script);
  DmcBytes shoot(std::int32_t frame, bool forward, std::uint32_t exposure_ms, unsigned blur_permille,
                 const std::vector<DmcWayScript>& ways = {});
  DmcBytes shoot2(std::int32_t frame, std::uint32_t exposure_ms, std::pair<int, int> shutter_deg,
                  const std::vector<DmcWayScript>& ways = {});
  DmcBytes go() { return ask(0x0113); }
  DmcBytes stop_loop() { return ask(0x0116); }
  DmcBytes jog_all(std::uint32_t fps_1000, std::int32_t frame);

  /// Throws std::runtime_error at the first byte that is not one of a whole, intact frame.
  void hear(const DmcBytes& bytes);
  /// Everything since the last call, in order.
  std::vector<DmcHeard> take_heard();
  /// The code of the acknowledgement of the last request, in two or in four bytes. 0: there is none.
  [[nodiscard]] unsigned code() const;
  /// The data that answer the last request.
  [[nodiscard]] std::optional<DmcHeard> data() const;
  /// How many messages answer the last request.
  [[nodiscard]] std::size_t answers() const;

 private:
  std::uint32_t id_ = 1;
  DmcBytes half_;
  std::vector<DmcHeard> heard_;
  std::vector<DmcHeard> answers_;
};

}  // namespace inbetween::oracle
