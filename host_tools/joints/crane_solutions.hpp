// Inverse kinematics of camera cranes and remote heads without iteration.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/joints/tip_target.hpp"
#include "inbetween/joints/crane_positions.hpp"

namespace inbetween {

/// A rig whose link hangs, from the root, on
/// - nothing that moves, or a track that slides, a swing square to it, a boom square to the swing, and
/// perhaps
///   a joint that follows the boom the other way round and keeps the head level;
/// - then a head: pan, tilt square to it, and perhaps roll square to the tilt, with axes through one point.
/// Fixed links may stand between them, turned as they like.
class CraneSolutions {
 public:
  /// Nothing where the link hangs on something else, or `axes` are not what moves it.
  static std::optional<CraneSolutions> find(const Kinematics& kinematics, std::int32_t link,
                                            const std::vector<TipAxis>& axes);

  /// Every solution, each with a position of every axis within a turn or so of 0. None where the target is
  /// out of reach or singular, and where it asks for another choice of place, aim and roll than the rig can
  /// follow in closed form: is_for() tells.
  [[nodiscard]] std::vector<std::vector<double>> of(const TipTarget& target) const;
  /// With a crane the target has a place, with a roll axis a roll, and always a point to look at.
  [[nodiscard]] bool is_for(const TipTarget& target) const;

 private:
  /// An axis of the rig that one joint follows.
  struct Follower {
    std::size_t axis = 0;  // index of the TipAxis
    double factor = 1;
  };
  struct Look;

  CraneSolutions() = default;
  [[nodiscard]] std::optional<Look> look_of(const TipTarget& target) const;
  void add_heads(const Look& look, const CranePositions& crane,
                 std::vector<std::vector<double>>& solutions) const;

  std::optional<CameraCrane> crane_;
  bool is_level_ = false;
  CameraHead head_;
  bool has_roll_ = false;
  Vector3 centre_;                   // of the head, with every axis at 0
  Pose camera_;                      // with every axis at 0
  Vector3 mount_;                    // from the centre to the camera, as the camera sees it
  std::vector<Follower> followers_;  // track, swing and boom if there is a crane; pan, tilt, perhaps roll
};

}  // namespace inbetween
