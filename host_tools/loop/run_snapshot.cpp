#include "host_tools/loop/run_snapshot.hpp"

#include <fmt/format.h>

namespace inbetween {
namespace {

/// The keys that mean something while nothing runs.
const char* hint_at_rest(SupervisorState state) {
  switch (state) {
    case SupervisorState::stopping:
      return "slowing down on the path";
    case SupervisorState::latched:
    case SupervisorState::cut_off:
      return "a acknowledges, q leaves";
    case SupervisorState::faulted:
      return "setpoints have ceased; remove the cause, or q leaves";
    case SupervisorState::ready:
      return "Enter starts from here, q leaves";
    default:
      return "";
  }
}

std::string line_of_shoot(const RunSnapshot& snapshot, const ShootSnapshot& shoot) {
  const bool runs = snapshot.state == SupervisorState::running;
  std::string hint = "Esc stops";
  if (shoot.phase == ShootPhase::waiting || shoot.phase == ShootPhase::standing) {
    const bool is_open = shoot.is_due && !shoot.is_shot;
    const std::string on = shoot.next ? fmt::format("space goes on with {}", *shoot.next) : "space ends";
    hint = fmt::format("{}{}, left and right look, Esc stops", is_open ? "space shoots it" : on,
                       shoot.is_shot ? ", e shoots it again" : "");
  }
  if (!runs) hint = hint_at_rest(snapshot.state);
  return fmt::format("{}  frame {} of {}  {} shot{} | {}",
                     runs ? name_of(shoot.phase) : name_of(snapshot.state), shoot.frame, shoot.frames,
                     shoot.exposures, shoot.camera ? "  CAMERA" : "",
                     *snapshot.words != 0 ? snapshot.words : hint);
}

std::string line_of_jog(const RunSnapshot& snapshot, const JogSnapshot& jog) {
  const char* hint = "left right step, 1-5 size, up down axis, q leaves";
  if (snapshot.state != SupervisorState::running) hint = hint_at_rest(snapshot.state);
  const std::string limits =
      jog.is_referenced ? fmt::format("in {:g}..{:g}", jog.min, jog.max) : std::string("UNREFERENCED");
  const std::string stop = jog.stop_way > 0 ? fmt::format("  stops in {:.3g}", jog.stop_way) : "";
  return fmt::format("{} {:.3f} {} {}  step {}: {:g}{} | {}", jog.axis, jog.position, jog.unit, limits,
                     jog.size, jog.increment, stop, *snapshot.words != 0 ? snapshot.words : hint);
}

}  // namespace

std::string status_line(const RunSnapshot& snapshot) {
  if (snapshot.jog) return line_of_jog(snapshot, *snapshot.jog);
  if (snapshot.shoot) return line_of_shoot(snapshot, *snapshot.shoot);
  const bool runs = snapshot.state == SupervisorState::running;
  const bool is_paused = runs && snapshot.is_resting;
  const char* hint = "space pauses, r turns, + - rate, Esc stops";
  if (is_paused) hint = "space plays, arrows step, r turns, q leaves";
  if (!runs) hint = hint_at_rest(snapshot.state);
  return fmt::format("{}  frame {:.1f}  rate {:+.2f} of {:.1f}{} | {}",
                     is_paused ? "paused" : name_of(snapshot.state), snapshot.frame, snapshot.rate,
                     snapshot.override_rate, snapshot.backward ? ", backward" : "",
                     *snapshot.words != 0 ? snapshot.words : hint);
}

}  // namespace inbetween
