#include "drivers/linux/machine_facts.hpp"

#include <algorithm>
#include <fstream>
#include <string_view>
#include <system_error>

namespace inbetween {
namespace {

namespace fs = std::filesystem;

/// "" where there is none.
std::string line_of(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

/// Returns the names in their order. A folder that is not there has none.
std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    names.push_back(entry.path().filename().string());
  }
  std::ranges::sort(names);
  return names;
}

/// "Linux version RELEASE (who has built it) (with what) VERSION" without the parentheses.
std::string without_parentheses(std::string_view text) {
  std::string kept;
  int depth = 0;
  for (const char letter : text) {
    if (letter == '(') ++depth;
    const bool is_second_space = letter == ' ' && kept.ends_with(' ');
    if (depth == 0 && !is_second_space) kept.push_back(letter);
    if (letter == ')') --depth;
  }
  constexpr std::string_view before = "Linux version ";
  return kept.starts_with(before) ? kept.substr(before.size()) : kept;
}

}  // namespace

MachineFacts read_machine_facts(const fs::path& root) {
  MachineFacts facts{.kernel = without_parentheses(line_of(root / "proc/version"))};
  facts.is_real_time_kernel = line_of(root / "sys/kernel/realtime") == "1";
  const std::string clock = line_of(root / "sys/devices/system/clocksource/clocksource0/current_clocksource");
  if (!clock.empty()) facts.clock_source = clock;
  const fs::path processors = root / "sys/devices/system/cpu";
  for (const std::string& name : names_in(processors)) {
    const std::string governor = line_of(processors / name / "cpufreq/scaling_governor");
    if (!governor.empty()) facts.governors.push_back({.name = name, .setting = governor});
  }
  const fs::path networks = root / "sys/class/net";
  constexpr std::string_view type_of_can = "280";  // ARPHRD_CAN
  for (const std::string& name : names_in(networks)) {
    std::error_code none;
    if (fs::exists(networks / name / "wireless", none)) facts.wireless.push_back(name);
    if (line_of(networks / name / "type") == type_of_can) facts.can_interfaces.push_back(name);
  }
  return facts;
}

}  // namespace inbetween
