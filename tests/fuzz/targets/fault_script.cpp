// Any text is a script of faults that keeps every promise of host_tools/rig/fault_script.hpp, or is
// refused in one line.
#include "host_tools/rig/fault_script.hpp"

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <variant>

#include "tests/fuzz/targets/refusal.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace {

/// An axis called "x", which can have faults, and one called "y", which cannot.
const RigFile& rig() {
  static const RigFile parsed = parse_rig(
      rig_text({axis_text("x", "mm", {-1, 1}, {.velocity = 1, .acceleration = 1}, "", cia402_text(1, -1e5)),
                axis_text("y", "mm", {0, 1}, {.velocity = 1, .acceleration = 1})},
               {.name = "r", .more = "[bus.can0]\nbitrate = 500000\n"}),
      "rig.toml");
  return parsed;
}

void require_fault(const ScriptedFault& fault) {
  const DriveTrouble& trouble = fault.trouble;
  fuzz_require(fault.axis < rig().axes.size(), "a fault is of an axis");
  fuzz_require(std::holds_alternative<Cia402Drive>(rig().axes[fault.axis].drive),
               "its drive can have faults");
  fuzz_require(!fault.what.empty(), "a fault has a word");
  const std::int64_t max_ns = static_cast<std::int64_t>(max_fault_seconds) * 1'000'000'000;
  fuzz_require(trouble.at_ns >= 0 && trouble.at_ns <= max_ns, "a fault has a time in its range");
  fuzz_require(trouble.for_ns > 0, "a fault lasts");
  fuzz_require(trouble.for_ns <= max_ns || trouble.for_ns == DriveTrouble{}.for_ns, "a while, or for good");
  fuzz_require(trouble.frames > 0, "a fault takes frames");
  const bool is_device = trouble.kind >= DriveTrouble::Kind::no_window;  // these are the last
  fuzz_require(!is_device || (trouble.at_ns == 0 && !fault.is_after_motion), "what a drive is has no time");
  const bool is_flood = trouble.kind == DriveTrouble::Kind::flood;
  fuzz_require(!is_flood || (trouble.value >= 1 && trouble.value <= max_flood_per_s), "a flood has its rate");
}

void require_script(const FaultScript& script) {
  fuzz_require(!script.faults.empty() && script.faults.size() <= max_faults, "a script has faults");
  for (const ScriptedFault& fault : script.faults) require_fault(fault);
}

}  // namespace
}  // namespace inbetween

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  return inbetween::fuzz_text(bytes, size, "any.toml", [](std::string_view text, const char* file) {
    inbetween::require_script(inbetween::parse_fault_script(text, file, inbetween::rig()));
  });
}
