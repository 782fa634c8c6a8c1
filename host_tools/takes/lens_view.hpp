// What a lens sees: a pinhole camera.
#pragma once

#include <array>
#include <optional>

#include "host_tools/rig_model/rig_lens.hpp"
#include "inbetween/joints/pose.hpp"

namespace inbetween {

/// A place in the picture (px): x to the right and y down from its upper left corner.
struct ImagePoint {
  double x = 0;
  double y = 0;
};

/// The pose of a camera is that of its tip in the world (m): it looks along x, y is to the left, z up.
///
/// A point (x, y, z) of that frame is seen at the middle of the picture less (fx y / x, fy z / x), where fx
/// is focal_length_mm * resolution / sensor_mm in the width, fy in the height (Hartley and Zisserman,
/// Multiple View Geometry, 2003, 6.1). No distortion, and the hole is at the tip.
class LensView {
 public:
  /// The middle of the picture and its corners.
  static constexpr std::size_t mark_count = 5;

  explicit LensView(const RigLens& lens);

  /// Nothing where the point is not before the camera. It may be outside the picture.
  [[nodiscard]] std::optional<ImagePoint> image_of(const Pose& camera, const Vector3& point) const;
  /// What the camera sees in the middle and in the corners at distance_m, measured along its x axis.
  [[nodiscard]] std::array<Vector3, mark_count> marks(const Pose& camera) const;
  /// The farthest that one of the marks of `from` moves in the picture when the camera is at `to` instead
  /// (px): infinite where one is not before it any more.
  [[nodiscard]] double shift(const Pose& from, const Pose& to) const;

 private:
  [[nodiscard]] std::array<ImagePoint, mark_count> images_of_marks() const;

  double distance_;
  ImagePoint middle_;
  ImagePoint focal_;  // px
};

}  // namespace inbetween
