#include "host_tools/scene/line_test.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "host_tools/exchange/baked_table.hpp"

namespace inbetween {
namespace {

constexpr double page_width = 1280, page_height = 720, margin = 24, heading = 44;
constexpr Color ink{0.13, 0.13, 0.15}, quiet{0.42, 0.42, 0.45}, bones{0.30, 0.45, 0.70},
    seen{0.835, 0.369, 0};
constexpr double smallest_m = 1e-6;  // of a rig that does not move and has no length

void widen(Vector3& low, Vector3& high, const Vector3& place) {
  low = {std::min(low.x, place.x), std::min(low.y, place.y), std::min(low.z, place.z)};
  high = {std::max(high.x, place.x), std::max(high.y, place.y), std::max(high.z, place.z)};
}

}  // namespace

LineTest::LineTest(const AnimatedScene& scene) : scene_(scene) {
  places_.resize(scene.rows);
  std::vector<Pose> world(scene.nodes.size());
  for (std::size_t row = 0; row < scene.rows; ++row) {
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
      const SceneNode& node = scene.nodes[i];
      const Pose local = local_pose(node, row);
      world[i] = node.parent < 0 ? local : world[static_cast<std::size_t>(node.parent)] * local;
      places_[row].push_back(world[i].position);
    }
    cameras_.push_back(world[static_cast<std::size_t>(scene.camera.node)]);
  }
  // A link that stands still on its own, such as what is filmed, is a point and no part of the rig.
  is_posture_.resize(scene.nodes.size());
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const SceneNode& node = scene.nodes[i];
    const bool is_carried = node.parent >= 0 && is_posture_[static_cast<std::size_t>(node.parent)];
    is_posture_[i] = is_carried || !node.positions.empty() || !node.turns.empty();
  }
  for (std::size_t i = scene.nodes.size(); i-- > 0;) {
    const std::int32_t parent = scene.nodes[i].parent;
    if (is_posture_[i] && parent >= 0) is_posture_[static_cast<std::size_t>(parent)] = true;
  }
  Vector3 low = places_.front().front(), high = low;
  for (const std::vector<Vector3>& row : places_)
    for (const Vector3& place : row) widen(low, high, place);
  size_ = std::max(std::hypot(high.x - low.x, high.y - low.y, high.z - low.z), smallest_m);
  for (std::size_t row = 0; row < scene.rows; ++row)
    for (const Vector3& corner : corners(row)) widen(low, high, corner);
  for (std::size_t i = 0; i < box_.size(); ++i) {
    box_.at(i) = {(i & 1U) == 0 ? low.x : high.x, (i & 2U) == 0 ? low.y : high.y,
                  (i & 4U) == 0 ? low.z : high.z};
  }
}

/// Upper left, upper right, lower right, lower left of what the camera sees.
std::array<Vector3, 4> LineTest::corners(std::size_t row) const {
  const SceneLens lens = scene_.camera.lens.value_or(usual_lens);
  const double ahead = size_ / 5;
  const double x = ahead * lens.sensor_mm[0] / 2 / lens.focal_length_mm;
  const double y = ahead * lens.sensor_mm[1] / 2 / lens.focal_length_mm;
  const Pose& camera = cameras_[row];
  return {camera * Vector3{-x, y, -ahead}, camera * Vector3{x, y, -ahead}, camera * Vector3{x, -y, -ahead},
          camera * Vector3{-x, -y, -ahead}};
}

/// In metres on the plane of the picture, up as on the stage.
Point LineTest::projected(View view, const Vector3& place) {
  if (view == View::plan) return {place.x, place.y};
  if (view == View::elevation) return {place.x, place.z};
  // From the front, 35 degrees to the right and 25 degrees up, without perspective.
  constexpr double right_x = 0.8192, right_y = 0.5736, level = 0.9063, up = 0.4226;
  const double away = place.y * right_x - place.x * right_y;
  return {place.x * right_x + place.y * right_y, place.z * level + away * up};
}

LineTest::Frame LineTest::frame_in(const Box& box, View view) const {
  Point low = projected(view, box_.front()), high = low;
  for (const Vector3& corner : box_) {
    const Point at = projected(view, corner);
    low = {std::min(low.x, at.x), std::min(low.y, at.y)};
    high = {std::max(high.x, at.x), std::max(high.y, at.y)};
  }
  Frame frame{.view = view};
  frame.scale = std::min(box.width / std::max(high.x - low.x, smallest_m),
                         box.height / std::max(high.y - low.y, smallest_m));
  frame.shift = {box.x + (box.width - frame.scale * (high.x + low.x)) / 2,
                 box.y + (box.height + frame.scale * (high.y + low.y)) / 2};
  return frame;
}

Point LineTest::Frame::at(const Vector3& place) const {
  const Point flat = projected(view, place);
  return {shift.x + scale * flat.x, shift.y - scale * flat.y};
}

void LineTest::draw_view(Canvas& canvas, const Box& box, View view, std::size_t row) const {
  const Frame frame = frame_in(box, view);
  const auto camera = static_cast<std::size_t>(scene_.camera.node);
  std::vector<Point> path;
  for (const std::vector<Vector3>& places : places_) path.push_back(frame.at(places[camera]));
  canvas.polyline(path, {ink.faded(0.25), 1.5});
  canvas.polyline(std::span(path).first(row + 1), {ink, 2});
  std::vector<std::pair<Point, Point>> links;
  for (std::size_t i = 0; i < scene_.nodes.size(); ++i) {
    const std::int32_t parent = scene_.nodes[i].parent;
    if (i == camera) continue;
    canvas.disc(frame.at(places_[row][i]), 3, bones);
    if (parent < 0 || !is_posture_[i]) continue;
    links.emplace_back(frame.at(places_[row][static_cast<std::size_t>(parent)]), frame.at(places_[row][i]));
  }
  canvas.lines(links, {bones, 3});
  const Point eye = frame.at(cameras_[row].position);
  const std::array<Vector3, 4> of_frame = corners(row);
  std::vector<std::pair<Point, Point>> rays;
  for (std::size_t i = 0; i < of_frame.size(); ++i) {
    const Point corner = frame.at(of_frame.at(i));
    rays.emplace_back(eye, corner);
    rays.emplace_back(corner, frame.at(of_frame.at((i + 1) % of_frame.size())));
  }
  canvas.lines(rays, {seen, 1});
  canvas.line(frame.at(of_frame[0]), frame.at(of_frame[1]), {seen, 3});  // what is up in the picture
  canvas.disc(eye, 4, seen);
}

void LineTest::draw(std::size_t row, const std::filesystem::path& file) const {
  Canvas canvas(file, page_width, page_height);
  const std::int64_t number = scene_.first_frame + static_cast<std::int64_t>(row);
  const double seconds = static_cast<double>(row) / scene_.fps.frames_per_second();
  const std::string title = fmt::format("{}, frame {}", scene_.name, number);
  canvas.text({margin, 30}, elided(canvas, title, {18, ink, Align::left, true}, page_width / 2),
              {18, ink, Align::left, true});
  canvas.text({page_width - margin, 30},
              fmt::format("{:.3f} s at {} a second", seconds, to_string(scene_.fps)),
              {14, quiet, Align::right});
  const double height = page_height - heading - margin;
  const double half = (height - margin) / 2;
  constexpr double space_width = 790, flat_width = page_width - space_width - 3 * margin;
  const double right = 2 * margin + space_width;
  draw_view(canvas, {margin, heading, space_width, height}, View::space, row);
  draw_view(canvas, {right, heading, flat_width, half}, View::plan, row);
  draw_view(canvas, {right, heading + half + margin, flat_width, half}, View::elevation, row);
  canvas.text({right, heading + 10}, "from above", {12, quiet});
  canvas.text({right, heading + half + margin + 10}, "from the front", {12, quiet});
  canvas.write(title, "the path of the camera, the links of the rig and what the camera sees");
}

}  // namespace inbetween
