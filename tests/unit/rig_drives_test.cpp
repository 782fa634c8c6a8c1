// What a rig file says of its CAN drives, and what is refused before a bus is opened.
#include "host_tools/rig_drives.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "host_tools/diagnostics.hpp"

namespace inbetween {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

RigFile rig_of(int axes, int rate_hz, int bitrate, const std::string& scale = "-1000.0") {
  std::string text =
      fmt::format("name = \"many\"\nrate_hz = {}\n[bus.can0]\nbitrate = {}\n", rate_hz, bitrate);
  for (int i = 1; i <= axes; ++i) {
    text += fmt::format(
        "[[axis]]\nname = \"a{}\"\nunit = \"mm\"\nmin = -10.5\nmax = 200\nmax_velocity = 250\n"
        "max_acceleration = 1000\ndrive = {{ type = \"cia402\", bus = \"can0\", node = {}, "
        "counts_per_unit = {} }}\n",
        i, i, scale);
  }
  return parse_rig(text, "rig.toml");
}

// faults.md 12
TEST(RigDrives, ABusThatWouldBeTooFullIsRefusedWithItsLoad) {
  EXPECT_NO_THROW(refuse_overloaded_buses(rig_of(5, 500, 1'000'000)));
  try {
    refuse_overloaded_buses(rig_of(6, 500, 1'000'000));
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), StartsWith("rig.toml:3:"));
    EXPECT_THAT(error.what(),
                HasSubstr("the 6 drives on bus \"can0\" need 74.8 % of its 1000000 bit/s at 500 Hz"));
    EXPECT_THAT(error.what(), HasSubstr("(5 fit)"));
  }
}

TEST(RigDrives, AnAxisTellsItsDriveItsRangeAndItsStep) {
  const RigFile rig = rig_of(1, 250, 1'000'000);
  const can::Cia402Settings settings = settings_of(rig.axes[0], rig.rate_hz);
  ASSERT_TRUE(settings.setup.position_limits);
  EXPECT_EQ(settings.setup.position_limits->least, -200'000) << "the scale turns the direction round";
  EXPECT_EQ(settings.setup.position_limits->most, 10'500);
  EXPECT_EQ(settings.max_step_counts, 1'201) << "1.2 times 250 mm/s in 4 ms, and a count for rounding";
  EXPECT_GE(settings.setup.host_timeout_ms, 90);
}

TEST(RigDrives, ASlowRigGivesItsDrivesTheTimeOfSeveralTicks) {
  const RigFile rig = rig_of(1, 10, 1'000'000);
  const can::Cia402Settings settings = settings_of(rig.axes[0], rig.rate_hz);
  EXPECT_GE(settings.setup.host_timeout_ms, 300);
  EXPECT_GE(settings.setup.setpoint_timeout_ms, 300);
}

}  // namespace
}  // namespace inbetween
