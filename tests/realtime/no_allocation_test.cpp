// The core takes no memory: neither while a move is made, nor while it is evaluated for hours.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <type_traits>
#include <vector>

#include "inbetween/limits/move_bounds.hpp"
#include "inbetween/limits/played_motion.hpp"
#include "inbetween/limits/roll.hpp"
#include "inbetween/limits/stop_bounds.hpp"
#include "inbetween/loop/supervisor.hpp"
#include "inbetween/play/frame_shoot.hpp"
#include "inbetween/play/playhead.hpp"
#include "inbetween/timing/frame_table.hpp"
#include "inbetween/timing/frame_time.hpp"
#include "inbetween/timing/track.hpp"
#include "tests/realtime/armed_allocator.hpp"

namespace inbetween {
namespace no_allocation_test {

using testing::Each;
using testing::Gt;

constexpr std::int64_t million = 1'000'000;
constexpr std::int32_t frames = 2400;
constexpr FrameRate fps{24, 1};

/// A move with a cusp and a dwell: every branch of the evaluation. All its memory is in itself.
class MoveInPlace {
 public:
  Result<Track> make() {
    const Result<Path> path = Path::make({.spline = Spline::tcb,
                                          .closed = false,
                                          .axis_count = 3,
                                          .keys = keys_,
                                          .weights = weights_,
                                          .shapes = shapes_},
                                         memory_.path.memory());
    if (!path) return path.error();
    const auto arc_length = ArcLength::make(*path, {}, memory_.arc_length.memory());
    if (!arc_length) return arc_length.error();
    const auto profile = SpeedProfile::make(speed_, memory_.profile.memory());
    if (!profile) return profile.error();
    return Track::make(*path, *arc_length, *profile, frames, fps, memory_.memory());
  }
  std::span<PathPoint> points() { return points_; }
  void set_tension(double tension) { shapes_[1].tension = tension; }

 private:
  std::array<double, 12> keys_{0, 0, 0, 40, 10, 3, 80, -20, 9, 120, 0, 0};
  std::array<double, 3> weights_{1, 1, 2};
  std::array<KeyShape, 4> shapes_{{{}, {.tension = 1}, {}, {}}};
  std::array<double, 9> speed_{0, 0, 10, 0, 0, 0, 0, 20, 5};
  TrackStorage<4, 3, 9, 2000> memory_;
  std::array<PathPoint, frames + 1> points_;
};

/// The error's text, or "" for a value.
template <class T>
std::string error_of(const Result<T>& result) {
  return result ? "" : result.error().what;
}

TEST(NoAllocation, AMillionPositionsTakeNoMemory) {
  const auto move = std::make_unique<MoveInPlace>();
  const auto track = move->make();
  ASSERT_TRUE(track) << error_of(track);
  std::array<double, 3> position{};
  double sum = 0;
  std::size_t hits = 0;
  {
    const ArmedAllocator armed;
    for (std::int64_t tick = 0; tick < million; ++tick) {
      track->positions(frame_time_of_tick(tick, fps, 10'000), position);
      sum += position[0];
    }
    hits = armed.hits();
  }
  EXPECT_EQ(hits, 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

TEST(NoAllocation, AMillionMotionsTakeNoMemory) {
  const auto move = std::make_unique<MoveInPlace>();
  const auto track = move->make();
  ASSERT_TRUE(track) << error_of(track);
  std::array<AxisMotion, 3> motion{};
  std::array<std::int64_t, 2> reported{};
  std::size_t hits = 0;
  {
    const ArmedAllocator armed;
    for (std::int64_t tick = 0; tick < million; ++tick) {
      const std::uint8_t order = track->motion(frame_time_of_tick(tick, fps, 10'000), motion);
      ++reported[order == 3 ? 0 : 1];
    }
    hits = armed.hits();
  }
  EXPECT_EQ(hits, 0U);
  EXPECT_EQ(reported[0] + reported[1], million);
}

TEST(NoAllocation, ATableIntoGivenMemoryTakesNoOther) {
  const auto move = std::make_unique<MoveInPlace>();
  std::size_t hits = 0;
  bool solved = false;
  double distance = 0;
  {
    const ArmedAllocator armed;
    const auto track = move->make();
    if (track) {
      const auto table = closed_form_table(*track, move->points());
      solved = table.has_value() && check_invariants(*track, *table).has_value();
      for (std::int32_t frame = 0; solved && frame <= frames; ++frame) {
        distance = frame_row(*track, *table, frame).distance;
      }
    }
    hits = armed.hits();
  }
  EXPECT_EQ(hits, 0U);
  EXPECT_TRUE(solved);
  EXPECT_GT(distance, 100);
}

/// The same move in cells, with its post-roll if it has one.
class CellsInPlace {
 public:
  static constexpr std::size_t axes = 3;
  static constexpr std::size_t cells = 256;

  explicit CellsInPlace(double tension = 1) { move_.set_tension(tension); }

  /// `roll_frames` of 0: none.
  Status make(std::span<const AxisLimits> limits, double tick_seconds, std::int32_t roll_frames) {
    const auto track = move_.make();
    if (!track) return track.error();
    track_ = *track;
    MoveRolls rolls;
    std::array<AxisMotion, axes> joints;
    joints_of({&*track_, 1}, RollEnd::after, joints);
    for (std::size_t d = 0; d < axes && roll_frames > 0; ++d) {
      const auto roll = RollAxis::make({RollEnd::after, frames, roll_frames, fps}, joints[d]);
      if (!roll) return roll.error();
      after_[d] = *roll;
      rolls.after = after_;
    }
    const auto move = Move::make(std::span<const Track>(&*track_, 1), rolls);
    if (!move) return move.error();
    write_room(limits, 1, tick_seconds, storage_.room);
    bounds_ = storage_.bounds(*move, cells);
    return bound_move(*move, {&*track_, 1}, {}, {}, storage_.memory(), bounds_);
  }
  [[nodiscard]] const MotionCells& cells_of_move() const { return bounds_.cells; }

 private:
  MoveInPlace move_;
  std::optional<Track> track_;
  std::array<RollAxis, axes> after_;
  MoveBoundsStorage<axes, 100, 1000, 100, cells> storage_;
  MoveBounds bounds_;
};

/// A move from rest that ends moving, with its post-roll, as it is played and stopped.
class PlayInPlace {
 public:
  static constexpr std::size_t axes = 3;
  static constexpr std::int32_t rate_hz = 100;

  Result<Playhead> make() {
    storage_.set_tension(0);
    const auto track = storage_.make();
    if (!track) return track.error();
    track_ = *track;
    for (AxisLimits& axis : limits_) {
      const auto limits = AxisLimits::make(
          {.min = -1000, .max = 1000, .max_velocity = 1000, .max_acceleration = 1000, .max_jerk = 100'000});
      if (!limits) return limits.error();
      axis = *limits;
    }
    if (const Status rolled = make_roll(); !rolled) return rolled.error();
    const auto played = Move::make(std::span<const Track>(&*track_, 1), {.after = after_});
    if (!played) return played.error();
    move_ = *played;
    std::array<AxisPeaks, axes> peaks;
    const double tick_seconds = 1.0 / rate_hz;
    const Status proven = cells_.make(limits_, tick_seconds, after_.front().span().frames);
    if (!proven) return proven.error();
    const auto bounds = StopBounds::make(
        {.motion = cells_.cells_of_move(), .limits = limits_, .tick_seconds = tick_seconds}, stops_, peaks);
    if (!bounds) return bounds.error();
    bounds_ = *bounds;
    return Playhead(*move_, *bounds_, rate_hz);
  }
  [[nodiscard]] const Move& move() const { return *move_; }
  void positions(const FrameTime& time, std::span<double> out) const {
    const std::span<const RollAxis> rolls = move_->rolls_at(time);
    for (std::size_t d = 0; d < rolls.size(); ++d) out[d] = rolls[d].motion(time).position;
    if (rolls.empty()) track_->positions(move_->within_part(time), out);
  }
  [[nodiscard]] const StopBounds& bounds() const { return *bounds_; }

 private:
  Status make_roll() {
    RollSpan span{.end = RollEnd::after, .joint_frame = frames, .fps = fps};
    std::array<AxisMotion, axes> joints;
    joints_of({&*track_, 1}, span.end, joints);
    const auto length = roll_frames({span.end, frames, fps, joints, limits_});
    if (!length) return length.error();
    span.frames = *length;
    for (std::size_t d = 0; d < axes; ++d) {
      const auto roll = RollAxis::make(span, joints[d]);
      if (!roll) return roll.error();
      after_[d] = *roll;
    }
    return Done{};
  }

  static AxisLimits any_limits() { return *AxisLimits::make({0, 1, 1, 1}); }

  MoveInPlace storage_;
  std::optional<Track> track_;
  std::array<RollAxis, axes> after_;
  std::array<AxisLimits, axes> limits_{any_limits(), any_limits(), any_limits()};
  std::optional<Move> move_;
  CellsInPlace cells_{0};
  std::array<StopCell, CellsInPlace::cells + 1> stops_;
  std::optional<StopBounds> bounds_;
};

/// Some command, perhaps one that is refused. Whether it was obeyed.
bool command(Playhead& playhead, const Move& move, std::mt19937& random) {
  const auto below = [&random](std::uint32_t end) { return static_cast<std::int32_t>(random() % end); };
  // On the time line or a little beside it.
  const std::int32_t frame = move.first_frame() - 100 + below(frames + 300);
  const Direction direction = below(3) == 0 ? Direction::backward : Direction::forward;
  constexpr std::array repeats{Repeat::none, Repeat::loop, Repeat::ping_pong};
  switch (below(8)) {
    case 0:
      playhead.stop();
      return true;
    case 1:
      return playhead.go_to(frame).has_value();
    case 2:
      return playhead.step(direction).has_value();
    case 3:
      return playhead.set_override(below(12) / 10.0).has_value();
    case 4:
      playhead.set_repeat(repeats.at(random() % repeats.size()));
      return true;
    case 5:
      return playhead.place_on(frame).has_value();
    default:
      return playhead.play(direction).has_value();
  }
}

TEST(NoAllocation, AMillionTicksOfPlayingTakeNoMemory) {
  const auto play = std::make_unique<PlayInPlace>();
  std::array<double, PlayInPlace::axes> position{};
  std::array<std::int64_t, 5> events{};
  std::array<std::int64_t, 4> states{};
  std::array<std::int64_t, 2> commands{};
  std::mt19937 random(1989);
  double sum = 0;
  double longest_stop_s = 0;
  std::size_t hits = 0;
  std::string error;
  {
    const ArmedAllocator armed;
    auto playhead = play->make();
    std::int64_t next_command = 0;
    for (std::int64_t tick = 0; playhead && tick < million; ++tick) {
      if (tick == next_command) {
        ++commands[command(*playhead, play->move(), random) ? 1 : 0];
        next_command += 1 + static_cast<std::int64_t>(random() % 2000);
      }
      ++events[static_cast<std::size_t>(playhead->tick())];
      ++states[static_cast<std::size_t>(playhead->state())];
      play->positions(playhead->time(), position);
      longest_stop_s =
          std::max(longest_stop_s, play->bounds().stop_from(playhead->time(), tick % 2 == 0).seconds);
      sum += position[0];
    }
    hits = armed.hits();
    if (!playhead) error = playhead.error().what;
  }
  EXPECT_EQ(error, "");
  EXPECT_EQ(hits, 0U);
  EXPECT_TRUE(std::isfinite(sum));
  EXPECT_GT(longest_stop_s, 0);
  EXPECT_LE(longest_stop_s, play->bounds().longest_in_time().length.seconds);
  // The session has been everywhere.
  EXPECT_THAT(events, Each(Gt(0)));
  EXPECT_THAT(states, Each(Gt(0)));
  EXPECT_GT(commands[0], 0);
  EXPECT_GT(commands[1], commands[0]);
}

TEST(NoAllocation, ShootingFramesInMotionTakesNoMemory) {
  const auto play = std::make_unique<PlayInPlace>();
  constexpr std::int64_t few_frames = 50;
  const ShootSpec spec{
      .settle_ticks = 3, .exposure_ticks = 1, .shutter = Shutter{-0.25, 0.25}, .exposure_s = 0.25};
  std::array<std::int64_t, shoot_phases> phases{};
  std::array<std::int32_t, frames + 1> shots{};
  std::int64_t exposures = 0;
  std::size_t hits = 0;
  std::string error;
  {
    const ArmedAllocator armed;
    auto playhead = play->make();
    if (playhead) {
      Playhead still = *playhead;
      FrameShoot shoot(spec, {.last = frames, .shots = shots}, *playhead, &still);
      Status status = shoot.check();
      if (status) status = shoot.shoot(0);
      for (std::int64_t tick = 0; status && tick < million && shoot.exposures() < few_frames; ++tick) {
        const PlayheadEvent event = playhead->tick();
        still.tick();
        shoot.tick(event);
        ++phases[static_cast<std::size_t>(shoot.phase())];
        if (shoot.phase() == ShootPhase::waiting) status = shoot.trigger();
      }
      exposures = shoot.exposures();
      if (!status) error = status.error().what;
    } else {
      error = playhead.error().what;
    }
    hits = armed.hits();
  }
  EXPECT_EQ(error, "");
  EXPECT_EQ(hits, 0U);
  EXPECT_EQ(exposures, few_frames);
  EXPECT_GT(phases[static_cast<std::size_t>(ShootPhase::settling)], 0);
  EXPECT_GT(phases[static_cast<std::size_t>(ShootPhase::exposing)], 0);
}

TEST(NoAllocation, WhyAMoveCannotBeStoppedTakesNoMemory) {
  const auto move = std::make_unique<CellsInPlace>();
  const auto stops = std::make_unique<std::array<StopCell, CellsInPlace::cells + 1>>();
  const AxisLimits weak = *AxisLimits::make({-1000, 1000, 1000, 0.001});
  const std::array limits{weak, weak, weak};
  std::size_t hits = 0;
  bool is_told = false;
  {
    const ArmedAllocator armed;
    const StopRequest request{.motion = move->cells_of_move(), .limits = limits};
    std::optional<StopObstacle> obstacle;
    if (move->make(limits, request.tick_seconds, 0)) {
      is_told = !StopBounds::make(request, *stops, {}, &obstacle) && obstacle.has_value();
    }
    hits = armed.hits();
  }
  EXPECT_EQ(hits, 0U);
  EXPECT_TRUE(is_told);
}

TEST(NoAllocation, TheSupervisorTakesNoMemory) {
  std::size_t hits = 0;
  int steps = 0;
  {
    const ArmedAllocator armed;
    for (std::size_t state = 0; state < supervisor_states; ++state) {
      for (std::size_t event = 0; event < supervisor_events; ++event) {
        const auto from = static_cast<SupervisorState>(state);
        const SupervisorStep step = supervise(from, static_cast<SupervisorEvent>(event));
        if (step.state != from || *name_of(step.state) != 0) ++steps;
      }
    }
    hits = armed.hits();
  }
  EXPECT_EQ(hits, 0U);
  EXPECT_EQ(steps, static_cast<int>(supervisor_states * supervisor_events));
}

/// Hides from the compiler that memory is taken for nothing.
template <class T>
T* escaped(T* memory) {
  asm volatile("" : "+r"(memory) : : "memory");
  return memory;
}

struct alignas(128) Wide {
  int number = 0;
};

TEST(ArmedAllocator, SeesNewAndDelete) {
  const ArmedAllocator armed;
  const int* number = escaped(new int(7));
  EXPECT_EQ(armed.hits(), 1U);
  delete number;
  EXPECT_EQ(armed.hits(), 2U);
  const int* numbers = escaped(new int[10]);
  EXPECT_EQ(armed.hits(), 3U);
  delete[] numbers;
  const Wide* wide = escaped(new Wide);
  EXPECT_EQ(armed.hits(), 5U);
  delete wide;
  EXPECT_EQ(armed.hits(), 6U);
}

TEST(ArmedAllocator, SeesEveryFunctionOfTheMallocFamily) {
  const ArmedAllocator armed;
  const auto hits_of = [&armed](auto take) {
    const std::size_t before = armed.hits();
    void* const memory = escaped(take());
    const std::size_t hits = armed.hits() - before;
    free(memory);
    return hits;
  };
  EXPECT_GE(hits_of([] { return malloc(10); }), 1U);
  EXPECT_GE(hits_of([] { return calloc(10, 10); }), 1U);
  EXPECT_GE(hits_of([] { return realloc(nullptr, 10); }), 1U);
  EXPECT_GE(hits_of([] { return aligned_alloc(64, 128); }), 1U);
  EXPECT_GE(hits_of([] {
              void* memory = nullptr;
              return posix_memalign(&memory, 64, 100) == 0 ? memory : nullptr;
            }),
            1U);
}

TEST(ArmedAllocator, SeesWhatALibraryTakes) {
  std::vector<int> numbers;
  std::string text;
  const ArmedAllocator armed;
  numbers.push_back(1);
  EXPECT_EQ(armed.hits(), 1U);
  text.assign(1000, 'x');
  EXPECT_EQ(armed.hits(), 2U);
}

TEST(ArmedAllocator, CountsOnlyWhileItIsArmed) {
  { const ArmedAllocator armed; }
  const std::vector<int> numbers(100);
  const ArmedAllocator armed;
  EXPECT_EQ(armed.hits(), 0U);
  EXPECT_EQ(escaped(numbers.data())[0], 0);
  EXPECT_EQ(armed.hits(), 0U);
}

}  // namespace no_allocation_test
}  // namespace inbetween
