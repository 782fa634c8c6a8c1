// Drives that tell a place which nobody vouches for: from one command to the next they are believed where
// they tell the same place, and only there.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/bus_axis.hpp"
#include "tests/support/refused_text.hpp"
#include "tests/support/rig_text.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace told_place_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A turn of the shoulder is a whole number of turns of each motor.
template <class Kind>
std::string drive_text() {
  return DriveInRig<Kind>::text();
}
template <>
std::string drive_text<CubemarsKind>() {  // which counts few turns
  return with(DriveInRig<CubemarsKind>::text(), "-0.05", "-0.0027777778");
}

/// A shoulder that turns by more than its motor remembers.
template <class Kind>
std::string shoulder(const std::string& more = "") {
  return rig_text({axis_text("shoulder", "deg", {-200, 260}, {.velocity = 40, .acceleration = 400},
                             "unpowered = \"holds\"\n" + more, drive_text<Kind>())},
                  {.rate_hz = 250, .more = DriveInRig<Kind>::bus()});
}

/// The rig in a file, and a file for its positions.
struct Stage {
  TemporaryFile rig;
  TemporaryFolder folder;
  std::string positions = (folder.path() / "kept.positions").string();

  explicit Stage(const std::string& text) : rig("rig.toml", text) {}
  [[nodiscard]] ProgramRun say(double position) const {
    return run_program({"goto", "--rig", rig.path().string(), "--positions", positions, "--stands-at",
                        fmt::format("shoulder={}", position)});
  }
  /// Simulated. `tells` is the position that the drive counts; without it, what it counted last.
  [[nodiscard]] ProgramRun go(double to, const std::string& tells = "") const {
    std::vector<std::string> words{"goto",        "--rig",   rig.path().string(),
                                   "--sim",       "--fast",  "--yes",
                                   "--positions", positions, fmt::format("shoulder={}", to)};
    if (!tells.empty()) words.insert(words.end(), {"--from", "shoulder=" + tells});
    return run_program(words);
  }
  [[nodiscard]] std::string kept() const { return file_contents(positions); }
};

template <class Kind>
class ToldPlace : public testing::Test {};
using Forgetful = testing::Types<Cia402Kind, OdriveKind, RmdKind, CubemarsKind>;
TYPED_TEST_SUITE(ToldPlace, Forgetful);

// docs/faults.md 48
TYPED_TEST(ToldPlace, ADriveThatNobodyVouchesForIsNotBelieved) {
  const Stage stage(shoulder<TypeParam>());
  const ProgramRun refused = stage.go(10, "-130");
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr("axis \"shoulder\" does not know where it is"), HasSubstr("--set-zero"),
                    HasSubstr("reference = \"drive\""), Not(HasSubstr("bring it in"))));
  EXPECT_EQ(refused.out, "");
}

TYPED_TEST(ToldPlace, AnEncoderThatSomebodyVouchesForIsBelieved) {
  const Stage stage(shoulder<TypeParam>("reference = \"drive\""));
  const ProgramRun there = stage.go(10, "20");
  EXPECT_EQ(there.status, 0) << there.err;
  EXPECT_EQ(stage.kept(), "");
}

TYPED_TEST(ToldPlace, TheSamePlaceIsBelievedInTheNextCommand) {
  const Stage stage(shoulder<TypeParam>());
  ASSERT_EQ(stage.say(230).status, 0);
  EXPECT_THAT(stage.kept(), Not(HasSubstr("zero")));
  const ProgramRun first = stage.go(228, "-130");
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_THAT(first.err, HasSubstr("230.000 -> 228.000 deg")) << "as it was said, whatever the drive counts";
  EXPECT_THAT(stage.kept(), HasSubstr("zero -3")) << "a turn less";
  const ProgramRun second = stage.go(227);
  ASSERT_EQ(second.status, 0) << second.err;
  EXPECT_THAT(second.out, HasSubstr("227."));
}

// docs/faults.md 48
TYPED_TEST(ToldPlace, AnotherPlaceIsToldInWordsAndNothingMoves) {
  const Stage stage(shoulder<TypeParam>());
  ASSERT_EQ(stage.say(230).status, 0);
  ASSERT_EQ(stage.go(229, "230").status, 0);
  const ProgramRun refused = stage.go(10, "-131");
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(
      refused.err,
      AllOf(HasSubstr("axis \"shoulder\" was left at 229"), HasSubstr("its drive tells -131"),
            HasSubstr("360 deg ("), HasSubstr(" of the "), HasSubstr("less"),
            HasSubstr("--stands-at shoulder=229"), HasSubstr("or shoulder=-131"), Not(HasSubstr("->"))));
  EXPECT_THAT(stage.kept(), HasSubstr("unreferenced shoulder"));
  EXPECT_EQ(stage.go(10, "-131").status, 1) << "until somebody has said which is true";
  ASSERT_EQ(stage.say(229).status, 0);
  const ProgramRun there = stage.go(228, "-131");
  EXPECT_EQ(there.status, 0) << there.err;
  EXPECT_THAT(there.err, HasSubstr("229.000 -> 228.000 deg"));
}

TYPED_TEST(ToldPlace, AnAxisThatHasSunkOntoItsBrakeIsWhereItsDriveTells) {
  const Stage stage(shoulder<TypeParam>());
  ASSERT_EQ(stage.say(100).status, 0);
  ASSERT_EQ(stage.go(99, "100").status, 0);
  for (int i = 0; i < 3; ++i) {
    const ProgramRun there = stage.go(99, "99.01");
    ASSERT_EQ(there.status, 0) << there.err;
    EXPECT_THAT(there.err, testing::AnyOf(HasSubstr("99.01"), HasSubstr("99.00"))) << "no sum of small steps";
  }
}

TEST(ToldPlaceOfMoteus, ProvesItselfByItsHomeState) {
  const Stage stage(shoulder<MoteusKind>());
  const ProgramRun there = stage.go(10, "20");
  EXPECT_EQ(there.status, 0) << there.err;
  EXPECT_EQ(stage.kept(), "");
}

}  // namespace told_place_test
}  // namespace inbetween
