#include "host_tools/motions/run_take.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "host_tools/move_model/move_cue.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {
namespace {

/// ISO 8601, in milliseconds.
std::string utc_now() {
  const auto now = std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
  const auto seconds = std::chrono::floor<std::chrono::seconds>(now);
  return fmt::format("{:%FT%T}.{:03}Z", fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)),
                     (now - seconds).count());
}

/// All that is known of it before it is played.
Take take_of(const StagedMove& staged, const SessionOptions& rig, const RunOptions& options) {
  const Plan& plan = staged.plan();
  Take take;
  take.move_name = plan.move().name;
  take.rig_name = plan.rig()->name;
  take.started_at = utc_now();
  take.version = options.take->version;
  take.is_simulated = rig.simulated;
  take.rate_hz = plan.rig()->rate_hz;
  take.frame_rate = plan.played().frame_rate();
  take.frames = plan.move().frames;
  take.part = plan.part();
  take.turns = options.turns ? options.turns->turns : 0;
  take.is_repeated = options.repeat != Repeat::none || (options.turns && options.turns->goes_round);
  take.is_shot = options.shoot.has_value();
  take.top_rate = staged.playhead().top_rate();
  for (const PlanAxis& axis : plan.axes()) {
    const RigAxis& of_rig = plan.rig()->axes[take.axes.size()];
    take.axes.push_back(take_axis_of(of_rig, axis.track ? std::optional(axis.move_axis) : std::nullopt));
  }
  take.files = options.take->files;
  take.trajectory = bytes_of(plan.motion());
  return take;
}

}  // namespace

std::unique_ptr<TakeRecorder> begun_take(const StagedMove& staged, const SessionOptions& rig,
                                         const RunOptions& options) {
  if (!options.take) return nullptr;
  TakeKeeping keeping = options.take->keeping;
  keeping.waits = rig.fast;
  const std::int32_t frames_of_turn = options.turns && options.turns->goes_round ? options.turns->frames : 0;
  keeping.pulse_words = [pulses = cue_pulses(staged.plan().move(), staged.plan().part()),
                         frames_of_turn](std::size_t number) {
    const CuePulse& pulse = pulses[number];
    const std::int32_t frame = frames_of_turn > 0 ? pulse.frame % frames_of_turn : pulse.frame;
    return fmt::format("{} at frame {}", pulse.line, frame + pulse.phase);
  };
  try {
    return std::make_unique<TakeRecorder>(keeping, take_of(staged, rig, options));
  } catch (const TakeStoreError& error) {
    fmt::print(stderr, "{}: warning: this run is no take: {}\n", keeping.file, error.message());
    return nullptr;
  }
}

void refuse_to_follow(const FollowedTake& take, const StagedMove& staged) {
  const Status possible = staged.playhead().can_follow(take.places);
  if (possible) return;
  const std::int64_t tick = possible.error().needed;
  throw InputError({staged.plan().move().path, 0, 0},
                   fmt::format("{} cannot be played again: in tick {} it is not within what this run may do; "
                               "a tick came late then, or the run was faster than this one may be",
                               take.name, tick));
}

}  // namespace inbetween
