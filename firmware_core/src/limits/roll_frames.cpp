#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>

#include "inbetween/limits/roll.hpp"

namespace inbetween {
namespace {

bool all_at_rest(std::span<const AxisMotion> joints) {
  for (const AxisMotion& joint : joints) {
    if (joint.velocity != 0 || joint.acceleration != 0) return false;
  }
  return true;
}

/// A roll that nobody looks at is ruled out by this much more than its rounding.
constexpr double generous = 16 * std::numeric_limits<double>::epsilon();

using FoundBreach = std::optional<RollBreach>;

/// The limit that the joint breaks, and so the move.
FoundBreach breach_at_joint(const AxisMotion& joint, const AxisLimits& limits) {
  const auto broken = [](RollQuantity quantity, double value, double limit) {
    return RollBreach{.quantity = quantity, .at_joint = true, .value = value, .limit = limit};
  };
  const double speed = std::fabs(joint.velocity);
  const double acceleration = std::fabs(joint.acceleration);
  if (speed > limits.max_velocity()) return broken(RollQuantity::velocity, speed, limits.max_velocity());
  if (acceleration > limits.max_acceleration())
    return broken(RollQuantity::acceleration, acceleration, limits.max_acceleration());
  if (joint.position < limits.min()) return broken(RollQuantity::position, joint.position, limits.min());
  if (joint.position > limits.max()) return broken(RollQuantity::position, joint.position, limits.max());
  return std::nullopt;
}

FoundBreach breach_within(const AxisPeaks& peaks, const AxisLimits& limits) {
  const auto broken = [](RollQuantity quantity, const Peak& peak, double limit) {
    return RollBreach{.quantity = quantity, .value = peak.value, .limit = limit, .frame = peak.frame};
  };
  if (peaks.velocity.value > limits.max_velocity())
    return broken(RollQuantity::velocity, peaks.velocity, limits.max_velocity());
  if (peaks.acceleration.value > limits.max_acceleration())
    return broken(RollQuantity::acceleration, peaks.acceleration, limits.max_acceleration());
  if (limits.max_jerk() && peaks.jerk.value > *limits.max_jerk())
    return broken(RollQuantity::jerk, peaks.jerk, *limits.max_jerk());
  if (peaks.lowest.value < limits.min()) return broken(RollQuantity::position, peaks.lowest, limits.min());
  if (peaks.highest.value > limits.max()) return broken(RollQuantity::position, peaks.highest, limits.max());
  return std::nullopt;
}

Result<FoundBreach> breach_of_axis(const RollRequest& request, std::size_t axis, std::int32_t frames) {
  const auto number = static_cast<std::int32_t>(axis);
  const Result<RollAxis> roll =
      RollAxis::make({request.end, request.joint_frame, frames, request.fps}, request.joints[axis]);
  if (!roll) {
    Error error = roll.error();
    error.axis = number;
    return error;
  }
  FoundBreach breach = breach_at_joint(request.joints[axis], request.limits[axis]);
  if (breach) {
    breach->frame = static_cast<double>(request.joint_frame);
  } else {
    breach = breach_within(roll->peaks(), request.limits[axis]);
  }
  if (breach) {
    breach->axis = number;
    breach->frames = frames;
  }
  return breach;
}

Status check_request(const RollRequest& request) {
  if (request.joints.size() != request.limits.size()) {
    return Error{.code = ErrorCode::wrong_count,
                 .what = "the axes that roll and the axes that have limits are not as many",
                 .remedy = "give the limits of every axis of every track"};
  }
  if (request.fps.numerator < 1 || request.fps.denominator < 1) {
    return Error{
        .code = ErrorCode::out_of_range, .what = "a roll has no frame rate", .remedy = "use a rate above 0"};
  }
  return Done{};
}

/// Whether a longer roll of the axis might keep the limit that one breaks: the list in the header.
bool longer_may_help(const RollRequest& request, const RollBreach& breach) {
  if (breach.at_joint || breach.quantity == RollQuantity::velocity) return false;
  if (breach.quantity != RollQuantity::position) return true;
  const AxisMotion& joint = request.joints[static_cast<std::size_t>(breach.axis)];
  const bool before = request.end == RollEnd::before;
  const bool from_below = (joint.velocity > 0) == before;
  const bool pushed_along = joint.velocity != 0 && (joint.acceleration < 0) != from_below;  // r > 0 or a = 0
  const bool broken_below = breach.value < breach.limit;
  if (!pushed_along || joint.acceleration == 0 || broken_below != from_below) return false;
  const double min_distance =
      std::fabs(joint.velocity) * (std::fabs(joint.velocity) / std::fabs(2 * joint.acceleration));
  return min_distance <= std::fabs(joint.position - breach.limit) * (1 + generous);
}

/// No roll of fewer frames changes a velocity so far within the limits of acceleration and jerk.
std::int32_t fewest_frames(const RollRequest& request) {
  double seconds = 0;
  for (std::size_t i = 0; i < request.joints.size(); ++i) {
    const double v = std::fabs(request.joints[i].velocity);
    const double a = std::fabs(request.joints[i].acceleration);
    seconds = std::max(seconds, v / request.limits[i].max_acceleration());
    if (const std::optional<double> jerk = request.limits[i].max_jerk()) {
      seconds = std::max(seconds, std::max(a / *jerk, std::sqrt(2 * (v / *jerk))));
    }
  }
  const double frames = seconds * static_cast<double>(request.fps.numerator) /
                        static_cast<double>(request.fps.denominator) * (1 - generous);
  if (!(frames < static_cast<double>(max_roll_frames))) return max_roll_frames;
  const auto whole = static_cast<std::int32_t>(frames);
  return std::max(static_cast<double>(whole) < frames ? whole + 1 : whole, std::int32_t{1});
}

/// Names a limit that a roll of `frames` frames breaks: one that no longer roll keeps, else one that wants a
/// longer roll whatever else there is, else one of position.
Result<FoundBreach> weightiest_breach(const RollRequest& request, std::int32_t frames) {
  FoundBreach weightiest;
  for (std::size_t i = 0; i < request.joints.size(); ++i) {
    const Result<FoundBreach> breach = breach_of_axis(request, i, frames);
    if (!breach) return breach.error();
    if (!*breach) continue;
    if (!longer_may_help(request, **breach)) return *breach;
    const bool weighs_more = (*breach)->quantity != RollQuantity::position && weightiest &&
                             weightiest->quantity == RollQuantity::position;
    if (!weightiest || weighs_more) weightiest = *breach;
  }
  return weightiest;
}

/// The answer, or the obstacle.
struct Search {
  std::int32_t frames = 0;
  FoundBreach obstacle;
};

Result<Search> search(const RollRequest& request) {
  const Status counts = check_request(request);
  if (!counts) return counts.error();
  if (all_at_rest(request.joints)) return Search{};
  FoundBreach obstacle;
  for (std::int32_t frames = fewest_frames(request); frames <= max_roll_frames; ++frames) {
    const Result<FoundBreach> breach = weightiest_breach(request, frames);
    if (!breach) return breach.error();
    if (!*breach) return Search{.frames = frames, .obstacle = std::nullopt};
    if (!longer_may_help(request, **breach)) return Search{.frames = 0, .obstacle = *breach};
    // The shortest roll that would do but for its travel is the one to report.
    if (!obstacle || obstacle->quantity != RollQuantity::position) obstacle = *breach;
  }
  return Search{.frames = 0, .obstacle = obstacle};
}

struct Text {
  const char* before;
  const char* after;
};

// The texts stand in the order of RollQuantity.
constexpr std::array what_at_joint{
    Text{"the move starts outside the range of the axis", "the move ends outside the range of the axis"},
    Text{"the move starts faster than max_velocity", "the move ends faster than max_velocity"},
    Text{"the move starts with more than max_acceleration", "the move ends with more than max_acceleration"},
};  // the jerk may step here, and is never looked at
constexpr std::array what_within{
    Text{"the pre-roll leaves the range of the axis", "the post-roll leaves the range of the axis"},
    Text{"the pre-roll exceeds max_velocity", "the post-roll exceeds max_velocity"},
    Text{"the pre-roll exceeds max_acceleration", "the post-roll exceeds max_acceleration"},
    Text{"the pre-roll exceeds max_jerk", "the post-roll exceeds max_jerk"},
};

Text remedy(RollQuantity quantity, bool at_joint) {
  if (quantity == RollQuantity::position) {
    return at_joint ? Text{"move the first key into the range", "move the last key into the range"}
                    : Text{"start at rest (two control values 0 first), or leave room before the first key",
                           "end at rest (two control values 0 last), or leave room behind the last key"};
  }
  return {"start at rest (two control values 0 first), or more slowly",
          "end at rest (two control values 0 last), or more slowly"};
}

}  // namespace

Result<std::int32_t> roll_frames(const RollRequest& request) {
  const Result<Search> found = search(request);
  if (!found) return found.error();
  if (!found->obstacle) return found->frames;
  const RollBreach& obstacle = *found->obstacle;
  const auto quantity = static_cast<std::size_t>(obstacle.quantity);
  const Text what = obstacle.at_joint ? what_at_joint[quantity] : what_within[quantity];
  const Text cure = remedy(obstacle.quantity, obstacle.at_joint);
  const bool before = request.end == RollEnd::before;
  return Error{.code = ErrorCode::no_solution,
               .what = before ? what.before : what.after,
               .remedy = before ? cure.before : cure.after,
               .axis = obstacle.axis,
               .frame = request.joint_frame};
}

Result<std::optional<RollBreach>> roll_obstacle(const RollRequest& request) {
  const Result<Search> found = search(request);
  if (!found) return found.error();
  return found->obstacle;
}

}  // namespace inbetween
