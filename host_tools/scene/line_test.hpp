// A line test, as animators shoot one before the scene itself: a picture for each frame of a rig that moves.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <vector>

#include "host_tools/plot/plot_canvas.hpp"
#include "host_tools/scene/animated_scene.hpp"

namespace inbetween {

/// Three views of each row, at one scale on all of them: in space, from above and from the front. In each are
/// the path of the camera, the way that lies behind it, the links as lines from joint to joint, and the frame
/// of the camera: what it sees, up to a fifth of the size of the motion, with its upper side marked. Refers
/// to the scene.
class LineTest {
 public:
  /// O(rows * nodes), and as much memory.
  explicit LineTest(const AnimatedScene& scene);

  /// Writes one picture, 1280 x 720 pixels, as the ending of the file says. Throws what Canvas throws.
  void draw(std::size_t row, const std::filesystem::path& file) const;

 private:
  enum class View { space, plan, elevation };
  /// Maps the stage to pixels of a box.
  struct Frame {
    View view = View::space;
    double scale = 1;
    Point shift = {};
    [[nodiscard]] Point at(const Vector3& place) const;
  };

  [[nodiscard]] static Point projected(View view, const Vector3& place);
  [[nodiscard]] Frame frame_in(const Box& box, View view) const;
  [[nodiscard]] std::array<Vector3, 4> corners(std::size_t row) const;
  void draw_view(Canvas& canvas, const Box& box, View view, std::size_t row) const;

  const AnimatedScene& scene_;
  std::vector<std::vector<Vector3>> places_;  // of each node, on each row
  std::vector<Pose> cameras_;
  std::vector<bool> is_posture_;  // of each node: it moves, or carries what does
  std::array<Vector3, 8> box_;    // the corners of all that moves
  double size_ = 1;               // m
};

}  // namespace inbetween
