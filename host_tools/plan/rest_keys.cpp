#include "host_tools/plan/rest_keys.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>
#include <vector>

#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

std::optional<RestFrames> rest_at_key(const MoveTrack& track, std::size_t key) {
  if (!is_over_time(track) || key == 0 || key + 1 >= track.keys.size()) return std::nullopt;
  const MoveKey& before = track.keys[key - 1];
  const MoveKey& here = track.keys[key];
  const MoveKey& behind = track.keys[key + 1];
  if (!before.frame || !here.frame || !behind.frame) return std::nullopt;
  if (before.at == here.at || here.at == behind.at) return std::nullopt;
  const std::int32_t frame = *here.frame;
  if (*behind.frame - frame >= frame - *before.frame && *behind.frame - frame > 1)
    return RestFrames{frame, frame + 1};
  if (frame - *before.frame > 1) return RestFrames{frame - 1, frame};
  return std::nullopt;
}

std::optional<std::size_t> key_to_rest(const MoveTrack& track, double frame, std::size_t axis, bool low) {
  std::size_t behind = 0;
  while (behind < track.keys.size() && track.keys[behind].frame.value_or(0) < frame) ++behind;
  std::optional<std::size_t> found;
  for (const std::size_t key : std::array{behind - 1, behind}) {
    if (key >= track.keys.size() || !rest_at_key(track, key)) continue;
    const auto is_beyond = [&](double at, double other) { return low ? at < other : at > other; };
    if (!found || is_beyond(track.keys[key].at[axis], track.keys[*found].at[axis])) found = key;
  }
  return found;
}

void write_twice(MoveTrack& track, const std::set<std::size_t>& keys) {
  std::vector<MoveKey> written;
  for (std::size_t k = 0; k < track.keys.size(); ++k) {
    written.push_back(track.keys[k]);
    const std::optional<RestFrames> rest = keys.contains(k) ? rest_at_key(track, k) : std::nullopt;
    if (!rest) continue;
    written.back().frame = rest->first;
    written.push_back(written.back());
    written.back().frame = rest->second;
  }
  track.keys = std::move(written);
}

std::string twice_in_words(const MoveTrack& track, const std::set<std::size_t>& keys) {
  std::vector<std::string> words;
  for (const std::size_t key : keys) {
    const RestFrames rest = rest_at_key(track, key).value();
    words.push_back(fmt::format("key {} twice, on frames {} and {}", key, rest.first, rest.second));
  }
  return listed_with_and(words) + ", for a rest there";
}

}  // namespace inbetween
