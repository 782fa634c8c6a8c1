#include "host_tools/cli/agreement.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <cstdio>
#include <optional>

#include "drivers/linux/interrupt_watch.hpp"
#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/loop/transport_keys.hpp"

namespace inbetween {
namespace {

/// The pause between two looks at the keyboard while somebody thinks.
constexpr std::int64_t ns_between_looks = 20'000'000;

}  // namespace

bool agrees(KeyTerminal& terminal, const std::string& question) {
  fmt::print(stderr, "{}\nEnter goes there, q leaves\n", question);
  const MonotonicClock clock;
  TransportKeys keys;
  for (;;) {
    keys.feed(terminal.read());
    while (const std::optional<TransportKey> key = keys.next()) {
      if (*key == TransportKey::start) return true;
      if (*key == TransportKey::quit || *key == TransportKey::stop) return false;
    }
    if (InterruptWatch::asked()) return false;
    clock.sleep_until_ns(clock.now_ns() + ns_between_looks);
  }
}

}  // namespace inbetween
