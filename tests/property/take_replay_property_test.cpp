// A take of any keys at any time, played again, has the same setpoints and the same edges on the STEP lines.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "host_tools/motions/run.hpp"
#include "host_tools/takes/replayed_take.hpp"
#include "host_tools/takes/take_store.hpp"
#include "tests/support/places.hpp"
#include "tests/support/property.hpp"
#include "tests/support/run_program.hpp"
#include "tests/support/temporary_file.hpp"

namespace inbetween {
namespace take_replay_property_test {

constexpr int many_takes = 50;

/// What is typed before which tick: at last q, where it has not ended by itself.
std::vector<std::pair<int, std::string>> any_keys() {
  std::vector<std::pair<int, std::string>> typed;
  int tick = 0;
  const int keys = *rc::gen::inRange(0, 8);
  for (int i = 0; i < keys; ++i) {
    tick += *rc::gen::inRange(1, 400);
    typed.emplace_back(
        tick, *rc::gen::element<std::string>(" ", "r", "+", "-", "\x1b", "\x1b[C", "g20\r", "\x1b[H"));
  }
  typed.emplace_back(tick + 1 + *rc::gen::inRange(0, 3000), "q");
  return typed;
}

SessionOptions typing(const std::vector<std::pair<int, std::string>>& typed, const std::string& steps) {
  SessionOptions options{.simulated = true, .fast = true, .steps = steps};
  options.audience.keys = [typed, tick = 0, next = std::size_t{0}]() mutable {
    std::string keys;
    while (next < typed.size() && typed[next].first <= tick) keys += typed[next++].second;
    ++tick;
    return keys;
  };
  return options;
}

/// Of a take what was played up to its first rest.
std::vector<TakeTick> played_ticks(TakeStore& store, std::int64_t take) {
  std::vector<TakeTick> ticks;
  store.read_ticks(store.read_head(take), [&](const TakeTick& tick) {
    if (tick.time) ticks.push_back(tick);
    return !tick.time || tick.rate != 0 || tick.rate_change != 0;
  });
  return ticks;
}

TEST(TakeReplayProperty, TheSetpointsAndTheEdgesAreTheSame) {
  const Plan plan(read_move_file(in_checkout("examples/slide_and_pan.toml")),
                  read_rig_file(in_checkout("examples/slider_rig.toml")), {});
  int replayed = 0;
  std::size_t ticks = 0;
  check_property(many_takes, [&] {
    const TemporaryFolder folder;
    const std::string file = folder.path() / "takes.db";
    const std::string steps = folder.path() / "steps.csv", again = folder.path() / "again.csv";
    const RunReport first =
        run(plan, typing(any_keys(), steps), {.take = TakeRequest{.keeping = {.file = file}}});
    if (first.kept->number == 0) return;  // stopped before anything was played
    TakeStore store(file, TakeStore::Access::read);
    const ReplayedTake take = replayed_take(store, first.kept->number);
    const RunReport second =
        run(plan, typing({}, again),
            {.take = TakeRequest{.keeping = {.file = file}}, .follow = FollowedTake{"take 1", take.places}});
    RC_ASSERT(second.ending == Ending::finished);
    const std::vector<TakeTick> was = played_ticks(store, 1), is = played_ticks(store, 2);
    RC_ASSERT(was.size() == is.size());
    for (std::size_t i = 0; i < was.size(); ++i) {
      RC_ASSERT(was[i].time == is[i].time);
      RC_ASSERT(was[i].rate == is[i].rate);
      RC_ASSERT(was[i].rate_change == is[i].rate_change);
      RC_ASSERT(was[i].told == is[i].told);
      RC_ASSERT(was[i].actual == is[i].actual);
    }
    // Where the first went on after its rest it has more edges.
    const std::string edges = file_contents(steps), same = file_contents(again);
    RC_ASSERT(edges.starts_with(same.substr(0, same.rfind('\n', same.size() - 2) + 1)));
    ++replayed;
    ticks += is.size();
  });
  std::cout << replayed << " takes played again, " << ticks << " ticks\n";
}

}  // namespace take_replay_property_test
}  // namespace inbetween
