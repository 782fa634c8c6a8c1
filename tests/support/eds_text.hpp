// The data sheet of a drive that never was, with the shapes that makers use: compact parts, sums with
// $NODEID, comments, counts that are wrong.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace inbetween {

struct EdsRequest {
  std::vector<std::string> without = {};     ///< sections that are left out
  std::string modes = "0x000000A1";          ///< 6502
  std::string period_access = "rw";          ///< 60C2:1
  std::string window = "2000";               ///< 6065
  std::vector<std::string> not_mapped = {};  ///< sections of objects that cannot be mapped, though others can
};

inline std::string eds_text(const EdsRequest& request) {
  std::string text =
      "[FileInfo]\nFileName=none.eds\nFileVersion=1\n\n; lists are not kept up\n[MandatoryObjects]\n"
      "SupportedObjects=9\n1=0x1000\n2=0x1001\n\n";
  const auto add = [&](std::string_view section, std::string_view lines) {
    if (std::ranges::find(request.without, section) != request.without.end()) return;
    text += fmt::format("[{}]\n{}\n", section, lines);
  };
  const auto variable = [&](std::string_view section, int type, std::string_view access,
                            std::string_view value) {
    constexpr std::array<std::string_view, 5> mapped{"6040", "6041", "6061", "6064", "607A"};
    const bool can_be_mapped = std::ranges::find(mapped, section) != mapped.end() &&
                               std::ranges::find(request.not_mapped, section) == request.not_mapped.end();
    add(section,
        fmt::format("ParameterName=p\nObjectType=0x7\nDataType=0x{:04X}\nAccessType={}\nDefaultValue={}\n"
                    "PDOMapping={}\n",
                    type, access, value, can_be_mapped ? 1 : 0));
  };
  const auto record = [&](std::string_view section) {
    add(section, "ParameterName=r\nObjectType=0x9\nSubNumber=2 ; wrong\n");
  };
  variable("1000", 7, "ro", "0x00020192");
  variable("1001", 5, "ro", "0");
  variable("1005", 7, "rw", "0x80");
  variable("1006", 7, "rw", "0");
  variable("1008", 9, "const", "T\xC3\xBCr");
  variable("100C", 6, "rw", "0");
  variable("100D", 5, "rw", "0");
  add("1016", "ParameterName=c\nObjectType=0x8\nDataType=0x0007\nAccessType=rw\nCompactSubObj=1\n");
  variable("1017", 6, "rw", "");
  record("1018");
  variable("1018sub0", 5, "ro", "4");
  variable("1018sub1", 7, "ro", "0x1234");
  for (int n = 0; n < 2; ++n) {
    for (const bool is_sent : {false, true}) {
      const int communication = (is_sent ? 0x1800 : 0x1400) + n;
      const int mapping = communication + 0x200;
      record(fmt::format("{:04X}", communication));
      variable(fmt::format("{:04X}sub1", communication), 7, "rw",
               fmt::format("$NODEID+0x{:X}",
                           (is_sent ? 0x40000180U : 0x200U) + 0x100U * static_cast<unsigned>(n)));
      variable(fmt::format("{:04X}sub2", communication), 5, "rw", "255");
      if (is_sent) variable(fmt::format("{:04X}sub3", communication), 6, "rw", "0");
      variable(fmt::format("{:04X}sub5", communication), 6, "rw", "0");
      for (int sub = 0; sub <= 4; ++sub) {
        variable(fmt::format("{:04X}sub{}", mapping, sub), sub == 0 ? 5 : 7, "rw",
                 sub == 0   ? "1"
                 : sub == 1 ? (is_sent ? "0x60410010" : "0x60400010")
                            : "0");
      }
    }
  }
  variable("603F", 6, "ro", "0");
  variable("6007", 3, "rw", "1");
  variable("6040", 6, "rww", "0");
  variable("6041", 6, "ro", "0");
  variable("605A", 3, "rw", "2");
  variable("605C", 3, "rw", "1");
  variable("605E", 3, "rw", "2");
  variable("6060", 2, "rw", "1");
  variable("6061", 2, "ro", "1");
  variable("6064", 4, "ro", "");
  variable("6065", 7, "rw", request.window);
  variable("6066", 6, "rw", "10");
  variable("607A", 4, "rww", "0");
  record("60C2");
  variable("60C2sub1", 5, request.period_access, "1");
  variable("60C2sub2", 2, "rw", "0xFFFFFFFD");
  variable("6502", 7, "ro", request.modes);
  return text;
}

}  // namespace inbetween
