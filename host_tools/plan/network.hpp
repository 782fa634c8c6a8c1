// Networks of moving points: a row of axes, curves over time that are drawn for some of them, and keys of all
// of them (Reeves 1981; Baecker's P-curves).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/row_spline.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "inbetween/path/path.hpp"

namespace inbetween {

/// The curve over time that is drawn of one axis. It refers to the numbers of its caller.
struct NetworkCurve {
  std::size_t axis = 0;                  ///< in the row
  std::span<const std::int32_t> frames;  ///< rising, from the first key frame to the last
  std::span<const double> at;            ///< in axis units, on each of them
};

/// A row of axes. It refers to the numbers of its caller.
struct NetworkSpec {
  std::span<const double> keys;              ///< key after key, in each the axes of the row, in axis units
  std::span<const std::int32_t> key_frames;  ///< rising, two or more
  std::span<const double> places;            ///< of each axis in the row, not falling
  std::span<const NetworkCurve> curves;      ///< in the order of the row, at most one for each axis
  bool rests_at_start = true;
  bool rests_at_end = true;
  /// Networks beside each other that do not touch, as x, y and z of a row of points: axis i is in row
  /// i % rows.
  std::size_t rows = 1;
};

/// A row of smooth curves over frames, with memory of its own. Throws SolverError, whose key is the one that
/// cannot be.
class FrameSpline {
 public:
  /// `at` are the positions of so many axes, frame after frame.
  FrameSpline(std::span<const std::int32_t> frames, std::span<const double> at, std::size_t axes,
              bool rests_at_start, bool rests_at_end);

  /// The places, in quarters of a frame, where segments begin, and where the last one ends.
  [[nodiscard]] std::span<const std::int64_t> knots() const { return knots_; }
  /// The segment in which a quarter lies; the last one at the end. O(log segments).
  [[nodiscard]] std::size_t segment_at(std::int64_t quarter) const;
  /// The cubic of an axis from one quarter of a frame to another one, both within the segment.
  [[nodiscard]] Cubic part(std::size_t segment, std::size_t axis, std::int64_t begin, std::int64_t end) const;
  [[nodiscard]] double value(std::int32_t frame, std::size_t axis = 0) const;
  /// The last position, to the last bit.
  [[nodiscard]] double end(std::size_t axis) const { return cubics_[(knots_.size() - 1) * axes_ + axis].c0; }

 private:
  std::size_t axes_;
  std::vector<Cubic> cubics_;  ///< segment after segment, and the continuation behind the last one
  std::vector<std::int64_t> knots_;
};

/// Segments of a network: as many as a track with the most keys can have, which are four a key beside rests.
/// Network.TooManyPiecesAreRefused.
inline constexpr std::size_t max_network_segments = 4 * max_keys;

/// A key and a drawn curve of one axis that are not in one place on the frame of the key.
struct NetworkGap {
  std::size_t curve = 0;
  std::size_t key = 0;
  double at_key = 0;
  double drawn = 0;
};

/// A drawn curve that the core refuses. The key of the error is the point of the curve.
class CurveError : public SolverError {
 public:
  CurveError(const Error& error, std::size_t curve) : SolverError(error), curve_(curve) {}
  [[nodiscard]] std::size_t curve() const { return curve_; }

 private:
  std::size_t curve_;
};

/// The Coons patch of a network of keys and curves. Axis i of the row is at
///
///   x_i(t) = S_i(t) + sum over d of B_d(u_i) (D_d(t) - S_d(t))
///
/// S_i is the smooth curve over frames through the keys of the axis, as Path::make makes it, D_d the curve
/// that is drawn of axis d, made the same way over its own frames, and u_i the place of the axis. B_d goes
/// linearly from 1 at the place of axis d to 0 at the next places that are drawn. At the first and the last
/// place of the row nothing is added where no axis is drawn there. Where several axes of one place are drawn,
/// each is its own curve, and the others see the mean of what these add. So every key is met, every drawn
/// axis is its curve, and in time all is C2, because S and D are.
///
/// (Coons, Surfaces for computer-aided design of space forms, 1967; Reeves, Inbetweening for computer
/// animation utilizing moving point constraints, 1981.)
class Network {
 public:
  /// Refers to the numbers of `spec`. Throws SolverError for the keys and CurveError for a drawn curve.
  /// O(axes * keys + points).
  explicit Network(const NetworkSpec& spec);

  /// The first key, in the order of keys and then of curves, that is further from the drawn curve of its axis
  /// than rounding explains: 1e-9 of the range of the axis over its keys and its points. O(keys * curves *
  /// log points).
  [[nodiscard]] std::optional<NetworkGap> gap() const;
  /// Segments of the path: between all knots of keys and curves.
  [[nodiscard]] std::size_t segments() const { return knots_.size() - 1; }
  /// The formula but for rounding: 2e-14 of the range of all numbers at most, in 2000 random networks
  /// (NetworkProperty). O(segments * (axes + curves)).
  [[nodiscard]] CubicsOverFrames path() const;

 private:
  /// So much of what a curve adds to its own axis.
  struct Share {
    std::size_t curve = 0;
    double weight = 0;
  };
  [[nodiscard]] std::vector<Share> shares_of(std::size_t axis) const;
  [[nodiscard]] bool is_in_row_of(std::size_t axis, const NetworkCurve& curve) const {
    return curve.axis % spec_.rows == axis % spec_.rows;
  }
  void add_shares_at(std::size_t axis, double place, double weight, std::vector<Share>& shares) const;
  template <class Curve, class Keys>
  [[nodiscard]] std::vector<Cubic> row(const Curve& drawn_there, const Keys& keys_there) const;
  void rest_at_end(CubicsOverFrames& path) const;
  void join(CubicsOverFrames& path) const;
  [[nodiscard]] FrameKnot frame_knot(std::size_t key, std::int64_t begin, std::int64_t end) const;

  NetworkSpec spec_;
  std::size_t axes_;
  FrameSpline through_keys_;
  std::vector<FrameSpline> drawn_;
  std::vector<std::vector<Share>> shares_;  ///< of each axis
  std::vector<std::int64_t> knots_;
};

}  // namespace inbetween
