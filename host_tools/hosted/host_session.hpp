// A rig is switched on and given to a host, until somebody leaves.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "drivers/linux/host_port.hpp"
#include "host_tools/hosted/host_line.hpp"
#include "host_tools/loop/rig_session.hpp"
#include "host_tools/motions/transit.hpp"

namespace inbetween {

struct HostSessionOptions {
  HostProtocol protocol = HostProtocol::dmc;
  Consent consent = Consent::asked;
  /// Of their limits, for what the host moves by itself, and on the way to a start: above 0, up to 1.
  double share = transit_share;
  /// The keys of the audience are Enter, Esc and q.
  SessionOptions session = {};
  /// What stands above, and what has happened since the last time. Ten times a second at most.
  std::function<void(const std::string& state, const std::vector<std::string>& events)> tell = {};
};

/// How it ended, and how the loop kept its time until then.
struct HostSessionEnd : SetupEnd {
  std::int64_t late_ticks = 0;
  WakeLatency latency = {};
};

/// The host's orders are those of HostedRig; Enter agrees, Esc stops and takes the consent away, q and an
/// interrupt leave. The rig has a section [dragonframe], and the port is open.
///
/// Throws InputError where an axis is unreferenced or stands outside its limits (nothing has moved then), and
/// what RigSession and RigReference throw.
HostSessionEnd give_to_host(const RigFile& rig, HostPort& port, RigReference& reference,
                            const HostSessionOptions& options);

}  // namespace inbetween
