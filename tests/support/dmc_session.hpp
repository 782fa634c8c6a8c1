// A scripted host, a DMC device and a rig that pretends, in a virtual time.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "host_tools/dragonframe/dmc_device.hpp"
#include "tests/support/oracle_dmc_host.hpp"
#include "tests/support/pretend_rig.hpp"

namespace inbetween::dragonframe {

struct DmcSession {
  explicit DmcSession(const DmcFacts& facts)
      : device(facts, [this](const RigOrder& order) { return rig.take(order); }) {
    device.connect(0);
    pass();
  }
  DmcSession(const DmcSession&) = delete;
  DmcSession& operator=(const DmcSession&) = delete;
  ~DmcSession() = default;

  /// The request is sent; the code of its acknowledgement, 0 where data answered it. It is answered once.
  unsigned ask(const oracle::DmcBytes& request) {
    device.hear(request, now_ns);
    pass();
    if (host.answers() != 1) throw std::runtime_error("a request is answered once");
    return host.code();
  }
  void pass() {
    host.hear(device.take_bytes());
    for (oracle::DmcHeard& message : host.take_heard()) heard.push_back(std::move(message));
  }
  void tick() {
    now_ns += PretendRig::tick_ns;
    const std::vector<RigEvent> events = rig.tick();
    device.observe(rig.state(), now_ns);
    for (const RigEvent& event : events) device.tell(event, now_ns);
    pass();
  }
  void run_for(double seconds) {
    const std::int64_t until_ns = now_ns + static_cast<std::int64_t>(seconds * 1e9);
    while (now_ns < until_ns) tick();
  }
  /// STATUS, as a host polls it. Throws after a minute of the rig's time.
  void run_until_still() {
    for (int i = 0; i < 3000; ++i) {
      tick();
      static_cast<void>(ask(host.status()));
      if (host.data()->number(0, 4) == 0) return;
    }
    throw std::runtime_error("the rig does not come to rest");
  }
  void run_until(DmcStage stage) {
    for (int i = 0; i < 3000 && device.stage() != stage; ++i) tick();
    if (device.stage() != stage) throw std::runtime_error("the stage is not reached");
  }
  /// How many messages of a type came without being asked for.
  [[nodiscard]] std::size_t pushed(unsigned type) const {
    std::size_t count = 0;
    for (const oracle::DmcHeard& message : heard) count += message.id == 0 && message.type == type ? 1U : 0U;
    return count;
  }
  [[nodiscard]] std::int32_t position(std::uint8_t motor) const {
    return rig.state().positions.at(motor - 1U);
  }
  /// Begin, one motor, end: all are OK.
  void upload(std::int32_t start, const std::vector<std::int32_t>& positions, unsigned motor = 1) {
    const auto end = start + static_cast<std::int32_t>(positions.size()) - 1;
    const bool is_ok =
        ask(host.configure(motor, 0x03)) == 0x10 && ask(host.upload_begin(start, end)) == 0x10 &&
        ask(host.upload_axis(motor, 0, true, positions)) == 0x10 && ask(host.upload_end()) == 0x10;
    if (!is_ok) throw std::runtime_error("the upload is refused");
  }

  PretendRig rig;
  DmcDevice device;
  oracle::DmcHost host;
  std::int64_t now_ns = 0;
  std::vector<oracle::DmcHeard> heard;
};

}  // namespace inbetween::dragonframe
