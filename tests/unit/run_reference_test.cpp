// `run` and the axes that no drive knows: where they rest is kept from one run to the next, and an axis that
// is not known is not run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "host_tools/plan/plan.hpp"
#include "host_tools/reference/rig_reference.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace run_reference_test {

using testing::AllOf;
using testing::HasSubstr;

const std::string slide_and_pan = in_checkout("examples/slide_and_pan.toml");
const std::string slider_rig = in_checkout("examples/slider_rig.toml");

class RunReference : public testing::Test {
 protected:
  ProgramRun run(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"run",   slide_and_pan, "--rig",       slider_rig,
                                          "--sim", "--fast",      "--positions", file_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
  /// Where the axes of the rig are at an end of the move.
  std::vector<double> planned(bool at_end) {
    std::vector<double> of_move(plan_.axes().size());
    plan_.motion().positions({at_end ? plan_.played().last_frame() : plan_.played().first_frame(), 0},
                             of_move);
    std::vector<double> of_rig;
    for (const RigAxis& axis : rig_.axes) {
      for (std::size_t i = 0; i < of_move.size(); ++i) {
        if (plan_.axes()[i].name == axis.name) of_rig.push_back(of_move[i]);
      }
    }
    return of_rig;
  }
  void say_where_they_stand(const std::vector<double>& positions) {
    RigReference reference(rig_, file_);
    for (std::size_t a = 0; a < positions.size(); ++a) reference.stands_at(a, positions[a]);
  }
  void expect_kept(const std::vector<double>& positions) {
    const RigReference reference(rig_, file_);
    for (std::size_t a = 0; a < positions.size(); ++a) {
      ASSERT_TRUE(reference.is_referenced(a)) << a;
      EXPECT_NEAR(*reference.position(a), positions[a], 0.02) << "a step";
    }
  }

  const TemporaryFolder folder_;
  const std::string file_ = folder_.path() / "slider.positions";
  const RigFile rig_ = read_rig_file(slider_rig);
  const Plan plan_{read_move_file(slide_and_pan), rig_, {}};
};

TEST_F(RunReference, AnAxisThatNobodyKnowsIsNotRun) {
  const ProgramRun refused = run({"--yes"});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr("slider_rig.toml:"), HasSubstr("axis \"slide\""), HasSubstr("home")));
  EXPECT_FALSE(std::filesystem::exists(file_));
}

TEST_F(RunReference, WhereTheAxesRestAfterARunIsKept) {
  say_where_they_stand(planned(false));
  const ProgramRun played = run();
  EXPECT_EQ(played.status, 0) << played.err;
  expect_kept(planned(true));
}

TEST_F(RunReference, TheNextRunBeginsWhereTheLastOneEnded) {
  say_where_they_stand(planned(false));
  ASSERT_EQ(run().status, 0);
  // The simulated motors stand at the start; what counts is what is kept.
  const ProgramRun again = run({"--yes"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_THAT(again.err, HasSubstr("slide"));
  expect_kept(planned(true));
}

TEST_F(RunReference, ARunThatIsRefusedOnTheWayHasNotMovedThem) {
  std::vector<double> elsewhere = planned(false);
  elsewhere.front() += 20;
  say_where_they_stand(elsewhere);
  const ProgramRun refused = run();
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("is not where the move starts"));
  expect_kept(elsewhere);
}

}  // namespace run_reference_test
}  // namespace inbetween
