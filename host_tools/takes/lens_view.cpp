#include "host_tools/takes/lens_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace inbetween {

LensView::LensView(const RigLens& lens)
    : distance_(lens.distance_m),
      middle_{lens.resolution_px[0] / 2.0, lens.resolution_px[1] / 2.0},
      focal_{lens.focal_length_mm / lens.sensor_mm[0] * lens.resolution_px[0],
             lens.focal_length_mm / lens.sensor_mm[1] * lens.resolution_px[1]} {}

std::optional<ImagePoint> LensView::image_of(const Pose& camera, const Vector3& point) const {
  const Vector3 seen = inverse(camera.rotation) * (point - camera.position);
  if (!(seen.x > 0)) return std::nullopt;
  return ImagePoint{middle_.x - focal_.x * (seen.y / seen.x), middle_.y - focal_.y * (seen.z / seen.x)};
}

std::array<ImagePoint, LensView::mark_count> LensView::images_of_marks() const {
  const double width = 2 * middle_.x, height = 2 * middle_.y;
  return {middle_, {0, 0}, {width, 0}, {0, height}, {width, height}};
}

std::array<Vector3, LensView::mark_count> LensView::marks(const Pose& camera) const {
  std::array<Vector3, mark_count> marks;
  std::ranges::transform(images_of_marks(), marks.begin(), [&](const ImagePoint& image) {
    const double left = (middle_.x - image.x) / focal_.x, up = (middle_.y - image.y) / focal_.y;
    return camera * Vector3{distance_, distance_ * left, distance_ * up};
  });
  return marks;
}

double LensView::shift(const Pose& from, const Pose& to) const {
  const std::array<Vector3, mark_count> points = marks(from);
  const std::array<ImagePoint, mark_count> before = images_of_marks();
  double farthest = 0;
  for (std::size_t i = 0; i < mark_count; ++i) {
    const std::optional<ImagePoint> image = image_of(to, points.at(i));
    if (!image) return std::numeric_limits<double>::infinity();
    farthest = std::max(farthest, std::hypot(image->x - before.at(i).x, image->y - before.at(i).y));
  }
  return farthest;
}

}  // namespace inbetween
