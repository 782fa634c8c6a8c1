#include "host_tools/rig/cue_log.hpp"

#include <fmt/format.h>

#include <iterator>

#include "host_tools/text/csv_table.hpp"
#include "inbetween/loop/tick_time.hpp"

namespace inbetween {

CueLog::CueLog(const std::string& file, const std::vector<CuePulse>& pulses, bool waits)
    : pulses_(pulses),
      log_(file, "seconds,line,frame,width_ms,merged,late_us\n", waits,
           [this](const PlayedPulse& played, std::string& text) { put(played, text); }) {}

void CueLog::put(const PlayedPulse& played, std::string& text) const {
  const BegunPulse& begun = played.begun;
  const CuePulse& pulse = pulses_[begun.pulse];
  fmt::format_to(std::back_inserter(text), "{}.{:09},{},{},{},{},", begun.at_ns / ns_per_s,
                 begun.at_ns % ns_per_s, csv_field(std::string(pulse.line)), pulse.frame + pulse.phase,
                 static_cast<double>(pulse.width_ns) * 1e-6, begun.is_merged ? 1 : 0);
  if (played.is_played) {
    fmt::format_to(std::back_inserter(text), "{}", static_cast<double>(played.late_ns) * 1e-3);
  }
  text += '\n';
}

}  // namespace inbetween
