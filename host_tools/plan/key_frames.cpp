#include "host_tools/plan/key_frames.hpp"

#include <cstdint>

#include "inbetween/timing/track.hpp"

namespace inbetween {

std::vector<double> key_frames_of(const Plan& plan, std::size_t index) {
  const SolvedTrack& solved = plan.tracks()[index];
  const Track& track = solved.track();
  std::vector<double> frames;
  for (std::int32_t i = 0; i <= track.path().segment_count(); ++i) {
    if (track.path().key_at(i)) frames.push_back(frame_of_segment(track, i));
  }
  frames.back() = track.frames();
  if (!solved.key_timing()) return frames;
  // Where the speed is 0, a distance is passed at many moments.
  for (const KeyLock& lock : solved.key_timing()->locks) {
    if (lock.key < 0) continue;  // a turn of the path, which is no key
    frames[static_cast<std::size_t>(lock.key)] = solved.key_timing()->frame_of(lock, track.frames());
  }
  return frames;
}

}  // namespace inbetween
