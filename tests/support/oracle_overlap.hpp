// Straight lines whose actions overlap, by convolution: an independent solution (Tuori 1977).
#pragma once

#include <vector>

namespace inbetween::oracle {

/// The keys of one axis with their frames, and for how many frames actions overlap at each.
struct OverlappingKeys {
  std::vector<long double> at;        ///< of a closed path one more, for the return
  std::vector<long double> frames;    ///< the same number
  std::vector<long double> overlaps;  ///< the same number; of a ring the first and the last are equal
  bool rests_at_start = true;
  bool rests_at_end = true;
  bool is_ring = false;
};

/// The position at a frame: the straight lines, extended beyond both ends, with every change of velocity
/// convolved with a triangle as wide as the overlap of its key, by quadrature. An action from rest begins
/// half an overlap later, and one to rest ends so much earlier.
long double overlapped_position(const OverlappingKeys& keys, long double frame);

}  // namespace inbetween::oracle
