#include "host_tools/motions/run_report.hpp"

#include <array>

#include "host_tools/text/json_writer.hpp"

namespace inbetween {
namespace {

// In the order of Ending.
constexpr std::array ending_names = {"finished", "stopped", "fault"};

void write_log(const char* name, const char* records, const LoopLogEnd& log, JsonWriter& json) {
  json.object(name, [&] {
    json.member(records, log.written);
    json.member("lost", log.lost);
    json.member("why", log.why);
  });
}

void write_kept(const KeptTake& kept, JsonWriter& json) {
  json.object("kept", [&] {
    json.member("take", kept.number);
    json.member("file", kept.file);
    json.member("ticks", kept.ticks);
    json.member("lost", kept.lost);
    json.member("why", kept.why);
    json.member("bytes", kept.bytes);
  });
}

void write_shoot(const ShootCount& shoot, JsonWriter& json) {
  json.object("shoot", [&] {
    json.member("first", shoot.first);
    json.member("last", shoot.last);
    json.member("due", shoot.due());
    json.member("shot", shoot.shot);
    json.member("shot_again", shoot.shot_again);
    json.member("skipped", shoot.skipped);
    json.member("left", shoot.left);
    json.member("cut_off", shoot.cut_off);
    json.member("last_shot", shoot.last_shot);
  });
}

void write_takes(const std::vector<RunTake>& takes, JsonWriter& json) {
  json.line();
  json.objects("takes", takes, [&](const RunTake& take) {
    json.member("take", take.number);
    json.member("whole", take.is_whole);
    json.member("file", take.file);
    if (take.record) write_log("record", "ticks", *take.record, json);
    if (take.kept) write_kept(*take.kept, json);
  });
}

void write_counts(const std::vector<Count>& counts, JsonWriter& json) {
  for (const Count& count : counts) json.member(count.name, count.count);
}

/// An object each, with what it is of as `named`.
void write_counted(const char* name, const char* named, const std::vector<Counted>& all, JsonWriter& json) {
  json.line();
  json.objects(name, all, [&](const Counted& each) {
    json.member(named, each.of);
    write_counts(each.counts, json);
  });
}

}  // namespace

std::string numbered(std::string name, std::int32_t take) {
  return name.replace(name.find("%n"), 2, std::to_string(take));
}

void write_run_json(const RunReport& report, std::FILE* file) {
  JsonWriter json(file);
  json.begin_object();
  json.member("format", 1);
  json.member("ended", ending_names.at(static_cast<std::size_t>(report.ending)));
  json.member("reason", report.reason);
  if (report.played) {
    json.member("first", report.played->first);
    json.member("last", report.played->last);
  }
  json.member("ticks", report.ticks);
  json.member("late_ticks", report.late_ticks);
  if (report.exposures) json.member("exposures", *report.exposures);
  if (report.shoot) write_shoot(*report.shoot, json);
  if (report.record) write_log("record", "ticks", *report.record, json);
  if (report.steps) write_log("steps", "edges", *report.steps, json);
  if (report.cue_log) write_log("cue_log", "pulses", *report.cue_log, json);
  if (report.shoot_log) write_log("shoot_log", "exposures", *report.shoot_log, json);
  if (report.kept) write_kept(*report.kept, json);
  if (!report.takes.empty()) write_takes(report.takes, json);
  json.line();
  json.objects("axes", report.axes, [&](const RunAxis& axis) {
    json.member("name", axis.name);
    json.member("last_commanded", axis.last_commanded);
    json.member("last_actual", axis.last_actual);
    json.member("following_error_peak", axis.following_error_peak);
  });
  json.line();
  write_json(report.wake_latency, json);
  write_counted("buses", "name", report.counts.buses, json);
  write_counted("drives", "axis", report.counts.drives, json);
  write_counted("chips", "label", report.counts.chips, json);
  if (!report.counts.pulses.empty()) {
    json.line();
    json.object("pulses", [&] { write_counts(report.counts.pulses, json); });
  }
  json.end_object();
  json.finish();
}

}  // namespace inbetween
