// The keys whose smooth path is nearest to positions that were recorded along it.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "inbetween/path/path.hpp"

namespace inbetween {

/// Positions in the order in which the path passes them.
struct PassedPoints {
  std::size_t axes = 0;
  std::vector<double> positions;  ///< point after point
  std::vector<double> scales;     ///< one per axis; 0: the axis does not count. Distances are in these units.
  std::vector<double> weights;    ///< of the path
};

/// A smooth path and where it passes the points. Orthogonal distance regression: Gauss and Newton's method on
/// the keys, in which a point may slide along the path (tangent distance minimization, Wang, Pottmann and Liu
/// 2006), damped after Levenberg and Marquardt. Needs two axes that count: along one, every path is as near.
class KeyFit {
 public:
  /// `keys` key after key, `places` one per point: s on the path of these keys.
  KeyFit(const PassedPoints& points, std::vector<double> keys, std::vector<double> places);

  /// At most so many steps. O(points * keys) each.
  void descend(int steps);
  /// A new key where the path is now, in the middle of the segment that misses its points most. False, if
  /// keys would come nearer than `shortest` everywhere, or make no path.
  bool split_worst(double shortest);

  [[nodiscard]] std::size_t key_count() const { return keys_.size() / points_->axes; }
  [[nodiscard]] std::span<const double> keys() const { return keys_; }
  [[nodiscard]] std::span<const double> places() const { return places_; }
  /// Whether the keys make a path.
  [[nodiscard]] bool is_path() const { return path_.has_value(); }
  [[nodiscard]] const Path& path() const { return *path_; }
  /// Of the distances of all points.
  [[nodiscard]] double mean_square() const;
  /// The largest distance of the mean of three neighbouring points, which has less noise than they.
  [[nodiscard]] double deviation() const;
  /// How far the path goes astray between one point and the next, from the line that joins them.
  [[nodiscard]] double excursion() const;
  [[nodiscard]] std::size_t farthest() const;
  [[nodiscard]] double distance(std::size_t point) const;

 private:
  /// How each point's distance, axis after axis, follows the coordinates of the keys that it feels: those
  /// from `first_column` of the point on.
  struct Effects {
    std::vector<std::vector<double>> rows;
    std::vector<std::size_t> first_column;
  };
  void make_path();
  void slide(double reach);
  [[nodiscard]] std::vector<double> misses() const;
  [[nodiscard]] double square_at(std::size_t point, double s) const;
  /// Nothing where shifted keys make no path.
  [[nodiscard]] std::optional<Effects> effects_of_keys() const;
  [[nodiscard]] bool step(double& damping);

  const PassedPoints* points_;
  std::vector<std::size_t> counted_;  ///< axes
  std::vector<double> keys_;
  std::vector<double> places_;
  std::vector<double> squares_;  ///< of the distance of each point
  std::vector<Cubic> cubics_;
  std::vector<double> weights_;
  std::optional<Path> path_;
};

}  // namespace inbetween
