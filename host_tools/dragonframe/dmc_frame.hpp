// Frames of Dragonframe's DMC protocol, version 2: found in a stream of bytes, and written. All numbers are
// little-endian:
//
//   0  "DF"            2  id, u32       6  type, u16      8  payload length N, u16
//   10 payload         10 + N           two check bytes: Fletcher-16, modulus 255, over all that stands
//   before
//
// Nothing is escaped: "DF" may stand in a payload.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace inbetween::dragonframe {

inline constexpr std::size_t dmc_header_bytes = 10;
inline constexpr std::size_t dmc_check_bytes = 2;
/// The maker's parser holds 2048 bytes, and drops a header that announces more.
inline constexpr std::size_t max_dmc_payload_bytes = 2036;
inline constexpr std::size_t max_dmc_frame_bytes = dmc_header_bytes + max_dmc_payload_bytes + dmc_check_bytes;
/// Set in the type of an acknowledgement.
inline constexpr std::uint16_t dmc_ack_bit = 0x8000;

struct DmcFrame {
  std::uint32_t id = 0;  ///< chosen by who asks, repeated in the answer; 0 where nobody asked
  std::uint16_t type = 0;
  std::span<const std::uint8_t> payload;
  bool is_intact = true;  ///< whether its check bytes fit: nothing else of a damaged frame is to be believed
};

/// The two check bytes over a header and its payload.
[[nodiscard]] std::array<std::uint8_t, 2> dmc_check(std::span<const std::uint8_t> bytes);

/// Appends the frame. A payload above max_dmc_payload_bytes throws std::length_error: a defect of the caller.
void append_dmc_frame(const DmcFrame& frame, std::vector<std::uint8_t>& bytes);

/// What was heard and thrown away; each number only grows.
struct DmcDecoderCounters {
  std::uint64_t frames = 0;         ///< intact
  std::uint64_t damaged = 0;        ///< frames whose check bytes are wrong
  std::uint64_t skipped_bytes = 0;  ///< that belong to no frame
  std::uint64_t abandoned = 0;      ///< frames that began and were given up
};

/// Bytes in, whole frames out, in a fixed memory of one frame. A frame that is damaged or given up loses its
/// first byte alone, and the search goes on behind that: a frame that follows a lost byte is still found. The
/// maker's parser loses it.
class DmcDecoder {
 public:
  /// Takes bytes from the front of `bytes` until a frame is whole, and returns it. Nothing: all are taken.
  /// What the frame shows is kept until the next call. Damaged frames are returned too, as they are to be
  /// answered. Cost: 2048 steps a byte at worst, where every byte begins a damaged frame.
  std::optional<DmcFrame> next(std::span<const std::uint8_t>& bytes);

  /// Whether a frame has begun and is not whole.
  [[nodiscard]] bool has_half() const { return size_ > consumed_; }

  /// Takes the half frame for one that will never be whole. Frames inside it are found by next().
  void give_up();

  /// Forgets the half frame: its sender is gone.
  void clear();

  [[nodiscard]] const DmcDecoderCounters& counters() const { return counters_; }

 private:
  void drop(std::size_t count);
  void hunt();
  [[nodiscard]] std::size_t frame_bytes() const;

  std::array<std::uint8_t, max_dmc_frame_bytes> buffer_{};
  std::size_t size_ = 0;
  std::size_t consumed_ = 0;  ///< in front: the frame that was returned last
  bool was_damaged_ = false;
  DmcDecoderCounters counters_;
};

}  // namespace inbetween::dragonframe
