// A move, solved: every track's path, speed and frame table, and the positions of every axis on time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host_tools/joints/kinematics.hpp"
#include "host_tools/move_model/move_file.hpp"
#include "host_tools/plan/followed_path.hpp"
#include "host_tools/plan/move_rolls.hpp"
#include "host_tools/plan/near_keys.hpp"
#include "host_tools/plan/plan_motion.hpp"
#include "host_tools/plan/solved_track.hpp"
#include "host_tools/plan/space_track.hpp"
#include "host_tools/rig_model/rig_file.hpp"
#include "host_tools/text/diagnostics.hpp"
#include "host_tools/text/frame_range.hpp"

namespace inbetween {

/// The longest move on a rig in ticks: 46 days at 250 Hz, 14 hours at 20 kHz.
inline constexpr std::int64_t max_ticks = 1'000'000'000;

struct PlanOptions {
  Solver solver = Solver::closed_form;
  std::shared_ptr<const Kinematics> kinematics = nullptr;  // of the rig, where it has some
  FrameRange frames = {};                                  // that are played; all where nothing is said
};

/// An axis of the plan, with its place in the rig, the tracks and the move.
struct PlanAxis {
  std::string name;
  std::optional<AxisUnit> unit;      // known with a rig, or where the move gives it one
  std::optional<std::size_t> track;  // index of its track; absent: in no track, the rig holds it where it is
  std::size_t track_axis = 0;        // its index within the track
  std::size_t move_axis = 0;         // its index in Plan::played(): through all tracks
};

/// Movable. With a rig its axes come in the rig's order, otherwise in that of the tracks.
class Plan {
 public:
  /// Solves every track and checks every frame table (check_invariants). Throws InputError at the place
  /// in the move's file where a track cannot be solved, where an axis or the line of a cue is not one of the
  /// rig's, where it has not the frames that are asked for, or where what is played, rolls included, has more
  /// than max_ticks ticks of the rig.
  Plan(MoveFile move, std::optional<RigFile> rig, const PlanOptions& options);
  /// The move of `other` with other speed curves, or in other frames, on the same rig: to be judged, not to
  /// be played. Its paths are those of `other` and are not measured again, and its frame tables are not
  /// checked. Throws as above.
  Plan(MoveFile move, const Plan& other);

  /// The move, the positions of its keys settled (key_positions.hpp).
  [[nodiscard]] const MoveFile& move() const { return move_; }
  [[nodiscard]] const std::optional<RigFile>& rig() const { return rig_; }
  [[nodiscard]] const std::vector<SolvedTrack>& tracks() const { return tracks_; }
  [[nodiscard]] const std::vector<PlanAxis>& axes() const { return axes_; }
  [[nodiscard]] const std::vector<Warning>& warnings() const { return warnings_; }
  /// The first key of each axis that lies outside its range on the rig, which `check` refuses.
  [[nodiscard]] std::vector<Warning> keys_outside() const;
  /// The frames of the move that are planned to be played.
  [[nodiscard]] const WholeFrames& part() const { return part_; }
  /// They were named, be they all of them.
  [[nodiscard]] bool names_frames() const { return names_frames_; }
  [[nodiscard]] bool is_whole() const { return part_ == WholeFrames{0, move_.frames}; }
  /// These frames on their time line, the axes track after track. On a rig it has a pre-roll where it starts
  /// moving and a post-roll where it ends moving, unless there is an obstacle.
  [[nodiscard]] const Move& played() const { return *played_; }
  /// The whole tracks(), one after another.
  [[nodiscard]] std::span<const Track> track_views() const { return track_views_; }
  /// What plays of them. The first call fits the trajectories: about 64 bytes for each piece and axis, and
  /// 3 to 16 pieces for each key. Threads may call it at once.
  [[nodiscard]] const PlayedMotion& motion() const;
  /// The motors of motion(): of every axis of played() with a calibration on the rig, to which they refer.
  [[nodiscard]] std::vector<CalibratedMotor> calibrated_motors() const;
  /// The limits of the axes of played(); empty without a rig.
  [[nodiscard]] const std::vector<AxisLimits>& limits() const { return limits_; }
  [[nodiscard]] const std::vector<RollObstacle>& roll_obstacles() const { return rolls_.obstacles; }
  /// Whether a track moves at an end of what is played, so that a roll joins it there.
  [[nodiscard]] bool is_moving(std::size_t track, RollEnd end) const;
  /// The geometry of the rig, if it was given.
  [[nodiscard]] const std::shared_ptr<const Kinematics>& kinematics() const { return kinematics_; }
  /// How well the axes of a track, or its tip, follow what is drawn; nothing where nothing follows.
  [[nodiscard]] const std::optional<FollowAccuracy>& accuracy(std::size_t track) const {
    return accuracies_[track];
  }
  /// The tips whose path is known: all axes that move them are in a track. warnings() names the others.
  [[nodiscard]] const std::vector<Tip>& tips() const { return tips_; }
  /// The axis of axes() that is axis `move_axis` of played().
  [[nodiscard]] std::size_t axis_of(std::size_t move_axis) const;
  /// The place where the move names axis `axis` of axes(), which is in a track.
  [[nodiscard]] const Place& place_of(std::size_t axis) const;

  /// The duration of the frames that are played, without the rolls.
  [[nodiscard]] double duration_s() const;
  /// How far two such keys of track `index` are apart: "0.1 mm".
  [[nodiscard]] std::string distance_in_words(std::size_t index, const NearKeys& pair) const;
  /// "mm" where all axes of a track with a weight above 0 share it; "" where they do not or have none.
  [[nodiscard]] std::string length_unit(std::size_t track) const;

 private:
  Plan(MoveFile move, std::optional<RigFile> rig, const PlanOptions& options, const Plan* other);
  void solve(const PlanOptions& options, const Plan* other);
  void put_together();
  void refuse_too_many_ticks() const;
  void list_axes();
  void warn_of_mixed_units();
  void warn_of_near_keys();
  void list_tips();
  [[nodiscard]] std::vector<AxisInMove> axes_in_move() const;
  /// What moves each axis of the rig, by tracks that are solved.
  [[nodiscard]] std::vector<DrivenCoordinate> driven_by(
      const std::vector<std::optional<SolvedTrack>>& solved) const;

  MoveFile move_;
  WholeFrames part_;
  bool names_frames_ = false;
  std::optional<RigFile> rig_;
  std::vector<SolvedTrack> tracks_;
  std::vector<std::optional<FollowAccuracy>> accuracies_;  // of tracks_
  std::vector<PlanAxis> axes_;
  std::vector<Warning> warnings_;
  std::vector<Track> track_views_;  // of tracks_, one after another
  std::vector<AxisLimits> limits_;
  PlannedRolls rolls_;
  std::optional<Move> played_;
  std::unique_ptr<PlanMotion> motion_ = std::make_unique<PlanMotion>();
  std::shared_ptr<const Kinematics> kinematics_;
  std::vector<Tip> tips_;
};

}  // namespace inbetween
