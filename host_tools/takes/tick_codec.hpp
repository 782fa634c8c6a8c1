// The ticks of a take as bytes, in chunks that are read each by itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/takes/take.hpp"
#include "inbetween/limits/played_motion.hpp"

namespace inbetween {

/// What both sides know of a take.
struct TickShape {
  std::vector<TakeAxis> axes;
  const PlayedMotion* motion = nullptr;  ///< that is played; null: none is
  FrameRate frame_rate = {};
  std::int32_t rate_hz = 1;
};

class KnownTicks;  // of the source: what a chunk has told so far

/// Makes chunks. In a chunk each tick has what differs from what was to be expected after the two before it:
/// the playhead moved on at its rate, setpoints are those of the motion at its place or the last ones, an
/// axis goes on as fast as it went. Numbers are told by how many doubles they are off, so that every one of
/// them comes back to the last bit, but for actual positions, which are whole numbers of TakeAxis::resolution
/// from the first of the chunk, and to the last bit where they are that up to rounding.
///
/// Method: second differences as whole numbers of 7 bits a byte (LEB128, zigzag), flags before them, and at
/// the end a check sum (FNV-1a). A tick that goes on steadily takes 2 to 3 bytes and one for each axis that
/// moves. Allocates for the chunk only.
class TickEncoder {
 public:
  explicit TickEncoder(TickShape shape);
  ~TickEncoder();
  TickEncoder(const TickEncoder&) = delete;
  TickEncoder& operator=(const TickEncoder&) = delete;

  /// Ticks come with ascending numbers.
  void add(const TakeTick& tick);
  [[nodiscard]] std::int64_t ticks() const { return ticks_; }
  [[nodiscard]] std::int64_t first() const { return first_; }
  /// Ends the chunk and begins the next.
  std::string take_chunk();

 private:
  TickShape shape_;
  std::unique_ptr<KnownTicks> known_;
  std::string text_;
  std::int64_t ticks_ = 0;
  std::int64_t first_ = 0;
};

/// Gives each tick of a chunk to `take`, until it returns false. Returns what is wrong with the chunk, in
/// words without an end; "" for nothing. Any bytes are a chunk or wrong.
std::string decode_ticks(std::string_view chunk, const TickShape& shape,
                         const std::function<bool(const TakeTick&)>& take);

}  // namespace inbetween
