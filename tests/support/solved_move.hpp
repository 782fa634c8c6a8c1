#pragma once

#include <optional>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "tests/support/oracle_rest.hpp"
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

/// The inner keys that are met exactly: breaks on their frames, holds where the played curve rests, of keys
/// in one place the first. Nothing where the curve does not rest within 1e-9 of the length from a hold.
std::optional<std::vector<oracle::MetKey>> met_keys(const RandomMove& move,
                                                    const SolvedTrack<double>& solved);

}  // namespace inbetween
