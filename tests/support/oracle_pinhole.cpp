#include "tests/support/oracle_pinhole.hpp"

#include <cstddef>

namespace inbetween {
namespace {

using Vector = OraclePinhole::Vector;

Vector times(const std::array<Vector, 3>& rows, const Vector& v) {
  Vector product{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) product.at(i) += rows.at(i).at(j) * v.at(j);
  }
  return product;
}

}  // namespace

OraclePinhole::OraclePinhole(const Lens& lens, const Vector& position, const std::array<Vector, 3>& columns) {
  intrinsic_ = {{{lens.focal_mm * lens.pixels[0] / lens.sensor_mm[0], 0, lens.pixels[0] / 2},
                 {0, lens.focal_mm * lens.pixels[1] / lens.sensor_mm[1], lens.pixels[1] / 2},
                 {0, 0, 1}}};
  for (std::size_t j = 0; j < 3; ++j) {
    rotation_[0].at(j) = -columns[1].at(j);
    rotation_[1].at(j) = -columns[2].at(j);
    rotation_[2].at(j) = columns[0].at(j);
  }
  translation_ = times(rotation_, position);
  for (double& t : translation_) t = -t;
}

std::array<double, 2> OraclePinhole::image(const Vector& point) const {
  Vector seen = times(rotation_, point);
  for (std::size_t i = 0; i < 3; ++i) seen.at(i) += translation_.at(i);
  const Vector homogeneous = times(intrinsic_, seen);
  return {homogeneous[0] / homogeneous[2], homogeneous[1] / homogeneous[2]};
}

Vector OraclePinhole::point(const std::array<double, 2>& pixel, double depth) const {
  const Vector seen{(pixel[0] - intrinsic_[0][2]) / intrinsic_[0][0] * depth,
                    (pixel[1] - intrinsic_[1][2]) / intrinsic_[1][1] * depth, depth};
  Vector point{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      point.at(i) += rotation_.at(j).at(i) * (seen.at(j) - translation_.at(j));
  }
  return point;
}

}  // namespace inbetween
