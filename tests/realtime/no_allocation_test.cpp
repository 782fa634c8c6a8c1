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
#include "inbetween/timing/ode_frame_table.hpp"
#include "inbetween/timing/track.hpp"
#include "tests/realtime/armed_allocator.hpp"

namespace inbetween {
namespace no_allocation_test {

using testing::Each;
using testing::Gt;

constexpr std::int64_t million = 1'000'000;
constexpr std::int32_t frames = 2400;
constexpr FrameRate fps{24, 1};

struct PrecisionName {
  template <class Real>
  static std::string GetName(int) {
    return std::is_same_v<Real, double> ? "double" : "float";
  }
};

template <class Real>
class NoAllocationIn : public testing::Test {};
using Precisions = testing::Types<double, float>;
TYPED_TEST_SUITE(NoAllocationIn, Precisions, PrecisionName);

/// A move with a cusp and a dwell: every branch of the evaluation. All its memory is in itself.
template <Precise Real>
class MoveInPlace {
 public:
  Result<Track<Real>> make() {
    const Result<Path<Real>> path = Path<Real>::make({.spline = Spline::tcb,
                                                      .closed = false,
                                                      .axis_count = 3,
                                                      .keys = keys_,
                                                      .weights = weights_,
                                                      .shapes = shapes_},
                                                     memory_.path.memory());
    if (!path) return path.error();
    const auto arc_length = ArcLength<Real>::make(*path, {}, memory_.arc_length.memory());
    if (!arc_length) return arc_length.error();
    const auto profile = SpeedProfile<Real>::make(speed_, memory_.profile.memory());
    if (!profile) return profile.error();
    return Track<Real>::make(*path, *arc_length, *profile, frames, fps, memory_.memory());
  }
  std::span<OdeSegment<Real>> segments() { return segments_; }
  std::span<PathPoint<Real>> points() { return points_; }
  void set_tension(Real tension) { shapes_[1].tension = tension; }

 private:
  std::array<Real, 12> keys_{0, 0, 0, 40, 10, 3, 80, -20, 9, 120, 0, 0};
  std::array<Real, 3> weights_{1, 1, 2};
  std::array<KeyShape<Real>, 4> shapes_{{{}, {.tension = 1}, {}, {}}};
  std::array<Real, 9> speed_{0, 0, 10, 0, 0, 0, 0, 20, 5};
  TrackStorage<Real, 4, 3, 9, 2000> memory_;
  std::array<OdeSegment<Real>, 4> segments_;
  std::array<PathPoint<Real>, frames + 1> points_;
};

/// The error's text, or "" for a value.
template <class T>
std::string error_of(const Result<T>& result) {
  return result ? "" : result.error().what;
}

TYPED_TEST(NoAllocationIn, AMillionPositionsTakeNoMemory) {
  using Real = TypeParam;
  const auto move = std::make_unique<MoveInPlace<Real>>();
  const auto track = move->make();
  ASSERT_TRUE(track) << error_of(track);
  std::array<Real, 3> position{};
  Real sum = 0;
  std::size_t hits = 0;
  {
    const ArmedAllocator armed;
    for (std::int64_t tick = 0; tick < million; ++tick) {
      track->positions(frame_time_of_tick<Real>(tick, fps, 10'000), position);
      sum += position[0];
    }
    hits = armed.hits();
  }
  EXPECT_EQ(hits, 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

TYPED_TEST(NoAllocationIn, AMillionMotionsTakeNoMemory) {
  using Real = TypeParam;
  const auto move = std::make_unique<MoveInPlace<Real>>();
  const auto track = move->make();
  ASSERT_TRUE(track) << error_of(track);
  std::array<AxisMotion<Real>, 3> motion{};
  std::array<std::int64_t, 2> reported{};
  std::size_t hits = 0;
  {
    const ArmedAllocator armed;
    for (std::int64_t tick = 0; tick < million; ++tick) {
      const std::uint8_t order = track->motion(frame_time_of_tick<Real>(tick, fps, 10'000), motion);
      ++reported[order == 3 ? 0 : 1];
    }
    hits = armed.hits();
  }
  EXPECT_EQ(hits, 0U);
  EXPECT_EQ(reported[0] + reported[1], million);
}

TYPED_TEST(NoAllocationIn, ATableIntoGivenMemoryTakesNoOther) {
  using Real = TypeParam;
  const auto move = std::make_unique<MoveInPlace<Real>>();
  std::size_t hits = 0;
  bool solved = false;
  Real distance = 0;
  {
    const ArmedAllocator armed;
    const auto track = move->make();
    if (track) {
      const auto table = closed_form_table<Real>(*track, move->points());
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

TYPED_TEST(NoAllocationIn, RungeKuttaTakesNoMemoryEither) {
  using Real = TypeParam;
  const auto move = std::make_unique<MoveInPlace<Real>>();
  std::size_t hits = 0;
  bool refused = false;
  bool solved = false;
  {
    const ArmedAllocator armed;
    const auto still = move->make();
    refused = still && !runge_kutta_table<Real>(*still, {}, move->segments(), move->points());
    move->set_tension(0);
    const auto track = move->make();
    solved = track && runge_kutta_table<Real>(*track, {}, move->segments(), move->points()).has_value();
    hits = armed.hits();
  }
  EXPECT_EQ(hits, 0U);
  EXPECT_TRUE(refused);
  if (std::is_same_v<Real, double>) {  // 24 000 steps are too many for the digits of float
    EXPECT_TRUE(solved);
  }
}

/// The same move in double, in cells, with its post-roll if it has one.
class CellsInPlace {
 public:
  static constexpr std::size_t axes = 3;
  static constexpr std::size_t cells = 256;

  explicit CellsInPlace(double tension = 1) { move_.set_tension(tension); }

  /// For limits of any precision. `roll_frames` of 0: none.
  template <Precise Real>
  Status make(std::span<const AxisLimits<Real>> limits, Real tick_seconds, std::int32_t roll_frames) {
    const auto track = move_.make();
    if (!track) return track.error();
    track_ = *track;
    MoveRolls<double> rolls;
    std::array<AxisMotion<double>, axes> joints;
    joints_of<double>({&*track_, 1}, RollEnd::after, joints);
    for (std::size_t d = 0; d < axes && roll_frames > 0; ++d) {
      const auto roll = RollAxis<double>::make({RollEnd::after, frames, roll_frames, fps}, joints[d]);
      if (!roll) return roll.error();
      after_[d] = *roll;
      rolls.after = after_;
    }
    const auto move = Move<double>::make(std::span<const Track<double>>(&*track_, 1), rolls);
    if (!move) return move.error();
    write_room<Real>(limits, 1, tick_seconds, storage_.room);
    bounds_ = storage_.bounds(*move, cells);
    return bound_move(*move, {&*track_, 1}, {}, {}, storage_.memory(), bounds_);
  }
  [[nodiscard]] const MotionCells& cells_of_move() const { return bounds_.cells; }

 private:
  MoveInPlace<double> move_;
  std::optional<Track<double>> track_;
  std::array<RollAxis<double>, axes> after_;
  MoveBoundsStorage<axes, 100, 1000, 100, cells> storage_;
  MoveBounds bounds_;
};

/// A move from rest that ends moving, with its post-roll, as it is played and stopped.
template <Precise Real>
class PlayInPlace {
 public:
  static constexpr std::size_t axes = 3;
  static constexpr std::int32_t rate_hz = 100;

  Result<Playhead<Real>> make() {
    storage_.set_tension(0);
    const auto track = storage_.make();
    if (!track) return track.error();
    track_ = *track;
    for (AxisLimits<Real>& axis : limits_) {
      const auto limits = AxisLimits<Real>::make(
          {.min = -1000, .max = 1000, .max_velocity = 1000, .max_acceleration = 1000, .max_jerk = 100'000});
      if (!limits) return limits.error();
      axis = *limits;
    }
    if (const Status rolled = make_roll(); !rolled) return rolled.error();
    const auto played = Move<Real>::make(std::span<const Track<Real>>(&*track_, 1), {.after = after_});
    if (!played) return played.error();
    move_ = *played;
    std::array<AxisPeaks<Real>, axes> peaks;
    const Real tick_seconds = Real{1} / rate_hz;
    const Status proven = cells_.make<Real>(limits_, tick_seconds, after_.front().span().frames);
    if (!proven) return proven.error();
    const auto bounds = StopBounds<Real>::make(
        {.motion = cells_.cells_of_move(), .limits = limits_, .tick_seconds = tick_seconds}, stops_, peaks);
    if (!bounds) return bounds.error();
    bounds_ = *bounds;
    return Playhead<Real>(*move_, *bounds_, rate_hz);
  }
  [[nodiscard]] const Move<Real>& move() const { return *move_; }
  void positions(const FrameTime<Real>& time, std::span<Real> out) const {
    const std::span<const RollAxis<Real>> rolls = move_->rolls_at(time);
    for (std::size_t d = 0; d < rolls.size(); ++d) out[d] = rolls[d].motion(time).position;
    if (rolls.empty()) track_->positions(move_->within_part(time), out);
  }
  [[nodiscard]] const StopBounds<Real>& bounds() const { return *bounds_; }

 private:
  Status make_roll() {
    RollSpan span{.end = RollEnd::after, .joint_frame = frames, .fps = fps};
    std::array<AxisMotion<Real>, axes> joints;
    joints_of<Real>({&*track_, 1}, span.end, joints);
    const auto length = roll_frames<Real>({span.end, frames, fps, joints, limits_});
    if (!length) return length.error();
    span.frames = *length;
    for (std::size_t d = 0; d < axes; ++d) {
      const auto roll = RollAxis<Real>::make(span, joints[d]);
      if (!roll) return roll.error();
      after_[d] = *roll;
    }
    return Done{};
  }

  static AxisLimits<Real> any_limits() { return *AxisLimits<Real>::make({0, 1, 1, 1}); }

  MoveInPlace<Real> storage_;
  std::optional<Track<Real>> track_;
  std::array<RollAxis<Real>, axes> after_;
  std::array<AxisLimits<Real>, axes> limits_{any_limits(), any_limits(), any_limits()};
  std::optional<Move<Real>> move_;
  CellsInPlace cells_{0};
  std::array<StopCell<Real>, CellsInPlace::cells + 1> stops_;
  std::optional<StopBounds<Real>> bounds_;
};

/// Some command, perhaps one that is refused. Whether it was obeyed.
template <Precise Real>
bool command(Playhead<Real>& playhead, const Move<Real>& move, std::mt19937& random) {
  const auto below = [&random](std::uint32_t end) { return static_cast<std::int32_t>(random() % end); };
  // On the time line or a little beside it.
  const std::int32_t frame = move.first_frame() - 100 + below(frames + 300);
  const Direction direction = below(3) == 0 ? Direction::backward : Direction::forward;
  constexpr std::array repeats{Repeat::none, Repeat::loop, Repeat::ping_pong};
  switch (below(9)) {
    case 0:
      playhead.stop();
      return true;
    case 1:
      return playhead.go_to(frame).has_value();
    case 2:
      return playhead.step(direction).has_value();
    case 3:
      return playhead.scrub_to({frame, Real(0.25)}).has_value();
    case 4:
      return playhead.set_override(Real(below(12)) / 10).has_value();
    case 5:
      playhead.set_repeat(repeats.at(random() % repeats.size()));
      return true;
    case 6:
      return playhead.place_on(frame).has_value();
    default:
      return playhead.play(direction).has_value();
  }
}

TYPED_TEST(NoAllocationIn, AMillionTicksOfPlayingTakeNoMemory) {
  using Real = TypeParam;
  const auto play = std::make_unique<PlayInPlace<Real>>();
  std::array<Real, PlayInPlace<Real>::axes> position{};
  std::array<std::int64_t, 5> events{};
  std::array<std::int64_t, 5> states{};
  std::array<std::int64_t, 2> commands{};
  std::mt19937 random(1989);
  Real sum = 0;
  Real longest_stop_s = 0;
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

TYPED_TEST(NoAllocationIn, ShootingFramesInMotionTakesNoMemory) {
  using Real = TypeParam;
  const auto play = std::make_unique<PlayInPlace<Real>>();
  constexpr std::int64_t few_frames = 50;
  const ShootSpec<Real> spec{.settle_ticks = 3,
                             .exposure_ticks = 1,
                             .shutter = Shutter<Real>{Real(-0.25), Real(0.25)},
                             .exposure_s = Real(0.25)};
  std::array<std::int64_t, shoot_phases> phases{};
  std::array<std::int32_t, frames + 1> shots{};
  std::int64_t exposures = 0;
  std::size_t hits = 0;
  std::string error;
  {
    const ArmedAllocator armed;
    auto playhead = play->make();
    if (playhead) {
      Playhead<Real> still = *playhead;
      FrameShoot<Real> shoot(spec, {.last = frames, .shots = shots}, *playhead, &still);
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

TYPED_TEST(NoAllocationIn, WhyAMoveCannotBeStoppedTakesNoMemory) {
  using Real = TypeParam;
  const auto move = std::make_unique<CellsInPlace>();
  const auto stops = std::make_unique<std::array<StopCell<Real>, CellsInPlace::cells + 1>>();
  const AxisLimits<Real> weak = *AxisLimits<Real>::make({-1000, 1000, 1000, Real(0.001)});
  const std::array limits{weak, weak, weak};
  std::size_t hits = 0;
  bool is_told = false;
  {
    const ArmedAllocator armed;
    const StopRequest<Real> request{.motion = move->cells_of_move(), .limits = limits};
    std::optional<StopObstacle<Real>> obstacle;
    if (move->make<Real>(limits, request.tick_seconds, 0)) {
      is_told = !StopBounds<Real>::make(request, *stops, {}, &obstacle) && obstacle.has_value();
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
