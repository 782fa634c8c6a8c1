#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "inbetween/base/precision.hpp"
#include "inbetween/base/result.hpp"
#include "inbetween/limits/limits.hpp"
#include "inbetween/timing/frame_time.hpp"
#include "inbetween/timing/track.hpp"
#include "inbetween/trajectory/axis_peaks.hpp"

/// Pre-roll and post-roll: from rest into a move that starts moving, and from one that ends moving to rest.
/// They join the first and the last of the frames that are played, A and B: 0 and N of a whole move.

namespace inbetween {

/// The longest roll that is looked for. 7 minutes at 24 frames a second, 10 s at 1000: who needs more has
/// written a limit in the wrong unit, and is told so after milliseconds. A test holds it
/// (roll_test, ARollOfMinutesIsRefused).
inline constexpr std::int32_t max_roll_frames = 10'000;

enum class RollEnd : std::uint8_t {
  before,  ///< pre-roll: frames joint_frame - frames .. joint_frame, where joint_frame is A
  after,   ///< post-roll: frames joint_frame .. joint_frame + frames, where joint_frame is B
};

/// The frames of a roll: one number for all axes of all tracks. The joint is where roll and move meet.
struct RollSpan {
  RollEnd end = RollEnd::before;
  std::int32_t joint_frame = 0;
  std::int32_t frames = 1;  ///< 1..max_roll_frames
  FrameRate fps;
};

/// One axis on a roll of T seconds: the polynomial of lowest degree in time that has the position, velocity
/// and acceleration of the joint there, and velocity and acceleration 0 at the other end, whose position is
/// free. Five conditions, so a quartic. The post-roll is the mirror image in time.
///
/// With h = T before and -T after the move, s = (time - joint) / h from -1 (rest) to 0 (joint), u = 1 + s and
/// b = a h - 2 v it is
///     velocity     u^2 (v + b s)
///     acceleration u (a + 3 b s / h)
///     position     p + h s (v + s (a h / 2 + s ((2 a h - 3 v) / 3 + s b / 4)))
/// and is evaluated so: at the joint it is p, v and a to the last bit, at the other end velocity and
/// acceleration are exactly 0. An axis with v = a = 0 stays where it is.
class RollAxis {
 public:
  /// An axis that rests at 0: room for one that is made later.
  RollAxis() = default;

  /// `joint` is what joints_of (move.hpp) says of frame A or B; its jerk is not used.
  /// Errors: not_finite; out_of_range (frames, fps, or numbers whose bounds are beyond the range of double).
  /// O(1).
  static Result<RollAxis> make(const RollSpan& span, const AxisMotion& joint);

  [[nodiscard]] const RollSpan& span() const { return span_; }
  [[nodiscard]] double seconds() const {
    return span_.end == RollEnd::before ? signed_seconds_ : -signed_seconds_;
  }
  /// The position in which the axis rests before the pre-roll or after the post-roll.
  [[nodiscard]] double rest_position() const { return at_share(-1, 0).position; }

  /// At a frame of the roll, in the numbers of the move: below A on a pre-roll, above B on a post-roll. The
  /// jerk at either end is that inside the roll. Beyond the end at rest: resting there. Domain: not on the
  /// move's side of the joint. O(1), no allocation.
  [[nodiscard]] AxisMotion motion(const FrameTime& time) const;

  /// c[0] + c[1] t + ... + c[4] t^4 is the position t seconds from the joint:
  /// c[0] = p, c[1] = v, c[2] = a / 2.
  [[nodiscard]] std::array<double, 5> coefficients() const;

  /// How far, how fast and how hard the axis goes on the roll, both ends included, in closed form: the
  /// extremes lie at the ends and at roots of the derivative, which are linear or known. Never below the
  /// truth (lowest: never above), rounding included; above it by at most 1e-9 of it, of
  /// positions by 1e-9 of |p| + T (3 |v| + |a| T). What is largest at the joint is exact. O(1).
  [[nodiscard]] AxisPeaks peaks() const;

 private:
  RollAxis(const RollSpan& span, const AxisMotion& joint, double signed_seconds)
      : span_(span),
        joint_(joint),
        signed_seconds_(signed_seconds),
        quartic_(joint.acceleration * signed_seconds - 2 * joint.velocity) {}

  [[nodiscard]] AxisMotion at_share(double s, double u) const;
  [[nodiscard]] double frame_at(double u) const;
  void bound_position(double rounding, AxisPeaks& peaks) const;
  void bound_velocity(double rounding, AxisPeaks& peaks) const;
  void bound_acceleration(double rounding, AxisPeaks& peaks) const;
  void bound_jerk(double rounding, AxisPeaks& peaks) const;
  [[nodiscard]] double drift() const { return joint_.acceleration * signed_seconds_; }
  [[nodiscard]] bool turns_back() const;

  RollSpan span_;
  AxisMotion joint_;
  double signed_seconds_ = 1;  ///< h
  double quartic_ = 0;         ///< b
};

enum class RollQuantity : std::uint8_t { position, velocity, acceleration, jerk };

/// A limit that a roll does not keep, and where.
struct RollBreach {
  std::int32_t axis = -1;
  RollQuantity quantity = RollQuantity::position;
  bool at_joint = false;  ///< the move itself breaks the limit on the frame of the joint: no roll can help
  double value = 0;       ///< the bound of RollAxis::peaks
  double limit = 0;
  double frame = 0;         ///< where, in the numbers of the move; it need not be a whole one
  std::int32_t frames = 0;  ///< of the roll that was looked at
};

/// The same axes in the same order: those of all tracks.
struct RollRequest {
  RollEnd end = RollEnd::before;
  std::int32_t joint_frame = 0;  ///< A before, B after
  FrameRate fps;
  std::span<const AxisMotion> joints;  ///< of frame A or B, one-sided
  std::span<const AxisLimits> limits;
};

/// The smallest whole number of frames for which every axis keeps its limits of position, velocity,
/// acceleration and jerk on the roll; 0 where every axis is at rest already (v = a = 0), because then there
/// is nothing to roll.
///
/// Method: longer is not always gentler. For one axis, r = a h / v, and T growing one finds:
/// - The peak velocity never falls. It is |v|, or if that is more, and r is not in 0..3,
///   4/27 |v| |3 - r|^3 / (2 - r)^2; from v = 0 it is 4/27 |a| T.
/// - The peak acceleration never rises. For r < 3/2 it is |v| (3 - r)^2 / (3 (2 - r) T), otherwise |a|.
/// - The jerk is linear, 6 v / T^2 - 2 a / h at rest and 4 a / h - 6 v / T^2 at the joint. For r > 0 its
///   peak falls until r = 2, rises until r = 3 and falls again; otherwise it falls.
/// - The travel v h / 2 - a T^2 / 12 grows without end for r <= 0 and from v = 0. For r > 0 it grows until
///   r = 3, to 3 v^2 / (4 |a|). Then the axis comes from the other side and backs up, by ever less, down to
///   v^2 / (2 |a|); from r = 6 on it rests beyond the joint, further and further.
/// So the lengths that fit can lie in several intervals. Whole numbers are tried in turn, from the least that
/// Newton's law leaves (|v| <= A T, |a| <= J T, |v| <= J T^2 / 2), until all axes fit or one breaks a limit
/// that by the above no longer roll keeps. That is a handful: the start is seldom below a third of the
/// answer.
///
/// Errors: no_solution, with axis, frame = joint_frame and the limit in the way (see roll_obstacle for value
/// and place), wrong_count (joints, limits), out_of_range (fps), those of RollAxis::make, with axis. Cost:
/// O(axes) a number tried, about 40 ns an axis on a desktop machine.
Result<std::int32_t> roll_frames(const RollRequest& request);

/// Why roll_frames found none: the limit that it names, with number and place; empty where it found one.
/// It is the first limit met that no longer roll keeps; where the search ended without one, the position on
/// the shortest roll that is gentle enough; and where none is, the acceleration or jerk on the longest.
/// Errors and cost: those of roll_frames, no_solution excepted.
Result<std::optional<RollBreach>> roll_obstacle(const RollRequest& request);

}  // namespace inbetween
