// A trajectory of one axis whose numbers are known.
#pragma once

#include <cstdint>
#include <vector>

#include "inbetween/trajectory/trajectory.hpp"

namespace inbetween {

/// An axis that goes evenly from one position to the next, at these times in frames at 24 fps.
class EvenPieces {
 public:
  EvenPieces(const std::vector<double>& frames, const std::vector<double>& positions)
      : values_(positions), buckets_(frames.size()) {
    for (std::uint32_t i = 0; i + 1 < frames.size(); ++i) {
      const double length = frames[i + 1] - frames[i];
      pieces_.push_back({.begin = moved_by(FrameTime{}, frames[i]),
                         .inverse_frames = 1 / length,
                         .seconds = length / 24,
                         .begin_row = i,
                         .end_row = i + 1,
                         .degree = 1,
                         .is_exact = true});
    }
    contents = {.axis_count = 1,
                .fps = {24, 1},
                .end = moved_by(FrameTime{}, frames.back()),
                .pieces = pieces_,
                .values = values_};
  }
  [[nodiscard]] Trajectory made() { return *Trajectory::make(contents, buckets_); }

  TrajectoryContents contents;

 private:
  std::vector<double> values_;
  std::vector<TrajectoryPiece> pieces_;
  std::vector<std::uint32_t> buckets_;
};

}  // namespace inbetween
