// Take after take of sixteen axes at 1 kHz, for as long as INBETWEEN_SOAK_MINUTES of their own time say (10
// without it): what --keep allows is never exceeded, the oldest go, one that is marked stays, no tick is
// lost.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "host_tools/takes/take_recorder.hpp"
#include "host_tools/takes/take_store.hpp"
#include "tests/support/sixteen_axes.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace take_soak_test {

constexpr std::int64_t number_of_takes = 40;
/// A take has 16.8 bytes a tick here; six of them do not fit.
constexpr std::int64_t bytes_of_a_tick = 17;
constexpr std::int64_t takes_that_fit = 5;
constexpr std::int64_t marked = 2;

std::int64_t ticks_of_a_take() {
  const char* const asked = std::getenv("INBETWEEN_SOAK_MINUTES");
  const double minutes = asked == nullptr ? 10 : std::atof(asked);
  return static_cast<std::int64_t>(minutes * 60 * sixteen_axes::rate_hz / number_of_takes);
}

std::int64_t size_of(const std::string& file) {
  std::error_code is_gone;
  const std::uintmax_t size = std::filesystem::file_size(file, is_gone);
  return is_gone ? 0 : static_cast<std::int64_t>(size);
}

/// The largest that a file of takes and its write-ahead log were.
struct LargestSize {
  std::int64_t file = 0, log = 0, both = 0;
  void look_at(const std::string& name) {
    const std::int64_t now = size_of(name), log_now = size_of(name + "-wal");
    file = std::max(file, now);
    log = std::max(log, log_now);
    both = std::max(both, now + log_now);
  }
};

TEST(Soak, TakesNeverTakeMoreThanKeepAllowsAndTheOldestGo) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "takes.db";
  const std::int64_t ticks = ticks_of_a_take();
  const std::int64_t keep = takes_that_fit * (ticks * bytes_of_a_tick + 200'000);
  sixteen_axes::TickedLoop rig;
  LargestSize largest;
  std::vector<std::int64_t> there;
  double longest_take_s = 0;
  const auto began = std::chrono::steady_clock::now();
  for (std::int64_t number = 1; number <= number_of_takes; ++number) {
    const auto take_began = std::chrono::steady_clock::now();
    TakeRecorder recorder({.file = file, .max_bytes = keep, .waits = true}, rig.take());
    LoopTrace trace(sixteen_axes::axes, {&recorder});
    for (std::int64_t tick = 0; tick < ticks; ++tick) {
      rig.tick(trace);
      if (tick % sixteen_axes::rate_hz == 0) largest.look_at(file);
    }
    const KeptTake kept = recorder.finish("played", true);
    largest.look_at(file);
    ASSERT_EQ(kept.lost, 0) << kept.why;
    there.push_back(number);
    for (const std::int64_t gone : kept.forgotten) {
      EXPECT_EQ(gone, there[there.front() == marked ? 1 : 0]) << "the oldest that is not marked";
      std::erase(there, gone);
    }
    TakeStore store(file, TakeStore::Access::write);
    if (number == marked) store.mark(marked, true);
    EXPECT_LE(store.used_bytes(), keep);
    std::vector<std::int64_t> listed;
    for (const TakeInfo& take : store.list()) listed.push_back(take.number);
    ASSERT_EQ(listed, there);
    longest_take_s = std::max(
        longest_take_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - take_began).count());
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  EXPECT_THAT(there, testing::Contains(marked));
  EXPECT_GE(there.size(), 4U) << "no more went than had to";
  EXPECT_TRUE(rig.is_running());
  // A chunk is written before room is made for it. docs/takes.md says how large the log is.
  EXPECT_LE(largest.file, keep + 100'000);
  EXPECT_LE(largest.log, 8'000'000);
  fmt::print(
      "{} takes of {} ticks in {:.0f} s, the longest {:.1f} s; --keep {}, the file {} at most, its log {}, "
      "both {}\n",
      number_of_takes, ticks, seconds, longest_take_s, size_in_words(keep), size_in_words(largest.file),
      size_in_words(largest.log), size_in_words(largest.both));
}

}  // namespace take_soak_test
}  // namespace inbetween
