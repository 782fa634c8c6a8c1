#include "tests/bench/gpio_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/support/bench.hpp"

namespace inbetween {

GpioScene::GpioScene(const GpioSceneOptions& options) {
  std::ofstream(path("rig.toml")) << options.rig;
  std::ofstream(path("move.toml")) << options.move;
  if (!options.at_zero.empty()) {
    std::vector<std::string> words{"goto",        "--rig",           path("rig.toml"),
                                   "--positions", path("positions"), "--set-zero"};
    words.insert(words.end(), options.at_zero.begin(), options.at_zero.end());
    EXPECT_EQ(run_program(words).status, 0);
  }
  std::vector<std::string> bench{"--virtual-time"};
  for (const auto* words : {&options.bench, &options.more_of_bench}) {
    bench.insert(bench.end(), words->begin(), words->end());
  }
  // A kernel that has just started has coarse timers.
  run = script_in_bench(
      bench, fmt::format(R"(echo -1 >/proc/sys/kernel/sched_rt_runtime_us
cd {}
chips=$INBETWEEN_BENCH_GPIO
pull() {{ echo pull-$2 >$chips/{}/sim_gpio$1/pull; }}
sleep 1
inbetween_watch_lines $chips/{} {} >record & watch=$!
{}
inbetween {} & run=$!
sleep 2
{}
status=0; wait $run || status=$?
sleep 0.5; kill $watch 2>/dev/null || true; exit $status)",
                         folder_.path().string(), options.watched, options.watched,
                         fmt::join(options.lines, " "), options.before, options.command, options.during));
  positions = file_contents(path("positions"));
  std::istringstream text(file_contents(path("record")));
  for (Levels at; text >> at.at_ns >> at.levels;) record.push_back(at);
}

std::vector<std::int64_t> GpioScene::changes_to(bool level, unsigned line) const {
  std::vector<std::int64_t> at_ns;
  for (std::size_t i = 1; i < record.size(); ++i) {
    if (is_high(i, line) == level && is_high(i - 1, line) != level) at_ns.push_back(record[i].at_ns);
  }
  return at_ns;
}

std::vector<std::int64_t> GpioScene::rises(unsigned line) const {
  return changes_to(true, line);
}
std::vector<std::int64_t> GpioScene::falls(unsigned line) const {
  return changes_to(false, line);
}

bool GpioScene::has_ever_been_high(unsigned line) const {
  for (std::size_t i = 0; i < record.size(); ++i) {
    if (is_high(i, line)) return true;
  }
  return false;
}

}  // namespace inbetween
