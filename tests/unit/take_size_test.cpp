// What docs/takes.md says of the size of takes is what they have.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <regex>
#include <string>

#include "host_tools/motions/run.hpp"
#include "host_tools/takes/take_store.hpp"
#include "host_tools/takes/taken_motion.hpp"
#include "host_tools/takes/tick_codec.hpp"
#include "tests/support/places.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/sixteen_axes.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace take_size_test {

/// The number before " kB" or " MB" behind `words`, in bytes.
double said_in_document(const std::string& words) {
  std::string text = file_contents(in_checkout("docs/takes.md"));
  for (char& letter : text) {
    if (letter == '\n') letter = ' ';
  }
  std::smatch found;
  if (!std::regex_search(text, found, std::regex(words + R"( ([0-9.]+) (kB|MB))"))) return 0;
  return std::atof(found[1].str().c_str()) * (found[2] == "MB" ? 1e6 : 1e3);
}

/// What the second of two runs adds to the file, as --keep counts it, for a minute.
double bytes_a_minute(const Plan& plan) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "takes.db";
  const TakeRequest request{.keeping = {.file = file}};
  std::int64_t before = 0, bytes = 0, ticks = 0;
  for (int i = 0; i < 2; ++i) {
    before = bytes;
    ticks = run(plan, {.simulated = true, .fast = true}, {.take = request}).kept->ticks;
    bytes = TakeStore(file, TakeStore::Access::read).used_bytes();
  }
  return static_cast<double>(bytes - before) / static_cast<double>(ticks) * 60 * plan.rig()->rate_hz;
}

/// The same, of the chunks alone, where the last count of every drive flickers, as an encoder's does.
double bytes_a_minute_with_noise(const Plan& plan) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "takes.db";
  run(plan, {.simulated = true, .fast = true}, {.take = TakeRequest{.keeping = {.file = file}}});
  const Take take = TakeStore(file, TakeStore::Access::read).read(1);
  const auto motion = TakenMotion::read(take.trajectory);
  TickEncoder encoder({.axes = take.axes,
                       .motion = &motion->motion(),
                       .frame_rate = take.frame_rate,
                       .rate_hz = take.rate_hz});
  std::mt19937 random(1);
  for (TakeTick tick : take.ticks_of_take) {
    for (std::size_t a = 0; a < take.axes.size(); ++a) {
      const double per_unit = 1 / take.axes[a].resolution;
      const double noise = static_cast<double>(random() % 3) - 1;
      tick.actual[a] = (std::nearbyint(tick.actual[a] * per_unit) + noise) / per_unit;
    }
    encoder.add(tick);
  }
  return static_cast<double>(encoder.take_chunk().size()) / static_cast<double>(take.ticks) * 60 *
         take.rate_hz;
}

void expect_about(double bytes, double said) {
  fmt::print("{} a minute, and the document says {}\n", size_in_words(static_cast<std::int64_t>(bytes)),
             size_in_words(static_cast<std::int64_t>(said)));
  EXPECT_GT(bytes, 0.8 * said);
  EXPECT_LT(bytes, 1.1 * said);
}

TEST(TakeSize, AMinuteHasTheBytesThatTheDocumentSays) {
  const Plan sixteen(parse_move(sixteen_axes::move(), "move.toml"),
                     parse_rig(sixteen_axes::rig_of(sixteen_axes::Drives::of_every_kind), "rig.toml"), {});
  expect_about(bytes_a_minute(sixteen), said_in_document("16 axes at 1 kHz about"));
  expect_about(bytes_a_minute_with_noise(sixteen), said_in_document("16 axes at 1 kHz about"));
  const Plan three(read_move_file(in_checkout("examples/reveal.toml")),
                   read_rig_file(in_checkout("examples/camera_rig.toml")), {});
  expect_about(bytes_a_minute(three), said_in_document("3 axes at 250 Hz about"));
  expect_about(bytes_a_minute_with_noise(three), said_in_document("3 axes at 250 Hz about"));
}

}  // namespace take_size_test
}  // namespace inbetween
