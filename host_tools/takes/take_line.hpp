// Where the axes were at any time of the move, from the ticks of a take.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host_tools/takes/take_samples.hpp"

namespace inbetween {

/// The samples of a take that lead on in time: the first to be behind all those before it, and of several at
/// one time the last, when the rig has settled. What was played backward, or a second time, is left out.
/// Turns follow one another.
///
/// Between two of them that are no more than two ticks of the drawn speed apart the axes are taken to go
/// straight. A function whose second derivative is at most M is then missed by h^2 M / 8 at most, h the time
/// between the two. M is estimated by the divided differences through the neighbours on both sides, which is
/// exact for a constant acceleration; where a sample has no near neighbour on a side, by the other end alone.
/// Refers to the samples.
class TakeLine {
 public:
  explicit TakeLine(const TakeSamples& samples);

  /// The samples that lead on.
  [[nodiscard]] const std::vector<std::size_t>& samples() const { return ahead_; }

  struct Place {
    std::int64_t turn = 0;
    FrameTime time = {};
  };
  /// Where the axes were at a place, into `out`; false where the take was not there, or lost the ticks around
  /// it. `missed` grows to the interpolation error of each axis, in its unit, where it is larger. Exact at a
  /// sample. O(axes) where `from_sample` is the one found for a place a little before, O(log samples + axes)
  /// otherwise; it becomes the one for this place. Whoever looks for places that lead on begins with 0.
  bool actual_at(const Place& place, std::span<double> out, std::span<double> missed,
                 std::size_t& from_sample) const;

 private:
  [[nodiscard]] static bool is_before(const TakeSample& sample, const Place& place);
  [[nodiscard]] std::size_t first_behind(const Place& place, std::size_t from) const;
  [[nodiscard]] double bend(std::size_t index, std::size_t axis) const;
  [[nodiscard]] double frames_from_to(std::size_t from, std::size_t to) const;
  [[nodiscard]] bool is_near(std::size_t index) const;

  const TakeSamples& samples_;
  std::vector<std::size_t> ahead_;
  double longest_frames_;
};

}  // namespace inbetween
