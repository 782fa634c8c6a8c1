#include "host_tools/loop/run_record.hpp"

#include <fmt/format.h>

#include <iterator>

#include "host_tools/text/csv_table.hpp"

namespace inbetween {
namespace {

std::vector<std::string> names_of(const RigFile& rig) {
  std::vector<std::string> names;
  for (const RigAxis& axis : rig.axes) names.push_back(axis.name);
  return names;
}

}  // namespace

RunRecord::RunRecord(const std::string& file, const RigFile& rig, bool waits)
    : axes_(rig.axes.size()),
      period_s_(1.0 / rig.rate_hz),
      log_(file, head_of_record(names_of(rig)), waits,
           [this](const Tick& tick, std::string& text) { put(tick, text); }) {}

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

void RunRecord::put(const Tick& tick, std::string& text) const {
  put_recorded({.number = tick.number,
                .state = tick.state,
                .frame = tick.frame,
                .told = std::span(tick.told).first(tick.is_told ? axes_ : 0),
                .actual = std::span(tick.actual).first(axes_)},
               period_s_, text);
}

std::string head_of_record(const std::vector<std::string>& axes) {
  std::string head = "tick,seconds,state,frame";
  for (const std::string& axis : axes) head += "," + csv_field(axis) + "," + csv_field(axis + " actual");
  return head + "\n";
}

void put_recorded(const RecordedTick& tick, double period_s, std::string& text) {
  auto out = std::back_inserter(text);
  fmt::format_to(out, "{},{:.6f},{},", tick.number, static_cast<double>(tick.number) * period_s,
                 name_of(tick.state));
  if (tick.frame) fmt::format_to(out, "{:.6f}", *tick.frame);
  for (std::size_t i = 0; i < tick.actual.size(); ++i) {
    if (tick.told.empty()) {
      fmt::format_to(out, ",,{}", tick.actual[i]);
    } else {
      fmt::format_to(out, ",{},{}", tick.told[i], tick.actual[i]);
    }
  }
  text += '\n';
}

}  // namespace inbetween
