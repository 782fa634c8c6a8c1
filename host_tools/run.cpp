#include "host_tools/run.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "drivers/linux/monotonic_clock.hpp"
#include "host_tools/json_writer.hpp"
#include "host_tools/planned_stops.hpp"
#include "host_tools/transport.hpp"
#include "inbetween/frame_time.hpp"
#include "inbetween/motion_loop.hpp"
#include "sim/simulated_rig.hpp"
#include "sim/virtual_clock.hpp"

namespace inbetween {
namespace {

constexpr std::int64_t ns_per_s = 1'000'000'000;

/// Where a simulated axis stands before anything moves it: as near to 0 as its limits allow.
double parked(const RigAxis& axis) {
  return std::clamp(0.0, axis.min, axis.max);
}

const Place& place_of(const PlanAxis& axis, const MoveFile& move) {
  return move.tracks[*axis.track].axis_places[axis.track_axis];
}

/// Where the axes of the rig stand at a time of the move; those in no track where they are parked.
std::vector<double> positions_at(const Plan& plan, const FrameTime<double>& time) {
  std::vector<double> moving(plan.played().axis_count());
  plan.played().positions(time, moving);
  std::vector<double> positions;
  for (std::size_t a = 0; a < plan.axes().size(); ++a) {
    const PlanAxis& axis = plan.axes()[a];
    positions.push_back(axis.track ? moving[axis.move_axis] : parked(plan.rig()->axes[a]));
  }
  return positions;
}

void refuse_positions_beyond_limits(const Plan& plan, std::int64_t last) {
  std::vector<double> positions(plan.played().axis_count());
  for (std::int64_t tick = 0; tick <= last; ++tick) {
    FrameTime<double> when = frame_time_of_tick<double>(tick, plan.move().fps.rate, plan.rig()->rate_hz);
    when.frame += plan.played().first_frame();
    plan.played().positions(when, positions);
    for (std::size_t d = 0; d < positions.size(); ++d) {
      if (positions[d] >= plan.limits()[d].min() && positions[d] <= plan.limits()[d].max()) continue;
      const std::size_t a = plan.axis_of(d);
      const RigAxis& axis = plan.rig()->axes[a];
      throw LimitError(
          place_of(plan.axes()[a], plan.move()),
          fmt::format("axis {} would go to {} {} at frame {:.2f}, outside {}..{} of the rig {}; "
                      "move its keys inward",
                      in_quotes(axis.name), positions[d], to_string(axis.unit), when.frame + when.fraction,
                      axis.min, axis.max, in_quotes(plan.rig()->name)));
    }
  }
}

/// A plan on a simulated rig that stands at its beginning.
class SimulatedRun {
 public:
  explicit SimulatedRun(const Plan& plan)
      : stops_(plan),
        playhead_(plan.played(), *stops_.bounds(), plan.rig()->rate_hz),
        rig_(positions_at(plan, {plan.played().first_frame(), 0})),
        states_(plan.axes().size()),
        setpoints_(plan.axes().size()),
        positions_(plan.played().axis_count()),
        loop_(rig_, lines_, {states_, setpoints_, positions_}) {
    for (std::size_t d = 0; d < positions_.size(); ++d) drive_of_.push_back(plan.axis_of(d));
    require(loop_.load({.move = &plan.played(),
                        .playhead = &playhead_,
                        .drive_of = drive_of_,
                        .limits = plan.limits(),
                        .tick_seconds = 1.0 / plan.rig()->rate_hz}));
  }
  SimulatedRun(const SimulatedRun&) = delete;
  SimulatedRun& operator=(const SimulatedRun&) = delete;

  /// Switches the drives on, without waiting, and starts the move.
  void start() {
    loop_.post(SupervisorEvent::arm);
    while (loop_.state() != SupervisorState::ready) loop_.tick(1);
    require(loop_.start(Direction::forward));
  }
  void tick() { loop_.tick(1); }
  [[nodiscard]] SupervisorState state() const { return loop_.state(); }
  [[nodiscard]] Transport& transport() { return transport_; }
  /// Throws LimitError where a loop would step.
  void set_repeat(const Plan& plan, Repeat repeat) {
    const Status status = playhead_.set_repeat(repeat);
    if (status) return;
    const std::size_t axis = plan.axis_of(static_cast<std::size_t>(std::max(status.error().axis, 0)));
    throw LimitError(place_of(plan.axes()[axis], plan.move()),
                     fmt::format("axis {}: {}; {}", in_quotes(plan.axes()[axis].name), status.error().what,
                                 status.error().remedy));
  }
  [[nodiscard]] const std::vector<SimulatedAxis>& axes() const { return rig_.axes(); }

 private:
  static void require(const Status& status) {
    if (!status) throw SolverError(status.error());
  }

  PlannedStops stops_;
  Playhead<double> playhead_;
  SimulatedRig rig_;
  SimulatedLines lines_;
  std::vector<std::size_t> drive_of_;
  std::vector<DriveState<double>> states_;
  std::vector<double> setpoints_;
  std::vector<double> positions_;
  SimulatedLoop loop_;
  Transport transport_{loop_, playhead_};
};

std::int64_t last_tick_of(const Plan& plan) {
  return last_tick(plan.played().last_frame() - plan.played().first_frame(), plan.move().fps.rate,
                   plan.rig()->rate_hz);
}

/// The move has ended, or was stopped and somebody leaves. Says which.
bool is_at_its_end(SimulatedRun& run, RunReport& report) {
  const SupervisorState state = run.state();
  const bool rests = state != SupervisorState::running && state != SupervisorState::stopping;
  if (run.transport().wants_to_leave() && rests) {
    report.ending = Ending::stopped;
    report.reason = "the move was stopped before its end";
    return true;
  }
  return state == SupervisorState::ready && !run.transport().was_stopped();
}

/// Waits for every tick. One that comes a whole period late or more delays those after it: time stands still
/// for the rig meanwhile, and there is no burst.
template <class Clock>
void play(const Plan& plan, SimulatedRun& run, const RunOptions& options, Clock& clock, RunReport& report) {
  const MonotonicClock wall;
  const std::int32_t rate_hz = plan.rig()->rate_hz;
  const std::int64_t last = last_tick_of(plan);
  WakeLatencyCounter latencies;
  TransportKeys keys;
  std::int64_t start_ns = clock.now_ns();
  std::int64_t next_progress_ns = 0;
  // In one more tick than it takes to rest the drives arrive.
  for (std::int64_t tick = 0, ticks_at_rest = 0; ticks_at_rest < 2; ++tick) {
    const std::int64_t deadline_ns =
        start_ns + tick / rate_hz * ns_per_s + tick % rate_hz * ns_per_s / rate_hz;
    clock.sleep_until_ns(deadline_ns);
    const std::int64_t latency_ns = clock.now_ns() - deadline_ns;
    latencies.add(latency_ns);
    if (latency_ns >= ns_per_s / rate_hz) {
      ++report.late_ticks;
      start_ns += latency_ns;
    }
    if (options.keys) keys.feed(options.keys());
    while (const std::optional<TransportKey> key = keys.next()) run.transport().press(*key);
    if (options.interrupted && options.interrupted()) run.transport().press(TransportKey::quit);
    if (tick > 0) run.tick();
    if (!is_at_its_end(run, report)) report.ticks = tick + 2;
    if (is_at_its_end(run, report)) ++ticks_at_rest;
    const bool shows = tick % 64 == 0 || !options.fast;
    if (!shows || wall.now_ns() < next_progress_ns) continue;
    if (options.progress) options.progress(std::min(tick, last), last);
    if (options.status) options.status(run.transport().share(plan.played()), run.transport().status());
    next_progress_ns = wall.now_ns() + ns_per_s / 10;
  }
  if (options.progress) options.progress(last, last);
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
  refuse_positions_beyond_limits(plan, last_tick_of(plan));
  SimulatedRun run(plan);
  run.set_repeat(plan, options.repeat);
  run.start();
  RunReport report;
  report.reason = "the move was played to its last frame";
  if (options.fast) {
    VirtualClock clock;
    play(plan, run, options, clock, report);
  } else {
    MonotonicClock clock;
    play(plan, run, options, clock, report);
  }
  const std::vector<SimulatedAxis>& axes = run.axes();
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
