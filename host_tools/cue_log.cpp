#include "host_tools/cue_log.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <iterator>

#include "host_tools/csv_field.hpp"
#include "inbetween/tick_time.hpp"

namespace inbetween {

CueLog::CueLog(const std::string& file, const std::vector<CuePulse>& pulses, bool waits)
    : pulses_(pulses),
      log_(file, "seconds,line,frame,width_ms,merged\n", waits,
           [this](const BegunPulse& begun, std::string& text) { put(begun, text); }) {}

void CueLog::put(const BegunPulse& begun, std::string& text) const {
  const CuePulse& pulse = pulses_[begun.pulse];
  fmt::format_to(std::back_inserter(text), "{}.{:09},{},{},{},{}\n", begun.at_ns / ns_per_s,
                 begun.at_ns % ns_per_s, csv_field(std::string(pulse.line)), pulse.frame + pulse.phase,
                 static_cast<double>(pulse.width_ns) * 1e-6, begun.is_merged ? 1 : 0);
}

}  // namespace inbetween
