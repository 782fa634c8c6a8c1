// The core takes no memory: neither while a move is made, nor while it is evaluated for hours.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "inbetween/frame_table.hpp"
#include "inbetween/frame_time.hpp"
#include "inbetween/ode_frame_table.hpp"
#include "inbetween/track.hpp"
#include "tests/realtime/armed_allocator.hpp"

namespace inbetween {
namespace {

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
      const Derivatives derivatives = track->motion(frame_time_of_tick<Real>(tick, fps, 10'000), motion);
      ++reported[derivatives == Derivatives::exact ? 0 : 1];
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

}  // namespace
}  // namespace inbetween
