// Whatever becomes of keys that are pressed, repeated and let go, an axis that is jogged comes to rest inside
// its limits, a bounded time after the last of them.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/loop/loop_preparations.hpp"
#include "host_tools/loop/loop_runner.hpp"
#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/motions/jog.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/rig/simulated_hardware.hpp"
#include "tests/support/property.hpp"
#include "tests/support/rig_text.hpp"

namespace inbetween {
namespace jog_property_test {

constexpr int many_hands = 3000;
constexpr int rate_hz = 250;
constexpr double tick_s = 1.0 / rate_hz;
constexpr double reach = 60;

/// What a terminal sends, by tick. Presses, repeats that begin and end anywhere, releases that come or are
/// lost, and stretches of time in which the terminal hangs: what was typed in them comes at their end.
struct Typed {
  std::map<int, std::string> at;
  int last = 0;     ///< tick of the last key
  int presses = 0;  ///< that may each be a step
  int holds = 0;    ///< that may each move it by its reach
};

Typed any_typing(bool tells_releases) {
  Typed typed;
  if (tells_releases) typed.at[2] = "\x1b[?2u";
  int tick = 10;
  const auto type = [&](int when, const std::string& key) {
    typed.at[when] += key;
    typed.last = std::max(typed.last, when);
  };
  for (int i = *rc::gen::inRange(1, 6); i > 0; --i) {
    const char letter = *rc::gen::element('C', 'D');
    if (*rc::gen::inRange(0, 5) == 0)
      type(tick, *rc::gen::element<std::string>("1", "5", " ", "4", "\x1b[B"));
    type(tick, fmt::format("\x1b[{}", letter));
    ++typed.presses;
    ++typed.holds;
    const int period = *rc::gen::inRange(1, 45);
    const int repeats = *rc::gen::inRange(0, 80);
    const int delay = *rc::gen::inRange(1, 200);
    const bool hangs = *rc::gen::inRange(0, 4) == 0;
    const int hung_until = tick + delay + *rc::gen::inRange(1, 200);
    int when = tick + delay;
    for (int repeat = 0; repeat < repeats; ++repeat, when += period) {
      const int comes = hangs ? std::max(when, hung_until) : when;
      type(comes, tells_releases ? fmt::format("\x1b[1;1:2{}", letter) : fmt::format("\x1b[{}", letter));
      if (!tells_releases && period >= 30) ++typed.presses;  // slow ones are presses
    }
    const bool is_lost = *rc::gen::arbitrary<bool>();
    if (tells_releases && !is_lost)
      type(std::max(when, hangs ? hung_until : 0), fmt::format("\x1b[1;1:3{}", letter));
    tick = when + *rc::gen::inRange(0, 150);
  }
  return typed;
}

/// A stepper axis under such keys on a virtual clock; its positions by tick.
std::vector<double> jogged(const RigFile& rig, const Typed& typed, double at, bool is_referenced, int ticks) {
  SimulatedHardware hardware(rig, std::vector<double>{at});
  RigInputs lines(rig, hardware);
  RigDrives drives(rig, hardware);
  LoopStorage room(1, 1);
  RunLoop loop(drives, lines, room.memory());
  LoopTrace trace(1);
  std::vector<double> path;
  LoopAudience audience;
  audience.keys = [&]() -> std::string {
    path.push_back(loop.setpoints()[0].position);
    const int tick = static_cast<int>(path.size());
    if (tick == ticks) return "q";
    const auto key = typed.at.find(tick);
    return key == typed.at.end() ? "" : key->second;
  };
  FastRunner runner(loop, rate_hz, audience, trace);
  Arming arming(loop);
  runner.run(arming, std::nullopt);
  FreeAxes free({*FreeAxis::make(free_limits_of(rig.axes[0], 1), at, tick_s)});
  const std::vector<std::size_t> drive_of{0};
  const std::vector<AxisLimits> limits{limits_of(rig.axes[0])};
  Jog jog(loop, {.source = source_of(free), .drive_of = drive_of, .limits = limits, .tick_seconds = tick_s},
          free,
          {{.name = "track",
            .unit = "mm",
            .increments = jog_increments(rig.axes[0]),
            .min = rig.axes[0].min,
            .max = rig.axes[0].max,
            .count = 1.0 / 40,
            .is_referenced = is_referenced,
            .reach = reach}},
          0);
  while (runner.run(jog, std::nullopt).begun && jog.asks() != Jog::Ask::none) {
    jog.asks() == Jog::Ask::mark ? jog.marked() : jog.kept();
  }
  RC_ASSERT(jog.was_left());
  return path;
}

TEST(JogProperty, WhateverBecomesOfTheKeysItRestsInsideItsLimits) {
  const RigFile rig = parse_rig(rig_text({stepper_track()}, {.rate_hz = rate_hz}), "rig.toml");
  const RigAxis& track = rig.axes[0];
  // The longest step is 5 mm and takes 0.2 s at these limits; a stop from full speed takes 0.375 s.
  constexpr int step_ticks = 100, stop_ticks = 100, silence_ticks = 39;
  int held = 0;
  int cases = 0;
  check_property(many_hands, [&] {
    const Typed typed = any_typing(*rc::gen::arbitrary<bool>());
    const bool is_referenced = *rc::gen::inRange(0, 4) != 0;
    const double at = 5.0 * *rc::gen::inRange(0, 101);
    const int rests = typed.last + silence_ticks + step_ticks + stop_ticks;
    const std::vector<double> path = jogged(rig, typed, at, is_referenced, rests + 50);
    double furthest = 0;
    double fastest = 0;
    for (std::size_t tick = 1; tick < path.size(); ++tick) {
      furthest = std::max(furthest, std::fabs(path[tick] - at));
      if (tick > 1) fastest = std::max(fastest, std::fabs(path[tick] - path[tick - 1]) / tick_s);
      if (is_referenced) RC_ASSERT(path[tick] >= track.min && path[tick] <= track.max);
      if (static_cast<int>(tick) > rests) RC_ASSERT(path[tick] == path[tick - 1]);
    }
    RC_ASSERT(fastest <= track.max_velocity * (1 + 1e-9));
    RC_ASSERT(furthest <= typed.presses * 5 + typed.holds * reach + 1e-9);
    if (furthest > typed.presses * 5) ++held;
    ++cases;
  });
  if (!counts_mean_something()) return;
  EXPECT_GT(held, cases / 10) << "keys were held";
}

}  // namespace jog_property_test
}  // namespace inbetween
