#include "host_tools/takes/replayed_take.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace inbetween {
namespace {

const char* words_of(TakeFile::Role role) {
  switch (role) {
    case TakeFile::Role::move:
      return "the move";
    case TakeFile::Role::rig:
      return "the rig";
    case TakeFile::Role::other:
      break;
  }
  return "a file of the rig";
}

[[noreturn]] void refuse_replay(const TakeStore& store, const Take& take, const std::string& why) {
  throw TakeStoreError(store.file(), fmt::format("take {} cannot be played again: {}", take.number, why));
}

}  // namespace

ReplayedTake replayed_take(TakeStore& store, std::int64_t number) {
  ReplayedTake replayed{.head = store.read_head(number), .places = {}};
  const Take& take = replayed.head;
  if (take.is_shot) refuse_replay(store, take, "it was shot frame by frame; choose one that was played");
  if (take.is_repeated)
    refuse_replay(store, take, "it goes over its end again and again; choose one that was played once");
  bool rests = false, is_whole = true;
  std::int64_t last = 0;
  store.read_ticks(take, [&](const TakeTick& tick) {
    const bool follows = replayed.places.empty() || tick.number == last + 1;
    last = tick.number;
    if (!tick.time) return replayed.places.empty();
    is_whole = follows;
    if (!is_whole) return false;
    replayed.places.push_back({*tick.time, tick.rate, tick.rate_change});
    rests = tick.rate == 0 && tick.rate_change == 0;
    return !rests;
  });
  if (replayed.places.empty()) refuse_replay(store, take, "nothing was played in it; choose another");
  if (!is_whole)
    refuse_replay(store, take, fmt::format("ticks before tick {} are lost; choose another", last));
  if (!rests) refuse_replay(store, take, "it never came to rest on its path; choose another");
  return replayed;
}

std::string changed_file(std::int64_t take, const std::vector<TakeFile>& then,
                         const std::vector<TakeFile>& today) {
  for (std::size_t i = 0; i < std::max(then.size(), today.size()); ++i) {
    if (i < then.size() && i < today.size() && then[i].hash == today[i].hash) continue;
    const TakeFile& file = i < today.size() ? today[i] : then[i];
    return fmt::format("{}: error: {} is another than in take {}", file.path, words_of(file.role), take);
  }
  return "";
}

}  // namespace inbetween
