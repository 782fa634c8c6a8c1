// A move played over and over on a simulated rig, for as long as INBETWEEN_SOAK_MINUTES of its own time say
// (10 without it): no drift, no growth of memory, nothing missed. scripts/soak plays it for a day.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <bit>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "host_tools/loop/rig_session.hpp"
#include "host_tools/motions/run_checks.hpp"
#include "host_tools/motions/transport.hpp"
#include "inbetween/base/hash.hpp"
#include "tests/support/sixteen_axes.hpp"

namespace inbetween {
namespace soak_test {

using namespace sixteen_axes;
constexpr std::int64_t ticks_of_a_loop = std::int64_t{rate_hz} * frames / fps;  // a whole number

double minutes_to_play() {
  const char* const asked = std::getenv("INBETWEEN_SOAK_MINUTES");
  return asked == nullptr ? 10 : std::atof(asked);
}

struct Memory {
  std::int64_t resident_kb = 0;
  std::int64_t max_resident_kb = 0;
  std::int64_t heap_bytes = 0;
};
Memory memory_now() {
  Memory memory;
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word == "VmRSS:") status >> memory.resident_kb;
    if (word == "VmHWM:") status >> memory.max_resident_kb;
  }
  const struct mallinfo2 heap = mallinfo2();
  memory.heap_bytes = static_cast<std::int64_t>(heap.uordblks + heap.hblkhd);
  return memory;
}

/// The transport of `run`, watched: every loop is hashed, bit by bit, and compared with the one before.
class Watched final : public LoopTask {
 public:
  Watched(RunLoop& loop, StagedMove& staged, std::int64_t ticks)
      : loop_(loop), transport_(loop, staged, false), last_tick_(ticks) {
    const Move& move = staged.plan().played();
    end_.resize(move.axis_count());
    staged.plan().motion().positions({frames, 0}, end_);
    memory_.reserve(64);
  }
  Status begin() override { return transport_.begin(); }
  void press(TransportKey key) override { transport_.press(key); }
  [[nodiscard]] bool is_over() const override { return transport_.is_over(); }
  [[nodiscard]] RunSnapshot snapshot() const override { return transport_.snapshot(); }
  [[nodiscard]] bool is_preparation() const override { return true; }

  void tick(std::int32_t ticks, std::int64_t now_ns) override {
    transport_.tick(ticks, now_ns);
    if (++tick_ > last_tick_) {
      if (tick_ == last_tick_ + 1) transport_.press(TransportKey::quit);
      return;
    }
    for (const Setpoint& setpoint : loop_.setpoints()) {
      hash_.add(std::bit_cast<std::uint64_t>(setpoint.position), 8);
    }
    if (tick_ % ticks_of_a_loop != 0) return;
    ++loops_;
    for (std::size_t a = 0; a < end_.size(); ++a) {
      if (std::bit_cast<std::uint64_t>(loop_.setpoints()[a].position) !=
          std::bit_cast<std::uint64_t>(end_[a])) {
        ++wrong_ends_;
      }
    }
    if (loops_ == 2) first_ = hash_.value();
    if (loops_ > 2 && hash_.value() != first_) ++other_loops_;
    hash_ = {};
    const std::int64_t all = last_tick_ / ticks_of_a_loop;
    if (loops_ == 2 || loops_ % std::max<std::int64_t>(all / 8, 1) == 0) memory_.push_back(memory_now());
  }

  [[nodiscard]] std::int64_t loops() const { return loops_; }
  [[nodiscard]] std::int64_t wrong_ends() const { return wrong_ends_; }
  [[nodiscard]] std::int64_t other_loops() const { return other_loops_; }
  [[nodiscard]] const std::vector<Memory>& memory() const { return memory_; }

 private:
  RunLoop& loop_;
  Transport transport_;
  std::int64_t last_tick_;
  std::int64_t tick_ = 0;
  std::vector<double> end_;
  Fnv1a hash_;
  std::uint64_t first_ = 0;
  std::int64_t loops_ = 0, wrong_ends_ = 0, other_loops_ = 0;
  std::vector<Memory> memory_;
};

std::int64_t count_named(const std::vector<Counted>& counted, const std::string& name) {
  std::int64_t sum = 0;
  for (const Counted& one : counted) {
    for (const Count& count : one.counts) {
      if (count.name == name) sum += count.count;
    }
  }
  return sum;
}

TEST(Soak, ALoopIsTheSameToTheLastBitHoweverLongItIsPlayedAndMemoryDoesNotGrow) {
  const Plan plan(parse_move(move(), "move.toml"), parse_rig(rig_of(Drives::of_every_kind), "rig.toml"), {});
  const auto staged = checked_move(plan, 1, Repeat::loop);
  const auto ticks = static_cast<std::int64_t>(minutes_to_play() * 60 * rate_hz);
  RigReference reference = reference_of(*plan.rig(), std::nullopt, true);
  SessionOptions options{.simulated = true, .fast = true};
  std::vector<double> start(axes);
  plan.motion().positions({0, 0}, start);
  for (int i = 0; i < axes; ++i) {
    options.standing[fmt::format("a{}", i)] = start[static_cast<std::size_t>(i)];
    if (reference.position(static_cast<std::size_t>(i)) == std::nullopt &&
        plan.rig()->axes[static_cast<std::size_t>(i)].reference != Reference::by_drive) {
      reference.stands_at(static_cast<std::size_t>(i), start[static_cast<std::size_t>(i)]);
    }
  }
  RigSession session(*plan.rig(), reference, options);
  std::optional<Watched> watched;
  const auto began = std::chrono::steady_clock::now();
  const std::string left_on = session.use([&] {
    const DisarmAtEnd disarm(session);
    ASSERT_TRUE(session.arm()) << session.trouble();
    reference.about_to_move(staged->loop_spec().drive_of);
    watched.emplace(session.loop(), *staged, ticks);
    const ActEnd end = session.perform(*watched);
    ASSERT_TRUE(end.begun) << end.begun.error().what;
    session.rest();
  });
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  EXPECT_EQ(left_on, "");
  EXPECT_EQ(session.trouble(), "");
  ASSERT_TRUE(watched);

  EXPECT_EQ(watched->loops(), ticks / ticks_of_a_loop);
  EXPECT_EQ(watched->wrong_ends(), 0) << "drift: a last position that is not the one of the plan";
  EXPECT_EQ(watched->other_loops(), 0) << "a loop with other bits than the second one";
  EXPECT_EQ(session.late_ticks(), 0);

  const std::vector<Memory>& memory = watched->memory();
  ASSERT_GE(memory.size(), 2U);
  for (const Memory& at : memory) {
    EXPECT_EQ(at.heap_bytes, memory.front().heap_bytes);
    EXPECT_LE(at.resident_kb, memory.front().resident_kb + 256);
    fmt::print("resident {} KB, at most {} KB, heap {} bytes\n", at.resident_kb, at.max_resident_kb,
               at.heap_bytes);
  }

  const Counters counts = session.drives().counts();
  for (const char* name :
       {"missed", "bad_frames", "duplicates", "stray_answers", "emergencies", "foreign_frames"}) {
    EXPECT_EQ(count_named(counts.drives, name), 0) << name;
  }
  for (const char* name : {"unsent", "floods"}) EXPECT_EQ(count_named(counts.buses, name), 0) << name;
  const std::int64_t feedback = count_named(counts.drives, "feedback");
  EXPECT_GE(feedback, 4 * ticks) << "each of four drives with SYNC has answered each tick";
  fmt::print("{} loops of {} ticks and {} axes in {:.1f} s, {:.2f} us a tick; {} frames of feedback\n",
             watched->loops(), ticks_of_a_loop, axes, seconds, 1e6 * seconds / static_cast<double>(ticks),
             feedback);
}

}  // namespace soak_test
}  // namespace inbetween
