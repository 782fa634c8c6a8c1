#include "inbetween/limits/roll.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace inbetween {
namespace {

/// T has three roundings, a h one more, b and the roots three, the values at most four; the partial
/// derivatives of the extremes by v and a T are at most 5 where S = 3 |v| + |a| T counts once. Together less
/// than 48 half units.
template <Precise Real>
constexpr Real rounding_share = 48 * std::numeric_limits<Real>::epsilon();

template <Precise Real>
Real duration(const RollSpan& span) {
  return static_cast<Real>(static_cast<std::int64_t>(span.frames) * span.fps.denominator) /
         static_cast<Real>(span.fps.numerator);
}

template <Precise Real>
bool is_at_rest(const AxisMotion<Real>& joint) {
  return joint.velocity == 0 && joint.acceleration == 0;
}

template <Precise Real>
bool is_finite(const AxisMotion<Real>& joint) {
  return std::isfinite(joint.position) && std::isfinite(joint.velocity) && std::isfinite(joint.acceleration);
}

template <Precise Real>
void lower(Peak<Real>& peak, Real value, Real frame) {
  if (value < peak.value) peak = {value, frame};
}

}  // namespace

template <Precise Real>
Result<RollAxis<Real>> RollAxis<Real>::make(const RollSpan& span, const AxisMotion<Real>& joint) {
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
  const Real seconds = duration<Real>(span);
  const Real scale = 64 * (3 * std::fabs(joint.velocity) + std::fabs(joint.acceleration) * seconds);
  if (!std::isfinite(std::fabs(joint.position) + scale * seconds) ||
      !std::isfinite(scale / seconds / seconds)) {
    return Error{.code = ErrorCode::out_of_range,
                 .what = "a roll would be beyond the range of the floating-point type",
                 .remedy = "use larger units or a slower move",
                 .frame = span.joint_frame};
  }
  return RollAxis(span, joint, span.end == RollEnd::before ? seconds : -seconds);
}

template <Precise Real>
AxisMotion<Real> RollAxis<Real>::at_share(Real s, Real u) const {
  const auto& [position, velocity, acceleration, jerk] = joint_;
  const Real h = signed_seconds_;
  const Real cubic = (2 * drift() - 3 * velocity) / 3;
  return {.position = position + h * (s * (velocity + s * (drift() / 2 + s * (cubic + s * (quartic_ / 4))))),
          .velocity = u * u * (velocity + quartic_ * s),
          .acceleration = u * (acceleration + 3 * (quartic_ / h) * s),
          .jerk = (acceleration + 3 * (quartic_ / h) * (s + u)) / h};
}

template <Precise Real>
AxisMotion<Real> RollAxis<Real>::motion(const FrameTime<Real>& time) const {
  const bool before = span_.end == RollEnd::before;
  const std::int32_t whole = before ? time.frame - span_.joint_frame : span_.joint_frame - time.frame;
  const Real fraction = before ? time.fraction : -time.fraction;
  const auto frames = static_cast<Real>(span_.frames);
  // Counted from the nearer end in whole frames, so that s and u keep the digits of the fraction.
  const Real u = (static_cast<Real>(span_.frames + whole) + fraction) / frames;
  if (u < 0) return {.position = rest_position()};
  return at_share((static_cast<Real>(whole) + fraction) / frames, u);
}

template <Precise Real>
AxisMotion<Real> RollAxis<Real>::motion_at_seconds(Real from_joint) const {
  const Real s = from_joint / signed_seconds_;
  if (s < -1) return {.position = rest_position()};
  return at_share(s, 1 + s);
}

template <Precise Real>
std::array<Real, 5> RollAxis<Real>::coefficients() const {
  const Real h = signed_seconds_;
  return {joint_.position, joint_.velocity, joint_.acceleration / 2,
          (2 * drift() - 3 * joint_.velocity) / 3 / h / h, quartic_ / 4 / h / h / h};
}

// --- bounds of one axis; u is 0 at rest and 1 at the joint, v (3 - r) u^2 - v (2 - r) u^3 the velocity

template <Precise Real>
Real RollAxis<Real>::frame_at(Real u) const {
  const Real away = (1 - u) * static_cast<Real>(span_.frames);
  const auto joint = static_cast<Real>(span_.joint_frame);
  return span_.end == RollEnd::before ? joint - away : joint + away;
}

/// r > 3: the axis backs up and turns at u = (r - 3) / (r - 2).
template <Precise Real>
bool RollAxis<Real>::turns_back() const {
  const Real along = joint_.velocity > 0 ? drift() : -drift();
  return joint_.velocity != 0 && along > 3 * std::fabs(joint_.velocity);
}

template <Precise Real>
AxisPeaks<Real> RollAxis<Real>::peaks() const {
  const Real here = frame_at(1);
  AxisPeaks<Real> peaks;
  peaks.lowest = peaks.highest = {joint_.position, here};
  peaks.velocity = {std::fabs(joint_.velocity), here};
  peaks.acceleration = {std::fabs(joint_.acceleration), here};
  peaks.jerk = {0, here};
  if (is_at_rest(joint_)) return peaks;
  const Real rounding = rounding_share<Real> * (3 * std::fabs(joint_.velocity) + std::fabs(drift())) +
                        std::numeric_limits<Real>::min();
  bound_position(rounding, peaks);
  bound_velocity(rounding, peaks);
  bound_acceleration(rounding, peaks);
  bound_jerk(rounding, peaks);
  return peaks;
}

template <Precise Real>
void RollAxis<Real>::bound_position(Real rounding, AxisPeaks<Real>& peaks) const {
  const Real v = joint_.velocity;
  const Real h = signed_seconds_;
  const Real slack =
      rounding * seconds() + 4 * std::numeric_limits<Real>::epsilon() * std::fabs(joint_.position);
  const Real rest = joint_.position - h * (v / 2 - drift() / 12);
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
  const Real m = v / quartic_;  // 1 - u of the turn
  const Real turn = joint_.position - h * (v * (m * (6 - m * (4 - m)) / 12));
  if (from_below) {
    lower(peaks.lowest, turn - slack, frame_at(1 - m));
    peaks.highest.raise(rest + slack, frame_at(0));
  } else {
    peaks.highest.raise(turn + slack, frame_at(1 - m));
    lower(peaks.lowest, rest - slack, frame_at(0));
  }
}

template <Precise Real>
void RollAxis<Real>::bound_velocity(Real rounding, AxisPeaks<Real>& peaks) const {
  const Real v = joint_.velocity;
  const Real rise = 3 * v - drift();
  const bool overshoots = (v > 0 && drift() < 0) || (v < 0 && drift() > 0);  // r < 0
  const bool from_standstill = v == 0 && quartic_ != 0;
  if (!overshoots && !turns_back() && !from_standstill) return;
  const Real u = std::min(-2 * rise / (3 * quartic_), Real{1});
  peaks.velocity.raise(u * u * std::fabs(rise) / 3 + rounding, frame_at(u));
}

template <Precise Real>
void RollAxis<Real>::bound_acceleration(Real rounding, AxisPeaks<Real>& peaks) const {
  const Real v = joint_.velocity;
  const Real along = v > 0 ? drift() : -drift();
  // For r >= 3/2 the joint has the largest; below, u = (3 - r) / (3 (2 - r)). So close to 3/2 that rounding
  // hides on which side, both differ by epsilon squared, which is still something.
  if (v == 0 || 2 * along >= 3 * std::fabs(v) * (1 + rounding_share<Real>)) return;
  const Real rise = 3 * v - drift();
  const Real u = std::min(-rise / (3 * quartic_), Real{1});
  peaks.acceleration.raise((u * std::fabs(rise) + rounding) / seconds(), frame_at(u));
}

template <Precise Real>
void RollAxis<Real>::bound_jerk(Real rounding, AxisPeaks<Real>& peaks) const {
  const Real at_rest = std::fabs(6 * joint_.velocity - 2 * drift());
  const Real at_joint = std::fabs(4 * drift() - 6 * joint_.velocity);
  peaks.jerk.raise((at_joint + rounding) / seconds() / seconds(), frame_at(1));
  peaks.jerk.raise((at_rest + rounding) / seconds() / seconds(), frame_at(0));
}

template class RollAxis<double>;
template class RollAxis<float>;

}  // namespace inbetween
