#include "timing/lock_frames.hpp"

#include <algorithm>
#include <limits>

#include "inbetween/base/bisection.hpp"
#include "inbetween/timing/speed_profile.hpp"

namespace inbetween {
namespace {

Error request_error(const char* what, const char* remedy, const KeyLock& lock) {
  return {
      .code = ErrorCode::out_of_range, .what = what, .remedy = remedy, .key = lock.key, .frame = lock.frame};
}

/// When the drawn curve arrives at the key of every request, as a share of the time that it moves. The keys
/// are in order, so that one walk along the curve finds them all.
void find_arrivals(const KeyTimingSpec& spec, std::span<double> arrivals) {
  const std::size_t f = spec.control_values.size() - 1;
  const auto span_at = [&](std::size_t i) { return speed_span(spec.control_values, i, spec.ends); };
  double total = 0;
  for (std::size_t i = 0; i < f; ++i) total += span_at(i).integral();
  const double length = spec.key_distances.back();
  std::size_t span = 0;
  double before = 0;
  for (std::size_t k = 0; k < spec.locks.size(); ++k) {
    const auto key = static_cast<std::size_t>(spec.locks[k].key);
    const double share = length > 0
                             ? spec.key_distances[key] / length
                             : static_cast<double>(key) / static_cast<double>(spec.key_distances.size());
    const double target = share * total;
    while (span + 1 < f && before + span_at(span).integral() < target) before += span_at(span++).integral();
    const auto is_before = [&](double t) { return before + span_at(span).integral(t) < target; };
    const double t = share > 0 ? bisected({0, 1}, std::numeric_limits<double>::digits, is_before).high : 0;
    arrivals[k] = (static_cast<double>(span) + t) / static_cast<double>(f);
  }
}

/// The frame of the hold at `index`, which has none: where the drawn curve arrives, played between the locks
/// with frames on either side in the frames that are no holds.
std::int32_t arrival_frame(const KeyTimingSpec& spec, std::span<const double> arrivals, std::size_t index) {
  const std::span<const KeyLock> locks = spec.locks;
  std::int32_t begin_frame = 0;
  double begin_share = 0;
  std::int32_t moving = spec.frames;
  for (std::size_t i = index; i-- > 0;) {
    moving -= locks[i].hold;
    if (locks[i].frame < 0) continue;
    begin_frame = locks[i].frame;
    begin_share = arrivals[i];
    break;
  }
  const std::int32_t first = spec.frames - moving + begin_frame;  // with what is held before
  moving -= begin_frame;
  double end_share = 1;
  for (std::size_t i = index; i < locks.size(); ++i) {
    if (locks[i].frame >= 0) {
      moving -= spec.frames - locks[i].frame;
      end_share = arrivals[i];
      break;
    }
    moving -= locks[i].hold;
  }
  const double share = arrivals[index] - begin_share;
  const double frames = share > 0 && end_share > begin_share
                            ? share / (end_share - begin_share) * static_cast<double>(moving)
                            : 0.0;
  // The first frame at or behind it; a frame met but for rounding is that frame.
  const double rounding = 64 * std::numeric_limits<double>::epsilon() * static_cast<double>(spec.frames);
  const auto whole = static_cast<std::int32_t>(frames);
  return first + (frames > static_cast<double>(whole) + rounding ? whole + 1 : whole);
}

double distance_of(const KeyTimingSpec& spec, const KeyLock& lock) {
  return spec.key_distances[static_cast<std::size_t>(lock.key)];
}

/// `drawn`: the frame of `lock` is where the curve arrives, and nobody's request.
Error on_one_frame(const KeyTimingSpec& spec, const KeyLock& before, const KeyLock& lock, bool drawn) {
  if (!drawn) {
    return request_error("this key is to be met on the frame of the locked key before it",
                         "give the two keys different frames", lock);
  }
  if (distance_of(spec, lock) != distance_of(spec, before)) {
    return request_error("the speed touches 0 just before this key, and both fall on one frame",
                         "move the key, or keep the path between its keys with overshoot = false", lock);
  }
  if (before.key == 0) {
    return request_error("the key before it is in the same place, and the move begins there",
                         "remove this key, and give the first its hold, if it has one", lock);
  }
  return request_error("the key before it is in the same place, and both rest or ease on one frame",
                       "remove one of the two, and give the other the hold or the ease", lock);
}

Error no_frame_behind(const KeyTimingSpec& spec, const KeyLock& lock) {
  if (distance_of(spec, lock) == spec.key_distances.back()) {
    return request_error("this key is in the place where the move ends",
                         "remove the keys behind it, and its ease if it has one", lock);
  }
  return request_error("this key leaves no frame for the keys behind it", "give it an earlier frame", lock);
}

}  // namespace

Result<std::size_t> complete_locks(const KeyTimingSpec& spec, std::span<KeyLock> out,
                                   std::span<double> arrivals) {
  const auto last_key = static_cast<std::int32_t>(spec.key_distances.size()) - 1;
  std::int32_t holds = 0;
  for (const KeyLock& lock : spec.locks) holds += lock.hold;
  if (holds >= spec.frames) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "the holds take all frames of the move",
                 .remedy = "shorten the holds or give the move more frames",
                 .key = spec.locks.front().key};
  }
  std::size_t count = 0;
  out[count++] = {.key = 0, .frame = 0};
  for (const KeyLock& request : spec.locks) {
    if (request.key < 0 || request.key > last_key) {
      return request_error("there is no such key", "count the keys from 0", request);
    }
  }
  const bool has_frames =
      std::ranges::all_of(spec.locks, [](const KeyLock& lock) { return lock.frame >= 0; });
  if (!has_frames) find_arrivals(spec, arrivals);
  for (std::size_t i = 0; i < spec.locks.size(); ++i) {
    KeyLock lock = spec.locks[i];
    const bool is_end = spec.ends == CurveEnds::natural && lock.key == 0;
    if (lock.ease && (is_end || lock.key == last_key)) {
      return request_error("the speed eases at an end of the move by the curve itself",
                           "remove ease, and draw 0, 0 at that end of the speed curve", lock);
    }
    if (lock.frame < 0) lock.frame = arrival_frame(spec, arrivals, i);
    const std::int32_t end = lock.frame + lock.hold;
    if (end > spec.frames) {
      return request_error("this key would be left after the last frame",
                           "give it an earlier frame or a shorter hold", lock);
    }
    KeyLock& before = out[count - 1];
    if (lock.key == 0) {
      if (lock.frame != 0) return request_error("the first key is met on frame 0", "remove its frame", lock);
      before = lock;
      continue;
    }
    if (lock.key == last_key && end != spec.frames) {
      return request_error("the last key is met on the last frame", "remove its frame, or change frames",
                           lock);
    }
    const std::int32_t left = before.frame + before.hold;
    if (lock.frame == left && lock.key != before.key)
      return on_one_frame(spec, before, lock, spec.locks[i].frame < 0);
    if (lock.frame < left) {
      return request_error("this key is to be met before the locked key in front of it",
                           "give the keys frames in their own order", lock);
    }
    out[count++] = lock;
  }
  if (out[count - 1].key != last_key) {
    const KeyLock& left = out[count - 1];
    if (left.frame + left.hold >= spec.frames) return no_frame_behind(spec, left);
    out[count++] = {.key = last_key, .frame = spec.frames};
  }
  return count;
}

}  // namespace inbetween
