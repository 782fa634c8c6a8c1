#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace inbetween {

/// A setting of something that the machine may have several of.
struct NamedSetting {
  std::string name;
  std::string setting;
  friend bool operator==(const NamedSetting&, const NamedSetting&) = default;
};

/// The kernel tells in files how punctual this machine can be. What it does not tell, as in a container, is
/// empty.
struct MachineFacts {
  std::string kernel;                ///< "6.1.0-18-rt-amd64 #1 SMP PREEMPT_RT Debian 6.1.76-1"
  bool is_real_time_kernel = false;  ///< /sys/kernel/realtime
  std::optional<std::string> clock_source{};
  std::vector<NamedSetting> governors{};      ///< of processors whose frequency can change, "cpu0"
  std::vector<std::string> wireless{};        ///< network interfaces
  std::vector<std::string> can_interfaces{};  ///< virtual ones too
};

/// Reads files under `root` only: /proc/version and /sys. Waits for nothing and changes nothing.
MachineFacts read_machine_facts(const std::filesystem::path& root = "/");

}  // namespace inbetween
