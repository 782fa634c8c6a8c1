#include "host_tools/check/check_refusals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace inbetween {
namespace {

constexpr std::string_view turn_remedy =
    "let the speed touch 0 there with corners = \"ease\", or move a key so that the path goes round";

/// The faults of one axis, in words.
class AxisRefusals {
 public:
  AxisRefusals(const Plan& plan, std::size_t index, CheckReport& report)
      : move_(plan.move()),
        track_(plan.move().tracks[*plan.axes()[index].track]),
        place_(plan.place_of(index)),
        rig_(*plan.rig()),
        limits_(plan.rig()->axes[index]),
        index_(index),
        axis_in_track_(plan.axes()[index].track_axis),
        axis_(report.axes[index]),
        report_(report) {}

  void add_all() {
    add_position();
    add_velocity_step();
    add_acceleration_step();
    if (add_unbounded()) return;
    add_peak(axis_.velocity, "max_velocity", "/s");
    add_peak(axis_.acceleration, "max_acceleration", "/s^2");
    add_peak(axis_.jerk, "max_jerk", "/s^3");
  }

 private:
  void refuse(const Place& place, double frame, std::string what, std::string_view remedy, bool slower_helps,
              bool at_any_rate = false) {
    report_.refusals.push_back(
        {place, std::move(what), std::string(remedy), index_, frame, slower_helps, at_any_rate});
  }

  void add_position() {
    const Peak<double>& lowest = axis_.range->lowest;
    const Peak<double>& highest = axis_.range->highest;
    const double below = limits_.min - lowest.value;
    const double above = highest.value - limits_.max;
    const double rounding = position_rounding(limits_);
    if (below <= rounding && above <= rounding) return;
    const Peak<double>& worst = below > above ? lowest : highest;
    refuse(place_, worst.frame,
           fmt::format("axis {} would go to {} {} at frame {:.2f}, outside {} of the rig {}",
                       in_quotes(axis_.name), worst.value, axis_.unit, worst.frame, range_in_words(limits_),
                       in_quotes(rig_.name)),
           remedy_of_position(), false, true);
  }
  /// Where its keys are inside, it is the curve between them that goes beyond.
  [[nodiscard]] std::string remedy_of_position() const {
    const bool can_overshoot =
        track_.overshoot && (track_.spline == Spline::smooth || track_.spline == Spline::catmull_rom);
    const bool keys_are_inside = !track_.space && std::ranges::all_of(track_.keys, [&](const MoveKey& key) {
      const double at = key.at[axis_in_track_];
      return at >= limits_.min && at <= limits_.max;
    });
    if (!keys_are_inside || !can_overshoot) return "move its keys inward";
    return "keep the curve between its keys with overshoot = false, or move its keys inward";
  }

  /// The largest step of this axis, and how many there are beside it.
  struct LargestStep {
    const CheckedStep* step = nullptr;
    std::size_t others = 0;

    void take(const CheckedStep& next, double CheckedStep::*size) {
      if (step != nullptr) ++others;
      if (step == nullptr || next.*size > step->*size) step = &next;
    }
    [[nodiscard]] std::string where() const {
      std::string words = fmt::format("frame {:.2f}", step->frame);
      if (step->key) words = fmt::format("key {}, {}", *step->key, words);
      if (others > 0) words += fmt::format(", and at {} more place{}", others, others == 1 ? "" : "s");
      return words;
    }
  };

  void add_velocity_step() {
    LargestStep largest;
    for (const CheckedStep& step : report_.steps) {
      if (step.axis == index_ && step.velocity > 0) largest.take(step, &CheckedStep::velocity);
    }
    if (largest.step == nullptr) return;
    refuse(place_of(*largest.step), largest.step->frame,
           fmt::format("axis {} would step by {:.6g} {}/s at {}, which no drive can follow",
                       in_quotes(axis_.name), largest.step->velocity, axis_.unit, largest.where()),
           remedy_of(*largest.step), false);
  }

  void add_acceleration_step() {
    LargestStep largest;
    for (const CheckedStep& step : report_.steps) {
      // A step of the velocity has been said, and its remedy cures both.
      const bool is_refused = step.velocity == 0 && breaks_jerk_limit(step, limits_);
      if (step.axis == index_ && is_refused) largest.take(step, &CheckedStep::acceleration);
    }
    if (largest.step == nullptr) return;
    const auto [step, most] = told_apart(largest.step->acceleration,
                                         limits_.max_acceleration_step.value_or(0), Digits::significant, 6);
    const std::string rule = limits_.max_acceleration_step
                                 ? fmt::format("max_acceleration_step is {} {}/s^2", most, axis_.unit)
                                 : "max_jerk allows no step";
    refuse(place_of(*largest.step), largest.step->frame,
           fmt::format("axis {} would step by {} {}/s^2 at {}, and {}", in_quotes(axis_.name), step,
                       axis_.unit, largest.where(), rule),
           remedy_of(*largest.step), limits_.max_acceleration_step.has_value());
  }

  /// If something has no bound, its derivatives have none either: it is said once.
  bool add_unbounded() {
    if (!std::isfinite(axis_.velocity.value)) {
      add_unbounded("a velocity", axis_.velocity, "stands still for the axes that have a weight");
    } else if (!std::isfinite(axis_.acceleration.value)) {
      add_unbounded("an acceleration", axis_.acceleration, "turns on the spot");
    } else if (!std::isfinite(axis_.jerk.value) && axis_.jerk.limit) {
      add_unbounded("a jerk", axis_.jerk, "turns on the spot");
    } else {
      return false;
    }
    return true;
  }
  void add_unbounded(std::string_view quantity, const CheckedPeak& peak, std::string_view what) {
    refuse(
        place_, peak.frame,
        fmt::format("axis {} would need {} without bound near frame {:.2f}, where the path {} and is passed "
                    "at a speed",
                    in_quotes(axis_.name), quantity, peak.frame, what),
        turn_remedy, false, true);
  }

  void add_peak(const CheckedPeak& peak, std::string_view limit, std::string_view per) {
    if (!peak.is_exceeded()) return;
    const auto [value, most] = told_apart(peak.value, *peak.limit, Digits::significant, 6);
    refuse(place_, peak.frame,
           fmt::format(
               "axis {} would reach {} {}{} at frame {:.2f}, and {} {} {} {}{}", in_quotes(axis_.name), value,
               axis_.unit, per, peak.frame, limit,
               limits_.backlash && !limits_.calibration ? "leaves beside the take-up of the backlash" : "is",
               most, axis_.unit, per),
           track_.timing == Timing::speed ? "give the move more frames, or draw a flatter speed curve there"
                                          : "give the move more frames there",
           true);
  }

  [[nodiscard]] static bool is_start(const CheckedStep& step) { return step.frame <= 0; }
  [[nodiscard]] bool is_end(const CheckedStep& step) const { return step.frame >= move_.frames; }
  [[nodiscard]] const MoveKey* key_of(const CheckedStep& step) const {
    return step.key ? &track_.keys[static_cast<std::size_t>(*step.key)] : nullptr;
  }

  [[nodiscard]] const Place& place_of(const CheckedStep& step) const {
    if (is_start(step) && !track_.speed_places.empty()) return track_.speed_places.front();
    if (is_end(step) && !track_.speed_places.empty()) return track_.speed_places.back();
    return step.key ? key_of(step)->place : place_;
  }
  [[nodiscard]] std::string remedy_of(const CheckedStep& step) const {
    if (track_.timing == Timing::frames && kinetic_of(track_) != MoveKinetic::pace) {
      if (track_.spline == Spline::linear) return "use spline = \"smooth\" and kinetic = \"curves\"";
      if (kinetic_of(track_) != MoveKinetic::curves) return "use kinetic = \"curves\"";
      return "use spline = \"smooth\"";
    }
    if (track_.timing == Timing::frames && (is_start(step) || is_end(step))) return "use rest = \"both\"";
    if (is_start(step)) return "begin the speed curve with 0, 0, at rest";
    if (is_end(step)) return "end the speed curve with 0, 0, at rest";
    if (!step.key) return std::string(turn_remedy);
    if (key_of(step)->breaks) return "take away the break of the key";
    const std::string ease = track_.timing == Timing::frames
                                 ? "let the speed touch 0 there with ease = true"
                                 : "let the speed touch 0 there with ease = true, or rest there with hold";
    return (track_.spline != Spline::smooth ? "use spline = \"smooth\", or " : "") + ease;
  }

  const MoveFile& move_;
  const MoveTrack& track_;
  const Place& place_;
  const RigFile& rig_;
  const RigAxis& limits_;
  std::size_t index_;
  std::size_t axis_in_track_;
  const CheckedAxis& axis_;
  CheckReport& report_;
};

std::string_view name_of(RollEnd end) {
  return end == RollEnd::before ? "pre-roll" : "post-roll";
}

/// How far beyond its limit, in words: "would go to -3 mm at frame -12.00, outside 0..1500 mm".
std::string breach_in_words(const RollBreach<double>& breach, const RigAxis& axis) {
  const std::string_view unit = to_string(axis.unit);
  const auto [value, most] = told_apart(breach.value, breach.limit, Digits::significant, 6);
  const auto beyond = [&, &value = value, &most = most](std::string_view per, std::string_view limit) {
    return fmt::format("would reach {} {}{} at frame {:.2f}, and {} is {} {}{}", value, unit, per,
                       breach.frame, limit, most, unit, per);
  };
  switch (breach.quantity) {
    case RollQuantity::velocity:
      return beyond("/s", "max_velocity");
    case RollQuantity::acceleration:
      return beyond("/s^2", "max_acceleration");
    case RollQuantity::jerk:
      return beyond("/s^3", "max_jerk");
    case RollQuantity::position:
      break;
  }
  return fmt::format("would go to {} {} at frame {:.2f}, outside {}", value, unit, breach.frame,
                     range_in_words(axis));
}

/// An axis that starts on its limit and moves away from it has no room, however slow it is.
bool has_room(const Plan& plan, const RollObstacle& obstacle) {
  const RollBreach<double>& breach = obstacle.breach;
  if (breach.quantity != RollQuantity::position) return true;
  std::vector<AxisMotion<double>> joints(plan.played().axis_count());
  static_cast<void>(joints_of(plan.played().tracks(), obstacle.end, std::span(joints), plan.part()));
  const double position = joints[static_cast<std::size_t>(breach.axis)].position;
  const AxisLimits<double>& limits = plan.limits()[static_cast<std::size_t>(breach.axis)];
  const double room = breach.value > breach.limit ? limits.max() - position : position - limits.min();
  return room > step_rounding * (limits.max() - limits.min());
}

}  // namespace

bool breaks_jerk_limit(const CheckedStep& step, const RigAxis& limits) {
  return limits.max_jerk && step.acceleration > limits.max_acceleration_step.value_or(0);
}

void refuse_axis(const Plan& plan, std::size_t axis, CheckReport& report) {
  AxisRefusals(plan, axis, report).add_all();
}

void refuse_roll(const Plan& plan, const RollObstacle& obstacle, CheckReport& report) {
  const RollBreach<double>& breach = obstacle.breach;
  const std::size_t index = plan.axis_of(static_cast<std::size_t>(breach.axis));
  const RigAxis& axis = plan.rig()->axes[index];
  const MoveTrack& track = plan.move().tracks[*plan.axes()[index].track];
  const bool starts = obstacle.end == RollEnd::before;
  // The move breaks the limit itself, which has been said.
  if (breach.at_joint && !report.refusals.empty()) return;
  const bool room = has_room(plan, obstacle);
  const std::int32_t frame = starts ? plan.part().first : plan.part().last;
  if (frame != (starts ? 0 : plan.move().frames)) {
    report.refusals.push_back(
        {plan.place_of(index),
         fmt::format("frame {} is passed moving, and on a {} of {} axis {} {}", frame, name_of(obstacle.end),
                     counted(breach.frames, "frame"), in_quotes(axis.name), breach_in_words(breach, axis)),
         fmt::format("{} on a frame where the move is slower or rests{}", starts ? "begin" : "end",
                     room ? ", or give the move more frames" : ""),
         index, static_cast<double>(frame), room});
    return;
  }
  const std::string remedy =
      track.timing == Timing::speed
          ? fmt::format("{} the speed curve with 0, 0, at rest{}", starts ? "begin" : "end",
                        room ? ", or give the move more frames" : ", or move the key inward")
          : std::string(room ? "give the move more frames" : "move the key inward");
  report.refusals.push_back(
      {track.speed_places.empty() ? plan.place_of(index)
       : starts                   ? track.speed_places.front()
                                  : track.speed_places.back(),
       fmt::format("the move {} moving, and on a {} of {} axis {} {}", starts ? "starts" : "ends",
                   name_of(obstacle.end), counted(breach.frames, "frame"), in_quotes(axis.name),
                   breach_in_words(breach, axis)),
       remedy, index, static_cast<double>(frame), room});
}

void refuse_motor(const Plan& plan, const CheckedMotor& motor, CheckReport& report) {
  const RigAxis& axis = plan.rig()->axes[motor.axis];
  const auto refuse = [&](const CheckedPeak& peak, std::string_view limit, std::string_view per) {
    // What has no bound of the axis has been said.
    if (!peak.is_exceeded() || !std::isfinite(peak.value)) return;
    const auto [value, most] = told_apart(peak.value, *peak.limit, Digits::significant, 6);
    report.refusals.push_back(
        {plan.place_of(motor.axis),
         fmt::format(
             "the motor of axis {} would reach {} {}{} at frame {:.2f}, and {} of its calibration {} {} {}{}",
             in_quotes(axis.name), value, motor.unit, per, peak.frame, limit,
             axis.backlash ? "leaves beside the take-up of the backlash" : "is", most, motor.unit, per),
         "give the move more frames, or draw it slower there", motor.axis, peak.frame, true});
  };
  refuse(motor.velocity, "max_velocity", "/s");
  refuse(motor.acceleration, "max_acceleration", "/s^2");
  refuse(motor.jerk, "max_jerk", "/s^3");
}

void refuse_stop(const Plan& plan, const PlannedStops& planned, CheckReport& report) {
  const StopObstacle<double>& obstacle = *planned.obstacle();
  const std::size_t index = plan.axis_of(static_cast<std::size_t>(obstacle.axis));
  const CheckedAxis& axis = report.axes[index];
  const bool by_jerk = obstacle.quantity == StopQuantity::jerk;
  const std::string_view per = by_jerk ? "/s^3" : "/s^2";
  const std::string_view limit = by_jerk ? "stop_jerk" : "stop_acceleration";
  const std::string_view unit = planned.is_of_motor() ? to_string(plan.rig()->axes[index].calibration->unit)
                                                      : std::string_view(axis.unit);
  // A bound of a stretch may be above the one of the whole move, which is nearer to the truth.
  double peak = by_jerk ? axis.jerk.value : axis.acceleration.value;
  if (planned.is_of_motor()) peak = obstacle.value;
  const auto [value, most] =
      told_apart(std::min(obstacle.value, peak), obstacle.limit, Digits::significant, 6);
  // The motion itself is beyond its limit, which has been said.
  if (!report.refusals.empty()) return;
  report.refusals.push_back(
      {plan.place_of(index),
       fmt::format("{}axis {} could not be stopped at frame {:.2f}: the motion alone takes {} {}{} there, "
                   "and {} is {} {}{}",
                   planned.is_of_motor() ? "the motor of " : "", in_quotes(axis.name), obstacle.frame, value,
                   unit, per, limit, most, unit, per),
       fmt::format("give the move more frames, or raise {}", limit), index, obstacle.frame, true});
}

}  // namespace inbetween
