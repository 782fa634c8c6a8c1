#include "host_tools/hosted/hosted_rig.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "host_tools/motions/free_axes.hpp"
#include "host_tools/rig_model/rig_motors.hpp"
#include "host_tools/text/diagnostics.hpp"

namespace inbetween {

using namespace dragonframe;

namespace {

/// A slower host moves with this share of the limits all the same: below it a stop would be without measure.
constexpr double min_share = 1e-3;
constexpr double full_jog_speed = 10'000;

}  // namespace

HostedRig::HostedRig(const RigFile& rig, HostedMotion& motion, HostedRigOptions options)
    : rig_(rig), motion_(motion), options_(std::move(options)), settings_(rig.axes.size()) {
  for (const double steps : rig.dragonframe->steps_per_unit) scales_.push_back({.steps_per_unit = steps});
}

RigAnswer HostedRig::take(const RigOrder& order) {
  return std::visit([&](const auto& what) { return apply(what); }, order);
}

RigAnswer HostedRig::refuse(RigAnswer answer, std::string why) {
  words_.push_back(std::move(why));
  return answer;
}

bool HostedRig::is_ready() const {
  return now_.state == SupervisorState::ready || now_.state == SupervisorState::running;
}

void HostedRig::acknowledge() {
  if (is_ready()) return;
  leave_frame();
  send({.kind = MotionOrder::Kind::acknowledge});
}

bool HostedRig::send(MotionOrder order, MotorMask moves) {
  order.number = sent_ + 1;
  if (!motion_.order(order)) return false;
  ++sent_;
  pending_ |= moves;
  return true;
}

bool HostedRig::mark(MotorMask motors) {
  if (options_.rig_has_changed && options_.rig_has_changed()) {
    words_.emplace_back("the rig file was changed; leave with q, and begin again");
    return false;
  }
  if (!options_.about_to_move) return true;
  try {
    options_.about_to_move(axes_of(motors));
  } catch (const std::runtime_error& error) {
    words_.emplace_back(error.what());
    return false;
  }
  is_marked_ = true;
  return true;
}

void HostedRig::leave_frame() {
  at_frame_.reset();
  goal_frame_.reset();
}

/// Whether anything may begin.
RigAnswer HostedRig::may_move() {
  if (is_ready()) return RigAnswer::ok;
  return refuse(RigAnswer::general, "the rig was stopped: Enter asks its drives where they are");
}

/// Whether an axis may go by itself.
RigAnswer HostedRig::may_go() {
  const bool is_free = phase_ == Phase::none || phase_ == Phase::going || phase_ == Phase::waiting;
  if (!is_free || now_.plays) return RigAnswer::moving;
  return may_move();
}

/// What the rounding of steps has put beyond a limit goes to the limit.
RigAnswer HostedRig::judge_position(std::size_t axis, double& position) {
  const RigAxis& of = axis_of(axis);
  const double rounding = 1e-9 * std::max({std::fabs(of.min), std::fabs(of.max), of.max - of.min});
  if (position >= of.min - rounding && position <= of.max + rounding) {
    position = std::clamp(position, of.min, of.max);
    return RigAnswer::ok;
  }
  const bool is_upper = (position > of.max) == (scales_[axis].steps_per_unit > 0);
  return refuse(is_upper ? RigAnswer::soft_upper : RigAnswer::soft_lower,
                fmt::format("{} would go to {:.6g} {}, outside its limits {}", named(of), position,
                            to_string(of.unit), range_in_words(of)));
}

/// A share of the rig's, and no more than the host has set. A stop may use all that the rig has.
FreeAxisLimits HostedRig::limits_of_axis(std::size_t axis) const {
  const double per_unit = std::fabs(scales_[axis].steps_per_unit);
  const RigAxis& of = axis_of(axis);
  const double hosts =
      settings_[axis].max_acceleration / per_unit / slow_enough_everywhere(of).max_acceleration;
  const double share = std::clamp(hosts, min_share, options_.share);
  FreeAxisLimits limits = free_limits_of(of, share);
  limits.velocity =
      std::min(free_limits_of(of, options_.share).velocity, settings_[axis].max_velocity / per_unit);
  limits.stop_share = 1 / share;
  return limits;
}

RigAnswer HostedRig::go(std::size_t axis, double position, double velocity) {
  const MotorMask motor = MotorMask{1} << axis;
  const bool is_sent =
      mark(motor) &&
      send({.kind = MotionOrder::Kind::go, .axis = axis, .position = position, .velocity = velocity}, motor);
  return is_sent ? RigAnswer::ok : RigAnswer::general;
}

/// Each by itself; those that are there already stay. All are judged before any goes.
RigAnswer HostedRig::go_all(const std::vector<std::pair<std::size_t, double>>& targets) {
  std::vector<std::pair<std::size_t, double>> away = targets;
  for (auto& [axis, position] : away) {
    const RigAnswer answer = judge_position(axis, position);
    if (answer != RigAnswer::ok) return answer;
  }
  for (const auto& [axis, position] : away) {
    if (commanded(axis) == position && (now_.moving >> axis & 1U) == 0) continue;
    const RigAnswer answer = go(axis, position, limits_of_axis(axis).velocity);
    if (answer != RigAnswer::ok) return answer;
  }
  return RigAnswer::ok;
}

RigAnswer HostedRig::apply(const SetMotor& order) {
  if (!has_axis(order.motor)) return RigAnswer::range;
  if (order.settings.is_live || order.settings.drives_next) {
    return refuse(RigAnswer::unsupported, "live and coupled motors are not moved");
  }
  const std::size_t axis = order.motor - 1U;
  settings_[axis] = order.settings;
  send({.kind = MotionOrder::Kind::limit, .axis = axis, .limits = limits_of_axis(axis)});
  return RigAnswer::ok;
}

/// The axis stays where it is: the host counts it otherwise.
RigAnswer HostedRig::apply(const PlaceMotor& order) {
  if (!has_axis(order.motor)) return RigAnswer::range;
  StepScale& scale = scales_[order.motor - 1U];
  const std::int64_t offset =
      order.position - std::llround(commanded(order.motor - 1U) * scale.steps_per_unit);
  if (std::abs(offset) > std::numeric_limits<std::int32_t>::max() / 2) {
    return refuse(RigAnswer::range, "so far from its own 0 the axis cannot be counted");
  }
  scale.offset = offset;
  leave_frame();
  drop_prepared();
  drop_travel();
  show();
  return RigAnswer::ok;
}

RigAnswer HostedRig::apply(const MoveMotor& order) {
  if (!has_axis(order.motor)) return RigAnswer::range;
  if (const RigAnswer may = may_go(); may != RigAnswer::ok) return may;
  const std::size_t axis = order.motor - 1U;
  double position = scales_[axis].units(order.target);
  RigAnswer answer = judge_position(axis, position);
  if (answer == RigAnswer::ok) answer = go(axis, position, limits_of_axis(axis).velocity);
  if (answer != RigAnswer::ok) return answer;
  leave_frame();
  drop_prepared();
  phase_ = Phase::going;
  return RigAnswer::ok;
}

/// As far as the limits of the rig, where the host names no nearer end.
RigAnswer HostedRig::apply(const JogMotor& order) {
  if (!has_axis(order.motor)) return RigAnswer::range;
  if (const RigAnswer may = may_go(); may != RigAnswer::ok) return may;
  const std::size_t axis = order.motor - 1U;
  const RigAxis& of = axis_of(axis);
  const double wanted = scales_[axis].units(order.destination);
  const double position = std::clamp(wanted, of.min, of.max);
  if (position != wanted && commanded(axis) == position) {
    const bool is_upper = (wanted > of.max) == (scales_[axis].steps_per_unit > 0);
    return refuse(is_upper ? RigAnswer::soft_upper : RigAnswer::soft_lower,
                  fmt::format("{} is at the end of its range {}", named(of), range_in_words(of)));
  }
  const double velocity = limits_of_axis(axis).velocity * order.speed / full_jog_speed;
  const RigAnswer answer = go(axis, position, velocity);
  if (answer != RigAnswer::ok) return answer;
  leave_frame();
  drop_prepared();
  phase_ = Phase::going;
  return RigAnswer::ok;
}

RigAnswer HostedRig::apply(const StopMotor& order) {
  if (!has_axis(order.motor)) return RigAnswer::range;
  send({.kind = MotionOrder::Kind::stop_axis, .axis = order.motor - 1U});
  return RigAnswer::ok;
}

/// As hard as the limits for stops allow: a second one finds nothing left.
RigAnswer HostedRig::apply(const StopAll& /*order*/) {
  if (!send({.kind = MotionOrder::Kind::stop})) return RigAnswer::general;
  const bool is_moving = now_.moving != 0 || pending_ != 0 || now_.plays;
  drop_prepared();
  goal_frame_.reset();
  begin_phase(is_moving ? Phase::stopping : Phase::none, 0);
  return RigAnswer::ok;
}

RigAnswer HostedRig::apply(const SetOutputs& order) {
  const std::size_t outputs = output_count(rig_);
  if (outputs == 0) return order.bits == 0 ? RigAnswer::ok : RigAnswer::unsupported;
  if ((std::uint64_t{order.bits} >> outputs) != 0) return RigAnswer::range;
  const bool is_sent = send({.kind = MotionOrder::Kind::switch_outputs, .outputs = order.bits});
  return is_sent ? RigAnswer::ok : RigAnswer::general;
}

RigAnswer HostedRig::apply(const SetCamera& order) {
  return order == SetCamera{} ? RigAnswer::ok : RigAnswer::unsupported;
}

RigAnswer HostedRig::apply(const ForgetHost& /*order*/) {
  drop_prepared();
  drop_travel();
  upload_ = nullptr;
  uploaded_ = 0;
  leave_frame();
  for (StepScale& scale : scales_) scale.offset = 0;
  for (std::size_t a = 0; a < settings_.size(); ++a) {
    settings_[a] = {};
    send({.kind = MotionOrder::Kind::limit, .axis = a, .limits = limits_of_axis(a)});
  }
  show();
  return RigAnswer::ok;
}

}  // namespace inbetween
