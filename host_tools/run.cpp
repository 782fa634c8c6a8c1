#include "host_tools/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host_tools/approach.hpp"
#include "host_tools/json_writer.hpp"
#include "host_tools/player.hpp"
#include "host_tools/staged_move.hpp"
#include "host_tools/transport.hpp"
#include "sim/simulated_rig.hpp"
#include "sim/virtual_clock.hpp"

namespace inbetween {
namespace {

/// Where a simulated axis stands before anything moves it: as near to 0 as its limits allow.
double parked(const RigAxis& axis) {
  return std::clamp(0.0, axis.min, axis.max);
}

void refuse_unknown_axis(const Plan& plan, const std::string& name) {
  for (const RigAxis& axis : plan.rig()->axes) {
    if (axis.name == name) return;
  }
  throw InputError({plan.rig()->path, 0, 0}, fmt::format("the rig {} has no axis {}; name one of its axes",
                                                         in_quotes(plan.rig()->name), in_quotes(name)));
}

void refuse_beyond_highest_rate(const Plan& plan, const CheckReport& report, double top_rate) {
  if (top_rate <= std::max(report.highest_rate, 1.0)) return;
  throw LimitError(
      plan.move().frames_place,
      fmt::format("at {:g} times the drawn speed the move leaves the limits of the rig; up to {:.3f} "
                  "times it does not",
                  top_rate, std::floor(report.highest_rate * 1000) / 1000));
}

/// Where the axes of the rig stand: at the start of the move, those in no track where they are parked, unless
/// somebody says otherwise. Throws InputError for a name that is no axis.
std::vector<double> standing_positions(const Plan& plan, std::map<std::string, double> said) {
  std::vector<double> moving(plan.played().axis_count());
  plan.played().positions({plan.played().first_frame(), 0}, moving);
  std::vector<double> positions;
  for (std::size_t a = 0; a < plan.axes().size(); ++a) {
    const PlanAxis& axis = plan.axes()[a];
    positions.push_back(axis.track ? moving[axis.move_axis] : parked(plan.rig()->axes[a]));
    if (const auto found = said.extract(axis.name)) positions.back() = found.mapped();
  }
  if (!said.empty()) refuse_unknown_axis(plan, said.begin()->first);
  return positions;
}

void refuse_positions_beyond_limits(const Plan& plan) {
  const Move<double>& move = plan.played();
  const std::int64_t last = move.last_tick_at(plan.rig()->rate_hz);
  std::vector<double> positions(move.axis_count());
  for (std::int64_t tick = 0; tick <= last; ++tick) {
    const FrameTime<double> when = move.time_of_tick(tick, plan.rig()->rate_hz);
    move.positions(when, positions);
    for (std::size_t d = 0; d < positions.size(); ++d) {
      if (positions[d] >= plan.limits()[d].min() && positions[d] <= plan.limits()[d].max()) continue;
      const std::size_t a = plan.axis_of(d);
      const RigAxis& axis = plan.rig()->axes[a];
      throw LimitError(
          plan.place_of(a),
          fmt::format("axis {} would go to {} {} at frame {:.2f}, outside {}..{} of the rig {}; "
                      "move its keys inward",
                      in_quotes(axis.name), positions[d], to_string(axis.unit), when.frame + when.fraction,
                      axis.min, axis.max, in_quotes(plan.rig()->name)));
    }
  }
}

/// A simulated rig under the motion loop.
class RigOnLoop {
 public:
  explicit RigOnLoop(const std::vector<double>& positions)
      : rig_(positions),
        states_(positions.size()),
        setpoints_(positions.size()),
        positions_(positions.size()),
        still_positions_(positions.size()),
        loop_(rig_, lines_, {states_, setpoints_, positions_, still_positions_}) {}
  RigOnLoop(const RigOnLoop&) = delete;
  RigOnLoop& operator=(const RigOnLoop&) = delete;

  /// Switches the drives on.
  void arm() {
    loop_.post(SupervisorEvent::arm);
    while (loop_.state() != SupervisorState::ready) loop_.tick(1, 0);
  }
  [[nodiscard]] SimulatedLoop& loop() { return loop_; }
  [[nodiscard]] const std::vector<SimulatedAxis>& axes() const { return rig_.axes(); }

 private:
  SimulatedRig rig_;
  SimulatedLines lines_;
  std::vector<DriveState<double>> states_;
  std::vector<double> setpoints_;
  std::vector<double> positions_;
  std::vector<double> still_positions_;
  SimulatedLoop loop_;
};

void require(const Status& status) {
  if (!status) throw SolverError(status.error());
}

/// The slow way to the start; nothing where the rig stands there. Throws InputError where nobody can agree.
std::optional<Plan> allowed_approach(const Plan& plan, const std::vector<double>& actual,
                                     const RunOptions& options) {
  std::optional<Plan> approach = plan_approach(plan, actual);
  if (!approach) return approach;
  refuse_positions_beyond_limits(*approach);
  if (options.confirm) return approach;
  throw InputError(
      {plan.move().path, 0, 0},
      fmt::format("axis {} of the rig is not where the move starts; bring it there, or agree to let "
                  "it go there slowly (--yes)",
                  in_quotes(approach->move().tracks.front().axes.front())));
}

/// Plays one performance; whether it came to its end.
template <class Clock, class Performance>
bool perform(Player<Clock>& player, Performance& performance, std::optional<std::int64_t> last,
             RunReport& report) {
  report.ticks = player.play(performance, last);
  if (performance.is_done()) return true;
  report.ending = Ending::stopped;
  report.reason = "the move was stopped before its end";
  return false;
}

template <class Clock>
void run_on(RigOnLoop& rig, StagedMove& staged, const std::optional<Plan>& approach,
            const RunOptions& options, RunReport& report) {
  const std::int32_t rate_hz = staged.plan().rig()->rate_hz;
  const std::int64_t last = staged.plan().played().last_tick_at(rate_hz);
  Player<Clock> player(options, rate_hz, report);
  SimulatedLoop& loop = rig.loop();
  rig.arm();
  if (approach) {
    StagedMove way(*approach);
    require(loop.load(way.loop_spec()));
    Transport transport(loop, way);
    require(transport.begin());
    if (!perform(player, transport, std::nullopt, report)) return;
  }
  require(loop.load(staged.loop_spec()));
  if (options.shoot) {
    SimulatedCamera camera(!options.keys);
    Shooting shooting(loop, staged, camera, shoot_spec(*options.shoot, rate_hz));
    require(shooting.begin());
    perform(player, shooting, std::nullopt, report);
    report.exposures = shooting.exposures();
  } else {
    Transport transport(loop, staged);
    require(transport.begin());
    perform(player, transport, last, report);
  }
  if (options.progress) options.progress(last, last);
  report.wake_latency = player.latencies();
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
  const CheckReport checked = check(plan);
  refuse_beyond_limits(checked);
  refuse_positions_beyond_limits(plan);
  refuse_beyond_highest_rate(plan, checked, options.top_rate);
  std::vector<std::string> still;
  if (options.shoot) still = options.shoot->still;
  for (const std::string& axis : still) refuse_unknown_axis(plan, axis);
  StagedMove staged(plan, options.top_rate, still);
  staged.set_repeat(options.repeat);
  if (options.shoot) refuse_exposures(staged, shoot_spec(*options.shoot, plan.rig()->rate_hz));
  const std::vector<double> standing = standing_positions(plan, options.standing);
  const std::optional<Plan> approach = allowed_approach(plan, standing, options);
  RunReport report;
  report.reason = options.shoot ? "every frame was shot" : "the move was played to its last frame";
  RigOnLoop rig(standing);
  if (approach && !options.confirm(describe_approach(*approach))) {
    report.ending = Ending::stopped;
    report.reason = "nobody agreed that the rig goes to the start of the move";
  } else if (options.fast) {
    run_on<VirtualClock>(rig, staged, approach, options, report);
  } else {
    run_on<MonotonicClock>(rig, staged, approach, options, report);
  }
  const std::vector<SimulatedAxis>& axes = rig.axes();
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
  if (report.exposures) json.member("exposures", *report.exposures);
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
