// The line that somebody at a terminal reads while a move runs.
#include "host_tools/loop/run_snapshot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace inbetween {
namespace run_snapshot_test {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

TEST(StatusLine, TellsStateFrameAndRateAndWhatToPress) {
  RunSnapshot now{.state = SupervisorState::running,
                  .frame = 12.25,
                  .frames = 48,
                  .seconds_left = 2.96,
                  .rate = 0.5,
                  .override_rate = 0.5,
                  .keys = "space pauses, r turns"};
  EXPECT_EQ(status_line(now),
            "playing  frame 12.2 of 48  rate +0.50 of 0.50  3.0 s left | "
            "space pauses, r turns");
  now.frame = -3;
  EXPECT_EQ(phase_of(now), "pre-roll");
  for (const double end : {0.0, 48.0}) {
    now.frame = end;
    EXPECT_EQ(phase_of(now), "playing") << "the ends belong to the move";
  }
  now.frame = 48.5;
  EXPECT_EQ(phase_of(now), "post-roll");
  now.is_resting = true;
  EXPECT_THAT(status_line(now), StartsWith("paused"));
  now.backward = true;
  EXPECT_THAT(status_line(now), HasSubstr(", backward"));
  now.keys = "";
  now.state = SupervisorState::latched;
  EXPECT_THAT(status_line(now), AllOf(StartsWith("stopped: press a"), HasSubstr("a acknowledges")));
  now.state = SupervisorState::faulted;
  EXPECT_THAT(status_line(now), HasSubstr("remove the cause"));
}

TEST(StatusLine, OfAPartOfAMoveItsRollsAreOutsideOfItsFrames) {
  RunSnapshot now{
      .state = SupervisorState::running, .frame = 30, .frames = 48, .part = WholeFrames{20, 40}, .rate = 1};
  EXPECT_EQ(state_line(now), "playing  frame 30.0 of 20..40  rate +1.00 of 1.00");
  now.frame = 19.5;
  EXPECT_EQ(phase_of(now), "pre-roll");
  now.frame = 41;
  EXPECT_EQ(phase_of(now), "post-roll");
}

TEST(StatusLine, WhyAKeyDidNothingComesFirst) {
  const RunSnapshot now{
      .state = SupervisorState::running, .frames = 48, .words = "slower than this is a pause"};
  EXPECT_THAT(status_line(now), EndsWith("| slower than this is a pause"));
}

TEST(StatusLine, OfAMoveThatIsShotTellsTheFrameAndTheCamera) {
  RunSnapshot now{
      .state = SupervisorState::running,
      .shoot = ShootSnapshot{
          .phase = ShootPhase::exposing, .frame = 3, .frames = 48, .exposures = 3, .camera = true}};
  EXPECT_EQ(status_line(now), "exposing  frame 3 of 48  3 shot  CAMERA | Esc stops, q leaves");
  now.shoot->phase = ShootPhase::waiting;
  now.shoot->camera = false;
  now.shoot->is_shot = true;
  now.shoot->next = 4;
  EXPECT_THAT(status_line(now), HasSubstr("space goes on with 4, e shoots again"));
  now.shoot->next = std::nullopt;
  EXPECT_THAT(status_line(now), HasSubstr("space ends"));
  now.shoot->is_shot = false;
  now.shoot->phase = ShootPhase::standing;
  EXPECT_THAT(status_line(now), HasSubstr("space shoots it"));
  now.state = SupervisorState::latched;
  EXPECT_THAT(status_line(now), AllOf(StartsWith("stopped: press a"), HasSubstr("a acknowledges")));
}

TEST(StatusLine, OfAMotionThatIsNoMoveTellsWhichItIs) {
  const RunSnapshot now{.state = SupervisorState::running, .doing = "going to the start"};
  EXPECT_EQ(status_line(now), "going to the start | Esc stops, q leaves");
}

TEST(StatusLine, ANumberThatIsTypedIsShownWithWhatEnterDoes) {
  RunSnapshot now{.state = SupervisorState::running, .words = "of the last key", .entry = EntrySnapshot{}};
  EXPECT_EQ(hint_line(now), "go to frame _: type its number, Esc stops");
  now.entry = EntrySnapshot{.is_key = true, .number = 12};
  EXPECT_EQ(hint_line(now), "go to key 12_: Enter goes there, Backspace corrects, Esc stops");
}

}  // namespace run_snapshot_test
}  // namespace inbetween
