// Takes of tests: a plan that was played, with errors that the test says.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "host_tools/plan/plan.hpp"
#include "host_tools/takes/take.hpp"
#include "host_tools/takes/take_measures.hpp"

namespace inbetween {

struct PlayedTake {
  std::int64_t number = 1;
  /// So much later on the time line is every tick, in ticks, 0..1.
  double phase = 0;
  /// So many ticks the rig holds the end.
  std::int64_t rest = 40;
  /// How much further an axis was than the setpoint that it answers, which is that of the tick before.
  std::function<double(std::int64_t tick, std::size_t axis)> error = [](std::int64_t, std::size_t) {
    return 0;
  };
  /// Where the rig holds axes that are in no track.
  double held = 7;
};

/// From frame 0 to the end and beyond; the axes are those of the rig, with a resolution of 1e-9.
Take played_take(const Plan& plan, const PlayedTake& played = {});

/// The text of what `run --record` writes.
std::string record_of(const Take& take, const Plan& plan, double held = 7);

/// Of the rig of the plan.
RigMeasures measures_of(const Plan& plan);

/// A plan of these texts; the rig has no joints.
Plan plan_of(const std::string& move, const std::string& rig);

/// The crane of the examples goes round the puppet.
Plan plan_of_crane();

}  // namespace inbetween
