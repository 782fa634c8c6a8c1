// What a DMC device is about, and what leads from where to where: one table.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace inbetween::dragonframe {

enum class DmcStage : std::uint8_t {
  jog,       ///< every motor by itself, or nothing
  all_jog,   ///< all together along the move, to a frame
  approach,  ///< the same, and a run is to follow
  preroll,   ///< to where a run or a shot begins
  wait,      ///< for GO
  shoot,     ///< from GO on, until everything rests
};
inline constexpr std::size_t dmc_stage_count = 6;

enum class DmcStep : std::uint8_t {
  motor_order,  ///< a move, jog or frame order of motors that are not live
  jog_all,
  run,
  shot,
  approached,
  in_place,
  go,
  at_rest,
  stop,
};
inline constexpr std::size_t dmc_step_count = 9;

/// The stage behind a step; nothing where the step is not possible: an order is refused, an event comes too
/// late.
[[nodiscard]] constexpr std::optional<DmcStage> after(DmcStage stage, DmcStep step) {
  using enum DmcStage;
  constexpr std::optional<DmcStage> none;
  using Row = std::array<std::optional<DmcStage>, dmc_step_count>;
  // motor_order, jog_all, run, shot, approached, in_place, go, at_rest, stop
  constexpr std::array<Row, dmc_stage_count> rows{{
      {jog, all_jog, approach, preroll, none, none, none, jog, jog},    // jog
      {none, all_jog, approach, none, jog, none, none, jog, jog},       // all_jog
      {none, all_jog, approach, none, preroll, none, none, jog, jog},   // approach
      {none, none, none, none, none, wait, none, jog, jog},             // preroll
      {jog, all_jog, approach, preroll, none, none, shoot, wait, jog},  // wait
      {none, none, none, none, none, none, none, jog, jog},             // shoot
  }};
  return rows.at(static_cast<std::size_t>(stage)).at(static_cast<std::size_t>(step));
}

}  // namespace inbetween::dragonframe
