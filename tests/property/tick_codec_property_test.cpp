// Any ticks come back from their bytes, to the last bit where that is promised.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "host_tools/takes/tick_codec.hpp"
#include "tests/support/property.hpp"

namespace inbetween {
namespace tick_codec_property_test {

constexpr int many_takes = 3000;

/// Any of all doubles, or a usual one.
double any_double() {
  if (*rc::gen::inRange(0, 4) == 0) return std::bit_cast<double>(*rc::gen::arbitrary<std::uint64_t>());
  return *rc::gen::inRange(-1'000'000, 1'000'000) / 1000.0;
}

/// Steady, but for what happens now and then.
std::vector<TakeTick> any_ticks(const TickShape& shape) {
  std::vector<TakeTick> ticks;
  const int count = *rc::gen::inRange(1, 60);
  TakeTick tick;
  tick.number = *rc::gen::inRange(0, 1000);
  std::vector<std::int64_t> counts(shape.axes.size()), speeds(shape.axes.size());
  double fraction = *rc::gen::inRange(0, 1000) / 1000.0;
  std::int32_t frame = *rc::gen::inRange(-50, 1000);
  double rate = 1;
  for (int i = 0; i < count; ++i) {
    if (*rc::gen::inRange(0, 10) == 0) tick.state = static_cast<SupervisorState>(*rc::gen::inRange(0, 8));
    if (*rc::gen::inRange(0, 10) == 0) tick.shows_frame = !tick.shows_frame;
    if (*rc::gen::inRange(0, 10) == 0) {
      // No rig goes round so often; the fuzzer found that a difference of two such turns was no number.
      const bool is_far = *rc::gen::inRange(0, 4) == 0;
      tick.turn = is_far ? *rc::gen::arbitrary<std::int64_t>() : *rc::gen::inRange(-3, 4);
    }
    if (*rc::gen::inRange(0, 10) == 0) rate = any_double();
    fraction += rate * shape.frame_rate.frames_per_second() / shape.rate_hz;
    if (!(fraction >= 0 && fraction < 1)) {
      frame += fraction < 0 ? -1 : 1;
      fraction = *rc::gen::inRange(0, 1000) / 1000.0;
    }
    tick.time.reset();
    tick.rate = tick.rate_change = 0;
    if (*rc::gen::inRange(0, 5) != 0) {
      tick.time = FrameTime{frame, fraction};
      tick.rate = rate;
      tick.rate_change = *rc::gen::inRange(0, 8) == 0 ? any_double() : 0;
    }
    tick.told.clear();
    tick.actual.clear();
    const bool is_told = *rc::gen::inRange(0, 4) != 0;
    for (std::size_t a = 0; a < shape.axes.size(); ++a) {
      if (*rc::gen::inRange(0, 6) == 0) speeds[a] = *rc::gen::inRange(-500, 500);
      counts[a] += speeds[a];
      const auto position = static_cast<double>(counts[a]) / (1 / shape.axes[a].resolution);
      tick.actual.push_back(*rc::gen::inRange(0, 20) == 0 ? any_double() : position);
      if (is_told) tick.told.push_back(*rc::gen::inRange(0, 10) == 0 ? any_double() : position);
    }
    ticks.push_back(tick);
    tick.number += *rc::gen::inRange(0, 10) == 0 ? *rc::gen::inRange(1, 100) : 1;
  }
  return ticks;
}

bool are_same(double one, double other) {
  return std::bit_cast<std::uint64_t>(one) == std::bit_cast<std::uint64_t>(other);
}

void require_same(const TickShape& shape, const TakeTick& tick, const TakeTick& read) {
  RC_ASSERT(read.number == tick.number);
  RC_ASSERT(read.state == tick.state);
  RC_ASSERT(read.shows_frame == tick.shows_frame);
  RC_ASSERT(read.turn == tick.turn);
  RC_ASSERT(read.time.has_value() == tick.time.has_value());
  if (tick.time) {
    RC_ASSERT(read.time->frame == tick.time->frame);
    RC_ASSERT(are_same(read.time->fraction, tick.time->fraction));
  }
  RC_ASSERT(are_same(read.rate, tick.rate));
  RC_ASSERT(are_same(read.rate_change, tick.rate_change));
  RC_ASSERT(read.told.size() == tick.told.size());
  for (std::size_t a = 0; a < tick.told.size(); ++a) RC_ASSERT(are_same(read.told[a], tick.told[a]));
  RC_ASSERT(read.actual.size() == tick.actual.size());
  for (std::size_t a = 0; a < tick.actual.size(); ++a) {
    const double resolution = shape.axes[a].resolution;
    const double actual = tick.actual[a];
    const double counts = std::nearbyint(actual * (1 / resolution));
    // A position from which others are counted may itself be none: then they are off by half of one at most.
    const bool is_whole = std::fabs(counts) < 1e6 && are_same(counts / (1 / resolution), actual);
    if (!std::isfinite(actual)) RC_ASSERT(are_same(read.actual[a], actual));
    if (std::isfinite(actual))
      RC_ASSERT(std::fabs(read.actual[a] - actual) <=
                resolution / 2 * (1 + 1e-9) + 1e-15 * std::fabs(actual) * (is_whole ? 1 : 4));
  }
}

TEST(TickCodecProperty, AnyTicksComeBack) {
  check_property(many_takes, [] {
    TickShape shape{.axes = {}, .motion = nullptr, .frame_rate = {24, 1}, .rate_hz = 250};
    const int axes = *rc::gen::inRange(1, 5);
    for (int a = 0; a < axes; ++a) {
      shape.axes.push_back(
          {.name = "x", .unit = "mm", .resolution = *rc::gen::element(0.001, 1.0 / 88.888889, 1.0, 1e-7)});
    }
    const std::vector<TakeTick> ticks = any_ticks(shape);
    TickEncoder encoder(shape);
    std::size_t next = 0;
    for (const TakeTick& tick : ticks) {
      encoder.add(tick);
      if (*rc::gen::inRange(0, 30) != 0 && &tick != &ticks.back()) continue;
      RC_ASSERT(encoder.ticks() > 0);
      const std::string chunk = encoder.take_chunk();
      const std::string wrong = decode_ticks(chunk, shape, [&](const TakeTick& read) {
        require_same(shape, ticks[next++], read);
        return true;
      });
      if (!wrong.empty()) RC_FAIL(wrong);
      std::string spoiled = chunk;
      const auto at = *rc::gen::inRange<std::size_t>(0, chunk.size());
      spoiled[at] = static_cast<char>(spoiled[at] ^ (1 << *rc::gen::inRange(0, 8)));
      RC_ASSERT(decode_ticks(spoiled, shape, [](const TakeTick&) { return true; }) != "");
    }
    RC_ASSERT(next == ticks.size());
  });
}

/// As drives tell it: counts over counts a unit.
TEST(TickCodecProperty, WholeCountsComeBackToTheLastBit) {
  check_property(many_takes, [] {
    const double per_unit = *rc::gen::element(1000.0, 88.888889, 4000.0, 12345.678, 3.0);
    const TickShape shape{.axes = {{.name = "x", .unit = "mm", .resolution = 1 / per_unit}},
                          .motion = nullptr,
                          .frame_rate = {24, 1},
                          .rate_hz = 250};
    TickEncoder encoder(shape);
    std::vector<double> positions;
    std::int64_t count = *rc::gen::inRange(-1'000'000, 1'000'000);
    for (int i = 0; i < 50; ++i) {
      count += *rc::gen::inRange(-2000, 2000);
      positions.push_back(static_cast<double>(count) / per_unit);
      TakeTick tick;
      tick.number = i;
      tick.actual = {positions.back()};
      encoder.add(tick);
    }
    std::size_t next = 0;
    RC_ASSERT(decode_ticks(encoder.take_chunk(), shape, [&](const TakeTick& read) {
                RC_ASSERT(are_same(read.actual[0], positions[next++]));
                return true;
              }) == "");
  });
}

}  // namespace tick_codec_property_test
}  // namespace inbetween
