// A simulated rig behind a real port: a scripted host has the other end of a pseudo-terminal open. The time
// is virtual.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

#include "drivers/linux/host_port.hpp"
#include "host_tools/hosted/host_line.hpp"
#include "tests/support/hosted_rig_scene.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {

class HostedPortScene final : public HostedRigScene {
  TemporaryFolder folder_;
  std::string name_ = folder_.path() / "port";
  HostPort port_;
  bool is_dmc_;
  int file_ = -1;

 public:
  HostedPortScene(const std::string& rig_text, HostProtocol protocol)
      : HostedRigScene(rig_text),
        is_dmc_(protocol == HostProtocol::dmc),
        line(port_, protocol, rig, *hosted, Consent::asked) {
    if (port_.open("pty:" + name_, baud_of(protocol))) throw std::runtime_error("there is no port");
  }
  ~HostedPortScene() override { unplug(); }
  HostedPortScene(const HostedPortScene&) = delete;
  HostedPortScene& operator=(const HostedPortScene&) = delete;

  /// A host opens the port; a tick later it is known.
  void plug() {
    file_ = ::open(name_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (file_ < 0) throw std::runtime_error("the host finds no port");
    dmc = {};
    tick();
  }
  void unplug() {
    if (file_ >= 0) ::close(file_);
    file_ = -1;
  }
  /// A port takes what it has room for; the rest after a tick.
  void write(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::write(file_, bytes.data(), bytes.size());
      if (count > 0) bytes = bytes.subspan(static_cast<std::size_t>(count));
      if (!bytes.empty()) tick();
    }
  }
  /// The code of the acknowledgement of a DMC request, 0 where data answered it.
  unsigned ask(const oracle::DmcBytes& request) {
    write(request);
    pass();
    for (int ticks = 0; dmc.answers() == 0; ++ticks) {
      if (ticks > max_silent_ticks) throw std::runtime_error("the device is silent");
      tick();
    }
    return dmc.code();
  }
  /// The first line that answers one of DFMoco, and what came with it.
  std::vector<std::string> ask(const std::string& command) {
    write(oracle::dfmoco_bytes(command));
    static_cast<void>(dfmoco.take_lines());
    pass();
    return dfmoco.take_lines();
  }
  /// Polls STATUS, and then asks for GO until the rig waits for it. The tick of the record that is the one of
  /// GO.
  std::size_t go() {
    run_until_still();
    for (int ticks = 0; ask(dmc.go()) != 0x10; ++ticks) {
      if (ticks > max_silent_ticks) throw std::runtime_error("GO is refused");
      tick();
    }
    return path.size() - 1;
  }

  HostLine line;
  oracle::DmcHost dmc;
  oracle::DfmocoHost dfmoco;
  std::vector<oracle::DmcHeard> heard;

 private:
  static constexpr int max_silent_ticks = 1000;
  void serve() override { pass(); }
  void pass() {
    line.serve(now_ns);
    for (std::string& text : line.take_words()) words.push_back(std::move(text));
    std::array<std::uint8_t, 4096> bytes{};
    while (file_ >= 0) {
      const ssize_t count = ::read(file_, bytes.data(), bytes.size());
      if (count <= 0) break;
      const auto end = bytes.begin() + count;
      if (is_dmc_) {
        dmc.hear({bytes.begin(), end});
      } else {
        dfmoco.hear({bytes.begin(), end});
      }
    }
    for (oracle::DmcHeard& message : dmc.take_heard()) heard.push_back(std::move(message));
  }
};

}  // namespace inbetween
