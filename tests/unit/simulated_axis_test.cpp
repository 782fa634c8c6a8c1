// The rig without hardware: axes.
#include "sim/simulated_axis.hpp"

#include <gtest/gtest.h>

namespace inbetween {
namespace simulated_axis_test {

TEST(SimulatedAxis, StandsWhereItWasPut) {
  const SimulatedAxis axis(12.5);
  EXPECT_EQ(axis.commanded(), 12.5);
  EXPECT_EQ(axis.actual(), 12.5);
  EXPECT_EQ(axis.following_error_peak(), 0);
}

TEST(SimulatedAxis, ArrivesOneTickAfterItWasTold) {
  SimulatedAxis axis(0);
  axis.tick(3);
  EXPECT_EQ(axis.commanded(), 3);
  EXPECT_EQ(axis.actual(), 0);
  axis.tick(5);
  EXPECT_EQ(axis.commanded(), 5);
  EXPECT_EQ(axis.actual(), 3);
}

TEST(SimulatedAxis, KeepsItsLargestFollowingErrorInEitherDirection) {
  SimulatedAxis axis(0);
  for (const double setpoint : {1.0, 3.0, -4.0, -4.0, -3.0}) axis.tick(setpoint);
  EXPECT_EQ(axis.following_error_peak(), 7);
  EXPECT_EQ(axis.actual(), -4);
}

}  // namespace simulated_axis_test
}  // namespace inbetween
