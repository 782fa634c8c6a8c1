#include "inbetween/limits/roll.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace inbetween {
namespace {

/// T has three roundings, a h one more, b and the roots three, the values at most four; the partial
/// derivatives of the extremes by v and a T are at most 5 where S = 3 |v| + |a| T counts once. Together less
/// than 48 half units.
constexpr double rounding_share = 48 * std::numeric_limits<double>::epsilon();

double duration(const RollSpan& span) {
  return static_cast<double>(static_cast<std::int64_t>(span.frames) * span.fps.denominator) /
         static_cast<double>(span.fps.numerator);
}

bool is_at_rest(const AxisMotion& joint) {
  return joint.velocity == 0 && joint.acceleration == 0;
}

bool is_finite(const AxisMotion& joint) {
  return std::isfinite(joint.position) && std::isfinite(joint.velocity) && std::isfinite(joint.acceleration);
}

void lower(Peak& peak, double value, double frame) {
  if (value < peak.value) peak = {value, frame};
}

}  // namespace

Result<RollAxis> RollAxis::make(const RollSpan& span, const AxisMotion& joint) {
  if (!is_finite(joint)) {
    return Error{
        .code = ErrorCode::not_finite,
        .what = "position, velocity or acceleration where a roll joins the move is not a finite number",
        .remedy = "let the move start and end where the path does not stand still",
        .frame = span.joint_frame};
  }
  if (span.frames < 1 || span.frames > max_roll_frames || span.fps.numerator < 1 ||
      span.fps.denominator < 1) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a roll has no frames, too many, or no frame rate",
                 .remedy = "use 1 to 10000 frames at a rate above 0",
                 .frame = span.joint_frame};
  }
  const double seconds = duration(span);
  const double scale = 64 * (3 * std::fabs(joint.velocity) + std::fabs(joint.acceleration) * seconds);
  if (!std::isfinite(std::fabs(joint.position) + scale * seconds) ||
      !std::isfinite(scale / seconds / seconds)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a roll would be beyond the range of the floating-point type",
                 .remedy = "use larger units or a slower move",
                 .frame = span.joint_frame};
  }
  return RollAxis(span, joint, span.end == RollEnd::before ? seconds : -seconds);
}

AxisMotion RollAxis::at_share(double s, double u) const {
  const auto& [position, velocity, acceleration, jerk] = joint_;
  const double h = signed_seconds_;
  const double cubic = (2 * drift() - 3 * velocity) / 3;
  return {.position = position + h * (s * (velocity + s * (drift() / 2 + s * (cubic + s * (quartic_ / 4))))),
          .velocity = u * u * (velocity + quartic_ * s),
          .acceleration = u * (acceleration + 3 * (quartic_ / h) * s),
          .jerk = (acceleration + 3 * (quartic_ / h) * (s + u)) / h};
}

AxisMotion RollAxis::motion(const FrameTime& time) const {
  const bool before = span_.end == RollEnd::before;
  const std::int32_t whole = before ? time.frame - span_.joint_frame : span_.joint_frame - time.frame;
  const double fraction = before ? time.fraction : -time.fraction;
  const auto frames = static_cast<double>(span_.frames);
  // Counted from the nearer end in whole frames, so that s and u keep the digits of the fraction.
  const double u = (static_cast<double>(span_.frames + whole) + fraction) / frames;
  if (u < 0) return {.position = rest_position()};
  return at_share((static_cast<double>(whole) + fraction) / frames, u);
}

std::array<double, 5> RollAxis::coefficients() const {
  const double h = signed_seconds_;
  return {joint_.position, joint_.velocity, joint_.acceleration / 2,
          (2 * drift() - 3 * joint_.velocity) / 3 / h / h, quartic_ / 4 / h / h / h};
}

// --- bounds of one axis; u is 0 at rest and 1 at the joint, v (3 - r) u^2 - v (2 - r) u^3 the velocity

double RollAxis::frame_at(double u) const {
  const double away = (1 - u) * static_cast<double>(span_.frames);
  const auto joint = static_cast<double>(span_.joint_frame);
  return span_.end == RollEnd::before ? joint - away : joint + away;
}

/// r > 3: the axis backs up and turns at u = (r - 3) / (r - 2).
bool RollAxis::turns_back() const {
  const double along = joint_.velocity > 0 ? drift() : -drift();
  return joint_.velocity != 0 && along > 3 * std::fabs(joint_.velocity);
}

AxisPeaks RollAxis::peaks() const {
  const double here = frame_at(1);
  AxisPeaks peaks;
  peaks.lowest = peaks.highest = {joint_.position, here};
  peaks.velocity = {std::fabs(joint_.velocity), here};
  peaks.acceleration = {std::fabs(joint_.acceleration), here};
  peaks.jerk = {0, here};
  if (is_at_rest(joint_)) return peaks;
  const double rounding = rounding_share * (3 * std::fabs(joint_.velocity) + std::fabs(drift())) +
                          std::numeric_limits<double>::min();
  bound_position(rounding, peaks);
  bound_velocity(rounding, peaks);
  bound_acceleration(rounding, peaks);
  bound_jerk(rounding, peaks);
  return peaks;
}

void RollAxis::bound_position(double rounding, AxisPeaks& peaks) const {
  const double v = joint_.velocity;
  const double h = signed_seconds_;
  const double slack =
      rounding * seconds() + 4 * std::numeric_limits<double>::epsilon() * std::fabs(joint_.position);
  const double rest = joint_.position - h * (v / 2 - drift() / 12);
  // Away from the side of which it is known that the axis comes from there, nothing is beyond the joint; so
  // the joint is not widened by the slack of its neighbours.
  const bool from_below = v != 0 ? (v > 0) == (h > 0) : joint_.acceleration < 0;
  if (!turns_back()) {
    if (from_below) {
      lower(peaks.lowest, rest - slack, frame_at(0));
    } else {
      peaks.highest.raise(rest + slack, frame_at(0));
    }
    return;
  }
  const double m = v / quartic_;  // 1 - u of the turn
  const double turn = joint_.position - h * (v * (m * (6 - m * (4 - m)) / 12));
  if (from_below) {
    lower(peaks.lowest, turn - slack, frame_at(1 - m));
    peaks.highest.raise(rest + slack, frame_at(0));
  } else {
    peaks.highest.raise(turn + slack, frame_at(1 - m));
    lower(peaks.lowest, rest - slack, frame_at(0));
  }
}

void RollAxis::bound_velocity(double rounding, AxisPeaks& peaks) const {
  const double v = joint_.velocity;
  const double rise = 3 * v - drift();
  const bool overshoots = (v > 0 && drift() < 0) || (v < 0 && drift() > 0);  // r < 0
  const bool from_standstill = v == 0 && quartic_ != 0;
  if (!overshoots && !turns_back() && !from_standstill) return;
  const double u = std::min(-2 * rise / (3 * quartic_), 1.0);
  peaks.velocity.raise(u * u * std::fabs(rise) / 3 + rounding, frame_at(u));
}

void RollAxis::bound_acceleration(double rounding, AxisPeaks& peaks) const {
  const double v = joint_.velocity;
  const double along = v > 0 ? drift() : -drift();
  // For r >= 3/2 the joint has the largest; below, u = (3 - r) / (3 (2 - r)). So close to 3/2 that rounding
  // hides on which side, both differ by epsilon squared, which is still something.
  if (v == 0 || 2 * along >= 3 * std::fabs(v) * (1 + rounding_share)) return;
  const double rise = 3 * v - drift();
  const double u = std::min(-rise / (3 * quartic_), 1.0);
  peaks.acceleration.raise((u * std::fabs(rise) + rounding) / seconds(), frame_at(u));
}

void RollAxis::bound_jerk(double rounding, AxisPeaks& peaks) const {
  const double at_rest = std::fabs(6 * joint_.velocity - 2 * drift());
  const double at_joint = std::fabs(4 * drift() - 6 * joint_.velocity);
  peaks.jerk.raise((at_joint + rounding) / seconds() / seconds(), frame_at(1));
  peaks.jerk.raise((at_rest + rounding) / seconds() / seconds(), frame_at(0));
}

}  // namespace inbetween
