// Any bytes are ticks of a take, or are refused in words; with a good check sum too, which no fuzzer finds by
// itself. What is read is written and read again as it was. And any bytes are a motion or none.
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host_tools/takes/byte_text.hpp"
#include "host_tools/takes/taken_motion.hpp"
#include "host_tools/takes/tick_codec.hpp"
#include "tests/fuzz/targets/fuzz_require.hpp"

namespace inbetween {
namespace {

TickShape two_axes() {
  return {.axes = {{.name = "x", .unit = "mm", .resolution = 0.001},
                   {.name = "y", .unit = "deg", .resolution = 0.1}},
          .motion = nullptr,
          .frame_rate = {24, 1},
          .rate_hz = 250};
}

std::string with_sum(std::string_view body) {
  ByteWriter sum;
  sum.fixed(sum_of(body));
  return std::string(body) + sum.text();
}

bool are_same(const TakeTick& one, const TakeTick& other) {
  if (one.number != other.number || one.state != other.state || one.turn != other.turn ||
      one.time.has_value() != other.time.has_value() || one.told.size() != other.told.size())
    return false;
  for (std::size_t a = 0; a < one.told.size(); ++a) {
    if (std::bit_cast<std::uint64_t>(one.told[a]) != std::bit_cast<std::uint64_t>(other.told[a]))
      return false;
  }
  return !one.time || *one.time == *other.time;
}

void require_ticks(std::string_view bytes) {
  const TickShape shape = two_axes();
  std::vector<TakeTick> ticks;
  const std::string wrong = decode_ticks(bytes, shape, [&](const TakeTick& tick) {
    fuzz_require(!tick.time || (tick.time->fraction >= 0 && tick.time->fraction < 1),
                 "a place has a part of a frame");
    fuzz_require(tick.actual.size() == 2, "every axis is somewhere");
    ticks.push_back(tick);
    return true;
  });
  fuzz_require(wrong.find('\n') == wrong.npos, "a refusal is one line");
  if (!wrong.empty() || ticks.empty()) return;
  TickEncoder encoder(shape);
  for (const TakeTick& tick : ticks) encoder.add(tick);
  std::size_t next = 0;
  const std::string again = decode_ticks(encoder.take_chunk(), shape, [&](const TakeTick& tick) {
    fuzz_require(are_same(tick, ticks[next++]), "what was read is read again");
    return true;
  });
  fuzz_require(again.empty() && next == ticks.size(), "what is written is read");
}

}  // namespace
}  // namespace inbetween

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  inbetween::require_ticks(text);
  inbetween::require_ticks(inbetween::with_sum(text));
  const auto motion = inbetween::TakenMotion::read(text);
  if (motion) fuzz_require(!inbetween::bytes_of(motion->motion()).empty(), "a motion is written");
  return 0;
}
