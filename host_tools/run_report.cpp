#include "host_tools/run_report.hpp"

#include "host_tools/json_writer.hpp"

namespace inbetween {
namespace {

const char* name_of(Ending ending) {
  switch (ending) {
    case Ending::finished:
      return "finished";
    case Ending::stopped:
      return "stopped";
    case Ending::fault:
      return "fault";
  }
  return "fault";
}

}  // namespace

void write_run_json(const RunReport& report, std::FILE* file) {
  JsonWriter json(file);
  json.begin_object();
  json.member("format", 1);
  json.member("ended", name_of(report.ending));
  json.member("reason", report.reason);
  json.member("ticks", report.ticks);
  json.member("late_ticks", report.late_ticks);
  if (report.exposures) json.member("exposures", *report.exposures);
  if (report.record) {
    json.key("record");
    json.begin_object();
    json.member("ticks", report.record->written);
    json.member("lost", report.record->lost);
    json.member("why", report.record->why);
    json.end_object();
  }
  json.line();
  json.key("axes");
  json.begin_array();
  for (const RunAxis& axis : report.axes) {
    json.line();
    json.begin_object();
    json.member("name", axis.name);
    json.member("last_commanded", axis.last_commanded);
    json.member("last_actual", axis.last_actual);
    json.member("following_error_peak", axis.following_error_peak);
    json.end_object();
  }
  json.end_array();
  json.line();
  json.key("wake_latency_us");
  json.begin_object();
  json.member("p50", report.wake_latency.p50_us);
  json.member("p99", report.wake_latency.p99_us);
  json.member("p99_9", report.wake_latency.p99_9_us);
  json.member("max", report.wake_latency.max_us);
  json.member("max_at_s", report.wake_latency.max_at_s);
  json.key("histogram");
  json.begin_array();
  for (const WakeLatency::Bucket& bucket : report.wake_latency.histogram) {
    json.begin_object();
    json.member("below_us", bucket.below_us);
    json.member("ticks", bucket.ticks);
    json.end_object();
  }
  json.end_array();
  json.end_object();
  json.end_object();
  json.finish();
}

}  // namespace inbetween
