// Any bytes, and any messages with check bytes that fit, to a DMC device.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host_tools/dragonframe/dmc_device.hpp"
#include "tests/fuzz/targets/consent_watch.hpp"

namespace inbetween::dragonframe {
namespace {

constexpr std::int64_t ms = 1'000'000;

struct DmcDesk {
  ConsentWatch rig;
  DmcDevice device{{.motors = 4, .outputs = 2, .inputs = 1, .frame_capacity = 50, .capabilities = 0x0783},
                   [this](const RigOrder& order) { return rig.take(order); }};
  std::int64_t now_ns = 0;
  std::uint32_t id = 0;
  RigState state;

  /// How many whole frames with this identifier the device sends.
  std::size_t answers(std::uint32_t wanted) {
    const std::vector<std::uint8_t> bytes = device.take_bytes();
    std::span<const std::uint8_t> left(bytes);
    DmcDecoder decoder;
    std::size_t count = 0;
    while (const auto frame = decoder.next(left)) {
      fuzz_require(frame->is_intact, "what is sent is intact");
      if (frame->id == wanted) ++count;
    }
    fuzz_require(!decoder.has_half() && decoder.counters().skipped_bytes == 0, "what is sent is frames");
    return count;
  }
  void sync() { rig.is_armed = device.is_armed(); }

  void ask(std::uint8_t which, std::span<const std::uint8_t> payload) {
    const auto table = dmc_type_table();
    const std::uint16_t type =
        which < table.size() ? static_cast<std::uint16_t>(table[which].type) : std::uint16_t{which};
    std::vector<std::uint8_t> bytes;
    append_dmc_frame({.id = ++id, .type = type, .payload = payload}, bytes);
    static_cast<void>(answers(id));
    device.hear(bytes, now_ns);
    fuzz_require(answers(id) == 1, "a message is answered once");
  }
  void happen(std::uint8_t what) {
    now_ns += what * ms;
    const std::array<RigEvent, 8> events{
        FrameReached{what % 60}, Approached{}, InPlace{}, MoveEnded{}, AtRest{}, HardStop{},
        StartSwitch{},           AtRest{}};
    device.tell(events.at(what % 8U), now_ns);
    state.moving = what & 0x10U;
    state.positions.fill(static_cast<std::int8_t>(what));
    device.observe(state, now_ns);
  }
};

}  // namespace
}  // namespace inbetween::dragonframe

/// The first byte: bit 0 says whether messages follow, or bytes as they come; bit 1 whether somebody has
/// agreed. A message is a byte that says which, one of its length, and that; from 0xF0 on something happens.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace inbetween::dragonframe;
  if (size == 0) return 0;
  std::span<const std::uint8_t> left(data + 1, size - 1);
  DmcDesk desk;
  desk.device.connect(0);
  if ((data[0] & 2U) != 0) fuzz_require(desk.device.arm(), "a rig at rest can be armed");
  desk.sync();
  if ((data[0] & 1U) == 0) {
    desk.device.hear(left, 0);
    desk.device.observe({}, 1000 * ms);
    static_cast<void>(desk.answers(0));
    return 0;
  }
  while (left.size() >= 2) {
    const std::uint8_t which = left[0];
    if (which >= 0xF0) {
      desk.happen(left[1]);
      left = left.subspan(2);
    } else {
      const std::size_t length = std::min<std::size_t>(left[1], left.size() - 2);
      desk.ask(which, left.subspan(2, length));
      left = left.subspan(2 + length);
    }
    // A consent that is gone is missed from the next message on.
    desk.sync();
  }
  desk.device.disconnect(desk.now_ns);
  fuzz_require(!desk.device.is_armed() && !desk.device.move().is_loaded(), "a host leaves nothing behind");
  return 0;
}
