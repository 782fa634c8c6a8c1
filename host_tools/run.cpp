#include "host_tools/run.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/json_writer.hpp"
#include "inbetween/frame_time.hpp"
#include "sim/simulated_axis.hpp"
#include "sim/virtual_clock.hpp"

namespace inbetween {
namespace {

constexpr std::int64_t ns_per_s = 1'000'000'000;

/// Where a simulated axis stands before anything moves it: as near to 0 as its limits allow.
double parked(const RigAxis& axis) {
  return std::clamp(0.0, axis.min, axis.max);
}

/// The setpoints of a plan with its rolls, tick by tick, in the order of the rig's axes.
class Setpoints {
 public:
  explicit Setpoints(const Plan& plan)
      : plan_(plan),
        fps_(plan.move().fps.rate),
        rate_hz_(plan.rig()->rate_hz),
        last_(last_tick(plan.played().last_frame() - plan.played().first_frame(), fps_, rate_hz_)),
        moving_(plan.played().axis_count()) {
    for (const RigAxis& axis : plan.rig()->axes) positions_.push_back(parked(axis));
  }

  [[nodiscard]] std::int64_t last() const { return last_; }
  [[nodiscard]] FrameTime<double> time(std::int64_t tick) const {
    FrameTime<double> time = frame_time_of_tick<double>(tick, fps_, rate_hz_);
    time.frame += plan_.played().first_frame();
    return time;
  }
  /// Valid until the next call. An axis in no track keeps its parked position.
  const std::vector<double>& at(std::int64_t tick) {
    plan_.played().positions(time(tick), moving_);
    for (std::size_t a = 0; a < positions_.size(); ++a) {
      const PlanAxis& axis = plan_.axes()[a];
      if (axis.track) positions_[a] = moving_[axis.move_axis];
    }
    return positions_;
  }

 private:
  const Plan& plan_;
  FrameRate fps_;
  std::int32_t rate_hz_;
  std::int64_t last_;
  std::vector<double> moving_;  ///< track after track
  std::vector<double> positions_;
};

const Place& place_of(const PlanAxis& axis, const MoveFile& move) {
  return move.tracks[*axis.track].axis_places[axis.track_axis];
}

void refuse_positions_beyond_limits(const Plan& plan, Setpoints& setpoints) {
  for (std::int64_t tick = 0; tick <= setpoints.last(); ++tick) {
    const std::vector<double>& positions = setpoints.at(tick);
    for (std::size_t a = 0; a < positions.size(); ++a) {
      const RigAxis& axis = plan.rig()->axes[a];
      if (positions[a] >= axis.min && positions[a] <= axis.max) continue;
      const FrameTime<double> when = setpoints.time(tick);
      throw LimitError(
          place_of(plan.axes()[a], plan.move()),
          fmt::format("axis {} would go to {} {} at frame {:.2f}, outside {}..{} of the rig {}; "
                      "move its keys inward",
                      in_quotes(axis.name), positions[a], to_string(axis.unit), when.frame + when.fraction,
                      axis.min, axis.max, in_quotes(plan.rig()->name)));
    }
  }
}

/// The loop: wait, compute, send.
template <class Clock>
void play(Setpoints& setpoints, const RunOptions& options, Clock& clock, std::vector<SimulatedAxis>& axes,
          std::int32_t rate_hz, RunReport& report) {
  const MonotonicClock wall;
  const std::int64_t last = setpoints.last() + 1;  // in one more tick the drives arrive
  WakeLatencyCounter latencies;
  const std::int64_t start_ns = clock.now_ns();
  std::int64_t next_progress_ns = 0;
  for (std::int64_t tick = 0; tick <= last; ++tick) {
    const std::int64_t deadline_ns =
        start_ns + tick / rate_hz * ns_per_s + tick % rate_hz * ns_per_s / rate_hz;
    clock.sleep_until_ns(deadline_ns);
    const std::int64_t latency_ns = clock.now_ns() - deadline_ns;
    latencies.add(latency_ns);
    if (latency_ns >= ns_per_s / rate_hz) ++report.late_ticks;
    const std::vector<double>& positions = setpoints.at(std::min(tick, setpoints.last()));
    for (std::size_t a = 0; a < axes.size(); ++a) axes[a].tick(positions[a]);
    if (options.progress && (tick % 64 == 0 || !options.fast) && wall.now_ns() >= next_progress_ns) {
      options.progress(tick, last);
      next_progress_ns = wall.now_ns() + ns_per_s / 10;
    }
  }
  if (options.progress) options.progress(last, last);
  report.ticks = setpoints.last() + 1;
  report.wake_latency = latencies.summary();
}

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

RunReport run_simulated(const Plan& plan, const RunOptions& options) {
  refuse_beyond_limits(check(plan));
  Setpoints setpoints(plan);
  refuse_positions_beyond_limits(plan, setpoints);
  std::vector<SimulatedAxis> axes;
  for (const double position : setpoints.at(0)) axes.emplace_back(position);
  RunReport report;
  report.reason = "the move was played to its last frame";
  if (options.fast) {
    VirtualClock clock;
    play(setpoints, options, clock, axes, plan.rig()->rate_hz, report);
  } else {
    MonotonicClock clock;
    play(setpoints, options, clock, axes, plan.rig()->rate_hz, report);
  }
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const RigAxis& axis = plan.rig()->axes[a];
    report.axes.push_back({axis.name, std::string(to_string(axis.unit)), axes[a].commanded(),
                           axes[a].actual(), axes[a].following_error_peak()});
  }
  return report;
}

void write_run_json(const RunReport& report, std::FILE* file) {
  JsonWriter json(file);
  json.begin_object();
  json.member("format", 1);
  json.member("ended", name_of(report.ending));
  json.member("reason", report.reason);
  json.member("ticks", report.ticks);
  json.member("late_ticks", report.late_ticks);
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
  json.end_object();
  json.end_object();
  json.finish();
}

}  // namespace inbetween
