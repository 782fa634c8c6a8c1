// What plays: the trajectories of tracks side by side, their parts, and the rolls that join them.
#include "inbetween/limits/played_motion.hpp"

#include <gtest/gtest.h>

#include <array>
#include <deque>
#include <vector>

#include "host_tools/plan/fitted_trajectory.hpp"
#include "host_tools/plan/solved_track.hpp"

namespace inbetween {
namespace played_motion_test {

constexpr FrameRate film{24, 1};

/// One axis through some keys.
SolvedTrack track_of(const std::vector<double>& keys, const std::vector<double>& speed) {
  TrackSpec spec;
  spec.path = {.spline = Spline::smooth, .closed = false, .axis_count = 1, .keys = keys};
  spec.control_values = speed;
  spec.frames = 48;
  spec.fps = film;
  return SolvedTrack(spec, Solver::closed_form);
}

/// Tracks with their trajectories.
class Fitted {
 public:
  explicit Fitted(std::vector<Track> tracks) : tracks_(std::move(tracks)) {
    for (const Track& track : tracks_) trajectories_.push_back(*fitted_.emplace_back(track));
  }
  bool joints(RollEnd end, const WholeFrames& part, std::span<AxisMotion> out) const {
    return joints_of_part(tracks_, trajectories_, part, end, out);
  }
  [[nodiscard]] std::vector<RollAxis> rolls(RollEnd end, std::int32_t frames, const WholeFrames& part) const {
    std::size_t axes = 0;
    for (const Trajectory& trajectory : trajectories_) axes += trajectory.axis_count();
    std::vector<AxisMotion> at(axes);
    joints(end, part, at);
    std::vector<RollAxis> made;
    const std::int32_t joint_frame = end == RollEnd::before ? part.first : part.last;
    for (const AxisMotion& joint : at)
      made.push_back(*RollAxis::make({end, joint_frame, frames, film}, joint));
    return made;
  }
  [[nodiscard]] PlayedMotion played(const MoveRolls& rolls, const WholeFrames& part) const {
    return *PlayedMotion::make(*Move::make(tracks_, rolls, part), trajectories_);
  }

 private:
  std::vector<Track> tracks_;
  std::deque<FittedTrajectory> fitted_;
  std::vector<Trajectory> trajectories_;
};

TEST(PlayedMotion, APartHasThePositionsOfTheWholeToTheLastBitBetweenRollsOfItsOwn) {
  const auto one = track_of({0, 30, 100}, {0, 0, 10, 0, 0});
  const auto other = track_of({-1, 2, 7}, {5, 10, 7});
  const Fitted fitted({one.track(), other.track()});
  constexpr WholeFrames part{12, 36};
  const auto before = fitted.rolls(RollEnd::before, 10, part);
  const auto after = fitted.rolls(RollEnd::after, 20, part);
  const PlayedMotion whole = fitted.played({}, {0, 48});
  const PlayedMotion played = fitted.played({before, after}, part);
  const Move* const move = &played.move();
  EXPECT_EQ(move->part(), part);
  EXPECT_EQ(move->first_frame(), 2);
  EXPECT_EQ(move->last_frame(), 56);
  EXPECT_EQ(move->time_of_tick(0, 240).frame, 2) << "the frames have the numbers of the whole";
  EXPECT_EQ(move->last_tick_at(240), 540);

  std::array<double, 2> of_part, of_whole;
  for (std::int32_t frame = 12; frame <= 36; ++frame) {
    for (const double fraction : {0.0, 0.3}) {
      if (frame == 36 && fraction > 0) continue;
      played.positions({frame, fraction}, of_part);
      whole.positions({frame, fraction}, of_whole);
      EXPECT_EQ(of_part, of_whole) << frame;
    }
  }
  std::array<AxisMotion, 2> outside, inside;
  for (const std::int32_t frame : {-5, 2, 56, 57}) {
    played.motion({frame, 0}, outside);
    EXPECT_EQ(outside[0].velocity, 0) << frame;
    EXPECT_EQ(outside[1].acceleration, 0) << frame;
    EXPECT_EQ(outside[0].position, (frame < 12 ? before : after)[0].rest_position());
  }
  for (const std::int32_t joint : {12, 36}) {
    const double step = 1.0 / 1024;
    played.motion(joint == 12 ? FrameTime{11, 1 - step} : FrameTime{36, step}, outside);
    whole.motion({joint, 0}, inside);
    for (std::size_t d = 0; d < 2; ++d) {
      EXPECT_NEAR(outside[d].position, inside[d].position, 0.01);
      EXPECT_NEAR(outside[d].velocity, inside[d].velocity, 0.05);
      EXPECT_NEAR(outside[d].acceleration, inside[d].acceleration, 2);
    }
  }
}

TEST(PlayedMotion, APartThatBeginsAndEndsInAHoldRestsThereWithoutRolls) {
  TrackSpec spec;
  const std::vector<double> keys{0, 40, 100};
  spec.path = {.axis_count = 1, .keys = keys};
  const std::vector<double> speed{0, 0, 10, 10, 10, 0, 0};
  spec.control_values = speed;
  const std::array locks{KeyLock{.key = 1, .frame = 40, .hold = 12}};
  spec.locks = locks;
  spec.frames = 96;
  spec.fps = film;
  const SolvedTrack solved(spec, Solver::closed_form);
  const Fitted fitted({solved.track()});
  std::vector<AxisMotion> joints(1);
  for (const WholeFrames& part : {WholeFrames{0, 40}, {0, 46}, {0, 52}}) {
    EXPECT_FALSE(fitted.joints(RollEnd::after, part, joints)) << part.last;
    EXPECT_NEAR(joints[0].position, 40, 1e-9);
    EXPECT_FALSE(fitted.joints(RollEnd::before, WholeFrames{part.last, 96}, joints));
  }
  EXPECT_TRUE(fitted.joints(RollEnd::after, WholeFrames{0, 39}, joints));

  const PlayedMotion played = fitted.played({}, {46, 96});
  std::array<double, 1> position;
  played.positions({20, 0.5}, position);
  EXPECT_NEAR(position[0], 40, 1e-9) << "where it rests, and not where the whole move is on frame 20";
}

TEST(PlayedMotion, ARollJoinsTheInnerSideOfAKeyOnWhichTheMotionSteps) {
  // Frame 24 is on the corner: first along one axis, then along the other.
  const std::vector<double> keys{0, 0, 100, 0, 100, 60};
  const std::vector<double> speed{10, 10};
  const std::vector<std::int32_t> frames{0, 24, 48};
  TrackSpec drawn;
  drawn.path = {.spline = Spline::linear, .axis_count = 2, .keys = keys};
  drawn.fps = film;
  drawn.frames = 48;
  TrackSpec timed = drawn;
  timed.key_frames = frames;
  timed.kinetic = Kinetic::linear;
  drawn.control_values = speed;
  const std::array locks{KeyLock{.key = 1, .frame = 24}};
  drawn.locks = locks;
  const std::array broken_locks{KeyLock{.key = 1, .frame = 24, .breaks = true}};
  TrackSpec broken = drawn;
  broken.locks = broken_locks;
  for (const TrackSpec& spec : {drawn, broken, timed}) {
    const SolvedTrack solved(spec, Solver::closed_form);
    const Fitted fitted({solved.track()});
    std::vector<AxisMotion> joints(2);
    ASSERT_TRUE(fitted.joints(RollEnd::after, WholeFrames{0, 24}, joints));
    EXPECT_GT(joints[0].velocity, 60);
    EXPECT_EQ(joints[1].velocity, 0);
    EXPECT_NEAR(joints[0].position, 100, 1e-9);
    ASSERT_TRUE(fitted.joints(RollEnd::before, WholeFrames{24, 48}, joints));
    EXPECT_EQ(joints[0].velocity, 0);
    EXPECT_GT(joints[1].velocity, 30);
    // The motion of a part arrives on its last frame as its post-roll goes on.
    const auto after = fitted.rolls(RollEnd::after, 30, {0, 24});
    fitted.played({{}, after}, {0, 24}).motion({24, 0}, joints);
    EXPECT_GT(joints[0].velocity, 60);
    EXPECT_EQ(joints[1].velocity, 0);
  }
}

TEST(PlayedMotion, TrajectoriesOfOtherTracksAreRefused) {
  const auto one = track_of({0, 30, 100}, {0, 0, 10, 0, 0});
  const std::array tracks{one.track()};
  const FittedTrajectory fitted(one.track());
  const Move move = *Move::make(tracks, {});
  const std::array part{fitted->part({3, 0}, {20, 0})};
  EXPECT_EQ(PlayedMotion::make(move, {}).error().code, ErrorCode::wrong_count);
  EXPECT_EQ(PlayedMotion::make(move, part).error().code, ErrorCode::out_of_range);
}

TEST(PlayedMotion, AMotorPlaysItsRollsAndRestsBeyondThem) {
  const auto one = track_of({0, 30, 100}, {5, 10, 7});
  const std::array tracks{one.track()};
  const Fitted fitted({one.track()});
  constexpr WholeFrames whole_move{0, 48};
  const auto before = fitted.rolls(RollEnd::before, 10, whole_move);
  const auto after = fitted.rolls(RollEnd::after, 20, whole_move);
  const std::array<CalibrationMark, 3> marks{{{-100, -10}, {50, 20}, {200, 80}}};
  std::array<CalibrationPiece, 4> pieces;
  const auto curve = Calibration::make(marks, pieces);
  ASSERT_TRUE(curve);
  const FittedTrajectory axis(one.track());
  const FittedMotor whole(MotorSource{&*axis, 0, &*curve, axis.travel(0)});
  const FittedMotor pre_roll(before[0], *curve);
  const FittedMotor post_roll(after[0], *curve);
  const PlayedMotor motor{.axis = 0, .whole = &*whole, .pre_roll = &*pre_roll, .post_roll = &*post_roll};
  const std::array trajectories{*axis};
  const auto played = PlayedMotion::make(*Move::make(tracks, {before, after}), trajectories, {&motor, 1});
  ASSERT_TRUE(played);
  const auto same = [](const AxisMotion& found, const AxisMotion& expected) {
    return found.position == expected.position && found.velocity == expected.velocity &&
           found.acceleration == expected.acceleration && found.jerk == expected.jerk;
  };
  for (const FrameTime& time : {FrameTime{-9, 0.5}, {-1, 0.25}})
    EXPECT_TRUE(same(played->motion_of(motor, time), (*pre_roll).motion_of(0, time))) << time.frame;
  for (const FrameTime& time : {FrameTime{0, 0}, {20, 0.5}, {48, 0}})
    EXPECT_TRUE(same(played->motion_of(motor, time), (*whole).motion_of(0, time))) << time.frame;
  for (const FrameTime& time : {FrameTime{48, 0.5}, {60, 0}})
    EXPECT_TRUE(same(played->motion_of(motor, time), (*post_roll).motion_of(0, time))) << time.frame;
  for (const std::int32_t frame : {-12, 70}) {
    const AxisMotion rest = played->motion_of(motor, {frame, 0});
    EXPECT_EQ(rest.velocity, 0) << frame;
    EXPECT_EQ(rest.position, curve->motor_at((frame < 0 ? before : after)[0].rest_position())) << frame;
  }
}

TEST(PlayedMotion, ALoopMayStepInNoneOfItsTracks) {
  const std::vector<double> speed{0, 0, 10, 0, 0};
  const auto round = track_of({3, 30, 3}, speed);
  const auto further = track_of({3, 30, 4}, speed);
  const Fitted good({round.track(), round.track()});
  EXPECT_TRUE(can_loop(good.played({}, {0, 48})));
  const Fitted bad({round.track(), further.track()});
  const Status refused = can_loop(bad.played({}, {0, 48}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().axis, 1);
}

TEST(PlayedMotion, OneAxisIsThatOfAllToTheLastBit) {
  const std::vector<double> keys{0, 0, 50, 20, 60, 90, 0, 100};
  const std::vector<double> speed{0, 0, 10, 4, 10, 0, 0};
  const SolvedTrack solved({.path = {.axis_count = 2, .keys = keys},
                            .control_values = speed,
                            .frames = 48,
                            .fps = film,
                            .arc_length = {}},
                           Solver::closed_form);
  const FittedTrajectory fitted(solved.track());
  std::array<AxisMotion, 2> all;
  for (int i = -20; i <= 500; ++i) {
    const FrameTime time = moved_by({0, 0}, i / 10.0);
    fitted->motion(time, all);
    for (std::size_t d = 0; d < all.size(); ++d) {
      const AxisMotion one = fitted->motion_of(d, time);
      EXPECT_EQ(one.position, all[d].position) << i;
      EXPECT_EQ(one.velocity, all[d].velocity) << i;
      EXPECT_EQ(one.acceleration, all[d].acceleration) << i;
      EXPECT_EQ(one.jerk, all[d].jerk) << i;
    }
  }
}

}  // namespace played_motion_test
}  // namespace inbetween
