#include "host_tools/loop/run_record.hpp"

#include <fmt/format.h>

#include <iterator>

#include "host_tools/text/csv_table.hpp"

namespace inbetween {

RunRecord::RunRecord(const std::string& file, const RigFile& rig, bool waits)
    : axes_(rig.axes.size()),
      period_s_(1.0 / rig.rate_hz),
      log_(file, head_of(rig), waits, [this](const Tick& tick, std::string& text) { put(tick, text); }) {}

void RunRecord::take(const RunLoop& loop, const LoopTask* act) {
  Tick tick;
  tick.number = number_++;
  tick.state = loop.state();
  if (act != nullptr) tick.frame = act->frame();
  tick.is_told = loop.sends_setpoints();
  for (std::size_t i = 0; i < axes_; ++i) {
    tick.told[i] = loop.setpoints()[i].position;
    tick.actual[i] = loop.drive_states()[i].actual;
  }
  log_.take(tick);
}

std::string RunRecord::head_of(const RigFile& rig) {
  std::string head = "tick,seconds,state,frame";
  for (const RigAxis& axis : rig.axes) {
    head += "," + csv_field(axis.name) + "," + csv_field(axis.name + " actual");
  }
  return head + "\n";
}

void RunRecord::put(const Tick& tick, std::string& text) const {
  auto out = std::back_inserter(text);
  fmt::format_to(out, "{},{:.6f},{},", tick.number, static_cast<double>(tick.number) * period_s_,
                 name_of(tick.state));
  if (tick.frame) fmt::format_to(out, "{:.6f}", *tick.frame);
  for (std::size_t i = 0; i < axes_; ++i) {
    if (tick.is_told) {
      fmt::format_to(out, ",{},{}", tick.told[i], tick.actual[i]);
    } else {
      fmt::format_to(out, ",,{}", tick.actual[i]);
    }
  }
  text += '\n';
}

}  // namespace inbetween
