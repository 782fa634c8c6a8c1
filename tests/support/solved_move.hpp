#pragma once

#include <optional>
#include <vector>

#include "host_tools/plan/solved_track.hpp"
#include "tests/support/oracle_rest.hpp"
#include "tests/support/random_move.hpp"

/// A move of the oracle handed to the product, number by number.

namespace inbetween {

struct TrackInput {
  std::vector<double> keys;
  std::vector<double> weights;
  std::vector<KeyShape> shapes;
  std::vector<double> control_values;
  TrackSpec spec;

  explicit TrackInput(const RandomMove& move);
  TrackInput(const TrackInput&) = delete;
  TrackInput& operator=(const TrackInput&) = delete;
};

/// The move as the closed form solves it.
SolvedTrack solve(const RandomMove& move, const ArcLengthOptions& arc_length = {});

/// The places of a table as the oracle counts them: the end of the path is (last segment, 1).
std::vector<std::pair<int, double>> oracle_places(const Track& track, const FrameTable& table);

/// The inner keys that are met exactly: breaks on their frames, holds where the played curve rests, of keys
/// in one place the first. Nothing where the curve does not rest within 1e-9 of the length from a hold.
std::optional<std::vector<oracle::MetKey>> met_keys(const RandomMove& move, const SolvedTrack& solved);

}  // namespace inbetween
