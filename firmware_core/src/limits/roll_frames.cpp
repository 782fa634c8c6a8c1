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

template <Precise Real>
bool all_at_rest(std::span<const AxisMotion<Real>> joints) {
  for (const AxisMotion<Real>& joint : joints) {
    if (joint.velocity != 0 || joint.acceleration != 0) return false;
  }
  return true;
}

/// A roll that nobody looks at is ruled out by this much more than its rounding.
template <Precise Real>
constexpr Real generous = 16 * std::numeric_limits<Real>::epsilon();

template <Precise Real>
using Breach = std::optional<RollBreach<Real>>;

/// The limit that the joint breaks, and so the move.
template <Precise Real>
Breach<Real> breach_at_joint(const AxisMotion<Real>& joint, const AxisLimits<Real>& limits) {
  const auto broken = [](RollQuantity quantity, Real value, Real limit) {
    return RollBreach<Real>{.quantity = quantity, .at_joint = true, .value = value, .limit = limit};
  };
  const Real speed = std::fabs(joint.velocity);
  const Real acceleration = std::fabs(joint.acceleration);
  if (speed > limits.max_velocity()) return broken(RollQuantity::velocity, speed, limits.max_velocity());
  if (acceleration > limits.max_acceleration())
    return broken(RollQuantity::acceleration, acceleration, limits.max_acceleration());
  if (joint.position < limits.min()) return broken(RollQuantity::position, joint.position, limits.min());
  if (joint.position > limits.max()) return broken(RollQuantity::position, joint.position, limits.max());
  return std::nullopt;
}

template <Precise Real>
Breach<Real> breach_on_the_way(const AxisPeaks<Real>& peaks, const AxisLimits<Real>& limits) {
  const auto broken = [](RollQuantity quantity, const Peak<Real>& peak, Real limit) {
    return RollBreach<Real>{.quantity = quantity, .value = peak.value, .limit = limit, .frame = peak.frame};
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

template <Precise Real>
Result<Breach<Real>> breach_of_axis(const RollRequest<Real>& request, std::size_t axis, std::int32_t frames) {
  const auto number = static_cast<std::int32_t>(axis);
  const Result<RollAxis<Real>> roll =
      RollAxis<Real>::make({request.end, request.joint_frame, frames, request.fps}, request.joints[axis]);
  if (!roll) {
    Error error = roll.error();
    error.axis = number;
    return error;
  }
  Breach<Real> breach = breach_at_joint(request.joints[axis], request.limits[axis]);
  if (breach) {
    breach->frame = static_cast<Real>(request.joint_frame);
  } else {
    breach = breach_on_the_way(roll->peaks(), request.limits[axis]);
  }
  if (breach) {
    breach->axis = number;
    breach->frames = frames;
  }
  return breach;
}

template <Precise Real>
Status check_request(const RollRequest<Real>& request) {
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
template <Precise Real>
bool longer_may_help(const RollRequest<Real>& request, const RollBreach<Real>& breach) {
  if (breach.at_joint || breach.quantity == RollQuantity::velocity) return false;
  if (breach.quantity != RollQuantity::position) return true;
  const AxisMotion<Real>& joint = request.joints[static_cast<std::size_t>(breach.axis)];
  const bool before = request.end == RollEnd::before;
  const bool from_below = (joint.velocity > 0) == before;
  const bool pushed_along = joint.velocity != 0 && (joint.acceleration < 0) != from_below;  // r > 0 or a = 0
  const bool broken_below = breach.value < breach.limit;
  if (!pushed_along || joint.acceleration == 0 || broken_below != from_below) return false;
  const Real min_way =
      std::fabs(joint.velocity) * (std::fabs(joint.velocity) / std::fabs(2 * joint.acceleration));
  return min_way <= std::fabs(joint.position - breach.limit) * (1 + generous<Real>);
}

/// No roll of fewer frames changes a velocity so far within the limits of acceleration and jerk.
template <Precise Real>
std::int32_t fewest_frames(const RollRequest<Real>& request) {
  Real seconds = 0;
  for (std::size_t i = 0; i < request.joints.size(); ++i) {
    const Real v = std::fabs(request.joints[i].velocity);
    const Real a = std::fabs(request.joints[i].acceleration);
    seconds = std::max(seconds, v / request.limits[i].max_acceleration());
    if (const std::optional<Real> jerk = request.limits[i].max_jerk()) {
      seconds = std::max(seconds, std::max(a / *jerk, std::sqrt(2 * (v / *jerk))));
    }
  }
  const Real frames = seconds * static_cast<Real>(request.fps.numerator) /
                      static_cast<Real>(request.fps.denominator) * (1 - generous<Real>);
  if (!(frames < static_cast<Real>(max_roll_frames))) return max_roll_frames;
  const auto whole = static_cast<std::int32_t>(frames);
  return std::max(static_cast<Real>(whole) < frames ? whole + 1 : whole, std::int32_t{1});
}

/// Names a limit that a roll of `frames` frames breaks: one that no longer roll keeps, else one that wants a
/// longer roll whatever else there is, else one of position.
template <Precise Real>
Result<Breach<Real>> weightiest_breach(const RollRequest<Real>& request, std::int32_t frames) {
  Breach<Real> weightiest;
  for (std::size_t i = 0; i < request.joints.size(); ++i) {
    const Result<Breach<Real>> breach = breach_of_axis(request, i, frames);
    if (!breach) return breach.error();
    if (!*breach) continue;
    if (!longer_may_help(request, **breach)) return *breach;
    const bool weighs_more = (*breach)->quantity != RollQuantity::position && weightiest &&
                             weightiest->quantity == RollQuantity::position;
    if (!weightiest || weighs_more) weightiest = *breach;
  }
  return weightiest;
}

/// The answer, or what is in the way.
template <Precise Real>
struct Search {
  std::int32_t frames = 0;
  Breach<Real> obstacle;
};

template <Precise Real>
Result<Search<Real>> search(const RollRequest<Real>& request) {
  const Status counts = check_request(request);
  if (!counts) return counts.error();
  if (all_at_rest(request.joints)) return Search<Real>{};
  Breach<Real> obstacle;
  for (std::int32_t frames = fewest_frames(request); frames <= max_roll_frames; ++frames) {
    const Result<Breach<Real>> breach = weightiest_breach(request, frames);
    if (!breach) return breach.error();
    if (!*breach) return Search<Real>{.frames = frames, .obstacle = std::nullopt};
    if (!longer_may_help(request, **breach)) return Search<Real>{.frames = 0, .obstacle = *breach};
    // The shortest roll that would do but for its travel is the one to report.
    if (!obstacle || obstacle->quantity != RollQuantity::position) obstacle = *breach;
  }
  return Search<Real>{.frames = 0, .obstacle = obstacle};
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
constexpr std::array what_on_the_way{
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

template <Precise Real>
Result<std::optional<RollBreach<Real>>> roll_breach(const RollRequest<Real>& request, std::int32_t frames) {
  const Status counts = check_request(request);
  if (!counts) return counts.error();
  for (std::size_t i = 0; i < request.joints.size(); ++i) {
    Result<Breach<Real>> breach = breach_of_axis(request, i, frames);
    if (!breach || *breach) return breach;
  }
  return Breach<Real>{};
}

template <Precise Real>
Result<std::int32_t> roll_frames(const RollRequest<Real>& request) {
  const Result<Search<Real>> found = search(request);
  if (!found) return found.error();
  if (!found->obstacle) return found->frames;
  const RollBreach<Real>& obstacle = *found->obstacle;
  const auto quantity = static_cast<std::size_t>(obstacle.quantity);
  const Text what = obstacle.at_joint ? what_at_joint[quantity] : what_on_the_way[quantity];
  const Text cure = remedy(obstacle.quantity, obstacle.at_joint);
  const bool before = request.end == RollEnd::before;
  return Error{.code = ErrorCode::no_solution,
               .what = before ? what.before : what.after,
               .remedy = before ? cure.before : cure.after,
               .axis = obstacle.axis,
               .frame = request.joint_frame};
}

template <Precise Real>
Result<std::optional<RollBreach<Real>>> roll_obstacle(const RollRequest<Real>& request) {
  const Result<Search<Real>> found = search(request);
  if (!found) return found.error();
  return found->obstacle;
}

#define INBETWEEN_INSTANTIATE(Real)                                                                     \
  template Result<std::optional<RollBreach<Real>>> roll_breach(const RollRequest<Real>&, std::int32_t); \
  template Result<std::int32_t> roll_frames(const RollRequest<Real>&);                                  \
  template Result<std::optional<RollBreach<Real>>> roll_obstacle(const RollRequest<Real>&);
INBETWEEN_INSTANTIATE(double)
INBETWEEN_INSTANTIATE(float)
#undef INBETWEEN_INSTANTIATE

}  // namespace inbetween
