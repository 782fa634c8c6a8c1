// Any bytes to a DFMoco device.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "host_tools/dragonframe/dfmoco_device.hpp"
#include "tests/fuzz/targets/consent_watch.hpp"

/// The first byte says whether somebody has agreed. Bytes go in as they come; behind 0xFF is one of tens of
/// milliseconds, in which something may have come to rest.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace inbetween::dragonframe;
  if (size == 0) return 0;
  ConsentWatch rig;
  DfmocoDevice device(rig.motors, [&](const RigOrder& order) { return rig.take(order); });
  device.connect(0);
  if ((data[0] & 1U) != 0) fuzz_require(device.arm(), "a rig can be armed");
  rig.is_armed = device.is_armed();
  std::int64_t now_ns = 0;
  for (std::size_t i = 1; i < size; ++i) {
    if (data[i] != 0xFF) {
      device.hear(std::span(data + i, 1), now_ns);
    } else if (++i < size) {
      now_ns += data[i] * std::int64_t{10'000'000};
      if ((data[i] & 1U) != 0) device.tell(AtRest{}, now_ns);
      device.observe({.moving = (data[i] & 2U) != 0 ? 1U : 0U}, now_ns);
    }
    rig.is_armed = device.is_armed();
    const std::string said = device.take_text();
    const std::string end = "\r\n";
    fuzz_require(said.empty() || (said.size() > 2 && said.substr(said.size() - 2) == end),
                 "a line has its end");
  }
  device.disconnect(now_ns);
  fuzz_require(!device.is_armed(), "a host leaves no consent behind");
  return 0;
}
