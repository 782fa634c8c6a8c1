// What is measured between two postures of a rig: its axes, its tips, and the picture of its lens.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/takes/lens_view.hpp"
#include "host_tools/takes/take_samples.hpp"

namespace inbetween {

inline constexpr double mm_per_m = 1000;
/// What is smaller is shown as 0: no rig has it, and numbers of positions round to it.
inline constexpr double measured_least = 1e-9;

struct Measure {
  enum class Kind : std::uint8_t {
    axis,      ///< how much further an axis is, with its sign
    distance,  ///< of a tip between the two, mm
    angle,     ///< by which a tip is turned between the two, deg, 0..180
    picture,   ///< LensView::shift(), px
  };
  Kind kind = Kind::axis;
  std::string name;  ///< of the axis or the tip
  std::string unit;
};

/// The measures of a rig: its axes in their order; distance and angle of each tip of [kinematics]; the
/// picture of the lens. All links of a tip count, those that the move holds too.
class RigMeasures {
 public:
  /// `kinematics` are those of the rig, null where it has none.
  RigMeasures(const RigFile& rig, std::shared_ptr<const Kinematics> kinematics);

  /// Throws std::runtime_error, one line, where a take has other axes than the rig.
  void refuse_other_axes(const TakeSamples& samples) const;

  [[nodiscard]] const std::vector<Measure>& all() const { return measures_; }
  /// The axes that move the tip of a measure, or its axis alone.
  [[nodiscard]] const std::vector<std::size_t>& axes_of(std::size_t measure) const {
    return moved_by_[measure];
  }

  /// The links of the rig in the world, of a position for each axis, into `out`, which gets their number;
  /// none without joints. Throws std::runtime_error, one line, where a position is beyond what
  /// JointTree::poses() takes.
  void poses(std::span<const double> axes, std::vector<Pose>& out) const;
  /// Every measure of `to` against `from`, into `out`. O(joints + axes).
  void take(std::span<const double> from, std::span<const double> to, std::span<double> out) const;

  /// What errors of the axes may do to a measure at a place: the sum of what each does alone.
  [[nodiscard]] double effect_of(std::span<const double> errors, std::span<const double> place,
                                 std::size_t measure) const;

  [[nodiscard]] const std::shared_ptr<const Kinematics>& kinematics() const { return kinematics_; }
  /// The lens and the link that it is at.
  [[nodiscard]] const std::optional<LensView>& lens() const { return lens_; }
  [[nodiscard]] std::size_t lens_link() const { return lens_link_; }

 private:
  void add(Measure measure, const Tip& tip);

  std::shared_ptr<const Kinematics> kinematics_;
  std::size_t axes_;
  std::vector<Measure> measures_;
  std::vector<std::vector<std::size_t>> moved_by_;  // of measures_
  std::optional<LensView> lens_ = {};
  std::size_t lens_link_ = 0;
};

/// "0.18 mm": the magnitude in two digits, rounded up, so that "at most" is true; 0 below measured_least;
/// "out of sight" where it is infinite.
std::string in_words(double error, const Measure& measure);

/// The angle by which one frame is turned against another (deg), 0..180. Accurate for small angles too: of
/// the vector of the turn's sine and of its trace, by atan2.
double angle_between(const Rotation3& from, const Rotation3& to);

}  // namespace inbetween
