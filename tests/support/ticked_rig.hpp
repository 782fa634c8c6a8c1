// A simulated rig on a clock of the test's.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host_tools/loop/loop_storage.hpp"
#include "host_tools/loop/run_loop.hpp"
#include "host_tools/plan/plan.hpp"
#include "host_tools/rig/simulated_hardware.hpp"

namespace inbetween {

/// With its loop, switched on, standing where a plan begins.
class TickedRig {
 public:
  explicit TickedRig(const Plan& plan)
      : rig_(*plan.rig()),
        hardware_(rig_, standing_at_start(plan)),
        lines_(rig_, hardware_),
        drives_(rig_, hardware_),
        room_(rig_.axes.size(), rig_.axes.size()),
        loop(drives_, lines_, room_.memory()) {
    EXPECT_TRUE(loop.post(SupervisorEvent::arm));
    for (int i = 0; i < 5000 && loop.state() != SupervisorState::ready; ++i) tick(loop, 1);
  }
  void tick(auto& of, int count) {
    for (int i = 0; i < count; ++i) of.tick(1, now_ns_ += 1'000'000'000 / rig_.rate_hz);
  }

 private:
  static std::vector<double> standing_at_start(const Plan& plan) {
    std::vector<double> start(plan.played().axis_count());
    plan.motion().positions({plan.played().first_frame(), 0}, start);
    std::vector<double> standing(plan.rig()->axes.size());
    for (std::size_t d = 0; d < start.size(); ++d) standing[plan.axis_of(d)] = start[d];
    return standing;
  }

  const RigFile& rig_;
  SimulatedHardware hardware_;
  RigInputs lines_;
  RigDrives drives_;
  LoopStorage room_;
  std::int64_t now_ns_ = 0;

 public:
  RunLoop loop;
};

}  // namespace inbetween
