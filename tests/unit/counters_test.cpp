#include "host_tools/rig/counters.hpp"

#include <gtest/gtest.h>

namespace inbetween {
namespace counters_test {

TEST(Counters, WhereNothingIsWrongThereIsNothingToSay) {
  Counters counts;
  counts.chips.push_back(
      {"head", counts_of(gpio::StepPlayerCounters{.played = 4000, .discarded = 3, .worst_late_ns = 12'000})});
  counts.pulses = counts_of(CueCounters{});
  EXPECT_EQ(trouble_of(counts), "");
}

TEST(Counters, WhatIsWrongIsSaidByBusDriveChipAndPulse) {
  Counters counts;
  counts.buses.push_back({"can0", counts_of(can::LaneCounters{.floods = 2}, nullptr)});
  counts.drives.push_back({"tilt", counts_of(can::DriveCounters{.missed = 12, .bad_frames = 1})});
  counts.chips.push_back({"head", counts_of(gpio::StepPlayerCounters{.refused = 5, .late = 7})});
  counts.pulses = counts_of(CueCounters{.lost = 3});
  EXPECT_EQ(
      trouble_of(counts),
      "bus can0: floods 2; tilt: missed 12, bad frames 1; chip head: refused 5, late 7; pulses: lost 3");
}

TEST(Counters, EveryCounterOfAChipIsInTheReport) {
  std::string names;
  for (const Count& count : counts_of(gpio::StepPlayerCounters{1, 2, 3, 4, 5})) {
    names += std::string(count.name) + " " + std::to_string(count.count) + "; ";
  }
  EXPECT_EQ(names, "played 1; discarded 2; refused 3; late 4; worst_late_ns 5; ");
}

TEST(Counters, EveryDelayOfStepsIsInTheReportAndNoTrouble) {
  std::string names;
  Counters counts;
  counts.drives.push_back(
      {"slide", counts_of(StepDelays{.late_steps = 1, .longest_ns = 2, .cancelled_pairs = 3})});
  for (const Count& count : counts.drives[0].counts) {
    names += std::string(count.name) + " " + std::to_string(count.count) + "; ";
  }
  EXPECT_EQ(names, "late_steps 1; longest_delay_ns 2; cancelled_pairs 3; ");
  EXPECT_EQ(trouble_of(counts), "");
}

}  // namespace counters_test
}  // namespace inbetween
