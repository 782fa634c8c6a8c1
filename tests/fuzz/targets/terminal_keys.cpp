// Whatever a terminal sends, nothing is held for longer than it is heard of, and nobody goes to a place that
// was not typed and asked for.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "host_tools/loop/key_hold.hpp"
#include "host_tools/loop/transport_keys.hpp"
#include "host_tools/motions/place_entry.hpp"
#include "tests/fuzz/targets/fuzz_require.hpp"

namespace inbetween {
namespace {

/// The keys as a run takes them.
struct Desk {
  TransportKeys keys;
  KeyHold arrow;
  PlaceEntry entry;
  std::int64_t now_ns = 0;

  void press(TransportKey key) {
    const bool was_typing = entry.shown().has_value();
    const bool had_number = was_typing && entry.shown()->number.has_value();
    static_cast<void>(entry.press(key));
    if (const auto place = entry.take()) {
      fuzz_require(had_number && key == TransportKey::start, "a place was typed, and asked for with Enter");
      fuzz_require(place->number >= 0 && place->number < 1'000'000'000, "a number is the one that was typed");
    }
    switch (key) {
      case TransportKey::tells_releases:
        return arrow.tells_releases();
      case TransportKey::step_forward:
      case TransportKey::step_backward:
        return arrow.press(direction_of(key), now_ns);
      case TransportKey::repeat_forward:
      case TransportKey::repeat_backward:
        return arrow.repeat(direction_of(key), now_ns);
      case TransportKey::let_go:
        arrow.release();
        fuzz_require(arrow.held(now_ns) == 0, "what is let go is not held");
        return;
      default:
        arrow.forget();
        fuzz_require(arrow.held(now_ns) == 0, "another key ends a hold");
    }
  }
};

}  // namespace
}  // namespace inbetween

/// A read of a terminal is a byte of milliseconds since the last, a byte that says how long it is, and that.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace inbetween;
  constexpr std::int64_t ns_per_ms = 1'000'000;
  std::string_view left(reinterpret_cast<const char*>(bytes), size);
  Desk desk;
  while (left.size() > 2) {
    desk.now_ns += static_cast<unsigned char>(left[0]) * ns_per_ms;
    const std::string_view read = left.substr(2, static_cast<unsigned char>(left[1]));
    left.remove_prefix(2 + read.size());
    desk.keys.feed(read);
    std::size_t count = 0;
    while (const auto key = desk.keys.next()) {
      desk.press(*key);
      ++count;
    }
    fuzz_require(count <= read.size(), "no byte is two keys");
    const int held = desk.arrow.held(desk.now_ns);
    fuzz_require(held >= -1 && held <= 1, "a direction");
  }
  desk.now_ns += static_cast<std::int64_t>(key_silence_s * 1000) * ns_per_ms;
  fuzz_require(desk.arrow.held(desk.now_ns) == 0, "silence ends a hold");
  return 0;
}
