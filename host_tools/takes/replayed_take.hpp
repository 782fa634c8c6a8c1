// A take as a motion that is played again.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host_tools/takes/take_store.hpp"
#include "inbetween/play/playhead.hpp"

namespace inbetween {

struct ReplayedTake {
  Take head;                          ///< without ticks
  std::vector<PlayheadPlace> places;  ///< from its first played tick to where it first rested
};

/// Throws TakeStoreError where there is no such take, or it is none that can be played again: it was shot
/// frame by frame or goes over its end, it has not all ticks up to there, or never came to rest on its path.
ReplayedTake replayed_take(TakeStore& store, std::int64_t number);

/// The first file that is another today than in a take, in words; "" where all are what they were. Both have
/// them in the same order.
std::string changed_file(std::int64_t take, const std::vector<TakeFile>& then,
                         const std::vector<TakeFile>& today);

}  // namespace inbetween
