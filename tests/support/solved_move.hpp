#pragma once

#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "tests/support/random_move.hpp"

/// A move of the oracle handed to the product, number by number.

namespace inbetween {

template <Precise Real>
struct TrackInput {
  std::vector<Real> keys;
  std::vector<Real> weights;
  std::vector<KeyShape<Real>> shapes;
  std::vector<Real> control_values;
  TrackSpec<Real> spec;

  explicit TrackInput(const RandomMove& move);
  TrackInput(const TrackInput&) = delete;
  TrackInput& operator=(const TrackInput&) = delete;
};

/// The places of a table as the oracle counts them: the end of the path is (last segment, 1).
template <Precise Real>
std::vector<std::pair<int, double>> oracle_places(const Track<Real>& track, const FrameTable<Real>& table);

}  // namespace inbetween
