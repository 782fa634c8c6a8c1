#include "host_tools/loop/run_snapshot.hpp"

#include <fmt/format.h>

namespace inbetween {
namespace {

/// The keys that mean something while nothing runs.
const char* hint_at_rest(SupervisorState state) {
  switch (state) {
    case SupervisorState::enabling:
      return "Esc leaves";
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

const char* phase_at_rest(SupervisorState state) {
  switch (state) {
    case SupervisorState::disarmed:
      return "the drives are off";
    case SupervisorState::enabling:
      return "switching the drives on";
    case SupervisorState::latched:
    case SupervisorState::cut_off:
      return "stopped: press a";
    default:
      return name_of(state);
  }
}

std::string hint_of_shoot(const ShootSnapshot& shoot) {
  if (shoot.phase != ShootPhase::waiting && shoot.phase != ShootPhase::standing) return "Esc stops, q leaves";
  const bool is_open = shoot.is_due && !shoot.is_shot;
  const std::string on = shoot.next ? fmt::format("space goes on with {}", *shoot.next) : "space ends";
  return fmt::format("{}{}, left right g look, Esc stops, q leaves", is_open ? "space shoots it" : on,
                     shoot.is_shot ? ", e shoots again" : "");
}

std::string hint_of_entry(const EntrySnapshot& entry) {
  const char* of = entry.is_key ? "key" : "frame";
  if (!entry.number) return fmt::format("go to {} _: type its number, Esc stops", of);
  return fmt::format("go to {} {}_: Enter goes there, Backspace corrects, Esc stops", of, *entry.number);
}

std::string words_of(const TurnSnapshot& turn) {
  return turn.of > 0 ? fmt::format("  turn {} of {}", turn.turn, turn.of)
                     : fmt::format("  turn {}", turn.turn);
}

std::string state_of_jog(const JogSnapshot& jog) {
  const std::string limits =
      jog.is_referenced ? fmt::format("in {:g}..{:g}", jog.min, jog.max) : std::string("UNREFERENCED");
  const std::string stop = jog.stop_distance > 0 ? fmt::format("  stops in {:.3g}", jog.stop_distance) : "";
  const std::string reach = jog.reach > 0 ? fmt::format("reach {:g}  ", jog.reach) : "";
  return fmt::format("{} {:.3f} {} {}  {}step {}: {:g}{}{}", jog.axis, jog.position, jog.unit, limits, reach,
                     jog.size, jog.increment, jog.is_count ? " (a count)" : "", stop);
}

}  // namespace

std::string phase_of(const RunSnapshot& snapshot) {
  if (snapshot.state != SupervisorState::running) return phase_at_rest(snapshot.state);
  if (*snapshot.doing != 0) return snapshot.doing;
  if (snapshot.shoot) return name_of(snapshot.shoot->phase);
  if (snapshot.is_resting) return "paused";
  if (snapshot.frame < snapshot.played().first) return "pre-roll";
  return snapshot.frame > snapshot.played().last ? "post-roll" : "playing";
}

std::string state_line(const RunSnapshot& snapshot) {
  if (snapshot.jog) return state_of_jog(*snapshot.jog);
  std::string phase = phase_of(snapshot);
  if (snapshot.frames == 0 && !snapshot.shoot) return phase;
  if (const auto& shoot = snapshot.shoot) {
    return fmt::format("{}  frame {} of {}  {} shot{}", phase, shoot->frame, shoot->frames, shoot->exposures,
                       shoot->camera ? "  CAMERA" : "");
  }
  const std::string left =
      snapshot.seconds_left ? fmt::format("  {:.1f} s left", *snapshot.seconds_left) : "";
  const auto [first, last] = snapshot.played();
  const std::string of = first > 0 || last < snapshot.frames ? fmt::format("{}..{}", first, last)
                                                             : std::to_string(snapshot.frames);
  return fmt::format("{}{}  frame {:.1f} of {}  rate {:+.2f} of {:.2f}{}{}", phase,
                     snapshot.turn ? words_of(*snapshot.turn) : "", snapshot.frame, of, snapshot.rate,
                     snapshot.override_rate, snapshot.backward ? ", backward" : "", left);
}

std::string hint_line(const RunSnapshot& snapshot) {
  if (snapshot.entry) return hint_of_entry(*snapshot.entry);
  if (*snapshot.words != 0) return snapshot.words;
  if (*snapshot.keys != 0) return snapshot.keys;
  if (snapshot.state != SupervisorState::running) return hint_at_rest(snapshot.state);
  if (snapshot.jog) {
    return fmt::format("{}; 1-5 size, {}q leaves",
                       snapshot.jog->by_device ? "of the device: hold left or right, or turn"
                                               : "left right step, held: move on",
                       snapshot.jog->is_alone ? "" : "up down axis, ");
  }
  if (snapshot.shoot) return hint_of_shoot(*snapshot.shoot);
  return "Esc stops, q leaves";
}

std::string status_line(const RunSnapshot& snapshot) {
  return state_line(snapshot) + " | " + hint_line(snapshot);
}

}  // namespace inbetween
