#include "host_tools/cli/take_export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "host_tools/check/check.hpp"
#include "host_tools/loop/run_record.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/plan/turns.hpp"
#include "host_tools/table/trajectory_table.hpp"
#include "host_tools/takes/taken_motion.hpp"
#include "host_tools/takes/taken_rig.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/output_file.hpp"

namespace inbetween {
namespace {

/// The frame that a record shows: of turns that in which the move is.
class ShownFrame {
 public:
  explicit ShownFrame(const Take& take) : frames_(take.frames), turns_(std::max(take.turns, 1)) {
    const std::unique_ptr<TakenMotion> motion = TakenMotion::read(take.trajectory);
    if (motion) last_ = {motion->motion().move().first_frame(), 0};
  }
  std::optional<double> of(const TakeTick& tick) {
    if (tick.time) last_ = *tick.time;
    if (!tick.shows_frame) return std::nullopt;
    const std::int32_t frames_of_turn = frames_ / turns_;
    const std::int32_t turn = std::min(std::max(last_.frame, 0) / std::max(frames_of_turn, 1), turns_ - 1);
    return last_.frame - turn * frames_of_turn + last_.fraction;
  }

 private:
  std::int32_t frames_;
  std::int32_t turns_;
  FrameTime last_;
};

/// The lines of a record; after each `written` may take what is there.
template <class Written>
std::string record_text(TakeStore& store, const Take& take, const Written& written) {
  std::vector<std::string> names;
  for (const TakeAxis& axis : take.axes) names.push_back(axis.name);
  ShownFrame frame(take);
  std::string text = head_of_record(names);
  store.read_ticks(take, [&](const TakeTick& tick) {
    put_recorded({.number = tick.number,
                  .state = tick.state,
                  .frame = frame.of(tick),
                  .told = tick.told,
                  .actual = tick.actual},
                 1.0 / take.rate_hz, text);
    written(text);
    return true;
  });
  return text;
}

/// Solved again from the texts that were kept.
Plan plan_of_take(const Take& take) {
  const TakeFile& move = file_of(take, TakeFile::Role::move);
  TakenRig taken = rig_of(take);
  PlanOptions options;
  options.kinematics = taken.kinematics;
  const FrameRange part{take.part.first, take.part.last};
  if (take.turns == 0) options.frames = part;
  Plan plan(parse_move_beside(kept_texts(take), move.text, move.path), std::move(taken.rig), options);
  if (take.turns == 0) return plan;
  options.frames = part;
  return {turns_of(plan, take.turns), plan.rig(), options};
}

}  // namespace

void export_take_csv(TakeStore& store, std::int64_t number, const std::string& file) {
  const Take take = store.read_head(number);
  write_output(file, [&](std::FILE* out) {
    constexpr std::size_t bytes_a_write = 1 << 16;
    std::string rest = record_text(store, take, [&](std::string& text) {
      if (text.size() < bytes_a_write) return;
      std::fputs(text.c_str(), out);
      text.clear();
    });
    std::fputs(rest.c_str(), out);
  });
}

std::string record_of_take(TakeStore& store, std::int64_t number) {
  return record_text(store, store.read_head(number), [](std::string&) {});
}

void export_take_trajectory(TakeStore& store, std::int64_t number, const std::string& file) {
  const Take take = store.read_head(number);
  const Plan plan = plan_of_take(take);
  if (bytes_of(plan.motion()) != take.trajectory) {
    throw TakeStoreError(
        store.file(),
        fmt::format("inbetween {} solved the move of take {} otherwise, in last bits at least; use that "
                    "version, or export --csv",
                    take.version, number));
  }
  const CheckReport report = check(plan);
  refuse_beyond_limits(report);
  const TrajectoryTable table = trajectory_table(plan, report);
  write_output(file, [&](std::FILE* out) {
    if (file.ends_with(".h")) {
      write_table_header(table, table_name_of(file), out);
    } else {
      write_table_json(table, out);
    }
  });
}

RunPlot plot_of_take(TakeStore& store, std::int64_t number) {
  const Take take = store.read_head(number);
  RunPlot plot{.name = fmt::format("{}, take {}", take.move_name, number),
               .summary = fmt::format("{} at {} Hz; {}", counted(take.ticks, "tick"), take.rate_hz,
                                      take.ending.empty() ? "the program ended before it" : take.ending),
               .axes = {}};
  for (const TakeAxis& axis : take.axes) plot.axes.push_back({.name = axis.name, .unit = axis.unit});
  std::vector<double> last_told;
  std::int64_t last = -1;
  store.read_ticks(take, [&](const TakeTick& tick) {
    const double seconds = static_cast<double>(tick.number) / take.rate_hz;
    for (std::size_t a = 0; a < plot.axes.size(); ++a) {
      RunPlotAxis& axis = plot.axes[a];
      if (!tick.told.empty()) axis.commanded.push_back({seconds, tick.told[a]});
      if (!axis.commanded.empty()) axis.actual.push_back({seconds, tick.actual[a]});
      // At the beginning of a tick a drive answers the setpoint before.
      if (!tick.told.empty() && !last_told.empty() && tick.number == last + 1)
        axis.following_error.push_back({seconds, last_told[a] - tick.actual[a]});
    }
    last_told = tick.told;
    last = tick.number;
    return true;
  });
  return plot;
}

}  // namespace inbetween
