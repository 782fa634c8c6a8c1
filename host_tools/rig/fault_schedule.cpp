#include "host_tools/rig/fault_schedule.hpp"

#include <algorithm>

namespace inbetween {
void FaultSchedule::advance(std::int64_t now_ns) {
  if (!motion_ns_ &&
      std::ranges::any_of(drives_, [](const DriveOfAxis& of) { return of.drive->has_been_moved(); })) {
    motion_ns_ = now_ns;
  }
  std::erase_if(pending_, [&](const ScriptedFault& fault) {
    const std::optional<std::int64_t> from_ns = fault.is_after_motion ? motion_ns_ : power_ns_;
    if (!from_ns || now_ns - *from_ns < fault.trouble.at_ns) return false;
    begin(fault, now_ns);
    return true;
  });
}

void FaultSchedule::begin(const ScriptedFault& fault, std::int64_t now_ns) {
  for (const DriveOfAxis& of : drives_) {
    if (of.axis != fault.axis) continue;
    DriveTrouble trouble = fault.trouble;
    trouble.at_ns = now_ns;
    of.drive->add_trouble(trouble);
    begun_.push_back({.axis = fault.axis, .at_ns = now_ns, .what = fault.what});
  }
}

}  // namespace inbetween
