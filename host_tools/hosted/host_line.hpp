// A host at a port, in one of Dragonframe's protocols, and the rig behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "drivers/linux/host_port.hpp"
#include "host_tools/dragonframe/dfmoco_device.hpp"
#include "host_tools/dragonframe/dmc_device.hpp"
#include "host_tools/hosted/hosted_rig.hpp"

namespace inbetween {

enum class HostProtocol : std::uint8_t { dmc, dfmoco };

/// What the protocols' maker has for the speed of the line, in bit/s.
constexpr std::int32_t baud_of(HostProtocol protocol) {
  return protocol == HostProtocol::dmc ? 115'200 : 57'600;
}

/// The consent of a person, where nobody can be asked.
enum class Consent : std::uint8_t {
  asked,  ///< a key at the rig's terminal
  given,  ///< whoever connects has it
};

/// Refers to the port and the rig. One thread, which is not that of the loop, calls its functions.
class HostLine {
 public:
  /// A host that leaves so many bytes unread is taken for gone.
  static constexpr std::size_t max_unread_bytes = 64 * 1024;

  HostLine(HostPort& port, HostProtocol protocol, const RigFile& rig, HostedRig& hosted, Consent consent);

  /// Bytes both ways, and what the rig tells. Every few milliseconds. `now_ns` is of the clock of the loop.
  void serve(std::int64_t now_ns);
  /// Somebody at the rig's terminal agrees. After a stop by the rig its drives are asked first where they
  /// are.
  void agree();
  /// The stop button of the rig.
  void stop(std::int64_t now_ns);

  [[nodiscard]] bool is_armed() const;
  [[nodiscard]] bool is_connected() const;
  /// What has happened since the last call, a line each.
  [[nodiscard]] std::vector<std::string> take_words();
  /// "a host is connected", and whether it may move the rig.
  [[nodiscard]] std::string state_in_words() const;
  /// Second hosts that were refused, bytes that were no messages.
  [[nodiscard]] std::string counts_in_words() const;

 private:
  using Device = std::variant<dragonframe::DmcDevice, dragonframe::DfmocoDevice>;
  static Device device_of(HostProtocol protocol, const RigFile& rig, HostedRig& hosted);
  void look_at_port(std::int64_t now_ns);
  void hear(std::int64_t now_ns);
  void send(std::int64_t now_ns);
  void look_at_rig(std::int64_t now_ns);
  void note();
  void arm();
  void disconnect(std::int64_t now_ns);
  void say(std::string words) { words_.push_back(std::move(words)); }

  HostPort& port_;
  HostedRig& hosted_;
  Consent consent_;
  Device device_;
  bool agrees_ = false;  ///< and the drives are asked
  std::vector<std::uint8_t> unsent_;
  std::uint64_t refused_hosts_ = 0;
  std::vector<std::string> words_;
};

}  // namespace inbetween
