// A pinhole camera by its 3 x 4 matrix, as textbooks of computer vision write it, to compare with.
#pragma once

#include <array>

namespace inbetween {

/// The picture of a camera at `position`, which looks along the first of `columns`; the second points to the
/// left, the third up (m).
class OraclePinhole {
 public:
  using Vector = std::array<double, 3>;
  struct Lens {
    double focal_mm = 50;
    std::array<double, 2> sensor_mm{};
    std::array<double, 2> pixels{};
  };

  OraclePinhole(const Lens& lens, const Vector& position, const std::array<Vector, 3>& columns);

  /// Of a point in the world, from the upper left corner (px).
  [[nodiscard]] std::array<double, 2> image(const Vector& point) const;
  /// The point in the world that is seen at a place of the picture, so deep before the camera.
  [[nodiscard]] Vector point(const std::array<double, 2>& pixel, double depth) const;

 private:
  std::array<Vector, 3> intrinsic_{};  // rows of K
  std::array<Vector, 3> rotation_{};   // rows of R: right, down, forward
  Vector translation_{};
};

}  // namespace inbetween
